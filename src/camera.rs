//! Where the eye is and what it sees: pose and pinhole projection.
//!
//! Poses are f64, so that a camera a thousand kilometres from the origin is as steady as
//! one at it: everything that reaches the GPU is first brought into view space.

use crate::lens::Lens;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, Mat4, UVec2, dvec2};

/// A pose, a field of view and a near plane.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Camera {
    /// Position of the lens centre in world space, metres.
    pub position: DVec3,
    /// Rotation from view space (looking along -z, y up) to world space.
    pub orientation: DQuat,
    /// Full vertical field of view, radians, in (0, pi).
    pub fov_y: f64,
    /// Width over height of the frame this camera was made for, if its source says so.
    pub aspect: Option<f64>,
    /// Distance of the near plane, metres. Nothing nearer is drawn.
    pub near_m: f64,
    /// Where the centre of the frame lies off the optical axis: the slopes (x right, y up)
    /// of its direction in view space. 0 for a symmetric view; an eye beside the middle of
    /// a screen has an asymmetric one ([`Camera::beside`]).
    #[serde(default)]
    pub frame_centre_slope: DVec2,
}

impl Camera {
    /// A camera at `eye` looking at `target` with +y up.
    pub fn look_at(eye: DVec3, target: DVec3, fov_y: f64, near_m: f64) -> Self {
        let back = (eye - target).normalize_or(DVec3::Z);
        let up = if back.cross(DVec3::Y).length_squared() < 1e-12 { DVec3::Z } else { DVec3::Y };
        let right = up.cross(back).normalize();
        let orientation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        Self { position: eye, orientation, fov_y, aspect: None, near_m, frame_centre_slope: DVec2::ZERO }
    }

    /// Takes world space to view space.
    pub fn view_from_world(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.orientation, self.position).inverse()
    }

    /// Unit vector along which the camera looks, world space.
    pub fn forward(&self) -> DVec3 {
        self.orientation * DVec3::NEG_Z
    }

    /// The projection onto a frame of `size` pixels with `overscan_px` more on every side.
    ///
    /// A frame wider than [`Camera::aspect`] keeps the vertical field of view and a
    /// narrower one the horizontal: the whole of the camera's own frame stays in view.
    pub fn projection(&self, size: UVec2, overscan_px: u32) -> Projection {
        let size_px = size.as_dvec2();
        let aspect = size_px.x / size_px.y;
        let tan_half_y = (self.fov_y * 0.5).tan() * (self.aspect.unwrap_or(aspect) / aspect).max(1.0);
        let focal_px = size_px.y * 0.5 / tan_half_y;
        let slope = self.frame_centre_slope;
        let axis_px = dvec2(-slope.x, slope.y) * focal_px;
        Projection { size, overscan_px, focal_px, axis_px, near_m: self.near_m }
    }

    /// The same camera with the vertical field of view that gives a frame of `size` the
    /// horizontal one `fov_x` (radians, in (0, pi)), whatever its own aspect ratio was.
    pub fn with_fov_x(&self, size: UVec2, fov_x: f64) -> Self {
        let height_per_width = f64::from(size.y) / f64::from(size.x.max(1));
        let fov_y = 2.0 * ((0.5 * fov_x).tan() * height_per_width).atan();
        Self { fov_y, aspect: None, ..*self }
    }

    /// The same view from `offset_m` metres to the right, through the same window: what lies
    /// at the depth `screen_m` keeps its place in the frame. The optical axes stay parallel,
    /// so that depths and thus the CoC of what lies across them stay the same too; with an
    /// infinite `screen_m` the frustum stays symmetric.
    pub fn beside(&self, offset_m: f64, screen_m: f64) -> Self {
        let position = self.position + self.orientation * (DVec3::X * offset_m);
        let frame_centre_slope = self.frame_centre_slope - dvec2(offset_m / screen_m, 0.0);
        Self { position, frame_centre_slope, ..*self }
    }
}

