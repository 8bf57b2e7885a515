//! Aperture shapes: their density, their moments, and the points that stand for them.

use defocus::aperture::{Aperture, ApertureError, ApertureImage};
use glam::{DVec2, UVec2, dvec2};
use std::sync::Arc;

/// A crooked image: an L of two intensities, off centre, with a wide and a narrow side.
fn image() -> Aperture {
    let pixels = (0..12 * 9).map(|i| match (i % 12, i / 12) {
        (2..=4, 1..=7) => 1.0,
        (5..=9, 5..=7) => 0.25,
        _ => 0.0,
    });
    Aperture::Image(Arc::new(ApertureImage::new("L", UVec2::new(12, 9), pixels.collect()).unwrap()))
}

fn all() -> Vec<Aperture> {
    vec![
        Aperture::Disc,
        Aperture::polygon(3),
        Aperture::polygon(6),
        Aperture::Polygon { blades: 5, rotation_deg: 20.0, roundness: 0.4 },
        Aperture::Gaussian { sigma_per_coc: 0.5 },
        Aperture::Gaussian { sigma_per_coc: 0.25 },
        image(),
    ]
}

fn mean(points: &[DVec2]) -> DVec2 {
    points.iter().sum::<DVec2>() / points.len() as f64
}

/// Standard deviation per axis over CoC diameter: half of that of v.
fn sigma_per_coc(points: &[DVec2]) -> f64 {
    let centre = mean(points);
    let squares: f64 = points.iter().map(|p| (*p - centre).length_squared()).sum();
    0.5 * (0.5 * squares / points.len() as f64).sqrt()
}

/// Midpoints of a grid over the aperture's bounds, and the area of a cell.
fn grid(aperture: &Aperture, side: u32) -> (impl Iterator<Item = DVec2>, f64) {
    let half = aperture.radius();
    let step = 2.0 * half / f64::from(side);
    let at = move |i: u32| -half + (f64::from(i) + 0.5) * step;
    ((0..side * side).map(move |i| dvec2(at(i % side), at(i / side))), step * step)
}

#[test]
fn density_integrates_to_one_about_zero() {
    for aperture in all() {
        let (points, area) = grid(&aperture, 600);
        let (mut total, mut first, mut second) = (0.0, DVec2::ZERO, 0.0);
        for v in points {
            let share = aperture.intensity(v) * area;
            (total, first, second) = (total + share, first + share * v, second + share * v.length_squared());
        }
        // The edge crosses about 2000 of 360000 cells, each half wrong at most and with
        // random sign: well below 1e-3 in the sum. An image's 12 x 9 pixels are no
        // multiple of the grid either: a cell's width at every pixel's edge.
        let tolerance = if matches!(aperture, Aperture::Image(_)) { 1e-2 } else { 1e-3 };
        assert!((total - 1.0).abs() < tolerance, "{aperture}: integral {total}");
        assert!(first.length() < tolerance, "{aperture}: centroid {first}");
        let sigma = 0.5 * (0.5 * second).sqrt();
        assert!((sigma / aperture.sigma_per_coc() - 1.0).abs() < tolerance, "{aperture}: sigma {sigma}");
    }
}

#[test]
fn closed_forms_of_sigma() {
    assert_eq!(Aperture::Disc.sigma_per_coc(), 0.25);
    // Second moment of a regular polygon with circumradius 1, per axis:
    // (2 + cos(2 pi / N)) / 12.
    for blades in [3_u32, 4, 6, 16] {
        let variance = (2.0 + (std::f64::consts::TAU / f64::from(blades)).cos()) / 12.0;
        let sigma = Aperture::polygon(blades).sigma_per_coc();
        assert!((sigma - 0.5 * variance.sqrt()).abs() < 1e-12, "{blades} blades: {sigma}");
    }
    let round = Aperture::Polygon { blades: 5, rotation_deg: 0.0, roundness: 1.0 };
    assert!((round.sigma_per_coc() - 0.25).abs() < 1e-12);
    // A lit square of side 2 has the variance 4/12 per axis.
    let square = ApertureImage::new("square", UVec2::splat(4), vec![0.5; 16]).unwrap();
    let sigma = Aperture::Image(Arc::new(square)).sigma_per_coc();
    assert!((sigma - 0.5 * (4.0_f64 / 12.0).sqrt()).abs() < 1e-12, "square: {sigma}");
}

