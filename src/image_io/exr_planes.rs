//! OpenEXR files as named float planes, multi-part files included.

use super::{ImageError, check_size};
use crate::image::{ColorImage, Image};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Layer, LayerAttributes, ReadChannels, ReadLayers,
    WritableImage,
};
use glam::{IVec2, UVec2, Vec3};
use std::fmt::Write as _;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};

/// Bit of the version field that marks files with deep parts (OpenEXR file layout).
const DEEP_FLAG: u32 = 1 << 11;

/// All channels of a file, as floats.
pub struct ExrPlanes {
    file: PathBuf,
    parts: Vec<Part>,
}

/// One part (layer) of a file: channels over one data window.
struct Part {
    name: String,
    view: String,
    window: Window,
    channels: Vec<(String, Vec<f32>)>,
}

/// Where a part lies in the display window, px.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Top left pixel.
    pub origin: IVec2,
    /// Width and height.
    pub size: UVec2,
}

/// Which part colour came from, so that depth can be taken from the same view.
pub struct ColorPart {
    index: usize,
    /// Its data window.
    pub window: Window,
}

impl ExrPlanes {
    /// Reads every channel of every part.
    ///
    /// # Errors
    ///
    /// Deep files, damaged ones and absurd sizes.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        check_header(path)?;
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_file(path)
            .map_err(|e| ImageError::Undecodable { file: path.to_owned(), detail: e.to_string() })?;
        let parts = image.layer_data.into_iter().map(Part::new).collect();
        Ok(Self { file: path.to_owned(), parts })
    }

    /// The first part with R, G and B (or, failing that, the first with luminance Y alone).
    ///
    /// # Errors
    ///
    /// [`ImageError::MissingChannel`].
    pub fn color(&self) -> Result<(ColorImage, ColorPart), ImageError> {
        for names in [["R", "G", "B"], ["Y", "Y", "Y"]] {
            for (index, part) in self.parts.iter().enumerate() {
                if let [Some(r), Some(g), Some(b)] = names.map(|name| part.channel(name)) {
                    let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect();
                    let image = Image { size: part.window.size, pixels };
                    return Ok((image, ColorPart { index, window: part.window }));
                }
            }
        }
        Err(self.missing("colour channels R, G, B", "choose a file with colour"))
    }

    /// The Z channel that belongs to a colour part: of that part itself, else of a part of
    /// the same view, else of the first part that has one.
    ///
    /// # Errors
    ///
    /// [`ImageError::MissingChannel`].
    pub fn depth_beside(&self, color: &ColorPart) -> Result<(Image<f32>, Window), ImageError> {
        let own = &self.parts[color.index];
        let same_view = self.parts.iter().filter(|part| part.view == own.view || part.window == own.window);
        let mut candidates = std::iter::once(own).chain(same_view).chain(&self.parts);
        candidates
            .find_map(|part| part.plane("Z"))
            .ok_or_else(|| self.missing("depth channel Z", "give the depth in a file of its own, with --depth FILE"))
    }

    /// The depth of a file that is nothing but depth: Z, or else a single channel.
    ///
    /// # Errors
    ///
    /// [`ImageError::MissingChannel`].
    pub fn depth_alone(&self) -> Result<(Image<f32>, Window), ImageError> {
        let z = self.parts.iter().find_map(|part| part.plane("Z"));
        let single = || match &self.parts[..] {
            [part] if part.channels.len() == 1 => part.plane(&part.channels[0].0),
            _ => None,
        };
        z.or_else(single)
            .ok_or_else(|| self.missing("depth channel Z", "choose a file with a channel Z or with a single channel"))
    }

    fn missing(&self, wanted: &'static str, remedy: &'static str) -> ImageError {
        let mut found = String::new();
        for part in &self.parts {
            for (name, _) in &part.channels {
                let separator = if found.is_empty() { "" } else { ", " };
                let prefix = if part.name.is_empty() { String::new() } else { format!("{}:", part.name) };
                // Writing to a string cannot fail.
                let _ = write!(found, "{separator}{prefix}{name}");
            }
        }
        ImageError::MissingChannel { file: self.file.clone(), wanted, found, remedy }
    }
}

impl Part {
    fn new(layer: Layer<AnyChannels<FlatSamples>>) -> Self {
        let text = |text: Option<exr::prelude::Text>| text.map(|text| text.to_string()).unwrap_or_default();
        let position = layer.attributes.layer_position;
        let window = Window {
            origin: IVec2::new(position.0, position.1),
            size: UVec2::new(layer.size.0 as u32, layer.size.1 as u32),
        };
        let channels = layer.channel_data.list.into_iter();
        let channels =
            channels.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect::<Vec<_>>())).collect();
        Self { name: text(layer.attributes.layer_name), view: text(layer.attributes.view_name), window, channels }
    }

    /// A channel by its name, or by the last component of a layered name (`beauty.R`).
    /// Subsampled channels, shorter than the window, do not count.
    fn channel(&self, name: &str) -> Option<&[f32]> {
        let plain = self.channels.iter().find(|(own, _)| own == name);
        let layered = || self.channels.iter().find(|(own, _)| own.rsplit('.').next() == Some(name));
        let (_, values) = plain.or_else(layered)?;
        (values.len() == self.window.size.x as usize * self.window.size.y as usize).then_some(values)
    }

    fn plane(&self, name: &str) -> Option<(Image<f32>, Window)> {
        let pixels = self.channel(name)?.to_vec();
        Some((Image { size: self.window.size, pixels }, self.window))
    }
}

/// Refuses deep files and absurd sizes before anything is allocated for them.
fn check_header(path: &Path) -> Result<(), ImageError> {
    let mut start = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(8).read_to_end(&mut start))
        .map_err(|source| ImageError::Unreadable { file: path.to_owned(), source })?;
    let flags = start.get(4..8).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes);
    if flags & DEEP_FLAG != 0 {
        return Err(ImageError::Deep { file: path.to_owned() });
    }
    let meta = exr::meta::MetaData::read_from_file(path, false)
        .map_err(|e| ImageError::Undecodable { file: path.to_owned(), detail: e.to_string() })?;
    let channel_count = meta.headers.iter().map(|header| header.channels.list.len() as u64).max().unwrap_or(1);
    for header in &meta.headers {
        let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
        check_size(path, width, height)?;
        // The limit on pixels is one on planes of four channels; many-channelled files
        // may have as many samples, not as many pixels.
        check_size(path, width, height.saturating_mul(channel_count.div_ceil(4))).map_err(|_| ImageError::Size {
            file: path.to_owned(),
            width,
            height,
        })?;
    }
    Ok(())
}

/// Encodes named float planes of one size as a single-part EXR, losslessly compressed.
pub(super) fn encode(
    target: &mut impl Write,
    size: UVec2,
    planes: Vec<(&'static str, Vec<f32>)>,
) -> std::io::Result<()> {
    let channels = planes.into_iter().map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values))).collect();
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::FAST_LOSSLESS };
    let layer = Layer::new(
        (size.x as usize, size.y as usize),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(channels),
    );
    // The encoder seeks back to fill in its offset table: in memory, then to the file.
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(std::io::Error::other)?;
    target.write_all(bytes.get_ref())
}
