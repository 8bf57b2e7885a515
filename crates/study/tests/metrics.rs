//! Metrics against outside implementations and closed forms.
//!
//! Expected numbers come from scikit-image 0.26 (`peak_signal_noise_ratio`;
//! `structural_similarity` with `gaussian_weights=True, sigma=1.5,
//! use_sample_covariance=False, data_range=1` on BT.601 luma), from NVIDIA's Python
//! package `flip-evaluator` on unquantised float images, and at run time from the crates
//! nv-flip (NVIDIA's C++ program) and image-compare. image-compare's SSIM is another
//! definition (8 x 8 blocks, sums in place of variances), so only its RMS is used.

use defocus::colormap::ColorMap;
use defocus::display::{Display, ToneMap};
use defocus::image::{ColorImage, Image};
use defocus::image_io::srgb::{linear_from_srgb_f32, srgb_from_linear_f32};
use defocus::viewing::Viewing;
use defocus_study::metrics::{
    CompareOptions, DEFAULT_PIXELS_PER_DEGREE, MetricsError, abs_error_map, compare, defocused_mask, flip_map,
    hdr_flip_map, rel_mse,
};
use glam::{UVec2, Vec3, uvec2};

const SIZE: UVec2 = uvec2(48, 36);

/// 8-bit pixels with a gradient, hard edges and high frequencies.
fn pattern(x: u32, y: u32) -> [u32; 3] {
    [(x * 5 + y * 3) % 256, if (x / 8 + y / 6) % 2 == 1 { 200 } else { 40 }, x * y % 256]
}

/// The pattern moved by a pixel, with noise.
fn distorted(x: u32, y: u32) -> [u32; 3] {
    let noise = (x * 37 + y * 91) % 17;
    pattern(x + 1, y).map(|c| (c + noise).min(255))
}

fn linear_image(f: impl Fn(u32, u32) -> [u32; 3]) -> ColorImage {
    Image::from_fn(SIZE, |x, y| Vec3::from(f(x, y).map(|c| linear_from_srgb_f32(c as f32 / 255.0))))
}

/// Highlights of up to 25 on a third of the tiles.
fn with_highlights(image: &ColorImage) -> ColorImage {
    let gain = |x: u32, y: u32| if (x / 12 + y / 12).is_multiple_of(3) { 25.0 } else { 1.0 };
    Image::from_fn(image.size, |x, y| image.at(x, y) * gain(x, y))
}

fn pair() -> (ColorImage, ColorImage) {
    (linear_image(distorted), linear_image(pattern))
}

fn noise(size: UVec2, seed: u32) -> ColorImage {
    let mut state = seed;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    Image::from_fn(size, |_, _| Vec3::new(next(), next(), next()))
}

/// Float rounding through sRGB there and back, over thousands of pixels.
fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found}, not {expected} +- {tolerance}");
}

#[test]
fn agrees_with_scikit_image() {
    let (test, reference) = pair();
    let metrics = compare(&test, &reference, &CompareOptions::default()).unwrap();
    // sRGB in f32 there and back is good to 1e-6 of a value.
    close(metrics.psnr_db.unwrap(), 13.799_456_208, 1e-4);
    close(metrics.ssim.unwrap(), 0.681_896_333, 1e-5);
    assert!(!metrics.identical);
    // Relative MSE has no function there; this is numpy's mean of its formula.
    close(rel_mse(&with_highlights(&test), &with_highlights(&reference)).unwrap(), 6.438_912_893, 1e-4);
}

#[test]
fn agrees_with_nvidias_flip_on_floats() {
    let (test, reference) = pair();
    // Both sum in f32 with kernels of some 20 taps: 1e-5 of values up to 100, through a
    // power of 0.7 near 0.
    for (ppd, mean, at) in [
        (DEFAULT_PIXELS_PER_DEGREE, 0.382_603_765, [0.143_404_78, 0.272_327_63, 0.979_700_51]),
        (30.0, 0.453_503_847, [0.066_631_74, 0.396_158_1, 0.984_320_1]),
    ] {
        let viewing = Viewing { px_per_degree: f64::from(ppd), ..Viewing::default() };
        let options = CompareOptions { viewing, ..Default::default() };
        close(compare(&test, &reference, &options).unwrap().flip, mean, 1e-4);
        let map = flip_map(&test, &reference, Display::default(), ppd).unwrap();
        for (expected, (x, y)) in at.into_iter().zip([(0, 0), (20, 20), (47, 35)]) {
            close(f64::from(map.at(x, y)), expected, 2e-4);
        }
    }
}

