//! `lens-layers`: lens rays through depth-peeled layers.
//!
//! Lee, Eisemann and Seidel, "Real-Time Lens Blur Effects and Focus Control" (SIGGRAPH 2010),
//! as far as public text tells:
//!
//! 1. the scene is peeled into layers behind one another, without the parts that no lens ray
//!    reaches;
//! 2. each pixel traces rays from points of the lens, from near to far, through the layers as
//!    height fields, which colours are read from where a ray meets one;
//! 3. the depths that a ray can meet are bounded beforehand, so that it searches no others.
//!
//! [`Adaptive`](super::Adaptive) descends from it, and this is what it was before: no classes of
//! tiles beyond "in focus", no filter of what rays found, no light apart. What it gains is what the
//! rest brings.
//!
//! Where this differs: layers are not drawn where no lens ray can pass the edge of what is before
//! them, tile by tile ([`View::peeled`]; the paper tests each fragment against the shadow of the
//! layer before it); bounds come from a pyramid (the paper: N-buffers); the lens is a thin one (the
//! paper's rays also bend as those of lenses with aberrations do).

use super::sheet_rays::SheetRays;
use super::tile_lists::{self, DEFOCUSED, FocusMap, Reach};
use super::{About, Apertures, IN_FOCUS_COC_PX, Meaning, Method, MethodError, Param, Quantity, Scale};
use crate::gpu::{Buffer, Frame, Gpu, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{PeelOrder, Peeled, View};
use crate::{shader, uniform};
use glam::{DVec2, Vec2};

const SHADER: Shader = shader!("methods/lens_layers");

/// How lens points differ between pixels.
const JITTERS: &[&str] = &["sets", "off"];

/// Sets of lens points, where each pixel has one of them.
const SETS: u32 = 16;

/// Most layers.
const MAX_LAYERS: u32 = 4;

/// Most lens points a pixel.
const MAX_SAMPLES: u32 = 1024;

/// Rays through layers, with the paper's choices as parameters.
#[derive(Clone, Debug)]
pub struct LensLayers {
    /// Lens points a pixel.
    pub samples: u32,
    /// Layers, 1 to 4.
    pub layers: u32,
    /// Index among the choices of the parameter of this name.
    pub jitter: usize,
}

impl Default for LensLayers {
    fn default() -> Self {
        Self { samples: 16, layers: MAX_LAYERS, jitter: 0 }
    }
}

uniform! {
    struct Params {
        size: [u32; 2],
        overscan: u32,
        layers: u32,
        samples: u32,
        sets: u32,
        lens_radius: f32,
        levels: u32,
    }
}

impl Method for LensLayers {
    fn about(&self) -> About {
        About {
            id: "lens-layers",
            title: "Lens rays through layers",
            paper: "Lee, Eisemann and Seidel, Real-Time Lens Blur Effects and Focus Control, SIGGRAPH 2010",
            summary: "Peels the scene into layers and traces a few lens rays a pixel through them.",
            limits: "As noisy as its rays are few, most so around bright lights. Four solid surfaces behind one another, and four sheets of glass, smoke or soft leaves; what an image hides is guessed from what lies beside it.",
            apertures: Apertures::Any,
            astigmatism: false,
            needs_scene: false,
            conserves_energy: false,
            averages: true,
            samples_lens: true,
        }
    }

    fn params(&mut self) -> Vec<Param<'_>> {
        vec![
            Param::int("samples", "Lens rays", "", &mut self.samples, (1, MAX_SAMPLES), "Lens rays a pixel.")
                .trading(&["8", "16", "32", "64", "128"]),
            Param::int(
                "layers",
                "Layers",
                "",
                &mut self.layers,
                (1, MAX_LAYERS),
                "Surfaces behind one another. 1: nothing that the pinhole image hides.",
            ),
            Param::choice(
                "jitter",
                "Jitter",
                &mut self.jitter,
                JITTERS,
                "Lens points of a pixel. sets: one of 16 sets. off: all pixels alike.",
            ),
        ]
    }

    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError> {
        let order = PeelOrder {
            count: self.layers,
            fineness: 1,
            draws: 1,
            lights: false,
            separation: view.layer_separation(lens),
        };
        let peeled = view.peeled(frame, &order)?;
        let sets = if JITTERS[self.jitter] == "sets" { SETS } else { 1 };
        let key = (lens.aperture.clone(), self.samples, sets);
        let gpu = frame.gpu();
        let points = gpu.memo().get(&key, || LensPoints::new(gpu, lens, self.samples, sets)).0.clone();
        let pinhole = view.pinhole(frame);
        let result = frame.color_texture("lens-layers", view.size());
        let reach_per_coc = 0.5 * lens.aperture.radius();
        let sheets = SheetRays::of(frame, view, lens);
        // Sheets may be blurred where all else is in focus.
        let in_focus_coc_px = if sheets.any { -1.0 } else { IN_FOCUS_COC_PX };
        let blur = Reach { in_focus_coc_px, per_coc: reach_per_coc, more_coc_px: 0.0 };
        let tiles = FocusMap::new(frame, view, lens, blur).tiles(frame, view);
        tiles.copy_in_focus(frame, &pinhole.color, view.overscan_px(), &result);
        let bounds = Bounds::of(frame, view, lens, &peeled, [self.samples, sets]);
        let pass = frame
            .pass(&SHADER, "trace_tiles")
            .uniform("lens", &view.lens_uniform(lens))
            .uniform("params", &bounds.params)
            .texture("first_color", &peeled.samples.color)
            .texture("colors", &peeled.color)
            .texture("radii", &bounds.radii)
            .texture("bounds", &bounds.pyramid)
            .buffer("lens_points", &points)
            .texture("result", &result);
        tiles.dispatch(sheets.bind(pass), DEFOCUSED);
        tiles.expose(frame);
        Ok(result)
    }

    fn explains(&self) -> &'static [&'static str] {
        &[RADII, tile_lists::SKIPPED]
    }

    fn meaning(&self, name: &str) -> Meaning {
        let radius = |name| Quantity::new(name, " px", Scale::Signed);
        match name {
            RADII => Meaning::numbers([
                radius("CoC radius, layer 1"),
                radius("layer 2"),
                radius("layer 3"),
                radius("layer 4"),
            ]),
            tile_lists::SKIPPED => tile_lists::meaning(&TILE_CLASSES),
            _ => Meaning::Picture,
        }
    }

    fn boxed(&self) -> Box<dyn Method> {
        Box::new(self.clone())
    }
}

