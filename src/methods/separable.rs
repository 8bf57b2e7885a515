//! `separable`: an adaptive filter in two passes.
//!
//! Zhou, Chen and Pullen, "Accurate Depth of Field Simulation in Real Time" (Computer
//! Graphics Forum 2007), as Lee, Kim and Choi describe it where they compare with it (TVCG
//! 2009, section 7 and Table 1): the image is filtered horizontally, then vertically, over
//! the pixel's own CoC radius, r + 1 + r reads each way. A tap counts
//!
//! - as far as its own circle reaches the centre, with a ramp of one pixel;
//! - by 1 over the area of its circle: the light there is that much thinner;
//! - not at all if it is nearer than the centre and sharp: no leakage.
//!
//! Sums are divided by their weights. The filter is not really separable, as the taps of
//! the second pass have already mixed depths: blurs look angular, and a blurred
//! foreground ends where it ends in the pinhole image unless `reach` lets it out.

use super::{About, Apertures, Method, MethodError, Param};
use crate::gpu::{Frame, Schedule, Shader, Texture};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/separable");

/// Side of the tiles whose greatest reach is found, px: `TILE` in the shader.
const TILE_PX: u32 = 16;

/// Greatest filter radius in view, px, beyond which hardware reads taps by windows. On an H100 at
/// 1920x1080 windows took 1.5 times as long where it was 3 px, and 0.95, 0.75 and 0.68 times where
/// it was 13, 54 and 108 px (`cans` at mean CoCs of 4, 16, 64 and 128 px): between the first two.
const WINDOWS_FROM_PX: f32 = 7.0;

/// How far a pixel looks for taps: over its own circle, or as far as any circle reaches it.
pub const REACHES: &[&str] = &["own", "neighbours"];

/// What a tap's light is thinned by: its circle's area, or its diameter, which is the
/// share of a circle that lies on a line through it.
pub const THINNINGS: &[&str] = &["area", "diameter"];

/// The adaptive separable filter with its constants as parameters.
#[derive(Clone, Debug)]
pub struct Separable {
    /// Filter radius over CoC diameter (1/2).
    pub radius_per_coc: f32,
    /// Index among the choices of the parameter of this name.
    pub reach: usize,
    /// Index among the choices of the parameter of this name.
    pub thinning: usize,
    /// CoC diameter, px, up to which a nearer tap is sharp and refused.
    pub sharp_coc_px: f32,
    /// Radius, px, to which greater filters are cut.
    pub max_radius_px: f32,
}

impl Default for Separable {
    fn default() -> Self {
        Self { radius_per_coc: 0.5, reach: 0, thinning: 0, sharp_coc_px: 1.0, max_radius_px: 128.0 }
    }
}

uniform! {
    struct Params {
        radius_per_coc: f32,
        max_radius: f32,
        sharp_coc: f32,
        neighbours: u32,
        by_diameter: u32,
        overscan: u32,
    }
}

