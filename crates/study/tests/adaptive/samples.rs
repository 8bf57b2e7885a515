//! The layers and samples that rays are cast through: how often they are drawn, and where they
//! lie.

use super::common::{self, gpu, quad, textured, unlit};
use super::{alike_at_all_depths, bars, lens, pixel_m, psnr_db, view_of};
use defocus::gpu::{download, download_depth};
use defocus::lens::Lens;
use defocus::methods;
use defocus::methods::adaptive::Adaptive;
use defocus::view::{FineDrawing, PeelOrder, Peeled, View};
use glam::{Vec3, vec2};

#[test]
fn layers_are_drawn_once_and_only_where_something_hidden_can_show() {
    let method = Adaptive::default();
    let stats = |view: &mut View, lens: &Lens| {
        let mut frame = gpu().frame();
        methods::record(&method, &mut frame, view, lens).unwrap();
        frame.finish().stats
    };
    let mut wall = view_of(vec![quad(4.0, vec2(-9.0, -9.0), vec2(9.0, 9.0), 0)], vec![textured()]);
    wall.set_fine_drawing(FineDrawing::Interleaved);
    let flat = stats(&mut wall, &lens());
    // A draw for each sample of a pixel, of which the pinhole image is one.
    assert_eq!(flat.views, 4, "{flat:?}");
    assert_eq!(flat.skipped.get("nothing hidden shows: no layers"), Some(&1));

    let mut view = bars();
    view.set_fine_drawing(FineDrawing::Interleaved);
    let first = stats(&mut view, &lens());
    // Four texels a pixel: of four layers, but that one of the first is the pinhole image,
    // and of the first three times more.
    assert_eq!(first.views, 4 * (4 + 3), "{first:?}");
    let refocused = stats(&mut view, &common::lens(11.0, 2.1));
    assert_eq!(refocused.views, 0, "a lens slider draws nothing: {refocused:?}");
}

/// Where coverage alone counts, the same layers, and samples of a regular grid: hardware draws them so.
#[test]
fn layers_drawn_at_once_are_those_that_are_interleaved() {
    let drawn = |drawing| {
        let mut view = bars();
        view.set_fine_drawing(drawing);
        let mut frame = gpu().frame();
        let texture = methods::record(&Adaptive::default(), &mut frame, &mut view, &lens()).unwrap();
        let views = frame.finish().stats.views;
        (download(gpu(), &texture), views)
    };
    let (interleaved, many) = drawn(FineDrawing::Interleaved);
    let (at_once, few) = drawn(FineDrawing::AtOnce);
    let db = psnr_db(&at_once, &interleaved);
    println!("{db:.1} dB, {few} draws for {many}");
    // The pinhole image, samples, and three hidden layers.
    assert_eq!(few, 5);
    // Samples that are interleaved are staggered too: an edge along a column lies up to 3/16 px elsewhere, on
    // average of a pixel's rows 1/16 px, by which pixels differ where neighbours do.
    let differ = |x: u32, y: u32| (at_once.at(x, y) - at_once.at(x + 1, y)).abs().max_element() > 0.05;
    let size = at_once.size - 1;
    let count = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y))).filter(|(x, y)| differ(*x, *y)).count();
    let edges = count as f64 / f64::from(size.element_product());
    let worst_db = -10.0 * (edges / (16.0 * 16.0)).log10();
    assert!(db >= worst_db, "{db} dB of at least {worst_db}");
    assert!(db < 60.0, "the samples lie in one grid: {db} dB");
}

#[test]
fn samples_hold_the_pinhole_image_at_pixel_centres() {
    let mut view = bars();
    let mut frame = gpu().frame();
    let pinhole = view.pinhole(&mut frame);
    frame.flush();
    let (color, depth) = (download(gpu(), &pinhole.color), download_depth(gpu(), &pinhole.depth));
    for (fineness, draws) in [(1, 1), (2, 1), (3, 1), (1, 3), (2, 2)] {
        let order = PeelOrder { count: 2, fineness, draws, separation: alike_at_all_depths(0.01), lights: true };
        let Peeled { samples, samples_a_side, .. } = view.peeled(&mut frame, &order).unwrap();
        frame.flush();
        assert_eq!(samples.color.size(), color.size * samples_a_side);
        let (all_colors, all_depths) = (download(gpu(), &samples.color), download_depth(gpu(), &samples.depth));
        for (x, y) in (0..depth.size.y).flat_map(|y| (0..depth.size.x).map(move |x| (x, y))) {
            let (at_x, at_y) = (samples_a_side * x, samples_a_side * y);
            assert_eq!(color.at(x, y), all_colors.at(at_x, at_y), "{fineness}, {draws}: colour at {x}, {y}");
            assert_eq!(depth.at(x, y), all_depths.at(at_x, at_y), "{fineness}, {draws}: depth at {x}, {y}");
        }
    }
}

/// Samples lie where they say: moved to the right, a picture shows what lies to the right.
#[test]
fn samples_lie_between_pixel_centres() {
    // Its edge passes 0.3 px to the right of a pixel's centre.
    let edge_m = (0.5 + 0.3) * pixel_m();
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 1);
    let front = quad(1.0, vec2(-9.0, -9.0), vec2(edge_m, 9.0), 0);
    let mut view = view_of(vec![wall, front], vec![unlit(Vec3::X), unlit(Vec3::Y)]);
    let mut frame = gpu().frame();
    let order = PeelOrder { count: 1, fineness: 2, draws: 2, separation: alike_at_all_depths(0.01), lights: true };
    let Peeled { samples, .. } = view.peeled(&mut frame, &order).unwrap();
    frame.finish();
    let colors = download(gpu(), &samples.color);
    let pixel = colors.size.x / 4 / 2;
    // At 0 and a quarter of a pixel the front covers, at a half and three quarters not.
    let row: Vec<f32> = (0..4).map(|part| colors.at(4 * pixel + part, colors.size.y / 2).x).collect();
    assert_eq!(row, [1.0, 1.0, 0.0, 0.0], "samples of pixel {pixel}");
}
