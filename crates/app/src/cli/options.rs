//! Options that several commands share, and the texts they are parsed from.

use clap::{Args, ValueEnum};
use defocus::aperture::Aperture;
use defocus::display::{Display, ToneMap};
use defocus::eye::{Eye, EyePreset, Pupil, PupilError, Refraction, amplitude_d, eye_presets};
use defocus::gpu::{Gpu, GpuError, Schedule};
use defocus::scene::gltf::Moment;
use defocus::viewing::{PX_PER_DEGREE, Screen, ScreenError};
use defocus_study::cache::ReferenceCache;
use glam::{DQuat, DVec3, UVec2, uvec2};
use std::path::PathBuf;

/// What to look at.
#[derive(Debug, Args)]
#[command(next_help_heading = "Scene")]
pub struct SceneOptions {
    /// A built-in name, gauntlet:SEED, a .glb or .gltf file, or an image with depth (.png, .jpg, .webp, .bmp,
    /// .tif, .hdr, .pfm, .exr)
    pub scene: String,
    /// Show a glTF file as it is at this time of its animation, seconds
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub time: Option<f64>,
    /// The animation to show, by name or number from 0 [default: the first, at 0 s without --time]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Depth of the image, if it has none of its own: an EXR, PFM, NumPy array, TIFF, or a PNG of 8 or 16
    /// bits; of another size than the image, it is resampled with edges kept
    #[arg(long, value_name = "FILE")]
    pub depth: Option<PathBuf>,
    /// What the depth's numbers mean
    #[arg(long, value_name = "KIND", value_enum, default_value_t = DepthKindName::Metres)]
    pub depth_kind: DepthKindName,
    /// Depths in metres between which inverse, relative and device numbers lie; FAR may be inf
    #[arg(long, value_name = "NEAR,FAR", value_parser = parse_range, allow_hyphen_values = true)]
    pub depth_range: Option<Range>,
    /// Metres, dioptres or pixels of disparity in a unit of the depth's numbers, such as 0.001 for
    /// millimetres [default: 1]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    pub depth_scale: Option<f64>,
    /// Metres in a unit of length of a scene's file, such as 0.01 for centimetres [default: 1]
    #[arg(long, value_name = "METRES")]
    pub scene_scale: Option<f64>,
    /// The number that means "not measured"
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub depth_unknown: Option<f32>,
    /// The number that means "infinitely far", such as 0
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub depth_infinity: Option<f32>,
    /// Of a stereo pair: focal length in pixels of the disparity map, baseline in metres, and the
    /// difference of the principal points in pixels (Middlebury's doffs)
    #[arg(long, value_name = "FOCAL_PX,BASELINE_M[,OFFSET_PX]", value_parser = parse_calibration, allow_hyphen_values = true)]
    pub depth_calibration: Option<Calibration>,
    /// The EXR layer that is the picture [default: Combined, beauty, rgba or one without a name]
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// The EXR layer or channel that is depth [default: Z, depth, Depth.Z, Depth.V or the like]
    #[arg(long, value_name = "NAME")]
    pub depth_layer: Option<String>,
}

impl SceneOptions {
    /// The moment of an animation that is asked for.
    pub fn moment(&self) -> Option<Moment> {
        let is_asked_for = self.time.is_some() || self.animation.is_some();
        is_asked_for.then(|| Moment { animation: self.animation.clone(), time_s: self.time.unwrap_or(0.0) })
    }
}

/// A stereo pair's calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Focal length, px.
    pub focal_px: f64,
    /// Distance of the cameras, metres.
    pub baseline_m: f64,
    /// Difference of the principal points, px.
    pub offset_px: f64,
}

