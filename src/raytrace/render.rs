//! A rendering in progress: sums over lens points that may be stopped, looked at and
//! continued at any time.

use super::bvh::LensRay;
use super::scene::Sample;
use super::{RayError, RayImage, RayOptions, RayScene};
use crate::camera::Projection;
use crate::image::{ColorImage, DepthImage};
use crate::lens::Lens;
use glam::{DVec2, DVec3, Vec3, dvec2};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rays between two calls of a progress callback, about: half a second's work on two cores.
const RAYS_PER_BATCH: u32 = 1 << 19;

/// A rendering in progress.
///
/// Every row counts its own lens points and is averaged over those, so whatever was traced
/// before a cancellation stays valid.
pub struct RayRender {
    scene: Arc<RayScene>,
    projection: Projection,
    lens: Lens,
    options: RayOptions,
    rows: Vec<Row>,
    pinhole: ColorImage,
    depth: DepthImage,
}

/// A row of pixels: sums of radiance over its lens points.
struct Row {
    sums: Vec<DVec3>,
    points: u32,
}

/// A point of the lens.
#[derive(Clone, Copy)]
struct LensPoint {
    /// Where it is, metres in view space.
    eye_m: DVec2,
    /// How far an astigmatic eye moves the image that is seen from it, px.
    moved_px: DVec2,
}

impl LensPoint {
    const CENTRE: Self = Self { eye_m: DVec2::ZERO, moved_px: DVec2::ZERO };

    fn of(projection: &Projection, lens: &Lens, v: DVec2) -> Self {
        Self { eye_m: projection.eye_on_lens_m(lens, v), moved_px: 0.5 * (lens.astigmatism_px() * v) }
    }
}

impl RayRender {
    /// Starts a rendering: traces the pinhole rays, one a pixel, and no lens point yet.
    ///
    /// Errors if the lens forms no image or the projection's near distance is not a
    /// positive number.
    pub fn new(
        scene: Arc<RayScene>,
        projection: &Projection,
        lens: &Lens,
        options: &RayOptions,
    ) -> Result<Self, RayError> {
        lens.check()?;
        if !(projection.near_m > 0.0 && projection.near_m.is_finite()) {
            return Err(RayError::Near { near_m: projection.near_m });
        }
        let size = projection.size;
        let row = |_| Row { sums: vec![DVec3::ZERO; size.x as usize], points: 0 };
        let mut render = Self {
            scene,
            projection: *projection,
            lens: lens.clone(),
            options: options.clone(),
            rows: (0..size.y).map(row).collect(),
            pinhole: ColorImage::filled(size, Vec3::ZERO),
            depth: DepthImage::filled(size, f32::INFINITY),
        };
        let pixels = render.pinhole_pixels();
        render.pinhole.pixels = pixels.iter().map(|&(color, _)| color).collect();
        render.depth.pixels = pixels.iter().map(|&(_, depth_m)| depth_m).collect();
        Ok(render)
    }

    /// Lens points that every pixel has by now.
    pub fn points_done(&self) -> u32 {
        self.rows.iter().map(|row| row.points).min().unwrap_or_else(|| self.points_wanted())
    }

    /// Lens points asked for.
    pub fn points_wanted(&self) -> u32 {
        self.options.lens_points.len() as u32
    }

    /// Whether every pixel has all its lens points.
    pub fn is_complete(&self) -> bool {
        self.points_done() >= self.points_wanted()
    }

    /// Traces `points` lens points more, or as many as are left, over the whole frame on all
    /// of rayon's threads. Once `cancel` is set it returns after the rows' current points.
    pub fn advance(&mut self, points: u32, cancel: &AtomicBool) {
        let target = self.points_done().saturating_add(points).min(self.points_wanted());
        let first = self.options.lens_points.start;
        let eyes: Vec<LensPoint> = (first..first + target)
            .map(|i| LensPoint::of(&self.projection, &self.lens, self.lens.aperture.lens_point(i)))
            .collect();
        // Taken out for the time being, so that the rest can be read from every thread.
        let mut rows = std::mem::take(&mut self.rows);
        rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            while row.points < target && !cancel.load(Ordering::Relaxed) {
                self.add_point(row, y as u32, eyes[row.points as usize]);
            }
        });
        self.rows = rows;
    }

    /// Traces what is left. `progress` is told the lens points done and wanted about twice a
    /// second; answering `Break` stops there, with an image of the points so far.
    pub fn run(mut self, mut progress: impl FnMut(u32, u32) -> ControlFlow<()>) -> RayImage {
        let pixels = self.projection.size.x.saturating_mul(self.projection.size.y).max(1);
        let batch = (RAYS_PER_BATCH / pixels).max(1);
        let never = AtomicBool::new(false);
        while !self.is_complete() {
            self.advance(batch, &never);
            if progress(self.points_done(), self.points_wanted()).is_break() {
                break;
            }
        }
        self.image()
    }

    /// The image by now: means over each row's lens points, or the pinhole image in rows
    /// that have none yet.
    pub fn image(&self) -> RayImage {
        let mut color = self.pinhole.clone();
        let width = self.projection.size.x as usize;
        for (pixels, row) in color.pixels.chunks_mut(width.max(1)).zip(&self.rows).filter(|(_, row)| row.points > 0) {
            for (pixel, sum) in pixels.iter_mut().zip(&row.sums) {
                *pixel = (*sum / f64::from(row.points)).as_vec3();
            }
        }
        RayImage { color, pinhole: self.pinhole.clone(), depth: self.depth.clone(), lens_points: self.points_done() }
    }

    fn add_point(&self, row: &mut Row, y: u32, eye: LensPoint) {
        for (x, sum) in (0..).zip(&mut row.sums) {
            let sample = self.sample(x, y, eye);
            *sum += self.scene.seen(&sample, self.options.shading).0.as_dvec3();
        }
        row.points += 1;
    }

    /// Colour and depth (metres) along every pixel's pinhole ray.
    fn pinhole_pixels(&self) -> Vec<(Vec3, f32)> {
        let size = self.projection.size;
        let pixel = |y| move |x| self.scene.seen(&self.sample(x, y, LensPoint::CENTRE), self.options.shading);
        (0..size.y).into_par_iter().flat_map_iter(|y| (0..size.x).map(pixel(y))).collect()
    }

    /// The ray through the centre of a pixel from a point of the lens.
    ///
    /// It passes the focus plane where the pixel's pinhole ray does, `slope * df`; seen from
    /// the eye that is `slope - eye / df` a unit of depth, which also holds where df is
    /// infinite: the rays of a pixel are then parallel.
    fn sample(&self, x: u32, y: u32, LensPoint { eye_m, moved_px }: LensPoint) -> Sample {
        let centre = dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let pinhole = self.projection.view_direction(centre - moved_px);
        let ray = LensRay {
            origin: eye_m / self.scene.unit_m(),
            slope: dvec2(pinhole.x, pinhole.y) - eye_m * self.lens.focus_d(),
            min_depth: self.projection.near_m / self.scene.unit_m(),
        };
        Sample { ray, viewer_m: if self.options.view_dependent { eye_m } else { DVec2::ZERO } }
    }
}
