//! The kernel itself: each method's point spread function beside the lens's own.
//!
//! A quad that covers one pixel, 64 times as bright as white, stands before a black wall at
//! one depth; what a method makes of it is its point spread function at that CoC. The quad is
//! also moved by parts of a pixel, and what is measured is the mean over those, about where
//! the point really is.

mod lens;
pub mod report;

pub use lens::{bessel_j1, lens_kernel, lens_mtf};

use crate::compare::params_json;
use crate::{Progress, StudyError, render, step};
use defocus::camera::Camera;
use defocus::gpu::Gpu;
use defocus::image::ColorImage;
use defocus::lens::Lens;
use defocus::methods::Method;
use defocus::scene::{Instance, Material, Mesh, Scene, Vertex};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{DAffine3, DVec2, DVec3, UVec2, Vec3, Vec4, dvec2};
use serde::Serialize;
use serde_json::{Map, Value};

/// Brightness of the point, linear: enough for what is spread over a thousand pixels to stay
/// well above the least numbers of f16.
const POINT: f32 = 64.0;

/// Positions of the point in its pixel, each coordinate once in eighths: means over them are
/// means over the pixel along either axis.
const SHIFTS: u32 = 8;

/// Depth of the point, metres.
const DEPTH_M: f64 = 2.0;

/// Share of the depth by which the wall lies behind the point.
const BEHIND: f64 = 1e-4;

/// Frequencies at which the MTF is told of.
const FREQUENCIES: u32 = 48;

/// Greatest frequency, in reciprocal diameters of the disc: past its second zero, 2.23.
const MOST_CYCLES_PER_DISC: f64 = 3.0;

/// Room around the lens's own spread, px.
const MARGIN_PX: u32 = 12;

/// Which side of the focus the point is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// In front of it.
    Front,
    /// Behind it.
    Behind,
}

/// A method's point spread function at one CoC.
#[derive(Clone, Debug, Serialize)]
pub struct Psf {
    /// The method's id.
    pub method: &'static str,
    /// Its parameters.
    pub params: Map<String, Value>,
    /// CoC diameter, px.
    pub coc_px: f64,
    /// The side of the focus.
    pub side: Side,
    /// Light in it over that of the point: 1 where light is kept.
    pub energy: f64,
    /// Standard deviation on an axis, px, without that of the pixel itself.
    pub sigma_px: f64,
    /// That of the lens.
    pub lens_sigma_px: f64,
    /// Where its centroid lies from the point, px (x right, y down).
    pub centroid_px: [f64; 2],
    /// How equal it is to its mirror images about the point: 1 for equal, 0 where nothing
    /// overlaps; the lesser of both axes.
    pub symmetry: f64,
    /// Greatest difference of its MTF from the lens's, up to three cycles in a disc or half a
    /// cycle in a pixel.
    pub mtf_error: f64,
    /// Frequencies, cycles per px.
    pub frequencies: Vec<f64>,
    /// Its MTF along x without that of the pixel.
    pub mtf: Vec<f64>,
    /// The lens's in closed form.
    pub lens_mtf: Vec<f64>,
    /// The image of the point at the centre of a pixel, its light 1 in all.
    #[serde(skip)]
    pub image: ColorImage,
}

/// The point before its wall, seen by a camera.
struct Stage {
    size: UVec2,
    camera: Camera,
}

