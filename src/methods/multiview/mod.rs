//! `multiview`: lens rays traced through slabs of the scene.
//!
//! Lee, Eisemann and Seidel, "Depth-of-Field Rendering with Multiview Synthesis"
//! (SIGGRAPH Asia 2009):
//!
//! 1. slabs of equal thickness in c, each with its own nearest surfaces, so that what the
//!    pinhole image hides is there (sections 4.1 and 4.2);
//! 2. for each pixel and lens point a ray that meets the slabs from near to far: height
//!    fields of c in (x, y, c), where lens rays are straight (section 4.3);
//! 3. slabs with nothing around a pixel are skipped, by an N-buffer (section 4.3);
//! 4. a ray is a cone that reads a mipmap with coverage (section 4.4);
//! 5. lens points differ between pixels (section 4.5).
//!
//! Slabs have exact bounds; the paper's geometry shader sorts whole triangles into them, which
//! approximates that. All are drawn in two draws of the scene ([`crate::view::SlabShot`]), or,
//! if it is asked for, one by one with a depth buffer each: the same slabs.

mod nbuffer;
mod points;
mod slabs;

pub use slabs::{SlabRange, slab_ranges};

use super::sheet_rays::SheetRays;
use super::tile_lists::{self, DEFOCUSED, FocusMap, Reach};
use super::{About, Apertures, IN_FOCUS_COC_PX, Meaning, Method, MethodError, Param, Quantity, Scale};
use crate::gpu::{Frame, SamplerKind, Shader, Texture};
use crate::lens::Lens;
use crate::view::{EnvironmentUniform, Tone, View};
use crate::{shader, uniform};
use glam::DVec2;
use nbuffer::NBuffer;
use points::{LensPoints, PointSets};
use slabs::{DEPTH, EXPLAINED, MAX_SLABS, Slabs, SlabsKey};

const SHADER: Shader = shader!("methods/multiview");

/// Multiview synthesis with the paper's choices as parameters.
#[derive(Clone, Debug)]
pub struct Multiview {
    /// Lens points per pixel.
    pub samples: u32,
    /// Most slabs.
    pub slabs: u32,
    /// delta: wanted thickness of a slab in c, px (section 4.1: 3).
    pub delta_px: f32,
    /// How far slabs reach over each of their bounds, in thicknesses (section 4.2: 0.1).
    pub overlap: f32,
    /// Index among the choices of the parameter of this name.
    pub intersection: usize,
    /// Whether N-buffers skip slabs (section 4.3).
    pub culling: bool,
    /// Whether rays are cones (section 4.4).
    pub cones: bool,
    /// Whether slabs of an image hold what nearer surfaces hide, as it is guessed.
    pub hidden: bool,
    /// Diameter of a ray's cone over the CoC *radius*, with 32 lens points of a disc (section 4.4:
    /// 0.137); with others in the ratio of their distances.
    pub lambda: f32,
    /// Index among the choices of the parameter of this name.
    pub coverage: usize,
    /// Index among the choices of the parameter of this name.
    pub jitter: usize,
    /// Whether each ray adds by how much its lens point sees another radiance than the lens's
    /// centre.
    pub view_dependent: bool,
    /// Index among the choices of the parameter of this name.
    pub drawing: usize,
}

/// How slabs are drawn.
pub const DRAWINGS: &[&str] = &["together", "one by one"];

/// How a ray is intersected with a slab.
pub const INTERSECTIONS: &[&str] = &["steps", "false_position"];

/// How what slabs cover of a cone comes together.
pub const COVERAGES: &[&str] = &["added", "over"];

/// Mean distance from each of 32 lens points of a disc to its nearest neighbour, in radii: a cone
/// that wide fills the gaps between rays.
const LAMBDA_OF_32: f32 = 0.219;

/// How lens points differ between pixels.
pub const JITTERS: &[&str] = &["sets", "offsets", "off"];