/// What a depth file's numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DepthKindName {
    /// Distance along the optical axis, in units of --depth-scale
    Metres,
    /// Distance along each pixel's ray by the field of view (--fov), in units of --depth-scale
    Distance,
    /// Inverse depth between 1/FAR and 1/NEAR of --depth-range, greater is nearer
    Inverse,
    /// Inverse depth of a network (MiDaS, Depth Anything): its greatest number is at NEAR, its least at FAR
    Relative,
    /// Inverse metres, in units of --depth-scale
    Dioptres,
    /// Pixels between the two images of --depth-calibration, in units of --depth-scale
    Disparity,
    /// A depth buffer over --depth-range, 0 is near
    Device,
}

/// The lens: the papers' symbols.
#[derive(Debug, Args)]
#[command(next_help_heading = "Lens", allow_negative_numbers = true)]
pub struct LensOptions {
    /// A preset to start from, as `defocus lenses` lists them
    #[arg(long, value_name = "NAME")]
    pub lens: Option<String>,
    /// E: diameter of the aperture, mm; 0 is a pinhole [default: one that blurs visibly]
    #[arg(short = 'E', value_name = "MM")]
    pub aperture_diameter_mm: Option<f64>,
    /// F: focal length, mm
    #[arg(short = 'F', value_name = "MM")]
    pub focal_length_mm: Option<f64>,
    /// The lens of a camera of this f-number N: E = F/N, and the image plane and its pixels are where and as
    /// dense as the field of view and the focus distance make them, whatever dr, ds and DPI
    #[arg(long, value_name = "N", requires = "focal_length_mm", conflicts_with_all = ["aperture_diameter_mm", "mean_coc", "pupil_luminance", "image_distance_mm", "density_px_per_mm"])]
    pub f_number: Option<f64>,
    /// dr: distance from the lens to the image plane, mm
    #[arg(long = "dr", value_name = "MM")]
    pub image_distance_mm: Option<f64>,
    /// ds: distance from the lens to the screen, mm
    #[arg(long = "ds", value_name = "MM")]
    pub screen_distance_mm: Option<f64>,
    /// DPI: pixel density of the screen, px per mm
    #[arg(long = "dpi", value_name = "PXPERMM")]
    pub density_px_per_mm: Option<f64>,
    /// df: focus distance, metres, or inf [default: the preset's, else the scene's own hint, else the
    /// median depth of the middle of the frame]
    #[arg(long, value_name = "M|inf", conflicts_with = "focus_at")]
    pub focus: Option<f64>,
    /// Focus on what is seen at a pixel
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pub focus_at: Option<UVec2>,
    /// Scale E so that the mean CoC diameter over the image is this, px
    #[arg(long, value_name = "PX", conflicts_with = "aperture_diameter_mm")]
    pub mean_coc: Option<f64>,
    /// Intensity over the aperture: disc, polygon:N[:ROT[:ROUNDNESS]], gaussian[:SIGMA_PER_COC] or image:FILE
    #[arg(long, value_name = "SHAPE", value_parser = parse_aperture)]
    pub aperture: Option<Aperture>,
    #[command(flatten)]
    pub eye: EyeOptions,
}

