//! One module a scene.

pub mod atrium;
pub mod cans;
mod column;
mod fresco;
mod labels;

/// What every scene is made with.
mod prelude {
    pub use super::super::canvas::{Canvas, lines, rgb};
    pub use super::super::noise::{Rng, cells, fbm, hash, mix, smoothstep};
    pub use super::super::patterns;
    pub use super::super::shape::{Shape, at, turn};
    pub use super::super::stage::{Material, Sky, Stage};
    pub use glam::{Mat4, Vec2, Vec3, ivec2, vec2, vec3};
}
