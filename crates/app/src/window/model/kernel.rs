//! Which point spread function is looked at.

use defocus_study::psf::Side;

/// CoC and side of the focus of a point spread function.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct KernelChoice {
    /// CoC diameter, px, in [`KernelChoice::COC_PX`].
    pub coc_px: f64,
    /// Whether the point lies in front of the focus, not behind it.
    pub in_front: bool,
}

impl Default for KernelChoice {
    fn default() -> Self {
        Self { coc_px: 16.0, in_front: false }
    }
}

impl KernelChoice {
    /// CoC diameters that are measured here, px: nine pictures of four times the area of the widest
    /// take a second in software.
    pub const COC_PX: std::ops::RangeInclusive<f64> = 0.5..=64.0;

    /// The side of the focus.
    pub fn side(self) -> Side {
        if self.in_front { Side::Front } else { Side::Behind }
    }

    /// The same with what a file could have wrong put right.
    pub fn repaired(self) -> Self {
        if Self::COC_PX.contains(&self.coc_px) { self } else { Self { in_front: self.in_front, ..Self::default() } }
    }
}