/// The eye behind the lens.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Eye", allow_negative_numbers = true)]
pub struct EyeOptions {
    /// E is the pupil of an eye that is adapted to this luminance, cd/m2; display: to a picture of mid-grey on
    /// the display
    #[arg(long, value_name = "CD_M2|display", conflicts_with_all = ["aperture_diameter_mm", "mean_coc"], value_parser = parse_adaptation)]
    pub pupil_luminance: Option<Adaptation>,
    /// Diameter of the lit field, degrees
    #[arg(long, value_name = "DEG", default_value_t = 60.0, requires = "pupil_luminance")]
    pub pupil_field: f64,
    /// One eye is covered
    #[arg(long, requires = "pupil_luminance")]
    pub one_eye: bool,
    /// Age, years, of whom the pupil and the accommodation are [default: 30 for the pupil, and an eye that
    /// focuses as near as is asked]
    #[arg(long, value_name = "YEARS")]
    pub age: Option<f64>,
    /// An eye by name: emmetrope, presbyope, myope or astigmat
    #[arg(long, value_name = "NAME", value_parser = parse_eye)]
    pub eye: Option<EyePreset>,
    /// Sphere of the glasses that the eye needs and does not wear, dioptres
    #[arg(long, value_name = "D")]
    pub sphere: Option<f64>,
    /// Cylinder of those glasses, dioptres
    #[arg(long, value_name = "D")]
    pub cylinder: Option<f64>,
    /// Axis of the cylinder, degrees from 0 to 180
    #[arg(long, value_name = "DEG")]
    pub axis: Option<f64>,
    /// How much nearer than at rest the eye can focus, dioptres; any: as near as is asked [default: that of
    /// its age]
    #[arg(long, value_name = "D|any", value_parser = parse_accommodation)]
    pub accommodation: Option<Accommodation>,
    /// Chromatic aberration: each of the display's primaries has its own focus; their dominant wavelengths in
    /// nm [default: the display's]
    #[arg(long, value_name = "R,G,B", num_args = 0..=1, require_equals = true, value_parser = parse_primaries)]
    pub chromatic: Option<Option<[f64; 3]>>,
}

/// What a pupil is adapted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Adaptation {
    /// The display.
    Display,
    /// A luminance, cd/m2.
    CdM2(f64),
}

/// How near an eye can focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accommodation {
    /// As near as is asked.
    Any,
    /// Nearer than at rest by so many dioptres.
    Dioptres(f64),
}

impl EyeOptions {
    /// What is said about the eye in place of `eye`, before a display of such light.
    pub fn overridden(&self, eye: Eye, screen: &Screen) -> Eye {
        let preset = self.eye;
        let base = preset.map_or(eye.refraction, |preset| preset.refraction);
        let refraction = Refraction {
            sphere_d: self.sphere.unwrap_or(base.sphere_d),
            cylinder_d: self.cylinder.unwrap_or(base.cylinder_d),
            axis_deg: self.axis.unwrap_or(base.axis_deg),
        };
        let by_age = self.age.or(preset.map(|preset| preset.age_years)).map(amplitude_d);
        let accommodation_d = match self.accommodation {
            Some(Accommodation::Any) => None,
            Some(Accommodation::Dioptres(d)) => Some(d),
            None => by_age.or(eye.accommodation_d),
        };
        let chromatic = self.chromatic.map(|given| given.unwrap_or(screen.primaries_nm)).or(eye.chromatic);
        Eye { refraction, accommodation_d, chromatic, ..eye }
    }

    /// Diameter of the pupil, mm, before a display of such light; `None` where E is said otherwise.
    ///
    /// # Errors
    ///
    /// Light or an age for which no pupil is known.
    pub fn pupil_mm(&self, screen: &Screen) -> Result<Option<f64>, PupilError> {
        let Some(adaptation) = self.pupil_luminance else { return Ok(None) };
        let usual = Pupil::default();
        let pupil = Pupil {
            luminance_cd_m2: match adaptation {
                Adaptation::Display => screen.adapting_cd_m2(),
                Adaptation::CdM2(luminance) => luminance,
            },
            field_deg: self.pupil_field,
            both_eyes: !self.one_eye,
            age_years: self.age.or(self.eye.map(|eye| eye.age_years)).unwrap_or(usual.age_years),
        };
        pupil.check()?;
        Ok(Some(pupil.diameter_mm()))
    }
}

fn parse_adaptation(text: &str) -> Result<Adaptation, String> {
    if text == "display" {
        return Ok(Adaptation::Display);
    }
    text.parse().map(Adaptation::CdM2).map_err(|_| "give a luminance in cd/m2, such as 100, or display".into())
}

fn parse_accommodation(text: &str) -> Result<Accommodation, String> {
    if text == "any" {
        return Ok(Accommodation::Any);
    }
    text.parse().map(Accommodation::Dioptres).map_err(|_| "give dioptres, such as 1.5, or any".into())
}

