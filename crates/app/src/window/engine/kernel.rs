//! A method's point spread function, as it was measured beside the interface.

use super::lane::Told;
use crate::window::model::{KernelChoice, MethodChoice};
use defocus::aperture::Aperture;
use defocus::image::ColorImage;
use defocus_study::psf::{Psf, lens_kernel};

/// All that a point spread function depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelOf {
    /// Which scene and shaders: another number for others.
    pub world: u64,
    /// The method with its parameters.
    pub method: MethodChoice,
    /// The aperture.
    pub aperture: Aperture,
    /// CoC diameter and side of the focus.
    pub choice: KernelChoice,
}

/// A point spread function beside the lens's own.
#[derive(Clone, Debug)]
pub struct MeasuredKernel {
    /// The method's.
    pub psf: Psf,
    /// The lens's, of the same size and light.
    pub lens: ColorImage,
}

/// What was asked for last.
pub struct Kernel {
    pub(super) ticket: u64,
    /// What it is of.
    pub of: KernelOf,
    /// `None` while it is measured.
    pub psf: Option<Result<MeasuredKernel, String>>,
}

impl Kernel {
    /// Takes in what the lane tells.
    pub(super) fn take(&mut self, told: Told) {
        match told {
            Told::Kernel(psf) => {
                let size = psf.image.size;
                let lens = lens_kernel(&self.of.aperture, (psf.coc_px, psf.side), size);
                self.psf = Some(Ok(MeasuredKernel { psf: *psf, lens }));
            }
            Told::Failed(error) => self.psf = Some(Err(error)),
            Told::Progress(..) | Told::Picture(_) | Told::Times(_) => {}
        }
    }
}
