//! Depth of field in a program that is not ours: it has its own device and has drawn a
//! colour and a depth texture; `defocus` gives back a blurred texture on the same device.
//!
//! cargo run --example embed [METHOD]

use defocus::gpu::{Gpu, download, wanted_features, wanted_limits};
use defocus::lens::Lens;
use defocus::methods;
use defocus::view::{DepthConvention, ForeignFrame, View};

const SIDE: u32 = 256;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let method = methods::by_id(&std::env::args().nth(1).unwrap_or("mipmap".into()))?;

    // What the other program has: a device opened its own way, and two textures.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: adapter.features() & wanted_features(),
        required_limits: wanted_limits(&adapter.limits()),
        ..Default::default()
    }))?;
    let color = texture(&device, &queue, wgpu::TextureFormat::Rgba8UnormSrgb, |x, y| {
        let bright = if (x / 8 + y / 8) % 2 == 0 { 230 } else { 40 };
        [bright, bright, if x > SIDE / 2 { 90 } else { bright }, 255]
    });
    // A conventional depth buffer: the left half at 0.5 m, the right half at 4 m.
    let (near_m, far_m) = (0.1, 100.0);
    let value = |d: f64| (far_m * (d - near_m) / (d * (far_m - near_m))) as f32;
    let depth = texture(&device, &queue, wgpu::TextureFormat::R32Float, |x, _| {
        value(if x < SIDE / 2 { 0.5 } else { 4.0 }).to_le_bytes()
    });

    // Depth of field, focused on the right half.
    let gpu = Gpu::from_device(&adapter.get_info(), device, queue);
    let mut frame = gpu.frame();
    let convention = DepthConvention::Conventional { far_m };
    let foreign = ForeignFrame { color: &color, depth: &depth, convention, near_m, fov_y: 0.8 };
    let mut view = View::of_foreign(&mut frame, &foreign)?;
    let lens = Lens { aperture_diameter_mm: 5.0, focus_distance_m: 4.0, ..Lens::PINHOLE };
    let blurred = methods::record(&*method, &mut frame, &mut view, &lens)?;
    frame.finish();

    // `blurred.raw()` is a wgpu texture of linear colour to go on with; here, a number.
    let image = download(&gpu, &blurred);
    let contrast = |x: u32| {
        let rows = image.pixels.chunks(SIDE as usize).map(|row| row[x as usize].y);
        rows.clone().fold(0.0, f32::max) - rows.fold(1.0, f32::min)
    };
    println!("{}: contrast {:.2} at 0.5 m, {:.2} at 4 m", method.about().id, contrast(40), contrast(200));
    Ok(())
}

fn texture<F: Fn(u32, u32) -> [u8; 4]>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    format: wgpu::TextureFormat,
    texel: F,
) -> wgpu::Texture {
    use wgpu::util::DeviceExt;
    let size = wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let (dimension, view_formats) = (wgpu::TextureDimension::D2, &[]);
    let (mip_level_count, sample_count, label) = (1, 1, None);
    let descriptor =
        wgpu::TextureDescriptor { label, size, mip_level_count, sample_count, dimension, format, usage, view_formats };
    let data: Vec<u8> = (0..SIDE * SIDE).flat_map(|i| texel(i % SIDE, i / SIDE)).collect();
    device.create_texture_with_data(queue, &descriptor, wgpu::util::TextureDataOrder::LayerMajor, &data)
}
