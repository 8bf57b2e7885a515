//! `linear`: depth of field as a linear filter that keeps the light.
//!
//! A Eurographics chapter of 2006 on depth of field through "a simple local averaging
//! filter": each pixel's energy e is spread evenly over its circle of confusion, e/(pi r^2)
//! to each pixel in it, and what arrives is summed. There is no order in depth. Its section
//! 3.1.2 names the two pitfalls:
//!
//! - circles drawn without antialiasing change their number of pixels by leaps as the
//!   radius grows, which shows as moire: pixels whose centre lies within sqrt(2)/2 of the
//!   circle's edge are therefore supersampled, 10x10, regularly or jittered;
//! - the energies of a circle must sum to 1: here each circle is divided by the area that
//!   was really drawn, so that they do for every radius.
//!
//! Light that leaves the drawn frame is lost, and light from outside is missing: with
//! overscan the frame around the image gives what it takes.
//!
//! Two back ends: the paper's CPU program ([`linear_cpu`]), and its GPU port, which
//! gathers: `out(p) = sum over q of e_q k(r_q, |p - q|)`, offset by offset over those that any
//! circle in reach has, with the shares of the pixels on a circle's edge from a table.

mod circle;
mod cpu;
mod table;

pub use circle::{CircleSampling, Circles, Coverage};
pub use cpu::{LinearFilter, linear_cpu};
use table::CoverageTable;

use super::{About, Apertures, Meaning, Method, MethodError, Param, Quantity, Scale};
use crate::gpu::{Buffer, Frame, Gpu, Shader, Texture};
use crate::image::Image;
use crate::lens::Lens;
use crate::view::{Layer, View};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/linear");

/// Side of the tiles that are skipped or read together, px: `TILE` in the shader.
const TILE_PX: u32 = 16;

/// Default radius, px, to which circles are cut: the work grows with its square.
pub const MAX_RADIUS_PX: f32 = 128.0;

/// How the share of a pixel that a circle covers is found.
pub const COVERAGES: &[&str] = &["naive", "supersampled"];

/// Where the sub-pixels lie.
pub const PATTERNS: &[&str] = &["uniform", "jittered"];

/// What computes the filter.
pub const BACKENDS: &[&str] = &["gpu", "cpu"];

/// The linear filter with the paper's constants as parameters.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Index among the choices of the parameter of this name.
    pub backend: usize,
    /// Index among the choices of the parameter of this name.
    pub coverage: usize,
    /// Index among the choices of the parameter of this name.
    pub pattern: usize,
    /// Sub-pixels along each side of a pixel (10).
    pub sub_pixels: u32,
    /// Whether each pixel is divided by the energy of a white image there.
    pub normalise: bool,
    /// Radius, px, to which greater circles are cut.
    pub max_radius_px: f32,
}

impl Default for Linear {
    fn default() -> Self {
        Self { backend: 0, coverage: 1, pattern: 0, sub_pixels: 10, normalise: false, max_radius_px: MAX_RADIUS_PX }
    }
}

uniform! {
    struct Params {
        radius_per_coc: f32,
        max_radius: f32,
        naive: u32,
        jittered: u32,
        side: u32,
        normalise: u32,
        overscan: u32,
        reach: u32,
        table_reach: u32,
        share: f32,
        _0: u32,
        _1: u32,
    }
}

uniform! {
    /// Some rows of the chunks of offsets that a workgroup gathers from.
    struct Part {
        first_row: u32,
        rows: u32,
        is_last: u32,
        _unused: u32,
    }
}

/// Offsets along a side of what is gathered at once: `CHUNK` in the shader.
const CHUNK_PX: u32 = 17;

/// Chunks of offsets that one pass gathers from, or one row of them where a row has more. A
/// software adapter ends all loops of an invocation after 65,535 rounds; how far it gets in
/// them depends on the circles, and this many (4,046 sources of a pixel) stay far enough below.
/// Beside the work of so many the start of another pass is nothing on any adapter.
const CHUNKS_A_PART: u32 = 14;

impl Part {
    /// Parts that together gather from all sources within `reach` px.
    fn all(reach: u32) -> Vec<Self> {
        let side = (2 * reach + 1).div_ceil(CHUNK_PX);
        let rows = (CHUNKS_A_PART / side).max(1);
        let part = |first_row| Self { first_row, rows, is_last: (first_row + rows >= side).into(), _unused: 0 };
        (0..side).step_by(rows as usize).map(part).collect()
    }
}

/// A [`CoverageTable`] on the GPU.
struct Table {
    reach: u32,
    begins: Buffer,
    counts: Buffer,
}

