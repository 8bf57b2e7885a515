//! Depth-of-field methods: textures in, a texture out.
//!
//! # What there is
//!
//! Every method turns a [`View`] (the pinhole image with its depth, and for a scene more on
//! request) and a [`Lens`] into the image that the lens makes. They differ in what they
//! read blur from, and with that in what goes wrong:
//!
//! | method | blur comes from | hidden surfaces | aperture | source |
//! |---|---|---|---|---|
//! | [`Accumulation`] | the scene, drawn from every lens point: the truth, slowly | seen | any | Haeberli and Akeley 1990 |
//! | [`Mipmap`] | a pyramid of the image that keeps sharp surfaces out of blurred backgrounds | missing | round | Lee, Kim, Choi 2009 |
//! | [`Multiview`] | rays through slabs of the scene | seen | any | Lee, Eisemann, Seidel 2009 |
//! | [`Preblur`] | twelve taps, mixed with a small blurred copy | missing | round | Scheuermann 2004 |
//! | [`Separable`] | a filter along rows, then along columns | missing | round | Zhou, Chen, Pullen 2007 |
//! | [`Linear`] | each pixel's light spread evenly over its circle, without order in depth | missing | round | Eurographics 2006 |
//! | [`Pyramid`] | sub-images by depth, holes filled, blurred by pyramids | guessed | round | Kraus, Strengert 2007 |
//! | [`Opaque`] | the same, with blurred opacity instead of filled holes | guessed | round | Kraus 2011 |
//! | [`Splat`] | a spot a pixel, in three layers around each destination's depth | one more layer | any | Lee, Kim, Choi 2008 |
//! | [`Scatter`] | a spot a pixel, sorted far to near | missing | any | Potmesil, Chakravarty 1981 |
//! | [`Gather`] | rings of taps on a half-size image, each weighed by its own blur | guessed | any | Jimenez 2014 and engines since |
//! | [`LensLayers`] | lens rays through depth-peeled layers | seen, four deep | any | Lee et al., SIGGRAPH 2010 |
//! | [`Adaptive`] | few lens rays a pixel through peeled layers, only where blur needs them | seen, four deep | any | this project |
//! | [`Pinhole`] | nothing: the input | | none | |
//!
//! [`About`] says the same for programs, with each method's known limits in words.
//!
//! # Rendering
//!
//! [`record`] is the one way in: it checks the lens, copies the image where all of it is in
//! focus, and otherwise records the method's passes into a [`Frame`].
//!
//! ```no_run
//! use defocus::{gpu::{Gpu, download}, lens::Lens, methods, view::View};
//! # use defocus::image::{ColorImage, DepthImage, Image};
//! # fn load() -> (ColorImage, DepthImage) {
//! #     let size = glam::UVec2::splat(64);
//! #     (Image::filled(size, glam::Vec3::ONE), Image::filled(size, 2.0))
//! # }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let gpu = Gpu::open(None)?;
//! let (color, depth_m) = load();
//! let mut view = View::of_image(&gpu, &color, &depth_m, 0.8)?;
//! let lens = Lens { aperture_diameter_mm: 40.0, focus_distance_m: 2.0, ..Lens::PINHOLE };
//! let mut method = methods::by_id("mipmap")?;
//! methods::set_param(&mut *method, "smoothing", "off")?;
//! let mut frame = gpu.frame();
//! let texture = methods::record(&*method, &mut frame, &mut view, &lens)?;
//! frame.finish();
//! let image = download(&gpu, &texture);
//! # Ok(())
//! # }
//! ```
//!
//! Parameters are plain data ([`Param`]): sliders, options of the command line, sweeps and
//! tests all come from [`Method::params`].
//!
//! # What holds for all of them
//!
//! A closed aperture or an image in focus gives the pinhole image; a constant colour stays
//! where a method averages; mirrored input gives mirrored output; nothing finite becomes NaN
//! or infinite. `crates/study/tests/invariants.rs` and the stress runs of `defocus-study` iterate over [`all`], so
//! that a method added later cannot escape them.
//!
//! # Adding one
//!
//! A file here, a shader of the same stem under `shaders/methods/`, and a line in [`all`].
//! The window, the command line, the metrics and the benchmarks find it by iterating.

