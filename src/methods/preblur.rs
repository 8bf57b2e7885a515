//! `preblur`: a gather that mixes the image with a blurred copy of it.
//!
//! Scheuermann, "Advanced Depth of Field" (GDC 2004; with Tatarchuk also in ShaderX3):
//!
//! 1. the image is reduced to a quarter of each side and filtered with a 3x3 Gaussian;
//! 2. twelve taps over the pixel's disc read both images and mix them by the tap's own
//!    blurriness; a tap that is nearer than the centre weighs as much as it is blurred,
//!    any other 1: what is sharp and near leaks less.
//!
//! **Blurriness** there does not follow a lens: it is a ramp, linear in depth, from the focus
//! distance to a near and a far distance of full blur that an artist chooses, and the disc is a
//! greatest disc times blurriness. Here the ramp is laid through the thin lens: it is 0 at
//! the focus distance, meets the lens where that reaches the share `ramp_share` of the
//! greatest CoC in view on that side, and stays within that CoC; full blur is the greatest
//! CoC in view, or the greatest disc of the article's program, 10 px, if that is more. The
//! alternative is the lens's CoC itself, with 10 px as full blur.

use super::{About, Apertures, Method, MethodError, Param};
use crate::gpu::{Frame, SamplerKind, Shader, Texture};
use crate::lens::Lens;
use crate::view::{LensUniform, View};
use crate::{shader, uniform};

const SHADER: Shader = shader!("methods/preblur");

/// Side of a reduced texel, px: `STEP` in the shader.
const STEP_PX: u32 = 4;

/// What blurriness follows.
pub const BLURRINESSES: &[&str] = &["ramp", "coc"];

/// CoC diameter, px, before a focus at infinity from which the ramp starts instead: a ramp
/// in depth cannot end there.
const NEARLY_IN_FOCUS_PX: f64 = 0.5;

/// Pre-blurring with the paper's constants as parameters.
#[derive(Clone, Debug)]
pub struct Preblur {
    /// Index among the choices of the parameter of this name.
    pub blurriness: usize,
    /// Share of the greatest CoC in view, on each side of the focus, at which the ramp
    /// meets the lens.
    pub ramp_share: f32,
    /// CoC diameter, px, of full blurriness (10); with the ramp, the least it may be.
    pub full_coc_px: f32,
    /// Radius of the disc of taps in the reduced image over that in the image, in texels
    /// of each (0.4).
    pub radius_scale: f32,
    /// Whether nearer taps weigh as much as they are blurred.
    pub leak_test: bool,
}

impl Default for Preblur {
    fn default() -> Self {
        Self { blurriness: 0, ramp_share: 0.75, full_coc_px: 10.0, radius_scale: 0.4, leak_test: true }
    }
}

uniform! {
    struct Params {
        near: f32,
        focus: f32,
        coc_per_depth: [f32; 2],
        coc_bounds: [f32; 2],
        diameter_per_coc: f32,
        full_coc: f32,
        radius_scale: f32,
        ramp: u32,
        leak_test: u32,
        overscan: u32,
    }
}

