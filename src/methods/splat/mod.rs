//! `splat`: point splatting on per-pixel layers.
//!
//! Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using Point Splatting on
//! Per-Pixel Layers" (Pacific Graphics 2008):
//!
//! 1. the visible image V, and a hidden image H of what lies behind partially occluding
//!    foreground, section 3.2;
//! 2. every pixel of both is a spot of its CoC's size and the aperture's shape, section
//!    3.3 and [`super::sprites`];
//! 3. each destination pixel sums what arrives in three layers: in front of, at and behind
//!    its own visible surface, equation (6);
//! 4. the layers are composed far to near, each divided by its alpha, equation (7).
//!
//! What the paper measures on "normalised depth" is measured here on the signed CoC over
//! its range in view: with stored depth near / d the two are the same scale, and it does
//! not change with the lens.
//!
//! The paper draws the spots as sprites and blends them. On hardware each pixel gathers what
//! reaches it, tile by tile: the same shares on the same layers, in any order, and in 32 bits
//! everywhere. A software adapter runs both sides of every branch of that and blends at no
//! extra cost: there sprites are drawn. `tests/splat_tiles.rs` holds the two against each other.
//!
//! Where the alphas of overlapping CoCs sum to more than 1, `1 - alpha` is taken as 0.
//!
//! **M1 and M2.** The paper adds them to L1 and L2, "because they are mostly in similar
//! depths". Where they are not, and a hidden surface lies within delta of a blurred visible
//! one that is complete by itself, the sum shows half of each. "filling" adds of H only as
//! much as V leaves of an alpha of 1; where H completes a surface of V the two agree. It is
//! the default: against accumulation, the built-in cans focused on the wall have 33.2 dB
//! without H, 32.0 dB with it added and 33.8 dB with it filling (192x144, 64 lens points).

mod sheets;
mod sprites;
mod tiles;

use super::sprites::{SpriteTable, SpritesUniform};
use super::{About, Apertures, Meaning, Method, MethodError, Param, Quantity, Scale};
use crate::gpu::{Buffer, Frame, Pass, Shader, Texture};
use crate::lens::Lens;
use crate::view::{Layer, LensUniform, View};
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/splat");

/// How the hidden image's layers meet the visible one's.
pub const HIDDEN_BLENDS: &[&str] = &["filling", "added"];

/// How spots are summed. "adapter": as is faster there, by tiles on hardware and by sprites
/// in software, if it blends 32-bit floats.
pub const SUMMED_BY: &[&str] = &["adapter", "tiles", "sprites"];

/// Point splatting with the paper's constants as parameters.
#[derive(Clone, Debug)]
pub struct Splat {
    /// Index among the choices of the parameter of this name.
    pub by: usize,
    /// Whether a hidden image is drawn and splatted (section 3.2).
    pub hidden: bool,
    /// Index among the choices of the parameter of this name.
    pub hidden_blend: usize,
    /// epsilon: how far behind the visible surface a hidden one must lie, over the range
    /// of c in view (section 3.2: 0.05).
    pub separation: f32,
    /// Least L(p) of equation (4) at which a pixel occludes partially, over the range of c
    /// in view (section 3.2: 0.01).
    pub occlusion: f32,
    /// Whether there are three layers or one (section 3.4).
    pub layers: bool,
    /// delta of equation (6), over C of the destination (0.3 to 0.5).
    pub delta: f32,
    /// Whether composed layers are divided by their alpha (section 3.5).
    pub normalise: bool,
    /// Whether one sprite stands for four pixels where that is not seen (section 5).
    pub accelerate: bool,
    /// Whether highlights that were cut at white are expanded, equation (8).
    pub highlights: bool,
    /// lambda_0 of equation (8).
    pub highlight_threshold: f32,
    /// beta of equation (8).
    pub highlight_falloff: f32,
    /// gamma of equation (8).
    pub highlight_gain: f32,
}

impl Default for Splat {
    fn default() -> Self {
        Self {
            by: 0,
            hidden: true,
            hidden_blend: 0,
            separation: 0.05,
            occlusion: 0.01,
            layers: true,
            delta: 0.4,
            normalise: true,
            accelerate: false,
            highlights: false,
            highlight_threshold: 0.8,
            highlight_falloff: 3.0,
            highlight_gain: 2.0,
        }
    }
}

uniform! {
    #[derive(PartialEq)]
    struct Params {
        delta: f32,
        separation_z: f32,
        occlusion_px: f32,
        layered: u32,
        normalised: u32,
        filling: u32,
        highlights: u32,
        highlight_threshold: f32,
        highlight_falloff: f32,
        highlight_gain: f32,
        sheets: u32,
    }
}

