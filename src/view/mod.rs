//! What a method may ask a scene for.
//!
//! Layers are drawn when a method asks for them, and cached until scene, camera,
//! size or overscan changes. The lens is not among them: a lens slider never redraws the
//! pinhole image. An image with a depth map is a view too: it answers [`View::pinhole`]
//! and says clearly that it cannot answer the rest.

mod eyes;
mod fine;
mod hidden;
mod import;
mod input;
mod layers;
mod lens_views;
mod nearest;
mod peel;
mod pipelines;
mod raster;
mod samples;
mod sheets;
mod slabs;
mod summary;
mod tone;
mod upload;

pub use fine::FineDrawing;
pub use import::{DepthConvention, ExternalFrame};
pub use layers::{Layer, LayerQuery, Shading, SurfaceLayer};
pub use nearest::{NEAREST_REACH_PX, SAMPLE_SLACK_PX};
pub(crate) use peel::copy_to_array_layer;
pub use peel::{DISOCCLUSION_PX, LayerSeparation, PEELED_LEVELS, PeelOrder, Peeled};
pub use pipelines::EnvironmentUniform;
pub use samples::{HIGHLIGHT_LIMIT, LIGHT_BYTES, Lights, MAX_DRAWS};
pub use sheets::{MAX_SHEETS, SHEET_LAYERS, Sheets};
pub use slabs::{MAX_SLABS_AT_ONCE, SlabArrays, SlabShot};
pub use tone::{Input, Tone, UnknownInput};
pub use upload::{GpuScene, SurfaceOptions};

use crate::camera::{Camera, Projection};
use crate::gpu::{Buffer, Frame, Gpu, Texture};
use crate::image::{ColorImage, DepthImage};
use crate::lens::{GREATEST_COC_PX, Lens};
use crate::uniform;
use eyes::Eyes;
use glam::{DVec2, UVec2};
use raster::{LensPoint, SceneSource, Shot};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::Arc;

/// Largest overscan that is chosen by default, px.
pub const MAX_AUTO_OVERSCAN_PX: u32 = 96;

