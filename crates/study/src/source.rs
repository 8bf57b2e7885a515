//! Something to look at, whatever it is: a built-in scene, a glTF file, or an image with
//! depth.

use crate::builtin;
use crate::gauntlet;
use crate::scale::{SCENE_SCALE, scaled};
use defocus::gpu::Gpu;
use defocus::image::{DepthImage, Image};
use defocus::lens::{Lens, MM_PER_M};
use defocus::presets;
use defocus::scene::gltf::{Lighting, Moment};
use defocus::scene::rgbd::{self, DepthEncoding, RgbdError, RgbdScene};
use defocus::scene::{MadeFor, Scene, SceneError, gltf};
use defocus::view::{GpuScene, SurfaceOptions, View, ViewError};
use glam::{UVec2, uvec2};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Size of a view where nothing says otherwise, px.
pub const DEFAULT_SIZE: UVec2 = uvec2(1024, 768);

/// Full vertical field of view, radians, of an image that does not say: 50 degrees, that of
/// the depth cameras and the phones that most such images come from.
pub const DEFAULT_IMAGE_FOV_Y: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// Mean CoC diameter of [`visibly_open`] over the image's height: 8 px at 768, plainly
/// visible and inside the range over which the papers compare.
const DEFAULT_MEAN_COC_PER_HEIGHT: f64 = 1.0 / 96.0;

/// Greatest CoC diameter of [`visibly_open`] over the image's height: 64 px at 768, so that
/// one near leaf does not become the whole picture.
const DEFAULT_MAX_COC_PER_HEIGHT: f64 = 1.0 / 12.0;

/// Extensions of the images that are read, lower case.
pub const IMAGE_EXTENSIONS: &[&str] = &["bmp", "exr", "hdr", "jpeg", "jpg", "pfm", "png", "tif", "tiff", "webp"];

/// How to read an image with depth, and in which unit a scene's lengths are.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DepthArgs {
    /// The depth file; `None` where the image carries its own depth.
    pub file: Option<PathBuf>,
    /// What its numbers mean.
    pub encoding: DepthEncoding,
    /// The EXR layer that is the picture; `None` for the one that is by its name.
    #[serde(default)]
    pub layer: Option<String>,
    /// The EXR layer or channel that is depth; `None` for the one that is by its name.
    #[serde(default)]
    pub depth_layer: Option<String>,
    /// Full vertical field of view of the image, radians; `None` for that of the depth's
    /// calibration, or [`DEFAULT_IMAGE_FOV_Y`].
    #[serde(default)]
    pub fov_y: Option<f64>,
    /// Metres in a unit of length of a scene's file, such as 0.01 for centimetres; `None` for
    /// metres, as glTF says. Without meaning for images.
    #[serde(default)]
    pub scene_scale: Option<f64>,
}

impl Default for DepthArgs {
    fn default() -> Self {
        Self {
            file: None,
            encoding: DepthEncoding::METRES,
            layer: None,
            depth_layer: None,
            fov_y: None,
            scene_scale: None,
        }
    }
}

/// Why there is nothing to look at.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// A glTF file that cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An image with depth that cannot be used.
    #[error(transparent)]
    Image(#[from] RgbdError),
    /// Neither a built-in name nor a file of a known kind.
    #[error(
        "there is no scene '{}': give a built-in name ({known}), gauntlet:SEED, a .glb or .gltf file, or a .png, .jpg, .webp, .bmp, .tif, .hdr, .pfm or .exr image with depth",
        spec.escape_debug()
    )]
    Unknown {
        /// What was given.
        spec: String,
        /// The built-in names.
        known: String,
    },
    /// A name that no generated scene has.
    #[error(transparent)]
    Generated(#[from] gauntlet::NameError),
    /// A file with a generated scene that cannot be used.
    #[error("{}: {source}", path.display())]
    SpecFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: gauntlet::SpecError,
    },
    /// A depth file beside a scene.
    #[error("{spec} is a scene, which has its own depth: leave out --depth")]
    DepthOfScene {
        /// What was given.
        spec: String,
    },
    /// A unit of length that no file has.
    #[error("a scene scale of {factor} is none: give the metres in a unit of the file, from {} to {}", SCENE_SCALE.start(), SCENE_SCALE.end())]
    SceneScale {
        /// What was given.
        factor: f64,
    },
    /// A time where nothing moves.
    #[error("{} has no animations: leave out --time and --animation, which are for .glb and .gltf files", spec.escape_debug())]
    NotAnimated {
        /// What was given.
        spec: String,
    },
    /// A camera that the scene does not have.
    #[error("{scene} has no camera '{}'; it has {known} (numbers from 0 are accepted too)", given.escape_debug())]
    NoSuchCamera {
        /// The scene's name.
        scene: String,
        /// What was given.
        given: String,
        /// The names there are.
        known: String,
    },
}

