//! Kinds of pictures that rays alone get wrong, made here: small lights before a wall of nearly
//! their blur, bright areas that go on beyond the frame, sharp detail behind something near, and
//! outlines that lie between pixels.

use super::common::{gpu, quad, unlit};
use super::{SIZE, lens, pixel_m, psnr_db, render, view_of};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::methods::{Accumulation, Adaptive};
use defocus::view::View;
use glam::{Vec3, vec2};

/// Sum of the red light, less `wall` in every pixel.
fn light(image: &ColorImage, wall: f32) -> f64 {
    image.pixels.iter().map(|p| f64::from(p.x - wall)).sum()
}

/// Corners, metres, of a rectangle at `depth_m` that covers the pixels from `low` to `high`,
/// counted from the frame's centre to the right and upwards.
fn covering(depth_m: f32, low: [f32; 2], high: [f32; 2], material: usize) -> defocus::scene::Mesh {
    let m = pixel_m() * depth_m;
    quad(depth_m, vec2(low[0], low[1]) * m, vec2(high[0], high[1]) * m, material)
}

/// With each number of rays, and however little the lights differ in blur from the wall.
#[test]
fn lights_before_a_wall_of_nearly_their_blur_keep_their_light() {
    const WALL: f32 = 0.02;
    for light_m in [3.0, 4.5, 6.0, 7.5] {
        let wall = quad(8.0, vec2(-40.0, -40.0), vec2(40.0, 40.0), 1);
        // Edges between pixel centres: all images have exactly its light.
        let places = [[-20.0, -9.0], [-6.0, 8.0], [4.0, -4.0], [17.0, 6.0]];
        let lights = places.map(|[x, y]| covering(light_m, [x, y], [x + 3.0, y + 3.0], 0));
        let meshes = std::iter::once(wall).chain(lights).collect();
        let mut view = view_of(meshes, vec![unlit(Vec3::ONE), unlit(Vec3::splat(WALL))]);
        let truth = render(&Accumulation { samples: 256, ..Accumulation::default() }, &mut view, &lens());
        for points in 0..4 {
            let image = render(&Adaptive { points, ..Adaptive::default() }, &mut view, &lens());
            let kept = light(&image, WALL) / light(&truth, WALL);
            println!("lights at {light_m} m, {} rays: {kept:.4} of the light", 8 << points);
            // Few rays meet a light of 3x3 px by chance, and those of one that lies close before
            // the wall meet the wall for it near its outline.
            let tolerance = if points == 0 { 0.05 } else { 0.03 };
            assert!((kept - 1.0).abs() <= tolerance, "{light_m} m, {} rays: {kept} of the light is left", 8 << points);
        }
    }
}

/// An image ends where its frame does; what it shows there goes on. Cells of the stretched border
/// are up to a radius wide, which a fortieth of the light shows.
#[test]
fn a_bright_band_is_as_bright_at_the_border_as_inside() {
    for upright in [false, true] {
        let inside = |x: u32, y: u32| if upright { (40..60).contains(&x) } else { (20..44).contains(&y) };
        let color = Image::from_fn(SIZE, |x, y| Vec3::splat(if inside(x, y) { 6.0 } else { 0.05 }));
        let depth: DepthImage = Image::filled(SIZE, 5.0);
        let mut view = View::of_image(gpu(), &color, &depth, 60f64.to_radians()).unwrap();
        let image = render(&Adaptive::default(), &mut view, &lens());
        let at = |along: u32| if upright { image.at(50, along).x } else { image.at(along, 32).x };
        for along in 0..if upright { SIZE.y } else { SIZE.x } {
            assert!((at(along) - 6.0).abs() <= 0.15, "upright: {upright}, pixel {along}: {}", at(along));
        }
    }
}

/// What is near hides a share of a sharp wall: neither is to blur the other's detail.
#[test]
fn a_speck_leaves_the_sharp_wall_behind_it_as_sharp_as_it_is() {
    let stripes = (0..60).map(|i| {
        let x = i as f32 * 4.0 - 120.0;
        covering(2.0, [x, -80.0], [x + 4.0, 80.0], (i % 2) as usize)
    });
    let specks =
        [[-11.3, 3.2, 1.0], [8.6, -7.4, 2.5]].map(|[x, y, side]| covering(0.8, [x, y], [x + side, y + side], 2));
    let materials = vec![unlit(Vec3::splat(0.8)), unlit(Vec3::splat(0.1)), unlit(Vec3::new(0.9, 0.4, 0.1))];
    let mut view = view_of(stripes.chain(specks).collect(), materials);
    let truth = render(&Accumulation { samples: 512, ..Accumulation::default() }, &mut view, &lens());
    let db = psnr_db(&render(&Adaptive::default(), &mut view, &lens()), &truth);
    println!("{db:.2} dB");
    assert!(db >= 48.0, "{db} dB");
}

