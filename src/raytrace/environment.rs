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

#[cfg(test)]
mod tests {
    use super::*;

    fn studio(softbox: f32) -> Environment {
        Environment::Studio { zenith: Vec3::X, horizon: Vec3::Y, ground: Vec3::Z, softbox }
    }

    #[test]
    fn the_gradient_runs_from_ground_over_horizon_to_zenith() {
        let at = |y: f32| radiance(&studio(9.0), vec3((1.0 - y * y).sqrt(), y, 0.0));
        assert_eq!((at(1.0), at(0.0), at(-1.0)), (Vec3::X, Vec3::Y, Vec3::Z));
        assert_eq!(at(0.25), vec3(0.25, 0.75, 0.0));
        assert_eq!(at(-0.5), Vec3::Z, "ground from a third below the horizon");
        assert_eq!(ambient(&studio(9.0), Vec3::X), vec3(0.25, 0.5, 0.25));
    }

    #[test]
    fn softboxes_are_reflected_where_they_are() {
        let towards = vec3(1.0, 1.2, -0.6).normalize();
        let seen = |r, roughness| reflected(&studio(9.0), r, roughness) - reflected(&studio(0.0), r, roughness);
        assert!((seen(towards, 0.0).x - 9.0).abs() < 1e-5);
        assert_eq!(seen(Vec3::NEG_Y, 0.0), Vec3::ZERO);
        assert_eq!(reflected(&studio(0.0), Vec3::NEG_Y, 1.0), ambient(&studio(0.0), Vec3::NEG_Y));
    }
}