fn parse_eye(text: &str) -> Result<EyePreset, String> {
    let all = eye_presets();
    let known = all.map(|eye| eye.name).join(", ");
    all.into_iter().find(|eye| eye.name == text).ok_or_else(|| format!("the eyes are {known}"))
}

fn parse_primaries(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    <[f64; 3]>::try_from(numbers).map_err(|_| "give three wavelengths in nm, such as 617,520,449".into())
}

/// The view.
#[derive(Debug, Args)]
#[command(next_help_heading = "View")]
pub struct ViewOptions {
    /// The scene's camera, by number from 0 or by name
    #[arg(long, value_name = "N|NAME", default_value = "0")]
    pub camera: String,
    /// Where the camera stands, metres, and its orientation as a quaternion, in place of the scene's
    #[arg(long, value_name = "X,Y,Z,QX,QY,QZ,QW", value_parser = parse_pose, allow_hyphen_values = true)]
    pub pose: Option<Pose>,
    /// Size of the image, px; an image with depth is shrunk to fit [default: 1024x768, or 768 high in the
    /// camera's own aspect ratio]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<UVec2>,
    /// Vertical field of view in degrees; camera: its own; display: what the eye at ds sees on the screen
    #[arg(long, value_name = "camera|display|DEG", default_value = "camera", value_parser = parse_fov, allow_hyphen_values = true)]
    pub fov: FieldOfView,
    /// Margin drawn around the image for rays that leave it, px; auto: half the greatest CoC, at most 96
    #[arg(long, value_name = "auto|PX", default_value = "auto", value_parser = parse_overscan)]
    pub overscan: Overscan,
    /// What lights a scene file: its own light, with a directional light and a neutral studio where it has
    /// hardly any; its own alone; or the added light, whatever it has
    #[arg(long, value_enum, default_value_t = LightName::Auto)]
    pub light: LightName,
    /// What surfaces show: lights and materials, or base colours only
    #[arg(long, value_enum, default_value_t = ShadingName::Scene)]
    pub shading: ShadingName,
    /// Shade references from each point of the lens, so that reflections shift
    #[arg(long)]
    pub view_dependent: bool,
    /// Show methods the pinhole image of a scene with its depth, and nothing else: as if it were a picture
    #[arg(long)]
    pub as_image: bool,
    /// Methods exactly as their sources published them; --set then changes single parameters
    #[arg(long)]
    pub as_published: bool,
    /// Set a parameter of a method (repeatable), as `defocus methods` lists them
    #[arg(long = "set", value_name = "[ID.]KEY=VALUE")]
    pub settings: Vec<String>,
}

/// What lights a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightName {
    /// The file's own light, and the added one where it has hardly any
    Auto,
    /// The file's own light alone
    File,
    /// The added light beside the file's own
    Studio,
}

/// What surfaces show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShadingName {
    /// The scene's lights and materials
    Scene,
    /// Base colours only
    Unlit,
}

/// How images are shown.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Display")]
pub struct DisplayOptions {
    /// Exposure before tone mapping, EV [default: 0; metered from the pinhole image for a scene file that
    /// would be white or black]
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = parse_exposure)]
    pub exposure: Option<f32>,
    /// Tone map: none, reinhard or agx
    #[arg(long, value_name = "NAME", default_value = "none", value_parser = parse_tone_map)]
    pub tonemap: ToneMap,
    /// Pixels per degree at which differences are judged [default: the lens's own, DPI ds pi / 180; 67 for
    /// diff]
    #[arg(long, value_name = "PX", allow_hyphen_values = true, value_parser = parse_ppd)]
    pub ppd: Option<f64>,
    /// Luminance of the display's white, cd/m2 [default: that of the lens preset's display, else 200]
    #[arg(long, value_name = "CD_M2", allow_hyphen_values = true)]
    pub peak_luminance: Option<f64>,
    /// Luminance of its black, cd/m2 [default: the preset's, else a thousandth of the peak]
    #[arg(long, value_name = "CD_M2", allow_hyphen_values = true)]
    pub black_luminance: Option<f64>,
    /// Light that falls on the display, lux [default: the preset's, else 250]
    #[arg(long, value_name = "LUX", allow_hyphen_values = true)]
    pub ambient: Option<f64>,
    /// The display shows values above white, which is then 203 cd/m2, up to its peak
    #[arg(long)]
    pub hdr: bool,
}