/// Sets of lens points to choose from: consecutive blocks of one progressive sequence,
/// each of them a good set and together a good set again.
const JITTER_SETS: u32 = 16;

/// Mipmap levels that cones read. As many for any lens and any number of lens points: slabs
/// with fewer would be drawn anew when more are asked for, which costs far more than levels.
const CONE_LEVELS: u32 = 6;

impl Default for Multiview {
    fn default() -> Self {
        Self {
            samples: 64,
            slabs: MAX_SLABS,
            delta_px: 3.0,
            overlap: 0.1,
            intersection: 0,
            culling: true,
            cones: true,
            hidden: true,
            lambda: LAMBDA_OF_32,
            coverage: 0,
            jitter: 0,
            view_dependent: false,
            drawing: 0,
        }
    }
}

uniform! {
    struct Params {
        origin: [f32; 2],
        frame_low: [f32; 2],
        frame_high: [f32; 2],
        slab_count: u32,
        samples: u32,
        sets: u32,
        jitter: f32,
        false_position: u32,
        cone_per_coc: f32,
        culling: u32,
        shading: u32,
        axis: [f32; 2],
        focal_px: f32,
        near_m: f32,
        lens_radius_m: f32,
        over: u32,
        stretched_px: f32,
        block_px: u32,
        blocks: [u32; 2],
        greatest_v: f32,
        _unused: u32,
    }
}

