//! What a file may ask for. Accessors may be shared or stand for zeros, and images may be
//! one colour: without a limit, a small file could ask for any amount of memory.

use super::super::error::SceneProblem;

/// Vertices that any file may have: 4 million, a third of a gigabyte.
const FREE_VERTICES: u64 = 1 << 22;

/// Instances that any file may have: 1 million, about a hundred megabytes.
const FREE_INSTANCES: u64 = 1 << 20;

/// Pixels of images that any file may have: 67 million, a quarter of a gigabyte.
const FREE_PIXELS: u64 = 1 << 26;

/// Pixels a byte of the file, beyond that: large flat images compress a hundredfold.
const PIXELS_PER_BYTE: u64 = 128;

/// What is left of each.
pub(super) struct Budget {
    vertices: u64,
    instances: u64,
    pixels: u64,
}

impl Budget {
    /// That of a file whose buffers have so many bytes: one vertex and one instance a byte,
    /// as no file that means them stores either in less.
    pub(super) fn of(bytes: usize) -> Self {
        let bytes = bytes as u64;
        Self {
            vertices: bytes.max(FREE_VERTICES),
            instances: bytes.max(FREE_INSTANCES),
            pixels: bytes.saturating_mul(PIXELS_PER_BYTE).max(FREE_PIXELS),
        }
    }

    /// Takes vertices for a mesh called `item`.
    pub(super) fn vertices(&mut self, count: usize, item: &str) -> Result<(), SceneProblem> {
        take(&mut self.vertices, count as u64, item, "vertices")
    }

    /// Takes instances for a node called `item`.
    pub(super) fn instances(&mut self, count: usize, item: &str) -> Result<(), SceneProblem> {
        take(&mut self.instances, count as u64, item, "instances")
    }

    /// Takes pixels for an image called `item`.
    pub(super) fn pixels(&mut self, count: u64, item: &str) -> Result<(), SceneProblem> {
        take(&mut self.pixels, count, item, "pixels")
    }
}

fn take(left: &mut u64, count: u64, item: &str, things: &str) -> Result<(), SceneProblem> {
    *left = left.checked_sub(count).ok_or_else(|| SceneProblem::Oversize {
        item: item.to_owned(),
        detail: format!("{count} {things}, more than the file's bytes can stand for"),
    })?;
    Ok(())
}
