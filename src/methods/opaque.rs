//! `opaque`: sub-images blurred without ever lowering an opacity.
//!
//! Kraus, "Using Opaque Image Blur for Real-Time Depth-of-Field Rendering" (GRAPP 2011).
//! Nothing that a sharp pinhole image hides is ever uncovered, so nothing need be made up
//! for it: a sub-image's colours are blurred, and its opacity is a *glow* of the same
//! pyramid that only grows.
//!
//! 1. matte: `RGBA = omega_i * (rgb, 1)`, section 3 (`subimages.rs`);
//! 2. blur and glow from one analysis pyramid of |i| levels, section 4, equation (8);
//! 3. `RGBA_sub = RGBA_blur * A_glow / A_blur`, equation (7);
//! 4. blending with "over", equation (6).
//!
//! It differs from `pyramid` in step 2 and 3: no disocclusion, a glow instead.
//!
//! At every pixel one sub-image has weight 1, which the glow keeps: the result is opaque
//! without normalisation, and flat colours stay what they are, at the border too.
//!
//! **Weights between sub-images.** Over a flat region of weight a < 1 the glow's opacity is
//! `1 - (1 - a)^(|i| + 1)`: nearer sub-images weigh too much. The calibration "measured" undoes
//! that; "paper" keeps it.

use super::subimages::{self, Spacing, SubImages, Wanted, box_groups, image_blocks};
use super::{About, Apertures, Meaning, Method, MethodError, Param};
use crate::gpu::{Frame, Precision, Shader, Texture};
use crate::lens::Lens;
use crate::shader;
use crate::view::View;

/// Side, px, below which an image is thin: a wide blur leaves so little of its opacity
/// against the transparent border that f16 has no digits for it.
const THIN_PX: u32 = 16;

const SHADER: Shader = shader!("methods/opaque");

/// The opaque image blur with the paper's constants as parameters.
#[derive(Clone, Debug)]
pub struct Opaque {
    /// Where sub-images lie.
    pub spacing: Spacing,
    /// Whether transparent black surrounds the image (section 5), or its border pixels
    /// continue.
    pub transparent_border: bool,
}

impl Default for Opaque {
    fn default() -> Self {
        Self { spacing: Spacing::default(), transparent_border: true }
    }
}

impl Method for Opaque {
    fn about(&self) -> About {
        About {
            id: "opaque",
            title: "Opaque image blur",
            paper: "Kraus, Using Opaque Image Blur for Real-Time Depth-of-Field Rendering, GRAPP 2011",
            summary: "Blurs sub-images by depth with pyramids, each with an opacity that only grows, so that nothing hidden is uncovered.",
            limits: "Silhouettes are too sharp and blurred objects too opaque: nothing shows through their edges. What is in focus shows up to 4 px beyond its edge over what is blurred behind it: it is part of the first blurred sub-image too (Fig. 2). Round apertures only. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Round,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        let mut params = self.spacing.params();
        params.push(Param::switch(
            "transparent_border",
            "Transparent border",
            &mut self.transparent_border,
            "Surround the image with transparent black (section 5); otherwise with what is nearest in it.",
        ));
        params
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let precision = frame.precision;
        if pinhole.color.size().min_element() < THIN_PX {
            frame.precision = Precision::Full;
        }
        let wanted = Wanted { glow: true, transparent_border: self.transparent_border, repeated_inclusion: 0.0 };
        let sub_images = SubImages::new(frame, view, lens, &self.spacing, &wanted);

        let matted = sub_images.matte(frame);
        let groups = box_groups(matted.size());
        sub_images
            .bind(frame.pass(&SHADER, "matte_and_reduce"), &pinhole)
            .buffer("occupied_out", &sub_images.occupied)
            .texture("coarser", &matted)
            .dispatch_groups(groups.x, groups.y, 1);

        let blurred = sub_images.blur(frame, matted);

        let result = frame.color_texture("opaque", view.size());
        sub_images
            .bind(frame.pass(&SHADER, "blur_and_blend"), &pinhole)
            .buffer("occupied", &sub_images.occupied)
            .texture("analysis", &blurred.analysis)
            .texture("blur", &blurred.blur)
            .texture("glow", &blurred.glow)
            .texture("result", &result)
            .dispatch(image_blocks(result.size()));
        frame.precision = precision;
        Ok(result)
    }

    fn explains(&self) -> &'static [&'static str] {
        subimages::EXPLAINS
    }

    fn meaning(&self, name: &str) -> Meaning {
        subimages::meaning(name)
    }

    fn texel_px(&self, name: &str) -> Option<u32> {
        subimages::texel_px(name)
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}