/// A file with animations that is kept, to be shown at one moment after the other.
pub struct Posable {
    file: gltf::Animated,
    scene_scale: Option<f64>,
}

impl Posable {
    /// Opens a `.glb` or `.gltf` file in the unit of length that `depth` names.
    ///
    /// # Errors
    ///
    /// [`SourceError::NotAnimated`] for what is no such file, a depth file beside it, a unit that no
    /// file has; those of the loader.
    pub fn open(spec: &str, depth: &DepthArgs) -> Result<Self, SourceError> {
        if depth.file.is_some() {
            return Err(SourceError::DepthOfScene { spec: spec.into() });
        }
        if let Some(factor) = depth.scene_scale.filter(|factor| !SCENE_SCALE.contains(factor)) {
            return Err(SourceError::SceneScale { factor });
        }
        let path = Path::new(spec);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !matches!(extension.as_str(), "glb" | "gltf") {
            return Err(SourceError::NotAnimated { spec: spec.into() });
        }
        Ok(Self { file: gltf::Animated::open(path)?, scene_scale: depth.scene_scale.filter(|factor| *factor != 1.0) })
    }

    /// The scene at rest.
    pub fn at_rest(&self) -> Scene {
        self.in_metres(self.file.at_rest().clone())
    }

    fn in_metres(&self, scene: Scene) -> Scene {
        self.scene_scale.map(|factor| scaled(&scene, factor)).unwrap_or(scene)
    }

    /// The scene at a moment.
    ///
    /// # Errors
    ///
    /// An animation that the file does not have, or one that is damaged.
    pub fn at(&self, moment: &Moment) -> Result<Scene, SourceError> {
        Ok(self.in_metres(self.file.at(moment)?))
    }
}

/// A scene or an image with depth; cheap to clone.
#[derive(Clone, Debug)]
pub enum Source {
    /// Triangles, lights and cameras.
    Scene(Arc<Scene>),
    /// A pinhole image with the depth of every pixel.
    Image(Arc<RgbdScene>),
}

/// What methods are given of a generated scene.
impl From<&gauntlet::SceneSpec> for Source {
    fn from(spec: &gauntlet::SceneSpec) -> Self {
        if spec.as_image { Self::Image(Arc::new(spec.image())) } else { Self::Scene(Arc::new(spec.scene())) }
    }
}

impl Source {
    /// Opens a built-in scene by name, one of the [gauntlet] by its
    /// name or its `.ron` file, a `.glb` or `.gltf` file, or an image with depth.
    ///
    /// # Errors
    ///
    /// Those of the loaders, an unknown name or kind of file, a depth file beside a scene.
    pub fn open(spec: &str, depth: &DepthArgs) -> Result<Self, SourceError> {
        let source = Self::open_as_it_is(spec, depth)?;
        match (depth.scene_scale, &source) {
            (Some(factor), _) if !SCENE_SCALE.contains(&factor) => Err(SourceError::SceneScale { factor }),
            (Some(factor), Self::Scene(scene)) if factor != 1.0 => Ok(Self::Scene(Arc::new(scaled(scene, factor)))),
            _ => Ok(source),
        }
    }

