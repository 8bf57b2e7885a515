//! What a surface point sends towards the viewer: glTF 2.0, appendix B, under punctual
//! lights without shadows and an analytic environment.
//!
//! Everything is in world orientation with the origin at the lens centre, so that a camera
//! far from the world's origin costs no precision.

use super::environment;
use crate::scene::{Environment, Light, LightKind};
use glam::{DVec3, Vec3, Vec4, vec2, vec4};
use std::f32::consts::{FRAC_1_PI, PI};

/// Greatest radiance handed on: the greatest f16, which is what methods read.
const MAX_RADIANCE: f32 = 65504.0;

/// Least perceptual roughness: below it a highlight is narrower than any sampling finds.
const MIN_ROUGHNESS: f32 = 0.045;

/// Least difference of a spot's cosines, as in the reference code of KHR_lights_punctual.
const MIN_SPOT_FALLOFF: f32 = 1e-3;

/// A lit surface point.
pub(super) struct Surface {
    /// Position, metres.
    pub position: Vec3,
    /// Unit shading normal, on the side that is seen.
    pub normal: Vec3,
    /// Linear base colour.
    pub albedo: Vec3,
    /// In [0, 1].
    pub metallic: f32,
    /// Perceptual, in [0, 1].
    pub roughness: f32,
    /// Linear emitted radiance.
    pub emissive: Vec3,
}

/// A punctual light as seen from the lens centre.
#[derive(Clone, Copy)]
pub(super) struct RelativeLight {
    intensity: Vec3,
    kind: RelativeKind,
}

#[derive(Clone, Copy)]
enum RelativeKind {
    Directional { towards: Vec3 },
    Point { position: Vec3, range_m: f32 },
    Spot { position: Vec3, range_m: f32, axis: Vec3, cos_inner: f32, cos_outer: f32 },
}

impl RelativeLight {
    /// The light with positions relative to `lens_centre` (world space, metres).
    pub fn new(light: &Light, lens_centre: DVec3) -> Self {
        let kind = match light.kind {
            LightKind::Directional { direction } => RelativeKind::Directional { towards: (-direction).as_vec3() },
            LightKind::Point { position, range_m } => {
                RelativeKind::Point { position: (position - lens_centre).as_vec3(), range_m: range_m as f32 }
            }
            LightKind::Spot { position, range_m, direction, cos_inner, cos_outer } => RelativeKind::Spot {
                position: (position - lens_centre).as_vec3(),
                range_m: range_m as f32,
                axis: direction.as_vec3(),
                cos_inner: cos_inner as f32,
                cos_outer: cos_outer as f32,
            },
        };
        Self { intensity: light.intensity, kind }
    }

    /// Unit vector towards the light and the irradiance of a surface facing it.
    fn at(&self, position: Vec3) -> (Vec3, Vec3) {
        match self.kind {
            RelativeKind::Directional { towards } => (towards, self.intensity),
            RelativeKind::Point { position: light, range_m } => {
                let (towards, attenuation) = from_point(light - position, range_m);
                (towards, self.intensity * attenuation)
            }
            RelativeKind::Spot { position: light, range_m, axis, cos_inner, cos_outer } => {
                let (towards, attenuation) = from_point(light - position, range_m);
                let cosine = axis.dot(-towards);
                let cone = ((cosine - cos_outer) / (cos_inner - cos_outer).max(MIN_SPOT_FALLOFF)).clamp(0.0, 1.0);
                (towards, self.intensity * (attenuation * cone * cone))
            }
        }
    }
}

/// Direction and attenuation from a point light at the offset `to_light`, metres:
/// `1/d^2` windowed to the range (KHR_lights_punctual).
fn from_point(to_light: Vec3, range_m: f32) -> (Vec3, f32) {
    let distance = to_light.length();
    if distance == 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    let window = (1.0 - (distance / range_m).powi(4)).clamp(0.0, 1.0);
    (to_light / distance, window / (distance * distance))
}

