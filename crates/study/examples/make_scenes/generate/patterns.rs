//! Textures of walls, floors, wood, cloth and ground. All tile.

use super::canvas::{Canvas, lines, rgb};
use super::noise::{fbm, hash, hash3, mix, smoothstep};
use glam::{IVec2, Vec2, Vec3, ivec2, vec2};
use std::f32::consts::TAU;

/// Planks along u, `planks` of them, with grain, knots and dark gaps.
pub fn wood(size: usize, planks: i32, light: Vec3, dark: Vec3, seed: u32) -> Canvas {
    let plank_of = move |uv: Vec2| (uv.y * planks as f32).floor() as i32 % planks;
    let grain = move |uv: Vec2| {
        let k = plank_of(uv);
        let shift = vec2(hash(k, 0, seed), 0.0);
        let q = vec2((uv.x + shift.x).fract(), uv.y);
        let warp = fbm(q, ivec2(3, 4 * planks), 3, seed + k as u32 * 13);
        let rings = (uv.y * planks as f32 * 5.0 + warp * 6.0 + hash(k, 1, seed) * 9.0) * TAU * 0.5;
        let fibre = fbm(q, ivec2(6, 60 * planks), 3, seed + 5);
        let pore = smoothstep(0.62, 0.7, fbm(q, ivec2(20, 90 * planks), 2, seed + 9));
        let ring = (0.5 + 0.5 * rings.sin()).powf(1.6);
        (0.55 * ring + 0.45 * fibre, pore)
    };
    let gap = move |uv: Vec2| {
        let along = ((uv.x + hash(plank_of(uv), 2, seed)).fract() - 0.5).abs();
        lines(uv.y * planks as f32, 0.028, 0.008).max(smoothstep(0.0022, 0.0012, along))
    };
    Canvas::paint(size, size, move |uv| {
        let (ring, pore) = grain(uv);
        let hue = 0.8 + 0.4 * hash(plank_of(uv), 3, seed);
        let base = light.lerp(dark, smoothstep(0.1, 0.9, ring)) * hue;
        base * (1.0 - 0.45 * pore) * (1.0 - 0.85 * gap(uv))
    })
    .emboss(0.5, move |uv| grain(uv).0 * 0.6 - 1.5 * gap(uv))
}

/// Running bond: `count.x` bricks by `count.y` courses (even).
pub fn brick(size: usize, count: IVec2, base: Vec3, mortar: Vec3, seed: u32) -> Canvas {
    let place = move |uv: Vec2| {
        let row = (uv.y * count.y as f32).floor() as i32;
        let x = uv.x * count.x as f32 + if row % 2 == 0 { 0.0 } else { 0.5 };
        let id = ivec2(x.floor() as i32 % count.x, row % count.y);
        (vec2(x.fract(), (uv.y * count.y as f32).fract()), id)
    };
    let inside = move |uv: Vec2| {
        let (p, id) = place(uv);
        let ragged = 0.035 * (fbm(uv, count * 3, 3, seed + 7) - 0.5);
        let edge = vec2((0.5 - (p.x - 0.5).abs()) * 2.4, 0.5 - (p.y - 0.5).abs());
        let chip = 0.05 * hash(id.x, id.y, seed + 3);
        smoothstep(0.055, 0.105 + chip, edge.min_element() + ragged)
    };
    let rough = move |uv: Vec2| fbm(uv, count * 5, 4, seed + 1);
    Canvas::paint(size, size, move |uv| {
        let (_, id) = place(uv);
        let tone = hash3(id.x, id.y, seed);
        let burnt = if tone.z > 0.85 { 0.5 } else { 1.0 };
        let speck = smoothstep(0.66, 0.74, fbm(uv, count * 9, 2, seed + 2));
        let face = base * (0.65 + 0.6 * tone.x) * burnt + Vec3::new(0.06, 0.02, 0.0) * (tone.y - 0.5);
        let face = face * (0.65 + 0.7 * rough(uv)) * (1.0 - 0.5 * speck);
        (mortar * (0.7 + 0.6 * rough(uv))).lerp(face, inside(uv))
    })
    .emboss(1.1, move |uv| inside(uv) + 0.8 * rough(uv))
}

