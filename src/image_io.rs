//! Images from and to files: PNG, JPEG, WebP, BMP, TIFF, HDR, PFM and EXR in, PNG and EXR out.
//!
//! 8- and 16-bit files hold sRGB-encoded colour and are decoded to linear; files of floats
//! (HDR, PFM, EXR, TIFF of 32 bits) are linear already. Images stand upright, as their Exif
//! data say. Every file is written under a temporary name beside its
//! target and renamed, so that a reader never meets half of one.

pub mod embedded;
mod error;
mod exr_layers;
pub mod exr_planes;
mod npy;
pub(crate) mod orientation;
mod pfm;
mod primaries;
mod scalar;
pub mod srgb;

pub use error::{ImageError, MAX_PIXELS};
pub use exr_planes::layer_names as exr_layer_names;
pub use scalar::{Scalars, read_scalars};

use crate::image::{ColorImage, DepthImage, Image};
use error::{check_size, check_size_to_read};
use exr_planes::ExrPlanes;
use glam::{UVec2, Vec3};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader};
use orientation::Orientation;
use pfm::Pfm;
use srgb::{linear_from_srgb_f32, linear_from_srgb8_table};
use std::io::{BufWriter, Read, Write};
use std::path::Path;

/// Whether the file begins like an OpenEXR file.
pub(crate) fn is_exr(path: &Path) -> Result<bool, ImageError> {
    read_start(path).map(|start| is_exr_start(&start))
}

fn is_exr_start(start: &[u8]) -> bool {
    start.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// The first bytes of a regular file, by which its format is told.
fn read_start(path: &Path) -> Result<Vec<u8>, ImageError> {
    let unreadable = |source| ImageError::Unreadable { file: path.to_owned(), source };
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        let source = std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file");
        return Err(unreadable(source));
    }
    let mut start = Vec::new();
    std::fs::File::open(path).and_then(|file| file.take(16).read_to_end(&mut start)).map_err(unreadable)?;
    Ok(start)
}

/// Reads a colour image as linear Rec. 709: sRGB-decoded from 8- and 16-bit files, as it
/// is from HDR and EXR. Alpha is dropped, so that premultiplied colour stays over black.
///
/// # Errors
///
/// The file, the cause and the remedy.
pub fn read_color(path: &Path) -> Result<ColorImage, ImageError> {
    read_picture(path, None).map(|(image, _)| image)
}

/// [`read_color`] of an EXR's layer called `layer`, with how the image was turned to stand
/// upright.
///
/// # Errors
///
/// Those of [`read_color`]; a layer that the file does not have.
pub(crate) fn read_picture(path: &Path, layer: Option<&str>) -> Result<(ColorImage, Orientation), ImageError> {
    let start = read_start(path)?;
    if is_exr_start(&start) {
        return ExrPlanes::read(path)?.color(layer).map(|(image, _)| (image, Orientation::NoTransforms));
    }
    if layer.is_some() {
        return Err(ImageError::NoLayers { file: path.to_owned(), option: "--layer" });
    }
    if pfm::is_pfm(&start) {
        let bytes = std::fs::read(path).map_err(|source| ImageError::Unreadable { file: path.to_owned(), source })?;
        let image = match pfm::parse(&bytes) {
            Ok(Pfm::Grey(grey)) => grey.map(Vec3::splat),
            Ok(Pfm::Color(rgb)) => rgb.map(Vec3::from),
            Err(detail) => return Err(ImageError::Undecodable { file: path.to_owned(), detail }),
        };
        return Ok((image, Orientation::NoTransforms));
    }
    let (decoded, orientation) = decode_with_orientation(path)?;
    let size = UVec2::new(decoded.width(), decoded.height());
    let pixels = match decoded {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            decoded.into_rgb32f().as_raw().as_chunks::<3>().0.iter().copied().map(Vec3::from).collect()
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let linear = |v: u16| linear_from_srgb_f32(f32::from(v) / 65535.0);
            decoded.into_rgb16().as_raw().as_chunks::<3>().0.iter().map(|rgb| Vec3::from(rgb.map(linear))).collect()
        }
        _ => {
            let table = linear_from_srgb8_table();
            let linear = |v: u8| table[usize::from(v)];
            decoded.into_rgb8().as_raw().as_chunks::<3>().0.iter().map(|rgb| Vec3::from(rgb.map(linear))).collect()
        }
    };
    Ok((Image { size, pixels }, orientation))
}

