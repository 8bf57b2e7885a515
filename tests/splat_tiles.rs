//! Point splatting by tiles gives what sprites that are blended give.

mod common;

use common::{apertures, front_camera, gpu, quad, textured, unlit};
use defocus::gpu::{Precision, Texture, download};
use defocus::image::{ColorImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Splat};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{Vec3, uvec2, vec2, vec3};
use std::sync::Arc;

/// L0 to L2, M1 and M2 of what was exposed, by name.
fn layers(exposed: &[(String, Texture)]) -> Vec<(String, ColorImage)> {
    let is_layer = |name: &str| ["L0:", "L1:", "L2:", "M1:", "M2:"].contains(&&name[..3.min(name.len())]);
    let found = exposed.iter().filter(|(name, _)| is_layer(name));
    found.map(|(name, texture)| (name.clone(), download(gpu(), texture))).collect()
}

/// Greatest difference of two images over the greatest of either's values, and 1.
fn greatest_difference(a: &ColorImage, b: &ColorImage) -> f32 {
    assert_eq!(a.size, b.size);
    let differences = a
        .pixels
        .iter()
        .zip(&b.pixels)
        .map(|(a, b)| (*a - *b).abs().max_element() / a.max_element().max(b.max_element()).max(1.0));
    differences.fold(0.0, f32::max)
}

/// Asserts that both ways to sum give the same layers and the same picture.
fn assert_sums_alike(splat: &Splat, view: &mut View, lens: &Lens, what: &str) {
    let mut by = |by: &str| {
        let mut splat = splat.clone();
        methods::set_param(&mut splat, "by", by).unwrap();
        let mut frame = gpu().frame();
        frame.keep_intermediates();
        frame.precision = Precision::Full;
        let texture = methods::record(&splat, &mut frame, view, lens).unwrap();
        let exposed = frame.finish().exposed;
        (download(gpu(), &texture), layers(&exposed))
    };
    let (tiles, sprites) = (by("tiles"), by("sprites"));
    assert!(tiles.1.len() >= 3 && tiles.1.len() == sprites.1.len(), "{what}: {} layers", tiles.1.len());
    for ((name, by_tiles), (other, by_sprites)) in tiles.1.iter().zip(&sprites.1) {
        assert_eq!(name, other);
        let difference = greatest_difference(by_tiles, by_sprites);
        // Up to some thousand f32 additions in another order; shares, whose corners are
        // differences of f32 sums below 1/2, are off by up to 1e-7 each.
        assert!(difference < 2e-4, "{what}, {name}: {difference}");
    }
    // Composed layers are divided by their alpha, down to where that is little more than
    // rounding: what lights a hundred times as bright would make of that is not compared.
    let difference = greatest_difference(&tiles.0, &sprites.0);
    println!("{what}: {difference:.1e}");
    assert!(difference < 1e-3, "{what}: {difference}");
}

#[test]
fn tiles_and_sprites_give_the_same_layers_of_a_scene() {
    let near = quad(1.0, vec2(-0.22, -0.25), vec2(0.25, 0.2), 0);
    let wall = quad(4.0, vec2(-5.0, -4.0), vec2(5.0, 4.0), 1);
    let mut scene = common::scene(vec![near, wall], vec![unlit(vec3(0.9, 0.5, 0.1)), textured()]);
    scene.textures = vec![Arc::new(common::uv_grid_texture(uvec2(64, 64)))];
    // Focused on the wall; the near square has a CoC of -24 px.
    let lens = common::lens(8.0, 4.0);
    let options = SurfaceOptions { mipmaps: false, ..SurfaceOptions::default() };
    let scene = GpuScene::new(gpu(), &scene, options);
    // Sizes that end within a tile, and margins that begin at one's edge and within it.
    for (aperture, overscan) in apertures().into_iter().zip([0, 7, 16, 3, 20]) {
        let mut view = View::of_scene(scene.clone(), front_camera(), uvec2(61, 43), overscan).unwrap();
        for accelerate in [false, true] {
            let splat = Splat { accelerate, ..Splat::default() };
            let lens = Lens { aperture: aperture.clone(), ..lens.clone() };
            let what = format!("{aperture:?}, margin {overscan} px, accelerated: {accelerate}");
            assert_sums_alike(&splat, &mut view, &lens, &what);
        }
    }
}

#[test]
fn tiles_and_sprites_give_the_same_layers_of_an_image() {
    // Spots from below a pixel to half the frame.
    let size = uvec2(70, 50);
    let color = Image::from_fn(size, |x, y| {
        let value = ((x * 7 + y * 13) % 17) as f32 / 17.0;
        if (x, y) == (40, 29) { Vec3::splat(9.0) } else { vec3(value, 1.0 - value, 0.3) }
    });
    let depth = Image::from_fn(size, |x, y| match (x / 23 + y / 17) % 4 {
        0 => 1.0,
        1 => 2.0,
        2 => 0.9 + y as f32 / 50.0,
        _ => f32::INFINITY,
    });
    let mut view = View::of_image(gpu(), &color, &depth, 0.8).unwrap();
    for k_px in [1.0, 20.0] {
        assert_sums_alike(&Splat::default(), &mut view, &common::lens(k_px, 2.0), &format!("K {k_px} px"));
    }
}

#[test]
fn tiles_and_sprites_give_the_same_layers_of_spots_that_are_wider_than_the_frame() {
    // From 128 px on the table's cells are larger than pixels. The frame has so many tiles
    // that a software adapter sums them in parts; few of its pixels are not in focus.
    let size = uvec2(160, 140);
    let color = Image::from_fn(size, |x, y| vec3(x as f32 / 160.0, y as f32 / 140.0, 0.5));
    let depth = Image::from_fn(size, |x, y| match (x % 37 == 5 && y % 29 == 3, (x / 37 + y / 29) % 2) {
        (false, _) => 2.0,
        (true, 0) => 1.0,
        (true, _) => f32::INFINITY,
    });
    let mut view = View::of_image(gpu(), &color, &depth, 0.8).unwrap();
    let splat = Splat { normalise: false, ..Splat::default() };
    assert_sums_alike(&splat, &mut view, &common::lens(200.0, 2.0), "K 200 px");
}
