//! `adaptive`: lens rays through peeled layers, only where and as finely as needed.
//!
//! The project's own method. In the space (x, y, s) with s = c/2, the signed CoC radius in
//! pixels, lens rays are straight lines, so the layers that the pinhole sees behind one
//! another are traced as they are:
//!
//! 1. up to four layers are peeled ([`View::peeled`]), finer than the image, the first with
//!    more samples and their mean, and kept while the view stays;
//! 2. tiles of 8x8 pixels find which of 64 bins of s their rays can meet ([`tiles`]) and
//!    with that whether they are sharp, of one blur, or need rays through depth;
//! 3. each pixel traces its own few lens points through the occupied bins, and more of them in
//!    tiles where two halves of the rays differ by more than a display hides;
//! 4. what is far brighter than white reaches the pixels that its blur covers one by one;
//! 5. hits are gathered in five buckets of s, filtered over the neighbours, whose lens
//!    points differ, and composited front to back.
//!
//! What limits it is the first step: one sample a pixel does not say where a silhouette
//! lies or how large a small light is, and no ray can find out. Layers of 2x2 texels a pixel
//! (`fineness`), the first of them sampled four times (`draws`), are therefore the default:
//! they are drawn once while the view stays. Rays that pass near the focus ask the samples,
//! others their mean. `docs/adaptive.md` has pictures and figures.
//!
//! Rays that leave the frame meet its border stretched outwards.

mod explain;
mod highlights;
mod nearest_grid;
mod passes;
mod points;
mod progressive;
pub mod tiles;
mod views;

use super::sheet_rays::SheetRays;
use super::{About, AccumulationRun, Apertures, Converging, Meaning, Method, MethodError, Param, pinhole};
use crate::aperture::Aperture;
use crate::gpu::{Frame, Texture};
use crate::lens::{GREATEST_COC_PX, Lens};
use crate::uniform;
use crate::view::{DISOCCLUSION_PX, LensUniform, MAX_DRAWS, PeelOrder, Peeled, View};
use nearest_grid::{NearestGrid, bend_px};
use passes::Rays;
pub use points::lens_points;
pub use progressive::{AdaptiveRun, TURNED_FRAMES};
use tiles::{TileGrid, Tiles};
use views::Views;

/// Names of the numbers of lens points a pixel.
const POINTS: &[&str] = &["8", "16", "32", "64"];

/// Names of the numbers of off-centre views.
const VIEWS: &[&str] = &["0", "4"];

/// Layers that fit in one texel of radii; `adaptive_highlights.wgsl` has a word for each.
const MAX_LAYERS: u32 = 4;

/// Greatest factor by which noisy tiles have more lens points.
const MAX_REFINE: u32 = 4;

/// Root mean square error of a tile, of display values in [0, 1], from which it is noisy: two
/// steps of an 8-bit display. It is estimated from the difference of two halves of the rays.
const NOISE_LIMIT: f32 = 2.0 / 255.0;

/// The same of an image: one step. Its pixels have one sample each, so that a ray takes half as many steps
/// near focus, where no filter hides its noise.
const IMAGE_NOISE_LIMIT: f32 = NOISE_LIMIT / 2.0;

/// Frames submitted at once.
const FRAMES_A_FLUSH: u32 = 16;

/// Layered lens rays.
#[derive(Clone, Debug)]
pub struct Adaptive {
    /// Index of the number of lens points a pixel: 8, 16, 32 or 64.
    pub points: usize,
    /// Greatest number of layers, 1 to 4.
    pub layers: u32,
    /// Texels of the layers a pixel on each side, 1 to 3.
    pub fineness: u32,
    /// Samples of the first layer a texel on each axis, 1 to 4.
    pub draws: u32,
    /// Times as many lens points in tiles that are noisy with those: 1 to 4.
    pub refine: u32,
    /// Index of the number of off-centre views: 0 or 4.
    pub views: usize,
    /// Whether surfaces behind all that is seen are left out.
    pub cull: bool,
    /// Whether each pixel has its own lens points.
    pub jitter: bool,
    /// Whether hits are filtered over neighbouring pixels.
    pub filter: bool,
    /// Frames that are brought together, 1 to 4096: see [`AdaptiveRun`].
    pub frames: u32,
}

