//! True views from four points of the lens: what rays near them hit needs no guess.

use super::AdaptiveUniform;
use crate::gpu::{Frame, Shader, Texture, TextureKey};
use crate::lens::Lens;
use crate::view::{Layer, View, ViewError, copy_to_array_layer};
use crate::{shader, uniform};
use glam::{UVec2, dvec2};

const SHADER: Shader = shader!("methods/adaptive_views");

/// Distance of a view from the lens's centre, lens radii: with the centre, each then serves
/// the lens points up to about half a radius around it.
pub(super) const DISTANCE: f64 = 0.68;

uniform! {
    struct Bounds {
        nearest_s: f32,
        farthest_s: f32,
    }
}

/// Four views, or none.
#[derive(Clone)]
pub(super) struct Views {
    /// Signed CoC radii, px, one component a view.
    pub radii: Texture,
    /// Colours, one array layer a view.
    pub colors: Texture,
    /// The lens they belong to.
    lens: Lens,
}

impl Views {
    /// Stand-ins that no ray reads.
    pub fn none(frame: &mut Frame<'_>, lens: &Lens) -> Self {
        let format = wgpu::TextureFormat::Rgba16Float;
        let key = TextureKey { size: UVec2::ONE, levels: 1, layers: 2, format };
        let radii = frame.texture("no views", UVec2::ONE, format);
        Self { radii, colors: frame.gpu().texture_of("no views", key), lens: lens.clone() }
    }

    /// Draws them, unless that was done since view or lens last changed.
    pub fn draw(
        frame: &mut Frame<'_>,
        view: &mut View,
        lens: &Lens,
        adaptive: &AdaptiveUniform,
    ) -> Result<Self, ViewError> {
        let known: Vec<Self> = view.kept().take().unwrap_or_default();
        // The three primaries of a chromatic eye have views of their own.
        let all = lens.of_all_primaries();
        let mut known: Vec<Self> = known.into_iter().filter(|views| views.lens.of_all_primaries() == all).collect();
        let found = known.iter().find(|views| views.lens == *lens).cloned();
        if let Some(views) = found {
            frame.skip("off-centre views unchanged");
            *view.kept() = Some(known);
            return Ok(views);
        }
        let (size, format) = (view.size(), wgpu::TextureFormat::Rgba16Float);
        let key = TextureKey { size, levels: 1, layers: 4, format };
        let colors = frame.gpu().texture_of("off-centre views", key);
        let along = f64::from(adaptive.view_distance);
        let layers: Vec<Layer> = (0..)
            .zip([(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)])
            .map(|(index, (x, y))| view.from_lens_point(frame, lens, along * dvec2(x, y), index, false))
            .collect::<Result<_, _>>()?;
        for (index, layer) in (0..).zip(&layers) {
            copy_to_array_layer(frame, &layer.color, &colors, index);
        }
        let radii = frame.texture("radii of off-centre views", size, format);
        let bounds = Bounds { nearest_s: adaptive.nearest_s, farthest_s: adaptive.farthest_s };
        frame
            .pass(&SHADER, "pack_views")
            .uniform("lens", &view.lens_uniform(lens))
            .uniform("bounds", &bounds)
            .texture("depth_0", &layers[0].depth)
            .texture("depth_1", &layers[1].depth)
            .texture("depth_2", &layers[2].depth)
            .texture("depth_3", &layers[3].depth)
            .texture("radii", &radii)
            .dispatch(size);
        let views = Self { radii, colors, lens: lens.clone() };
        known.push(views.clone());
        *view.kept() = Some(known);
        Ok(views)
    }
}
