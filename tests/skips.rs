//! Work follows need, by time: what is in focus costs little.

mod common;

use common::gpu;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{UVec2, uvec2, vec2};

const SIZE: UVec2 = uvec2(320, 240);

const WALL_M: f64 = 2.0;
const STRIP_M: f64 = 1.0;

/// What `mipmap` may read with the overscan of this view: the paper counts 20.98.
const MIPMAP_READS_PER_PX: f64 = 16.0;

/// The most that `multiview` reads where all is blurred alike: two for each of 64 rays, and what finds
/// its tiles and slabs.
const MULTIVIEW_READS_PER_PX: f64 = 140.0;

/// A wall, and before it a strip over the left of the frame: with what its blur reaches, a
/// tenth of it.
fn wall_and_strip() -> View {
    let aspect = SIZE.x as f32 / SIZE.y as f32;
    let half_height_at = |depth_m: f32| depth_m * 30f32.to_radians().tan();
    let (wall, strip) = (half_height_at(WALL_M as f32), half_height_at(STRIP_M as f32));
    let right = strip * aspect * (2.0 * 0.08 - 1.0);
    let meshes = vec![
        common::quad(WALL_M as f32, vec2(-2.0 * aspect * wall, -2.0 * wall), vec2(2.0 * aspect * wall, 2.0 * wall), 0),
        common::quad(STRIP_M as f32, vec2(-2.0 * aspect * strip, -2.0 * strip), vec2(right, 2.0 * strip), 0),
    ];
    let scene = common::scene(meshes, vec![common::textured()]);
    let surfaces = GpuScene::new(gpu(), &scene, SurfaceOptions::default());
    View::of_scene(surfaces, common::front_camera(), SIZE, 8).unwrap()
}

/// A lens focused at `focus_m` with a CoC of `coc_px` at `depth_m`.
fn lens(focus_m: f64, depth_m: f64, coc_px: f64) -> Lens {
    let unit = common::lens(1.0, focus_m);
    common::lens(coc_px / unit.coc_diameter_px(depth_m).abs(), focus_m)
}

/// Texture reads of a run after one through another lens, so that all that depends on
/// the lens is made anew, but for layers, which stay until the focus distance has doubled or
/// halved. Counted, not timed: the same on every machine.
fn reads(method: &dyn Method, view: &mut View, lens: &Lens) -> f64 {
    let other = Lens { focus_distance_m: 0.85 * lens.focus_distance_m, ..lens.clone() };
    let mut run = |lens: &Lens| {
        let mut frame = gpu().frame();
        let count = frame.count_texture_reads();
        methods::record(method, &mut frame, view, lens).unwrap();
        let count = frame.read_buffer::<u64>(&count)[0];
        frame.finish();
        count as f64 / f64::from(SIZE.element_product())
    };
    [&other, lens].map(&mut run)[1]
}

#[test]
fn a_scene_that_is_mostly_in_focus_reads_little() {
    let mut view = wall_and_strip();
    // One blur for both: 8 px. Where the wall is in focus the strip alone has it.
    let mostly = lens(WALL_M, STRIP_M, 8.0);
    let none = lens(4.0 / 3.0, STRIP_M, 8.0);
    assert!((none.coc_diameter_px(WALL_M).abs() - 8.0).abs() < 0.1, "both surfaces are blurred alike");
    let mut costly = Vec::new();
    println!("method | 90 % in focus, reads per px | all defocused, reads per px | ratio");
    // What is aimed at is a quarter. Where all is blurred alike a ray of `multiview` takes two reads, the
    // fewest there can be. `mipmap` has few passes over the whole frame, which read little wherever the
    // blur is. `adaptive` reads a third less than that where all is blurred alike, up to four times the rays
    // where the strip ends, and near focus two rows of samples a step.
    for (id, greatest) in [("mipmap", 1.0), ("splat", 0.25), ("multiview", 0.2), ("adaptive", 0.7)] {
        let method = methods::by_id(id).unwrap();
        let [sharp, blurred] = [&mostly, &none].map(|lens| reads(&*method, &mut view, lens));
        println!("{id} | {sharp:.1} | {blurred:.1} | {:.2}", sharp / blurred);
        if id == "mipmap" && blurred > MIPMAP_READS_PER_PX {
            costly.push(format!("{id}: {blurred:.1} reads per px"));
        }
        if id == "multiview" && blurred > MULTIVIEW_READS_PER_PX {
            costly.push(format!("{id}: {blurred:.1} reads per px"));
        }
        if sharp > greatest * blurred {
            costly.push(format!("{id}: {sharp:.1} reads per px in focus, {blurred:.1} defocused"));
        }
    }
    assert!(costly.is_empty(), "{costly:?}");
}

#[test]
fn a_scene_wholly_in_focus_is_copied() {
    let mut view = wall_and_strip();
    // A lens so small that nothing is blurred.
    let sharp = lens(WALL_M, STRIP_M, 0.04);
    for method in methods::all() {
        let mut run = || {
            let mut frame = gpu().timed_frame();
            methods::record(&*method, &mut frame, &mut view, &sharp).unwrap();
            frame.finish().timings.wait()
        };
        // The first also draws.
        let passes = [run(), run()].map(|passes| passes.len())[1];
        assert_eq!(passes, 1, "{} does more than copy", method.about().id);
    }
}
