//! Textures of living things and of the ground, and implicit bodies.

use super::canvas::{Canvas, lines, rgb};
use super::noise::{cells, fbm, hash, mix, smoothstep};
use super::shape::{Corner, Shape};
use glam::{IVec3, Vec2, Vec3, ivec2, vec2};
use std::collections::HashMap;

/// Bark: ridges along v.
pub fn bark(size: usize, light: Vec3, dark: Vec3, seed: u32) -> Canvas {
    let ridge = move |uv: Vec2| {
        let bent = vec2(uv.x + 0.03 * fbm(uv, ivec2(4, 8), 3, seed), uv.y);
        let (first, second, _) = cells(bent, ivec2(14, 5), seed + 1);
        smoothstep(0.0, 0.28, second - first) * (0.6 + 0.6 * fbm(uv, ivec2(30, 12), 3, seed + 2))
    };
    Canvas::paint(size, size, move |uv| {
        let lichen = smoothstep(0.62, 0.68, fbm(uv, ivec2(9, 9), 4, seed + 3));
        dark.lerp(light, ridge(uv)).lerp(rgb(0x9aa68a), 0.7 * lichen)
    })
    .emboss(0.9, ridge)
}

/// A leaf's upper side, stem at v = 1, tip at v = 0.
pub fn leaf(size: usize, base: Vec3, edge: Vec3, seed: u32) -> Canvas {
    Canvas::paint(size, size, move |uv| {
        let side = (uv.x - 0.5).abs() * 2.0;
        let vein = lines((uv.y + 0.32 * side) * 8.0, 0.13, 0.05) * (1.0 - side * 0.6);
        let middle = smoothstep(0.07, 0.03, side);
        let blotch = fbm(uv, ivec2(5, 5), 4, seed);
        let spot = smoothstep(0.16, 0.1, cells(uv, ivec2(7, 7), seed + 1).0) * smoothstep(0.5, 0.7, blotch);
        let tone = base.lerp(edge, smoothstep(0.35, 1.0, side * 0.6 + blotch * 0.6));
        (tone * (0.8 + 0.4 * blotch)).lerp(rgb(0xdfe6b0), 0.75 * vein.max(middle)).lerp(rgb(0x4a2a14), 0.8 * spot)
    })
}

/// Dry ground: cracked clay, pebbles and straw.
pub fn savanna(size: usize, seed: u32) -> Canvas {
    let stones = move |uv: Vec2| {
        let (first, _, id) = cells(uv, ivec2(40, 40), seed + 4);
        let radius = 0.1 + 0.28 * hash(id.x, id.y, seed + 5).powi(3);
        (smoothstep(radius, radius - 0.07, first), hash(id.x, id.y, seed + 6))
    };
    let crack = move |uv: Vec2| {
        let (first, second, _) = cells(uv + 0.012 * fbm(uv, ivec2(20, 20), 3, seed), ivec2(13, 13), seed + 1);
        smoothstep(0.07, 0.02, second - first)
    };
    let straw = move |uv: Vec2| {
        let patch = smoothstep(0.5, 0.62, fbm(uv, ivec2(5, 5), 4, seed + 8));
        let blade = fbm(vec2(uv.x + 0.02 * uv.y, uv.y), ivec2(90, 14), 2, seed + 9);
        patch * smoothstep(0.5, 0.6, blade)
    };
    Canvas::paint(size, size, move |uv| {
        let (stone, tone) = stones(uv);
        let base = rgb(0xb98a58).lerp(rgb(0x8a5f3a), fbm(uv, ivec2(4, 4), 5, seed + 2));
        let ground = base * (1.0 - 0.6 * crack(uv)) * (0.8 + 0.4 * fbm(uv, ivec2(60, 60), 2, seed + 3));
        let ground = ground.lerp(rgb(0xd8c07a), 0.8 * straw(uv));
        ground.lerp(rgb(0xa39a8c) * (0.6 + 0.7 * tone), stone)
    })
    .emboss(0.7, move |uv| stones(uv).0 + 0.6 * straw(uv) - crack(uv))
}

