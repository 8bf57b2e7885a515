//! What runs on the CPU: `cargo bench`.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use defocus::aperture::Aperture;
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::linear_cpu;
use defocus::presets;
use defocus::raytrace::{RayOptions, RayRender, RayScene, Shading};
use defocus_study::builtin;
use defocus_study::metrics::{self, CompareOptions};
use glam::{UVec2, Vec3, uvec2};
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

const SIZE: UVec2 = uvec2(256, 192);

/// A chequer with gradients, `phase` apart from another: detailed, and nowhere equal.
fn picture(phase: f32) -> ColorImage {
    Image::from_fn(SIZE, |x, y| {
        let chequer = ((x / 4 + y / 4) % 2) as f32;
        Vec3::new(chequer, x as f32 / SIZE.x as f32, (0.1 * y as f32 + phase).sin().abs())
    })
}

fn lens_points(c: &mut Criterion) {
    let mut group = c.benchmark_group("lens points");
    group.throughput(Throughput::Elements(1024));
    for aperture in [Aperture::Disc, Aperture::polygon(6)] {
        group.bench_function(aperture.to_string(), |b| b.iter(|| black_box(&aperture).lens_points(1024)));
    }
    group.finish();
}

fn all_metrics(c: &mut Criterion) {
    let (test, reference) = (picture(0.0), picture(0.1));
    let mut group = c.benchmark_group("metrics");
    group.throughput(Throughput::Elements(u64::from(SIZE.element_product())));
    group.bench_function("all", |b| {
        b.iter(|| metrics::compare(black_box(&test), &reference, &CompareOptions::default()).expect("equal sizes"));
    });
    group.bench_function("relative MSE", |b| {
        b.iter(|| metrics::rel_mse(black_box(&test), &reference).expect("equal sizes"));
    });
    group.finish();
}

fn linear(c: &mut Criterion) {
    let color = picture(0.0);
    let mut group = c.benchmark_group("linear on the CPU");
    group.throughput(Throughput::Elements(u64::from(SIZE.element_product())));
    for greatest_px in [8.0, 32.0] {
        let coc_px = Image::from_fn(SIZE, |x, _| greatest_px * x as f32 / SIZE.x as f32);
        group.bench_function(format!("CoC to {greatest_px} px"), |b| b.iter(|| linear_cpu(black_box(&color), &coc_px)));
    }
    group.finish();
}

/// The lens of the papers' projection screen.
fn lens() -> Lens {
    presets::preset("projection").expect("a preset of this program").lens
}

fn raytrace(c: &mut Criterion) {
    let scene = Arc::new(builtin::builtin("cans").expect("a built-in scene").load().expect("a sound file"));
    let camera = scene.cameras[0].camera;
    let mut group = c.benchmark_group("raytrace cans");
    group.bench_function("build", |b| b.iter(|| RayScene::new(black_box(scene.clone()), &camera).expect("triangles")));
    let rays = Arc::new(RayScene::new(scene.clone(), &camera).expect("triangles"));
    let projection = camera.projection(SIZE, 0);
    let options = RayOptions { lens_points: 0..1, shading: Shading::Unlit, view_dependent: false };
    group.throughput(Throughput::Elements(u64::from(SIZE.element_product())));
    group.bench_function("one ray a pixel", |b| {
        let start = || RayRender::new(rays.clone(), &projection, &lens(), &options).expect("a lens that focuses");
        b.iter_batched_ref(start, |render| render.advance(1, &AtomicBool::new(false)), BatchSize::PerIteration);
    });
    group.finish();
}

fn gltf(c: &mut Criterion) {
    let mut group = c.benchmark_group("load glTF");
    for name in ["branches", "cans"] {
        let scene = builtin::builtin(name).expect("a built-in scene");
        group.throughput(Throughput::Bytes(scene.glb().len() as u64));
        group.bench_function(name, |b| b.iter(|| black_box(scene).load().expect("a sound file")));
    }
    group.finish();
}

/// Ten samples in a few seconds each: these are milliseconds to seconds, not nanoseconds.
fn few_samples() -> Criterion {
    Criterion::default().sample_size(10).measurement_time(Duration::from_secs(3)).without_plots()
}

criterion_group! {
    name = cpu;
    config = few_samples();
    targets = lens_points, all_metrics, linear, raytrace, gltf
}
criterion_main!(cpu);
