//! One module a scene.

pub mod atrium;
pub mod branches;
pub mod cans;
mod column;
pub mod fence;
pub mod forest;
mod fresco;
pub mod glasshouse;
pub mod handrail;
pub mod herd;
pub mod highlights;
mod labels;
pub mod mirrors;

/// What every scene is made with.
mod prelude {
    pub use super::super::canvas::{Canvas, lines, rgb};
    pub use super::super::noise::{Rng, cells, fbm, hash, smoothstep};
    pub use super::super::shape::{Shape, at, turn, upright_to};
    pub use super::super::stage::{Material, Sky, Stage};
    pub use super::super::{nature, patterns};
    pub use glam::{Mat4, Vec2, Vec3, ivec2, vec2, vec3};
}
