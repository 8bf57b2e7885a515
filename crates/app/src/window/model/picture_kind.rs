//! Kinds of files that a picture is saved as.

/// Ways to keep a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// As it is shown: 8 bits, sRGB.
    Png,
    /// The method's own values: linear, 32 bits, with depth and CoC where they fit.
    Exr,
}

impl PictureKind {
    /// What the file's name ends with.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }
}