impl Method for Multiview {
    fn about(&self) -> About {
        About {
            id: "multiview",
            title: "Multiview synthesis",
            paper: "Lee, Eisemann and Seidel, Depth-of-Field Rendering with Multiview Synthesis, SIGGRAPH Asia 2009",
            summary: "Draws the scene once in slabs of depth and traces rays from the whole lens through them: hidden surfaces come into sight as they should.",
            limits: "Within a slab only the nearest solid surface is known, and rays that pass under it meet it (section 4.3), and of glass four sheets behind one another, which do not shift with the lens point. What an image with a depth map hides is guessed from what lies beside it.",
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
            Param::int("samples", "Lens points", "", &mut self.samples, (1, 256), "Rays per pixel; one goes through the middle of the lens.")
                .trading(&["16", "32", "64", "128"]).as_published("32"),
            Param::int(
                "slabs",
                "Most slabs",
                "",
                &mut self.slabs,
                (1, MAX_SLABS),
                "Slabs of depth that the scene is cut into, unless delta asks for fewer.",
            ),
            Param::float(
                "delta",
                "delta",
                "px",
                &mut self.delta_px,
                (0.5, 32.0),
                "Thickness of a slab as growth of the CoC diameter over it, section 4.1, which has 3 px of the radius: 6 px here.",
            ).as_published("6"),
            Param::float(
                "overlap",
                "Overlap",
                "",
                &mut self.overlap,
                (0.0, 1.0),
                "How far slabs reach into each other, in thicknesses, section 4.2.",
            ),
            Param::choice(
                "intersection",
                "Intersection",
                &mut self.intersection,
                INTERSECTIONS,
                "steps: at most a pixel at a time. false_position: three estimates, section 4.3.",
            ).as_published("false_position"),
            Param::switch(
                "culling",
                "Culling",
                &mut self.culling,
                "Skips slabs with nothing around a pixel: the same image, sooner.",
            ),
            Param::switch(
                "cones",
                "Cones",
                &mut self.cones,
                "Gives rays the width of the gaps between them, section 4.4.",
            ),
            Param::switch(
                "hidden",
                "Hidden surfaces of images",
                &mut self.hidden,
                "Guess what an image with depth hides from what lies beside it, and let it go on beyond its border. A scene's slabs hold it anyway.",
            )
            .as_published("off"),
            Param::float(
                "lambda",
                "lambda",
                "",
                &mut self.lambda,
                (0.01, 2.0),
                "Diameter of a cone over the CoC's radius with 32 lens points, section 4.4; with more points cones are narrower as the points lie closer. 0.219: the mean distance of 32 points.",
            )
            .as_published("0.137"),
            Param::choice(
                "coverage",
                "Coverage",
                &mut self.coverage,
                COVERAGES,
                "How what slabs cover of a cone comes together. added: pieces of one surface in neighbouring slabs cover different parts. over: v1 c1 + (1 - v1) c2, section 4.4.",
            )
            .as_published("over"),
            Param::choice(
                "jitter",
                "Jitter",
                &mut self.jitter,
                JITTERS,
                "Lens points of a pixel. sets: one of 16 sets. offsets: one set, moved by 16 pairs of four values, section 4.5. off: all pixels alike.",
            ).as_published("offsets"),
            Param::switch(
                "view_dependent",
                "View-dependent shading",
                &mut self.view_dependent,
                "Shade for each ray from its lens point, section 5, so that reflections shift; otherwise a surface emits what the pinhole image shows. What the pinhole image shows stays filtered by the cones; rays add what differs from it.",
            ),
            Param::choice(
                "drawing",
                "Slabs are drawn",
                &mut self.drawing,
                DRAWINGS,
                "together: all in two draws of the scene. one by one: a draw each, the same slabs.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        if !view.is_scene() && !self.hidden {
            frame.skip("hidden surfaces: an image has none");
        }
        let gpu = frame.gpu();
        let key = (lens.aperture.clone(), self.samples, self.jitter, self.cones, self.lambda.to_bits());
        let points = gpu.memo().get(&key, || LensPoints::of(&self.point_sets(), gpu, lens));
        let sheets = SheetRays::of(frame, view, lens);
        let seen = view.pinhole(frame);
        let view = view.solid();
        let slabs = self.slabs(frame, view, lens)?;
        let n_buffer = NBuffer::of(frame, view, &slabs);
        let params = self.uniform(view, lens, &slabs, &n_buffer, &points);
        let result = frame.color_texture("multiview", view.size());
        // Without shading nothing reads these, but they are bound.
        let (base, normal) = slabs.surfaces.as_ref().map_or((&slabs.color, &slabs.color), |s| (&s.base, &s.normal));
        // Rays that shade see reflections move where all else is in focus, and sheets may be blurred there.
        let in_focus_coc_px = if self.shades(view) || sheets.any { -1.0 } else { IN_FOCUS_COC_PX };
        let reach_per_coc = 0.5 * lens.aperture.radius();
        let blur = Reach { in_focus_coc_px, per_coc: reach_per_coc, more_coc_px: lens.greatest_astigmatism_px() };
        let tiles = FocusMap::new(frame, view, lens, blur).tiles(frame, view);
        tiles.copy_in_focus(frame, &seen.color, view.overscan_px(), &result);
        let shading = if self.shades(view) { Some(view.shading()?) } else { None };
        let (environment, lights) = shading.map_or_else(
            || (EnvironmentUniform::default(), frame.gpu().buffer("no lights", size_of::<[f32; 16]>() as u64)),
            |s| (s.environment, s.lights),
        );
        let entry = if self.shades(view) || sheets.any { "trace_tiles_with_more" } else { "trace_tiles" };
        let pass = frame
            .pass(&SHADER, entry)
            .uniform("lens", &view.lens_uniform(lens))
            .uniform("params", &params)
            .texture("slab_color", &slabs.color)
            .texture("slab_depth", &slabs.depth)
            .texture("slab_base", base)
            .texture("slab_normal", normal)
            .buffer("n_buffer", &n_buffer.nearest)
            .sampler("linear_clamp", SamplerKind::Linear)
            .buffer("content", &slabs.content)
            .buffer("lens_points", &points.v)
            .uniform("environment", &environment)
            .buffer("lights", &lights)
            .texture("pinhole", &seen.color)
            .texture("result", &result);
        tiles.dispatch(sheets.bind(pass), DEFOCUSED);
        tiles.expose(frame);
        Ok(result)
    }

    fn explains(&self) -> &'static [&'static str] {
        &[EXPLAINED, tile_lists::SKIPPED]
    }

