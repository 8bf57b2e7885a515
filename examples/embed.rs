//! Depth of field in a program that is not ours: it has its own device, draws a colour and a
//! depth texture with an encoder of its own, and goes on with the blurred texture in the same
//! encoder. It alone submits, once; nothing waits inside.
//!
//! cargo run --example embed [METHOD]

use defocus::gpu::{Gpu, Texture, download, wanted_features, wanted_limits, without_indirect_checks};
use defocus::lens::Lens;
use defocus::methods;
use defocus::view::{DepthConvention, ExternalFrame, View};

const SIDE: u32 = 256;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let method = methods::by_id(&std::env::args().nth(1).unwrap_or("mipmap".into()))?;

    // What the other program has: a device opened its own way, and what it draws.
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    without_indirect_checks(&mut descriptor);
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: adapter.features() & wanted_features(),
        required_limits: wanted_limits(&adapter.limits()),
        ..Default::default()
    }))?;
    let scene_color = texture(&device, &queue, wgpu::TextureFormat::Rgba8UnormSrgb, |x, y| {
        let bright = if (x / 8 + y / 8) % 2 == 0 { 230 } else { 40 };
        [bright, bright, if x > SIDE / 2 { 90 } else { bright }, 255]
    });
    // A conventional depth buffer: the left half at 0.5 m, the right half at 4 m.
    let (near_m, far_m) = (0.1, 100.0);
    let value = |d: f64| (far_m * (d - near_m) / (d * (far_m - near_m))) as f32;
    let scene_depth = texture(&device, &queue, wgpu::TextureFormat::R32Float, |x, _| {
        value(if x < SIDE / 2 { 0.5 } else { 4.0 }).to_le_bytes()
    });

    // Depth of field, focused on the right half. All is in sight between 0.5 and 4 m: a program
    // that does not know pays for the worst until the depths of a view have arrived.
    let gpu = Gpu::from_device(&adapter.get_info(), device, queue);
    let lens = Lens { aperture_diameter_mm: 5.0, focus_distance_m: 4.0, ..Lens::PINHOLE };
    let [color, depth] = [&scene_color, &scene_depth].map(|texture| target_like(&gpu, texture));
    let convention = DepthConvention::Conventional { far_m };
    let external = ExternalFrame { color: &color, depth: &depth, convention, near_m, fov_y: 0.8 };

    // A frame of the program: its scene, then the lens, then what it does with the picture.
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    draw_scene(&mut encoder, [&scene_color, &scene_depth], [&color, &depth]);
    let mut recorder = gpu.recorder(&mut encoder);
    let mut view = View::of_external(&mut recorder, &external)?;
    view.set_depth_range_m(Some([0.5, 4.0]));
    let blurred = methods::record(&*method, &mut recorder, &mut view, &lens)?;
    recorder.finish();
    let shown = target_like(&gpu, blurred.raw());
    copy(&mut encoder, blurred.raw(), &shown);
    gpu.queue().submit([encoder.finish()]);
    // The next frame has the same view: view.set_external(&mut recorder, &external).

    // A texture of linear colour; here, a number.
    let image = download(&gpu, &Texture::external(shown));
    let contrast = |x: u32| {
        let rows = image.pixels.chunks(SIDE as usize).map(|row| row[x as usize].y);
        rows.clone().fold(0.0, f32::max) - rows.fold(1.0, f32::min)
    };
    println!("{}: contrast {:.2} at 0.5 m, {:.2} at 4 m", method.about().id, contrast(40), contrast(200));
    Ok(())
}

/// What stands for the program's own passes.
fn draw_scene(encoder: &mut wgpu::CommandEncoder, scene: [&wgpu::Texture; 2], targets: [&wgpu::Texture; 2]) {
    for (from, to) in scene.into_iter().zip(targets) {
        copy(encoder, from, to);
    }
}

fn copy(encoder: &mut wgpu::CommandEncoder, from: &wgpu::Texture, to: &wgpu::Texture) {
    encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
}

fn target_like(gpu: &Gpu, texture: &wgpu::Texture) -> wgpu::Texture {
    use wgpu::TextureUsages as Usage;
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: texture.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: texture.dimension(),
        format: texture.format(),
        usage: Usage::TEXTURE_BINDING | Usage::COPY_DST | Usage::COPY_SRC,
        view_formats: &[],
    })
}

fn texture<F: Fn(u32, u32) -> [u8; 4]>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    format: wgpu::TextureFormat,
    texel: F,
) -> wgpu::Texture {
    use wgpu::util::DeviceExt;
    let size = wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
    let (dimension, view_formats) = (wgpu::TextureDimension::D2, &[]);
    let (mip_level_count, sample_count, label) = (1, 1, None);
    let descriptor =
        wgpu::TextureDescriptor { label, size, mip_level_count, sample_count, dimension, format, usage, view_formats };
    let data: Vec<u8> = (0..SIDE * SIDE).flat_map(|i| texel(i % SIDE, i / SIDE)).collect();
    device.create_texture_with_data(queue, &descriptor, wgpu::util::TextureDataOrder::LayerMajor, &data)
}
