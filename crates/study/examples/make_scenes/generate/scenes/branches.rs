//! Thin crossing branches with leaves, the focus between the two: nothing in the way of
//! a blurred branch has an outline of its own.

use super::prelude::*;
use std::f32::consts::TAU;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.28, 0.42, 0.62),
            horizon: vec3(0.55, 0.56, 0.52),
            ground: vec3(0.12, 0.14, 0.07),
            softbox: 0.0,
        },
        focus_m: 1.12,
        occlusion_m: 0.5,
        ..Stage::default()
    };
    stage.sun(vec3(3.2, 2.8, 2.2), vec3(0.55, -0.62, -0.56), 0.03);
    let bark = stage.jpeg(nature::bark(512, rgb(0x9a7b5c), rgb(0x3a2a1e), 3), 80);
    let bark = stage.matte("bark", bark, 0.9);
    let leaves = [(0x4f8a2c, 0x2f6a1e), (0x86a02a, 0xc8a52c), (0xb5532a, 0xd9992e)].map(|(base, edge)| {
        let texture = stage.jpeg(nature::leaf(256, rgb(base), rgb(edge), base), 84);
        stage.material(Material {
            name: "leaf",
            texture: Some(texture),
            roughness: 0.5,
            double_sided: true,
            ..Material::default()
        })
    });
    garden(&mut stage, bark, &leaves);
    // Two bare crossing branches, one on each side of the focus, and one with leaves.
    limb(
        &mut stage,
        bark,
        None,
        [vec3(-0.55, 0.42, -0.86), vec3(-0.05, 0.06, -0.94), vec3(0.5, -0.36, -0.9)],
        0.0105,
        31,
    );
    limb(
        &mut stage,
        bark,
        None,
        [vec3(-0.62, -0.34, -1.36), vec3(0.02, 0.04, -1.42), vec3(0.66, 0.36, -1.3)],
        0.0125,
        47,
    );
    limb(
        &mut stage,
        bark,
        Some(leaves[0]),
        [vec3(-0.9, 0.62, -1.15), vec3(-0.35, 0.48, -1.2), vec3(0.28, 0.5, -1.1)],
        0.010,
        5,
    );
    limb(
        &mut stage,
        bark,
        Some(leaves[1]),
        [vec3(0.95, -0.62, -1.75), vec3(0.45, -0.28, -1.7), vec3(0.1, -0.36, -1.6)],
        0.011,
        8,
    );
    limb(
        &mut stage,
        bark,
        Some(leaves[2]),
        [vec3(0.5, 0.42, -0.62), vec3(0.33, 0.2, -0.6), vec3(0.26, 0.02, -0.58)],
        0.005,
        12,
    );
    limb(
        &mut stage,
        bark,
        Some(leaves[2]),
        [vec3(-1.3, -0.5, -2.2), vec3(-0.7, -0.2, -2.1), vec3(-0.3, 0.1, -2.3)],
        0.014,
        21,
    );
    stage.camera("crossing", vec3(0.0, 0.05, 0.0), vec3(0.0, 0.02, -1.1), 40.0, 0.05);
    stage.camera("aside", vec3(0.55, 0.25, 0.1), vec3(-0.1, 0.0, -1.3), 45.0, 0.05);
    stage
}

/// A leaf along +y from the origin, its face towards +z.
fn leaf(length: f32, nu: usize, nv: usize) -> Shape {
    Shape::surface(nu, nv, |u, v| {
        let side = 2.0 * u - 1.0;
        let outline = (v.powf(0.6) * (1.0 - v).powf(0.75)) * 0.95 + 0.01;
        let serrated = 1.0 + 0.1 * (v * 14.0).fract() * f32::from(nv > 12);
        let x = side * outline * serrated * 0.5 * length;
        vec3(x, v * length, 0.12 * length * (side * side * outline * 1.6 - (v * 2.4).sin() * 0.6))
    })
    .mapped(|c| vec2(c.uv.x, 1.0 - c.uv.y))
}

