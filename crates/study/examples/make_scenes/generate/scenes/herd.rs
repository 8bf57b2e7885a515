//! Elephants at many depths on dry ground.

use super::super::nature::{blend, cone, ellipsoid, surface_net};
use super::prelude::*;
use std::f32::consts::TAU;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.06, 0.22, 0.66),
            horizon: vec3(0.62, 0.60, 0.55),
            ground: vec3(0.24, 0.17, 0.10),
            softbox: 0.0,
        },
        focus_m: 6.0,
        occlusion_m: 1.6,
        ..Stage::default()
    };
    stage.sun(vec3(3.4, 2.7, 1.8), vec3(-0.70, -0.58, -0.36), 0.02);
    let soil = stage.jpeg(nature::savanna(1024, 2), 78);
    let soil = stage.matte("savanna", soil, 0.95);
    let ground = Shape::surface(90, 110, |u, v| {
        let s = 2.0 * u - 1.0;
        let (x, z) = (60.0 * (0.25 * s + 0.75 * s * s * s), 3.0 - 83.0 * (0.18 * v + 0.82 * v * v * v));
        vec3(x, 0.12 * (fbm(vec2(x, z) / 40.0 + 0.5, ivec2(9, 9), 3, 1) - 0.5), z)
    });
    stage.place(ground.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z) / 3.2), soil);
    let haze = stage.material(Material { name: "hills", color: vec3(0.30, 0.33, 0.40), ..Material::default() });
    for (z, rise, seed) in [(-84.0, 9.0, 1), (-100.0, 19.0, 5)] {
        let hills = Shape::surface(120, 6, |u, v| {
            let ridge = fbm(vec2(u, 0.5), ivec2(7, 1), 5, seed);
            vec3((u - 0.5) * 220.0, -1.0 + rise * ridge * v, z - 8.0 * v)
        });
        stage.place(hills.flipped_if(|c| c.normal.z < 0.0), haze);
    }
    let skin = stage.jpeg(nature::hide(1024, rgb(0xa89a8c), 7), 78);
    let skin = stage.matte("hide", skin, 0.8);
    let ivory = stage.material(Material {
        name: "ivory",
        color: vec3(0.78, 0.70, 0.54),
        roughness: 0.4,
        ..Material::default()
    });
    elephants(&mut stage, skin, ivory);
    trees(&mut stage);
    stage.camera("herd", vec3(0.0, 1.5, 0.0), vec3(0.1, 1.35, -8.0), 40.0, 0.1);
    stage.camera("low", vec3(-1.6, 0.55, -0.6), vec3(0.8, 1.5, -9.0), 46.0, 0.1);
    stage
}

