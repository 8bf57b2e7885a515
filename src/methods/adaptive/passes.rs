//! The passes that follow the tiles: rays, glow, composite.

use super::AdaptiveUniform;
use super::explain::explain;
use super::tiles::Tiles;
use super::views::Views;
use crate::gpu::{Buffer, Frame, Pass, SamplerKind, Shader, Switches, Texture, TextureKey};
use crate::methods::sheet_rays::SheetRays;
use crate::shader;
use crate::view::{LIGHT_BYTES, Peeled};
use glam::UVec2;

const TRACE: Shader = shader!("methods/adaptive_trace");
const GLOW: Shader = shader!("methods/adaptive_glow");
const COMPOSITE: Shader = shader!("methods/adaptive_composite");

/// Buckets of s: `BUCKETS` in `shaders/lib/layers.wgsl`.
const BUCKETS: u32 = 5;

/// Classes of tiles, with their indices in lists and dispatches.
#[derive(Clone, Copy)]
enum Class {
    Copy = 0,
    Uniform = 1,
    Complex = 2,
}

/// What the rays of a frame read.
pub(super) struct Rays<'a> {
    pub adaptive: &'a AdaptiveUniform,
    pub tiles: &'a Tiles,
    pub peeled: &'a Peeled,
    pub views: &'a Views,
    pub sheets: &'a SheetRays,
    /// [`lens_points`](super::lens_points).
    pub points: &'a Buffer,
}

impl Rays<'_> {
    /// Records all passes and returns the image.
    pub fn record(&self, frame: &mut Frame<'_>) -> Texture {
        let (size, half) = (UVec2::from(self.adaptive.size), wgpu::TextureFormat::Rgba16Float);
        let key = TextureKey { size, levels: 1, layers: BUCKETS, format: half };
        let buckets = frame.gpu().texture_of("buckets", key);
        let looked_at = self.adaptive.diagnose != 0;
        let counts = frame.texture("counts", if looked_at { size } else { UVec2::ONE }, half);
        self.trace(frame, &buckets, &counts);
        let glow = self.glow(frame);
        let result = frame.color_texture("adaptive", size);
        for class in [Class::Complex, Class::Uniform] {
            let pass = self
                .composite_pass(frame, "composite")
                .buffer("tiles", &self.tiles.dilated)
                .texture("buckets", &buckets)
                .buffer("tile_buckets", &self.tiles.buckets)
                .texture("glow", &glow)
                .texture("result", &result);
            self.tiles.lists.dispatch(pass, class as u32);
        }
        let pass = self.composite_pass(frame, "copy_sharp").texture("counts", &counts).texture("result", &result);
        self.tiles.lists.dispatch(pass, Class::Copy as u32);
        if looked_at {
            explain(frame, &self.tiles.classes, &counts, &buckets);
        }
        result
    }

    /// What the shaders of rays have code for: `override` constants of
    /// `shaders/lib/lens_rays.wgsl`; tracing has `VIEWS` of `lens_views.wgsl` beside them.
    fn switches(&self) -> Switches {
        Switches::of([
            ("ASTIGMATIC", self.adaptive.lens.astigmatism_px != 0.0),
            ("STAGGERED", self.peeled.staggered),
            ("IMAGE", self.adaptive.is_image != 0),
            ("SHEETS", self.sheets.any),
        ])
    }

    /// Gathers the hits of every pixel's rays.
    fn trace(&self, frame: &mut Frame<'_>, buckets: &Texture, counts: &Texture) {
        let lights = match &self.peeled.lights {
            Some(lights) => lights.buffer.clone(),
            None => frame.gpu().buffer("no lights", LIGHT_BYTES),
        };
        for (entry, class) in [("trace_complex", Class::Complex), ("trace_uniform", Class::Uniform)] {
            let switches = self.switches().with("VIEWS", self.adaptive.views != 0);
            let mut pass = frame.specialized_pass(&TRACE, entry, switches).uniform("adaptive", self.adaptive);
            if let Class::Complex = class {
                pass = pass
                    .buffer("lights", &lights)
                    .buffer("tiles", &self.tiles.dilated)
                    .texture("view_radii", &self.views.radii)
                    .texture("view_colors", &self.views.colors)
                    .texture("nearest_depths", &self.peeled.nearest);
                pass = self.sheets.bind(pass);
            }
            let pass = pass
                .texture("radii", &self.tiles.radii)
                .texture("colors", &self.peeled.color)
                .texture("sample_colors", &self.peeled.samples.color)
                .texture("sample_depths", &self.peeled.samples.depth)
                .sampler("linear_clamp", SamplerKind::Linear)
                .sampler("nearest_clamp", SamplerKind::Nearest)
                .buffer("lens_points", self.points)
                .texture("new_buckets", buckets)
                .buffer("tile_buckets", &self.tiles.buckets)
                .texture("counts", counts);
            self.tiles.lists.dispatch(pass, class as u32);
        }
    }

    /// What emitters bring, where there are any.
    fn glow(&self, frame: &mut Frame<'_>) -> Texture {
        let half = wgpu::TextureFormat::Rgba16Float;
        let Some(highlights) = &self.tiles.highlights else {
            return frame.texture("no glow", UVec2::ONE, half);
        };
        let glow = frame.texture("glow", UVec2::from(self.adaptive.size), half);
        let pass = frame
            .specialized_pass(&GLOW, "add_glow", self.switches())
            .uniform("adaptive", self.adaptive)
            .buffer("tiles", &self.tiles.dilated)
            .uniform("highlights", &highlights.uniform)
            .buffer("emitter_lists", &highlights.lists)
            .buffer("listed_counts", &highlights.listed_counts)
            .buffer("emitters", &highlights.emitters)
            .texture("aperture", &highlights.aperture)
            .texture("radii", &self.tiles.radii)
            .texture("sample_depths", &self.peeled.samples.depth)
            .texture("nearest_depths", &self.peeled.nearest)
            .texture("new_glow", &glow);
        self.tiles.lists.dispatch(self.sheets.bind(pass), Class::Complex as u32);
        frame.expose("glow of highlights", &glow);
        glow
    }

    fn composite_pass<'f, 'g>(&self, frame: &'f mut Frame<'g>, entry: &'static str) -> Pass<'f, 'g> {
        let samples = &self.peeled.samples.color;
        // What it has in workgroup memory it writes before it reads it.
        let switches = Switches::default().with_uninitialized_memory();
        frame
            .specialized_pass(&COMPOSITE, entry, switches)
            .uniform("adaptive", self.adaptive)
            .texture("sample_colors", samples)
    }
}
