//! What the textures hold that a method makes on its way, as a display shows them.

use super::StudyError;
use defocus::display::Display;
use defocus::gpu::{Gpu, Texture, download_rgba8};
use defocus::image::Image;
use defocus::lens::Lens;
use defocus::methods::{self, Method, Quantity};
use defocus::present::{Numbers, Slice, slice_picture};
use defocus::view::View;

/// A picture, or a channel of numbers, of an intermediate texture.
#[derive(Clone, Debug)]
pub struct InsideImage {
    /// The texture's name; several may have the same.
    pub texture: String,
    /// The texture's place in the order in which they were made, from 0.
    pub index: usize,
    /// Array layer, where there are several.
    pub layer: Option<u32>,
    /// Channel, where there are several with numbers.
    pub channel: Option<u32>,
    /// What the numbers are, with the stored values at the ends of the colours; `None` for
    /// a picture.
    pub numbers: Option<(Quantity, [f32; 2])>,
    /// sRGB-encoded, as large as the texture.
    pub image: Image<[u8; 3]>,
}

/// Renders `view` through `lens` with `method` and shows each texture that it exposes: all
/// layers and channels of its finest level. `display` is that of the pictures among them.
///
/// # Errors
///
/// What the method says.
pub fn look_inside(
    gpu: &Gpu,
    view: &mut View,
    lens: &Lens,
    method: &dyn Method,
    display: &Display,
) -> Result<Vec<InsideImage>, StudyError> {
    let mut frame = gpu.frame();
    frame.keep_intermediates();
    methods::record(method, &mut frame, view, lens)
        .map_err(|source| StudyError::Method { method: method.about().id, source })?;
    let mut images = Vec::new();
    for (index, (name, texture)) in frame.finish().exposed.iter().enumerate() {
        let quantities = methods::meaning(method, name).channels(texture.format().components());
        for layer in 0..texture.layers() {
            let slice = Slice { texture, level: 0, layer };
            let mut add = |channel, numbers, shown: &Texture| {
                let image = download_rgba8(gpu, shown).map(|[r, g, b, _]| [r, g, b]);
                let layer = (texture.layers() > 1).then_some(layer);
                images.push(InsideImage { texture: name.clone(), index, layer, channel, numbers, image });
            };
            if quantities.is_empty() {
                let mut frame = gpu.frame();
                let shown = slice_picture(&mut frame, slice, display);
                frame.finish();
                add(None, None, &shown);
            }
            for (channel, quantity) in (0..).zip(&quantities) {
                let mut frame = gpu.frame();
                let numbers = Numbers::on(&mut frame, slice, channel, quantity.scale);
                let shown = numbers.alone(&mut frame);
                frame.finish();
                let channel = (quantities.len() > 1).then_some(channel);
                add(channel, Some((quantity.clone(), numbers.ends)), &shown);
            }
        }
    }
    Ok(images)
}
