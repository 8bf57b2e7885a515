//! `defocus`: a depth-of-field instrument.
//!
//! It renders a scene through a thin lens with many depth-of-field methods, shows how
//! each differs from the truth and what it costs.
//!
//! ```text
//! Scene + Camera --draw--> View --Method(Lens)--> linear HDR texture --present--> window / PNG / EXR
//!                           |                            |
//!                           +--accumulation / raytrace --+--> metrics
//! ```
//!
//! # Where to begin
//!
//! | to | see |
//! |---|---|
//! | render a scene or an image with depth | [`methods`], with an example; [`view::View`] |
//! | know what the methods are and how they differ | [`methods`] |
//! | set a lens, and read off its circles of confusion | [`lens::Lens`], [`presets`] |
//! | put an eye behind it: pupil, glasses, colours, comfort | [`eye`], [`viewing`] |
//! | load a glTF scene, or a photograph with a depth map | [`scene::gltf`], [`scene::rgbd`] |
//! | use the program's own device, textures and depth buffer | [`gpu::Gpu::from_device`], [`view::ExternalFrame`] |
//! | trace rays through a lens | [`raytrace`] |
//! | write a method | [`methods`], [`gpu`] |
//!
//! Two crates stand on this one and are not imported here: `defocus-study` (`crates/study`)
//! compares methods with the truth, looks for what they cannot bear and has the built-in
//! scenes; `defocus-app` (`crates/app`) is the program with its window and command line.
//!
//! # Conventions, the same in every file
//!
//! - **Depth** `d` is the distance along the optical axis, in metres (glTF's unit), never
//!   the radial distance. On the GPU it is stored *reversed with an infinite far plane*:
//!   `z = near / d`, 1 at the near plane and 0 at infinity.
//! - **CoC** is a *signed diameter in pixels*, negative in front of the focus distance and
//!   positive behind it. With the depth above it is affine in the stored value:
//!   `c = K - K * (df / near) * z` ([`lens::CocOfDepth`]).
//! - **Images** have their origin at the top left; pixel centres lie at half integers.
//! - **View space** looks along -z, with x right and y up. A lens point `v` lives in the
//!   unit disc with *image* orientation (y down). A scene point with CoC c that the pinhole
//!   shows at `p0` is seen from `v` at `p0 + v * c / 2` (scattering); hence the lens ray
//!   through pixel `p` and `v` meets depth d at `p - v * c(d) / 2` (gathering).
//! - **Colour** is linear Rec. 709, scene-referred and unbounded until
//!   [`display`] or [`present`] turns it into display values.
//! - Names carry space and unit: `view_from_world`, `coc_diameter_px`, `focus_distance_m`.

pub mod aperture;
pub mod camera;
pub mod colormap;
pub mod combine;
pub mod display;
pub mod eye;
pub mod focus;
pub mod gpu;
pub mod histogram;
pub mod image;
pub mod image_io;
pub mod lens;
pub mod methods;
pub mod present;
pub mod presets;
pub mod raytrace;
pub mod scene;
pub mod stereo;
pub mod view;
pub mod viewing;
