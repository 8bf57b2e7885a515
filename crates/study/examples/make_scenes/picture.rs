//! The picture with a depth map: the forest, traced through a pinhole.

use crate::generate;
use anyhow::{Context, Result};
use defocus::image::Image;
use defocus::image_io::{srgb::srgb8_from_linear, write_png_rgb};
use defocus::presets::presets;
use defocus::raytrace::{RayOptions, RayRender, RayScene};
use defocus::scene::gltf;
use std::path::Path;
use std::sync::Arc;

/// Size of the picture, px.
const SIZE: glam::UVec2 = glam::uvec2(768, 576);
/// Depth at the highest 16-bit value, metres: `1/d = v / NEAR_M`. Nothing is nearer.
const NEAR_M: f32 = 0.8;

/// Writes `forest.png` and `forest_depth.png` into `folder`.
pub fn write(folder: &Path) -> Result<()> {
    let mut stage = generate::unlit("forest").context("the generator knows the forest")?;
    generate::bake::bake(&mut stage);
    let scene = Arc::new(gltf::load_bytes("forest", &generate::glb::write(&stage))?);
    let camera = scene.cameras[0].camera;
    let rays = Arc::new(RayScene::new(scene, &camera)?);
    // No lens points: only what the lens centre sees is wanted, whatever the lens.
    let options = RayOptions { lens_points: 0..0, ..RayOptions::default() };
    let lens = presets().swap_remove(0).lens;
    let seen = RayRender::new(rays, &camera.projection(SIZE, 0), &lens, &options)?.image();
    std::fs::create_dir_all(folder).with_context(|| format!("creating {}", folder.display()))?;
    let pixels = seen.pinhole.pixels.iter().map(|c| c.to_array().map(srgb8_from_linear)).collect();
    write_png_rgb(&folder.join("forest.png"), &Image { size: SIZE, pixels })?;
    let inverse = seen.depth.pixels.iter().map(|&d| (NEAR_M / d * 65535.0).round() as u16).collect();
    let depth = image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::from_raw(SIZE.x, SIZE.y, inverse);
    let path = folder.join("forest_depth.png");
    let depth = depth.context("as many pixels as the size says")?;
    depth.save(&path).with_context(|| format!("writing {}", path.display()))?;
    println!("forest: {} triangles, field of view {:.3} degrees", stage.triangles(), camera.fov_y.to_degrees());
    Ok(())
}