#[test]
fn agrees_with_nv_flip_everywhere() {
    let bytes = |f: fn(u32, u32) -> [u32; 3]| -> Vec<u8> {
        let pixels = (0..SIZE.y).flat_map(|y| (0..SIZE.x).flat_map(move |x| f(x, y)));
        pixels.map(|c| c as u8).collect()
    };
    let image = |data: Vec<u8>| nv_flip::FlipImageRgb8::with_data(SIZE.x, SIZE.y, &data);
    let theirs = nv_flip::flip(image(bytes(pattern)), image(bytes(distorted)), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    let (test, reference) = pair();
    let ours = flip_map(&test, &reference, Display::default(), DEFAULT_PIXELS_PER_DEGREE).unwrap();
    // As above, per pixel.
    let worst = ours.pixels.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 2e-4, "greatest difference {worst}");
}

#[test]
fn agrees_with_nvidias_hdr_flip() {
    let (test, reference) = pair();
    let (test, reference) = (with_highlights(&test), with_highlights(&reference));
    let map = hdr_flip_map(&test, &reference, DEFAULT_PIXELS_PER_DEGREE).unwrap().unwrap();
    for (expected, (x, y)) in [0.694_541_8, 0.294_768_15, 0.983_229_2].into_iter().zip([(0, 0), (20, 20), (47, 35)]) {
        close(f64::from(map.at(x, y)), expected, 2e-4);
    }
    let options = CompareOptions { hdr_flip: true, ..Default::default() };
    close(compare(&test, &reference, &options).unwrap().hdr_flip.unwrap(), 0.454_177_976, 1e-4);
    // No light, no exposure range.
    let black = Image::filled(SIZE, Vec3::ZERO);
    assert_eq!(compare(&test, &black, &options).unwrap().hdr_flip, None);
    // A black median bounds the exposures instead of letting them run to infinity.
    let spark = Image::from_fn(SIZE, |x, y| if (x, y) == (9, 9) { Vec3::ONE } else { Vec3::ZERO });
    assert!(compare(&test, &spark, &options).unwrap().hdr_flip.unwrap() > 0.0);
}

#[test]
fn psnr_agrees_with_image_compare() {
    let (test, reference) = pair();
    let gray = |f: fn(u32, u32) -> [u32; 3], channel: usize| {
        image::GrayImage::from_fn(SIZE.x, SIZE.y, |x, y| image::Luma([f(x, y)[channel] as u8]))
    };
    let mse: f64 = (0..3)
        .map(|channel| {
            let rms = image_compare::Algorithm::RootMeanSquared;
            let (a, b) = (gray(distorted, channel), gray(pattern, channel));
            // Its score is 1 - RMS.
            (1.0 - image_compare::gray_similarity_structure(&rms, &a, &b).unwrap().score).powi(2) / 3.0
        })
        .sum();
    let found = compare(&test, &reference, &CompareOptions::default()).unwrap().psnr_db.unwrap();
    close(found, -10.0 * mse.log10(), 1e-4);
}

#[test]
fn constant_differences_have_closed_forms() {
    // Encoded values 0.5 and 0.6.
    let of = |encoded: f32| Image::filled(SIZE, Vec3::splat(linear_from_srgb_f32(encoded)));
    let (test, reference) = (of(0.6), of(0.5));
    let metrics = compare(&test, &reference, &CompareOptions::default()).unwrap();
    // f32 rounding of 0.1: 1e-6 relative.
    close(metrics.psnr_db.unwrap(), 20.0, 1e-4);
    close(metrics.worst_block_psnr_db.unwrap(), 20.0, 1e-4);
    // No variance: only the luminance term is left.
    close(metrics.ssim.unwrap(), (2.0 * 0.3 + 1e-4) / (0.25 + 0.36 + 1e-4), 1e-5);
    let (a, b) = (f64::from(linear_from_srgb_f32(0.6)), f64::from(linear_from_srgb_f32(0.5)));
    close(metrics.rel_mse, (a - b).powi(2) / (b * b + 0.01), 1e-9);
    let map = abs_error_map(&test, &reference, Display::default()).unwrap();
    assert!(map.pixels.iter().all(|p| (*p - 0.1).abs().max_element() < 1e-6));
}

#[test]
fn flip_of_black_and_white_is_that_of_the_paper() {
    // Flat images have no features, so FLIP is the remapped colour difference: black and
    // white differ by 100 in lightness, to be compared with green against blue.
    let (black, white) = (Image::filled(SIZE, Vec3::ZERO), Image::filled(SIZE, Vec3::ONE));
    let error = compare(&white, &black, &CompareOptions::default()).unwrap().flip;
    // Hunt-adjusted L*a*b* of sRGB green (87.73, -75.6, 73.0) and blue (32.30, 25.6,
    // -34.8): HyAB = 55.43 + hypot(101.2, 107.8), good to its 4 digits.
    let max = (55.43_f64 + 101.2_f64.hypot(107.8)).powf(0.7);
    let knee = 0.4 * max;
    close(error, 0.95 + 0.05 * (100_f64.powf(0.7) - knee) / (max - knee), 1e-3);
}