/// A pinhole projection onto pixels, square by construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The inner frame, px: what a method's output shows.
    pub size: UVec2,
    /// Margin on every side of the inner frame, px.
    pub overscan_px: u32,
    /// Distance of the image plane from the pinhole in pixels: a point at view (x, y, -d)
    /// lies `axis_px + focal_px * (x, -y) / d` from the centre of the frame.
    pub focal_px: f64,
    /// Where the optical axis meets the image plane, px from the centre of the inner frame
    /// (x right, y down); 0 for a symmetric frustum.
    pub axis_px: DVec2,
    /// Distance of the near plane, metres.
    pub near_m: f64,
}

impl Projection {
    /// The drawn frame: the inner one with the overscan around it, px.
    pub fn outer_size(&self) -> UVec2 {
        self.size + UVec2::splat(2 * self.overscan_px)
    }

    /// The same projection with `fineness` pixels for each one on both axes.
    pub fn refined(&self, fineness: u32) -> Self {
        Self {
            size: self.size * fineness,
            overscan_px: self.overscan_px * fineness,
            focal_px: self.focal_px * f64::from(fineness),
            axis_px: self.axis_px * f64::from(fineness),
            near_m: self.near_m,
        }
    }

    /// Full horizontal field of view of the inner frame, radians.
    pub fn fov_x(&self) -> f64 {
        let half_px = f64::from(self.size.x) * 0.5;
        let angle = |side_px: f64| (side_px / self.focal_px).atan();
        angle(half_px + self.axis_px.x) + angle(half_px - self.axis_px.x)
    }

    /// Clip space (reversed, infinite depth; z/w = near/d) from view space for the eye
    /// moved to the lens point `v` (unit disc, image orientation), with the plane at the
    /// focus distance held fixed on the image. `v = 0` is the pinhole.
    ///
    /// A point at depth d moves by `v * c(d) / 2` pixels against the pinhole image: the
    /// shear of Haeberli and Akeley 1990 with the aperture of [`Lens::aperture_diameter_m`].
    /// An astigmatic eye adds [`Lens::astigmatism_px`].
    pub fn clip_from_view(&self, lens: &Lens, v: DVec2) -> Mat4 {
        let eye_m = self.eye_on_lens_m(lens, v);
        let outer = self.outer_size().as_dvec2();
        let (sx, sy) = (2.0 * self.focal_px / outer.x, 2.0 * self.focal_px / outer.y);
        // x_clip = sx * (x - eye) + d * (sx * eye / df + axis), with d = -z. The far limit
        // df -> inf, vergence 0, has no shear, and v = 0 has none either.
        // Astigmatism moves the whole image, at all depths alike.
        let astigmatism_px = 0.5 * (lens.astigmatism_px() * v);
        let axis = (self.axis_px + astigmatism_px) * dvec2(2.0, -2.0) / outer;
        let shear = if eye_m == DVec2::ZERO { DVec2::ZERO } else { eye_m * lens.focus_d() };
        Mat4::from_cols_array(&[
            sx as f32,
            0.0,
            0.0,
            0.0,
            0.0,
            sy as f32,
            0.0,
            0.0,
            (-sx * shear.x - axis.x) as f32,
            (-sy * shear.y - axis.y) as f32,
            0.0,
            -1.0,
            (-sx * eye_m.x) as f32,
            (-sy * eye_m.y) as f32,
            self.near_m as f32,
            0.0,
        ])
    }

    /// Position on the lens, metres in view space (x right, y up), of the lens point `v`.
    pub fn eye_on_lens_m(&self, lens: &Lens, v: DVec2) -> DVec2 {
        let radius_m = 0.5 * lens.aperture_diameter_m(self.focal_px);
        dvec2(v.x, -v.y) * radius_m
    }

    /// View-space direction (not normalised, z = -1) through the point `p` of the inner
    /// frame, px from its top left corner.
    pub fn view_direction(&self, p: DVec2) -> DVec3 {
        let slope = (p - self.size.as_dvec2() * 0.5 - self.axis_px) / self.focal_px;
        DVec3::new(slope.x, -slope.y, -1.0)
    }
}
