//! Frames of other programs: every depth convention arrives as stored depth near / d.

mod common;

use common::gpu;
use defocus::view::{DepthConvention, ExternalFrame, View};
use glam::UVec2;
use wgpu::util::DeviceExt;

const NEAR_M: f64 = 0.2;
const FAR_M: f64 = 50.0;

fn texture(size: UVec2, format: wgpu::TextureFormat, bytes: &[u8]) -> wgpu::Texture {
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    gpu().device().create_texture_with_data(gpu().queue(), &descriptor, wgpu::util::TextureDataOrder::LayerMajor, bytes)
}

fn import(color: &[[f32; 4]], values: &[f32], convention: DepthConvention) -> View {
    let size = UVec2::new(values.len() as u32, 1);
    let color = texture(size, wgpu::TextureFormat::Rgba32Float, bytemuck::cast_slice(color));
    let depth = texture(size, wgpu::TextureFormat::R32Float, bytemuck::cast_slice(values));
    let external = ExternalFrame { color: &color, depth: &depth, convention, near_m: NEAR_M, fov_y: 0.8 };
    let mut frame = gpu().frame();
    let view = View::of_external(&mut frame, &external).unwrap();
    frame.finish();
    view
}

#[test]
fn every_convention_gives_the_depth_that_was_meant() {
    let depths_m = [0.2, 0.5, 3.0, 20.0, 50.0];
    // As the projections of those conventions write them, z / w.
    type Written = fn(f64) -> f64;
    let conventions: [(DepthConvention, Written); 4] = [
        (DepthConvention::ReversedInfinite, |d| NEAR_M / d),
        (DepthConvention::ConventionalInfinite, |d| 1.0 - NEAR_M / d),
        (DepthConvention::Reversed { far_m: FAR_M }, |d| NEAR_M * (FAR_M - d) / (d * (FAR_M - NEAR_M))),
        (DepthConvention::Conventional { far_m: FAR_M }, |d| FAR_M * (d - NEAR_M) / (d * (FAR_M - NEAR_M))),
    ];
    for (convention, written) in conventions {
        let values: Vec<f32> = depths_m.iter().map(|d| written(*d) as f32).collect();
        let mut view = import(&[[0.5; 4]; 5], &values, convention);
        for (found, wanted) in view.depth_m(gpu()).pixels.iter().zip(depths_m) {
            // The values are f32 near 1 in the conventional form: 6e-8 of near / d = 0.004.
            let error = (f64::from(*found) / wanted - 1.0).abs();
            assert!(error < 1e-4, "{convention:?}: {found} m for {wanted} m");
        }
        assert_eq!(view.repaired_pixels(gpu()), 0);
    }
}

#[test]
fn pixels_that_are_not_numbers_are_counted_and_replaced() {
    let mut color = [[0.5; 4]; 5];
    color[1][0] = f32::NAN;
    color[3][2] = f32::INFINITY;
    let mut view = import(&color, &[0.5, 0.5, f32::NAN, 0.5, 0.5], DepthConvention::ReversedInfinite);
    assert_eq!(view.repaired_pixels(gpu()), 3);
    let mut frame = gpu().frame();
    let layer = view.pinhole(&mut frame);
    frame.finish();
    assert!(defocus::gpu::download(gpu(), &layer.color).pixels.iter().all(|p| p.is_finite()));
}

#[test]
fn textures_that_do_not_fit_each_other_are_refused() {
    let color = texture(UVec2::new(2, 1), wgpu::TextureFormat::R32Float, &[0; 8]);
    let depth = texture(UVec2::new(1, 1), wgpu::TextureFormat::R32Float, &[0; 4]);
    let convention = DepthConvention::ReversedInfinite;
    let external = ExternalFrame { color: &color, depth: &depth, convention, near_m: NEAR_M, fov_y: 0.8 };
    let error = View::of_external(&mut gpu().frame(), &external).err().unwrap();
    assert!(error.to_string().contains("one size"), "{error}");
}
