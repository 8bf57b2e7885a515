//! What the pinhole does not see and a lens may: where hidden layers are drawn, how far
//! apart, and whether what is behind a surface stays there.

use super::common::{self, gpu, quad, unlit};
use super::{alike_at_all_depths, pixel_m, render, view_of};
use defocus::gpu::download_depth;
use defocus::image::DepthImage;
use defocus::methods::adaptive::Adaptive;
use defocus::methods::adaptive::tiles::TILE_PX;
use defocus::scene::{Material, Mesh};
use defocus::view::{LayerSeparation, PeelOrder};
use glam::{Vec3, Vec4, vec2};

/// Hidden layers are drawn near edges only; that nothing is missed there is what
/// comparisons with accumulation show.
#[test]
fn hidden_layers_are_left_out_far_from_edges() {
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 2);
    // Covers the left half, up to the middle of the frame.
    let front = quad(1.0, vec2(-9.0, -9.0), vec2(0.0, 9.0), 0);
    let mut view = view_of(vec![wall, front], vec![unlit(Vec3::X), unlit(Vec3::Y), unlit(Vec3::Z)]);
    let mut frame = gpu().frame();
    // From the stored depths 0.1 and 0.0125: up to 0.1 / 0.02 = 5 px behind the edge.
    let order = PeelOrder { count: 2, fineness: 1, draws: 1, separation: alike_at_all_depths(0.02), lights: true };
    let peeled = view.peeled(&mut frame, &order).unwrap();
    frame.finish();
    let second = download_array_layer(&peeled.depth, 1);
    let middle = second.size.x / 2;
    for y in 0..second.size.y {
        for x in 0..second.size.x {
            let z = second.at(x, y);
            if x < middle && x + 6 >= middle {
                assert!((z - 0.0125).abs() < 1e-4, "{x}, {y}: z = {z}, but the wall shows past the edge");
            }
            if x + 6 + 2 * TILE_PX < middle {
                assert!(z < 0.0, "{x}, {y}: z = {z}, but no ray gets there");
            }
        }
    }
}

/// One array layer of an R32F texture.
fn download_array_layer(array: &defocus::gpu::Texture, layer: u32) -> DepthImage {
    let single = gpu().texture("one layer", array.size(), array.format());
    let mut frame = gpu().frame();
    let mut source = array.raw().as_image_copy();
    source.origin.z = layer;
    let size = single.raw().size();
    frame.encoder().copy_texture_to_texture(source, single.raw().as_image_copy(), size);
    frame.finish();
    download_depth(gpu(), &single)
}

/// A column's mouldings, a surface each, before a wall: from the third layer on they count
/// as one, and the wall gets a layer.
#[test]
fn mouldings_leave_layers_for_what_lies_behind() {
    let depths_m = [1.0, 1.02, 1.04, 1.06, 8.0];
    // Up to the middle of the frame, but for the wall.
    let to_x_m = |depth_m: f32| if depth_m < 2.0 { 0.0 } else { 20.0 };
    let surfaces = depths_m.map(|d| quad(d, vec2(-20.0, -20.0), vec2(to_x_m(d), 20.0), 0));
    let mut view = view_of(surfaces.into(), vec![unlit(Vec3::ONE)]);
    let uniform = view.lens_uniform(&common::lens(40.0, 4.0));
    let separation = LayerSeparation::of(&uniform);
    let z = depths_m.map(|d| 0.1 / d);
    assert!(separation.z < z[2] - z[3], "the mouldings lie a pixel of s apart");
    assert!(separation.widening_from_z >= uniform.focus_z && separation.widening_from_z < 2.0 * uniform.focus_z);
    for (widening_from_z, third) in [(1.0, z[2]), (separation.widening_from_z, z[4])] {
        let separation = LayerSeparation { widening_from_z, ..separation };
        let order = PeelOrder { count: 3, fineness: 1, draws: 1, separation, lights: true };
        let mut frame = gpu().frame();
        let peeled = view.peeled(&mut frame, &order).unwrap();
        frame.finish();
        for (layer, wanted) in [(0, z[0]), (1, z[1]), (2, third)] {
            let depth = download_array_layer(&peeled.depth, layer);
            let found = depth.at(depth.size.x / 2 - 3, depth.size.y / 2);
            assert!((found - wanted).abs() < 1e-4, "widening from {widening_from_z}: layer {layer} at z = {found}");
        }
    }
}

/// A bright window behind the edge of a sign: nearly as blurred, and farther from the edge
/// than a lens looks around it.
#[test]
fn a_light_does_not_shine_through_what_hides_it() {
    let lens = common::lens(40.0, 2.0);
    let (sign_m, window_m) = (6.0, 8.0);
    let s = |depth_m: f64| 0.5 * lens.coc_diameter_px(depth_m);
    let behind_px = s(window_m.into()) - s(sign_m.into());
    assert!(behind_px > 1.0 && behind_px < 2.0, "{behind_px}");
    let px_m = |depth_m: f32| depth_m * pixel_m();
    let sign = quad(sign_m, vec2(-60.0, -60.0), vec2(0.0, 60.0), 0);
    let window = quad(window_m, vec2(-7.0, -4.0) * px_m(window_m), vec2(-4.0, 4.0) * px_m(window_m), 1);
    // Without a light in view none is looked for.
    let lamp = quad(window_m, vec2(36.0, -1.0) * px_m(window_m), vec2(38.0, 1.0) * px_m(window_m), 1);
    let bright = Material { base_color: Vec4::new(50.0, 50.0, 50.0, 1.0), ..unlit(Vec3::ONE) };
    let image_of = |meshes: Vec<Mesh>| {
        let mut view = view_of(meshes, vec![unlit(Vec3::splat(0.1)), bright.clone()]);
        render(&Adaptive::default(), &mut view, &lens)
    };
    let without = image_of(vec![sign.clone(), lamp.clone()]);
    let with = image_of(vec![sign, lamp, window]);
    let most = with.pixels.iter().zip(&without.pixels).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    // A rounding of f16 beside the lamp.
    assert!(most < 1e-3, "a hidden window adds {most}");
}
