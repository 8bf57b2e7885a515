//! Devices that are opened with the limits that every adapter has.

use defocus::gpu::Gpu;
use defocus::methods::{self, MethodError};
use defocus::view::SurfaceOptions;
use defocus_study::{DepthArgs, Source};
use glam::{UVec2, uvec2};

/// A device without optional features and with these limits.
fn gpu_with(required_limits: wgpu::Limits) -> Gpu {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Gpu::from_device(&adapter.get_info(), device, queue)
}

/// Records a frame of every method at this size without running it. Returns the methods
/// that say that it is too large.
fn refusals(gpu: &Gpu, size: UVec2) -> Vec<&'static str> {
    let source = Source::open("cans", &DepthArgs::default()).unwrap();
    let uploaded = source.upload(gpu, SurfaceOptions::default());
    // Depths of a small view, where they are read back sooner.
    let depth = uploaded.view(0, uvec2(64, 48), 0, None).unwrap().depth_m(gpu);
    let lens = source.default_lens(&depth).with_mean_coc(16.0, depth.pixels.iter().copied()).unwrap();
    let mut view = uploaded.view(0, size, 40, None).unwrap();
    let finite: Vec<f32> = depth.pixels.iter().copied().filter(|d| d.is_finite()).collect();
    let [near, far] =
        [finite.iter().copied().fold(f32::INFINITY, f32::min), finite.iter().copied().fold(0.0, f32::max)];
    view.set_depth_range_m(Some([f64::from(near), f64::from(far)]));
    let mut refused = Vec::new();
    for method in methods::all() {
        let id = method.about().id;
        view.redraw();
        let scope = gpu.device().push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let mut recorder = gpu.recorder(&mut encoder);
        match methods::record(&*method, &mut recorder, &mut view, &lens) {
            Ok(_) => {}
            Err(error @ MethodError::TooLarge { .. }) => {
                let text = error.to_string();
                assert!(text.starts_with(id) && text.contains("make it smaller"), "{text}");
                println!("{text}");
                refused.push(id);
            }
            Err(other) => panic!("{id}: {other}"),
        }
        recorder.finish();
        // Finished, so that it is checked, and given up.
        drop(encoder.finish());
        let error = pollster::block_on(scope.pop());
        assert!(error.is_none(), "{id} at {size}: {}", error.unwrap());
    }
    refused
}

#[test]
fn all_methods_render_2560x1440_or_say_that_they_cannot() {
    let gpu = gpu_with(wgpu::Limits::default());
    let refused = refusals(&gpu, uvec2(2560, 1440));
    // Lights of `adaptive` take 48 bytes a pixel.
    assert!(refused.iter().all(|id| *id == "adaptive"), "{refused:?}");
}

#[test]
fn what_is_too_large_is_refused_in_words() {
    // A megabyte where the sorted pixels of `scatter` take 1.5.
    let limits = wgpu::Limits { max_storage_buffer_binding_size: 1 << 20, ..wgpu::Limits::default() };
    let refused = refusals(&gpu_with(limits), uvec2(640, 480));
    assert!(refused.contains(&"scatter") && !refused.contains(&"mipmap"), "{refused:?}");
}