impl Table {
    /// The table of `sampling`; an empty one where there is no regular grid.
    fn of(gpu: &Gpu, sampling: CircleSampling) -> Self {
        let table = match sampling.coverage {
            Coverage::Uniform => CoverageTable::new(sampling.sub_pixels, gpu.largest_binding_bytes()),
            _ => CoverageTable::default(),
        };
        let buffer = |label, words: &[u32]| gpu.buffer_of(label, if words.is_empty() { &[0] } else { words });
        Self {
            reach: table.reach,
            begins: buffer("where counts of sub-pixels begin", &table.begins),
            counts: buffer("counts of sub-pixels", &table.counts),
        }
    }
}

/// Light gathered in the parts so far.
const SUMS: &str = "gathered light";

/// Names of what is exposed.
const CIRCLES: &str = "circles";
const TILE_CIRCLES: &str = "greatest circle of each tile";

impl Method for Linear {
    fn about(&self) -> About {
        About {
            id: "linear",
            title: "Linear filter",
            paper: "Eurographics 2006 chapter on depth of field as a linear, space-variant filter",
            summary: "Spreads the light of each pixel evenly over its circle of confusion and sums it: no light is lost or gained.",
            limits: "No order in depth: foreground, background and what is in focus add up, so a constant colour changes where the CoC does, unless \"normalise\" is on; without overscan the border darkens. Draws discs: another aperture becomes the disc of the same standard deviation. Work grows with the square of the CoC. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Round,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: !self.normalise && COVERAGES[self.coverage] != "naive",
            averages: self.normalise,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::choice(
                "backend",
                "Back end",
                &mut self.backend,
                BACKENDS,
                "gpu: gathers on the GPU. cpu: the paper's program, on all cores.",
            ),
            Param::choice(
                "coverage",
                "Circle coverage",
                &mut self.coverage,
                COVERAGES,
                "naive: pixels lie in a circle or not, Fig. 4. supersampled: antialiased and of energy 1, Fig. 5.",
            ),
            Param::choice(
                "pattern",
                "Sub-pixels",
                &mut self.pattern,
                PATTERNS,
                "Where a pixel on a circle's edge is sampled: on a grid, or at random in its cells.",
            ),
            Param::int(
                "sub_pixels",
                "Sub-pixels a side",
                "",
                &mut self.sub_pixels,
                (1, 32),
                "Samples along each side of a pixel on a circle's edge; section 3.1.2 has 10.",
            ),
            Param::switch(
                "normalise",
                "Divide by the energy of white",
                &mut self.normalise,
                "Keeps a constant colour instead of the total energy. Not in the paper.",
            ),
            Param::float(
                "max_radius",
                "Greatest radius",
                "px",
                &mut self.max_radius_px,
                (1.0, 512.0),
                "Greater circles are cut to this radius.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        let greatest_px = radius_per_coc(lens) * nearest_px.abs().max(farthest_px.abs());
        if greatest_px < circle::OWN_PIXEL_RADIUS_PX {
            frame.skip("all circles within their pixel");
            return Ok(super::pinhole::inner(frame, view));
        }
        match BACKENDS[self.backend] {
            "cpu" if frame.may_wait() => Ok(self.on_cpu(frame, view, lens)),
            "cpu" => Err(MethodError::HasToWait { method: "linear" }),
            _ => Ok(self.on_gpu(frame, view, lens, greatest_px as f32)),
        }
    }

    fn explains(&self) -> &'static [&'static str] {
        &[CIRCLES, TILE_CIRCLES]
    }

    fn meaning(&self, name: &str) -> Meaning {
        let radius = Quantity::new("radius", " px", Scale::Found);
        match name {
            CIRCLES => Meaning::numbers([radius, Quantity::new("energy a pixel", "", Scale::Found)]),
            TILE_CIRCLES => Meaning::numbers([radius]),
            _ => Meaning::Picture,
        }
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// Radius of the disc that stands for the lens, over the CoC diameter: 1/2 for the disc
/// itself, and twice the standard deviation for any, as a disc's is half its radius.
fn radius_per_coc(lens: &Lens) -> f64 {
    2.0 * lens.aperture.sigma_per_coc()
}

impl Linear {
    /// The filter that the parameters describe.
    pub fn filter(&self) -> LinearFilter {
        let coverage = match (COVERAGES[self.coverage], PATTERNS[self.pattern]) {
            ("naive", _) => Coverage::Naive,
            (_, "jittered") => Coverage::Jittered,
            _ => Coverage::Uniform,
        };
        LinearFilter {
            sampling: CircleSampling { coverage, sub_pixels: self.sub_pixels },
            max_radius_px: self.max_radius_px,
            normalise: self.normalise,
        }
    }

    fn on_cpu(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Texture {
        let Layer { color, depth } = view.pinhole(frame);
        // What was recorded so far draws the layer that is read back.
        frame.flush();
        let gpu = frame.gpu();
        let (coc, near_m) = (lens.coc(), view.projection().near_m);
        let diameter_per_coc = 2.0 * radius_per_coc(lens);
        let diameter_px = |z: f32| (diameter_per_coc * coc.at_stored(f64::from(z), near_m)) as f32;
        let diameters: Image<f32> = crate::gpu::download_depth(gpu, &depth).map(diameter_px);
        let outer = self.filter().apply(&crate::gpu::download(gpu, &color), &diameters);
        crate::gpu::upload(gpu, "linear", &outer.crop(UVec2::splat(view.overscan_px()), view.size()))
    }

    fn on_gpu(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, greatest_px: f32) -> Texture {
        let Layer { color, depth } = view.pinhole(frame);
        let lens_uniform = view.lens_uniform(lens);
        let gpu = frame.gpu();
        let sampling = self.filter().sampling;
        let table = gpu.memo().get(&sampling, || Table::of(gpu, sampling));
        let params = Params { table_reach: table.reach, ..self.uniform(view, lens, greatest_px) };
        let sub_pixels = gpu.memo().get(&sampling, || gpu.buffer_of("sub-pixels", &self.sub_pixels()));
        let outer = color.size();
        let tiles = (outer + TILE_PX - 1) / TILE_PX;
        let circles = frame.texture(CIRCLES, outer, wgpu::TextureFormat::Rg32Float);
        let tile_radius = frame.texture(TILE_CIRCLES, tiles, wgpu::TextureFormat::R32Float);
        frame
            .pass(&SHADER, "measure_circles")
            .uniform("lens", &lens_uniform)
            .uniform("params", &params)
            .buffer("sub_pixels", &sub_pixels)
            .buffer("table_begins", &table.begins)
            .buffer("table", &table.counts)
            .texture("depth", &depth)
            .texture("circles_out", &circles)
            .texture("tile_radius_out", &tile_radius)
            .dispatch(outer);
        frame.expose(CIRCLES, &circles);
        frame.expose(TILE_CIRCLES, &tile_radius);
        let result = frame.color_texture("linear", view.size());
        let mut sums = frame.texture(SUMS, UVec2::ONE, wgpu::TextureFormat::Rgba32Float);
        for part in Part::all(params.reach) {
            let size = if part.is_last == 0 { result.size() } else { UVec2::ONE };
            let new_sums = frame.texture(SUMS, size, wgpu::TextureFormat::Rgba32Float);
            frame
                .pass(&SHADER, "gather_circles")
                .uniform("params", &params)
                .uniform("part", &part)
                .buffer("sub_pixels", &sub_pixels)
                .buffer("table_begins", &table.begins)
                .buffer("table", &table.counts)
                .texture("color", &color)
                .texture("circles", &circles)
                .texture("tile_radius", &tile_radius)
                .texture("sums", &sums)
                .texture("new_sums", &new_sums)
                .texture("result", &result)
                .dispatch(result.size());
            sums = new_sums;
        }
        result
    }

    fn uniform(&self, view: &View, lens: &Lens, greatest_px: f32) -> Params {
        let filter = self.filter();
        Params {
            radius_per_coc: radius_per_coc(lens) as f32,
            max_radius: self.max_radius_px,
            naive: (filter.sampling.coverage == Coverage::Naive).into(),
            jittered: (filter.sampling.coverage == Coverage::Jittered).into(),
            side: self.sub_pixels,
            normalise: self.normalise.into(),
            overscan: view.overscan_px(),
            // One more than the oracle's reach: the shader's radius may round up.
            reach: (greatest_px.min(self.max_radius_px) + 0.5) as u32 + 1,
            share: 1.0 / self.sub_pixels.pow(2) as f32,
            ..Default::default()
        }
    }

    /// The sub-pixels for the shader, px from a pixel's centre; one unused where there are none.
    fn sub_pixels(&self) -> Vec<[f32; 2]> {
        let circles = Circles::new(self.filter().sampling);
        let mut offsets: Vec<_> = circles.sub_pixels().iter().map(|p| p.map(|v| v as f32)).collect();
        offsets.resize(offsets.len().max(1), [0.0; 2]);
        offsets
    }
}