impl DisplayOptions {
    /// The display; its exposure is 0 where none is named.
    pub fn display(&self) -> Display {
        Display { exposure_ev: self.exposure.unwrap_or(0.0), tone_map: self.tonemap }
    }

    /// The display's light: `preset` with what is given in place of its own.
    ///
    /// # Errors
    ///
    /// A luminance that no display has.
    pub fn screen(&self, preset: Option<Screen>) -> Result<Screen, ScreenError> {
        let base = preset.unwrap_or_default();
        let peak_cd_m2 = self.peak_luminance.unwrap_or(base.peak_cd_m2);
        // Another peak keeps the contrast.
        let black_cd_m2 = self.black_luminance.unwrap_or(base.black_cd_m2 * peak_cd_m2 / base.peak_cd_m2);
        let ambient_lux = self.ambient.unwrap_or(base.ambient_lux);
        let screen = Screen { peak_cd_m2, black_cd_m2, ambient_lux, hdr: self.hdr || base.hdr, ..base };
        screen.check()?;
        Ok(screen)
    }
}

/// Where it runs and what it says.
#[derive(Debug, Args)]
#[command(next_help_heading = "Run")]
pub struct RunOptions {
    /// The graphics adapter, by a part of its name [default: the fastest real one]
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// How tiles that need different work get it, lists or branches: the same pictures
    /// [default: lists in software, branches on hardware]
    #[arg(long, value_name = "HOW")]
    pub schedule: Option<Schedule>,
    #[command(flatten)]
    pub json: JsonOption,
    /// No progress bar and no summary
    #[arg(short, long)]
    pub quiet: bool,
}

impl RunOptions {
    /// Opens the adapter.
    pub fn gpu(&self) -> Result<Gpu, GpuError> {
        open_gpu(self.adapter.as_deref(), self.schedule)
    }
}

/// Opens an adapter, which works on tiles as `schedule` says if it says so.
pub fn open_gpu(adapter: Option<&str>, schedule: Option<Schedule>) -> Result<Gpu, GpuError> {
    let gpu = Gpu::open(adapter)?;
    if let Some(schedule) = schedule {
        gpu.set_schedule(schedule);
    }
    Ok(gpu)
}

/// Machine-readable results.
#[derive(Debug, Args)]
pub struct JsonOption {
    /// Write the result as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// References kept from one run to the next.
#[derive(Debug, Args)]
pub struct CacheOptions {
    /// Folder in which references are kept [default: the user's cache folder]
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Neither use nor keep references
    #[arg(long, conflicts_with = "cache")]
    pub no_cache: bool,
}

impl CacheOptions {
    /// The cache, if there is to be one.
    pub fn cache(&self) -> Option<ReferenceCache> {
        match &self.cache {
            _ if self.no_cache => None,
            Some(folder) => Some(ReferenceCache::at(folder)),
            None => ReferenceCache::of_user(),
        }
    }
}

/// Two ends of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The nearer end, metres.
    pub near_m: f64,
    /// The farther end, metres.
    pub far_m: f64,
}

/// Where a camera stands and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres, world space.
    pub position: DVec3,
    /// From view space to world space, normalised.
    pub orientation: DQuat,
}

/// Where the field of view comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    /// The camera.
    Camera,
    /// The screen and its distance.
    Display,
    /// The user: full and vertical, degrees.
    Degrees(f64),
}

/// The margin around the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overscan {
    /// As much as the greatest CoC asks for, capped.
    Auto,
    /// As given, px.
    Pixels(u32),
}