/// Why a view cannot be made or cannot answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A view of an image was asked for what only a scene has.
    #[error("an image with a depth map has no {0}: use a scene, or a method that needs the pinhole image only")]
    ImageHasNo(&'static str),
    /// A size of 0 or beyond what the GPU can draw.
    #[error(
        "a view of {width}x{height} px (with {overscan} px of overscan on every side) cannot be drawn: both sides must lie between 1 and {limit} px on this adapter"
    )]
    Size {
        /// Inner width, px.
        width: u32,
        /// Inner height, px.
        height: u32,
        /// Overscan, px.
        overscan: u32,
        /// Greatest side, px.
        limit: u32,
    },
    /// Textures of another program that do not make a frame.
    #[error("the frame that was handed over cannot be used: {0}")]
    External(&'static str),
    /// A lens that forms no image.
    #[error(transparent)]
    Lens(#[from] crate::lens::LensError),
}

uniform! {
    /// `Lens` in `shaders/lib/lens.wgsl`.
    pub struct LensUniform {
        /// K, px.
        pub k_px: f32,
        /// K * df / near, px.
        pub slope_px: f32,
        /// near / df.
        pub focus_z: f32,
        /// Standard deviation per axis over CoC diameter.
        pub sigma_per_coc: f32,
        /// Direction of the eye's meridian ([`Lens::meridian`]).
        pub meridian: [f32; 2],
        /// What astigmatism adds to the CoC along it, px; 0 for a round blur.
        pub astigmatism_px: f32,
        /// Fills the structure to a multiple of 16 bytes.
        pub _unused: f32,
    }
}

enum Source {
    Scene(Box<SceneSource>),
    Image(Layer),
}

/// A scene or image seen from one place at one size.
pub struct View {
    source: Source,
    projection: Projection,
    pinhole: Option<Layer>,
    peeled: Option<Peeled>,
    summary: summary::Known,
    depth_m: Option<Arc<DepthImage>>,
    repaired: Repaired,
    fine_drawing: Option<FineDrawing>,
    /// Layers have one texel a pixel, and one sample.
    draft: bool,
    /// What becomes of colours before they are blurred.
    tone: Tone,
    /// Of a view of an image, its colours as they came, once others are given.
    linear_image: Option<Texture>,
    /// Sheets are never drawn.
    without_sheets: bool,
    /// This view without sheets.
    solid: Option<Box<View>>,
    peels: Option<sheets::Peels>,
    sheets: Option<Sheets>,
    kept: HashMap<TypeId, Box<dyn Any + Send + Sync>>,
}

/// Where the number of replaced pixels is known.
enum Repaired {
    Counted(usize),
    OnGpu(Buffer),
}

impl View {
    /// A view of a scene. Errors for a size of 0 or beyond the adapter's limit.
    pub fn of_scene(scene: Arc<GpuScene>, camera: Camera, size: UVec2, overscan_px: u32) -> Result<Self, ViewError> {
        check_size(&scene.gpu, size, overscan_px)?;
        let projection = camera.projection(size, overscan_px);
        Ok(Self::new(Source::Scene(Box::new(SceneSource::new(scene, camera))), projection))
    }

    /// A view of an image with a depth map in metres and a vertical field of view in
    /// radians. Colours beyond f16's range are clamped to it. Pixels that are not numbers
    /// do not spread: such a colour becomes black, such a depth (or a negative one) infinite,
    /// and [`View::repaired_pixels`] counts them.
    ///
    /// Panics if the images differ in size: loaders see to that.
    pub fn of_image(gpu: &Gpu, color: &ColorImage, depth: &DepthImage, fov_y: f64) -> Result<Self, ViewError> {
        assert_eq!(color.size, depth.size, "colour and depth have one size");
        check_size(gpu, color.size, 0)?;
        let broken = |(color, depth): (&glam::Vec3, &f32)| !color.is_finite() || depth.is_nan() || *depth <= 0.0;
        let repaired_pixels = color.pixels.iter().zip(&depth.pixels).filter(|p| broken(*p)).count();
        let color = color.map(|c| if c.is_finite() { c } else { glam::Vec3::ZERO });
        let depth = depth.map(|d| if d > 0.0 { d } else { f32::INFINITY });
        let nearest = depth.pixels.iter().copied().filter(|d| d.is_finite()).fold(f32::INFINITY, f32::min);
        let near_m = if nearest.is_finite() { f64::from(nearest) } else { 1.0 };
        let stored = depth.map(|d| (near_m / f64::from(d)) as f32);
        let layer = Layer {
            color: crate::gpu::upload(gpu, "image", &color),
            depth: crate::gpu::upload_scalar(gpu, "stored depth", &stored),
        };
        Ok(Self { repaired: Repaired::Counted(repaired_pixels), ..Self::of_layer(layer, near_m, fov_y) })
    }

    /// The pinhole image of the inner frame with its depth, as a view that knows nothing else. Errors for
    /// a size that the adapter cannot draw.
    pub fn as_image(&mut self, gpu: &Gpu) -> Result<Self, ViewError> {
        let Projection { size, overscan_px, focal_px, near_m, .. } = self.projection;
        check_size(gpu, size, 0)?;
        let mut frame = gpu.frame();
        let outer = self.pinhole(&mut frame);
        let mut inner = |texture: &Texture| {
            let cropped = gpu.texture("inner frame", size, texture.format());
            let mut from = texture.raw().as_image_copy();
            (from.origin.x, from.origin.y) = (overscan_px, overscan_px);
            let copied = wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
            frame.encoder().copy_texture_to_texture(from, cropped.raw().as_image_copy(), copied);
            cropped
        };
        let layer = Layer { color: inner(&outer.color), depth: inner(&outer.depth) };
        frame.finish();
        let fov_y = 2.0 * (0.5 * f64::from(size.y) / focal_px).atan();
        Ok(Self::of_layer(layer, near_m, fov_y))
    }

    /// A view of textures that already hold a pinhole image and stored depth near / d.
    pub fn of_layer(layer: Layer, near_m: f64, fov_y: f64) -> Self {
        let camera = Camera { fov_y, near_m, ..Camera::look_at(glam::DVec3::ZERO, glam::DVec3::NEG_Z, fov_y, near_m) };
        let projection = camera.projection(layer.color.size(), 0);
        Self::new(Source::Image(layer), projection)
    }

    fn new(source: Source, projection: Projection) -> Self {
        Self {
            source,
            projection,
            pinhole: None,
            peeled: None,
            summary: summary::Known::default(),
            depth_m: None,
            repaired: Repaired::Counted(0),
            fine_drawing: None,
            draft: false,
            tone: Tone::Linear,
            linear_image: None,
            without_sheets: false,
            solid: None,
            peels: None,
            sheets: None,
            kept: HashMap::new(),
        }
    }

    /// Pixels of the image whose colour or depth was not a number and was replaced. Waits
    /// for the GPU if it did the counting.
    pub fn repaired_pixels(&self, gpu: &Gpu) -> usize {
        match &self.repaired {
            Repaired::Counted(count) => *count,
            Repaired::OnGpu(buffer) => gpu.frame().read_buffer::<u32>(buffer).first().map_or(0, |n| *n as usize),
        }
    }

    /// Moves the camera, forgetting what was drawn if that changes anything. A view of an
    /// image stays where its image was taken.
    pub fn set_camera(&mut self, camera: Camera) {
        if let Source::Scene(source) = &self.source
            && source.camera != camera
        {
            self.projection = camera.projection(self.projection.size, self.projection.overscan_px);
            let source = SceneSource::new(source.scene.clone(), camera).toned(self.tone);
            self.source = Source::Scene(Box::new(source));
            self.forget();
        }
    }

    /// Changes size and overscan, forgetting what was drawn if that changes anything. A
    /// view of an image keeps the image's size.
    pub fn set_size(&mut self, gpu: &Gpu, size: UVec2, overscan_px: u32) -> Result<(), ViewError> {
        check_size(gpu, size, overscan_px)?;
        if let Source::Scene(source) = &self.source {
            let projection = source.camera.projection(size, overscan_px);
            if projection != self.projection {
                self.projection = projection;
                self.forget();
            }
        }
        Ok(())
    }

    /// Draws everything anew when it is next asked for, as if the camera had moved.
    pub fn redraw(&mut self) {
        // A pinhole image that was handed in, and what follows from it, stays.
        if self.is_scene() {
            self.pinhole = None;
            self.peeled = None;
            self.forget_sheets();
            self.kept.clear();
        }
    }

    fn forget_sheets(&mut self) {
        self.solid = None;
        self.peels = None;
        self.sheets = None;
    }

    /// Draws layers of several texels a pixel in that way, not as the adapter does best.
    pub fn set_fine_drawing(&mut self, drawing: FineDrawing) {
        self.fine_drawing = Some(drawing);
        self.peeled = None;
        self.solid = None;
    }

    /// Draws layers of several texels a pixel with one, as for a picture that is replaced soon: while the
    /// camera moves, drawing them takes most of a frame's time. What was drawn otherwise is drawn anew
    /// when it is next asked for; the pinhole image stays.
    pub fn set_draft(&mut self, draft: bool) {
        self.draft = draft;
        if let Some(solid) = &mut self.solid {
            solid.draft = draft;
        }
    }

    fn forget(&mut self) {
        self.pinhole = None;
        self.peeled = None;
        self.summary.forget();
        self.depth_m = None;
        self.forget_sheets();
        self.kept.clear();
    }

    /// A place, empty at first, for what a method derives from this view and wants back in
    /// its next frame: one for each type, emptied when scene, camera, size or overscan
    /// changes.
    pub fn kept<T: Any + Send + Sync>(&mut self) -> &mut Option<T> {
        let place = self.kept.entry(TypeId::of::<T>()).or_insert_with(|| Box::new(None::<T>));
        place.downcast_mut().expect("the place of a type holds that type")
    }

    /// The projection, with size, overscan and near plane.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Size of the inner frame, px: what methods return.
    pub fn size(&self) -> UVec2 {
        self.projection.size
    }

    /// Margin on every side of the inner frame, px.
    pub fn overscan_px(&self) -> u32 {
        self.projection.overscan_px
    }

    /// The scene's camera; `None` for an image.
    pub fn camera(&self) -> Option<&Camera> {
        match &self.source {
            Source::Scene(source) => Some(&source.camera),
            Source::Image(_) => None,
        }
    }

    /// Whether there is a scene to draw more than the pinhole image from.
    pub fn is_scene(&self) -> bool {
        matches!(self.source, Source::Scene(_))
    }

    /// The lens for this view's stored depth.
    pub fn lens_uniform(&self, lens: &Lens) -> LensUniform {
        let coc = lens.coc();
        let (k_px, slope_px) = (coc.k_px, coc.slope_px(self.projection.near_m));
        // An absurd lens is closed until f32 holds it: its focus stays where it is, and all
        // else is blurred beyond any image either way.
        let closed = (GREATEST_FACTOR_PX / k_px.abs().max(slope_px.abs())).min(1.0);
        let (meridian, astigmatism_px) = lens.meridian();
        LensUniform {
            k_px: (k_px * closed) as f32,
            slope_px: (slope_px * closed) as f32,
            focus_z: lens.stored_focus(self.projection.near_m) as f32,
            sigma_per_coc: lens.aperture.sigma_per_coc() as f32,
            meridian: meridian.as_vec2().to_array(),
            astigmatism_px: astigmatism_px.clamp(-GREATEST_COC_PX, GREATEST_COC_PX) as f32,
            _unused: 0.0,
        }
    }

    /// The pinhole image and its stored depth, drawn when first asked for. Sheets are mixed with what
    /// lies behind them, and the depth is that of the nearest surface that covers half or more.
    pub fn pinhole(&mut self, frame: &mut Frame<'_>) -> Layer {
        if let Some(layer) = &self.pinhole {
            frame.skip("view unchanged");
            return layer.clone();
        }
        let layer = match &self.source {
            Source::Image(layer) => layer.clone(),
            Source::Scene(_) if self.has_sheets() => {
                let solid = self.solid().pinhole(frame);
                self.under_sheets(frame, solid)
            }
            Source::Scene(source) => source.draw(frame, "pinhole", &self.pinhole_shot(LayerQuery::NEAREST)),
        };
        self.pinhole = Some(layer.clone());
        layer
    }

    /// A farther layer or a slab, as the pinhole sees it. Errors for an image.
    pub fn layer(&mut self, frame: &mut Frame<'_>, label: &str, query: LayerQuery<'_>) -> Result<Layer, ViewError> {
        let Source::Scene(source) = &self.source else { return Err(ViewError::ImageHasNo("hidden surfaces")) };
        Ok(source.draw(frame, label, &self.pinhole_shot(query)))
    }

    /// As [`View::layer`], but what its surfaces are made of instead of what they show.
    pub(crate) fn surface_layer(
        &mut self,
        frame: &mut Frame<'_>,
        label: &str,
        query: LayerQuery<'_>,
    ) -> Result<SurfaceLayer, ViewError> {
        let Source::Scene(source) = &self.source else { return Err(ViewError::ImageHasNo("surfaces to shade")) };
        Ok(source.draw_surfaces(frame, label, &self.pinhole_shot(query)))
    }

    /// What shades a [`SurfaceLayer`]. Errors for an image.
    pub fn shading(&self) -> Result<Shading, ViewError> {
        let Source::Scene(source) = &self.source else { return Err(ViewError::ImageHasNo("surfaces to shade")) };
        Ok(source.shading())
    }

    fn pinhole_shot<'a>(&'a self, query: LayerQuery<'a>) -> Shot<'a> {
        let clip_from_view = self.projection.clip_from_view(&Lens::PINHOLE, DVec2::ZERO);
        Shot::new(&self.projection, clip_from_view, DVec2::ZERO, query)
    }

    /// Whether [`View::layer`] may find anything between these depths: `false` only where it
    /// certainly would not. Draws nothing.
    pub(crate) fn may_hold(&self, query: &LayerQuery<'_>) -> bool {
        match &self.source {
            Source::Image(_) => true,
            Source::Scene(source) => source.may_hold(&self.pinhole_shot(*query)),
        }
    }

    /// The inner frame (no overscan) of the scene from the lens point `v`, with the plane
    /// at the focus distance held fixed. A sheet is there or not, pixel by pixel, so that the mean
    /// over lens points of consecutive `number`s has it cover as much as it does.
    /// With `view_dependent`, shading looks from there too; else what a surface emits is
    /// what the pinhole image shows. Errors for an image.
    pub fn from_lens_point(
        &mut self,
        frame: &mut Frame<'_>,
        lens: &Lens,
        v: DVec2,
        number: u32,
        view_dependent: bool,
    ) -> Result<Layer, ViewError> {
        let Source::Scene(source) = &self.source else { return Err(ViewError::ImageHasNo("other viewpoints")) };
        let projection = Projection { overscan_px: 0, ..self.projection };
        let clip_from_view = projection.clip_from_view(lens, v);
        let eye_m = projection.eye_on_lens_m(lens, v);
        // Shading is in the pinhole's view space: only the eye in it moves.
        let shading_eye_m = if view_dependent { eye_m } else { DVec2::ZERO };
        let sheets = (!self.without_sheets).then_some(LensPoint(number));
        let shot = Shot { sheets, ..Shot::new(&projection, clip_from_view, shading_eye_m, LayerQuery::NEAREST) };
        // Of the eyes of all lens points the farthest: those to come share what is drawn.
        let radius_m = lens.aperture.radius() * projection.eye_on_lens_m(lens, DVec2::X).x;
        let moved_px = 0.5 * lens.aperture.radius().max(v.length()) * lens.greatest_astigmatism_px();
        let eyes = Eyes {
            radius_m: radius_m.max(eye_m.length()) as f32,
            focus_d: lens.focus_d() as f32,
            astigmatism_slope: (moved_px / projection.focal_px) as f32,
        };
        Ok(source.draw_from_lens(frame, "lens view", &shot, eyes))
    }

    /// Depth of the inner frame in metres on the CPU, read back when first asked for.
    pub fn depth_m(&mut self, gpu: &Gpu) -> Arc<DepthImage> {
        if let Some(depth) = &self.depth_m {
            return depth.clone();
        }
        let mut frame = gpu.frame();
        let layer = self.pinhole(&mut frame);
        frame.finish();
        let stored = crate::gpu::download_depth(gpu, &layer.depth);
        let inner = stored.crop(UVec2::splat(self.projection.overscan_px), self.projection.size);
        let depth = Arc::new(inner.map(|z| (self.projection.near_m / f64::from(z)) as f32));
        self.depth_m = Some(depth.clone());
        depth
    }
}

/// Greatest K and slope, px, that a shader is given: their difference is still far from the
/// end of f32.
const GREATEST_FACTOR_PX: f64 = 1e30;

/// Greatest difference of the CoC of a primary from green's, px: that of infinity.
fn greatest_shift_px(lens: &Lens) -> f64 {
    let primaries = lens.primaries().into_iter().flatten();
    primaries.map(|primary| (primary.k_px() - lens.k_px()).abs()).fold(0.0, f64::max)
}

/// Overscan, px, that the greatest CoC in view asks for, capped at
/// [`MAX_AUTO_OVERSCAN_PX`]: a lens ray leaves the frame by at most C/2.
pub fn auto_overscan_px(lens: &Lens, depths_m: &DepthImage) -> u32 {
    let extent = lens.aperture.radius();
    let greatest = lens.coc_statistics(depths_m.pixels.iter().copied());
    let coc_px = greatest.map_or(0.0, |s| s.min_signed_px.abs().max(s.max_signed_px.abs()));
    let coc_px = coc_px + lens.greatest_astigmatism_px() + greatest_shift_px(lens);
    (coc_px * 0.5 * extent).ceil().min(f64::from(MAX_AUTO_OVERSCAN_PX)) as u32
}

fn check_size(gpu: &Gpu, size: UVec2, overscan_px: u32) -> Result<(), ViewError> {
    let limit = gpu.max_texture_side();
    let outer = |side: u32| u64::from(side) + 2 * u64::from(overscan_px);
    let good = |side: u32| side > 0 && outer(side) <= u64::from(limit);
    if good(size.x) && good(size.y) {
        return Ok(());
    }
    Err(ViewError::Size { width: size.x, height: size.y, overscan: overscan_px, limit })
}
