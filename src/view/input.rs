//! Where tones that are mapped or cut before the blur enter a view: [`Input`].

use super::tone::{Input, Tone};
use super::{Layer, Source, View};
use crate::display::LUMINANCE;
use crate::gpu::{Gpu, download, upload};
use crate::image::ColorImage;
use glam::{UVec2, Vec3};

/// Added to luminances before their logarithm, so that a black pixel is one among others:
/// equation (1)'s delta.
const DARKEST: f64 = 1e-4;

/// Log-average luminance, Reinhard's equation (1).
fn log_average(image: &ColorImage) -> f64 {
    let log = |color: &Vec3| (DARKEST + f64::from(color.dot(LUMINANCE).max(0.0))).ln();
    (image.pixels.iter().map(log).sum::<f64>() / image.pixels.len().max(1) as f64).exp()
}

impl View {
    /// Gives methods `input` from now on and returns what becomes of a colour. Forgets what was
    /// drawn if that changes anything. [`Input::Reinhard`] waits for the pinhole image.
    pub fn set_input(&mut self, gpu: &Gpu, input: Input) -> Tone {
        let tone = match input {
            Input::Hdr => Tone::Linear,
            Input::Clamped { white } => Tone::Clamped(white),
            Input::Reinhard { key } => {
                self.set_tone(gpu, Tone::Linear);
                let mut frame = gpu.frame();
                let outer = self.pinhole(&mut frame).color;
                frame.finish();
                let inner = download(gpu, &outer).crop(UVec2::splat(self.projection.overscan_px), self.size());
                Tone::Reinhard((f64::from(key) / log_average(&inner)) as f32)
            }
        };
        self.set_tone(gpu, tone);
        tone
    }

    /// What becomes of a colour before it is blurred.
    pub fn tone(&self) -> Tone {
        self.tone
    }

    fn set_tone(&mut self, gpu: &Gpu, tone: Tone) {
        if self.tone == tone {
            return;
        }
        self.tone = tone;
        match &mut self.source {
            Source::Scene(source) => source.tone = tone,
            Source::Image(layer) => {
                let linear = self.linear_image.get_or_insert_with(|| layer.color.clone());
                let toned = match tone {
                    Tone::Linear => linear.clone(),
                    _ => upload(gpu, "image", &download(gpu, linear).map(|color| tone.apply(color))),
                };
                *layer = Layer { color: toned, depth: layer.depth.clone() };
            }
        }
        self.forget();
    }
}
