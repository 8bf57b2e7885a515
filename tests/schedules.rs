//! Work on tiles by lists and by branches gives the same pictures.

mod common;

use common::{front_camera, gpu, lens, quad, textured, unlit};
use defocus::gpu::{FrameStats, Schedule, download};
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{uvec2, vec2, vec3};
use std::sync::Arc;

/// A strip before a wall in focus: tiles in focus, of one blur, and at edges. The size ends
/// within a tile.
fn view() -> View {
    let near = quad(1.0, vec2(-0.3, -0.9), vec2(0.1, 0.9), 0);
    let wall = quad(4.0, vec2(-9.0, -7.0), vec2(9.0, 7.0), 1);
    let mut scene = common::scene(vec![near, wall], vec![unlit(vec3(0.9, 0.5, 0.1)), textured()]);
    scene.textures = vec![Arc::new(common::uv_grid_texture(uvec2(64, 64)))];
    let scene = GpuScene::new(gpu(), &scene, SurfaceOptions::default());
    View::of_scene(scene, front_camera(), uvec2(133, 77), 9).unwrap()
}

fn render(method: &dyn Method, lens: &Lens, schedule: Schedule) -> (ColorImage, FrameStats) {
    gpu().set_schedule(schedule);
    let mut frame = gpu().frame();
    let picture = methods::record(method, &mut frame, &mut view(), lens).unwrap();
    let stats = frame.finish().stats;
    (download(gpu(), &picture), stats)
}

/// Whether a method lists tiles: a frame that is recorded and given up tells.
fn lists_tiles(method: &dyn Method, lens: &Lens) -> bool {
    gpu().set_schedule(Schedule::TileLists);
    let mut frame = gpu().frame();
    methods::record(method, &mut frame, &mut view(), lens).unwrap();
    frame.stats.indirect_dispatches > 0
}

#[test]
fn lists_and_branches_give_the_same_pictures() {
    let lens = lens(6.0, 4.0);
    let mut with_lists = Vec::new();
    for method in methods::all() {
        let id = method.about().id;
        if id == "accumulation" || !lists_tiles(&*method, &lens) {
            continue;
        }
        with_lists.push(id);
        let (by_lists, lists) = render(&*method, &lens, Schedule::TileLists);
        let (by_branches, branches) = render(&*method, &lens, Schedule::Branches);
        assert_eq!(by_lists.pixels, by_branches.pixels, "{id}");
        assert_eq!(branches.indirect_dispatches, 0, "{id}: branches need no grid that the GPU decides");
        assert!(branches.passes < lists.passes, "{id}: {} passes, {} by lists", branches.passes, lists.passes);
    }
    assert!(with_lists.contains(&"multiview") && with_lists.contains(&"adaptive"), "{with_lists:?}");
}

/// Tap by tap, as software adapters do it, and by windows in a workgroup's memory: the same taps
/// in the same order.
#[test]
fn separable_filters_alike_by_windows() {
    // Filters within a window, and over several; hardware has windows from a CoC of 14 px on.
    for (coc_px, reach) in [(15.0, "neighbours"), (30.0, "own"), (90.0, "neighbours"), (180.0, "own")] {
        let mut separable = methods::by_id("separable").expect("a method");
        methods::set_param(&mut *separable, "reach", reach).unwrap();
        let lens = lens(coc_px, 2.0);
        let [taps, windows] = [Schedule::TileLists, Schedule::Branches].map(|s| render(&*separable, &lens, s).0);
        assert_eq!(taps.pixels, windows.pixels, "K {coc_px} px, reach {reach}");
    }
}

#[test]
fn schedules_have_names() {
    for schedule in [Schedule::TileLists, Schedule::Branches] {
        assert_eq!(schedule.to_string().parse(), Ok(schedule));
    }
    let error = "none".parse::<Schedule>().unwrap_err().to_string();
    assert!(error.contains("'none'") && error.contains("lists, branches"), "{error}");
}
