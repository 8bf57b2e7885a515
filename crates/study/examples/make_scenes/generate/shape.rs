//! Geometry: parametric surfaces, lathed profiles, tubes and boxes.

use glam::{Mat4, Quat, Vec2, Vec3, vec2, vec3};
use std::f32::consts::TAU;

/// A corner of a shape; `tint` is a linear colour factor.
#[derive(Clone, Copy)]
pub struct Corner {
    pub position: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
    pub tint: Vec3,
}

/// An indexed triangle mesh, counter-clockwise seen from the front.
#[derive(Clone, Default)]
pub struct Shape {
    pub corners: Vec<Corner>,
    pub indices: Vec<u32>,
}

impl Shape {
    /// The surface `f(u, v)` over the unit square with `nu` by `nv` cells; its front is
    /// where df/du x df/dv points. Texture coordinates are (u, v) until changed.
    pub fn surface(nu: usize, nv: usize, f: impl Fn(f32, f32) -> Vec3) -> Self {
        // Wide enough for f32 positions of a few metres, narrow against any detail here.
        const STEP: f32 = 1.0 / 2048.0;
        let mut shape = Self::default();
        for j in 0..=nv {
            for i in 0..=nu {
                let (u, v) = (i as f32 / nu as f32, j as f32 / nv as f32);
                let along = |du: f32, dv: f32| {
                    let lo = f((u - du).max(0.0), (v - dv).max(0.0));
                    f((u + du).min(1.0), (v + dv).min(1.0)) - lo
                };
                // At a pole one derivative vanishes: take it a little off the pole.
                let (mut a, b) = (along(STEP, 0.0), along(0.0, STEP));
                if a.length_squared() < 1e-10 * b.length_squared() {
                    let inner = if v < 0.5 { v + STEP } else { v - STEP };
                    a = f((u + STEP).min(1.0), inner) - f((u - STEP).max(0.0), inner);
                }
                let normal = a.normalize_or_zero().cross(b.normalize_or_zero()).normalize_or(Vec3::Y);
                shape.corners.push(Corner { position: f(u, v), normal, uv: vec2(u, v), tint: Vec3::ONE });
            }
        }
        for j in 0..nv as u32 {
            for i in 0..nu as u32 {
                let row = nu as u32 + 1;
                let k = j * row + i;
                shape.quad([k, k + 1, k + row + 1, k + row]);
            }
        }
        shape
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        let p = |i: u32| self.corners[i as usize].position;
        let area = |a: u32, b: u32, c: u32| (p(b) - p(a)).cross(p(c) - p(a)).length_squared();
        let (first, second) = (area(a, b, c) > 1e-18, area(a, c, d) > 1e-18);
        if first {
            self.indices.extend([a, b, c]);
        }
        if second {
            self.indices.extend([a, c, d]);
        }
    }

    /// A profile of (radius, height) turned around +y, from bottom to top for an outside.
    /// Creases sharper than about 30 degrees stay sharp. u runs around (1 turn), v along
    /// the profile by length.
    pub fn lathe(profile: &[Vec2], turns: usize) -> Self {
        let segment_normal = |k: usize| {
            let d = profile[k + 1] - profile[k];
            vec2(d.y, -d.x).normalize_or_zero()
        };
        let length: f32 = profile.windows(2).map(|w| (w[1] - w[0]).length()).sum();
        let (mut shape, mut run) = (Self::default(), 0.0);
        let row = turns as u32 + 1;
        for k in 0..profile.len() - 1 {
            let n = segment_normal(k);
            let soft = |other: Option<Vec2>| match other {
                Some(m) if m.dot(n) > 0.86 => (true, (m + n).normalize()),
                _ => (false, n),
            };
            let (joined, before) = soft(k.checked_sub(1).map(segment_normal));
            let (_, after) = soft((k + 2 < profile.len()).then(|| segment_normal(k + 1)));
            let step = (profile[k + 1] - profile[k]).length();
            let mut ring = |point: Vec2, normal: Vec2, along: f32| {
                for i in 0..=turns {
                    let turn = i as f32 / turns as f32;
                    let (sin, cos) = (turn * TAU).sin_cos();
                    let around = vec3(sin, 0.0, cos);
                    shape.corners.push(Corner {
                        position: around * point.x + Vec3::Y * point.y,
                        normal: around * normal.x + Vec3::Y * normal.y,
                        uv: vec2(turn, 1.0 - along / length),
                        tint: Vec3::ONE,
                    });
                }
            };
            if !joined {
                ring(profile[k], before, run);
            }
            run += step;
            ring(profile[k + 1], after, run);
            let base = shape.corners.len() as u32 - 2 * row;
            for i in 0..turns as u32 {
                shape.quad([base + i, base + i + 1, base + row + i + 1, base + row + i]);
            }
        }
        shape
    }