impl Default for Adaptive {
    fn default() -> Self {
        Self {
            points: 1,
            layers: MAX_LAYERS,
            fineness: 2,
            draws: 2,
            refine: MAX_REFINE,
            views: 0,
            cull: true,
            jitter: true,
            filter: true,
            frames: 1,
        }
    }
}

uniform! {
    /// `Adaptive` in `shaders/lib/layers.wgsl`.
    pub struct AdaptiveUniform {
        tiles: [u32; 2],
        inner_tiles: [u32; 2],
        size: [u32; 2],
        first_tile: u32,
        overscan: u32,
        layers: u32,
        points: u32,
        reach: u32,
        cull: u32,
        first_t: f32,
        bin_t: f32,
        nearest_s: f32,
        farthest_s: f32,
        lens_radius: f32,
        lens_variance: f32,
        sharp_s: f32,
        narrow_s: f32,
        diagnose: u32,
        fineness: u32,
        views: u32,
        view_distance: f32,
        lens: LensUniform,
        samples_a_side: u32,
        most_points: u32,
        noise_limit: f32,
        is_image: u32,
        grid_layer: u32,
        is_disc: u32,
        grid_spacing: u32,
        grid_margin: u32,
        grid_reach_px: f32,
        _pad: u32,
    }
}

impl Method for Adaptive {
    fn about(&self) -> About {
        About {
            id: "adaptive",
            title: "Adaptive lens rays",
            paper: "",
            summary: "Traces a few lens rays a pixel through peeled layers, only where the blur needs them, and filters what they hit by depth.",
            limits: "Four solid surfaces behind one another, and four sheets of glass, smoke or soft leaves, which have one sample a pixel; with an image as input what the foreground hides is guessed from what lies beside it. Shading does not depend on the lens point.",
            apertures: Apertures::Any,
            astigmatism: true,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: true,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::choice(
                "points",
                "Lens points",
                &mut self.points,
                POINTS,
                "Lens rays a pixel. Neighbours use others, and the filter over them makes up for most of the difference.",
            )
            .trading(POINTS),
            Param::int(
                "layers",
                "Layers",
                "",
                &mut self.layers,
                (1, MAX_LAYERS),
                "Surfaces behind one another that rays can meet; 1 knows only what the pinhole sees.",
            ),
            Param::int(
                "fineness",
                "Layer resolution",
                "texels per px",
                &mut self.fineness,
                (1, 3),
                "Draws the layers with this many texels a pixel on each side: silhouettes and small lights gain most. Costs memory, and time only when the view changes.",
            ),
            Param::int(
                "draws",
                "Draws",
                "on each axis",
                &mut self.draws,
                (1, MAX_DRAWS),
                "Samples the nearest layer this often a texel on each axis: thin things nearly in focus lie where they are, blurred surfaces show the mean, and glints and small lights as much light as they have. Costs memory, and time only when the view changes.",
            ),
            Param::int(
                "refine",
                "Refinement",
                "times the points",
                &mut self.refine,
                (1, MAX_REFINE),
                "Casts up to this many times the lens points in tiles whose rays differ by more than a display hides; 1 casts as many everywhere.",
            ),
            Param::choice(
                "views",
                "Off-centre views",
                &mut self.views,
                VIEWS,
                "Draws the scene from four more points of the lens, at each change of lens or view: rays near them see what is really there.",
            ),
            Param::switch(
                "cull",
                "Umbra cull",
                &mut self.cull,
                "Leaves out surfaces behind the farthest that the pinhole sees within reach of a tile.",
            ),
            Param::switch(
                "jitter",
                "Points by pixel",
                &mut self.jitter,
                "Turns the lens points from pixel to pixel: fine noise, which the filter removes, instead of ghosts.",
            ),
            Param::switch(
                "filter",
                "Filter",
                &mut self.filter,
                "Filters what rays hit over 3x3 or 5x5 pixels, apart for near and far blur, and takes that much off the rays' own blur.",
            ),
            Param::int(
                "frames",
                "Frames",
                "",
                &mut self.frames,
                (1, 4096),
                "Brings that many frames together: eight with other lens points, then true views over the lens, with which the picture converges to accumulation.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let greatest_px = view.coc_bounds_px(frame, lens).map(f64::abs).into_iter().fold(0.0, f64::max);
        let greatest_px = greatest_px + lens.greatest_astigmatism_px();
        if !view.has_sheets() && 0.5 * greatest_px * (lens.aperture.sigma_per_coc() / 0.25) < tiles::COPY_RADIUS_PX {
            frame.skip("all tiles in focus");
            return Ok(pinhole::inner(frame, view));
        }
        if self.frames <= 1 {
            return self.turned(frame, view, lens, 0);
        }
        let mut run = AdaptiveRun::new(self.clone());
        while run.count() < self.frames {
            run.advance(frame, view, lens, FRAMES_A_FLUSH.min(self.frames - run.count()))?;
            frame.flush();
        }
        Ok(run.mean(frame))
    }

    fn converging(&self) -> Option<(Box<dyn Converging>, u32)> {
        (self.frames > 1).then(|| (Box::new(AdaptiveRun::new(self.clone())) as Box<dyn Converging>, self.frames))
    }

    fn explains(&self) -> &'static [&'static str] {
        &explain::EXPLAINS
    }

    fn meaning(&self, name: &str) -> Meaning {
        explain::meaning(name)
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

impl Adaptive {
    /// One frame, with the lens points turned as the `turn`-th of many.
    fn turned(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, turn: u32) -> Result<Texture, MethodError> {
        let sheets = SheetRays::of(frame, view, lens);
        let view = view.solid();
        let (peeled, adaptive, tiles) = self.prepare(frame, view, lens, &sheets)?;
        let gpu = frame.gpu();
        let AdaptiveUniform { points, most_points, .. } = adaptive;
        let points = gpu.memo().get(&(lens.aperture.clone(), points, most_points, self.jitter, turn), || {
            gpu.buffer_of("lens points", &lens_points(&lens.aperture, points, most_points, self.jitter, turn))
        });
        let views = match adaptive.views {
            0 => Views::none(frame, lens),
            _ => Views::draw(frame, view, lens, &adaptive)?,
        };
        let rays = Rays {
            adaptive: &adaptive,
            tiles: &tiles,
            peeled: &peeled,
            views: &views,
            sheets: &sheets,
            points: &points,
        };
        Ok(rays.record(frame))
    }

    /// The layers that the lens can show parts of: one where no neighbouring pixels lie far
    /// enough apart in CoC for anything to show between them.
    fn peel(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Peeled, MethodError> {
        let separation = view.layer_separation(lens);
        let lens = view.lens_uniform(lens);
        let mut order =
            PeelOrder { count: self.layers, fineness: self.fineness, draws: self.draws, separation, lights: true };
        if 0.5 * lens.slope_px * view.greatest_z_step(frame) < DISOCCLUSION_PX {
            frame.skip("nothing hidden shows: no layers");
            order = PeelOrder { count: 1, fineness: 1, ..order };
        }
        Ok(view.peeled(frame, &order)?)
    }

    /// Records the passes that find the tiles, without the rays: what a test or an overlay
    /// looks at.
    pub fn tiles(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<(TileGrid, Tiles), MethodError> {
        let sheets = SheetRays::of(frame, view, lens);
        let view = view.solid();
        let (peeled, _, tiles) = self.prepare(frame, view, lens, &sheets)?;
        Ok((grid(frame, view, lens, &peeled), tiles))
    }

    fn prepare(
        &self,
        frame: &mut Frame<'_>,
        view: &mut View,
        lens: &Lens,
        sheets: &SheetRays,
    ) -> Result<(Peeled, AdaptiveUniform, Tiles), MethodError> {
        let peeled = self.peel(frame, view, lens)?;
        let grid = grid(frame, view, lens, &peeled);
        let adaptive = self.uniform(frame, view, lens, &grid, &peeled);
        if peeled.lights.is_none() {
            frame.skip("no highlights");
        }
        let tiles = tiles::build(frame, view, lens, &peeled, &adaptive, sheets);
        Ok((peeled, adaptive, tiles))
    }

    fn uniform(
        &self,
        frame: &Frame<'_>,
        view: &View,
        lens: &Lens,
        grid: &TileGrid,
        peeled: &Peeled,
    ) -> AdaptiveUniform {
        let bins = grid.bins();
        let [sharp_s, narrow_s] = if self.filter { FILTERED_FROM_PX[self.points] } else { [f32::MAX; 2] };
        let rays = NearestGrid::new(lens, grid.radii_px, bend_px(&lens.aperture, sharp_s, narrow_s));
        AdaptiveUniform {
            tiles: grid.tiles.to_array(),
            inner_tiles: grid.inner_tiles.to_array(),
            size: view.size().to_array(),
            first_tile: grid.first_tile,
            overscan: view.overscan_px(),
            layers: peeled.layers,
            points: 8 << self.points,
            reach: grid.reach,
            cull: self.cull.into(),
            first_t: bins.x as f32,
            bin_t: bins.y as f32,
            nearest_s: grid.radii_px[0] as f32,
            farthest_s: grid.radii_px[1] as f32,
            lens_radius: lens.aperture.radius() as f32,
            lens_variance: (lens.aperture.sigma_per_coc() / 0.25).powi(2) as f32,
            sharp_s,
            narrow_s,
            diagnose: frame.keeps_intermediates().into(),
            fineness: peeled.fineness,
            views: if view.is_scene() { [0, 4][self.views.min(1)] } else { 0 },
            // On each of two axes.
            view_distance: (views::DISTANCE * lens.aperture.radius() * std::f64::consts::FRAC_1_SQRT_2) as f32,
            lens: view.lens_uniform(lens),
            samples_a_side: peeled.samples_a_side,
            most_points: self.refine * (8 << self.points),
            noise_limit: if view.is_scene() { NOISE_LIMIT } else { IMAGE_NOISE_LIMIT },
            is_image: (!view.is_scene()).into(),
            grid_layer: rays.layer,
            is_disc: (lens.aperture == Aperture::Disc && lens.greatest_astigmatism_px() == 0.0).into(),
            grid_spacing: rays.spacing_px,
            grid_margin: rays.margin_px,
            grid_reach_px: rays.reach_px as f32,
            ..Default::default()
        }
    }
}

/// |s|, px, from which hits are filtered over 3x3 pixels and from which over 5x5, by the
/// number of lens points: wide filters blur thin things, and the more points there are the
/// less they are needed.
const FILTERED_FROM_PX: [[f32; 2]; 4] = [[2.0, 5.0], [3.0, 12.0], [4.0, 12.0], [6.0, 24.0]];

fn grid(frame: &mut Frame<'_>, view: &mut View, lens: &Lens, peeled: &Peeled) -> TileGrid {
    let [near_px, mut far_px] = view.coc_bounds_px(frame, lens);
    if peeled.layers > 1 && view.is_scene() {
        // Hidden surfaces may lie at any distance behind the visible ones.
        far_px = lens.coc().k_px.min(GREATEST_COC_PX);
    }
    TileGrid::new(view, lens, near_px, far_px)
}
