//! Why an image cannot be read or written, and how large one may be.

use glam::UVec2;
use std::path::{Path, PathBuf};

/// Why an image cannot be read or written: the file, the cause and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file cannot be opened or read.
    #[error("{}: cannot read it: {source}; check that the file exists and may be read", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The content does not decode.
    #[error("{}: does not decode ({detail}); use an intact PNG, JPEG, WebP, BMP, TIFF, HDR, PFM or EXR image", file.display())]
    Undecodable {
        /// The file.
        file: PathBuf,
        /// The decoder's reason.
        detail: String,
    },
    /// A deep EXR: several samples a pixel.
    #[error("{}: holds deep data (several samples a pixel), which is not supported; flatten it to an ordinary EXR first", file.display())]
    Deep {
        /// The file.
        file: PathBuf,
    },
    /// An EXR without the channels that were asked for.
    #[error("{}: has no {wanted} (its channels are {found}); {remedy}", file.display())]
    MissingChannel {
        /// The file.
        file: PathBuf,
        /// What was asked for.
        wanted: &'static str,
        /// The channels there are.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
    /// No layer has the name that was given.
    #[error("{}: has no layer '{wanted}' ({option}); its layers are {known}", file.display())]
    NoSuchLayer {
        /// The file.
        file: PathBuf,
        /// The name that was given.
        wanted: String,
        /// The option that takes it.
        option: &'static str,
        /// The layers there are.
        known: String,
    },
    /// Several layers that may be meant.
    #[error("{}: it is not clear which layer is the {what}: name one of {layers} with {option}", file.display())]
    UnclearLayer {
        /// The file.
        file: PathBuf,
        /// "picture", "depth" or "layer".
        what: &'static str,
        /// The option that takes its name.
        option: &'static str,
        /// The layers in question.
        layers: String,
    },
    /// A layer was named of a file that has none.
    #[error("{}: has no layers to choose from; leave out {option}, which is for EXR files", file.display())]
    NoLayers {
        /// The file.
        file: PathBuf,
        /// The option.
        option: &'static str,
    },
    /// No pixels, or more than can be handled.
    #[error("{}: its size is {width} x {height}; between 1 x 1 and {} million pixels are accepted", file.display(), MAX_PIXELS / 1_000_000)]
    Size {
        /// The file.
        file: PathBuf,
        /// Width, px.
        width: u64,
        /// Height, px.
        height: u64,
    },
    /// More pixels than its bytes can stand for.
    #[error("{}: its {width} x {height} pixels are more than its {bytes} bytes can stand for: it is damaged, or made to fill the memory; save it again smaller", file.display())]
    Inflated {
        /// The file.
        file: PathBuf,
        /// Width, px.
        width: u64,
        /// Height, px.
        height: u64,
        /// Length of the file.
        bytes: u64,
    },
    /// The target cannot be written.
    #[error("{}: cannot write it: {source}; check that its folder exists, may be written and has space", file.display())]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Layers of one file that differ in size.
    #[error("{}: cannot write it: the {layer} has {layer_size} pixels and the colour {color_size}; give layers of one size", file.display())]
    LayerSize {
        /// The file.
        file: PathBuf,
        /// "depth" or "CoC".
        layer: &'static str,
        /// Its size.
        layer_size: UVec2,
        /// The colour's size.
        color_size: UVec2,
    },
}

/// Pixels accepted in a file: 2^28, four times the largest camera sensors. Beyond that a
/// damaged header is likelier than an image.
pub const MAX_PIXELS: u64 = 1 << 28;

/// An error unless both sides are at least 1 px and the image is within [`MAX_PIXELS`].
pub(super) fn check_size(path: &Path, width: u64, height: u64) -> Result<(), ImageError> {
    let accepted = width > 0 && height > 0 && width.checked_mul(height).is_some_and(|pixels| pixels <= MAX_PIXELS);
    if accepted { Ok(()) } else { Err(ImageError::Size { file: path.to_owned(), width, height }) }
}

/// Pixels that any file may have, 34 million: decoded, as linear colour and with depth they take a
/// gigabyte at most.
const FREE_PIXELS: u64 = 1 << 25;

/// Pixels a byte of the file, beyond that. Measured depth and pictures take more than a byte for four
/// pixels however they are compressed; zeros take one for a thousand.
const PIXELS_PER_BYTE: u64 = 16;

/// [`check_size`] of a file that is to be read: a small one cannot ask for any amount of memory.
pub(super) fn check_size_to_read(path: &Path, width: u64, height: u64) -> Result<(), ImageError> {
    check_size(path, width, height)?;
    let unreadable = |source| ImageError::Unreadable { file: path.to_owned(), source };
    let bytes = std::fs::metadata(path).map_err(unreadable)?.len();
    let most = bytes.saturating_mul(PIXELS_PER_BYTE).max(FREE_PIXELS);
    let accepted = width.checked_mul(height).is_some_and(|pixels| pixels <= most);
    if accepted { Ok(()) } else { Err(ImageError::Inflated { file: path.to_owned(), width, height, bytes }) }
}