/// Signed distance of an elephant facing +x, its feet on y = 0, 2.6 m at the shoulder;
/// `step` in [-1, 1] swings the legs, `lift` the trunk.
fn body(p: Vec3, step: f32, lift: f32) -> f32 {
    let mirrored = vec3(p.x, p.y, p.z.abs());
    let mut d = ellipsoid(p, vec3(-0.05, 1.72, 0.0), vec3(1.28, 0.82, 0.72));
    d = blend(d, ellipsoid(p, vec3(-0.75, 1.78, 0.0), vec3(0.68, 0.74, 0.62)), 0.4);
    d = blend(d, ellipsoid(p, vec3(0.75, 1.85, 0.0), vec3(0.62, 0.72, 0.58)), 0.4);
    for (x, phase) in [(0.72, 1.0), (-0.85, -1.0)] {
        let side = p.z.signum();
        let swing = 0.26 * step * phase * side;
        let (hip, knee, foot) =
            (vec3(x, 1.5, 0.36), vec3(x + swing * 0.6 + 0.05 * phase, 0.78, 0.36), vec3(x + swing, 0.14, 0.36));
        let leg = blend(cone(mirrored, hip, knee, 0.32, 0.215), cone(mirrored, knee, foot, 0.205, 0.2), 0.1);
        let pad = cone(mirrored, foot - Vec3::Y * 0.02, foot - Vec3::Y * 0.1, 0.225, 0.24).max(-p.y);
        d = blend(d, blend(leg, pad, 0.08), 0.22);
    }
    // Head, brow, and the trunk as a chain.
    d = blend(d, cone(p, vec3(1.0, 2.0, 0.0), vec3(1.5, 2.3, 0.0), 0.46, 0.36), 0.3);
    d = blend(d, ellipsoid(p, vec3(1.6, 2.32, 0.0), vec3(0.42, 0.5, 0.38)), 0.22);
    d = blend(d, ellipsoid(mirrored, vec3(1.62, 2.62, 0.15), vec3(0.24, 0.2, 0.18)), 0.2);
    let trunk = [
        vec3(1.85, 2.22, 0.0),
        vec3(2.12, 1.85, 0.0),
        vec3(2.2, 1.35, 0.0),
        vec3(2.2 + 0.1 * lift, 0.85 + 0.15 * lift, 0.05),
        vec3(2.3 + 0.3 * lift, 0.42 + 0.45 * lift, 0.08),
        vec3(2.5 + 0.2 * lift, 0.34 + 0.8 * lift, 0.08),
    ];
    let rings = 0.008 * (p.y * 46.0).sin() * f32::from(p.x > 1.95);
    for (k, pair) in trunk.windows(2).enumerate() {
        let radius = |i: usize| 0.25 - 0.037 * i as f32;
        d = blend(d, cone(p, pair[0], pair[1], radius(k), radius(k + 1)) + rings, 0.1);
    }
    d = blend(d, cone(p, vec3(1.62, 2.0, 0.0), vec3(1.85, 1.72, 0.0), 0.24, 0.12), 0.15);
    // Ears: flattened, fanned out behind the head.
    let ear = vec3(1.22, 2.1, 0.42);
    let fan = mirrored - ear;
    let (out, back) = (fan.z * 0.83 + fan.x * 0.56, -fan.x * 0.83 + fan.z * 0.56);
    let bend = out - 0.06 * (back * 5.0).sin() - 0.25 * back * back;
    let flap = ellipsoid(vec3(back, fan.y, bend), vec3(0.36, -0.04, 0.0), vec3(0.52, 0.66, 0.075));
    d = blend(d, flap, 0.07);
    let tail = blend(
        cone(p, vec3(-1.38, 2.0, 0.0), vec3(-1.62, 1.3, 0.04), 0.07, 0.035),
        ellipsoid(p, vec3(-1.64, 1.1, 0.05), vec3(0.07, 0.2, 0.07)),
        0.08,
    );
    let eye = ellipsoid(mirrored, vec3(1.83, 2.33, 0.315), vec3(0.06, 0.05, 0.05));
    blend(blend(d, tail, 0.08), eye, 0.02)
}

fn elephants(stage: &mut Stage, skin: usize, ivory: usize) {
    let made = [(0.8, 0.15), (-0.7, 0.9)].map(|(step, lift)| {
        let shape = surface_net(vec3(-1.9, -0.06, -1.35), vec3(3.0, 3.0, 1.35), 0.060, |p| body(p, step, lift));
        let shape = shape.mapped(|c| {
            let p = c.position;
            // Unrolled around the body, so that no side is stretched much.
            vec2(p.x + p.z * 0.3, p.y + p.z.abs() * 0.8 * c.normal.y.abs()) * 0.95
        });
        stage.mesh(shape, skin)
    });
    let tusk: Vec<(Vec3, f32)> = (0..=20)
        .map(|k| {
            let t = k as f32 / 20.0;
            (vec3(1.8 + 0.75 * t, 1.95 - 0.75 * t + 0.42 * t * t, 0.2 + 0.1 * t), 0.062 * (1.0 - 0.9 * t * t))
        })
        .collect();
    let mut tusks = Shape::tube(&tusk, 14);
    let other: Vec<(Vec3, f32)> = tusk.iter().map(|&(p, r)| (vec3(p.x, p.y, -p.z), r)).collect();
    tusks.append(&Shape::tube(&other, 14));
    let tusks = stage.mesh(tusks, ivory);
    let herd = [
        (0.55, -6.1, 0.75, 0.50, 0),
        (-1.15, -3.6, 2.6, 0.42, 1),
        (1.55, -3.0, -2.5, 0.30, 0),
        (-2.7, -8.2, 0.35, 1.0, 0),
        (2.9, -9.5, 2.75, 1.05, 1),
        (-0.4, -12.5, 0.1, 1.1, 1),
        (5.6, -14.0, 3.3, 1.0, 0),
        (-6.2, -14.5, -0.3, 1.1, 1),
        (1.8, -18.5, 0.5, 1.05, 0),
        (-3.2, -21.0, 2.9, 1.0, 1),
        (8.5, -23.0, 3.0, 1.1, 0),
        (-9.5, -26.0, 0.2, 1.05, 0),
        (3.9, -31.0, 2.7, 1.1, 1),
        (-2.5, -38.0, 0.2, 1.1, 0),
    ];
    for (x, z, angle, scale, kind) in herd {
        let place = at(x, -0.02, z) * turn(angle) * Mat4::from_scale(vec3(scale, scale, scale));
        stage.node(made[kind], place);
        stage.node(tusks, place);
    }
}

