//! Repeatable randomness: integer hashes and noise that tiles.

use glam::{IVec2, Vec2, Vec3, ivec2};

/// A number in [0, 1) for a lattice point (Wellons' `lowbias32` over mixed coordinates).
pub fn hash(x: i32, y: i32, seed: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77).rotate_left(15);
    h ^= seed.wrapping_mul(0xC2B2_AE3D).rotate_left(7);
    h = (h ^ (h >> 16)).wrapping_mul(0x21F0_AAAD);
    h = (h ^ (h >> 15)).wrapping_mul(0x735A_2D97);
    ((h ^ (h >> 15)) >> 8) as f32 / 16_777_216.0
}

/// Three independent numbers in [0, 1) for a lattice point.
pub fn hash3(x: i32, y: i32, seed: u32) -> Vec3 {
    Vec3::new(hash(x, y, seed), hash(x, y, seed ^ 0x5bd1), hash(x, y, seed ^ 0x1b56_c4e9))
}

/// A stream of numbers in [0, 1).
pub struct Rng {
    seed: u32,
    drawn: i32,
}

impl Rng {
    /// A stream of its own for every seed.
    pub fn new(seed: u32) -> Self {
        Self { seed, drawn: 0 }
    }

    /// The next number in [0, 1).
    pub fn unit(&mut self) -> f32 {
        self.drawn += 1;
        hash(self.drawn, 77, self.seed)
    }

    /// The next number in [lo, hi).
    pub fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }

    /// The next index below `n`.
    pub fn index(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }
}

/// Value noise in [0, 1] that repeats every `period` lattice cells.
pub fn noise(p: Vec2, period: IVec2, seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let c = cell.as_ivec2();
    let at = |dx, dy| {
        let q = (c + ivec2(dx, dy)).rem_euclid(period);
        hash(q.x, q.y, seed)
    };
    let (top, bottom) = (mix(at(0, 0), at(1, 0), w.x), mix(at(0, 1), at(1, 1), w.x));
    mix(top, bottom, w.y)
}

/// Octaves of [`noise`] over the unit square, `cells` of the coarsest across it: in [0, 1],
/// tiling.
pub fn fbm(uv: Vec2, cells: IVec2, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let period = cells << octave as i32;
        sum += weight * noise(uv * period.as_vec2(), period, seed + octave);
        total += weight;
        weight *= 0.5;
    }
    sum / total
}

/// `a` at 0, `b` at 1.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 below `a`, 1 above `b`, smooth between. Falls where `a > b`.
pub fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Distance of the nearest and second nearest of jittered points, one a cell, tiling.
pub fn cells(uv: Vec2, count: IVec2, seed: u32) -> (f32, f32, IVec2) {
    let p = uv * count.as_vec2();
    let home = p.floor().as_ivec2();
    let (mut first, mut second, mut id) = (9.0f32, 9.0f32, home);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let c = home + ivec2(dx, dy);
            let q = c.rem_euclid(count);
            let site = c.as_vec2() + Vec2::new(hash(q.x, q.y, seed), hash(q.x, q.y, seed + 1));
            let d = (site - p).length();
            if d < first {
                (second, first, id) = (first, d, q);
            } else {
                second = second.min(d);
            }
        }
    }
    (first, second, id)
}
