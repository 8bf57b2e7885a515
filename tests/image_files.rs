//! Images from and to files, and images with depth.

mod tiny_files;

use defocus::image::Image;
use defocus::image_io::{self, srgb};
use defocus::scene::rgbd::{self, DepthEncoding, DepthKind};
use glam::{UVec2, Vec3};
use tiny_files::{gradient, png, png16, write};

#[test]
fn exr_keeps_every_bit_and_names_its_layers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.exr");
    let color = gradient(17, 9);
    let depth = Image::from_fn(color.size, |x, y| if x == 3 { f32::INFINITY } else { 0.1 + (x + y) as f32 / 7.0 });
    let coc_px = Image::from_fn(color.size, |x, y| x as f32 / 3.0 - y as f32);
    image_io::write_exr(&path, &color, Some(&depth), Some(&coc_px)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(image_io::read_color(&path).unwrap_or_else(|e| panic!("{e}")), color);
    let scene = rgbd::load(&path, None, &DepthEncoding::METRES, 0.7).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((scene.color, scene.depth, scene.nonfinite_pixels), (color, depth, 0));
    let meta = exr::meta::MetaData::read_from_file(&path, true).expect("pedantically valid");
    let channels =
        meta.headers[0].channels.list.iter().map(|c| (c.name.to_string(), c.sample_type)).collect::<Vec<_>>();
    assert_eq!(
        channels,
        ["B", "C", "G", "R", "Z"].map(|name| (name.to_owned(), exr::meta::attribute::SampleType::F32))
    );
}

#[test]
fn png_keeps_its_bytes_and_is_decoded_from_srgb() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.png");
    let bytes = Image::from_fn(UVec2::new(16, 16), |x, y| [(16 * y + x) as u8, x as u8, y as u8]);
    image_io::write_png_rgb(&path, &bytes).unwrap_or_else(|e| panic!("{e}"));
    let read = image_io::read_color(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(read.map(|rgb| rgb.to_array().map(srgb::srgb8_from_linear)), bytes);
    assert_eq!(read.at(8, 8).x, srgb::linear_from_srgb(136.0 / 255.0) as f32);
    image_io::write_png(&path, &bytes.map(|[r, g, b]| [r, g, b, 255])).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(image_io::read_color(&path).unwrap_or_else(|e| panic!("{e}")), read);
}

#[test]
fn sixteen_bit_colour_keeps_more_than_eight_bits() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = write(folder.path(), "a.png", &png16(4, 1, |x, _| 30000 + x as u16));
    let read = image_io::read_color(&path).unwrap_or_else(|e| panic!("{e}"));
    assert!(read.pixels.windows(2).all(|pair| pair[0].x < pair[1].x));
    assert_eq!(read.at(1, 0).y, srgb::linear_from_srgb(f64::from(30001.0_f32 / 65535.0)) as f32);
}

#[test]
fn a_failed_write_leaves_the_target_and_no_litter() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = write(folder.path(), "precious.txt", b"before");
    let failed = image_io::write_atomically(&path, |file| {
        std::io::Write::write_all(file, b"half of")?;
        Err(std::io::Error::other("the disk is full"))
    });
    let message = failed.expect_err("the write failed").to_string();
    assert!(message.contains("the disk is full") && message.contains("precious.txt"), "{message}");
    assert_eq!(std::fs::read(&path).expect("is still there"), b"before");
    assert_eq!(std::fs::read_dir(folder.path()).expect("can be listed").count(), 1);
    let absent = folder.path().join("absent").join("a.png");
    let message = image_io::write_png(&absent, &Image::filled(UVec2::ONE, [0; 4])).expect_err("no folder").to_string();
    assert!(message.contains("folder exists"), "{message}");
    let color = gradient(4, 4);
    let depth = Image::filled(UVec2::new(4, 5), 1.0);
    let message = image_io::write_exr(&path, &color, Some(&depth), None).expect_err("sizes differ").to_string();
    assert!(message.contains("depth") && message.contains("one size"), "{message}");
}

#[cfg(unix)]
#[test]
fn written_files_have_ordinary_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plain = write(folder.path(), "plain", b"");
    let path = folder.path().join("a.png");
    image_io::write_png(&path, &Image::filled(UVec2::ONE, [0; 4])).unwrap_or_else(|e| panic!("{e}"));
    let mode = |path: &std::path::Path| std::fs::metadata(path).expect("exists").permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}

#[test]
fn sixteen_bit_depth_is_exact_and_unknown_is_filled() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let color = write(folder.path(), "c.png", &png(10, 8, [90, 90, 90]));
    let raw = |x: u32, y: u32| if x == 4 { 0 } else { 1000 + (10 * y + x) as u16 };
    let depth = write(folder.path(), "d.png", &png16(10, 8, raw));
    let encoding = DepthEncoding { kind: DepthKind::Metres { per_unit: 0.0002 }, unknown: Some(0.0), infinity: None };
    let scene = rgbd::load(&color, Some(&depth), &encoding, 0.7).unwrap_or_else(|e| panic!("{e}"));
    for (x, y) in [(0, 0), (9, 7), (3, 5)] {
        assert_eq!(scene.depth.at(x, y), (f64::from(raw(x, y)) * 0.0002) as f32);
    }
    // The farthest neighbour is the one to the lower right.
    assert_eq!(scene.depth.at(4, 2), (f64::from(raw(5, 3)) * 0.0002) as f32);
    assert_eq!((scene.unknown_share, scene.nonfinite_pixels), (0.1, 0));
    assert!(scene.notes[0].contains("10.0 %"), "{:?}", scene.notes);
}

#[test]
fn damaged_pixels_are_counted_once_and_replaced() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.exr");
    let mut color = Image::filled(UVec2::new(8, 8), Vec3::splat(0.5));
    let mut depth = Image::filled(color.size, 3.0_f32);
    color.pixels[9] = Vec3::new(0.1, f32::NAN, 0.1);
    color.pixels[20] = Vec3::new(f32::INFINITY, 0.0, 0.0);
    depth.pixels[20] = f32::NAN;
    depth.pixels[33] = -1.0;
    depth.pixels[34] = 0.0;
    image_io::write_exr(&path, &color, Some(&depth), None).unwrap_or_else(|e| panic!("{e}"));
    let scene = rgbd::load(&path, None, &DepthEncoding::METRES, 0.7).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((scene.nonfinite_pixels, scene.unknown_share), (4, 0.0));
    assert!(scene.color.pixels.iter().all(|rgb| (*rgb - 0.5).abs().max_element() < 1e-6));
    assert!(scene.depth.pixels.iter().all(|d| *d == 3.0));
    assert!(scene.notes[0].starts_with("4 pixels"), "{:?}", scene.notes);
}
