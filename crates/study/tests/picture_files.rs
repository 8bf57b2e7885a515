//! Pictures with depth as cameras, renderers and depth networks write them.

#[path = "../../../tests/tiny_files/mod.rs"]
mod tiny_files;

use defocus::image::Image;
use defocus::image_io::{self, read_color};
use defocus::scene::rgbd::{self, DepthEncoding, DepthKind, Request, RgbdScene};
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage};
use glam::{UVec2, Vec3};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use tiny_files::{gradient, png, png16, write};

const SIZE: UVec2 = UVec2::new(8, 6);
const FOV_Y: f64 = 0.8;

fn request<'a>(color: &'a Path, depth: Option<&'a Path>, encoding: &'a DepthEncoding) -> Request<'a> {
    let (layer, depth_layer) = (None, None);
    Request { color, depth, encoding, fov_y: None, default_fov_y: FOV_Y, layer, depth_layer }
}

fn load(color: &Path, depth: Option<&Path>, kind: DepthKind) -> RgbdScene {
    let encoding = DepthEncoding { kind, ..DepthEncoding::METRES };
    rgbd::load_request(&request(color, depth, &encoding)).unwrap_or_else(|e| panic!("{e}"))
}

const METRES: DepthKind = DepthKind::Metres { per_unit: 1.0 };

/// The values of a channel by column and row.
type Values<'a> = &'a dyn Fn(u32, u32) -> f32;