impl Method for Separable {
    fn about(&self) -> About {
        About {
            id: "separable",
            title: "Adaptive separable filter",
            paper: "Zhou, Chen and Pullen, Accurate Depth of Field Simulation in Real Time, Computer Graphics Forum 2007",
            summary: "Filters rows, then columns, over each pixel's CoC; taps count as far as their own circle reaches, and sharp nearer ones do not leak.",
            limits: "Blurs in squares of side C, 15 % wider than the disc; mixed depths are not separable; blurred foreground keeps a hard edge with reach \"own\". Another aperture counts by its standard deviation. Work grows with the CoC. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Round,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::float(
                "radius_per_coc",
                "Radius per CoC",
                "",
                &mut self.radius_per_coc,
                (0.05, 1.0),
                "Filter radius over CoC diameter; the paper's filter has 1/2, and 0.433 has the disc's standard deviation.",
            ),
            Param::choice(
                "reach",
                "Reach",
                &mut self.reach,
                REACHES,
                "own: taps within the pixel's own circle. neighbours: also those whose circle reaches the pixel.",
            ),
            Param::choice(
                "thinning",
                "Light divided by",
                &mut self.thinning,
                THINNINGS,
                "A tap's weight is 1 over its circle's area, or over its diameter.",
            ),
            Param::float(
                "sharp_coc",
                "Sharp up to",
                "px",
                &mut self.sharp_coc_px,
                (0.0, 16.0),
                "A nearer tap with a CoC up to this is refused; from one pixel more on it counts in full.",
            ),
            Param::float(
                "max_radius",
                "Greatest radius",
                "px",
                &mut self.max_radius_px,
                (1.0, 512.0),
                "Wider filters are cut to this radius.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        let params = self.uniform(view, lens);
        let greatest_px = params.radius_per_coc * nearest_px.abs().max(farthest_px.abs()) as f32;
        if greatest_px <= 0.5 {
            frame.skip("no filter reaches another pixel");
            return Ok(super::pinhole::inner(frame, view));
        }
        let uniforms = Uniforms { lens: view.lens_uniform(lens), params };
        let tile_reach = self.tile_reach(frame, &pinhole, &uniforms);
        // Columns beyond the inner frame are not read again; rows are.
        let strip = UVec2::new(view.size().x, pinhole.color.size().y);
        let rows = frame.color_texture("filtered rows", strip);
        let result = frame.color_texture("separable", view.size());
        let by_windows = frame.gpu().schedule() == Schedule::Branches && greatest_px > WINDOWS_FROM_PX;
        let entries = match by_windows {
            false => ["filter_rows", "filter_columns"],
            true => ["filter_rows_by_windows", "filter_columns_by_windows"],
        };
        for (entry, color, output) in [(entries[0], &pinhole.color, &rows), (entries[1], &rows, &result)] {
            frame
                .pass(&SHADER, entry)
                .uniform("lens", &uniforms.lens)
                .uniform("params", &uniforms.params)
                .texture("color", color)
                .texture("depth", &pinhole.depth)
                .texture("tile_reach", &tile_reach)
                .texture("result", output)
                .dispatch(output.size());
        }
        frame.expose("filtered rows", &rows);
        Ok(result)
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

struct Uniforms {
    lens: LensUniform,
    params: Params,
}

impl Separable {
    fn uniform(&self, view: &View, lens: &Lens) -> Params {
        Params {
            // Another aperture counts as the disc of its standard deviation, C/4.
            radius_per_coc: self.radius_per_coc * (4.0 * lens.aperture.sigma_per_coc()) as f32,
            max_radius: self.max_radius_px,
            sharp_coc: self.sharp_coc_px,
            neighbours: (REACHES[self.reach] == "neighbours").into(),
            by_diameter: (THINNINGS[self.thinning] == "diameter").into(),
            overscan: view.overscan_px(),
        }
    }

    /// For each tile, the greatest filter radius that reaches it along its row of tiles
    /// and along its column; a texture that is not read where pixels look no farther than
    /// their own circle.
    fn tile_reach(&self, frame: &mut Frame<'_>, pinhole: &Layer, uniforms: &Uniforms) -> Texture {
        if REACHES[self.reach] == "own" {
            frame.skip("own reach: no tiles");
            return frame.texture("no tile reach", UVec2::ONE, wgpu::TextureFormat::Rg32Float);
        }
        let tiles = (pinhole.depth.size() + TILE_PX - 1) / TILE_PX;
        let radius = frame.texture("greatest radius of each tile", tiles, wgpu::TextureFormat::R32Float);
        let reach = frame.texture("tile reach", tiles, wgpu::TextureFormat::Rg32Float);
        frame
            .pass(&SHADER, "tile_radii")
            .uniform("lens", &uniforms.lens)
            .uniform("params", &uniforms.params)
            .texture("depth", &pinhole.depth)
            .texture("tile_radius_out", &radius)
            .dispatch(tiles);
        frame
            .pass(&SHADER, "dilate_tiles")
            .texture("tile_radius", &radius)
            .texture("tile_reach_out", &reach)
            .dispatch(tiles);
        reach
    }
}
