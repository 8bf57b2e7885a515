//! Its pictures converge while nothing moves, are as blurred at every size and number of
//! rays, and move no more than the reference's.

use super::common::{self, front_camera, gpu, quad, scene, unlit};
use super::{FOCUS_M, lens, psnr_db, render, textured_view};
use defocus::gpu::download;
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::adaptive::{Adaptive, AdaptiveRun, TURNED_FRAMES};
use defocus::methods::{Accumulation, Converging};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{UVec2, Vec3, uvec2, vec2};

#[test]
fn it_converges_to_accumulation_while_nothing_moves() {
    let size = uvec2(64, 48);
    let mut view = textured_view(size, 16);
    let truth = render(&Accumulation { samples: 1024, ..Accumulation::default() }, &mut view, &lens());
    let mut run = AdaptiveRun::new(Adaptive { points: 0, ..Adaptive::default() });
    let mut db = Vec::new();
    for target in [1, TURNED_FRAMES, 64, 256, TURNED_FRAMES + 512] {
        let mut frame = gpu().frame();
        while run.count() < target {
            run.advance(&mut frame, &mut view, &lens(), 1).unwrap();
        }
        let picture = run.mean(&mut frame);
        frame.finish();
        db.push(psnr_db(&download(gpu(), &picture), &truth));
    }
    println!("{db:.2?} dB after 1, {TURNED_FRAMES}, 64, 256 and {} frames", TURNED_FRAMES + 512);
    assert!(db.is_sorted(), "{db:?}: more frames are worse");
    assert!(db[4] > 50.0, "{db:?}");
}

/// Standard deviation, px, of a picture of one bright patch, on the horizontal axis.
fn width_px(image: &ColorImage) -> f64 {
    let moment = |power: i32, centre: f64| -> f64 {
        let weighted = |(i, p): (usize, &Vec3)| {
            let x = (i as u32 % image.size.x) as f64 + 0.5;
            f64::from(p.x) * (x - centre).powi(power)
        };
        image.pixels.iter().enumerate().map(weighted).sum()
    };
    let total = moment(0, 0.0);
    let centre = moment(1, 0.0) / total;
    (moment(2, centre) / total).sqrt()
}

/// A white patch, 1/12 of the frame's height wide, in a black sheet or alone in front of a
/// black wall, blurred by 1/8 of the height.
fn patch_width_px(size: UVec2, method: &Adaptive, in_sheet: bool) -> f64 {
    let half_m = (30f32.to_radians()).tan() / 12.0;
    let black_m = if in_sheet { 1.0 } else { 8.0 };
    let black = |min, max| quad(black_m, black_m * min, black_m * max, 1);
    let mut meshes = vec![quad(1.0, vec2(-half_m, -half_m), vec2(half_m, half_m), 0)];
    if in_sheet {
        meshes.push(black(vec2(-9.0, half_m), vec2(9.0, 9.0)));
        meshes.push(black(vec2(-9.0, -9.0), vec2(9.0, -half_m)));
        meshes.push(black(vec2(-9.0, -half_m), vec2(-half_m, half_m)));
        meshes.push(black(vec2(half_m, -half_m), vec2(9.0, half_m)));
    } else {
        meshes.push(black(vec2(-9.0, -9.0), vec2(9.0, 9.0)));
    }
    let surfaces =
        GpuScene::new(gpu(), &scene(meshes, vec![unlit(Vec3::ONE), unlit(Vec3::ZERO)]), SurfaceOptions::default());
    let mut view = View::of_scene(surfaces, front_camera(), size, 4).unwrap();
    let lens = common::lens(f64::from(size.y) / 8.0, FOCUS_M);
    width_px(&render(method, &mut view, &lens))
}

#[test]
fn blur_is_as_wide_at_every_resolution_and_number_of_rays() {
    for height in [48, 96, 192] {
        let size = uvec2(height * 4 / 3, height);
        // A disc and a square, independent of each other: variances add.
        let (radius, side) = (f64::from(height) / 16.0, f64::from(height) / 12.0);
        let expected = (radius * radius / 4.0 + side * side / 12.0).sqrt();
        for points in 0..4 {
            let method = Adaptive { points, ..Adaptive::default() };
            let [sheet, alone] = [true, false].map(|in_sheet| patch_width_px(size, &method, in_sheet));
            println!("{size}, {} rays: {sheet:.3} px in a sheet, {alone:.3} px alone, of {expected:.3}", 8 << points);
            let error = sheet / expected - 1.0;
            assert!(error.abs() < 0.02, "{size}, {} rays: {sheet} px in a sheet, not {expected}", 8 << points);
            // The offsets at which rays read make up for the filter's own blur within a surface,
            // not for that of its outline: up to 3/2 px^2, that of 5 pixels.
            let widest = (expected * expected + 1.5).sqrt();
            let within = expected * 0.98..widest * 1.02;
            assert!(within.contains(&alone), "{size}, {} rays: {alone} px alone, not {expected}", 8 << points);
        }
    }
}

/// Greatest of the mean absolute changes from frame to frame beyond the reference's own.
fn greatest_excess(frames: &[(ColorImage, ColorImage)]) -> f32 {
    let change = |a: &ColorImage, b: &ColorImage| -> f32 {
        let differences = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().element_sum() / 3.0);
        differences.sum::<f32>() / a.pixels.len() as f32
    };
    let excess = |pair: &[(ColorImage, ColorImage)]| change(&pair[0].0, &pair[1].0) - change(&pair[0].1, &pair[1].1);
    frames.windows(2).map(excess).fold(0.0, f32::max)
}

/// A slow pull of the focus and a slow move of the camera, 120 frames each.
#[test]
fn pictures_are_steady_in_motion() {
    const FRAMES: u32 = 120;
    let reference = Accumulation { samples: 32, ..Accumulation::default() };
    let method = Adaptive { draws: 1, ..Adaptive::default() };
    let mut view = textured_view(uvec2(32, 24), 8);
    let pair = |view: &mut View, lens: &Lens| (render(&method, view, lens), render(&reference, view, lens));
    let pulled: Vec<_> = (0..FRAMES)
        .map(|i| pair(&mut view, &common::lens(6.0, 1.2 + 1.6 * f64::from(i) / f64::from(FRAMES))))
        .collect();
    let moved: Vec<_> = (0..FRAMES)
        .map(|i| {
            let mut camera = front_camera();
            camera.position.x = 0.1 * f64::from(i) / f64::from(FRAMES);
            view.set_camera(camera);
            pair(&mut view, &common::lens(6.0, FOCUS_M))
        })
        .collect();
    let (pull, motion) = (greatest_excess(&pulled), greatest_excess(&moved));
    println!("greatest mean change beyond the reference's own: focus pull {pull:.5}, camera {motion:.5}");
    // One step of an 8-bit display on average over the frame: each of its 12 tiles that
    // changed its class with a jump of a tenth would be two.
    assert!(pull < 1.0 / 255.0, "focus pull: {pull}");
    assert!(motion < 1.0 / 255.0, "camera: {motion}");
}
