//! The environment's light, from the formulas in the documentation of
//! [`Environment`](crate::scene::Environment).

use crate::scene::Environment;
use glam::{Vec3, vec3};

/// Radiance that arrives from the unit direction `r` (world space).
pub(super) fn radiance(environment: &Environment, r: Vec3) -> Vec3 {
    match *environment {
        Environment::Black => Vec3::ZERO,
        Environment::Studio { zenith, horizon, .. } if r.y >= 0.0 => horizon.lerp(zenith, r.y),
        Environment::Studio { ground, horizon, .. } => horizon.lerp(ground, (-3.0 * r.y).min(1.0)),
    }
}

/// What a white diffuse surface with the unit normal `n` shows.
pub(super) fn ambient(environment: &Environment, n: Vec3) -> Vec3 {
    match *environment {
        Environment::Black => Vec3::ZERO,
        Environment::Studio { zenith, horizon, ground, .. } => {
            let (below, above) = ((ground + horizon) * 0.5, (zenith + horizon) * 0.5);
            below.lerp(above, (n.y + 1.0) * 0.5)
        }
    }
}

/// What a perfect reflector of the given perceptual roughness shows in the unit direction `r`.
pub(super) fn reflected(environment: &Environment, r: Vec3, roughness: f32) -> Vec3 {
    let Environment::Studio { softbox, .. } = *environment else { return Vec3::ZERO };
    let smooth = radiance(environment, r).lerp(ambient(environment, r), roughness);
    let half_width = 0.02 + 0.3 * roughness;
    let seen: f32 = [(1.0, 0.6), (1.0, -0.6), (-1.0, 0.6), (-1.0, -0.6)]
        .into_iter()
        .map(|(x, z)| r.dot(vec3(x, 1.2, z).normalize()))
        .map(|cosine| smoothstep(0.9 - half_width, 0.9 + half_width, cosine))
        .sum();
    smooth + Vec3::splat(softbox * seen)
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