impl Method for Splat {
    fn about(&self) -> About {
        About {
            id: "splat",
            title: "Point splatting",
            paper: "Lee, Kim and Choi, Real-Time Depth-of-Field Rendering Using Point Splatting on Per-Pixel Layers, Pacific Graphics 2008",
            summary: "Spreads every pixel over its blur spot on three layers around each destination, with a second image of what the foreground hides.",
            limits: "Two solid surfaces deep: a third behind two blurred ones is missing. Glass behind a blurred solid rim is drawn over it. The cost grows with the area of the CoC.",
            apertures: Apertures::Any,
            astigmatism: true,
            needs_scene: false,
            conserves_energy: true,
            averages: true,
            samples_lens: false,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::choice(
                "by",
                "Summed by",
                &mut self.by,
                SUMMED_BY,
                "tiles: each pixel gathers what reaches it. sprites: as in the paper, drawn and blended; the same but for rounding. adapter: tiles on hardware, sprites in software.",
            ),
            Param::switch(
                "hidden",
                "Hidden image",
                &mut self.hidden,
                "Draw what lies behind partially occluding foreground and splat it too, section 3.2. Of an image with depth it is guessed from what lies beside the foreground.",
            ),
            Param::choice(
                "hidden_blend",
                "Hidden image is",
                &mut self.hidden_blend,
                HIDDEN_BLENDS,
                "added: as in section 3.5. filling: no more of it than the visible layers leave to be filled.",
            )
            .as_published("added"),
            Param::float(
                "separation",
                "epsilon",
                "",
                &mut self.separation,
                (0.0, 1.0),
                "How far behind the visible surface a hidden one must lie, over the range of the CoC in view, section 3.2.",
            ),
            Param::float(
                "occlusion",
                "Occlusion threshold",
                "",
                &mut self.occlusion,
                (0.0, 1.0),
                "How much farther a pixel's surroundings must be for anything behind it to be seen, over the range of the CoC in view, equation (4).",
            ),
            Param::switch(
                "layers",
                "Per-pixel layers",
                &mut self.layers,
                "Three layers around each destination's depth, section 3.4; off: one for all, and no hidden image.",
            ),
            Param::float(
                "delta",
                "delta",
                "",
                &mut self.delta,
                (0.0, 2.0),
                "Half the depth of the middle layer over the destination's CoC, equation (6).",
            ),
            Param::switch(
                "normalise",
                "Normalise",
                &mut self.normalise,
                "Divide the composed layers by their alpha, section 3.5; off shows what overlapping spots sum to.",
            ),
            Param::switch(
                "accelerate",
                "Quarter-area sprites",
                &mut self.accelerate,
                "One spot for four pixels where C is 4 px or more and nothing is partially occluded, section 5.",
            )
            .trading(&["off", "on"]),
            Param::switch(
                "highlights",
                "Expand highlights",
                &mut self.highlights,
                "Brighten what was cut at white, equation (8): for images without values above 1.",
            ),
            Param::float(
                "highlight_threshold",
                "lambda_0",
                "",
                &mut self.highlight_threshold,
                (0.0, 0.99),
                "Luminance from which highlights are expanded, equation (8).",
            ),
            Param::float(
                "highlight_falloff",
                "beta",
                "",
                &mut self.highlight_falloff,
                (0.1, 10.0),
                "Exponent with which the expansion sets in, equation (8).",
            ),
            Param::float(
                "highlight_gain",
                "gamma",
                "",
                &mut self.highlight_gain,
                (1.0, 20.0),
                "How many times brighter white becomes, equation (8).",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let sheets = view.sheets(frame, lens);
        let view = view.solid();
        let pass = Splatting::new(self, frame, view, lens);
        let arrays = self.accelerate.then(|| pass.choose_arrays(frame));
        let mut layers = pass.splat_visible(frame, arrays.as_ref());
        let Some(sheets) = sheets else { return self.with_hidden(frame, view, lens, &pass, &layers) };
        let [in_front, behind] = pass.splat_sheets(frame, &sheets);
        layers[2] = pass.put_behind(frame, &behind, &layers[2]);
        let seen = self.with_hidden(frame, view, lens, &pass, &layers)?;
        Ok(pass.put_in_front(frame, &in_front, &seen))
    }

    fn explains(&self) -> &'static [&'static str] {
        &[EXPLAINED]
    }

    fn meaning(&self, name: &str) -> Meaning {
        let share = |name| Quantity::new(name, " %", Scale::Found).worth(100.0);
        match name {
            EXPLAINED => Meaning::numbers([
                Quantity::new("layers seen", "", Scale::Classes(&LAYERS)),
                share("share in front"),
                share("share at"),
                share("share behind"),
            ]),
            HIDDEN_LIMIT => Meaning::stored_depth(),
            _ => Meaning::Picture,
        }
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// Labels of L0, L1 and L2, and of M1 and M2.
const LAYER_LABELS: [&str; 3] = ["layer in front", "layer at", "layer behind"];
const HIDDEN_LABELS: [&str; 2] = ["hidden at", "hidden behind"];

/// Names of what is exposed.
const HIDDEN_LIMIT: &str = "hidden limit";
const EXPLAINED: &str = "layers of each pixel";

/// Which layers are seen, as the shader numbers them.
const LAYERS: [(f32, &str); 4] = [(0.0, "at"), (1.0, "at, in front"), (2.0, "at, behind"), (3.0, "all")];

impl Splat {
    /// The picture of the visible image's layers, with those of the hidden one where it is needed.
    fn with_hidden(
        &self,
        frame: &mut Frame<'_>,
        view: &mut View,
        lens: &Lens,
        pass: &Splatting,
        layers: &[Texture; 3],
    ) -> Result<Texture, MethodError> {
        if !self.hidden_is_needed(frame, view, lens) {
            return Ok(pass.compose(frame, layers, None));
        }
        let hidden = self.hidden_image(frame, view, lens, pass)?;
        frame.expose("hidden", &hidden.color);
        let hidden_layers = pass.splat_hidden(frame, &hidden);
        Ok(pass.compose(frame, layers, Some(&hidden_layers)))
    }

    /// What the foreground hides. All primaries of a chromatic eye share one, drawn for that which blurs
    /// the foreground most.
    fn hidden_image(
        &self,
        frame: &mut Frame<'_>,
        view: &mut View,
        lens: &Lens,
        pass: &Splatting,
    ) -> Result<Layer, MethodError> {
        let separation = view.layer_separation(lens);
        let farthest = lens.of_farthest_primary();
        if lens.eye.farthest_shift_d == 0.0 {
            let limit = pass.hidden_limit(frame);
            return Ok(view.hidden(frame, &limit, separation)?);
        }
        let key = (farthest.clone(), pass.params);
        let known = view.kept::<HiddenOfPrimaries>().take().filter(|known| known.key == key && *lens != farthest);
        let layer = match known {
            Some(known) => {
                frame.skip("hidden image of another primary");
                known.layer
            }
            None => {
                let limit = Splatting { lens: view.lens_uniform(&farthest), ..pass.clone() }.hidden_limit(frame);
                view.hidden(frame, &limit, separation)?
            }
        };
        *view.kept() = Some(HiddenOfPrimaries { key, layer: layer.clone() });
        Ok(layer)
    }

    fn hidden_is_needed(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> bool {
        if !self.hidden || !self.layers {
            return false;
        }
        // Foreground whose spots stay within a pixel occludes nothing partially.
        let [nearest_px, _] = view.coc_bounds_px(frame, lens);
        if (lens.greatest_astigmatism_px() - nearest_px) * lens.aperture.radius() <= 1.0 {
            frame.skip("no foreground: no hidden image");
            return false;
        }
        true
    }

    fn uniform(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Params {
        let [z_min, z_max] = view.z_bounds(frame);
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        Params {
            delta: self.delta,
            separation_z: self.separation * (z_max - z_min),
            occlusion_px: self.occlusion * (farthest_px - nearest_px) as f32,
            layered: self.layers.into(),
            normalised: self.normalise.into(),
            filling: (HIDDEN_BLENDS[self.hidden_blend] == "filling").into(),
            highlights: self.highlights.into(),
            highlight_threshold: self.highlight_threshold,
            highlight_falloff: self.highlight_falloff,
            highlight_gain: self.highlight_gain,
            sheets: 0,
        }
    }
}

/// The hidden image that the primaries of a chromatic eye share, with what it was drawn for.
struct HiddenOfPrimaries {
    key: (Lens, Params),
    layer: Layer,
}

/// One frame's splatting: what goes in.
#[derive(Clone)]
struct Splatting {
    visible: Layer,
    lens: LensUniform,
    sprites: SpritesUniform,
    params: Params,
    idf_sums: Texture,
    /// The same as a buffer.
    idf_table: Buffer,
    /// Size of the inner frame.
    size: UVec2,
    by_sprites: bool,
    /// How far from its centre the widest spot reaches, px.
    reach_px: f64,
}

impl Splatting {
    fn new(splat: &Splat, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Self {
        let table = SpriteTable::of_lens(lens);
        let [nearest_px, farthest_px] = view.coc_bounds_px(frame, lens);
        Self {
            visible: view.pinhole(frame),
            lens: view.lens_uniform(lens),
            sprites: table.uniform(view),
            params: splat.uniform(frame, view, lens),
            idf_sums: SpriteTable::texture_of_lens(lens, frame.gpu()),
            idf_table: SpriteTable::buffer_of_lens(lens, frame.gpu()),
            size: view.size(),
            by_sprites: match SUMMED_BY[splat.by] {
                "adapter" => frame.gpu().is_software() && sprites::blends_32_bits(frame.gpu()),
                by => by == "sprites",
            },
            reach_px: table.reach_px(nearest_px.abs().max(farthest_px.abs()) + lens.greatest_astigmatism_px()),
        }
    }

    /// Binds what all passes read that look for partial occlusion.
    fn of_visible_depth<'f, 'g>(&self, pass: Pass<'f, 'g>) -> Pass<'f, 'g> {
        pass.uniform("lens", &self.lens)
            .uniform("sprites", &self.sprites)
            .uniform("params", &self.params)
            .texture("visible_depth", &self.visible.depth)
    }

    /// Equation (4): z below which hidden surfaces are accepted, -1 where none is.
    fn hidden_limit(&self, frame: &mut Frame<'_>) -> Texture {
        let size = self.visible.depth.size();
        let limit = frame.texture(HIDDEN_LIMIT, size, wgpu::TextureFormat::R32Float);
        let pass = frame.pass(&SHADER, "find_hidden_limit").texture("behind_z", &limit);
        self.of_visible_depth(pass).dispatch(size);
        frame.expose(HIDDEN_LIMIT, &limit);
        limit
    }

    /// Which of 2x2 pixels are spread as one, as four, or (between the two) both.
    fn choose_arrays(&self, frame: &mut Frame<'_>) -> Texture {
        let outer = self.visible.depth.size();
        let blocks = UVec2::new(outer.x.div_ceil(2), outer.y.div_ceil(2));
        let arrays = frame.texture("sprite arrays", blocks, wgpu::TextureFormat::R32Uint);
        let pass = frame.pass(&SHADER, "choose_arrays").texture("chosen_arrays", &arrays);
        self.of_visible_depth(pass).dispatch(blocks);
        arrays
    }

    /// L0, L1 and L2.
    fn splat_visible(&self, frame: &mut Frame<'_>, arrays: Option<&Texture>) -> [Texture; 3] {
        match self.by_sprites {
            true => self.draw_visible(frame, arrays),
            false => self.gather_visible(frame, arrays),
        }
    }

    /// M1 and M2.
    fn splat_hidden(&self, frame: &mut Frame<'_>, hidden: &Layer) -> [Texture; 2] {
        match self.by_sprites {
            true => self.draw_hidden(frame, hidden),
            false => self.gather_hidden(frame, hidden),
        }
    }

    fn compose(&self, frame: &mut Frame<'_>, layers: &[Texture; 3], hidden: Option<&[Texture; 2]>) -> Texture {
        let [front, same, behind] = layers;
        for (name, layer) in [("L0: in front", front), ("L1: at", same), ("L2: behind", behind)] {
            frame.expose(name, layer);
        }
        if frame.keeps_intermediates() {
            let explained = frame.texture(EXPLAINED, self.size, wgpu::TextureFormat::Rgba16Float);
            frame
                .pass(&SHADER, "explain_layers")
                .texture("explained", &explained)
                .texture("layer_front", front)
                .texture("layer_same", same)
                .texture("layer_behind", behind)
                .dispatch(self.size);
            frame.expose(EXPLAINED, &explained);
        }
        let result = frame.color_texture("splat", self.size);
        let pass = match hidden {
            None => frame.pass(&SHADER, "compose_visible"),
            Some([hidden_same, hidden_behind]) => {
                frame.expose("M1: hidden, at", hidden_same);
                frame.expose("M2: hidden, behind", hidden_behind);
                let pass = frame
                    .pass(&SHADER, "compose_with_hidden")
                    .uniform("lens", &self.lens)
                    .uniform("sprites", &self.sprites)
                    .texture("visible_depth", &self.visible.depth);
                pass.texture("hidden_same", hidden_same).texture("hidden_behind", hidden_behind)
            }
        };
        pass.uniform("params", &self.params)
            .texture("result", &result)
            .texture("layer_front", front)
            .texture("layer_same", same)
            .texture("layer_behind", behind)
            .dispatch(self.size);
        result
    }
}