    fn open_as_it_is(spec: &str, depth: &DepthArgs) -> Result<Self, SourceError> {
        let path = Path::new(spec);
        let builtin = builtin::builtin(spec);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let generated = gauntlet::named(spec).transpose()?;
        let is_scene = builtin.is_some() || generated.is_some() || matches!(extension.as_str(), "glb" | "gltf" | "ron");
        if is_scene && depth.file.is_some() {
            return Err(SourceError::DepthOfScene { spec: spec.into() });
        }
        if let Some(generated) = generated {
            return Ok(Self::from(&generated));
        }
        if let Some(picture) = builtin::pictures().iter().find(|p| p.name == spec) {
            return Ok(Self::Image(Arc::new(picture.load())));
        }
        match (builtin, extension.as_str()) {
            (Some(builtin), _) => Ok(Self::Scene(Arc::new(builtin.load()?))),
            (None, "ron") => {
                let spec_file = |source| SourceError::SpecFile { path: path.into(), source };
                Ok(Self::from(&gauntlet::SceneSpec::read(path).map_err(spec_file)?))
            }
            (None, "glb" | "gltf") => Ok(Self::Scene(Arc::new(gltf::load(path)?))),
            (None, extension) if IMAGE_EXTENSIONS.contains(&extension) => {
                let image = rgbd::load_request(&rgbd::Request {
                    color: path,
                    depth: depth.file.as_deref(),
                    encoding: &depth.encoding,
                    fov_y: depth.fov_y,
                    default_fov_y: DEFAULT_IMAGE_FOV_Y,
                    layer: depth.layer.as_deref(),
                    depth_layer: depth.depth_layer.as_deref(),
                })?;
                Ok(Self::Image(Arc::new(image)))
            }
            _ => {
                let names = builtin::all().iter().map(|b| b.name).chain(builtin::pictures().iter().map(|p| p.name));
                let known = names.collect::<Vec<_>>().join(", ");
                Err(SourceError::Unknown { spec: spec.into(), known })
            }
        }
    }

    /// Opens a `.glb` or `.gltf` file as it is at a moment of an animation, as [`Posable::open`] does.
    ///
    /// # Errors
    ///
    /// Those of [`Posable`].
    pub fn open_at(spec: &str, depth: &DepthArgs, moment: &Moment) -> Result<Self, SourceError> {
        Ok(Self::Scene(Arc::new(Posable::open(spec, depth)?.at(moment)?)))
    }

    /// The same source with its light chosen; an image has its light in it.
    pub fn lit(self, lighting: Lighting) -> Self {
        match self {
            Self::Scene(mut scene) if lighting != Lighting::Auto => {
                gltf::relight(Arc::make_mut(&mut scene), lighting);
                Self::Scene(scene)
            }
            other => other,
        }
    }

    /// Short name: the built-in name or the file's stem.
    pub fn name(&self) -> &str {
        match self {
            Self::Scene(scene) => &scene.name,
            Self::Image(image) => &image.name,
        }
    }