impl Stage {
    fn new(lens: &Lens, coc_px: f64) -> Self {
        let spread_px = (coc_px * lens.aperture.radius()).max(6.0 * lens.aperture.sigma_per_coc() * coc_px);
        // Even, so that pyramids are centred.
        let side = 2 * (spread_px.ceil() as u32 + MARGIN_PX);
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, 0.6, 0.1);
        Self { size: UVec2::splat(side), camera }
    }

    /// Where the point is in the picture, px, moved from the centre of its pixel.
    fn point_px(&self, shift_px: DVec2) -> DVec2 {
        0.5 * self.size.as_dvec2() + 0.5 + shift_px
    }

    fn view(&self, gpu: &Gpu, shift_px: DVec2) -> Result<View, StudyError> {
        let focal_px = self.camera.projection(self.size, 0).focal_px;
        let on_wall = |p: DVec2, depth_m: f64| {
            let slope = (p - 0.5 * self.size.as_dvec2()) / focal_px;
            DVec3::new(slope.x, -slope.y, -1.0) * depth_m
        };
        let quad = |from: DVec2, to: DVec2, depth_m: f64, material| {
            let corners = [dvec2(from.x, to.y), to, dvec2(to.x, from.y), from];
            let vertex = |p: DVec2| Vertex {
                position: on_wall(p, depth_m).as_vec3(),
                normal: Vec3::Z,
                color: Vec4::ONE,
                ..Vertex::default()
            };
            Mesh {
                name: "quad".into(),
                vertices: corners.map(vertex).into(),
                indices: vec![0, 1, 2, 0, 2, 3],
                material,
            }
        };
        let point = self.point_px(shift_px);
        let far = self.size.as_dvec2() * 4.0;
        let unlit = |color: Vec3| Material { unlit: true, base_color: color.extend(1.0), ..Material::default() };
        let scene = Scene {
            name: "point".into(),
            meshes: vec![quad(point - 0.5, point + 0.5, DEPTH_M, 0), quad(-far, far, DEPTH_M * (1.0 + BEHIND), 1)],
            materials: vec![unlit(Vec3::splat(POINT)), unlit(Vec3::ZERO)],
            instances: (0..2).map(|mesh| Instance { mesh, world_from_object: DAffine3::IDENTITY }).collect(),
            ..Scene::default()
        };
        let uploaded = GpuScene::new(gpu, &scene, SurfaceOptions::default());
        Ok(View::of_scene(uploaded, self.camera, self.size, 0)?)
    }
}

/// `lens` with focus and aperture such that the point has that CoC.
fn lens_at(lens: &Lens, coc_px: f64, side: Side) -> Lens {
    let focus_distance_m = if side == Side::Behind { 0.5 * DEPTH_M } else { 2.0 * DEPTH_M };
    let unit = Lens { aperture_diameter_mm: 1.0, focus_distance_m, ..lens.clone() };
    Lens { aperture_diameter_mm: coc_px / unit.coc_diameter_px(DEPTH_M).abs(), ..unit }
}

/// Measures `methods` at each CoC diameter, px, with the aperture of `lens`.
///
/// # Errors
///
/// What a method says, [`StudyError::Stopped`].
pub fn measure(
    gpu: &Gpu,
    lens: &Lens,
    methods: &[Box<dyn Method>],
    (cocs_px, side): (&[f64], Side),
    progress: &mut Progress<'_>,
) -> Result<Vec<Psf>, StudyError> {
    let mut found: Vec<Psf> = Vec::new();
    let of = (cocs_px.len() * methods.len()) as u32 * (1 + SHIFTS);
    for &coc_px in cocs_px {
        let lens = lens_at(lens, coc_px, side);
        let stage = Stage::new(&lens, coc_px);
        let shifts: Vec<DVec2> = (0..SHIFTS).map(shift_px).collect();
        let mut views = shifts.iter().map(|shift| stage.view(gpu, *shift)).collect::<Result<Vec<_>, _>>()?;
        let mut centred = stage.view(gpu, DVec2::ZERO)?;
        for method in methods {
            let id = method.about().id;
            let before = found.len() as u32 * (1 + SHIFTS);
            step(progress, id, before, of)?;
            let image = render(gpu, &mut centred, &lens, method.as_ref())?.color;
            let mut sums = Sums::new(coc_px);
            for (i, (view, shift)) in (1..).zip(views.iter_mut().zip(&shifts)) {
                step(progress, id, before + i, of)?;
                let image = render(gpu, view, &lens, method.as_ref())?.color;
                sums.add(&image, stage.point_px(*shift));
            }
            found.push(sums.psf(method.as_ref(), &lens, (coc_px, side), image));
        }
    }
    Ok(found)
}

/// The i-th position of the point in its pixel, px from the centre, in (-1/2, 1/2).
fn shift_px(i: u32) -> DVec2 {
    let eighth = |i: u32| (f64::from(i % SHIFTS) + 0.5) / f64::from(SHIFTS) - 0.5;
    dvec2(eighth(i), eighth(3 * i))
}