#[test]
fn points_have_the_moments_of_the_density() {
    for aperture in all() {
        let points = aperture.lens_points(4096);
        // A scrambled net's error is near N^-1.5 for smooth integrands (4e-6) and near
        // N^-0.75 (2e-3) with an edge; the maps of polygon and image have kinks.
        assert!(mean(&points).length() < 2e-3, "{aperture}: mean {}", mean(&points));
        let sigma = sigma_per_coc(&points);
        assert!((sigma / aperture.sigma_per_coc() - 1.0).abs() < 2e-3, "{aperture}: sigma {sigma}");
    }
}

#[test]
fn points_lie_where_the_density_is_not_zero() {
    for aperture in all() {
        let radius = aperture.radius() * (1.0 + 1e-12);
        for v in aperture.lens_points(4096) {
            assert!(v.length() <= radius, "{aperture}: {v} beyond {radius}");
            // A point may round onto the edge itself: one part in 1e9 towards the centre.
            assert!(aperture.intensity(v * (1.0 - 1e-9)) > 0.0, "{aperture}: {v} is dark");
        }
    }
}

#[test]
fn points_follow_the_density_in_every_quadrant() {
    for aperture in all() {
        let points = aperture.lens_points(4096);
        let (cells, area) = grid(&aperture, 400);
        let mut expected = [0.0; 4];
        let quadrant = |v: DVec2| usize::from(v.x > 0.0) + 2 * usize::from(v.y > 0.0);
        cells.for_each(|v| expected[quadrant(v)] += aperture.intensity(v) * area);
        for (q, expected) in expected.into_iter().enumerate() {
            let found = points.iter().filter(|v| quadrant(**v) == q).count() as f64 / 4096.0;
            // A line crosses about 2 sqrt(N) of a net's N cells: 128 / 4096 of the points
            // at worst, a quarter of it by the random signs.
            assert!((found - expected).abs() < 8e-3, "{aperture}, quadrant {q}: {found}, not {expected}");
        }
    }
}

/// Greatest difference between the share of points in a box at the corner and its area.
fn star_discrepancy(points: &[DVec2]) -> f64 {
    let coordinates = |i: usize| (i as f64 + 1.0) / 64.0;
    let mut worst: f64 = 0.0;
    for (x, y) in (0..64 * 64).map(|i| (coordinates(i % 64), coordinates(i / 64))) {
        let inside = points.iter().filter(|p| p.x < x && p.y < y).count() as f64;
        worst = worst.max((inside / points.len() as f64 - x * y).abs());
    }
    worst
}

/// A square image of one intensity is the unit square itself, moved and scaled.
fn unit_square_points(range: std::ops::Range<u32>) -> Vec<DVec2> {
    let square = Aperture::Image(Arc::new(ApertureImage::new("one", UVec2::ONE, vec![1.0]).unwrap()));
    range.map(|i| 0.5 * (square.lens_point(i) + DVec2::ONE)).collect()
}

#[test]
fn every_prefix_is_a_good_set() {
    // (0,2)-nets in base 2 have a star discrepancy below (log2 N / 2 + 3/2) / N
    // (Niederreiter 1992, chapter 4); a prefix is a union of at most log2 N such nets.
    for n in [16_u32, 64, 256, 1024] {
        let bound = (f64::from(n.ilog2()) / 2.0 + 1.5) / f64::from(n);
        let found = star_discrepancy(&unit_square_points(0..n));
        assert!(found <= bound, "{n} points: {found} above {bound}");
    }
    for n in [11_u32, 50, 100, 777] {
        let bound = (1..=n.ilog2()).map(|m| f64::from(m) / 2.0 + 1.5).sum::<f64>() / f64::from(n);
        // Random points have above 0.87 / sqrt(n), the mean of Kolmogorov's law in one
        // dimension.
        let found = star_discrepancy(&unit_square_points(0..n));
        assert!(found <= bound.min(0.87 / f64::from(n).sqrt()), "{n} points: {found}");
    }
}

#[test]
fn every_aligned_block_is_stratified() {
    // The definition of a (0,m,2)-net: one point in each elementary interval of area 1/64.
    for first in [0_u32, 64, 192, 4096 - 64] {
        let points = unit_square_points(first..first + 64);
        for columns in [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0] {
            let cell = |p: &DVec2| ((p.x * columns) as usize, (p.y * 64.0 / columns) as usize);
            let cells: std::collections::HashSet<_> = points.iter().map(cell).collect();
            assert_eq!(cells.len(), 64, "block at {first}, {columns} columns");
        }
    }
}