    /// What was approximated, left out or filled in while loading, one sentence each.
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Scene(scene) => &scene.notes,
            Self::Image(image) => &image.notes,
        }
    }

    /// Names of the cameras, never empty; an image has the one that took it.
    pub fn cameras(&self) -> Vec<&str> {
        match self {
            Self::Scene(scene) => scene.cameras.iter().map(|c| c.name.as_str()).collect(),
            Self::Image(_) => vec!["image"],
        }
    }

    /// Index of the camera given by number (from 0) or name.
    ///
    /// # Errors
    ///
    /// [`SourceError::NoSuchCamera`].
    pub fn camera_index(&self, given: &str) -> Result<usize, SourceError> {
        let cameras = self.cameras();
        let by_number = || given.parse().ok().filter(|index| *index < cameras.len());
        cameras.iter().position(|name| *name == given).or_else(by_number).ok_or_else(|| SourceError::NoSuchCamera {
            scene: self.name().into(),
            given: given.into(),
            known: cameras.join(", "),
        })
    }

    /// Size of a view, px, if nothing else is asked for: an image's own; else 768 high and
    /// as wide as the camera's aspect ratio asks, 1024 without one. A camera that does not
    /// exist counts as one without.
    pub fn default_size(&self, camera: usize) -> UVec2 {
        match self {
            Self::Image(image) => image.color.size,
            Self::Scene(scene) => {
                if let Some(made_for) = &scene.made_for {
                    return made_for.size;
                }
                let aspect = scene.cameras.get(camera).and_then(|c| c.camera.aspect);
                let width = aspect.map_or(DEFAULT_SIZE.x, |a| (f64::from(DEFAULT_SIZE.y) * a).round().max(1.0) as u32);
                uvec2(width, DEFAULT_SIZE.y)
            }
        }
    }

    /// The size in px that a view has when `wanted` is asked for: exactly that for a scene.
    /// An image keeps its aspect ratio and is never enlarged: it is shrunk to fit.
    pub fn fitted_size(&self, wanted: UVec2) -> UVec2 {
        match self {
            Self::Scene(_) => wanted,
            Self::Image(image) => {
                let own = image.color.size.as_dvec2();
                let scale = (wanted.as_dvec2() / own).min_element().min(1.0);
                (own * scale).round().as_uvec2().max(wanted.min(UVec2::ONE))
            }
        }
    }

    /// Focus distance that the scene's author recommends, metres.
    pub fn focus_hint_m(&self) -> Option<f64> {
        match self {
            Self::Scene(scene) => scene.focus_hint_m,
            Self::Image(_) => None,
        }
    }

    /// The lens and the frame that it is made for, if it is made for one.
    pub fn made_for(&self) -> Option<&MadeFor> {
        match self {
            Self::Scene(scene) => scene.made_for.as_ref(),
            Self::Image(image) => image.made_for.as_ref(),
        }
    }

    /// Whether there is more to draw than one pinhole image.
    pub fn is_scene(&self) -> bool {
        matches!(self, Self::Scene(_))
    }

    /// Uploads what does not depend on the camera.
    pub fn upload(&self, gpu: &Gpu, options: SurfaceOptions) -> GpuSource {
        let scene = match self {
            Self::Scene(scene) => Some(GpuScene::new(gpu, scene, options)),
            Self::Image(_) => None,
        };
        GpuSource { gpu: gpu.clone(), source: self.clone(), options, scene }
    }

    /// A lens to start from: that which the source is made for, or [`default_lens`] at the
    /// author's focus distance.
    pub fn default_lens(&self, depth: &DepthImage) -> Lens {
        match self.made_for() {
            Some(made_for) => made_for.lens_at(depth.size.y),
            None => default_lens(depth, self.focus_hint_m()),
        }
    }
}

/// A source on the GPU: makes views without uploading again.
#[derive(Clone)]
pub struct GpuSource {
    gpu: Gpu,
    source: Source,
    options: SurfaceOptions,
    scene: Option<Arc<GpuScene>>,
}

impl GpuSource {
    /// What was uploaded.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// How its surfaces are drawn.
    pub fn options(&self) -> SurfaceOptions {
        self.options
    }

    /// The GPU it is on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The same source with its scene at another moment of an animation, as [`Posable::at`] gives it:
    /// what does not change then is not uploaded again.
    pub fn posed(&self, scene: Arc<Scene>) -> Self {
        let uploaded = match (&self.source, &self.scene) {
            (Source::Scene(before), Some(uploaded)) => uploaded.posed(before, &scene),
            _ => GpuScene::new(&self.gpu, &scene, self.options),
        };
        let (gpu, options) = (self.gpu.clone(), self.options);
        Self { gpu, source: Source::Scene(scene), options, scene: Some(uploaded) }
    }

    /// A view from a camera, [`Source::fitted_size`] large. `fov_y` (full and vertical,
    /// radians, in (0, pi)) replaces the camera's own field of view. An image has no
    /// overscan. A camera that does not exist counts as the last.
    ///
    /// # Errors
    ///
    /// A size of 0 or beyond the adapter's limit.
    pub fn view(&self, camera: usize, size: UVec2, overscan_px: u32, fov_y: Option<f64>) -> Result<View, ViewError> {
        match (&self.source, &self.scene) {
            (Source::Scene(scene), Some(uploaded)) => {
                let mut camera = scene.cameras[camera.min(scene.cameras.len() - 1)].camera;
                if let Some(fov_y) = fov_y {
                    (camera.fov_y, camera.aspect) = (fov_y, None);
                }
                View::of_scene(uploaded.clone(), camera, size, overscan_px)
            }
            (Source::Image(image), _) => self.image_view(image, self.source.fitted_size(size), fov_y),
            (Source::Scene(_), None) => unreachable!("a scene is uploaded when its GpuSource is made"),
        }
    }