/// What is added up over the positions of the point.
struct Sums {
    frequencies: Vec<f64>,
    light: f64,
    first: DVec2,
    second: f64,
    /// By frequency, cosine and sine.
    waves: Vec<DVec2>,
}

impl Sums {
    fn new(coc_px: f64) -> Self {
        let most = (MOST_CYCLES_PER_DISC / coc_px).min(0.5);
        let frequencies: Vec<f64> = (0..=FREQUENCIES).map(|i| most * f64::from(i) / f64::from(FREQUENCIES)).collect();
        let waves = vec![DVec2::ZERO; frequencies.len()];
        Self { frequencies, light: 0.0, first: DVec2::ZERO, second: 0.0, waves }
    }

    fn add(&mut self, image: &ColorImage, point_px: DVec2) {
        let width = image.size.x;
        for (i, pixel) in (0_u32..).zip(&image.pixels) {
            let light = f64::from(pixel.y);
            if light == 0.0 {
                continue;
            }
            let from_point = dvec2(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5) - point_px;
            self.light += light;
            self.first += light * from_point;
            self.second += light * from_point.length_squared();
            for (wave, frequency) in self.waves.iter_mut().zip(&self.frequencies) {
                let (sin, cos) = (std::f64::consts::TAU * frequency * from_point.x).sin_cos();
                *wave += light * dvec2(cos, sin);
            }
        }
    }

    fn psf(self, method: &dyn Method, lens: &Lens, (coc_px, side): (f64, Side), image: ColorImage) -> Psf {
        let centroid = self.first / self.light;
        // A pixel that is lit wherever in it the point is has a variance of 1/12 on each axis.
        let variance = 0.5 * (self.second / self.light - centroid.length_squared()) - 1.0 / 12.0;
        let pixel = |f: f64| if f == 0.0 { 1.0 } else { (std::f64::consts::PI * f).sin() / (std::f64::consts::PI * f) };
        let mtf = |(wave, f): (&DVec2, &f64)| wave.length() / self.light / pixel(*f);
        let mtf: Vec<f64> = self.waves.iter().zip(&self.frequencies).map(mtf).collect();
        let lens_mtf: Vec<f64> = self.frequencies.iter().map(|f| lens_mtf(&lens.aperture, coc_px, *f)).collect();
        let errors = mtf.iter().zip(&lens_mtf).map(|(a, b)| (a - b).abs());
        let sum: f32 = image.pixels.iter().map(|p| p.y).sum();
        Psf {
            method: method.about().id,
            params: params_json(method),
            coc_px,
            side,
            energy: self.light / f64::from(SHIFTS) / f64::from(POINT),
            sigma_px: variance.max(0.0).sqrt(),
            lens_sigma_px: lens.aperture.sigma_per_coc() * coc_px,
            centroid_px: centroid.to_array(),
            symmetry: symmetry(&image),
            mtf_error: errors.fold(0.0, f64::max),
            mtf,
            lens_mtf,
            frequencies: self.frequencies,
            image: image.map(|p| if sum > 0.0 { p / sum } else { p }),
        }
    }
}

/// How equal an image is to its mirror images about the pixel right below and right of its
/// centre.
fn symmetry(image: &ColorImage) -> f64 {
    let [width, height] = image.size.to_array();
    let at = |x: u32, y: u32| f64::from(image.at(x, y).y);
    let pixels = || (1..height).flat_map(move |y| (1..width).map(move |x| (x, y)));
    let sum: f64 = pixels().map(|(x, y)| at(x, y)).sum();
    let unlike =
        |mirrored: &dyn Fn(u32, u32) -> f64| -> f64 { pixels().map(|(x, y)| (at(x, y) - mirrored(x, y)).abs()).sum() };
    let worst = unlike(&|x, y| at(width - x, y)).max(unlike(&|x, y| at(x, height - y)));
    if sum > 0.0 { 1.0 - 0.5 * worst / sum } else { 0.0 }
}