#[test]
fn what_does_not_exist_is_none() {
    let (image, _) = pair();
    let metrics = compare(&image, &image, &CompareOptions { hdr_flip: true, ..Default::default() }).unwrap();
    assert!(metrics.identical);
    assert_eq!((metrics.psnr_db, metrics.worst_block_psnr_db, metrics.worst_block), (None, None, None));
    assert_eq!((metrics.flip, metrics.hdr_flip, metrics.rel_mse), (0.0, Some(0.0), 0.0));
    close(metrics.ssim.unwrap(), 1.0, 1e-12);

    // Equal on the display, not in the data.
    let (one, two) = (Image::filled(SIZE, Vec3::ONE), Image::filled(SIZE, Vec3::splat(2.0)));
    let metrics = compare(&one, &two, &CompareOptions::default()).unwrap();
    assert!(!metrics.identical && metrics.psnr_db.is_none() && metrics.rel_mse > 0.0);

    let small = |seed| noise(uvec2(10, 11), seed);
    let metrics = compare(&small(1), &small(2), &CompareOptions::default()).unwrap();
    assert!(metrics.ssim.is_none() && metrics.psnr_db.is_some() && metrics.flip > 0.0);
    let json = serde_json::to_value(&metrics).unwrap();
    assert!(json["ssim"].is_null() && json["psnr_db"].is_number(), "{json}");

    let single = compare(&noise(UVec2::ONE, 1), &noise(UVec2::ONE, 2), &CompareOptions::default()).unwrap();
    assert!(single.flip > 0.0 && single.worst_block == Some(UVec2::ZERO));
}

#[test]
fn the_mask_selects_pixels() {
    let (_, reference) = pair();
    let mut test = reference.clone();
    test.pixels[0] = Vec3::ONE - test.pixels[0];
    let with = |mask: &Image<bool>| {
        let options = CompareOptions { defocused: Some(mask), ..Default::default() };
        compare(&test, &reference, &options).unwrap()
    };
    let all = with(&Image::filled(SIZE, true));
    assert_eq!(all.psnr_defocused_db, all.psnr_db);
    assert_eq!(with(&Image::filled(SIZE, false)).psnr_defocused_db, None);
    // Half of the pixels with all of the error: 3 dB less.
    let half = with(&Image::from_fn(SIZE, |x, _| x < SIZE.x / 2));
    close(half.psnr_defocused_db.unwrap(), all.psnr_db.unwrap() - 10.0 * 2_f64.log10(), 1e-9);
    let elsewhere = with(&Image::from_fn(SIZE, |x, y| (x, y) != (0, 0)));
    assert_eq!(elsewhere.psnr_defocused_db, None);
}

#[test]
fn the_mask_holds_blurred_and_changed_pixels() {
    let pinhole = Image::filled(uvec2(4, 1), Vec3::splat(0.5));
    let mut reference = pinhole.clone();
    reference.pixels[2] = Vec3::splat(0.6);
    // Within the rounding of half floats.
    reference.pixels[3] = Vec3::splat(0.500_1);
    let coc = Image { size: uvec2(4, 1), pixels: vec![-1.0, 0.9, 0.0, 0.0] };
    let mask = defocused_mask(&coc, &pinhole, &reference).unwrap();
    assert_eq!(mask.pixels, [true, false, true, false]);
}

#[test]
fn the_worst_block_is_found() {
    let reference = Image::filled(SIZE, Vec3::splat(0.5));
    let mut test = reference.clone();
    // A slight error everywhere and a grave one in the bottom right block, which is cut
    // to 8 x 4 px.
    test.pixels.iter_mut().for_each(|p| *p += 0.001);
    let spot = (SIZE.x * SIZE.y - 1) as usize;
    test.pixels[spot] = Vec3::splat(linear_from_srgb_f32(srgb_from_linear_f32(0.5) - 0.25));
    let metrics = compare(&test, &reference, &CompareOptions::default()).unwrap();
    assert_eq!(metrics.worst_block, Some(uvec2(40, 32)));
    // One of 32 pixels is wrong by a quarter; the others add 1e-6 to the mean of 2e-3.
    close(metrics.worst_block_psnr_db.unwrap(), -10.0 * (0.0625_f64 / 32.0).log10(), 5e-3);
}