#[test]
fn halves_are_as_good_as_each_other() {
    for aperture in all() {
        let points = aperture.lens_points(1024);
        let (first, second) = points.split_at(512);
        // As for 4096 points, (4096/512)^0.75 = 5 times as much.
        for half in [first, second] {
            assert!(mean(half).length() < 1e-2, "{aperture}: mean {}", mean(half));
            assert!((sigma_per_coc(half) / aperture.sigma_per_coc() - 1.0).abs() < 1e-2, "{aperture}");
        }
    }
}

#[test]
fn polygon_is_symmetric_and_rotates_clockwise() {
    let hexagon = Aperture::polygon(6);
    for v in hexagon.lens_points(256) {
        for k in 1..6 {
            let turned = DVec2::from_angle(std::f64::consts::FRAC_PI_3 * f64::from(k)).rotate(v * 0.999);
            assert!(hexagon.intensity(turned) > 0.0, "{v} turned by {k} sixths");
        }
    }
    // A corner up (y down: -y) at 0 degrees; to the right of up for a small rotation.
    let triangle = |rotation_deg| Aperture::Polygon { blades: 3, rotation_deg, roundness: 0.0 };
    assert!(triangle(0.0).intensity(dvec2(0.0, -0.99)) > 0.0);
    assert_eq!(triangle(0.0).intensity(dvec2(0.0, 0.51)), 0.0);
    let up_right = 0.99 * DVec2::from_angle(-60_f64.to_radians());
    assert!(triangle(30.0).intensity(up_right) > 0.0);
    assert_eq!(triangle(-30.0).intensity(up_right), 0.0);
}

#[test]
fn text_and_saved_states_round_trip() {
    for text in ["disc", "polygon:6", "polygon:5:12.5", "polygon:7:0:0.5", "gaussian:0.3"] {
        let aperture: Aperture = text.parse().unwrap();
        assert_eq!(aperture.to_string(), text);
    }
    assert_eq!("gaussian".parse(), Ok(Aperture::Gaussian { sigma_per_coc: 0.5 }));
    for aperture in all() {
        let json = serde_json::to_string(&aperture).unwrap();
        assert_eq!(serde_json::from_str::<Aperture>(&json).unwrap(), aperture);
        let ron = ron::to_string(&aperture).unwrap();
        assert_eq!(ron::from_str::<Aperture>(&ron).unwrap(), aperture);
    }
}

#[test]
fn image_files_are_read_and_reduced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ring.png");
    let ring = image::GrayImage::from_fn(600, 300, |x, _| image::Luma([if x < 300 { 255 } else { 0 }]));
    ring.save(&path).unwrap();
    let aperture: Aperture = format!("image:{}", path.display()).parse().unwrap();
    let Aperture::Image(image) = &aperture else { panic!("{aperture} is no image") };
    assert_eq!(image.size(), UVec2::new(256, 128));
    // The left half is lit: its centroid lies at a quarter of the width. Reduction blurs
    // the edge by less than a pixel.
    assert!((image.centroid_px() - dvec2(64.0, 64.0)).length() < 0.5, "{}", image.centroid_px());
    assert_eq!(aperture.to_string(), format!("image:{}", path.display()));
}

#[test]
fn mistakes_are_named() {
    let error = |text: &str| text.parse::<Aperture>().unwrap_err().to_string();
    assert!(error("heart").contains("there is no kind 'heart'"));
    assert!(error("disc:1").contains("takes no parameters"));
    assert!(error("polygon").contains("number of blades is missing"));
    assert!(error("polygon:six").contains("N is 'six'"));
    assert!(error("polygon:2").contains("number of blades is 2: it must be 3 to 16"));
    assert!(error("polygon:6:0:2").contains("roundness is 2"));
    assert!(error("polygon:6:nan").contains("rotation is NaN"));
    assert!(error("gaussian:0").contains("above 0"));
    assert!(error("gaussian:nan").contains("above 0"));
    assert!(error("image:").contains("file's name is missing"));
    assert!(error("image:no/such.png").contains("cannot read the aperture image 'no/such.png'"));
    let black = ApertureImage::new("night", UVec2::splat(2), vec![0.0; 4]).unwrap_err();
    assert!(matches!(&black, ApertureError::BadImage { cause, .. } if cause.contains("black")), "{black}");
    let broken = r#"{"Image":{"name":"x","size":[2,2],"pixels":[1.0]}}"#;
    assert!(serde_json::from_str::<Aperture>(broken).unwrap_err().to_string().contains("1 pixels"));
}