impl Surface {
    /// Lets the share `passing` of light through, what it does not reflect at the angle of
    /// `viewer`, and returns how much of what lies behind it covers: `Material::is_sheet`.
    pub fn let_pass(&mut self, passing: f32, viewer: Vec3) -> f32 {
        if passing <= 0.0 {
            return 1.0;
        }
        let passes = passing * (1.0 - self.metallic);
        let grazing = 1.0 - self.n_dot_v((viewer - self.position).normalize_or_zero());
        let mirrors = passes * (0.04 + 0.96 * grazing.powi(5));
        let covers = 1.0 - passes + mirrors;
        let share = mirrors / covers.max(1e-6);
        self.albedo = self.albedo.lerp(Vec3::ONE, share);
        self.metallic += (1.0 - self.metallic) * share;
        covers
    }

    /// Radiance towards a viewer at `viewer` (relative to the lens centre, metres).
    pub fn radiance(&self, viewer: Vec3, lights: &[RelativeLight], environment: &Environment) -> Vec3 {
        let view = (viewer - self.position).normalize_or_zero();
        let f0 = Vec3::splat(0.04).lerp(self.albedo, self.metallic);
        let diffuse = self.albedo * (1.0 - self.metallic);
        let lit: Vec3 = lights
            .iter()
            .map(|light| {
                let (towards, irradiance) = light.at(self.position);
                self.brdf(view, towards, diffuse, f0) * self.normal.dot(towards).max(0.0) * irradiance
            })
            .sum();
        bounded(lit + self.environment_light(view, diffuse, f0, environment) + self.emissive)
    }

    /// Reflected radiance per irradiance, between the unit vectors `view` and `towards` the light.
    fn brdf(&self, view: Vec3, towards: Vec3, diffuse: Vec3, f0: Vec3) -> Vec3 {
        let n_l = self.normal.dot(towards);
        if n_l <= 0.0 {
            return Vec3::ZERO;
        }
        let n_v = self.n_dot_v(view);
        let half = (view + towards).normalize_or_zero();
        let n_h = self.normal.dot(half).clamp(0.0, 1.0);
        let v_h = view.dot(half).clamp(0.0, 1.0);
        let alpha = self.roughness.max(MIN_ROUGHNESS).powi(2);
        let alpha2 = alpha * alpha;
        // GGX: D = a^2 / (pi ((n.h)^2 (a^2 - 1) + 1)^2).
        let spread = n_h * n_h * (alpha2 - 1.0) + 1.0;
        let distribution = alpha2 / (PI * spread * spread);
        // Height-correlated Smith, with the 1 / (4 n.l n.v) of the BRDF within.
        let visibility = 0.5
            / (n_l * (n_v * n_v * (1.0 - alpha2) + alpha2).sqrt() + n_v * (n_l * n_l * (1.0 - alpha2) + alpha2).sqrt());
        let fresnel = f0 + (Vec3::ONE - f0) * (1.0 - v_h).powi(5);
        diffuse * FRAC_1_PI * (Vec3::ONE - fresnel) + fresnel * (distribution * visibility)
    }

    /// Ambient and mirrored light. The weights of the latter are the split-sum fit of Karis,
    /// "Physically Based Shading on Mobile" (2014).
    fn environment_light(&self, view: Vec3, diffuse: Vec3, f0: Vec3, environment: &Environment) -> Vec3 {
        let n_v = self.n_dot_v(view);
        let r = vec4(-1.0, -0.0275, -0.572, 0.022) * self.roughness + vec4(1.0, 0.0425, 1.04, -0.04);
        let a004 = (r.x * r.x).min((-9.28 * n_v).exp2()) * r.x + r.y;
        let ab = vec2(-1.04, 1.04) * a004 + vec2(r.z, r.w);
        let mirrored = (-view).reflect(self.normal);
        diffuse * environment::ambient(environment, self.normal)
            + (f0 * ab.x + Vec3::splat(ab.y)) * environment::reflected(environment, mirrored, self.roughness)
    }

