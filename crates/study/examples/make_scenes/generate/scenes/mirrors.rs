//! Polished metal at many depths: what it shows moves with the eye.

use super::prelude::*;
use std::f32::consts::TAU;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.10, 0.13, 0.20),
            horizon: vec3(0.62, 0.52, 0.42),
            ground: vec3(0.05, 0.035, 0.03),
            softbox: 5.0,
        },
        focus_m: 2.0,
        occlusion_m: 0.6,
        ..Stage::default()
    };
    stage.sun(vec3(1.9, 1.75, 1.55), vec3(-0.5, -0.75, -0.35), 0.06);
    hall(&mut stage);
    let metals = [
        ("chrome", vec3(0.78, 0.79, 0.80), 0.03),
        ("gold", vec3(0.95, 0.68, 0.30), 0.10),
        ("copper", vec3(0.90, 0.52, 0.40), 0.07),
        ("blued steel", vec3(0.25, 0.36, 0.62), 0.05),
        ("brushed", vec3(0.62, 0.60, 0.57), 0.15),
    ]
    .map(|(name, color, roughness)| {
        stage.material(Material { name, color, metallic: 1.0, roughness, ..Material::default() })
    });
    pieces(&mut stage, &metals);
    stage.camera("hall", vec3(0.0, 0.62, 0.0), vec3(0.05, 0.36, -2.2), 42.0, 0.05);
    stage.camera("low", vec3(-0.75, 0.22, -0.3), vec3(0.35, 0.34, -2.6), 46.0, 0.05);
    stage
}

fn hall(stage: &mut Stage) {
    let tiles = stage.jpeg(patterns::star_tiles(1024, 4, 5), 78);
    let tiles = stage.matte("tiles", tiles, 0.35);
    let floor = Shape::surface(70, 90, |u, v| {
        let s = 2.0 * u - 1.0;
        vec3(5.0 * (0.4 * s + 0.6 * s * s * s), 0.0, 0.6 - 9.6 * (0.3 * v + 0.7 * v * v))
    });
    let floor = floor.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z) / 1.2);
    stage.place(floor, tiles);
    let lattice = stage.jpeg(patterns::damask(768, 4, rgb(0x1f3a3d), rgb(0xcaa55a), rgb(0xe9dcb8)), 80);
    let lattice = stage.matte("hanging", lattice, 0.8);
    let wall = Shape::surface(50, 22, |u, v| vec3((u - 0.5) * 11.0, 4.2 - 4.2 * v, -8.6))
        .flipped_if(|c| c.normal.z < 0.0)
        .mapped(|c| vec2(c.position.x, -c.position.y) / 1.6);
    stage.place(wall, lattice);
}

fn pieces(stage: &mut Stage, metals: &[usize; 5]) {
    let balls = metals.map(|metal| stage.mesh(Shape::sphere(1.0, 28), metal));
    let mut rng = Rng::new(17);
    let near = [
        (-0.30, -0.95, 0.13, 1),
        (0.28, -0.80, 0.085, 0),
        (0.46, -1.35, 0.17, 2),
        (-0.75, -1.75, 0.26, 0),
        (0.02, -1.98, 0.2, 3),
    ];
    for (x, z, r, metal) in near {
        stage.place(Shape::sphere(r, 34).moved(at(x, r, z)), metals[metal]);
    }
    let mut set: Vec<Vec3> = near.iter().map(|n| vec3(n.0, n.1, n.2)).collect();
    while set.len() < 34 {
        let r = rng.range(0.07, 0.30);
        let z = rng.range(-7.8, -2.3);
        let x = rng.range(-0.42, 0.42) * -z;
        let free = set.iter().all(|o| vec2(o.x - x, o.y - z).length() > o.z + r + 0.08);
        if free && vec2(x - 0.75, z + 2.9).length() > r + 0.5 && vec2(x + 0.9, z + 4.2).length() > r + 0.6 {
            set.push(vec3(x, z, r));
            stage.node(balls[rng.index(5)], at(x, r, z) * Mat4::from_scale(vec3(r, r, r)));
        }
    }
    let ring = |major: f32, minor: f32| Shape::torus(major, minor, 96, 26);
    stage.place(ring(0.34, 0.085).moved(at(0.75, 0.42, -2.9) * turn(0.5) * Mat4::from_rotation_x(1.35)), metals[1]);
    stage.place(ring(0.42, 0.06).moved(at(-0.9, 0.47, -4.2) * turn(-0.6) * Mat4::from_rotation_x(1.5)), metals[2]);
    stage.place(ring(0.15, 0.035).moved(at(-0.02, 0.035, -1.25)), metals[4]);
    let plinth = stage.matte("plinth", 0, 0.5);
    for (x, z) in [(-1.7, -3.1), (1.75, -4.0), (0.15, -5.6)] {
        stage.place(Shape::cuboid(vec3(x, 0.2, z), vec3(0.6, 0.4, 0.4), 0.1), plinth);
        let knot: Vec<(Vec3, f32)> = (0..=150)
            .map(|k| {
                // A little past the full turn: the ends overlap.
                let t = k as f32 / 148.0 * TAU;
                let r = 0.17 + 0.075 * (3.0 * t).cos();
                (vec3(r * (2.0 * t).cos(), 0.68 + r * (2.0 * t).sin(), 0.09 * (3.0 * t).sin()), 0.042)
            })
            .collect();
        stage.place(Shape::tube(&knot, 14).moved(at(x, 0.0, z)), metals[if x < 0.0 { 3 } else { 0 }]);
    }
    // Wavy panels like folding screens.
    for (x, z, angle, metal) in
        [(-2.6, -5.2, 0.55, 4), (2.5, -6.2, -0.5, 1), (-0.5, -7.6, 0.1, 0), (1.5, -2.35, -0.75, 3)]
    {
        let scale = if z > -3.0 { 0.5 } else { 1.0 };
        let panel = Shape::surface(90, 30, |u, v| {
            let wave = 0.07 * (u * 5.0 * TAU).sin() + 0.03 * (v * 3.0 * TAU + u * 4.0).sin();
            vec3((u - 0.5) * 1.7, v * 1.8, wave) * scale
        });
        let panel = panel.flipped_if(|c| c.normal.z < 0.0);
        stage.place(panel.moved(at(x, 0.0, z) * turn(angle)), metals[metal]);
    }
}
