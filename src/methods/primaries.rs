//! Three lenses, one picture: the chromatic aberration of the eye.
//!
//! Each of the display's primaries is seen through a lens of its own
//! ([`Lens::primaries`](crate::lens::Lens::primaries)), and the picture has red from the first,
//! green from the second and blue from the third: Cholewiak et al., "ChromaBlur: Rendering
//! Chromatic Eye Aberration Improves Accommodation and Realism" (SIGGRAPH Asia 2017). It holds
//! for every method, since all take a view and a lens; the view is drawn once for all three.

use super::{Converging, Method, MethodError, record_through};
use crate::gpu::{Frame, Shader, Texture};
use crate::image::ColorImage;
use crate::lens::Lens;
use crate::shader;
use crate::view::View;
use glam::Vec3;

const SHADER: Shader = shader!("primaries");

/// Summed in 32 bits, references have that many.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Names of the primaries, as passes are labelled.
const NAMES: [&str; 3] = ["red", "green", "blue"];

/// Records `method` through each of the three lenses. What it exposes is that of green.
pub(super) fn record_all(
    method: &dyn Method,
    frame: &mut Frame<'_>,
    view: &mut View,
    lenses: &[Lens; 3],
) -> Result<Texture, MethodError> {
    let id = method.about().id;
    let kept = frame.keeps_intermediates().then(|| frame.take_intermediates());
    let mut through = |frame: &mut Frame<'_>, primary: usize| {
        frame.set_prefix(format!("{id}/{}/", NAMES[primary]));
        record_through(method, frame, view, &lenses[primary])
    };
    let (red, blue) = (through(frame, 0)?, through(frame, 2)?);
    if let Some(kept) = &kept {
        frame.keep_intermediates();
        kept.iter().for_each(|(name, texture)| frame.expose(name, texture));
    }
    let green = through(frame, 1)?;
    frame.set_prefix(format!("{id}/"));
    Ok(combined(frame, [&red, &green, &blue]))
}

/// Red of the first, green of the second and blue of the third.
fn combined(frame: &mut Frame<'_>, [red, green, blue]: [&Texture; 3]) -> Texture {
    let result = frame.texture("primaries", green.size(), FORMAT);
    frame
        .pass(&SHADER, "one_of_each")
        .texture("red", red)
        .texture("green", green)
        .texture("blue", blue)
        .texture("result", &result)
        .dispatch(result.size());
    result
}

/// The same of images on the CPU.
pub fn combined_images([red, green, blue]: [&ColorImage; 3]) -> ColorImage {
    let pixel = |i: usize| Vec3::new(red.pixels[i].x, green.pixels[i].y, blue.pixels[i].z);
    ColorImage { size: green.size, pixels: (0..green.pixels.len()).map(pixel).collect() }
}

/// A run of `method` for pictures through `lens`, where it gets better over many frames, and
/// how many frames there are to be: [`Method::converging`], for each primary where the lens
/// has chromatic aberration.
pub fn converging(method: &dyn Method, lens: &Lens) -> Option<(Box<dyn Converging>, u32)> {
    let (run, samples) = method.converging()?;
    if lens.primaries().is_none() {
        return Some((run, samples));
    }
    let another = || method.converging().map(|(run, _)| run);
    Some((Box::new(ThreeRuns { runs: [run, another()?, another()?] }), samples))
}

/// Three pictures that converge side by side.
struct ThreeRuns {
    runs: [Box<dyn Converging>; 3],
}

impl Converging for ThreeRuns {
    fn count(&self) -> u32 {
        self.runs[0].count()
    }

    fn advance(&mut self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, n: u32) -> Result<(), MethodError> {
        let lenses = lens.primaries().unwrap_or_else(|| std::array::from_fn(|_| lens.clone()));
        self.runs.iter_mut().zip(&lenses).try_for_each(|(run, lens)| run.advance(frame, view, lens, n))
    }

    fn mean(&self, frame: &mut Frame<'_>) -> Texture {
        let means: Vec<Texture> = self.runs.iter().map(|run| run.mean(frame)).collect();
        combined(frame, [&means[0], &means[1], &means[2]])
    }
}
