//! Classical parts: a fluted column, an arch, balusters, cloth.

use super::prelude::*;
use std::f32::consts::{PI, TAU};

/// A Corinthian column 2.9 m high standing at the origin.
pub fn column() -> Shape {
    let mut shape = Shape::surface(160, 14, |u, v| {
        let (sin, cos) = (u * TAU).sin_cos();
        let ends = smoothstep(0.0, 0.03, v) * smoothstep(1.0, 0.97, v);
        let flute = ((u * 20.0 * PI).sin().abs()).sqrt() * 0.028 * ends;
        let radius = 0.215 - 0.035 * v * v - flute;
        vec3(sin * radius, 0.3 + 2.1 * v, cos * radius)
    })
    .mapped(|c| vec2(c.uv.x * 2.0, -1.5 * c.position.y));
    let attic: Vec<Vec2> = (0..=28)
        .map(|k| {
            let t = k as f32 / 28.0;
            let round = |centre: f32, half: f32| (1.0 - ((t - centre) / half).powi(2)).max(0.0).sqrt();
            let radius = 0.215 + 0.07 * round(0.2, 0.2) - 0.01 * round(0.52, 0.12) + 0.045 * round(0.78, 0.14);
            vec2(radius, 0.1 + 0.2 * t)
        })
        .collect();
    shape.append(&scaled_uv(Shape::lathe(&attic, 48), 1.4, 0.3));
    shape.append(&Shape::cuboid(vec3(0.0, 0.05, 0.0), vec3(0.6, 0.1, 0.6), 0.15));
    shape.append(&capital());
    shape
}

fn scaled_uv(shape: Shape, u: f32, v: f32) -> Shape {
    shape.mapped(|c| vec2(c.uv.x * u, c.uv.y * v))
}

fn capital() -> Shape {
    let ring = [(0.185, 2.385), (0.2, 2.395), (0.2, 2.41)];
    let bell = [(0.178, 2.42), (0.182, 2.55), (0.2, 2.66), (0.235, 2.75), (0.26, 2.79)];
    let profile: Vec<Vec2> = ring.into_iter().chain(bell).map(|(r, y)| vec2(r, y)).collect();
    let mut shape = scaled_uv(Shape::lathe(&profile, 48), 1.4, 0.4);
    for tier in 0..2 {
        let (base, height, lean) = (2.42 + 0.02 * tier as f32, 0.17 + 0.13 * tier as f32, 0.075);
        let leaf = Shape::surface(8, 12, |u, v| {
            let side = 2.0 * u - 1.0;
            let lobes = 1.0 - 0.22 * (v * 5.0 * TAU).cos().max(0.0);
            let width = 0.062 * (1.0 - 0.75 * v * v) * lobes;
            let curl = smoothstep(0.6, 1.0, v);
            let out = 0.186 + lean * v * v + 0.05 * curl - 0.012 * side * side + 0.006 * (side * 9.0).cos();
            vec3(side * width, base + height * (v - 0.28 * curl * curl), out + 0.008)
        });
        for k in 0..8 {
            let angle = (k as f32 + 0.5 * tier as f32) / 8.0 * TAU;
            shape.append(&leaf.clone().mapped(|c| c.uv * 0.2).moved(turn(angle)));
        }
    }
    let spiral: Vec<(Vec3, f32)> = (0..28)
        .map(|k| {
            let t = k as f32 / 27.0;
            let (sin, cos) = (t * 2.1 * TAU).sin_cos();
            let radius = 0.052 * (1.0 - 0.8 * t);
            (vec3(0.0, 2.73 + radius * cos, 0.285 + radius * sin), 0.013 * (1.0 - 0.5 * t))
        })
        .collect();
    for k in 0..8 {
        let angle = (k / 2) as f32 / 4.0 * TAU + TAU / 8.0 + if k % 2 == 0 { 0.09 } else { -0.09 };
        shape.append(&Shape::tube(&spiral, 7).mapped(|c| c.uv * 0.3).moved(turn(angle)));
    }
    shape.append(&Shape::cuboid(vec3(0.0, 2.82, 0.0), vec3(0.54, 0.06, 0.54), 0.1));
    shape.append(&Shape::cuboid(vec3(0.0, 2.875, 0.0), vec3(0.58, 0.05, 0.58), 0.1));
    shape
}