    fn n_dot_v(&self, view: Vec3) -> f32 {
        self.normal.dot(view).clamp(1e-4, 1.0)
    }
}

/// The radiance of an unlit surface: its base colour.
pub(super) fn unlit(base_color: Vec4) -> Vec3 {
    bounded(base_color.truncate())
}

/// In [0, 65504], NaN as 0.
fn bounded(radiance: Vec3) -> Vec3 {
    let channel = |c: f32| if c > 0.0 { c.min(MAX_RADIANCE) } else { 0.0 };
    Vec3::new(channel(radiance.x), channel(radiance.y), channel(radiance.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{dvec3, vec3};

    const LENS_CENTRE: DVec3 = DVec3::new(1.0e6, 5.0, -3.0);

    fn irradiance(kind: LightKind, position: Vec3) -> f32 {
        let light = RelativeLight::new(&Light { intensity: Vec3::splat(8.0), kind }, LENS_CENTRE);
        light.at(position).1.x
    }

    #[test]
    fn point_lights_fall_off_by_the_square_and_end_at_their_range() {
        let at = |range_m| {
            let kind = LightKind::Point { position: LENS_CENTRE + dvec3(0.0, 2.0, 0.0), range_m };
            irradiance(kind, Vec3::ZERO)
        };
        assert_eq!(at(f64::INFINITY), 2.0);
        // (d / range)^4 = 1/16.
        assert_eq!(at(4.0), 2.0 * 15.0 / 16.0);
        assert_eq!(at(2.0), 0.0);
        assert_eq!(at(1.0), 0.0);
    }

    #[test]
    fn spots_fade_between_their_cosines() {
        let at = |x: f32| {
            let (cos_inner, cos_outer) = (0.9, 0.5);
            let position = LENS_CENTRE;
            let kind =
                LightKind::Spot { position, range_m: f64::INFINITY, direction: DVec3::NEG_Y, cos_inner, cos_outer };
            // At the distance 1 and the cosine x from the axis.
            irradiance(kind, vec3((1.0 - x * x).sqrt(), -x, 0.0))
        };
        assert!((at(0.95) - 8.0).abs() < 1e-5);
        assert!((at(0.7) - 2.0).abs() < 1e-5, "half way, squared: {}", at(0.7));
        assert_eq!(at(0.45), 0.0);
    }

    #[test]
    fn highlights_peak_where_the_half_vector_is_the_normal() {
        let surface = Surface {
            position: Vec3::ZERO,
            normal: Vec3::Y,
            albedo: Vec3::ONE,
            metallic: 1.0,
            roughness: 0.5,
            emissive: Vec3::ZERO,
        };
        let view = vec3(0.6, 0.8, 0.0);
        let towards = vec3(-0.6, 0.8, 0.0);
        // F = 1 for a white metal; D = 1 / (pi a^2), a = 1/4; V with n.l = n.v = 0.8 is
        // 1 / (4 * 0.8 * sqrt(0.64 (1 - a^2) + a^2)).
        let expected = 16.0 / PI / (3.2 * (0.64f32 * (15.0 / 16.0) + 1.0 / 16.0).sqrt());
        let peak = surface.brdf(view, towards, Vec3::ZERO, Vec3::ONE).x;
        assert!((peak / expected - 1.0).abs() < 1e-5, "{peak}, not {expected}");
        assert!(surface.brdf(view, vec3(-0.5, 0.75f32.sqrt(), 0.0), Vec3::ZERO, Vec3::ONE).x < peak);
        assert_eq!(surface.brdf(view, Vec3::NEG_Y, Vec3::ZERO, Vec3::ONE), Vec3::ZERO);
    }

    #[test]
    fn radiance_is_bounded_and_a_number() {
        assert_eq!(bounded(vec3(f32::NAN, -1.0, f32::INFINITY)), vec3(0.0, 0.0, MAX_RADIANCE));
    }
}
