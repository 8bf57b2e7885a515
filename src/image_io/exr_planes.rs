//! OpenEXR files as named float planes, multi-part files included.

use super::error::{ImageError, check_size, check_size_to_read};
use super::exr_layers::{self, Layer};
use super::primaries;
use crate::image::{ColorImage, Image};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, LayerAttributes, ReadChannels, ReadLayers,
    WritableImage,
};
use glam::{IVec2, Mat3, UVec2, Vec3};
use std::fmt::Write as _;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};

/// Bit of the version field that marks files with deep parts (OpenEXR file layout).
const DEEP_FLAG: u32 = 1 << 11;

/// All channels of a file, as floats.
pub struct ExrPlanes {
    file: PathBuf,
    parts: Vec<Part>,
    layers: Vec<Layer>,
    /// From the file's primaries to linear Rec. 709, where they differ.
    rec709_from_file: Option<Mat3>,
    /// Weights of the file's red, green and blue in luminance.
    luminance: Vec3,
}

/// One part of a file: channels over one data window.
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

/// Which layer colour came from, so that depth can be taken from the same view.
pub struct ColorPart {
    layer: Layer,
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
        let rec709_from_file = image.attributes.chromaticities.and_then(|c| primaries::rec709_from(&c));
        let luminance = image.attributes.chromaticities.map_or(primaries::LUMINANCE, |c| primaries::luminance(&c));
        let parts: Vec<Part> = image.layer_data.into_iter().map(Part::new).collect();
        // Subsampled channels, shorter than the window, do not count.
        let whole = |part: &Part, values: &[f32]| values.len() == part.window.pixels();
        let names = parts.iter().map(|part| {
            let channels = part.channels.iter().map(|(name, values)| if whole(part, values) { name } else { "" });
            (part.name.as_str(), part.view.as_str(), channels.collect())
        });
        let layers = Layer::all(names);
        Ok(Self { file: path.to_owned(), parts, layers, rec709_from_file, luminance })
    }

    /// The picture: the layer called `layer`, or the one that is the picture by its name
    /// (no name, Combined, beauty, rgba ...), or the only one that can be. Luminance alone
    /// makes a grey picture.
    ///
    /// # Errors
    ///
    /// [`ImageError::MissingChannel`], [`ImageError::NoSuchLayer`],
    /// [`ImageError::UnclearLayer`].
    pub fn color(&self, layer: Option<&str>) -> Result<(ColorImage, ColorPart), ImageError> {
        let ranked = |layer: &'_ Layer| layer.color_rank();
        let chosen = match layer {
            Some(name) => self.called(name, "--layer")?,
            None => exr_layers::best(self.layers.iter().filter_map(|layer| Some((ranked(layer)?, layer, ()))))
                .map(|(layer, ())| layer)
                .map_err(|equal| {
                    self.not_clear(&equal, "picture", "--layer", "colour channels R, G, B", COLOR_REMEDY)
                })?,
        };
        let part = &self.parts[chosen.part];
        let plane = |component: &str| chosen.channels.get(component).map(|&index| part.channels[index].1.as_slice());
        let planes = [["r", "g", "b"], ["y", "ry", "by"], ["y"; 3]].into_iter().find_map(|names| {
            let [Some(a), Some(b), Some(c)] = names.map(plane) else { return None };
            Some((names[1] == "ry", [a, b, c]))
        });
        let single = || chosen.channels.values().next().map(|&index| (false, [part.channels[index].1.as_slice(); 3]));
        let single = || single().filter(|_| chosen.channels.len() == 1);
        let (is_chroma, [r, g, b]) =
            planes.or_else(single).ok_or_else(|| self.missing("colour channels R, G, B", COLOR_REMEDY))?;
        let pixel = |((&r, &g), &b): ((&f32, &f32), &f32)| {
            let rgb =
                if is_chroma { primaries::rgb_from_luminance(r, g, b, self.luminance) } else { Vec3::new(r, g, b) };
            self.rec709_from_file.map_or(rgb, |matrix| matrix * rgb)
        };
        let pixels = r.iter().zip(g).zip(b).map(pixel).collect();
        let image = Image { size: part.window.size, pixels };
        Ok((image, ColorPart { layer: chosen.clone(), window: part.window }))
    }

    /// The depth that belongs to a picture: the layer or channel called `layer`, or the one
    /// that is depth by its name, of the same view and enclosing layer where several are.
    ///
    /// # Errors
    ///
    /// Those of [`ExrPlanes::color`].
    pub fn depth_beside(&self, color: &ColorPart, layer: Option<&str>) -> Result<(Image<f32>, Window), ImageError> {
        if let Some(name) = layer {
            return self.depth_called(name);
        }
        let mut found: Vec<(u8, &Layer, Vec<usize>)> =
            self.layers.iter().filter_map(|layer| layer.depth().map(|(rank, found)| (rank, layer, found))).collect();
        let closest = found.iter().map(|(_, layer, _)| layer.kinship(&color.layer)).max();
        let of_the_picture = |(_, layer, _): &(u8, &Layer, Vec<usize>)| Some(layer.kinship(&color.layer)) == closest;
        // A better name counts for more than a closer place.
        let least = found.iter().map(|(rank, ..)| *rank).min();
        found.retain(|(rank, ..)| Some(*rank) == least);
        if found.iter().any(of_the_picture) {
            found.retain(of_the_picture);
        }
        self.one_depth(
            found,
            "give the depth in a file of its own, with --depth FILE, or name a layer with --depth-layer",
        )
    }

    /// The depth of a file that is nothing but depth: what is depth by its name, a single
    /// channel, or three equal ones.
    ///
    /// # Errors
    ///
    /// Those of [`ExrPlanes::color`].
    pub fn depth_alone(&self, layer: Option<&str>) -> Result<(Image<f32>, Window), ImageError> {
        if let Some(name) = layer {
            return self.depth_called(name);
        }
        let by_name: Vec<_> =
            self.layers.iter().filter_map(|layer| layer.depth().map(|(rank, found)| (rank, layer, found))).collect();
        if by_name.is_empty()
            && let [layer] = &self.layers[..]
            && let Some(found) = layer.only_values()
        {
            return self.equal_planes(layer, &found).ok_or_else(|| {
                let remedy = "its channels differ: choose a file with a channel Z or with a single channel, or name one with --depth-layer";
                self.missing("depth channel Z", remedy)
            });
        }
        self.one_depth(
            by_name,
            "choose a file with a channel Z or with a single channel, or name one with --depth-layer",
        )
    }

    fn one_depth(
        &self,
        ranked: Vec<(u8, &Layer, Vec<usize>)>,
        remedy: &'static str,
    ) -> Result<(Image<f32>, Window), ImageError> {
        let (layer, found) = exr_layers::best(ranked.into_iter())
            .map_err(|equal| self.not_clear(&equal, "depth", "--depth-layer", "depth channel Z", remedy))?;
        self.equal_planes(layer, &found)
            .ok_or_else(|| self.missing("single depth", "its depth has channels that differ"))
    }

    /// A layer or a single channel by its name.
    fn depth_called(&self, name: &str) -> Result<(Image<f32>, Window), ImageError> {
        for (part, own) in self.parts.iter().enumerate() {
            let full = |channel: &str| format!("{}.{channel}", own.name).to_lowercase();
            let is_it = |channel: &str| channel.eq_ignore_ascii_case(name) || full(channel) == name.to_lowercase();
            if let Some(index) = own.channels.iter().position(|(channel, _)| is_it(channel))
                && let Some(found) = self.plane(part, index)
            {
                return Ok(found);
            }
        }
        let layer = self.called(name, "--depth-layer")?;
        let found = layer.depth().map(|(_, found)| found).unwrap_or_else(|| layer.channels.values().copied().collect());
        self.equal_planes(layer, &found).ok_or_else(|| {
            let remedy = "the channels of that layer differ: name one of them with --depth-layer, such as LAYER.Z";
            self.missing("single depth", remedy)
        })
    }

    fn called(&self, name: &str, option: &'static str) -> Result<&Layer, ImageError> {
        let found: Vec<&Layer> = self.layers.iter().filter(|layer| layer.is_called(name)).collect();
        match found[..] {
            [layer] => Ok(layer),
            [] => Err(ImageError::NoSuchLayer {
                file: self.file.clone(),
                wanted: name.escape_debug().to_string(),
                option,
                known: shown(&self.layers.iter().collect::<Vec<_>>()),
            }),
            _ => {
                Err(ImageError::UnclearLayer { file: self.file.clone(), what: "layer", option, layers: shown(&found) })
            }
        }
    }

    /// The first of these channels, if all of them are the same.
    fn equal_planes(&self, layer: &Layer, channels: &[usize]) -> Option<(Image<f32>, Window)> {
        let (first, rest) = channels.split_first()?;
        let bits = |index: usize| self.parts[layer.part].channels[index].1.iter().map(|value| value.to_bits());
        let all_equal = rest.iter().all(|&index| bits(index).eq(bits(*first)));
        if all_equal { self.plane(layer.part, *first) } else { None }
    }

    fn plane(&self, part: usize, channel: usize) -> Option<(Image<f32>, Window)> {
        let part = &self.parts[part];
        let pixels = part.channels.get(channel)?.1.clone();
        (pixels.len() == part.window.pixels()).then_some((Image { size: part.window.size, pixels }, part.window))
    }

    /// The layers, as `--layer` takes them, each with its channels.
    pub fn layer_names(&self) -> Vec<String> {
        self.layers.iter().map(Layer::shown).collect()
    }

    fn not_clear(
        &self,
        equal: &[&Layer],
        what: &'static str,
        option: &'static str,
        wanted: &'static str,
        remedy: &'static str,
    ) -> ImageError {
        if equal.is_empty() {
            return self.missing(wanted, remedy);
        }
        ImageError::UnclearLayer { file: self.file.clone(), what, option, layers: shown(equal) }
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

/// What to do where a file has no picture.
const COLOR_REMEDY: &str = "choose a file with colour, or name a layer with --layer";

fn shown(layers: &[&Layer]) -> String {
    layers.iter().map(|layer| layer.shown()).collect::<Vec<_>>().join(", ")
}

impl Window {
    fn pixels(&self) -> usize {
        self.size.x as usize * self.size.y as usize
    }
}

impl Part {
    fn new(layer: exr::prelude::Layer<AnyChannels<FlatSamples>>) -> Self {
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
}

/// Names of an EXR's layers, as a layer is asked for by: those of its parts and of the channels in
/// them. Reads no pixels. A layer without a name is none that can be asked for.
///
/// # Errors
///
/// A file that cannot be read, is damaged, deep, or absurdly large.
pub fn layer_names(path: &Path) -> Result<Vec<String>, ImageError> {
    check_header(path)?;
    let meta = exr::meta::MetaData::read_from_file(path, false)
        .map_err(|e| ImageError::Undecodable { file: path.to_owned(), detail: e.to_string() })?;
    let text = |text: &Option<exr::prelude::Text>| text.as_ref().map(ToString::to_string).unwrap_or_default();
    let parts: Vec<(String, String, Vec<String>)> = (meta.headers.iter())
        .map(|header| {
            let own = &header.own_attributes;
            let channels = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
            (text(&own.layer_name), text(&own.view_name), channels)
        })
        .collect();
    let parts = parts
        .iter()
        .map(|(name, view, channels)| (name.as_str(), view.as_str(), channels.iter().map(String::as_str).collect()));
    let names = Layer::all(parts).into_iter().map(|layer| layer.name);
    Ok(names.filter(|name| !name.is_empty()).collect())
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
    // Samples of all parts, as planes of four channels below one another.
    let samples = |header: &exr::meta::header::Header| {
        let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
        width.saturating_mul(height).saturating_mul(header.channels.list.len() as u64)
    };
    let samples = meta.headers.iter().map(samples).fold(0, u64::saturating_add);
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
    let first = meta.headers.first().map_or((1, 1), |header| (header.layer_size.0 as u64, header.layer_size.1 as u64));
    check_size_to_read(path, samples.div_ceil(4).max(1), 1).map_err(|error| match error {
        // The size that a person knows is that of the first part.
        ImageError::Inflated { file, bytes, .. } => {
            ImageError::Inflated { file, width: first.0, height: first.1, bytes }
        }
        _ => ImageError::Size { file: path.to_owned(), width: first.0, height: first.1 },
    })
}

/// Encodes named float planes of one size as a single-part EXR, losslessly compressed.
pub(super) fn encode(
    target: &mut impl Write,
    size: UVec2,
    planes: Vec<(&'static str, Vec<f32>)>,
) -> std::io::Result<()> {
    let channels = planes.into_iter().map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values))).collect();
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::FAST_LOSSLESS };
    let layer = exr::prelude::Layer::new(
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