mod accumulation;
pub mod adaptive;
mod gather;
mod lens_layers;
mod linear;
mod meaning;
mod mipmap;
pub mod multiview;
mod opaque;
mod param;
mod pinhole;
mod preblur;
mod primaries;
mod pyramid;
mod scatter;
mod separable;
mod sheet_rays;
mod splat;
pub mod sprites;
mod subimages;
pub mod tile_lists;

pub use accumulation::{Accumulation, AccumulationRun};
pub use adaptive::Adaptive;
pub use gather::Gather;
pub use lens_layers::LensLayers;
pub use linear::{CircleSampling, Circles, Coverage, Linear, LinearFilter, linear_cpu};
pub use meaning::{Meaning, Quantity, Scale};
pub use mipmap::{Mipmap, MipmapCalibration, MipmapFilter, MipmapInterpolation};
pub use multiview::Multiview;
pub use opaque::Opaque;
pub use param::{Param, ParamError, Value};
pub use pinhole::{Pinhole, copy_inner};
pub use preblur::{Preblur, Ramp};
pub use primaries::{combined_images, converging};
pub use pyramid::Pyramid;
pub use scatter::Scatter;
pub use separable::Separable;
pub use splat::Splat;
pub use subimages::{Spacing, SpacingCalibration, pyramid_variance_px2};

use crate::gpu::{Frame, Refused, Texture};
use crate::lens::Lens;
use crate::view::{View, ViewError};

/// All methods with their default parameters, in the order in which they are listed.
pub fn all() -> Vec<Box<dyn Method>> {
    vec![
        Box::new(Pinhole),
        Box::new(Accumulation::default()),
        Box::new(Mipmap::default()),
        Box::new(Multiview::default()),
        Box::new(Preblur::default()),
        Box::new(Separable::default()),
        Box::new(Linear::default()),
        Box::new(Pyramid::default()),
        Box::new(Opaque::default()),
        Box::new(Splat::default()),
        Box::new(Scatter::default()),
        Box::new(Gather::default()),
        Box::new(LensLayers::default()),
        Box::new(Adaptive::default()),
    ]
}

/// What a method is.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct About {
    /// Short name on the command line and in results.
    pub id: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// Authors, title and year of the source.
    pub paper: &'static str,
    /// What it does, in a sentence or two.
    pub summary: &'static str,
    /// What it cannot do or is known to get wrong.
    pub limits: &'static str,
    /// Aperture shapes that it can render; others are approximated by their width.
    pub apertures: Apertures,
    /// Whether it renders the elliptical blur of an astigmatic eye; others blur as its mean
    /// meridian does.
    pub astigmatism: bool,
    /// Whether it needs more of a scene than the pinhole image and its depth.
    pub needs_scene: bool,
    /// Whether it spreads each point's light, so that a lone point keeps its energy.
    pub conserves_energy: bool,
    /// Whether each pixel is an average, so that a constant colour stays for any depth.
    pub averages: bool,
    /// Whether it samples the lens, so that a mirrored image differs by sampling noise.
    pub samples_lens: bool,
}

/// Aperture shapes that a method can render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Apertures {
    /// Every shape.
    Any,
    /// A round blur of the lens's width.
    Round,
    /// None: nothing is blurred.
    None,
}

/// Why a method cannot render.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MethodError {
    /// The view cannot give what the method needs.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The lens forms no image.
    #[error(transparent)]
    Lens(#[from] crate::lens::LensError),
    /// The adapter lacks something.
    #[error("{method} needs {what}, which this adapter does not have: choose another method or adapter")]
    Unsupported {
        /// The method's id.
        method: &'static str,
        /// What is missing.
        what: &'static str,
    },
    /// The device allows no textures or buffers as large as the picture needs.
    #[error(
        "{method} cannot render as large a picture: {refused}; make it smaller, with less overscan, or open the \
         device with the limits that the adapter has"
    )]
    TooLarge {
        /// The method's id.
        method: &'static str,
        /// What is too large.
        refused: Refused,
    },
    /// It has to wait for the GPU, which frames of a [`Recorder`](crate::gpu::Recorder) do
    /// not.
    #[error("{method} computes on the CPU and has to wait for the picture: record it in a frame of its own")]
    HasToWait {
        /// The method's id.
        method: &'static str,
    },
}