/// Tiles whose halves of the rays differ have more of them, and an outline gains; what is left
/// then is where between two samples it lies.
#[test]
fn noisy_tiles_have_more_rays() {
    let wall = quad(8.0, vec2(-40.0, -40.0), vec2(40.0, 40.0), 1);
    let bars = [-24.3, -8.6, 7.1].map(|x| covering(1.2, [x, -17.4], [x + 9.0, 17.7], 0));
    let meshes = std::iter::once(wall).chain(bars).collect();
    let mut view = view_of(meshes, vec![unlit(Vec3::splat(0.9)), unlit(Vec3::splat(0.02))]);
    let truth = render(&Accumulation { samples: 512, ..Accumulation::default() }, &mut view, &lens());
    let mut db = |refine| psnr_db(&render(&Adaptive { refine, ..Adaptive::default() }, &mut view, &lens()), &truth);
    let (once, often) = (db(1), db(4));
    println!("{once:.2} dB, refined {often:.2} dB");
    assert!(often >= once + 1.0, "{once} dB and refined {often} dB");
}

/// An image does not show what is behind a blurred card; what is beside it goes on there: straight
/// outlines, corners, thin bars, and cards over cards.
#[test]
fn behind_what_an_image_shows_goes_on_what_is_beside_it() {
    let wall = |material| quad(6.0, vec2(-40.0, -40.0), vec2(40.0, 40.0), material);
    let card = |depth_m, low, high| covering(depth_m, low, high, 0);
    let kinds = [
        ("half", vec![card(0.9, [-80.0, -80.0], [3.0, 80.0])]),
        ("corner", vec![card(1.0, [-80.0, -80.0], [5.0, 2.0])]),
        ("bars", (0..5).map(|i| card(1.1, [20.0 * i as f32 - 38.0, -80.0], [20.0 * i as f32 - 34.0, 80.0])).collect()),
        ("cards", vec![card(0.8, [-60.0, -60.0], [-10.0, 60.0]), covering(1.3, [-30.0, -20.0], [20.0, 25.0], 2)]),
    ];
    for (name, cards) in kinds {
        let meshes = std::iter::once(wall(1)).chain(cards).collect();
        let materials = vec![unlit(Vec3::splat(0.8)), unlit(Vec3::splat(0.1)), unlit(Vec3::new(0.9, 0.4, 0.1))];
        let mut scene = view_of(meshes, materials);
        let truth = render(&Accumulation { samples: 512, ..Accumulation::default() }, &mut scene, &lens());
        let mut image = scene.as_image(gpu()).unwrap();
        let mut db =
            |layers| psnr_db(&render(&Adaptive { layers, ..Adaptive::default() }, &mut image, &lens()), &truth);
        let (seen, guessed) = (db(1), db(4));
        println!("{name}: {seen:.2} dB, and with what is hidden {guessed:.2} dB");
        assert!(guessed >= 40.0 && guessed >= seen + 3.0, "{name}: {seen} dB, with what is hidden {guessed} dB");
    }
}

/// A wall brighter than white goes on as bright behind a dark card: what is kept apart of its light
/// is not lost where it is hidden.
#[test]
fn light_that_an_image_hides_goes_on() {
    const WALL: f32 = 6.0;
    let wall = quad(6.0, vec2(-40.0, -40.0), vec2(40.0, 40.0), 1);
    let card = covering(0.9, [-80.0, -80.0], [3.0, 80.0], 0);
    let mut scene = view_of(vec![wall, card], vec![unlit(Vec3::splat(0.02)), unlit(Vec3::splat(WALL))]);
    let truth = render(&Accumulation { samples: 512, ..Accumulation::default() }, &mut scene, &lens());
    let mut image = scene.as_image(gpu()).unwrap();
    let blurred = render(&Adaptive::default(), &mut image, &lens());
    let kept = light(&blurred, 0.0) / light(&truth, 0.0);
    println!("{kept:.4} of the light");
    assert!((kept - 1.0).abs() <= 0.02, "{kept} of the light is left");
}
