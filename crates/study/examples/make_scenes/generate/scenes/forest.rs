//! A dense wood, of which a picture with a depth map is made.

use super::prelude::*;
use std::f32::consts::TAU;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.34, 0.46, 0.50),
            horizon: vec3(0.46, 0.52, 0.42),
            ground: vec3(0.10, 0.12, 0.05),
            softbox: 0.0,
        },
        focus_m: 3.2,
        occlusion_m: 0.9,
        ..Stage::default()
    };
    stage.sun(vec3(4.2, 3.7, 2.7), vec3(0.45, -0.70, 0.28), 0.03);
    let soil = stage.jpeg(floor_texture(), 84);
    let soil = stage.matte("litter", soil, 0.95);
    let ground = Shape::surface(160, 170, |u, v| {
        let s = 2.0 * u - 1.0;
        let (x, z) = (18.0 * (0.3 * s + 0.7 * s * s * s), 1.5 - 31.0 * (0.25 * v + 0.75 * v * v));
        vec3(x, height(x, z), z)
    });
    stage.place(ground.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z) / 1.6), soil);
    trunks(&mut stage);
    undergrowth(&mut stage);
    canopy(&mut stage);
    stage.camera("forest", vec3(0.0, 1.15, 0.0), vec3(0.1, 1.0, -4.0), 42.0, 0.1);
    stage
}

fn height(x: f32, z: f32) -> f32 {
    0.55 * (fbm(vec2(x, z) / 40.0 + 0.5, ivec2(8, 8), 4, 3) - 0.5)
}

fn floor_texture() -> Canvas {
    let palette = [0x8a5a2c, 0xa9793a, 0x5f3f22, 0xc09a4e, 0x6f6a30].map(rgb);
    Canvas::paint(1024, 1024, move |uv| {
        let mut colour = rgb(0x2c2015) * (0.6 + 0.8 * fbm(uv, ivec2(30, 30), 3, 2));
        for layer in 0..3u32 {
            let (first, second, id) = cells(uv, ivec2(26, 26) + 3 * layer as i32, 11 + layer);
            let tone = hash(id.x, id.y, layer + 40);
            if tone > 0.35 && first < 0.42 {
                let rib = lines(first * 6.0 + tone, 0.16, 0.06);
                let face = palette[(tone * 97.0) as usize % 5] * (0.6 + 0.8 * (second - first).min(0.6));
                colour = face.lerp(face * 0.55, rib);
            }
        }
        let moss = smoothstep(0.54, 0.62, fbm(uv, ivec2(4, 4), 5, 9));
        colour.lerp(rgb(0x5c7a26) * (0.5 + 0.9 * fbm(uv, ivec2(90, 90), 2, 5)), moss)
    })
}

fn trunks(stage: &mut Stage) {
    let barks = [(0x8f7658, 0x33261a, 3), (0x9a9484, 0x38342c, 8)].map(|(light, dark, seed)| {
        let texture = stage.jpeg(nature::bark(768, rgb(light), rgb(dark), seed), 84);
        stage.matte("bark", texture, 0.95)
    });
    let mut rng = Rng::new(12);
    let mut stands: Vec<Vec3> =
        vec![vec3(-1.15, 0.0, -1.9), vec3(0.95, 0.0, -3.2), vec3(-0.35, 0.0, -5.2), vec3(2.3, 0.0, -4.4)];
    while stands.len() < 90 {
        let z = -3.0 - 26.0 * rng.unit().sqrt();
        let p = vec3(rng.range(-0.75, 0.75) * (2.0 - z), 0.0, z);
        if stands.iter().all(|q| q.distance(p) > 0.9) {
            stands.push(p);
        }
    }
    for (k, stand) in stands.iter().enumerate() {
        let (girth, lean) = (rng.range(0.09, 0.24), vec2(rng.range(-0.06, 0.06), rng.range(-0.05, 0.05)));
        let (sides, rings) = if k < 12 { (48, 60) } else { (14, 16) };
        let root = stand.with_y(height(stand.x, stand.z) - 0.1);
        let trunk = Shape::surface(sides, rings, |u, v| {
            let (sin, cos) = (u * TAU).sin_cos();
            let flare = 1.0 + 0.8 * (-(v * 7.0 / 0.35)).exp() * (1.0 + 0.4 * (u * TAU * 5.0 + k as f32).cos());
            let knobs = 1.0 + 0.08 * (fbm(vec2(u, v * 0.5), ivec2(4, 9), 3, k as u32) - 0.5);
            let radius = girth * flare * knobs * (1.0 - 0.35 * v);
            root + vec3(
                lean.x * 7.0 * v + 0.05 * (v * 9.0 + k as f32).sin() + sin * radius,
                7.0 * v,
                lean.y * 7.0 * v + cos * radius,
            )
        });
        let around = (girth * 8.0).round().max(1.0);
        stage.place(trunk.mapped(|c| vec2(c.uv.x * around, c.uv.y * 7.0)), barks[k % 2]);
    }
}

