//! `gather`: its layers, sprites and stages, on pictures whose blur is known.

mod common;
mod views;

use common::{gpu, lens};
use defocus::aperture::Aperture;
use defocus::gpu::FrameStats;
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Gather, Method};
use glam::{UVec2, Vec3, uvec2};
use views::{blurred, depths_of, energy, noise, point, variance_px2, view_of};

const SIZE: UVec2 = uvec2(96, 64);

fn wide_lens() -> Lens {
    lens(60.0, 2.0)
}

fn full() -> Gather {
    Gather { resolution: 0, ..Gather::default() }
}

fn both() -> [(&'static str, Gather); 2] {
    [("full", full()), ("half", Gather::default())]
}

/// Left of 48 px white at the CoC `white_px`, right of it black at `black_px`.
fn halves(method: &Gather, white_px: f32, black_px: f32) -> ColorImage {
    let is_left = |x: u32| x < SIZE.x / 2;
    let color = ColorImage::from_fn(SIZE, |x, _| if is_left(x) { Vec3::ONE } else { Vec3::ZERO });
    let coc = Image::from_fn(SIZE, |x, _| if is_left(x) { white_px } else { black_px });
    blurred(method, &color, &wide_lens(), &coc)
}

/// Share of a disc of radius 1 on the side of a straight line, `x` radii from its centre.
fn disc_share(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 - (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI
}

#[test]
fn foreground_spreads_as_a_disc_over_what_is_in_focus() {
    let _turn = views::turn();
    for (name, method) in both() {
        for coc_px in [8.0f32, 16.0, 24.0] {
            let picture = halves(&method, -coc_px, 0.0);
            for x in 49..SIZE.x {
                let distance = f64::from(x) + 0.5 - 48.0;
                let wanted = disc_share(2.0 * distance / f64::from(coc_px));
                let got = f64::from(picture.at(x, 32).x);
                // A tap of three rings covers a seventh of the disc.
                assert!((got - wanted).abs() < 0.09, "{name}, C = {coc_px}, {distance} px outside: {got} of {wanted}");
            }
        }
    }
}

#[test]
fn what_is_in_focus_stays_out_of_blurred_background() {
    let _turn = views::turn();
    for (name, method) in both() {
        let picture = halves(&method, 0.0, 16.0);
        for x in 0..SIZE.x {
            let wanted = if x < 48 { 1.0 } else { 0.0 };
            assert!((picture.at(x, 32).x - wanted).abs() < 2e-3, "{name}, {x}: {}", picture.at(x, 32));
        }
    }
}

#[test]
fn what_is_behind_fills_what_a_blurred_foreground_leaves_open() {
    let _turn = views::turn();
    for (name, method) in both() {
        // The foreground's own half of the disc at its edge, the black behind it in the other.
        let inside = |fill| halves(&Gather { fill, ..method.clone() }, -16.0, 0.0).at(46, 32).x;
        assert!((0.4..0.75).contains(&inside(true)), "{name}: {}", inside(true));
        assert!(inside(false) > 0.98, "{name}: {}", inside(false));
    }
}

#[test]
fn without_the_near_field_foreground_ends_at_its_outline() {
    let _turn = views::turn();
    for (name, method) in both() {
        let outside = |near| halves(&Gather { near, ..method.clone() }, -16.0, 0.0).at(50, 32).x;
        assert!(outside(true) > 0.25, "{name}: {}", outside(true));
        assert!(outside(false) < 2e-3, "{name}: {}", outside(false));
    }
}

#[test]
fn sprites_keep_a_points_light_and_width() {
    let _turn = views::turn();
    for (name, method) in both() {
        for coc_px in [-12.0f32, 9.0, 16.0, 23.0] {
            let image = point(SIZE, 64.0);
            let spread = blurred(&method, &image, &wide_lens(), &Image::filled(SIZE, coc_px));
            let kept = energy(&spread) / 64.0;
            // A texel of half resolution keeps a mean of four pixels, and f16 a few roundings.
            assert!((kept - 1.0).abs() < 0.02, "{name}, c = {coc_px}: {kept} of the light");
            for variance in variance_px2(&spread) {
                let wanted = f64::from(coc_px).powi(2) / 16.0;
                assert!((variance / wanted - 1.0).abs() < 0.1, "{name}, c = {coc_px}: {variance} of {wanted} px^2");
            }
        }
    }
}

#[test]
fn without_sprites_taps_meet_or_miss_a_point() {
    let _turn = views::turn();
    let light = |sprites| {
        let method = Gather { sprites, ..full() };
        let spread = blurred(&method, &point(SIZE, 64.0), &wide_lens(), &Image::filled(SIZE, 20.0));
        let lit = spread.pixels.iter().filter(|p| p.x > 0.02).count();
        (lit as f64, energy(&spread) / 64.0)
    };
    let area_px = std::f64::consts::PI * 100.0;
    assert!((light(true).0 / area_px - 1.0).abs() < 0.15, "{:?}", light(true));
    assert!(light(false).0 < 0.9 * area_px, "the disc has holes: {:?}", light(false));
}

#[test]
fn spots_have_the_apertures_shape() {
    let _turn = views::turn();
    let square = Aperture::Polygon { blades: 4, rotation_deg: 45.0, roundness: 0.0 };
    let lens = Lens { aperture: square, ..wide_lens() };
    for (name, method) in both() {
        for sprites in [true, false] {
            // A light of 5 x 5 px, which taps meet.
            let middle = SIZE / 2;
            let is_lit = |x: u32, y: u32| x.abs_diff(middle.x) <= 2 && y.abs_diff(middle.y) <= 2;
            let color = ColorImage::from_fn(SIZE, |x, y| if is_lit(x, y) { Vec3::splat(8.0) } else { Vec3::ZERO });
            let method = Gather { sprites, ..method.clone() };
            let spread = blurred(&method, &color, &lens, &Image::filled(SIZE, 24.0));
            // Along an axis the square ends where a disc of its width does, along a diagonal it
            // reaches farther or less far.
            let along =
                |dx: u32, dy: u32| (1..30).filter(|i| spread.at(middle.x + dx * i, middle.y + dy * i).x > 0.02).count();
            let (axis, diagonal) = (along(1, 0) as f64, along(1, 1) as f64 * 2f64.sqrt());
            let ratio = (diagonal / axis).max(axis / diagonal);
            assert!(ratio > 1.15, "{name}, sprites {sprites}: {axis} px along the axis, {diagonal} along the diagonal");
        }
    }
}

/// Each stage can be left out, whatever else there is, and says so in the picture.
#[test]
fn every_stage_can_be_switched_off_and_changes_the_picture() {
    let _turn = views::turn();
    let color = {
        let mut color = noise(SIZE);
        color.pixels[(20 * SIZE.x + 70) as usize] = Vec3::splat(200.0);
        color
    };
    let coc = Image::from_fn(SIZE, |x, y| match (x, y) {
        (20..=40, 15..=45) => -14.0,
        (41..=55, _) => 0.0,
        (85.., _) => 2.2,
        _ => 12.0,
    });
    let render = |method: &dyn Method| blurred(method, &color, &wide_lens(), &coc);
    let whole = render(&Gather::default());
    for key in ["prefilter", "tiles", "near", "fill", "slight", "sprites"] {
        let mut method: Box<dyn Method> = Box::new(Gather::default());
        methods::set_param(method.as_mut(), key, "off").unwrap();
        let without = render(method.as_ref());
        assert!(without.pixels.iter().all(|p| p.is_finite()), "{key}");
        let differs = views::greatest_difference(&whole, &without);
        // Tiles save work alone.
        let limit = if key == "tiles" { 0.05 } else { f32::MAX };
        assert!(differs < limit && (key == "tiles" || differs > 0.02), "{key}: {differs}");
    }
    for filter in ["median", "mean"] {
        let mut method: Box<dyn Method> = Box::new(Gather::default());
        methods::set_param(method.as_mut(), "post_filter", filter).unwrap();
        let filtered = render(method.as_ref());
        assert!(filtered.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0), "{filter}");
        assert!(views::greatest_difference(&whole, &filtered) > 0.005, "{filter}");
    }
}

fn stats_of(method: &Gather, color: &ColorImage, coc_px: &Image<f32>) -> FrameStats {
    let lens = wide_lens();
    let mut view = view_of(color, &depths_of(&lens, coc_px));
    let mut frame = gpu().frame();
    view.z_bounds(&mut frame);
    frame.finish();
    let mut frame = gpu().frame();
    methods::record(method, &mut frame, &mut view, &lens).unwrap();
    frame.finish().stats
}

#[test]
fn a_frame_is_four_to_six_passes_and_says_what_it_skips() {
    let _turn = views::turn();
    let behind = Image::from_fn(SIZE, |x, _| 0.2 * x as f32);
    let dim = stats_of(&Gather::default(), &noise(SIZE), &behind);
    assert_eq!(dim.passes, 4, "{dim:?}");
    let skipped: Vec<&str> = dim.skipped.keys().map(String::as_str).collect();
    assert_eq!(skipped, ["no foreground: no near field", "no highlights: no sprites", "view unchanged"]);
    let filtered = Gather { post_filter: 1, ..Gather::default() };
    assert_eq!(stats_of(&filtered, &point(SIZE, 64.0), &behind.map(|c| c - 6.0)).passes, 6);
}