/// One bay of an arcade along x, springing at y = 0: `bay` wide, opening of `radius`.
pub fn arch(bay: f32, radius: f32, height: f32, thickness: f32) -> Shape {
    let rim = |u: f32| {
        let (sin, cos) = (u * PI).sin_cos();
        let reach = (bay * 0.5 / cos.abs().max(1e-4)).min(height / sin.max(1e-4));
        (vec2(-cos, sin) * radius, vec2(-cos, sin) * reach)
    };
    let mut shape = Shape::default();
    for side in [-1.0f32, 1.0] {
        let face = Shape::surface(48, 5, |u, v| {
            let (inner, outer) = rim(u);
            inner.lerp(outer, v).extend(side * thickness * 0.5)
        })
        .flipped_if(|c| c.normal.z * side < 0.0);
        shape.append(&face.mapped(|c| vec2(c.position.x, -c.position.y)));
        for (offset, thick) in [(0.05, 0.035), (0.14, 0.05), (0.2, 0.018)] {
            let path: Vec<(Vec3, f32)> = (0..=36)
                .map(|k| {
                    let (sin, cos) = (k as f32 / 36.0 * PI).sin_cos();
                    ((vec2(-cos, sin) * (radius + offset)).extend(side * thickness * 0.5), thick)
                })
                .collect();
            shape.append(&Shape::tube(&path, 7).mapped(|c| vec2(c.uv.y, c.uv.x * 0.3)));
        }
    }
    let soffit = Shape::surface(48, 5, |u, v| rim(u).0.extend((v - 0.5) * thickness))
        .flipped_if(|c| c.normal.y > 0.0)
        .mapped(|c| vec2(c.uv.x * 2.8, c.uv.y * thickness));
    shape.append(&soffit);
    for side in [-1.0, 1.0] {
        let centre = vec3(side * (bay * 0.5 + radius) * 0.5, 0.02, 0.0);
        shape.append(&Shape::cuboid(centre, vec3(bay * 0.5 - radius, 0.07, thickness + 0.06), 0.15));
    }
    shape
}

/// A turned baluster 0.7 m high.
pub fn baluster(turns: usize) -> Shape {
    let profile: Vec<Vec2> = (0..=36)
        .map(|k| {
            let t = k as f32 / 36.0;
            let belly = 0.042 * (-((t - 0.36) / 0.14).powi(2)).exp();
            let rings =
                0.012 * [0.06, 0.64, 0.72, 0.93].iter().map(|c| (-((t - c) / 0.022).powi(2)).exp()).sum::<f32>();
            vec2(0.022 + belly + rings + 0.01 * (t - 0.62).abs(), 0.7 * t)
        })
        .collect();
    Shape::lathe(&profile, turns)
}

/// Cloth hung from a rod along x: `width` by `height`, gathered into folds.
pub fn drape(width: f32, height: f32, nu: usize, nv: usize) -> Shape {
    Shape::surface(nu, nv, |u, v| {
        let pull = 1.0 - 0.22 * (v * PI).sin() * v;
        let phase = u * 9.0 + 0.35 * (u * 17.0).sin() + 0.5 * v * (u * 7.0 + 1.0).sin();
        let depth = (0.035 + 0.05 * v) * (phase * TAU).sin() + 0.02 * v * (u * 31.0 + v * 3.0).sin();
        let hem = 0.03 * (phase * TAU).cos() * v;
        vec3((u - 0.5) * width * pull, -height * v + hem, depth)
    })
    .mapped(|c| vec2(c.uv.x * width * 1.5, c.uv.y * height) * 0.7)
}

/// A wrought-iron panel `width` along x, 1 m high.
pub fn railing(width: f32) -> Shape {
    let rod = |a: Vec3, b: Vec3, r: f32| Shape::tube(&[(a, r), (a.lerp(b, 0.5), r), (b, r)], 6);
    let mut shape = Shape::default();
    for (y, r) in [(0.08, 0.009), (0.82, 0.009), (0.98, 0.02)] {
        shape.append(&rod(vec3(-width * 0.5, y, 0.0), vec3(width * 0.5, y, 0.0), r));
    }
    let count = (width / 0.11) as usize;
    for k in 0..=count {
        let x = (k as f32 / count as f32 - 0.5) * width;
        shape.append(&rod(vec3(x, 0.0, 0.0), vec3(x, 0.97, 0.0), 0.0055));
        if k < count {
            let ring = Shape::torus(0.045, 0.005, 18, 5).moved(Mat4::from_rotation_x(PI * 0.5));
            let middle = x + 0.5 * width / count as f32;
            shape.append(&ring.clone().moved(at(middle, 0.895, 0.0)));
            shape.append(&ring.moved(at(middle, 0.45, 0.0)));
        }
    }
    shape
}