    fn meaning(&self, name: &str) -> Meaning {
        let number = |name| Quantity::new(name, "", Scale::Whole);
        match name {
            EXPLAINED => Meaning::numbers([number("slab index"), number("slabs with a surface")]),
            tile_lists::SKIPPED => tile_lists::meaning(&TILE_CLASSES),
            name if name == DEPTH || name.starts_with("N-buffer") => Meaning::stored_depth(),
            _ => Meaning::Picture,
        }
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// Classes of tiles, [`tile_lists::IN_FOCUS`] and [`DEFOCUSED`].
const TILE_CLASSES: [(f32, &str); 2] = [(0.0, "in focus: copied, no rays"), (1.0, "traced")];

impl Multiview {
    /// Slabs of thickness delta over a range of CoCs, px; at least one.
    fn slab_count(&self, range_px: f64) -> u32 {
        // Rounding past a whole number of slabs asks for no further one.
        ((range_px / f64::from(self.delta_px) - 1e-3).ceil() as u32).clamp(1, self.slabs)
    }

    /// Whether there are surfaces in slabs of an image that it does not show.
    fn guesses_hidden(&self, view: &View) -> bool {
        self.hidden && !view.is_scene()
    }

    /// Whether rays do the shading: an image's colours are all that is known of it, and so are
    /// those of a scene whose tones were mapped.
    fn shades(&self, view: &View) -> bool {
        self.view_dependent && view.is_scene() && view.tone() == Tone::Linear
    }

    fn slabs(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Slabs, MethodError> {
        let [z_min, z_max] = view.z_bounds(frame);
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        let count = self.slab_count(farthest_px - nearest_px);
        let levels = if self.cones { CONE_LEVELS } else { 1 };
        let ranges = slab_ranges(z_max, z_min, count, self.overlap);
        Slabs::of(
            frame,
            view,
            SlabsKey {
                ranges,
                levels,
                surfaces: self.shades(view),
                hidden: (self.guesses_hidden(view) && count > 1).then(|| view.layer_separation(lens)),
                one_by_one: DRAWINGS[self.drawing] == "one by one",
            },
        )
    }

    fn point_sets(&self) -> PointSets {
        PointSets {
            samples: self.samples,
            sets: if JITTERS[self.jitter] == "sets" { JITTER_SETS } else { 1 },
            moved: JITTERS[self.jitter] == "offsets",
            cone: if self.cones { f64::from(self.lambda / LAMBDA_OF_32) } else { 0.0 },
        }
    }

    fn uniform(&self, view: &View, lens: &Lens, slabs: &Slabs, n_buffer: &NBuffer, points: &LensPoints) -> Params {
        let projection = view.projection();
        let low = slabs.padding.as_vec2();
        let high = low + projection.outer_size().as_vec2();
        Params {
            origin: (low + view.overscan_px() as f32).to_array(),
            frame_low: low.to_array(),
            frame_high: high.to_array(),
            slab_count: slabs.ranges.len() as u32,
            samples: self.samples,
            sets: points.sets,
            jitter: points.jitter as f32,
            false_position: (INTERSECTIONS[self.intersection] == "false_position").into(),
            cone_per_coc: points.cone_per_coc as f32,
            culling: self.culling.into(),
            shading: self.shades(view).into(),
            axis: (0.5 * (low + high) + projection.axis_px.as_vec2()).to_array(),
            focal_px: projection.focal_px as f32,
            near_m: projection.near_m as f32,
            lens_radius_m: projection.eye_on_lens_m(lens, DVec2::X).x as f32,
            over: (COVERAGES[self.coverage] == "over").into(),
            // Else rays that leave the frame under what is near would meet what that hides.
            stretched_px: if self.guesses_hidden(view) { projection.outer_size().max_element() as f32 } else { 0.0 },
            block_px: n_buffer.block_px,
            blocks: n_buffer.blocks.to_array(),
            greatest_v: points.greatest,
            _unused: 0,
        }
    }
}