/// One frond along +z, arching: a stem with leaflets in pairs.
fn frond(length: f32, pairs: usize) -> Shape {
    let arch = |t: f32| vec3(0.0, length * (0.75 * t - 0.62 * t * t), length * t * 0.85);
    let stem: Vec<(Vec3, f32)> = (0..=10).map(|k| (arch(k as f32 / 10.0), 0.004 * (1.1 - k as f32 / 10.0))).collect();
    let mut shape = Shape::tube(&stem, 5).mapped(|_| vec2(0.5, 0.3));
    for k in 0..2 * pairs {
        let side = if k % 2 == 0 { 1.0f32 } else { -1.0 };
        let t = 0.08 + 0.9 * (k / 2) as f32 / pairs as f32;
        let reach = length * 0.26 * (1.0 - t).powf(0.7) * smoothstep(0.0, 0.2, t) + 0.004;
        let leaflet = Shape::surface(2, 6, |u, v| {
            let width = 0.42 * length / pairs as f32 * (1.0 - v).powf(0.6) * (1.0 - 0.3 * (v * 19.0).cos());
            arch(t) + vec3(side * reach * v, -0.25 * reach * v * v, (u - 0.5) * width + 0.35 * reach * v)
        });
        shape.append(&leaflet.mapped(|c| vec2(c.uv.x, 1.0 - c.uv.y)));
    }
    shape
}

fn undergrowth(stage: &mut Stage) {
    let greens = [(0x4f8f2c, 0x7fae3a), (0x6c8f2a, 0xc2a53a)].map(|(base, edge)| {
        let texture = stage.jpeg(nature::leaf(256, rgb(base), rgb(edge), base), 86);
        stage.material(Material { name: "fern", texture: Some(texture), double_sided: true, ..Material::default() })
    });
    let mut rng = Rng::new(44);
    let ferns: Vec<usize> = (0..4)
        .map(|k| {
            let mut fern = Shape::default();
            let count = 8 + k;
            for i in 0..count {
                let spin = turn((i as f32 + rng.range(-0.3, 0.3)) / count as f32 * TAU);
                let tilt = Mat4::from_rotation_x(rng.range(-0.35, 0.15));
                fern.append(&frond(rng.range(0.42, 0.75), 20).moved(spin * tilt));
            }
            stage.mesh(fern, greens[k % 2])
        })
        .collect();
    for k in 0..360 {
        let z = -0.9 - 22.0 * rng.unit().powf(1.6);
        let x = rng.range(-0.7, 0.7) * (1.6 - z);
        let size = rng.range(0.6, 1.15);
        if z < -1.6 || x.abs() > 0.45 {
            let place = at(x, height(x, z) - 0.02, z) * turn(rng.range(0.0, TAU));
            stage.node(ferns[k % 4], place * Mat4::from_scale(vec3(size, size, size)));
        }
    }
}

/// Low twigs with leaves, near ones against far ones.
fn canopy(stage: &mut Stage) {
    let texture = stage.jpeg(nature::leaf(256, rgb(0x5f9a2e), rgb(0xb4c23e), 71), 86);
    let green =
        stage.material(Material { name: "leaf", texture: Some(texture), double_sided: true, ..Material::default() });
    let mut rng = Rng::new(70);
    let sprays: Vec<usize> = (0..3)
        .map(|_| {
            let path: Vec<(Vec3, f32)> =
                (0..=12).map(|k| (vec3(k as f32 * 0.05, -0.0025 * (k * k) as f32, 0.0), 0.004)).collect();
            let mut spray = Shape::tube(&path, 6).mapped(|_| vec2(0.5, 0.4));
            for _ in 0..34 {
                let t = rng.range(0.1, 1.0);
                let point =
                    vec3(rng.range(-0.2, 1.0), rng.range(-0.8, 0.5), rng.range(-1.0, 1.0)).normalize_or(Vec3::X);
                let size = rng.range(0.045, 0.085);
                let leaf = Shape::surface(4, 6, |u, v| {
                    let side = 2.0 * u - 1.0;
                    let outline = v.powf(0.6) * (1.0 - v).powf(0.75) * 0.9 + 0.01;
                    vec3(side * outline * 0.5, v, 0.2 * side * side * outline - 0.15 * v * v) * size
                });
                let place = at(t * 0.6, -0.36 * t * t, 0.0) * upright_to(point) * turn(rng.range(0.0, TAU));
                spray.append(&leaf.mapped(|c| vec2(c.uv.x, 1.0 - c.uv.y)).moved(place));
            }
            stage.mesh(spray, green)
        })
        .collect();
    for (k, (x, y, z, spin)) in
        [(-0.75, 1.62, -1.05, 0.2), (0.85, 1.55, -1.5, 2.7), (-1.2, 1.9, -2.0, -0.3)].into_iter().enumerate()
    {
        stage.node(sprays[k], at(x, y, z) * turn(spin));
    }
    for k in 0..620 {
        let z = -2.4 - 22.0 * rng.unit().powf(1.4);
        let place = at(rng.range(-0.7, 0.7) * (1.8 - z), rng.range(1.5, 2.2) + rng.range(0.0, 0.42) * -z, z);
        let tilt = turn(rng.range(0.0, TAU)) * Mat4::from_rotation_z(rng.range(-0.5, 0.5));
        stage.node(sprays[k % 3], place * tilt * Mat4::from_scale(Vec3::splat(rng.range(1.0, 1.7))));
    }
}
