//! Apertures as text: the command line's `--aperture`.

use super::{Aperture, ApertureError, ApertureImage, DEFAULT_SIGMA_PER_COC};
use std::fmt;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

impl FromStr for Aperture {
    type Err = ApertureError;

    /// Parses `disc`, `polygon:N[:ROT[:ROUNDNESS]]`, `gaussian[:SIGMA_PER_COC]` or
    /// `image:FILE`; the last reads the file.
    fn from_str(given: &str) -> Result<Self, ApertureError> {
        let (kind, rest) = match given.split_once(':') {
            Some((kind, rest)) => (kind, Some(rest)),
            None => (given, None),
        };
        let wrong = |cause: &str| ApertureError::Syntax { given: given.into(), cause: cause.into() };
        let aperture = match (kind, rest) {
            ("disc", None) => Self::Disc,
            ("disc", Some(_)) => return Err(wrong("a disc takes no parameters")),
            ("polygon", None) => return Err(wrong("the number of blades is missing")),
            ("polygon", Some(rest)) => polygon(given, rest)?,
            ("gaussian", None) => Self::Gaussian { sigma_per_coc: DEFAULT_SIGMA_PER_COC },
            ("gaussian", Some(rest)) => Self::Gaussian { sigma_per_coc: number(given, "SIGMA_PER_COC", rest)? },
            ("image", None | Some("")) => return Err(wrong("the file's name is missing")),
            ("image", Some(file)) => Self::Image(Arc::new(ApertureImage::load(Path::new(file))?)),
            _ => return Err(wrong(&format!("there is no kind '{}'", kind.escape_debug()))),
        };
        aperture.check()?;
        Ok(aperture)
    }
}

fn polygon(given: &str, rest: &str) -> Result<Aperture, ApertureError> {
    let parts: Vec<&str> = rest.split(':').collect();
    let optional = |i: usize, name| parts.get(i).map_or(Ok(0.0), |text| number(given, name, text));
    if parts.len() > 3 {
        return Err(ApertureError::Syntax { given: given.into(), cause: "a polygon takes three parameters".into() });
    }
    let blades = number(given, "N", parts[0])?;
    Ok(Aperture::Polygon { blades, rotation_deg: optional(1, "ROT")?, roundness: optional(2, "ROUNDNESS")? })
}

fn number<T: FromStr>(given: &str, name: &str, text: &str) -> Result<T, ApertureError> {
    let cause = || format!("{name} is '{}', which is not such a number", text.escape_debug());
    text.parse().map_err(|_| ApertureError::Syntax { given: given.into(), cause: cause() })
}

impl fmt::Display for Aperture {
    /// Writes what [`Aperture::from_str`] reads, the shortest form of it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Disc => write!(f, "disc"),
            Self::Polygon { blades, rotation_deg, roundness } => {
                write!(f, "polygon:{blades}")?;
                if *rotation_deg != 0.0 || *roundness != 0.0 {
                    write!(f, ":{rotation_deg}")?;
                }
                if *roundness != 0.0 {
                    write!(f, ":{roundness}")?;
                }
                Ok(())
            }
            Self::Gaussian { sigma_per_coc } => write!(f, "gaussian:{sigma_per_coc}"),
            Self::Image(image) => write!(f, "image:{}", image.name()),
        }
    }
}