/// Ashlar: large blocks with chiselled margins.
pub fn ashlar(size: usize, count: IVec2, base: Vec3, seed: u32) -> Canvas {
    let place = move |uv: Vec2| {
        let row = (uv.y * count.y as f32).floor() as i32;
        let x = uv.x * count.x as f32 + 0.5 * (row % 2) as f32;
        (vec2(x.fract(), (uv.y * count.y as f32).fract()), ivec2(x.floor() as i32 % count.x, row))
    };
    let height = move |uv: Vec2| {
        let (p, _) = place(uv);
        let edge = vec2((0.5 - (p.x - 0.5).abs()) * 2.0, 0.5 - (p.y - 0.5).abs()).min_element();
        let joint = smoothstep(0.012, 0.03, edge);
        let boss = smoothstep(0.08, 0.11, edge);
        let pits = fbm(uv, count * 8, 4, seed);
        joint * 1.2 + boss * (0.4 + 1.2 * pits) + 0.3 * pits
    };
    Canvas::paint(size, size, move |uv| {
        let (p, id) = place(uv);
        let edge = vec2((0.5 - (p.x - 0.5).abs()) * 2.0, 0.5 - (p.y - 0.5).abs()).min_element();
        let stain = fbm(uv, ivec2(4, 3), 4, seed + 5);
        let tone = 0.75 + 0.35 * hash(id.x, id.y, seed + 1);
        let vein = smoothstep(0.04, 0.0, (fbm(uv, count * 2, 4, seed + 8) - 0.5).abs()) * 0.18;
        base * tone * mix(0.7, 1.1, stain) * (1.0 - vein) * mix(0.35, 1.0, smoothstep(0.008, 0.02, edge))
    })
    .emboss(0.8, height)
}

/// Roman mosaic: square tesserae of `n` across, arranged as a medallion in a guilloche
/// border, with grout.
pub fn mosaic(size: usize, n: i32, seed: u32) -> Canvas {
    let palette = [0xe9dfc8, 0x2b3a55, 0xa63d2a, 0xd9a441, 0x3f6b57, 0x1d1a18].map(rgb);
    let design = move |c: Vec2| {
        let p = (c - 0.5) * 2.0;
        let (r, angle) = (p.length(), p.y.atan2(p.x));
        let edge = p.abs().max_element();
        if edge > 0.93 {
            return 5;
        }
        if edge > 0.74 {
            // Two strands twisting around each other.
            let along = if p.x.abs() > p.y.abs() { p.y } else { p.x };
            let across = (edge - 0.835) / 0.09;
            let wave = (along * TAU * 4.0).sin() * 0.62;
            return match ((across - wave).abs() < 0.28, (across + wave).abs() < 0.28) {
                (true, _) => 2,
                (_, true) => 3,
                _ => 1,
            };
        }
        if edge > 0.7 {
            return 5;
        }
        if r < 0.66 {
            let petals = 0.36 + 0.2 * (angle * 8.0).cos();
            return match r {
                r if r < 0.09 => 3,
                r if r < 0.14 => 5,
                r if r < petals - 0.06 => 2,
                r if r < petals => 0,
                r if r > 0.6 => 1,
                r if r > 0.55 => 0,
                _ => 4,
            };
        }
        if ((p.x * 9.0).floor() + (p.y * 9.0).floor()) as i32 & 1 == 0 { 0 } else { 3 }
    };
    Canvas::paint(size, size, move |uv| {
        let p = uv * n as f32;
        let id = p.floor().as_ivec2();
        let nudge = hash3(id.x, id.y, seed) - 0.5;
        let d = (p - p.floor() - 0.5 - nudge.truncate() * 0.12).abs().max_element();
        let tile = smoothstep(0.44, 0.37, d);
        let colour = palette[design((id.as_vec2() + 0.5) / n as f32)] * (0.82 + 0.36 * hash(id.x, id.y, seed + 4));
        let dirt = 0.75 + 0.4 * fbm(uv, ivec2(5, 5), 4, seed + 2);
        rgb(0x6b6258).lerp(colour, tile) * dirt
    })
}