/// Decodes an image of the formats of the `image` crate, told apart by their content, within
/// [`MAX_PIXELS`], and turns it upright; the second is how it was turned.
pub(crate) fn decode_with_orientation(path: &Path) -> Result<(DynamicImage, Orientation), ImageError> {
    let undecodable = |detail: String| ImageError::Undecodable { file: path.to_owned(), detail: one_line(&detail) };
    let unreadable = |source| ImageError::Unreadable { file: path.to_owned(), source };
    let open = || ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(unreadable);
    let (width, height) = open()?.into_dimensions().map_err(|e| undecodable(e.to_string()))?;
    check_size_to_read(path, u64::from(width), u64::from(height))?;
    let decode = || {
        let mut decoder = open().map_err(|e| e.to_string())?.into_decoder().map_err(|e| e.to_string())?;
        // Exif data that cannot be read say nothing.
        let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
        let mut image = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
        image.apply_orientation(orientation);
        Ok((image, orientation))
    };
    decode().map_err(undecodable)
}

/// A decoder's words without the line breaks that some of them have.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Writes an 8-bit RGBA PNG of values that are display-referred sRGB already.
///
/// # Errors
///
/// [`ImageError::Unwritable`]; the target is then as it was.
pub fn write_png(path: &Path, image: &Image<[u8; 4]>) -> Result<(), ImageError> {
    write_png_bytes(path, image.pixels.as_flattened(), image.size, ExtendedColorType::Rgba8)
}

/// Writes an 8-bit RGB PNG of values that are display-referred sRGB already.
///
/// # Errors
///
/// [`ImageError::Unwritable`]; the target is then as it was.
pub fn write_png_rgb(path: &Path, image: &Image<[u8; 3]>) -> Result<(), ImageError> {
    write_png_bytes(path, image.pixels.as_flattened(), image.size, ExtendedColorType::Rgb8)
}

fn write_png_bytes(path: &Path, bytes: &[u8], size: UVec2, color: ExtendedColorType) -> Result<(), ImageError> {
    check_size(path, u64::from(size.x), u64::from(size.y))?;
    write_atomically(path, |file| {
        let encoder = image::codecs::png::PngEncoder::new(file);
        encoder.write_image(bytes, size.x, size.y, color).map_err(std::io::Error::other)
    })
}

/// Writes a 32-bit float EXR: R, G, B linear, and where given Z (depth along the axis,
/// metres) and C (signed CoC diameter, px).
///
/// # Errors
///
/// [`ImageError::LayerSize`] or [`ImageError::Unwritable`]; the target is then as it was.
pub fn write_exr(
    path: &Path,
    color: &ColorImage,
    depth_z: Option<&DepthImage>,
    coc_px: Option<&Image<f32>>,
) -> Result<(), ImageError> {
    for (layer, plane) in [("depth", depth_z), ("CoC", coc_px)] {
        if let Some(plane) = plane.filter(|plane| plane.size != color.size) {
            let (layer_size, color_size) = (plane.size, color.size);
            return Err(ImageError::LayerSize { file: path.to_owned(), layer, layer_size, color_size });
        }
    }
    check_size(path, u64::from(color.size.x), u64::from(color.size.y))?;
    let component = |k: usize| color.pixels.iter().map(|rgb| rgb[k]).collect::<Vec<f32>>();
    let mut planes = vec![("R", component(0)), ("G", component(1)), ("B", component(2))];
    planes.extend(depth_z.map(|plane| ("Z", plane.pixels.clone())));
    planes.extend(coc_px.map(|plane| ("C", plane.pixels.clone())));
    write_atomically(path, |file| exr_planes::encode(file, color.size, planes))
}

/// Writes a file through `write` under a temporary name in the target's folder, and
/// renames it when all is written: the target is either whole or untouched.
///
/// # Errors
///
/// [`ImageError::Unwritable`] with the first reason met.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> Result<(), ImageError> {
    let unwritable = |source| ImageError::Unwritable { file: path.to_owned(), source };
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".defocus-").suffix(".part");
    // A temporary file is private by default; the finished one follows the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut temporary = builder.tempfile_in(folder).map_err(unwritable)?;
    let mut buffered = BufWriter::new(temporary.as_file_mut());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(unwritable)?;
    drop(buffered);
    temporary.persist(path).map(|_| ()).map_err(|e| unwritable(e.error))
}