fn trees(stage: &mut Stage) {
    let bark = stage.jpeg(nature::bark(256, rgb(0x8a6f52), rgb(0x35281c), 9), 78);
    let bark = stage.matte("bark", bark, 0.9);
    let leaf = stage.material(Material {
        name: "acacia",
        color: vec3(0.16, 0.24, 0.07),
        double_sided: true,
        ..Material::default()
    });
    let straw = stage.material(Material {
        name: "straw",
        color: vec3(0.62, 0.47, 0.20),
        double_sided: true,
        ..Material::default()
    });
    let mut rng = Rng::new(3);
    let (mut wood, mut crown) = (Shape::default(), Shape::default());
    for k in 0..7 {
        let angle = k as f32 * 0.9;
        let tip = vec3(angle.cos() * rng.range(1.2, 2.6), 4.6, angle.sin() * rng.range(1.2, 2.6));
        let path: Vec<_> = (0..=8)
            .map(|i| {
                let t = i as f32 / 8.0;
                (vec3(tip.x * t * t, tip.y * t, tip.z * t * t), 0.17 * (1.0 - 0.75 * t))
            })
            .collect();
        wood.append(&Shape::tube(&path, 9).mapped(|c| c.uv * 1.2));
    }
    for _ in 0..620 {
        let (r, a) = (3.4 * rng.unit().sqrt(), rng.range(0.0, TAU));
        let centre = vec3(r * a.cos(), 4.55 + 0.35 * rng.unit() + 0.25 * (1.0 - r / 3.4), r * a.sin());
        let tilt = upright_to(vec3(rng.range(-0.7, 0.7), 1.0, rng.range(-0.7, 0.7)));
        let tuft =
            Shape::surface(2, 2, |u, v| vec3((u - 0.5) * 0.5 * (1.0 - (v - 0.5).abs()), 0.06 * u, (v - 0.5) * 0.3));
        crown.append(&tuft.moved(Mat4::from_translation(centre) * tilt * turn(a * 7.0)));
    }
    let (wood, crown) = (stage.mesh(wood, bark), stage.mesh(crown, leaf));
    for (x, z, s) in [
        (-7.5, -20.0, 1.0),
        (9.5, -27.0, 1.2),
        (-16.0, -38.0, 1.3),
        (4.5, -46.0, 1.4),
        (20.0, -50.0, 1.5),
        (-5.0, -60.0, 1.5),
        (14.0, -66.0, 1.6),
        (-24.0, -62.0, 1.6),
    ] {
        let place = at(x, -0.05, z) * turn(x) * Mat4::from_scale(vec3(s, s, s));
        stage.node(wood, place);
        stage.node(crown, place);
    }
    let mut tuft = Shape::default();
    for _ in 0..26 {
        let (lean, a) = (rng.range(0.1, 0.5), rng.range(0.0, TAU));
        let (root, h) = (vec3(rng.range(-0.07, 0.07), 0.0, rng.range(-0.07, 0.07)), rng.range(0.14, 0.34));
        let blade = Shape::surface(1, 4, |u, v| {
            let side = vec3(-a.sin(), 0.0, a.cos()) * (u - 0.5) * 0.012 * (1.02 - v);
            root + side + vec3(a.cos() * lean * v * v * h, v * h, a.sin() * lean * v * v * h)
        });
        tuft.append(&blade);
    }
    let tuft = stage.mesh(tuft, straw);
    for _ in 0..280 {
        let z = -1.2 - 24.0 * rng.unit().powi(2);
        let place = at(rng.range(-0.75, 0.75) * (1.5 - z), -0.03, z) * turn(rng.range(0.0, TAU));
        stage.node(tuft, place);
    }
}
