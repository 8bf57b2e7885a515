//! Painted walls of the atrium.

use super::prelude::*;
use std::f32::consts::TAU;

/// A rose window and its geometry, 3.4 by 4.1 m.
pub fn fresco() -> Canvas {
    let (w, h) = (832.0, 1000.0);
    let inks = [0x21355f, 0xb5442c, 0xe0a93e, 0x2f6b58, 0xf0e4c6, 0x6d2440].map(rgb);
    let mut c = Canvas::filled(w as usize, h as usize, inks[0]);
    c.blend(Vec2::ZERO, vec2(w, h), inks[2], |p| {
        let (x, y) = ((p.x / 26.0).fract() - 0.5, (p.y / 26.0).fract() - 0.5);
        f32::from(x.abs() + y.abs() < 0.2)
    });
    let centre = vec2(w * 0.5, 440.0);
    c.disc(centre, 372.0, inks[4]);
    c.disc(centre, 362.0, inks[5]);
    for (ring, count, radius, size) in [(0, 24, 318.0, 36.0), (1, 16, 228.0, 40.0), (2, 8, 128.0, 44.0)] {
        for k in 0..count {
            let (sin, cos) = ((k as f32 + 0.5 * (ring % 2) as f32) / count as f32 * TAU).sin_cos();
            let p = centre + vec2(cos, sin) * radius;
            c.stroke(&[centre, p], 3.0, inks[4]);
            c.disc(p, size, inks[4]);
            c.disc(p, size - 6.0, inks[(k + ring) % 4]);
            for j in 0..6 {
                let (s, o) = (j as f32 / 6.0 * TAU).sin_cos();
                c.disc(p + vec2(o, s) * size * 0.45, size * 0.2, inks[(k + ring + 2) % 5]);
            }
            c.disc(p, size * 0.18, inks[2]);
        }
    }
    c.disc(centre, 62.0, inks[4]);
    c.disc(centre, 54.0, inks[1]);
    for k in 0..16 {
        let (sin, cos) = (k as f32 / 16.0 * TAU).sin_cos();
        c.stroke(&[centre, centre + vec2(cos, sin) * 50.0], 4.0, inks[2]);
    }
    c.rect(40.0, 846.0, w - 80.0, 118.0, inks[4]);
    c.rect(48.0, 854.0, w - 96.0, 102.0, inks[1]);
    c.text_centred(w * 0.5, 868.0, 40.0, 8.0, inks[4], "CAMERA OBSCVRA");
    c.text_centred(w * 0.5, 922.0, 22.0, 4.0, inks[2], "ANNO DOMINI MDCCCXXVII");
    border(&mut c, w, h, inks[4], inks[3]);
    c.wear(0.55, |uv| 0.6 + 0.5 * fbm(uv, ivec2(6, 7), 5, 12));
    c
}

fn border(c: &mut Canvas, w: f32, h: f32, light: Vec3, dark: Vec3) {
    c.blend(Vec2::ZERO, vec2(w, h), light, |p| {
        let edge = p.min(vec2(w, h) - p).min_element();
        let key = ((p.x + p.y) / 14.0).floor() as i32 % 2 == 0;
        f32::from(edge < 22.0 && (key || !(4.0..=18.0).contains(&edge)))
    });
    c.blend(Vec2::ZERO, vec2(w, h), dark, |p| {
        let edge = p.min(vec2(w, h) - p).min_element();
        f32::from((22.0..28.0).contains(&edge))
    });
}

/// A band of carved letters, 5.1 by 0.72 m.
pub fn frieze() -> Canvas {
    let (w, h) = (1275.0, 180.0);
    let (stone, cut) = (rgb(0xd9c7a4), rgb(0x5d1f1a));
    let mut c = Canvas::filled(w as usize, h as usize, stone);
    c.text_centred(w * 0.5 + 3.0, 51.0, 84.0, 17.0, rgb(0xf6ead0), "FOCVS AD INFINITVM");
    c.text_centred(w * 0.5, 48.0, 84.0, 16.0, cut, "FOCVS AD INFINITVM");
    for y in [10.0, 22.0, 154.0, 166.0] {
        c.rect(0.0, y, w, 5.0, cut);
    }
    c.wear(0.5, |uv| 0.6 + 0.55 * fbm(uv, ivec2(14, 2), 5, 3));
    c
}
