//! What a frame of each method consists of at 1920x1080: passes, draws of the scene, bytes.
//! Frames are recorded and not executed, as on hardware, so that the counts are the same on
//! every adapter.
//!
//! [`BUDGETS`] are upper bounds: what an improvement saves is taken off them in the same
//! change. [`GOALS`] are aims, met or not: `cargo test --test budgets -- --nocapture` prints
//! them, and one that is met has to be taken into the budgets.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::gpu;
use defocus::gpu::{FrameStats, Schedule};
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::{SurfaceOptions, View};
use defocus_study::{DepthArgs, GpuSource, Source};
use glam::{UVec2, uvec2};

const SIZE: UVec2 = uvec2(1920, 1080);

/// Margin, px: half the greatest CoC of the view at a mean of 16 px.
const OVERSCAN_PX: u32 = 40;

/// Bytes of a megabyte.
const MB: u64 = 1_000_000;

/// What changes before a frame.
#[derive(Clone, Copy, PartialEq)]
enum Change {
    Nothing,
    Lens,
    Camera,
}

/// What a frame may consist of, at most.
struct Budget {
    method: &'static str,
    /// While nothing changes.
    passes: u64,
    /// Of those, dispatches whose grid the GPU decides.
    indirect: u64,
    /// Draws of the scene while nothing, the lens and the camera change.
    draws: [u64; 3],
    /// Textures and buffers at once while nothing or the camera changes, MB.
    mb: u64,
}

const BUDGETS: &[Budget] = &[
    Budget { method: "pinhole", passes: 1, indirect: 0, draws: [0, 0, 1], mb: 45 },
    Budget { method: "accumulation", passes: 129, indirect: 0, draws: [64, 64, 64], mb: 150 },
    Budget { method: "mipmap", passes: 5, indirect: 0, draws: [0, 0, 1], mb: 99 },
    Budget { method: "multiview", passes: 6, indirect: 0, draws: [0, 0, 3], mb: 624 },
    Budget { method: "preblur", passes: 2, indirect: 0, draws: [0, 0, 1], mb: 46 },
    Budget { method: "separable", passes: 2, indirect: 0, draws: [0, 0, 1], mb: 63 },
    Budget { method: "linear", passes: 2, indirect: 0, draws: [0, 0, 1], mb: 64 },
    Budget { method: "pyramid", passes: 17, indirect: 0, draws: [0, 0, 1], mb: 167 },
    Budget { method: "opaque", passes: 8, indirect: 0, draws: [0, 0, 1], mb: 101 },
    Budget { method: "splat", passes: 7, indirect: 0, draws: [1, 1, 2], mb: 239 },
    Budget { method: "scatter", passes: 108, indirect: 0, draws: [0, 0, 1], mb: 165 },
    Budget { method: "gather", passes: 5, indirect: 0, draws: [0, 0, 1], mb: 80 },
    Budget { method: "lens-layers", passes: 18, indirect: 0, draws: [0, 0, 4], mb: 328 },
    Budget { method: "adaptive", passes: 12, indirect: 0, draws: [0, 0, 4], mb: 1539 },
];

/// What a goal is about.
enum Aim {
    /// Passes while nothing changes.
    Passes(u64),
    /// Draws of the scene while the camera moves.
    CameraDraws(u64),
    /// MB while nothing changes.
    Mb(u64),
}

/// Aims that counts can show; the others are times and belong to `script/gpu-check`.
const GOALS: &[(&str, Aim)] = &[
    ("mipmap", Aim::Passes(12)),
    ("multiview", Aim::CameraDraws(3)),
    ("adaptive", Aim::CameraDraws(4)),
    ("adaptive", Aim::Mb(400)),
];

/// The methods as hardware has them.
fn all_methods() -> Vec<Box<dyn Method>> {
    let mut all = methods::all();
    for method in all.iter_mut().filter(|m| m.about().id == "splat") {
        methods::set_param(&mut **method, "by", "tiles").unwrap();
    }
    all
}

/// The scene of all counts, and a lens of a mean CoC of `coc_px`.
fn stage(coc_px: f64) -> (View, Lens) {
    gpu().set_schedule(Schedule::Branches);
    let source = Source::open("cans", &DepthArgs::default()).unwrap();
    let uploaded: GpuSource = source.upload(gpu(), SurfaceOptions::default());
    // Depths of a small view, where they are read back sooner.
    let depth = uploaded.view(0, SIZE / 8, 0, None).unwrap().depth_m(gpu());
    let lens = source.default_lens(&depth).with_mean_coc(coc_px, depth.pixels.iter().copied()).unwrap();
    let mut view = uploaded.view(0, SIZE, OVERSCAN_PX, None).unwrap();
    // The depths are waited for once; all that follows is only recorded.
    let mut frame = gpu().frame();
    view.z_bounds(&mut frame);
    frame.finish();
    (view, lens)
}