/// Wrinkled hide.
pub fn hide(size: usize, base: Vec3, seed: u32) -> Canvas {
    let fold = move |uv: Vec2| {
        let bent = uv + 0.03 * vec2(fbm(uv, ivec2(6, 6), 3, seed), fbm(uv, ivec2(6, 6), 3, seed + 20));
        let (a, b, _) = cells(bent, ivec2(26, 44), seed + 1);
        let (c, d, _) = cells(bent, ivec2(9, 14), seed + 2);
        smoothstep(0.02, 0.25, b - a) * mix(0.55, 1.0, smoothstep(0.01, 0.12, d - c))
    };
    Canvas::paint(size, size, move |uv| {
        let mud = smoothstep(0.48, 0.62, fbm(uv, ivec2(4, 4), 5, seed + 4));
        (base * (0.58 + 0.45 * fold(uv))).lerp(rgb(0x9a6f4a), 0.5 * mud * fold(uv))
    })
    .emboss(0.6, fold)
}

/// Polygonises `field < 0` within `lo..hi` by naive surface nets (Gibson 1998): a vertex
/// in every cell that the surface crosses, at the mean of the crossings of its edges.
pub fn surface_net(lo: Vec3, hi: Vec3, cell: f32, field: impl Fn(Vec3) -> f32) -> Shape {
    let size = ((hi - lo) / cell).ceil().as_ivec3() + 1;
    let index = |p: IVec3| ((p.z * size.y + p.y) * size.x + p.x) as usize;
    let point = |p: IVec3| lo + p.as_vec3() * cell;
    let grid = |limit: IVec3| {
        (0..limit.z).flat_map(move |z| (0..limit.y).flat_map(move |y| (0..limit.x).map(move |x| IVec3::new(x, y, z))))
    };
    let values: Vec<f32> = grid(size).map(|p| field(point(p))).collect();
    let (mut shape, mut vertex) = (Shape::default(), HashMap::new());
    for p in grid(size - 1) {
        let corner = |k: i32| p + IVec3::new(k & 1, k >> 1 & 1, k >> 2 & 1);
        let inside = (0..8).filter(|&k| values[index(corner(k))] < 0.0).count();
        if inside == 0 || inside == 8 {
            continue;
        }
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for (a, bit) in (0..8).flat_map(|a| [1, 2, 4].map(|bit| (a, bit))).filter(|&(a, bit)| a & bit == 0) {
            let (va, vb) = (values[index(corner(a))], values[index(corner(a | bit))]);
            if (va < 0.0) != (vb < 0.0) {
                sum += point(corner(a)).lerp(point(corner(a | bit)), va / (va - vb));
                count += 1.0;
            }
        }
        vertex.insert(p, shape.corners.len() as u32);
        let position = sum / count;
        let slope = |axis: Vec3| field(position + axis * cell * 0.5) - field(position - axis * cell * 0.5);
        let normal = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(Vec3::Y);
        shape.corners.push(Corner { position, normal, uv: Vec2::ZERO, tint: Vec3::ONE });
    }
    for p in grid(size - 1).filter(|p| p.min_element() > 0) {
        for axis in 0..3 {
            let mut step = [IVec3::X, IVec3::Y, IVec3::Z];
            step.rotate_left(axis);
            let (from, to) = (values[index(p)] < 0.0, values[index(p + step[0])] < 0.0);
            if from == to {
                continue;
            }
            let around = [p, p - step[1], p - step[1] - step[2], p - step[2]].map(|q| vertex[&q]);
            let [a, b, c, d] = if from { around } else { [around[3], around[2], around[1], around[0]] };
            shape.indices.extend([a, b, c, a, c, d]);
        }
    }
    shape
}

/// Distance of a capsule with different radii at its ends, approximate.
pub fn cone(p: Vec3, a: Vec3, b: Vec3, ra: f32, rb: f32) -> f32 {
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
    (p - a - ab * t).length() - mix(ra, rb, t)
}

/// Distance of an ellipsoid, approximate.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = (p - centre) / radii;
    (q.length() - 1.0) * radii.min_element()
}

/// The smaller of two distances, blended where they differ by less than `k`.
pub fn blend(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}
