//! Its pictures converge while nothing moves, and move little more than the reference's.

use super::common::{self, front_camera, gpu};
use super::{FOCUS_M, lens, psnr_db, render, textured_view};
use defocus::gpu::download;
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::adaptive::{Adaptive, AdaptiveRun, TURNED_FRAMES};
use defocus::methods::{Accumulation, Converging};
use defocus::view::View;
use glam::uvec2;

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

#[test]
fn a_draft_gives_way_to_the_picture_at_rest() {
    let mut view = textured_view(uvec2(64, 48), 16);
    let at_rest = render(&Adaptive::default(), &mut view, &lens());
    view.set_draft(true);
    let draft = render(&Adaptive::default(), &mut view, &lens());
    assert!(draft.pixels != at_rest.pixels, "a draft has all samples");
    view.set_draft(false);
    assert!(render(&Adaptive::default(), &mut view, &lens()).pixels == at_rest.pixels, "something of the draft stays");
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