/// What a frame consists of in which this changes.
fn counted(method: &dyn Method, view: &mut View, lens: &Lens, change: Change) -> FrameStats {
    let record = |lens: &Lens, view: &mut View| {
        let mut encoder = gpu().device().create_command_encoder(&Default::default());
        let mut recorder = gpu().recorder(&mut encoder);
        let _picture = methods::record(method, &mut recorder, view, lens).unwrap();
        recorder.finish().stats
    };
    view.set_draft(change == Change::Camera);
    record(lens, view);
    let other = Lens { focus_distance_m: 1.01 * lens.focus_distance_m, ..lens.clone() };
    match change {
        Change::Nothing => record(lens, view),
        Change::Lens => record(&other, view),
        Change::Camera => {
            view.redraw();
            record(lens, view)
        }
    }
}

#[test]
fn no_method_takes_more_than_its_budget() {
    let (mut view, lens) = stage(16.0);
    let mut over = Vec::new();
    for method in all_methods() {
        let id = method.about().id;
        // What other methods kept in the view is not this one's.
        view.redraw();
        let [still, by_lens, camera] =
            [Change::Nothing, Change::Lens, Change::Camera].map(|change| counted(&*method, &mut view, &lens, change));
        let draws = [&still, &by_lens, &camera].map(|stats| stats.views);
        let mb = camera.peak_bytes().max(still.peak_bytes()).div_ceil(MB);
        println!(
            "Budget {{ method: \"{id}\", passes: {}, indirect: {}, draws: {draws:?}, mb: {mb} }}, // while the camera moves {} MB",
            still.passes,
            still.indirect_dispatches,
            camera.peak_bytes().div_ceil(MB)
        );
        let Some(budget) = BUDGETS.iter().find(|b| b.method == id) else {
            over.push(format!("{id} has no budget: give it what it takes"));
            continue;
        };
        let mut check = |what: &str, taken: u64, most: u64| {
            if taken > most {
                over.push(format!("{id}: {taken} {what}, the budget has {most}"));
            }
        };
        check("passes", still.passes, budget.passes);
        check("indirect dispatches", still.indirect_dispatches, budget.indirect);
        for (what, (taken, most)) in ["still", "lens", "camera"].iter().zip(draws.iter().zip(budget.draws)) {
            check(&format!("draws of the scene ({what})"), *taken, most);
        }
        check("MB", mb, budget.mb);
    }
    assert!(over.is_empty(), "{}", over.join("\n"));
}

#[test]
fn goals_that_are_met_are_in_the_budgets() {
    let (mut view, lens) = stage(16.0);
    for (id, aim) in GOALS {
        let method = methods::by_id(id).unwrap();
        let budget = BUDGETS.iter().find(|b| b.method == *id).expect("every method has a budget");
        view.redraw();
        let still = counted(&*method, &mut view, &lens, Change::Nothing);
        let camera = counted(&*method, &mut view, &lens, Change::Camera);
        let (what, taken, goal, held) = match aim {
            Aim::Passes(goal) => ("passes", still.passes, *goal, budget.passes <= *goal),
            Aim::CameraDraws(goal) => ("draws while the camera moves", camera.views, *goal, budget.draws[2] <= *goal),
            Aim::Mb(goal) => ("MB", still.peak_bytes().div_ceil(MB), *goal, budget.mb <= *goal),
        };
        let met = taken <= goal;
        println!("{id}: {taken} {what}, aimed at {goal}: {}", if met { "met" } else { "not met" });
        assert!(!met || held, "{id} meets its goal of {goal} {what}: lower its budget to that");
    }
}

/// No pass and no buffer depends on how much is blurred, but for methods whose paper says so.
#[test]
fn frames_of_wider_blur_draw_no_more_of_the_scene() {
    let (mut view, narrow) = stage(4.0);
    let wide = Lens { aperture_diameter_mm: 32.0 * narrow.aperture_diameter_mm, ..narrow.clone() };
    for method in all_methods().into_iter().filter(|m| m.about().id != "multiview") {
        let [few, many] = [&narrow, &wide].map(|lens| counted(&*method, &mut view, lens, Change::Camera).views);
        assert!(many <= few + 1, "{}: {few} draws at 4 px, {many} at 128", method.about().id);
    }
}
