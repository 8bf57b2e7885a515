//! A picture that is worth measuring.

use super::identity::Identity;
use defocus::gpu::Texture;
use defocus::image::ColorImage;
use std::sync::Arc;

/// A finished picture, or a stage of one that converges.
#[derive(Clone)]
pub(super) struct Milestone {
    /// The picture, linear.
    pub texture: Texture,
    /// The same on the CPU, where it is known there.
    pub color: Option<Arc<ColorImage>>,
    /// What it is.
    pub identity: Identity,
    /// Changes with every new picture and is never the same for two.
    pub revision: u64,
}