/// An EXR of float channels, each of one value a pixel.
fn exr(folder: &TempDir, name: &str, channels: &[(&str, Values<'_>)]) -> PathBuf {
    let plane = |value: Values<'_>| Image::from_fn(SIZE, value).pixels;
    let channels =
        channels.iter().map(|(name, value)| AnyChannel::new(*name, FlatSamples::F32(plane(value)))).collect();
    let size = (SIZE.x as usize, SIZE.y as usize);
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    let path = folder.path().join(name);
    exr::prelude::Image::from_layer(layer).write().to_file(&path).expect("is written");
    path
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn the_picture_and_the_depth_of_a_layered_exr() {
    let folder = folder();
    let (one, two): (Values, Values) = (&|_, _| 0.25, &|_, _| 0.75);
    let far: Values = &|x, _| 3.0 + x as f32;
    let file = exr(
        &folder,
        "blender.exr",
        &[
            ("ViewLayer.AO.R", two),
            ("ViewLayer.AO.G", two),
            ("ViewLayer.AO.B", two),
            ("ViewLayer.Combined.R", one),
            ("ViewLayer.Combined.G", one),
            ("ViewLayer.Combined.B", one),
            ("ViewLayer.Depth.V", far),
            ("ViewLayer.Mist.V", two),
            ("ViewLayer.Normal.X", two),
            ("ViewLayer.Normal.Y", two),
            ("ViewLayer.Normal.Z", two),
        ],
    );
    let scene = load(&file, None, METRES);
    assert!(scene.color.pixels.iter().all(|c| *c == Vec3::splat(0.25)));
    assert_eq!(scene.depth.at(5, 1), 8.0);

    let encoding = DepthEncoding::METRES;
    let named =
        |layer, depth_layer| rgbd::load_request(&Request { layer, depth_layer, ..request(&file, None, &encoding) });
    let other = named(Some("ViewLayer.AO"), Some("ViewLayer.Mist.V")).unwrap_or_else(|e| panic!("{e}"));
    assert!(other.color.at(0, 0) == Vec3::splat(0.75) && other.depth.at(0, 0) == 0.75);
    let short = named(Some("ao"), Some("depth")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((short.color.at(0, 0).x, short.depth.at(0, 0)), (0.75, 3.0));
    let message = named(Some("beauty"), None).expect_err("no such layer").to_string();
    assert!(message.contains("--layer") && message.contains("ViewLayer.Combined"), "{message}");
    let message = named(None, Some("W")).expect_err("no such layer").to_string();
    assert!(message.contains("--depth-layer") && message.contains("ViewLayer.Depth"), "{message}");
}

#[test]
fn mist_normals_and_positions_are_no_depth() {
    let folder = folder();
    let value: Values = &|x, y| 1.0 + (x * y) as f32;
    let color = [("R", value), ("G", value), ("B", value)];
    for (case, pass) in [
        ("mist", vec![("Mist.Z", value)]),
        ("normal", vec![("N.X", value), ("N.Y", value), ("N.Z", value)]),
        ("position", vec![("Position.X", value), ("Position.Y", value), ("Position.Z", value)]),
    ] {
        let file = exr(&folder, "pass.exr", &[&color[..], &pass].concat());
        let encoding = DepthEncoding::METRES;
        let message = rgbd::load_request(&request(&file, None, &encoding)).expect_err(case).to_string();
        assert!(message.contains(pass[0].0) && message.contains("--depth"), "{case}: {message}");
        let alone = exr(&folder, "alone.exr", &pass);
        let picture = write(folder.path(), "c.png", &png(8, 6, [9, 9, 9]));
        assert!(rgbd::load_request(&request(&picture, Some(&alone), &encoding)).is_err(), "{case} as a depth file");
    }
}

#[test]
fn what_is_not_clear_is_asked_for() {
    let folder = folder();
    let value: Values = &|_, _| 1.0;
    let file = exr(
        &folder,
        "two.exr",
        &[
            ("key.R", value),
            ("key.G", value),
            ("key.B", value),
            ("fill.R", value),
            ("fill.G", value),
            ("fill.B", value),
            ("Z", value),
        ],
    );
    let message = read_color(&file).expect_err("two pictures").to_string();
    assert!(message.contains("not clear") && message.contains("key (BGR)") && message.contains("fill"), "{message}");
    let file = exr(
        &folder,
        "depths.exr",
        &[("R", value), ("G", value), ("B", value), ("a.Depth.Z", value), ("b.Depth.Z", value)],
    );
    let encoding = DepthEncoding::METRES;
    let message = rgbd::load_request(&request(&file, None, &encoding)).expect_err("two depths").to_string();
    assert!(message.contains("a.Depth") && message.contains("--depth-layer"), "{message}");
    let png = write(folder.path(), "c.png", &png(8, 6, [9, 9, 9]));
    let result = rgbd::load_request(&Request { layer: Some("x"), ..request(&png, Some(&file), &encoding) });
    assert!(result.expect_err("a PNG has no layers").to_string().contains("leave out --layer"));
}

#[test]
fn three_equal_channels_are_one_and_different_ones_are_not() {
    let folder = folder();
    let picture = write(folder.path(), "c.png", &png(8, 6, [9, 9, 9]));
    let (value, other): (Values, Values) = (&|x, _| 2.0 + x as f32, &|_, y| 5.0 + y as f32);
    let equal = exr(&folder, "equal.exr", &[("R", value), ("G", value), ("B", value)]);
    assert_eq!(load(&picture, Some(&equal), METRES).depth.at(3, 0), 5.0);
    let named = exr(&folder, "named.exr", &[("depth.R", value), ("depth.G", value), ("depth.B", value), ("A", other)]);
    assert_eq!(load(&picture, Some(&named), METRES).depth.at(3, 0), 5.0);
    let different = exr(&folder, "different.exr", &[("R", value), ("G", value), ("B", other)]);
    let encoding = DepthEncoding::METRES;
    let message = rgbd::load_request(&request(&picture, Some(&different), &encoding)).expect_err("colour").to_string();
    assert!(message.contains("differ") && message.contains("--depth-layer"), "{message}");
}

#[test]
fn luminance_and_chroma_make_colour() {
    let folder = folder();
    let (y, ry, by): (Values, Values, Values) = (&|x, _| 0.5 + x as f32, &|_, _| 0.4, &|_, _| -0.2);
    let picture = exr(&folder, "chroma.exr", &[("Y", y), ("RY", ry), ("BY", by), ("Z", &|_, _| 3.0)]);
    let scene = load(&picture, None, METRES);
    for x in 0..3 {
        // RY = (R - Y) / Y, BY = (B - Y) / Y, and Y is the luminance of Rec. 709.
        let found = scene.color.at(x, 1);
        let y = 0.5 + x as f32;
        let luminance = found.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        assert!((found.x - 1.4 * y).abs() < 1e-5 && (found.z - 0.8 * y).abs() < 1e-5, "{found}");
        assert!((luminance - y).abs() < 1e-4, "{luminance} for {y}");
        assert_eq!(scene.depth.at(x, 1), 3.0);
    }
}

#[test]
fn primaries_of_the_file_are_obeyed() {
    let folder = folder();
    let path = folder.path().join("aces.exr");
    let one = || FlatSamples::F32(vec![1.0; 48]);
    let red = [("R", one()), ("G", FlatSamples::F32(vec![0.0; 48])), ("B", FlatSamples::F32(vec![0.0; 48]))];
    let channels = red.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let layer = Layer::new((8, 6), LayerAttributes::default(), Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    let mut image = exr::prelude::Image::from_layer(layer);
    use exr::math::Vec2 as Pair;
    image.attributes.chromaticities = Some(exr::meta::attribute::Chromaticities {
        red: Pair(0.7347, 0.2653),
        green: Pair(0.0, 1.0),
        blue: Pair(0.0001, -0.077),
        white: Pair(0.32168, 0.33767),
    });
    image.write().to_file(&path).expect("is written");
    let color = read_color(&path).unwrap_or_else(|e| panic!("{e}"));
    // The red of ACES in Rec. 709, as the ACES documents print it.
    assert!((color.at(0, 0) - Vec3::new(2.5217, -0.2765, -0.0154)).abs().max_element() < 2e-3, "{}", color.at(0, 0));
}

/// A JPEG of a picture whose left half is bright, stored so that Exif has to turn it.
fn turned_jpeg(orientation: u8) -> Vec<u8> {
    let upright = image::RgbImage::from_fn(32, 16, |x, _| image::Rgb(if x < 16 { [250, 250, 250] } else { [5, 5, 5] }));
    let stored = match orientation {
        // A quarter turn clockwise is still to be made: it was stored turned the other way.
        6 => image::imageops::rotate270(&upright),
        8 => image::imageops::rotate90(&upright),
        3 => image::imageops::rotate180(&upright),
        _ => upright,
    };
    let mut jpeg = std::io::Cursor::new(Vec::new());
    stored.write_to(&mut jpeg, image::ImageFormat::Jpeg).expect("encodes");
    let jpeg = jpeg.into_inner();
    let tag = [0x12, 0x01, 3, 0, 1, 0, 0, 0, orientation, 0, 0, 0];
    let exif = [&b"Exif\0\0II*\0\x08\0\0\0\x01\0"[..], &tag, &[0; 4]].concat();
    let segment = [&[0xff, 0xe1][..], &(exif.len() as u16 + 2).to_be_bytes(), &exif].concat();
    [&jpeg[..2], &segment, &jpeg[2..]].concat()
}

#[test]
fn exif_turns_the_picture_and_a_depth_that_lies_with_it() {
    let folder = folder();
    let upright = write(folder.path(), "u.png", &png16(32, 16, |x, _| if x < 16 { 1000 } else { 2000 }));
    // As the picture of orientation 6 is stored: its left half at the bottom.
    let stored = write(folder.path(), "s.png", &png16(16, 32, |_, y| if y >= 16 { 1000 } else { 2000 }));
    let kind = DepthKind::Metres { per_unit: 0.001 };
    for (orientation, depth) in [(6, &upright), (6, &stored), (3, &upright), (8, &upright), (1, &upright)] {
        let picture = write(folder.path(), "p.jpg", &turned_jpeg(orientation));
        let scene = load(&picture, Some(depth), kind);
        assert_eq!(scene.color.size, UVec2::new(32, 16), "{orientation}");
        for (x, is_bright, depth_m) in [(2, true, 1.0), (29, false, 2.0)] {
            assert_eq!(scene.color.at(x, 8).x > 0.5, is_bright, "{orientation} at {x}");
            assert_eq!(scene.depth.at(x, 8), depth_m, "{orientation} at {x}");
        }
    }
}

#[test]
fn depth_of_half_the_size_keeps_its_edges() {
    let folder = folder();
    let near = |x: u32, y: u32| (5..14).contains(&x) && (3..10).contains(&y);
    let picture =
        image::RgbImage::from_fn(24, 16, |x, y| image::Rgb(if near(x, y) { [200, 30, 30] } else { [60, 60, 90] }));
    let path = folder.path().join("c.png");
    picture.save(&path).expect("is written");
    let depth = png16(12, 8, |x, y| if near(2 * x + 1, 2 * y + 1) { 1000 } else { 4000 });
    let depth = write(folder.path(), "d.png", &depth);
    let scene = load(&path, Some(&depth), DepthKind::Metres { per_unit: 0.001 });
    assert_eq!(scene.depth.size, UVec2::new(24, 16));
    for y in 0..16 {
        for x in 0..24 {
            assert_eq!(scene.depth.at(x, y), if near(x, y) { 1.0 } else { 4.0 }, "at {x}, {y}");
        }
    }
    let said = scene.notes.iter().any(|n| n.contains("12x8") && n.contains("24x16") && n.contains("factor of 2.000"));
    assert!(said, "{:?}", scene.notes);
    // Twice as large as the picture: one of the samples, never a mean.
    let large = write(folder.path(), "l.png", &png16(48, 32, |x, _| if x < 23 { 1000 } else { 4000 }));
    let scene = load(&path, Some(&large), DepthKind::Metres { per_unit: 0.001 });
    assert!(scene.depth.pixels.iter().all(|d| *d == 1.0 || *d == 4.0));
}

#[test]
fn depth_in_every_format() {
    let folder = folder();
    let value = |x: u32, y: u32| 1.5 + (x + 8 * y) as f32 / 16.0;
    let floats: Vec<f32> = Image::from_fn(SIZE, value).pixels;
    let bottom_up: Vec<f32> = floats.chunks(8).rev().flatten().copied().collect();
    let pfm = [&b"Pf\n8 6\n-1.0\n"[..], bytemuck::cast_slice(&bottom_up)].concat();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (6, 8), }\n";
    let npy = [
        &b"\x93NUMPY\x01\0"[..],
        &(header.len() as u16).to_le_bytes(),
        header.as_bytes(),
        bytemuck::cast_slice(&floats),
    ]
    .concat();
    let mut float_tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut float_tiff).expect("starts");
    encoder.write_image::<tiff::encoder::colortype::Gray32Float>(8, 6, &floats).expect("encodes");
    let mut integer_tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut integer_tiff).expect("starts");
    let sixteenths: Vec<u16> = floats.iter().map(|v| (v * 16.0) as u16).collect();
    encoder.write_image::<tiff::encoder::colortype::Gray16>(8, 6, &sixteenths).expect("encodes");

    let colors: Vec<PathBuf> =
        [image::ImageFormat::WebP, image::ImageFormat::Bmp, image::ImageFormat::Tiff, image::ImageFormat::Png]
            .into_iter()
            .map(|format| {
                let path = folder.path().join("c").with_extension(format.extensions_str()[0]);
                image::RgbImage::from_pixel(8, 6, image::Rgb([255, 128, 0]))
                    .save_with_format(&path, format)
                    .expect("is written");
                path
            })
            .collect();
    for (color, (name, bytes, per_unit)) in colors.iter().zip([
        ("d.pfm", pfm.clone(), 1.0),
        ("d.npy", npy, 1.0),
        ("d.tif", float_tiff.into_inner(), 1.0),
        ("e.tif", integer_tiff.into_inner(), 1.0 / 16.0),
    ]) {
        let depth = write(folder.path(), name, &bytes);
        let scene = load(color, Some(&depth), DepthKind::Metres { per_unit });
        assert_eq!(scene.depth.pixels, floats, "{name}");
        let expected = Vec3::new(1.0, 0.2158605, 0.0);
        assert!(
            (scene.color.at(3, 3) - expected).abs().max_element() < 1e-5,
            "{}: {}",
            color.display(),
            scene.color.at(3, 3)
        );
    }
    // A PFM is a picture, too, and linear.
    let grey = read_color(&write(folder.path(), "p.pfm", &pfm)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(grey.at(7, 5), Vec3::splat(value(7, 5)));
}

#[test]
fn far_sentinels_are_infinity_and_take_no_focus() {
    let folder = folder();
    for far in [1e10_f32, 65504.0, f32::MAX, 0.0] {
        let depth = Image::from_fn(SIZE, |x, _| if x < 6 { far } else { 3.0 });
        let path = folder.path().join("a.exr");
        image_io::write_exr(&path, &gradient(8, 6), Some(&depth), None).expect("is written");
        let scene = load(&path, None, METRES);
        assert_eq!((scene.depth.at(0, 0), scene.depth.at(7, 0)), (f32::INFINITY, 3.0), "{far}");
        assert!(scene.notes.iter().any(|note| note.starts_with("36 depths")), "{far}: {:?}", scene.notes);
        let focus = defocus_study::source::default_focus_m(&scene.depth, None);
        assert_eq!(focus, Some(3.0), "{far}");
    }
    // 0 by choice, in a file of integers.
    let picture = write(folder.path(), "c.png", &png(8, 6, [9, 9, 9]));
    let depth = write(folder.path(), "d.png", &png16(8, 6, |x, _| if x < 4 { 0 } else { 2000 }));
    let kind = DepthKind::Metres { per_unit: 0.001 };
    let encoding = DepthEncoding { kind, unknown: None, infinity: Some(0.0) };
    let scene = rgbd::load_request(&request(&picture, Some(&depth), &encoding)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((scene.depth.at(0, 0), scene.depth.at(7, 0)), (f32::INFINITY, 2.0));
}

#[test]
fn distances_along_rays_of_a_wall_are_one_depth() {
    let folder = folder();
    let focal_px = 3.0 / (FOV_Y / 2.0).tan();
    let distance = Image::from_fn(SIZE, |x, y| {
        let slope = (glam::dvec2(f64::from(x), f64::from(y)) + 0.5 - glam::dvec2(4.0, 3.0)) / focal_px;
        (5.0 * (1.0 + slope.length_squared()).sqrt()) as f32
    });
    let path = folder.path().join("wall.exr");
    image_io::write_exr(&path, &gradient(8, 6), Some(&distance), None).expect("is written");
    let scene = load(&path, None, DepthKind::Distance { per_unit: 1.0 });
    assert!(scene.depth.pixels.iter().all(|d| (d - 5.0).abs() < 1e-5), "{:?}", scene.depth.pixels);
    assert!(scene.notes.iter().any(|note| note.contains("45.84 degrees")), "{:?}", scene.notes);
}

#[test]
fn a_calibration_gives_depth_and_field_of_view() {
    let folder = folder();
    let picture = write(folder.path(), "c.png", &png(8, 6, [9, 9, 9]));
    let values: Vec<f32> = (0..48).map(|i| if i == 0 { f32::INFINITY } else { 10.0 }).collect();
    let pfm = [&b"Pf\n8 6\n-1.0\n"[..], bytemuck::cast_slice(&values)].concat();
    let depth = write(folder.path(), "disp.pfm", &pfm);
    let kind = DepthKind::Disparity { focal_px: 3.0, baseline_m: 10.0, offset_px: 2.0, per_unit: 1.0 };
    let scene = load(&picture, Some(&depth), kind);
    assert!(scene.depth.pixels.iter().all(|d| *d == 2.5) && scene.unknown_share > 0.0);
    assert!((scene.fov_y - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

/// All of it in focus, at whatever distance: no aperture gives a blur.
#[test]
fn constant_depth_has_no_mean_blur_at_any_distance() {
    let lens = defocus::presets::preset("projection").expect("a preset").lens.clone();
    for distance_m in [0.37_f32, 1.0, 3.3, 12.7, 1234.5] {
        for focus_m in [f64::from(distance_m), f64::from(distance_m) * (1.0 + 3e-8)] {
            let focused = defocus::lens::Lens { focus_distance_m: focus_m, ..lens.clone() };
            assert!(focused.with_mean_coc(8.0, [distance_m; 9]).is_none(), "{distance_m} m");
        }
        let near = defocus::lens::Lens { focus_distance_m: f64::from(distance_m) * 0.9, ..lens.clone() };
        assert!(near.with_mean_coc(8.0, [distance_m; 9]).is_some(), "{distance_m} m");
    }
}

/// A small file cannot ask for gigabytes: what its bytes cannot stand for is refused before anything is
/// decoded.
#[test]
fn pixels_that_the_bytes_cannot_stand_for_are_refused() {
    let folder = folder();
    let (width, height) = (10_000_u32, 9_000_u32);
    // Lines of zeros: a thousandth of what they stand for.
    let path = folder.path().join("zeros.png");
    let file = std::io::BufWriter::new(std::fs::File::create(&path).expect("is created"));
    let (best, plain) = (image::codecs::png::CompressionType::Best, image::codecs::png::FilterType::NoFilter);
    let encoder = image::codecs::png::PngEncoder::new_with_quality(file, best, plain);
    let zeros = vec![0_u8; width as usize * height as usize];
    image::ImageEncoder::write_image(encoder, &zeros, width, height, image::ExtendedColorType::L8).expect("is written");
    let bytes = std::fs::metadata(&path).expect("is there").len();
    assert!(bytes < 5_000_000, "{bytes} bytes");
    let message = image_io::read_scalars(&path, None).expect_err("too large").to_string();
    assert!(message.contains("10000 x 9000") && message.contains("can stand for"), "{message}");
    let message = read_color(&path).expect_err("too large").to_string();
    assert!(message.contains("can stand for"), "{message}");
}

#[test]
fn the_layers_of_an_exr_are_listed_as_they_are_asked_for() {
    let folder = folder();
    let one: Values = &|_, _| 1.0;
    let file = exr(&folder, "layers.exr", &[("R", one), ("G", one), ("B", one), ("mist.Z", one), ("a.Depth.Z", one)]);
    let names = image_io::exr_layer_names(&file).expect("an EXR");
    assert_eq!(names, ["a.Depth", "mist"]);
    assert!(image_io::exr_layer_names(&folder.path().join("none.exr")).is_err());
}