/// Name under which the CoC radii of the layers are exposed.
const RADII: &str = "CoC radii of the layers";

/// Classes of tiles, [`tile_lists::IN_FOCUS`] and [`DEFOCUSED`].
const TILE_CLASSES: [(f32, &str); 2] = [(0.0, "in focus: copied, no rays"), (1.0, "traced")];

/// Lens points of all sets.
struct LensPoints(Buffer);

impl LensPoints {
    fn new(gpu: &Gpu, lens: &Lens, samples: u32, sets: u32) -> Self {
        let points = lens.aperture.lens_point_sets(samples, sets);
        let points: Vec<Vec2> = points.into_iter().map(DVec2::as_vec2).collect();
        Self(gpu.buffer_of("lens points", &points))
    }
}

/// CoC radii of the layers, and the least and greatest in squares of them.
struct Bounds {
    params: Params,
    radii: Texture,
    pyramid: Texture,
}

impl Bounds {
    fn of(frame: &mut Frame<'_>, view: &View, lens: &Lens, peeled: &Peeled, [samples, sets]: [u32; 2]) -> Self {
        let size = view.projection().outer_size();
        let levels = size.max_element().next_power_of_two().ilog2() + 1;
        let format = wgpu::TextureFormat::Rgba32Float;
        let params = Params {
            size: size.to_array(),
            overscan: view.overscan_px(),
            layers: peeled.layers,
            samples,
            sets,
            lens_radius: lens.aperture.radius() as f32,
            levels,
        };
        let radii = frame.texture(RADII, size, format);
        // Sides of a power of two: each level has half the squares of the one before it.
        let padded = size.map(u32::next_power_of_two);
        let pyramid =
            frame.gpu().texture_of("bounds of CoC radii", TextureKey { size: padded, levels, layers: 1, format });
        frame
            .pass(&SHADER, "measure")
            .uniform("lens", &view.lens_uniform(lens))
            .uniform("params", &params)
            .texture("depth", &peeled.depth)
            .texture("new_radii", &radii)
            .level("new_bounds", &pyramid, 0)
            .dispatch(size);
        for level in 1..levels {
            frame
                .pass(&SHADER, "widen")
                .level("finer", &pyramid, level - 1)
                .level("new_bounds", &pyramid, level)
                .dispatch(pyramid.level_size(level));
        }
        frame.expose(RADII, &radii);
        Self { params, radii, pyramid }
    }
}