/// Woven damask: a mirrored floral ornament in two colours with visible threads.
pub fn damask(size: usize, repeat: i32, ground: Vec3, figure: Vec3, accent: Vec3) -> Canvas {
    Canvas::paint(size, size, move |uv| {
        let p = uv * repeat as f32;
        let row = p.y.floor() as i32;
        let x = (p.x + 0.5 * (row & 1) as f32).fract();
        let q = vec2((x - 0.5).abs() * 2.0, p.y.fract() * 2.0 - 1.0);
        let (r, angle) = (q.length(), q.y.atan2(q.x));
        let leaf = 0.5 + 0.28 * (angle * 5.0).cos() + 0.08 * (angle * 15.0).cos();
        let ogee = (q.x - 0.75 - 0.22 * (q.y * TAU * 0.5).cos()).abs();
        let vein = lines(r * 7.0, 0.35, 0.05);
        let mut colour = ground;
        if r < leaf {
            colour = if vein > 0.5 { ground } else { figure };
        }
        if r < 0.16 || (r > leaf && r < leaf + 0.05) {
            colour = accent;
        }
        if ogee < 0.055 {
            colour = figure;
        } else if ogee < 0.085 {
            colour = accent;
        }
        let thread = 0.86 + 0.14 * (uv.x * 160.0 * TAU).sin() * (uv.y * 160.0 * TAU).sin();
        colour * thread
    })
}

/// Marble: warped veins.
pub fn marble(size: usize, base: Vec3, vein: Vec3, seed: u32) -> Canvas {
    Canvas::paint(size, size, move |uv| {
        let warp = fbm(uv, ivec2(3, 3), 5, seed);
        let fine = fbm(uv, ivec2(7, 7), 5, seed + 9);
        let thread = smoothstep(0.03, 0.0, (warp - 0.5).abs()) + 0.6 * smoothstep(0.02, 0.0, (fine - 0.5).abs());
        let grain = 0.9 + 0.2 * fbm(uv, ivec2(60, 60), 2, seed + 3);
        let pit = smoothstep(0.7, 0.76, fbm(uv, ivec2(40, 40), 2, seed + 4));
        base.lerp(vein, (0.75 * thread + 0.3 * pit).min(1.0)) * grain * mix(0.88, 1.08, fine)
    })
}

/// Eight-pointed stars and crosses in glazed tile, `n` across.
pub fn star_tiles(size: usize, n: i32, seed: u32) -> Canvas {
    let glaze = [0x1f5f8b, 0xe8dcc0, 0xc2572e, 0x2c7a5c].map(rgb);
    Canvas::paint(size, size, move |uv| {
        let p = uv * n as f32;
        let id = (p + 0.5).floor().as_ivec2().rem_euclid(IVec2::splat(n));
        let q = p - (p + 0.5).floor();
        let square = q.abs().max_element();
        let diamond = (q.x.abs() + q.y.abs()) * std::f32::consts::FRAC_1_SQRT_2;
        let star = square.min(diamond);
        let (ring, angle) = (q.length(), q.y.atan2(q.x));
        let spokes = (angle * 8.0).cos() * 0.5 + 0.5;
        let mut colour = if star < 0.335 { glaze[((id.x + id.y) % 2) as usize * 2] } else { glaze[1] };
        if star > 0.27 && star < 0.295 || ring < 0.05 || (ring > 0.1 && ring < 0.22 && spokes > 0.72) {
            colour = glaze[1];
        } else if star > 0.4 {
            colour = glaze[3];
        }
        let grout = smoothstep(0.012, 0.006, (star - 0.335).abs()).max(smoothstep(0.492, 0.497, square));
        let age = 0.8 + 0.3 * fbm(uv, ivec2(6, 6), 5, seed) + 0.1 * (hash(id.x, id.y, seed) - 0.5);
        (colour * age).lerp(rgb(0x4f4a42), grout)
    })
}

