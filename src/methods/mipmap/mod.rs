//! `mipmap`: anisotropically filtered mipmap interpolation.
//!
//! Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using Anisotropically Filtered
//! Mipmap Interpolation" (TVCG 2009). Blur is read from a mipmap of the pinhole image at
//! a level that follows from the CoC. There are two ways, by [`Mipmap::filter`]:
//!
//! **As printed** ([`MipmapFilter::AsPrinted`]):
//!
//! 1. a mipmap of depth (as CoC), DoB (degree of blur, sigma = C/2) and DoN (the DoB of
//!    nearer foreground neighbours), section 3.1 and equation (10);
//! 2. a mipmap of colour in which a blurred background refuses sharper texels, equation
//!    (9);
//! 3. a level from a blur, equation (6) or the pyramid's measured second moment;
//! 4. the DoB smoothed over the edges of the foreground, equation (11);
//! 5. two levels blended through a circular filter, equation (8), with the weights of
//!    equation (9).
//!
//! **By discs** ([`MipmapFilter::Discs`], the default) goes further where the paper's steps
//! show their limits:
//!
//! - Levels are filtered beforehand, all at once, by discs of two diameters that differ by
//!   sqrt(2); a pixel reads the two discs around its own. Discs up to 4 px are drawn on the
//!   image itself.
//! - In place of equation (9), which weighs each texel by its centre, each pixel behind the
//!   focus distance has a part in a level as far as its own blur reaches that level. Colours
//!   are stored times that part, so what is sharp has none whichever way a level is read:
//!   equation (9) bars sharp texels while levels are made, but a filter over a level, or a
//!   bilinear read of it, mixes both sides of an edge again. Nor does the light of small
//!   things vanish that are less blurred than what is behind them.
//! - In place of equations (10) and (11), each pixel in front of the focus distance is spread
//!   by its own blur, through the levels, over what is behind it. The paper blurs the DoB
//!   over the foreground's edges; what a pixel beyond them then reads is mostly the colour of
//!   what lies behind: 4 px outside of a straight edge with C = 12 px it leaves 0.02 of the
//!   foreground, where a lens has 0.28. And the DoB it reads, from levels that mix all there
//!   is, blurs sharp things that lie between a speck in front and something far behind.
//!
//! **Which lens this is.** The paper names a Gaussian lens of sigma = C/2, but its level
//! formula blurs close to a *disc* of diameter C, whose standard deviation is C/4. Here
//! the level is set so that the second moment of what the pyramid really does equals the
//! lens's own ("measured"); the paper's constant is the other setting.

mod grid;
mod params;
mod passes;

pub use params::{Mipmap, MipmapCalibration, MipmapFilter, MipmapInterpolation};

use super::tile_lists::{self, SKIPPED};
use super::{About, Apertures, Meaning, Method, MethodError, Param, Quantity, Scale};
use crate::gpu::{Frame, Texture};
use crate::lens::Lens;
use crate::view::View;
use passes::{BLUR_PYRAMID, COLOR_PYRAMID, EXPLAINED, PYRAMID, TILE_CLASSES};

impl Method for Mipmap {
    fn about(&self) -> About {
        About {
            id: "mipmap",
            title: "Anisotropic mipmaps",
            paper: "Lee, Kim and Choi, Real-Time Depth-of-Field Rendering Using Anisotropically Filtered Mipmap Interpolation, TVCG 2009",
            summary: "Reads each pixel's blur from a mipmap that keeps sharp surfaces out of blurred backgrounds, and spreads blurred foreground over what is behind it.",
            limits: "One view only: what a blurred foreground hides is filled in from what is seen beside it. Behind the focus distance there is no order in depth beyond what is sharper: a blur takes in what is more blurred, too. Round apertures only. As printed also: blurred foreground hardly reaches over its outline (equation 11 smooths the degree of blur, and the colour read there is mostly what lies behind: 0.02 of it 4 px outside of an edge with C = 12 px, where a lens has 0.28); what is small and behind the focus distance vanishes where what is behind it is blurred more by delta (equation 9: of 3x3 px with C = 21 px before a wall with 31 px no light is left); between two texels a sharp one can count by delta over the difference of their DoBs. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Round,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        self.list()
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        Ok(match self.filter == MipmapFilter::Discs as usize {
            true => passes::by_discs(self, frame, view, lens),
            false => passes::as_printed(self, frame, view, lens),
        })
    }

    fn explains(&self) -> &'static [&'static str] {
        match self.filter == MipmapFilter::Discs as usize {
            true => &[EXPLAINED, SKIPPED],
            false => &[EXPLAINED, BLUR_PYRAMID],
        }
    }

    fn meaning(&self, name: &str) -> Meaning {
        let px = |name, scale| Quantity::new(name, " px", scale);
        let used = match self.filter == MipmapFilter::Discs as usize {
            true => Quantity::new("covered by foreground", "", Scale::Found),
            false => px("smoothed DoB", Scale::Found),
        };
        match name {
            BLUR_PYRAMID => {
                Meaning::numbers([px("CoC", Scale::Signed), px("DoB", Scale::Found), px("DoN", Scale::Found)])
            }
            SKIPPED => tile_lists::meaning(&TILE_CLASSES),
            EXPLAINED => Meaning::numbers([
                px("CoC", Scale::Signed),
                px("DoB", Scale::Found),
                used,
                Quantity::new("mipmap level", "", Scale::Found),
            ]),
            _ => Meaning::Picture,
        }
    }

    fn texel_px(&self, name: &str) -> Option<u32> {
        // The pyramids begin at level 1.
        [COLOR_PYRAMID, BLUR_PYRAMID, PYRAMID].contains(&name).then_some(2)
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}