/// A depth-of-field method.
pub trait Method: Send + Sync {
    /// What it is.
    fn about(&self) -> About;

    /// Its parameters.
    fn params(&mut self) -> Vec<Param<'_>>;

    /// Records the passes that render `view` through `lens` and returns a texture of
    /// the view's inner size, RGBA16F or RGBA32F, linear. Called through [`record`],
    /// which has checked the lens and that there is something to blur.
    fn record(&self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<Texture, MethodError>;

    /// What a texture means that [`Method::record`] exposes under `name`.
    fn meaning(&self, _name: &str) -> Meaning {
        Meaning::Picture
    }

    /// Names of those exposed textures that tell of each pixel or tile what was done there:
    /// numbers that are worth laying over the picture.
    fn explains(&self) -> &'static [&'static str] {
        &[]
    }

    /// Width, px, of a texel of the finest level of a texture that [`Method::record`] exposes
    /// under `name`, where that does not follow from its size.
    fn texel_px(&self, _name: &str) -> Option<u32> {
        None
    }

    /// For a method whose picture gets better over many frames: a run of them, and how many
    /// there are to be.
    fn converging(&self) -> Option<(Box<dyn Converging>, u32)> {
        None
    }

    /// A copy with its parameters.
    fn boxed(&self) -> Box<dyn Method>;
}

/// A picture that gets better frame by frame, as long as view and lens stay: it can be
/// looked at, carried on or given up at any time.
pub trait Converging: Send {
    /// Frames so far.
    fn count(&self) -> u32;

    /// Adds `n` frames.
    ///
    /// # Errors
    ///
    /// As [`Method::record`].
    fn advance(&mut self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, n: u32) -> Result<(), MethodError>;