impl Method for Preblur {
    fn about(&self) -> About {
        About {
            id: "preblur",
            title: "Pre-blurred gather",
            paper: "Scheuermann, Advanced Depth of Field, GDC 2004",
            summary: "Twelve taps over the CoC mix the image with a quarter-size blurred copy by their blurriness.",
            limits: "A mix of sharp and much blurred where a little blur is due; sharp colours leak through the copy; foreground keeps hard edges; large blurs show the taps. With \"ramp\" blurriness is linear in depth, which no lens is. Another aperture counts by its standard deviation. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
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
            Param::choice(
                "blurriness",
                "Blurriness",
                &mut self.blurriness,
                BLURRINESSES,
                "ramp: linear in depth, as in the article, laid through the lens. coc: the lens's CoC.",
            ),
            Param::float(
                "ramp_share",
                "Ramp meets lens at",
                "",
                &mut self.ramp_share,
                (0.05, 0.95),
                "Share of the greatest CoC in view, before and behind the focus, at which the ramp meets the lens.",
            ),
            Param::float(
                "full_coc",
                "Full blur at",
                "px",
                &mut self.full_coc_px,
                (1.0, 128.0),
                "CoC at which only the blurred copy is read; the article's greatest disc is 10 px. With the ramp it is the greatest CoC in view where that is more.",
            ),
            Param::float(
                "radius_scale",
                "Radius scale",
                "",
                &mut self.radius_scale,
                (0.0, 1.0),
                "Radius of the disc in the blurred copy, in its texels, over that in the image; the article has 0.4, and 0.25 covers the same disc.",
            ),
            Param::switch(
                "leak_test",
                "Leak test",
                &mut self.leak_test,
                "Taps nearer than the centre weigh as much as they are blurred.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let bounds_px = view.coc_bounds_px(frame, lens);
        let uniforms = Uniforms { lens: view.lens_uniform(lens), params: self.uniform(view, lens, bounds_px) };
        let size = (pinhole.color.size() + STEP_PX - 1) / STEP_PX;
        let blurred = frame.color_texture("blurred copy", size);
        frame.pass(&SHADER, "reduce").texture("color", &pinhole.color).texture("reduced_out", &blurred).dispatch(size);
        frame.expose("blurred copy", &blurred);
        let result = frame.color_texture("preblur", view.size());
        frame
            .pass(&SHADER, "gather_taps")
            .uniform("lens", &uniforms.lens)
            .uniform("params", &uniforms.params)
            .texture("color", &pinhole.color)
            .texture("depth", &pinhole.depth)
            .texture("reduced", &blurred)
            .sampler("linear_clamp", SamplerKind::Linear)
            .texture("result", &result)
            .dispatch(result.size());
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

/// Scheuermann's ramp: the signed CoC diameter, px, as a function linear in depth on each
/// side of the focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Depth, metres, at which it is 0.
    pub focus_m: f64,
    /// Slope before and behind the focus, px per metre.
    pub coc_per_depth_px_m: [f64; 2],
    /// Least and greatest signed CoC diameter, px, that it takes.
    pub coc_bounds_px: [f64; 2],
}

impl Ramp {
    /// The ramp through the thin lens's CoC at the share `share` of its bounds in view.
    pub fn through(lens: &Lens, coc_bounds_px: [f64; 2], share: f64) -> Self {
        let coc = lens.coc();
        // Only one side may be in view; the other side's slope then does not matter.
        let bounds_px = [coc_bounds_px[0].min(0.0), coc_bounds_px[1].max(0.0)];
        let sharpest_m = lens.sharpest_m();
        // Where nothing is sharp the ramp begins at what is least blurred, all but its last
        // hundredth: that lies at infinity.
        let [low_px, high_px] = bounds_px;
        let nearly_px = (coc_bounds_px[1] + 0.01 * (coc_bounds_px[0] - coc_bounds_px[1])).min(-NEARLY_IN_FOCUS_PX);
        let nearly_px = if high_px > low_px && lens.focus_d() < 0.0 { nearly_px } else { -NEARLY_IN_FOCUS_PX };
        let focus_m = if sharpest_m.is_finite() { sharpest_m } else { coc.depth_at(nearly_px) };
        let slope = |bound_px: f64| {
            let run_m = coc.depth_at(share * bound_px) - focus_m;
            // The depth that one bound has may round to the focus itself.
            if run_m == 0.0 || !run_m.is_finite() { 0.0 } else { (share * bound_px / run_m).abs() }
        };
        Self { focus_m, coc_per_depth_px_m: bounds_px.map(slope), coc_bounds_px: bounds_px }
    }

    /// Signed CoC diameter, px, at `d_m` metres (may be infinite).
    pub fn coc_diameter_px(&self, d_m: f64) -> f64 {
        let [near, far] = self.coc_per_depth_px_m;
        let slope = if d_m < self.focus_m { near } else { far };
        if slope == 0.0 {
            return 0.0;
        }
        (slope * (d_m - self.focus_m)).clamp(self.coc_bounds_px[0], self.coc_bounds_px[1])
    }
}

impl Preblur {
    fn uniform(&self, view: &View, lens: &Lens, coc_bounds_px: [f64; 2]) -> Params {
        let ramp = Ramp::through(lens, coc_bounds_px, f64::from(self.ramp_share));
        let follows_ramp = BLURRINESSES[self.blurriness] == "ramp";
        let greatest_px = ramp.coc_bounds_px[1].max(-ramp.coc_bounds_px[0]) as f32;
        Params {
            near: view.projection().near_m as f32,
            focus: ramp.focus_m as f32,
            coc_per_depth: ramp.coc_per_depth_px_m.map(|v| v as f32),
            coc_bounds: ramp.coc_bounds_px.map(|v| v as f32),
            // Another aperture counts as the disc of its standard deviation, C/4.
            diameter_per_coc: (4.0 * lens.aperture.sigma_per_coc()) as f32,
            full_coc: if follows_ramp { greatest_px.max(self.full_coc_px) } else { self.full_coc_px },
            radius_scale: self.radius_scale,
            ramp: follows_ramp.into(),
            leak_test: self.leak_test.into(),
            overscan: view.overscan_px(),
        }
    }
}