    /// A tube along `path` with the radius at each point, `sides` around, its ends closed.
    /// u runs around, v along by length in metres.
    pub fn tube(path: &[(Vec3, f32)], sides: usize) -> Self {
        let mut shape = Self::default();
        let ends = [path[0].0, path[path.len() - 1].0].map(|end| (end, 0.0));
        let path: Vec<(Vec3, f32)> = [&ends[..1], path, &ends[1..]].concat();
        let tangent = |k: usize| {
            let k = k.clamp(1, path.len() - 2);
            (path[k + 1].0 - path[k - 1].0).normalize_or(Vec3::Y)
        };
        let mut side = tangent(0).any_orthonormal_vector();
        let mut run = 0.0;
        for (k, &(centre, radius)) in path.iter().enumerate() {
            let t = tangent(k);
            side = (side - t * side.dot(t)).normalize_or(t.any_orthonormal_vector());
            run += if k > 0 { (centre - path[k - 1].0).length() } else { 0.0 };
            for i in 0..=sides {
                let (sin, cos) = (i as f32 / sides as f32 * TAU).sin_cos();
                let normal = side * cos + t.cross(side) * sin;
                let uv = vec2(i as f32 / sides as f32, run);
                shape.corners.push(Corner { position: centre + normal * radius, normal, uv, tint: Vec3::ONE });
            }
        }
        let row = sides as u32 + 1;
        for k in 0..path.len() as u32 - 1 {
            for i in 0..sides as u32 {
                let a = k * row + i;
                shape.quad([a, a + 1, a + row + 1, a + row]);
            }
        }
        shape
    }

    /// A sphere with `n` cells from pole to pole and twice as many around.
    pub fn sphere(radius: f32, n: usize) -> Self {
        Self::surface(2 * n, n, |u, v| {
            let ((st, ct), (sp, cp)) = ((-v * 0.5 * TAU).sin_cos(), (u * TAU).sin_cos());
            vec3(-st * sp, ct, -st * cp) * radius
        })
        .flipped_if(|c| c.position.dot(c.normal) < 0.0)
    }

    /// A torus around +y.
    pub fn torus(major: f32, minor: f32, around: usize, across: usize) -> Self {
        Self::surface(around, across, |u, v| {
            let ((su, cu), (sv, cv)) = ((u * TAU).sin_cos(), (v * TAU).sin_cos());
            vec3(su * (major + minor * cv), minor * sv, cu * (major + minor * cv))
        })
    }

    /// A box with texture coordinates in metres and cells of at most `cell` metres.
    pub fn cuboid(centre: Vec3, size: Vec3, cell: f32) -> Self {
        let mut shape = Self::default();
        for axis in 0..3 {
            for sign in [-1.0f32, 1.0] {
                let mut n = Vec3::ZERO;
                n[axis] = sign;
                // u runs right and v down as seen from outside, texture upright on walls.
                let right = if axis == 1 { Vec3::X } else { Vec3::Y.cross(n) };
                let up = n.cross(right);
                let (w, h) = (right.abs().dot(size), up.abs().dot(size));
                let cells = |l: f32| ((l / cell).ceil() as usize).clamp(1, 400);
                let middle = centre + n * (n.abs().dot(size) * 0.5);
                let mut face =
                    Self::surface(cells(w), cells(h), |u, v| middle + right * (u - 0.5) * w + up * (v - 0.5) * h);
                for c in &mut face.corners {
                    (c.normal, c.uv) = (n, vec2(c.uv.x * w, -c.uv.y * h));
                }
                shape.append(&face);
            }
        }
        shape
    }

    /// Turns the surface inside out where `test` holds for a corner in the middle.
    pub fn flipped_if(mut self, test: impl Fn(&Corner) -> bool) -> Self {
        if test(&self.corners[self.corners.len() / 2]) {
            self.corners.iter_mut().for_each(|c| c.normal = -c.normal);
            self.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Adds another shape.
    pub fn append(&mut self, other: &Self) {
        let base = self.corners.len() as u32;
        self.corners.extend_from_slice(&other.corners);
        self.indices.extend(other.indices.iter().map(|i| i + base));
    }

    /// The shape placed by `m` (no mirroring).
    pub fn moved(mut self, m: Mat4) -> Self {
        let normals = m.inverse().transpose();
        for c in &mut self.corners {
            c.position = m.transform_point3(c.position);
            c.normal = normals.transform_vector3(c.normal).normalize_or(Vec3::Y);
        }
        self
    }

    /// With texture coordinates replaced.
    pub fn mapped(mut self, uv: impl Fn(&Corner) -> Vec2) -> Self {
        for c in &mut self.corners {
            c.uv = uv(c);
        }
        self
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }
}

/// Shorthand: a translation.
pub fn at(x: f32, y: f32, z: f32) -> Mat4 {
    Mat4::from_translation(vec3(x, y, z))
}

/// Shorthand: a rotation about +y, radians.
pub fn turn(angle: f32) -> Mat4 {
    Mat4::from_rotation_y(angle)
}

/// The rotation that takes +y to `direction`.
pub fn upright_to(direction: Vec3) -> Mat4 {
    Mat4::from_quat(Quat::from_rotation_arc(Vec3::Y, direction.normalize_or(Vec3::Y)))
}
