//! The lens points of a pixel's rays.

use crate::gpu::{Buffer, Gpu};
use crate::lens::Lens;
use glam::{DVec2, Vec2};

/// Which lens points there are to be.
pub(super) struct PointSets {
    /// Points of a pixel.
    pub samples: u32,
    /// Sets that neighbouring pixels take in turn.
    pub sets: u32,
    /// Whether each point is moved from pixel to pixel, by up to half the distance of points.
    pub moved: bool,
    /// How wide a ray's cone is, over the distance of points; 0 without cones.
    pub cone: f64,
}

/// Lens points of all sets, and how far apart they lie.
pub(super) struct LensPoints {
    /// By cell and set: point k of every set lies in cell k of the lens. Then for each cell the least and
    /// the greatest x, y of its points, with the jitter.
    pub v: Buffer,
    /// Greatest |x| or |y| of any, with the jitter.
    pub greatest: f32,
    pub sets: u32,
    /// Greatest offset per axis that is added to each, in v.
    pub jitter: f64,
    /// Lambda: diameter of a ray's cone over C, 0 without cones.
    pub cone_per_coc: f64,
}

impl LensPoints {
    pub fn of(order: &PointSets, gpu: &Gpu, lens: &Lens) -> Self {
        let PointSets { samples, sets, moved, cone } = *order;
        let points = lens.aperture.lens_point_sets(samples, sets);
        let spacing = mean_spacing(&points[..samples as usize]);
        let jitter = if moved && samples > 1 { 0.5 * spacing } else { 0.0 };
        // One set is the same for all pixels already, and its order says which offset each point has.
        let by_cell = if sets == 1 { points } else { lens.aperture.lens_point_sets_by_cell(samples, sets) };
        let cells: Vec<[Vec2; 2]> = by_cell
            .chunks(sets as usize)
            .map(|cell| bounds(cell).map(DVec2::as_vec2))
            .map(|b| widened(b, jitter))
            .collect();
        let greatest = cells.iter().flatten().map(|v| v.abs().max_element()).fold(0.0, f32::max);
        let points = by_cell.into_iter().map(DVec2::as_vec2);
        let table: Vec<Vec2> = points.chain(cells.into_iter().flatten()).collect();
        Self {
            v: gpu.buffer_of("lens points", &table),
            greatest,
            sets,
            jitter,
            // Points a distance s apart in v are s * C / 2 apart on the image.
            cone_per_coc: 0.5 * spacing * cone,
        }
    }
}

fn bounds(points: &[DVec2]) -> [DVec2; 2] {
    let low = points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    [low, high]
}

/// By more than what jittered points are rounded by.
fn widened([low, high]: [Vec2; 2], jitter: f64) -> [Vec2; 2] {
    let more = (1.001 * jitter) as f32;
    [low - more, high + more]
}

/// Mean distance from a point to its nearest neighbour: the paper's lambda, in v. One point stands
/// for the whole lens.
fn mean_spacing(points: &[DVec2]) -> f64 {
    if points.len() == 1 {
        return 2.0;
    }
    let nearest = |(i, p): (usize, &DVec2)| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, q)| p.distance_squared(*q)).fold(f64::INFINITY, f64::min).sqrt()
    };
    points.iter().enumerate().map(nearest).sum::<f64>() / points.len() as f64
}
