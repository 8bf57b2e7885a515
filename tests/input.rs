//! What methods are given of the light: tones cut or mapped before the blur, for images and
//! scenes alike.

mod common;
mod views;

use common::{front_camera, gpu, lens, quad, scene, unlit};
use defocus::gpu::Precision;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::methods::{self, Pinhole};
use defocus::scene::{Material, Scene};
use defocus::view::{GpuScene, Input, SurfaceOptions, Tone, View};
use glam::{UVec2, Vec3, uvec2, vec2, vec3};
use views::render;

const SIZE: UVec2 = uvec2(48, 36);

/// A wall, and in front of it a light far brighter than white.
fn lamp() -> Scene {
    let glowing = Material { emissive: vec3(40.0, 30.0, 8.0), ..unlit(Vec3::ZERO) };
    let lamp = Material { unlit: false, ..glowing };
    scene(
        vec![quad(4.0, vec2(-6.0, -5.0), vec2(6.0, 5.0), 0), quad(3.0, vec2(-0.3, -0.3), vec2(0.3, 0.3), 1)],
        vec![unlit(vec3(0.2, 0.3, 0.1)), lamp],
    )
}

fn scene_view() -> View {
    let scene = GpuScene::new(gpu(), &lamp(), SurfaceOptions::default());
    View::of_scene(scene, front_camera(), SIZE, 3).expect("a small view fits")
}

fn image_view() -> View {
    let color = ColorImage::from_fn(SIZE, |x, y| {
        let lit = (20..24).contains(&x) && (14..18).contains(&y);
        if lit { vec3(40.0, 30.0, 8.0) } else { vec3(0.2, 0.3, 0.1) }
    });
    let depth: DepthImage = Image::filled(SIZE, 4.0);
    View::of_image(gpu(), &color, &depth, 0.8).expect("a small image fits")
}

fn pinhole(view: &mut View) -> ColorImage {
    render(&Pinhole, view, &lens(0.0, 2.0), Precision::Half)
}

fn views() -> [View; 2] {
    [scene_view(), image_view()]
}

#[test]
fn the_pinhole_image_is_what_the_tone_makes_of_each_colour() {
    let _turn = views::turn();
    for mut view in views() {
        let linear = pinhole(&mut view);
        assert!(linear.pixels.iter().any(|c| c.x > 30.0), "the lamp is in view");
        for input in [Input::Clamped { white: 1.0 }, Input::Clamped { white: 0.25 }, Input::Reinhard { key: 0.72 }] {
            let tone = view.set_input(gpu(), input);
            assert_ne!(tone, Tone::Linear);
            let given = pinhole(&mut view);
            // Each is rounded to f16 once more than the other: 2^-11 of it, twice.
            let off = |(a, b): (&Vec3, &Vec3)| (*a - tone.apply(*b)).abs().max_element();
            let worst = given.pixels.iter().zip(&linear.pixels).map(off).fold(0.0, f32::max);
            assert!(worst < 2e-3, "{input}: {worst}");
            view.set_input(gpu(), Input::Hdr);
            assert_eq!(pinhole(&mut view), linear, "{input}: what was given before comes back");
        }
    }
}

#[test]
fn the_log_average_of_what_reinhard_maps_is_its_key() {
    let _turn = views::turn();
    for mut view in views() {
        let linear = pinhole(&mut view);
        let Tone::Reinhard(scale) = view.set_input(gpu(), Input::Reinhard { key: 0.5 }) else { panic!("as asked") };
        let log = |c: &Vec3| f64::from(scale * c.dot(defocus::display::LUMINANCE)).ln();
        let mean = linear.pixels.iter().map(log).sum::<f64>() / linear.pixels.len() as f64;
        // Equation (1) adds 1e-4 to luminances of 0.26 and more.
        assert!((mean.exp() - 0.5).abs() < 1e-3, "{}", mean.exp());
    }
}

#[test]
fn every_method_blurs_what_it_is_given() {
    let _turn = views::turn();
    let lens = lens(9.0, 2.0);
    for method in methods::all() {
        for mut view in views() {
            if method.about().needs_scene && !view.is_scene() {
                continue;
            }
            let id = method.about().id;
            let of_all = render(&*method, &mut view, &lens, Precision::Half);
            view.set_input(gpu(), Input::Clamped { white: 1.0 });
            let of_clamped = render(&*method, &mut view, &lens, Precision::Half);
            let greatest = |image: &ColorImage| image.pixels.iter().map(|c| c.max_element()).fold(0.0, f32::max);
            // Sums of spread light may be a little brighter where surfaces meet.
            let most = if method.about().averages { 1.01 } else { 1.1 };
            assert!(greatest(&of_clamped) < most, "{id}: {}", greatest(&of_clamped));
            assert!(greatest(&of_all) > 1.2, "{id}: {} of a lamp of 40", greatest(&of_all));
        }
    }
}

#[test]
fn inputs_are_read_as_they_are_written() {
    for input in [Input::Hdr, Input::Clamped { white: 0.5 }, Input::Reinhard { key: 0.72 }] {
        assert_eq!(input.to_string().parse(), Ok(input));
    }
    assert_eq!("clamped".parse(), Ok(Input::Clamped { white: 1.0 }));
    assert_eq!("reinhard".parse(), Ok(Input::Reinhard { key: 0.18 }));
    for wrong in ["", "agx", "hdr:1", "clamped:0", "reinhard:-1", "reinhard:nan", "reinhard:inf", "clamped:"] {
        assert!(wrong.parse::<Input>().is_err(), "{wrong}");
    }
}