#[test]
fn mistakes_are_named() {
    let image = Image::filled(SIZE, Vec3::ONE);
    let options = CompareOptions::default();
    let error = |test: &ColorImage, options: &CompareOptions| compare(test, &image, options).unwrap_err();
    let message = error(&Image::filled(uvec2(3, 2), Vec3::ONE), &options).to_string();
    assert!(message.contains("3 x 2 px") && message.contains("48 x 36 px"), "{message}");
    let mut broken = image.clone();
    broken.pixels[50].y = f32::NAN;
    broken.pixels[60].x = f32::INFINITY;
    let not_finite = MetricsError::NotFinite { what: "test image", count: 2, first: uvec2(2, 1) };
    assert_eq!(error(&broken, &options), not_finite);
    let mask = Image::filled(uvec2(1, 1), true);
    let message = error(&image, &CompareOptions { defocused: Some(&mask), ..options }).to_string();
    assert!(message.contains("mask is 1 x 1 px"), "{message}");
    for px_per_degree in [0.0, f64::NAN, 1e6] {
        let viewing = Viewing { px_per_degree, ..options.viewing };
        let options = CompareOptions { viewing, ..options };
        assert!(matches!(error(&image, &options), MetricsError::PixelsPerDegree(_)));
    }
    let empty = Image::filled(UVec2::ZERO, Vec3::ONE);
    assert_eq!(rel_mse(&empty, &empty), Err(MetricsError::Empty));
}

#[test]
fn srgb_is_that_of_the_standard() {
    for (linear, encoded) in [(0.0, 0.0), (0.003_130_8, 0.040_449_9), (0.214_041_14, 0.5), (1.0, 1.0)] {
        close(f64::from(srgb_from_linear_f32(linear)), encoded, 1e-6);
    }
    for step in 0..=1000 {
        let value = step as f32 / 1000.0;
        close(f64::from(linear_from_srgb_f32(srgb_from_linear_f32(value))), f64::from(value), 1e-6);
    }
}

#[test]
fn tone_maps_do_what_they_say() {
    let shown = |tone_map, exposure_ev, value: f32| Display { tone_map, exposure_ev }.linear(Vec3::splat(value)).x;
    assert_eq!(shown(ToneMap::None, 0.0, 3.0), 1.0);
    assert_eq!(shown(ToneMap::None, -2.0, 2.0), 0.5);
    assert_eq!(shown(ToneMap::None, 0.0, -1.0), 0.0);
    close(f64::from(shown(ToneMap::Reinhard, 0.0, 1.0)), 0.5, 1e-6);
    close(f64::from(shown(ToneMap::Reinhard, 1.0, 1.5)), 0.75, 1e-6);
    // Wrensch's listing evaluated in double precision at middle grey.
    close(f64::from(shown(ToneMap::Agx, 0.0, 0.18)).powf(1.0 / 2.2), 0.496_676_19, 1e-5);
    for tone_map in ToneMap::ALL {
        assert_eq!(tone_map.to_string().parse(), Ok(tone_map));
        let mut last = -1.0;
        for step in 0..200 {
            let value = shown(tone_map, 0.0, step as f32 * 0.05);
            assert!((0.0..=1.0).contains(&value), "{tone_map}: {value}");
            // The fit falls by less than its error where it saturates.
            assert!(value >= last - 2e-3, "{tone_map} falls at {step}: {value} after {last}");
            last = value;
        }
        // Infinity and zero stay displayable.
        assert!(Display { tone_map, exposure_ev: 40.0 }.linear(Vec3::splat(1e20)).is_finite());
        assert!(Display { tone_map, exposure_ev: 0.0 }.linear(Vec3::ZERO).max_element() < 1e-3);
    }
    assert!("filmic".parse::<ToneMap>().unwrap_err().to_string().contains("none, reinhard and agx"));
}

#[test]
fn color_maps_are_matplotlibs() {
    // NVIDIA's copy of magma, all 256 entries; 33 are kept here, and interpolation
    // between them is off by at most 1.3, rounding by half.
    let magma = nv_flip::magma_lut().to_vec();
    for (i, theirs) in magma.chunks_exact(3).enumerate() {
        let ours = ColorMap::Magma.srgb8(i as f32 / 255.0);
        for (a, b) in ours.into_iter().zip(theirs) {
            assert!(a.abs_diff(*b) <= 2, "entry {i}: {ours:?}, not {theirs:?}");
        }
    }
    // Viridis' published ends and middle.
    assert_eq!(ColorMap::Viridis.srgb8(-1.0), [68, 1, 84]);
    assert_eq!(ColorMap::Viridis.srgb8(2.0), [253, 231, 37]);
    let middle = ColorMap::Viridis.srgb8(0.5);
    assert!(middle.iter().zip([33, 145, 140]).all(|(a, b)| a.abs_diff(b) <= 2), "{middle:?}");
    let map = Image { size: uvec2(3, 1), pixels: vec![0.0, 0.2, f32::NAN] };
    assert_eq!(ColorMap::Magma.apply(&map, 0.2).pixels, [[0, 0, 4], [252, 253, 191], [0, 0, 0]]);
}