/// Parquet of `n` by `n` squares, each of six strips, turned alternately.
pub fn parquet(size: usize, n: i32, seed: u32) -> Canvas {
    Canvas::paint(size, size, move |uv| {
        let p = uv * n as f32;
        let id = p.floor().as_ivec2().rem_euclid(IVec2::splat(n));
        let q = if (id.x + id.y) % 2 == 0 { p.fract() } else { vec2(p.y.fract(), p.x.fract()) };
        let strip = (q.y * 6.0).floor() as i32;
        let tone = hash(id.x * 6 + strip, id.y, seed);
        let fibre =
            if (id.x + id.y) % 2 == 0 { fbm(uv, ivec2(10, 220), 3, seed) } else { fbm(uv, ivec2(220, 10), 3, seed) };
        let seam = lines(q.y * 6.0, 0.07, 0.03).max(smoothstep(0.49, 0.496, (q.x - 0.5).abs()));
        let wood = rgb(0xb9824c).lerp(rgb(0x7a4a26), mix(tone, fibre, 0.45)) * (0.75 + 0.5 * fibre);
        wood * (1.0 - 0.75 * seam)
    })
}

/// A flat-woven runner: stepped diamonds between striped borders, along v.
pub fn kilim(size: usize, steps: i32) -> Canvas {
    let wool = [0x8c1f26, 0x1d2b4a, 0xd9b36a, 0xeadfc4, 0x2f5f4c].map(rgb);
    Canvas::paint(size, size, move |uv| {
        let q = (uv * vec2(steps as f32 * 6.0, steps as f32 * 6.0)).floor();
        let (x, y) = (q.x / (steps as f32 * 6.0), q.y / (steps as f32 * 6.0));
        let side = (x - 0.5).abs() * 2.0;
        let weave = 0.85 + 0.15 * (uv.x * 300.0 * TAU).sin() * (uv.y * 150.0 * TAU).sin();
        let wave = |count: f32| ((y * count).fract() - 0.5).abs() * 2.0;
        let colour = if side > 0.94 {
            wool[1]
        } else if side > 0.78 {
            wool[if ((side - 0.78) * 6.0 + wave(12.0)) % 1.0 > 0.5 { 3 } else { 0 }]
        } else if side > 0.74 {
            wool[2]
        } else {
            let d = side + wave(2.0) * 0.74;
            wool[[0, 2, 1, 3, 4, 2, 0, 1][((d * 9.0) as usize) % 8]]
        };
        colour * weave
    })
}

/// Rounded setts in rows, wet and dark.
pub fn cobbles(size: usize, count: IVec2, seed: u32) -> Canvas {
    let place = move |uv: Vec2| {
        let row = (uv.y * count.y as f32).floor() as i32;
        let x = uv.x * count.x as f32 + 0.5 * (row % 2) as f32;
        (vec2(x.fract(), (uv.y * count.y as f32).fract()) - 0.5, ivec2(x.floor() as i32 % count.x, row))
    };
    let dome = move |uv: Vec2| {
        let (q, _) = place(uv);
        let edge = (q.x.abs().powi(4) + q.y.abs().powi(4)).powf(0.25);
        smoothstep(0.5, 0.3, edge + 0.05 * (fbm(uv, count * 2, 3, seed) - 0.5))
    };
    Canvas::paint(size, size, move |uv| {
        let (_, id) = place(uv);
        let tone = 0.6 + 0.6 * hash(id.x, id.y, seed + 1);
        rgb(0x2a2722).lerp(rgb(0x8a8a90) * tone, dome(uv)) * (0.75 + 0.5 * fbm(uv, count * 4, 3, seed + 2))
    })
    .emboss(1.2, dome)
}
