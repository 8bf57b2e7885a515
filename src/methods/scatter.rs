//! `scatter`: every pixel a sprite, in true depth order.
//!
//! Potmesil and Chakravarty, "A Lens and Aperture Camera Model for Synthetic Image
//! Generation" (SIGGRAPH 1981), as Lee, Kim and Choi (Pacific Graphics 2008, section 2)
//! sum it up: the intensity of a pixel is distributed over its CoC; the sprites are
//! blended from farther to nearer, and the image is normalised such that alpha is one.
//! The order is that of a sort on the GPU by the bits of the stored depth.
//!
//! **Blending is what it is.** With alpha = coverage / area and "over", the sprites of a
//! uniformly blurred surface reach an alpha of 1 - 1/e only, so what lies behind shows
//! through; and of pixels at one depth, which have no order, those drawn last weigh up to
//! e times as much. The second leans every spot towards one corner. `symmetric` therefore
//! averages over the four orders in which rows and columns can be drawn; without it one
//! order is drawn, as published.

use super::sprites::{SpriteTable, SpritesUniform, sum_format};
use super::{About, Apertures, Method, MethodError, Param};
use crate::gpu::{Blend, Buffer, Frame, Shader, Texture, sort_pairs};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};

const SHADER: Shader = shader!("methods/scatter");

/// The four drawing orders: right before left, lower before upper.
const ORDERS: [[u32; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];

/// Depth-sorted scattering.
#[derive(Clone, Debug)]
pub struct Scatter {
    /// Whether pixels at one depth are drawn in four orders and averaged, or in one.
    pub symmetric: bool,
}

impl Default for Scatter {
    fn default() -> Self {
        Self { symmetric: true }
    }
}

uniform! {
    struct Params {
        from_right: u32,
        from_below: u32,
        weight: f32,
    }
}

impl Method for Scatter {
    fn about(&self) -> About {
        About {
            id: "scatter",
            title: "Sorted scattering",
            paper: "Potmesil and Chakravarty, A Lens and Aperture Camera Model for Synthetic Image Generation, SIGGRAPH 1981",
            summary: "Draws every pixel as its blur spot, far to near in a true depth order, and divides by the alpha that was reached.",
            limits: "One view only: what a blurred foreground hides is missing. Blurred surfaces stay a little transparent to what was drawn before them. Glass and what is seen through it have one depth, that of the nearest surface that covers half or more.",
            apertures: Apertures::Any,
            astigmatism: true,
            needs_scene: false,
            conserves_energy: true,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![Param::switch(
            "symmetric",
            "Symmetric order",
            &mut self.symmetric,
            "Average the four orders in which pixels of one depth can be drawn; off: one order, which leans every spot to one side, at a quarter of the cost.",
        )]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let pinhole = view.pinhole(frame);
        let table = SpriteTable::of_lens(lens);
        let input = Input {
            lens: view.lens_uniform(lens),
            sprites: table.uniform(view),
            idf_sums: SpriteTable::texture_of_lens(lens, frame.gpu()),
            pinhole,
        };
        let orders = if self.symmetric { &ORDERS[..] } else { &ORDERS[..1] };
        let mut sum: Option<Texture> = None;
        for &[from_right, from_below] in orders {
            let params = Params { from_right, from_below, weight: 1.0 / orders.len() as f32 };
            let far_to_near = sorted(frame, &input.pinhole, &params);
            let blended = frame.texture("blended", view.size(), sum_format(frame.gpu(), 1));
            draw(frame, &input, &far_to_near, &blended);
            frame.expose("blended sprites", &blended);
            let next = frame.texture("scatter", view.size(), wgpu::TextureFormat::Rgba32Float);
            match &sum {
                None => frame.pass(&SHADER, "normalise_first"),
                Some(sum) => frame.pass(&SHADER, "normalise_next").texture("sum_before", sum),
            }
            .uniform("params", &params)
            .texture("blended", &blended)
            .texture("sum", &next)
            .dispatch(view.size());
            sum = Some(next);
        }
        Ok(sum.expect("there is at least one order"))
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

struct Input {
    lens: LensUniform,
    sprites: SpritesUniform,
    idf_sums: Texture,
    pinhole: Layer,
}

/// Indices of the pixels, farthest first.
fn sorted(frame: &mut Frame<'_>, pinhole: &Layer, params: &Params) -> Buffer {
    let size = pinhole.depth.size();
    let count = size.element_product();
    let bytes = u64::from(count) * 4;
    let keys = frame.gpu().scratch("depth bits", bytes);
    let pixels = frame.gpu().scratch("pixels far to near", bytes);
    let pass = frame.pass(&SHADER, "list_pixels").uniform("params", params).texture("depth", &pinhole.depth);
    pass.buffer("depth_bits", &keys).buffer("pixels", &pixels).dispatch(size);
    sort_pairs(frame, &keys, &pixels, count);
    pixels
}

fn draw(frame: &mut Frame<'_>, input: &Input, far_to_near: &Buffer, blended: &Texture) {
    let count = input.pinhole.depth.size().element_product();
    let draw = frame.draw(&SHADER, "vs_sorted", "fs_over").strips();
    draw.target(blended, Blend::Over, Some([0.0; 4]))
        .uniform("lens", &input.lens)
        .uniform("sprites", &input.sprites)
        .texture("color", &input.pinhole.color)
        .texture("depth", &input.pinhole.depth)
        .texture("idf_sums", &input.idf_sums)
        .buffer("far_to_near", far_to_near)
        .vertices(4, count);
}
