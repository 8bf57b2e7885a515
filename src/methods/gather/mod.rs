//! `gather`: what engines ship today, rings of taps on a reduced image, in layers.
//!
//! Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare" (SIGGRAPH
//! 2014, Advances in Real-Time Rendering), and what followed it: Abadie, "A Life of a Bokeh"
//! (SIGGRAPH 2018, the same course), AMD FidelityFX DOF, Filament, EEVEE. The steps are
//! theirs, each of which can be switched off:
//!
//! 1. **Prefilter.** The image is reduced to half of each side; of the pixels of a texel those
//!    count whose CoC is like the widest, so that what is sharp does not flow into what is
//!    blurred. Three coarser levels follow in the same way. What is far brighter than its
//!    surroundings is taken out and listed.
//! 2. **Tiles** of 8x8 texels know the CoCs that can reach them: each tile's bounds, spread as
//!    far as the blur reaches. They are in focus (nothing is done), of one blur (taps are
//!    added up), or mixed.
//! 3. **Rings.** Each texel looks at 1 + 4n(n+1) taps of equal area in its own CoC; where
//!    foreground is near, at as many in the foreground's CoC. A tap's weight is the share of
//!    *its* light that falls on the texel, as if it were scattered: no tap brings light that
//!    its own CoC does not carry there. Taps in front of the texel's surface make a layer with
//!    an alpha, taps at it and behind it another; where the surface is missing from its own
//!    disc, what is behind fills the gap, the taps that lie closest if none reaches.
//! 4. **Post filter** over 3x3 texels: a median, or a mean.
//! 5. **Sprites.** What was taken out of the image is drawn as the blur spots that it makes,
//!    as many as an indirect draw finds in the list.
//! 6. **Recombination.** Each pixel of the full image looks for itself where it is in focus, at
//!    3x3 pixels where it is slightly blurred, and at those of four texels that lie on the same
//!    surface where it is blurred more; what is in front comes over it.
//!
//! The sources weigh taps by their distance from the nearest surface of a tile, in two layers
//! that are the same for all pixels of it. Here, as in [`splat`](super::Splat), "in front",
//! "at" and "behind" are told from the texel's own surface, with ramps in place of steps:
//! nothing pops as the focus moves.

mod grid;
mod params;
mod passes;

use super::{About, Apertures, Meaning, Method, MethodError, Param, Quantity, Scale, tile_lists};
use crate::gpu::{Frame, Texture};
use crate::lens::Lens;
use crate::view::View;
pub use params::Gather;

impl Method for Gather {
    fn about(&self) -> About {
        About {
            id: "gather",
            title: "Ring gather in layers",
            paper: "Jimenez, Next Generation Post Processing in Call of Duty: Advanced Warfare, SIGGRAPH 2014; Abadie, A Life of a Bokeh, SIGGRAPH 2018",
            summary: "Rings of taps on a half-size image, each weighed by its own blur, in a layer in front and one behind; bright pixels are drawn as sprites.",
            limits: "What the foreground hides is guessed from what lies beside it. At half resolution slight blur is soft and small things waver; between rings large blurs show steps. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Any,
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
        Ok(passes::record(self, frame, view, lens))
    }

    fn explains(&self) -> &'static [&'static str] {
        &[tile_lists::SKIPPED, passes::EXPLAINED]
    }

    fn meaning(&self, name: &str) -> Meaning {
        let share = |name| Quantity::new(name, " %", Scale::Found).worth(100.0);
        match name {
            tile_lists::SKIPPED => tile_lists::meaning(&passes::TILE_CLASSES),
            passes::EXPLAINED => Meaning::numbers([
                share("share in front"),
                share("own share of the rest"),
                share("share of sprites"),
                Quantity::new("CoC", " px", Scale::Signed),
            ]),
            _ => Meaning::Picture,
        }
    }

    fn texel_px(&self, name: &str) -> Option<u32> {
        match name {
            tile_lists::SKIPPED => Some(self.step() * tile_lists::TILE_PX),
            name if passes::ON_THE_GRID.contains(&name) => Some(self.step()),
            _ => None,
        }
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}