/// A branch through three points with side twigs, leaved or bare.
fn limb(stage: &mut Stage, bark: usize, leaves: Option<usize>, through: [Vec3; 3], radius: f32, seed: u32) {
    let mut rng = Rng::new(seed);
    let [a, b, c] = through;
    let control = b * 2.0 - (a + c) * 0.5;
    let wobble = |t: f32, s: f32| {
        let n = |k: u32| fbm(vec2(t * 0.5, 0.37), ivec2(9, 3), 3, seed + k) - 0.5;
        vec3(n(1), n(2), n(3)) * s
    };
    let along = |t: f32| a * (1.0 - t) * (1.0 - t) + control * 2.0 * t * (1.0 - t) + c * t * t + wobble(t, 0.05);
    let thick = |t: f32| radius * (1.0 - 0.55 * t) * (1.0 + 0.22 * (t * 47.0).sin().max(0.0).powi(6));
    let path: Vec<(Vec3, f32)> = (0..=72).map(|k| (along(k as f32 / 72.0), thick(k as f32 / 72.0))).collect();
    let mut wood = Shape::tube(&path, 14).mapped(|c| vec2(c.uv.x, c.uv.y * 6.0));
    let mut foliage = Shape::default();
    let twigs = if leaves.is_some() { 16 } else { 7 };
    for k in 0..twigs {
        let t = (k as f32 + rng.range(0.2, 0.9)) / twigs as f32;
        let start = along(t);
        let heading = (along((t + 0.02).min(1.0)) - along(t - 0.02)).normalize_or(Vec3::X);
        let out = vec3(rng.range(-1.0, 1.0), rng.range(-0.8, 1.0), rng.range(-0.45, 0.45)).normalize_or(Vec3::Y);
        let direction = (heading * 0.6 + out).normalize_or(Vec3::Y);
        let length = rng.range(0.06, 0.16) * if leaves.is_some() { 1.0 } else { 0.8 };
        let twig = |s: f32| {
            start + direction * length * s + Vec3::NEG_Y * 0.03 * s * s + wobble(s + t, 0.02) - wobble(t, 0.02)
        };
        let path: Vec<_> = (0..=8).map(|i| (twig(i as f32 / 8.0), 0.35 * thick(t) * (1.1 - i as f32 / 8.0))).collect();
        wood.append(&Shape::tube(&path, 8).mapped(|c| vec2(c.uv.x, c.uv.y * 6.0)));
        let count = if leaves.is_some() { 4 } else { 0 };
        for i in 0..count {
            let s = (i as f32 + 1.0) / count as f32;
            let point = (direction + vec3(rng.range(-0.8, 0.8), rng.range(-0.9, 0.4), rng.range(-0.5, 0.7)))
                .normalize_or(Vec3::X);
            let spin = Mat4::from_rotation_y(rng.range(-0.9, 0.9));
            let place = Mat4::from_translation(twig(s)) * upright_to(point) * spin;
            foliage.append(&leaf(rng.range(0.06, 0.1), 6, 14).moved(place));
        }
    }
    stage.place(wood, bark);
    if let Some(material) = leaves {
        stage.place(foliage, material);
    }
}

fn garden(stage: &mut Stage, bark: usize, leaves: &[usize; 3]) {
    let bricks = stage.jpeg(patterns::brick(768, ivec2(5, 14), rgb(0x9c5a44), rgb(0xc2bba8), 17), 78);
    let bricks = stage.matte("garden wall", bricks, 0.9);
    let wall = Shape::surface(60, 36, |u, v| vec3((u - 0.5) * 8.0, 2.4 - 3.6 * v, -4.2))
        .flipped_if(|c| c.normal.z < 0.0)
        .mapped(|c| vec2(c.position.x, -c.position.y) / 1.2);
    stage.place(wall, bricks);
    let soil = stage.jpeg(nature::savanna(512, 6), 76);
    let soil = stage.matte("soil", soil, 0.95);
    let ground = Shape::surface(50, 40, |u, v| vec3((u - 0.5) * 8.0, -1.2, 0.5 - 5.0 * v))
        .flipped_if(|c| c.normal.y < 0.0)
        .mapped(|c| vec2(c.position.x, c.position.z) / 1.5);
    stage.place(ground, soil);
    let mut rng = Rng::new(99);
    let sprays: Vec<usize> = leaves
        .iter()
        .map(|&material| {
            let mut spray = Shape::default();
            for _ in 0..22 {
                let place = vec3(rng.range(-0.16, 0.16), rng.range(-0.14, 0.16), rng.range(-0.1, 0.1));
                let point = vec3(rng.range(-1.0, 1.0), rng.range(-1.0, 0.6), rng.range(0.0, 0.9)).normalize_or(Vec3::Y);
                let m = Mat4::from_translation(place) * upright_to(point) * turn(rng.range(-0.8, 0.8));
                spray.append(&leaf(rng.range(0.07, 0.12), 4, 5).moved(m));
            }
            stage.mesh(spray, material)
        })
        .collect();
    // Ivy on the wall, thick at its foot and in two columns, and bushes before it.
    for k in 0..560 {
        let (x, z) = (rng.range(-3.4, 3.4), if k % 3 == 0 { rng.range(-3.9, -2.7) } else { -4.1 });
        let dense = fbm(vec2(x / 7.0 + 0.5, 0.3), ivec2(7, 1), 2, 41);
        let y = if z > -4.0 { rng.range(-1.2, -0.55 + 0.4 * dense) } else { rng.range(-1.2, -1.4 + 3.6 * dense) };
        let kind = if rng.unit() < 0.62 { 0 } else { 1 + rng.index(2) };
        let tilt = Mat4::from_rotation_z(rng.range(0.0, TAU)) * turn(rng.range(-0.6, 0.6));
        stage.node(sprays[kind], at(x, y, z) * tilt);
    }
    for (x, lean) in [(-1.9f32, 0.25f32), (1.7, -0.2), (2.9, 0.1)] {
        let path: Vec<_> = (0..=24)
            .map(|k| {
                let t = k as f32 / 24.0;
                (
                    vec3(x + lean * t + 0.06 * (t * 9.0).sin(), -1.2 + 3.6 * t, -3.2 + 0.1 * (t * 5.0).cos()),
                    0.11 - 0.04 * t,
                )
            })
            .collect();
        stage.place(Shape::tube(&path, 24).mapped(|c| vec2(c.uv.x * 2.0, c.uv.y * 2.0)), bark);
    }
}