fn pair<T: std::str::FromStr>(text: &str, separator: char) -> Option<[T; 2]> {
    let (a, b) = text.split_once(separator)?;
    Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
}

fn parse_range(text: &str) -> Result<Range, String> {
    let [near_m, far_m] = pair(text, ',').ok_or("give two distances in metres, such as 0.5,20")?;
    Ok(Range { near_m, far_m })
}

fn parse_calibration(text: &str) -> Result<Calibration, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[focal_px, baseline_m]) => Ok(Calibration { focal_px, baseline_m, offset_px: 0.0 }),
        Some(&[focal_px, baseline_m, offset_px]) => Ok(Calibration { focal_px, baseline_m, offset_px }),
        _ => Err("give a focal length in pixels and a baseline in metres, such as 1050,0.16".into()),
    }
}

fn parse_pixel(text: &str) -> Result<UVec2, String> {
    let [x, y] = pair(text, ',').ok_or("give a pixel from the top left corner, such as 320,240")?;
    Ok(uvec2(x, y))
}

pub fn parse_size(text: &str) -> Result<UVec2, String> {
    let [x, y] = pair(text, 'x').ok_or("give width and height in pixels, such as 1024x768")?;
    Ok(uvec2(x, y))
}

fn parse_fov(text: &str) -> Result<FieldOfView, String> {
    match text {
        "camera" => Ok(FieldOfView::Camera),
        "display" => Ok(FieldOfView::Display),
        _ => text.parse().map(FieldOfView::Degrees).map_err(|_| "give camera, display or degrees, such as 40".into()),
    }
}

fn parse_pose(text: &str) -> Result<Pose, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    let [x, y, z, qx, qy, qz, qw] = numbers[..] else {
        return Err("give a position and a quaternion, such as 0,1.5,4,0,0,0,1".into());
    };
    let (position, orientation) = (DVec3::new(x, y, z), DQuat::from_xyzw(qx, qy, qz, qw));
    if !(position.is_finite() && orientation.is_finite() && orientation.length() > 1e-6) {
        return Err("give finite numbers and a quaternion that is not 0".into());
    }
    // One that is a rotation already keeps its bits: a copied command draws the same picture.
    let orientation = if orientation.is_normalized() { orientation } else { orientation.normalize() };
    Ok(Pose { position, orientation })
}

fn parse_overscan(text: &str) -> Result<Overscan, String> {
    if text == "auto" {
        return Ok(Overscan::Auto);
    }
    text.parse().map(Overscan::Pixels).map_err(|_| "give auto or a number of pixels, such as 32".into())
}

pub fn parse_aperture(text: &str) -> Result<Aperture, String> {
    text.parse().map_err(|e: defocus::aperture::ApertureError| e.to_string())
}

fn parse_tone_map(text: &str) -> Result<ToneMap, String> {
    text.parse().map_err(|e: defocus::display::UnknownToneMap| e.to_string())
}

fn parse_ppd(text: &str) -> Result<f64, String> {
    let known = text.parse().ok().filter(|ppd| PX_PER_DEGREE.contains(ppd));
    known.ok_or_else(|| {
        format!("give pixels per degree from {} to {}, such as 25", PX_PER_DEGREE.start(), PX_PER_DEGREE.end())
    })
}

/// Beyond 64 EV either way every finite colour is black or white.
fn parse_exposure(text: &str) -> Result<f32, String> {
    let ev: f32 = text.parse().map_err(|_| "give a number of stops, such as -1.5")?;
    if ev.abs() <= 64.0 { Ok(ev) } else { Err("give a number of stops from -64 to 64".into()) }
}

/// A quality in JOD that something may have.
pub fn parse_jod(text: &str) -> Result<f64, String> {
    let known = text.parse().ok().filter(|jod| (0.0..=10.0).contains(jod));
    known.ok_or_else(|| "give JOD from 0 to 10, such as 9.5".into())
}
