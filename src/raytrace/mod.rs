//! The reference on the CPU: a thin lens, traced ray by ray.
//!
//! Cook, Porter and Carpenter, "Distributed Ray Tracing" (SIGGRAPH 1984): each pixel is the
//! mean over points of the lens of what a ray from there through the pixel's point on the
//! focus plane sees. It shares with the rasteriser only the scene, the camera and the lens;
//! visibility, texturing and shading are computed anew, so that the two references check
//! each other.
//!
//! ```text
//!   pixel p        lens           focus plane        hit
//!              eye *.
//!                    ` .  slope - eye/df
//!   -----------+-------- ` * -------------- axis, d ->
//!              |         df  ` .
//!                                ` X  depth d: what the pinhole sees at p - v c(d)/2
//! ```
//!
//! Rays pass pixel *centres*, without jitter within the pixel: where everything is in focus
//! the image is the pinhole image. Background is seen along the ray's own direction, which
//! blurs it by c(infinity) = K.
//!
//! ```no_run
//! # fn f(scene: std::sync::Arc<defocus::scene::Scene>, lens: defocus::lens::Lens) -> Result<(), defocus::raytrace::RayError> {
//! use defocus::raytrace::{RayOptions, RayRender, RayScene};
//! let camera = scene.cameras[0].camera;
//! let rays = std::sync::Arc::new(RayScene::new(scene, &camera)?);
//! let projection = camera.projection(glam::uvec2(256, 192), 0);
//! let render = RayRender::new(rays, &projection, &lens, &RayOptions::default())?;
//! let image = render.run(|_done, _wanted| std::ops::ControlFlow::Continue(()));
//! # Ok(()) }
//! ```

mod bvh;
mod environment;
mod render;
mod scene;
mod shading;
mod texture;

pub use render::RayRender;
pub use scene::RayScene;

use crate::image::{ColorImage, DepthImage};
use crate::lens::LensError;
use std::ops::Range;

/// What a surface shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shading {
    /// Lights, environment and materials of the scene.
    #[default]
    Scene,
    /// The base colour of every material, and nothing else.
    Unlit,
}

/// How to trace.
#[derive(Clone, Debug, PartialEq)]
pub struct RayOptions {
    /// Indices of the lens points ([`Aperture::lens_point`](crate::aperture::Aperture)). Two
    /// disjoint ranges give two independent estimates; any start of a range is a fair set.
    pub lens_points: Range<u32>,
    /// What surfaces show.
    pub shading: Shading,
    /// Whether highlights and reflections are those seen from the lens point. Otherwise
    /// they are those seen from the lens centre, as in every single-view method's input.
    pub view_dependent: bool,
}

impl Default for RayOptions {
    fn default() -> Self {
        Self { lens_points: 0..256, shading: Shading::Scene, view_dependent: false }
    }
}

/// A traced image.
#[derive(Clone, Debug, PartialEq)]
pub struct RayImage {
    /// Mean over the lens points.
    pub color: ColorImage,
    /// Through the lens centre alone.
    pub pinhole: ColorImage,
    /// Depth through the lens centre, metres, of the nearest surface that covers half or more;
    /// infinity where none does.
    pub depth: DepthImage,
    /// Lens points that every pixel of `color` has at least; 0 where cancelled before.
    pub lens_points: u32,
}

/// Why nothing can be traced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RayError {
    /// The lens forms no image.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// A near distance that is not a positive number.
    #[error("the near distance is {near_m} m: it must be a finite number above 0")]
    Near {
        /// The value given, metres.
        near_m: f64,
    },
    /// More triangles than indices reach.
    #[error(
        "the scene has {triangle_count} triangles over its instances, more than the 4294967295 that can be traced: use fewer instances"
    )]
    TooManyTriangles {
        /// Triangles over all instances.
        triangle_count: u64,
    },
}