    fn image_view(&self, image: &RgbdScene, size: UVec2, fov_y: Option<f64>) -> Result<View, ViewError> {
        let fov_y = fov_y.unwrap_or(image.fov_y);
        View::of_image(&self.gpu, &shrunk(&image.color, size), &shrunk(&image.depth, size), fov_y)
    }
}

/// Every pixel the one nearest to its centre in `image`. Colour is not averaged: a mean
/// over an edge belongs to neither of the depths there.
fn shrunk<T: Copy>(image: &Image<T>, size: UVec2) -> Image<T> {
    if size == image.size {
        return image.clone();
    }
    let nearest = |i: u32, to: u32, from: u32| {
        ((f64::from(i) + 0.5) * f64::from(from) / f64::from(to)).min(f64::from(from - 1)) as u32
    };
    Image::from_fn(size, |x, y| image.at(nearest(x, size.x, image.size.x), nearest(y, size.y, image.size.y)))
}

/// A lens to start from over the depths (metres) of a view: the preset `projection`,
/// focused at [`default_focus_m`], opened by [`visibly_open`]. Its focal length is
/// shortened to half the focus distance where that is nearer than an image forms.
pub fn default_lens(depth: &DepthImage, focus_hint_m: Option<f64>) -> Lens {
    let projection = presets::preset("projection").map_or(Lens::PINHOLE, |preset| preset.lens);
    let focus_distance_m = default_focus_m(depth, focus_hint_m).unwrap_or(projection.focus_distance_m);
    let focal_length_mm = projection.focal_length_mm.min(0.5 * focus_distance_m * MM_PER_M);
    visibly_open(Lens { focus_distance_m, focal_length_mm, ..projection }, depth)
}

/// Where to focus: at the author's hint, metres, or else at the median depth of the middle
/// third of the frame; `None` where nothing is anywhere.
pub fn default_focus_m(depth: &DepthImage, focus_hint_m: Option<f64>) -> Option<f64> {
    focus_hint_m.or_else(|| centre_depth_m(depth))
}

/// `lens` with E such that the mean CoC diameter over `depth` is 1/96 of the image's height
/// (8 px at 768), or less where the greatest would exceed 1/12 of it. Unchanged where
/// nothing is out of focus.
pub fn visibly_open(lens: Lens, depth: &DepthImage) -> Lens {
    let height_px = f64::from(depth.size.y);
    let depths = || depth.pixels.iter().copied();
    let Some(scaled) = lens.with_mean_coc(height_px * DEFAULT_MEAN_COC_PER_HEIGHT, depths()) else { return lens };
    let greatest = scaled.coc_statistics(depths()).map_or(0.0, |s| s.min_signed_px.abs().max(s.max_signed_px.abs()));
    let limit = height_px * DEFAULT_MAX_COC_PER_HEIGHT;
    let aperture_diameter_mm = scaled.aperture_diameter_mm * (limit / greatest.max(limit));
    Lens { aperture_diameter_mm, ..scaled }
}

/// Median of the finite depths in the middle third of the frame, or in all of it where
/// there is none; `None` where nothing is anywhere.
fn centre_depth_m(depth: &DepthImage) -> Option<f64> {
    let third = depth.size / 3;
    let centre = depth.crop(third, depth.size - 2 * third);
    median_of_finite(&centre).or_else(|| median_of_finite(depth))
}

fn median_of_finite(depth: &DepthImage) -> Option<f64> {
    let mut finite: Vec<f32> = depth.pixels.iter().copied().filter(|d| d.is_finite()).collect();
    let middle = finite.len() / 2;
    (!finite.is_empty()).then(|| f64::from(*finite.select_nth_unstable_by(middle, f32::total_cmp).1))
}
