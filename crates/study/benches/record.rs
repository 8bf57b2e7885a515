//! What recording a frame costs the CPU, without the GPU's part: `cargo bench --bench record`.
//!
//! Each method is recorded at 1920x1080 into an encoder that is finished and then dropped.
//! Times are this thread's time on a processor, which hardly depends on what else the machine
//! does. The goal is at most 8 us a pass and 0.25 ms a frame for every method that runs in
//! real time.

use cpu_time::ThreadTime;
use criterion::{Criterion, criterion_group, criterion_main};
use defocus::gpu::Gpu;
use defocus::lens::Lens;
use defocus::methods::{self, Method};
use defocus::view::{SurfaceOptions, View};
use defocus_study::{DepthArgs, Source};
use glam::{UVec2, uvec2};
use std::time::Duration;

const SIZE: UVec2 = uvec2(1920, 1080);
const OVERSCAN_PX: u32 = 64;
const MEAN_COC_PX: f64 = 16.0;

/// Records one frame and gives it up. Returns its number of passes.
fn record(gpu: &Gpu, method: &dyn Method, view: &mut View, lens: &Lens) -> u64 {
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let mut recorder = gpu.recorder(&mut encoder);
    let picture = methods::record(method, &mut recorder, view, lens).expect("every method renders a scene");
    let passes = recorder.finish().stats.passes;
    drop((encoder.finish(), picture));
    passes
}

fn all_methods(c: &mut Criterion) {
    let gpu = Gpu::open(None).expect("a graphics adapter");
    let source = Source::open("cans", &DepthArgs::default()).expect("a built-in scene");
    let uploaded = source.upload(&gpu, SurfaceOptions::default());
    // Depths of a small view, where they are read back sooner.
    let depth = uploaded.view(0, SIZE / 8, 0, None).expect("a small size").depth_m(&gpu);
    let lens = source.default_lens(&depth).with_mean_coc(MEAN_COC_PX, depth.pixels.iter().copied());
    let lens = lens.expect("not all of the scene lies at one depth");
    let mut view = uploaded.view(0, SIZE, OVERSCAN_PX, None).expect("a common size");
    let mut frame = gpu.frame();
    view.z_bounds(&mut frame);
    frame.finish();
    let mut group = c.benchmark_group("record");
    for method in methods::all() {
        let id = method.about().id;
        // What a view keeps is there from the second frame on.
        let passes = [(); 2].map(|()| record(&gpu, &*method, &mut view, &lens))[1];
        group.bench_function(id, |b| {
            b.iter_custom(|rounds| {
                let start = ThreadTime::now();
                for _ in 0..rounds {
                    record(&gpu, &*method, &mut view, &lens);
                }
                start.elapsed()
            });
        });
        let frames = 100;
        let start = ThreadTime::now();
        for _ in 0..frames {
            record(&gpu, &*method, &mut view, &lens);
        }
        let us = start.elapsed().as_secs_f64() * 1e6 / f64::from(frames);
        println!("{id}: {passes} passes, {:.1} us a pass, {us:.0} us a frame", us / passes.max(1) as f64);
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .without_plots();
    targets = all_methods
}
criterion_main!(benches);