    /// The picture so far, RGBA32F. Panics before the first frame.
    fn mean(&self, frame: &mut Frame<'_>) -> Texture;
}

impl Clone for Box<dyn Method> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// CoC diameter, px, below which a whole image counts as in focus. A disc this wide has a
/// standard deviation of 1/80 px: it changes a pixel by less than a thousandth of the
/// contrast around it.
pub const IN_FOCUS_COC_PX: f64 = 0.05;

/// Renders `view` through `lens` with `method`; the pinhole image itself, with no blur
/// pass, where everything is in focus.
///
/// # Errors
///
/// As [`MethodError`] says. After [`MethodError::TooLarge`] the frame holds commands that are
/// valid and without effect on anything but textures of its own.
pub fn record(
    method: &dyn Method,
    frame: &mut Frame<'_>,
    view: &mut View,
    lens: &Lens,
) -> Result<Texture, MethodError> {
    lens.check()?;
    let id = method.about().id;
    // What something else asked for on this thread is not this method's.
    frame.gpu().take_refused();
    let result = match lens.primaries().filter(|lenses| lenses.iter().any(|lens| is_blurred(frame, view, lens))) {
        Some(lenses) => primaries::record_all(method, frame, view, &lenses)?,
        None => {
            frame.set_prefix(format!("{id}/"));
            record_through(method, frame, view, lens)?
        }
    };
    if frame.keeps_intermediates() {
        expose_pinhole(frame, view);
    }
    match frame.gpu().take_refused() {
        Some(refused) => Err(MethodError::TooLarge { method: id, refused }),
        None => Ok(result),
    }
}

/// Whether a lens blurs anything in the view enough to be seen.
pub fn is_blurred(frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> bool {
    if lens.aperture_diameter_mm == 0.0 {
        return false;
    }
    if view.has_sheets() {
        // What is seen through may be blurred where the nearest surface is not.
        return true;
    }
    let [low, high] = view.coc_bounds_px(frame, lens);
    low.abs().max(high.abs()) + lens.greatest_astigmatism_px() >= IN_FOCUS_COC_PX
}

/// As [`record`], through a lens without chromatic aberration that was checked.
fn record_through(
    method: &dyn Method,
    frame: &mut Frame<'_>,
    view: &mut View,
    lens: &Lens,
) -> Result<Texture, MethodError> {
    if is_blurred(frame, view, lens) {
        return method.record(frame, view, lens);
    }
    frame.skip("everything in focus");
    Ok(pinhole::inner(frame, view))
}

/// Exposes the pinhole image and its depth.
pub fn expose_pinhole(frame: &mut Frame<'_>, view: &mut View) {
    let pinhole = view.pinhole(frame);
    frame.expose("pinhole image", &pinhole.color);
    frame.expose(STORED_DEPTH, &pinhole.depth);
}

/// Name under which [`expose_pinhole`] exposes depth.
const STORED_DEPTH: &str = "stored depth";

/// What a texture means that `method`, or [`record`] around it, exposes under `name`.
pub fn meaning(method: &dyn Method, name: &str) -> Meaning {
    if name == STORED_DEPTH { Meaning::stored_depth() } else { method.meaning(name) }
}

/// The method called `id` with its default parameters, or an error that lists all.
pub fn by_id(id: &str) -> Result<Box<dyn Method>, UnknownMethod> {
    let mut methods = all();
    let known: Vec<_> = methods.iter().map(|m| m.about().id).collect();
    match known.iter().position(|k| *k == id) {
        Some(index) => Ok(methods.swap_remove(index)),
        None => Err(UnknownMethod { id: id.into(), known: known.join(", ") }),
    }
}

/// No method has that name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("there is no method '{}'; there are: {known}", id.escape_debug())]
pub struct UnknownMethod {
    /// The name given.
    pub id: String,
    /// The names there are.
    pub known: String,
}

/// Sets one parameter of a method from text.
pub fn set_param(method: &mut dyn Method, key: &str, text: &str) -> Result<(), ParamError> {
    let id = method.about().id;
    let mut params = method.params();
    let known: Vec<_> = params.iter().map(|p| p.key).collect();
    let Some(param) = params.iter_mut().find(|p| p.key == key) else {
        return Err(ParamError::Unknown { method: id, key: key.into(), known: known.join(", ") });
    };
    let key = param.key;
    param.set(text).map_err(|expected| ParamError::Invalid { method: id, key, given: text.into(), expected })
}

/// Sets the parameters in which a method's defaults go beyond its source to what the source
/// has: constants, filters, intersections, blending as they were published. What a source
/// leaves open keeps its default. [`Param::published`] has each value.
pub fn set_as_published(method: &mut dyn Method) {
    for param in &mut method.params() {
        if let Some(value) = param.published {
            // Every method's are tried by a test.
            let _ = param.set(value);
        }
    }
}

/// Whether a method has all that [`set_as_published`] sets; `None` where its defaults are what
/// was published.
pub fn is_as_published(method: &dyn Method) -> Option<bool> {
    let mut method = method.boxed();
    let params = method.params();
    let mut known = params.iter().filter_map(|param| Some(param.published? == param.text())).peekable();
    known.peek()?;
    Some(known.all(|same| same))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_values_are_accepted_and_differ_from_the_defaults() {
        for mut method in all() {
            let id = method.about().id;
            for param in &mut method.params() {
                let Some(value) = param.published else { continue };
                let default = param.text();
                assert_eq!(param.set(value), Ok(()), "{id}.{}", param.key);
                assert_eq!(param.text(), value, "{id}.{}: as the parameter itself writes it", param.key);
                assert_ne!(default, value, "{id}.{}: the default is what was published", param.key);
            }
            let wanted = is_as_published(by_id(id).expect("it is known").as_ref());
            assert!(wanted != Some(true), "{id}: the default");
            let mut published = by_id(id).expect("it is known");
            set_as_published(published.as_mut());
            assert!(is_as_published(published.as_ref()) != Some(false), "{id}: as published");
        }
    }
}
