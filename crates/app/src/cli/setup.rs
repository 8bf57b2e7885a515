//! From options to a view and a lens.

use super::options::{
    DepthKindName, DisplayOptions, FieldOfView, LensOptions, LightName, Overscan, SceneOptions, ShadingName,
    ViewOptions, open_gpu,
};
use anyhow::{Context, ensure};
use defocus::camera::Camera;
use defocus::display::{Display, ToneMap};
use defocus::gpu::{Gpu, Schedule};
use defocus::image::DepthImage;
use defocus::lens::{Lens, MM_PER_M};
use defocus::presets;
use defocus::scene::gltf::Lighting;
use defocus::scene::rgbd::{DepthEncoding, DepthKind};
use defocus::stereo::Layout;
use defocus::view::{Input, SurfaceOptions, Tone, View, auto_overscan_px};
use defocus::viewing::{Screen, Viewing};
use defocus_study::meter::{is_metered, view_exposure_ev};
use defocus_study::results::Setting;
use defocus_study::source::{default_focus_m, visibly_open};
use defocus_study::{DepthArgs, GpuSource, Source};
use glam::UVec2;

/// All that images are made with.
pub struct Setup {
    /// The source on the GPU.
    pub source: GpuSource,
    /// The camera's name.
    pub camera: String,
    /// The view, its overscan set.
    pub view: View,
    /// The lens, checked.
    pub lens: Lens,
    /// How colours are shown.
    pub display: Display,
    /// Under what angle and in what light they are looked at.
    pub viewing: Viewing,
    metered: Option<String>,
    input: Option<String>,
}

/// What makes a setup.
pub struct SetupOptions<'a> {
    pub scene: &'a SceneOptions,
    pub lens: &'a LensOptions,
    pub view: &'a ViewOptions,
    pub display: &'a DisplayOptions,
    pub adapter: Option<&'a str>,
    pub schedule: Option<Schedule>,
    /// Whether textures are mipmapped.
    pub mipmaps: bool,
    /// How two eyes' images share one, where there are two.
    pub stereo: Option<Layout>,
}

impl Setup {
    /// Checks the options, cheapest first, opens source and adapter, and sets the lens.
    pub fn new(options: &SetupOptions<'_>) -> anyhow::Result<Self> {
        check_fov(options.view.fov)?;
        let depth_args = depth_args(options.scene, options.view.fov)?;
        let preset = options.lens.lens.as_deref().map(presets::preset).transpose()?;
        let screen = options.display.screen(preset.and_then(|preset| preset.screen))?;
        // An E that is said outright and one that follows from light are the same from here on.
        let pupil_mm = options.lens.eye.pupil_mm(&screen)?;
        let lens_options = &Given { options: options.lens, pupil_mm, screen };
        let parts = lens_parts(lens_options)?;
        let spec = &options.scene.scene;
        let source = match options.scene.moment() {
            None => Source::open(spec, &depth_args)?,
            Some(moment) => Source::open_at(spec, &depth_args, &moment)?,
        };
        let source = source.lit(lighting(options.view.light));
        let camera = source.camera_index(&options.view.camera)?;
        check_overscan(options.view.overscan, &source)?;

        let gpu = open_gpu(options.adapter, options.schedule)?;
        let surfaces = SurfaceOptions { unlit: options.view.shading == ShadingName::Unlit, mipmaps: options.mipmaps };
        let uploaded = source.upload(&gpu, surfaces);
        let size = source.fitted_size(options.view.size.unwrap_or_else(|| source.default_size(camera)));
        let size = options.stereo.map_or(size, |layout| layout.eye_size(size));
        let mut view = uploaded.view(camera, size, 0, fov_y(options.view.fov, &parts, size))?;
        if let Some(pose) = options.view.pose {
            let camera = view
                .camera()
                .copied()
                .context("--pose moves the camera of a scene, and an image with depth has none: leave out --pose")?;
            view.set_camera(Camera { position: pose.position, orientation: pose.orientation, ..camera });
        }
        let depth = view.depth_m(&gpu);
        let lens = focused_and_open(lens_options, parts, &depth, &source)?;
        let is_camera = options.lens.f_number.is_some();
        let lens = if is_camera { of_camera(lens, view.projection().focal_px) } else { lens };
        lens.check()?;
        let overscan = match options.view.overscan {
            Overscan::Auto => auto_overscan(&source, &lens, &depth),
            Overscan::Pixels(px) => px,
        };
        if source.is_scene() {
            view.set_size(&gpu, size, overscan)?;
        }
        let camera = source.cameras()[camera].to_owned();
        let display = options.display.display();
        let viewing = Viewing::of(&lens, screen).with_ppd(options.display.ppd);
        let mut setup = Self { source: uploaded, camera, view, lens, display, viewing, metered: None, input: None };
        let is_unlit = options.view.shading == ShadingName::Unlit;
        if options.display.exposure.is_none() && !is_unlit && is_metered(spec, &source) {
            setup.meter()?;
        }
        Ok(setup)
    }

    /// Exposes a scene that would be white or black by its pinhole image.
    fn meter(&mut self) -> anyhow::Result<()> {
        let gpu = self.gpu();
        if let Some(ev) = view_exposure_ev(&gpu, &mut self.view, &self.lens)? {
            self.display.exposure_ev = ev;
            self.metered =
                Some(format!("exposure: {ev:+.1} EV, metered from the pinhole image (--exposure 0 for none)"));
        }
        Ok(())
    }

    /// From now on there is the pinhole image of the inner frame with its depth alone.
    pub fn show_as_image(&mut self) -> anyhow::Result<()> {
        let gpu = self.gpu();
        self.view = self.view.as_image(&gpu)?;
        Ok(())
    }

    /// From now on methods are given `input`; returns what becomes of a colour.
    pub fn give(&mut self, input: Input) -> anyhow::Result<Tone> {
        let maps_twice = matches!(input, Input::Reinhard { .. }) && self.display.tone_map != ToneMap::None;
        ensure!(!maps_twice, "--input reinhard maps tones before the blur: leave out --tonemap, which maps them again");
        if input != Input::Hdr {
            self.input = Some(format!("input: {input}"));
        }
        let gpu = self.gpu();
        Ok(self.view.set_input(&gpu, input))
    }

    /// The GPU.
    pub fn gpu(&self) -> Gpu {
        self.source.gpu().clone()
    }

    /// The depth of the inner frame, metres.
    pub fn depth_m(&mut self) -> std::sync::Arc<DepthImage> {
        self.view.depth_m(&self.gpu())
    }

    /// What goes to the head of every result.
    pub fn setting(&mut self) -> Setting {
        let depth = self.depth_m();
        let coc = self.lens.coc_statistics(depth.pixels.iter().copied());
        let source = self.source.source();
        let setting = Setting::new(self.source.gpu(), source.name(), &self.camera, self.view.size(), &self.lens, coc);
        Setting { notes: self.notes(), ..setting }
    }

    /// What was approximated, left out or filled in, one sentence each.
    pub fn notes(&self) -> Vec<String> {
        let eye = self.lens.eye.out_of_reach(1.0 / self.lens.focus_distance_m);
        self.source.source().notes().iter().chain(&self.metered).chain(&self.input).chain(&eye).cloned().collect()
    }
}

/// The lens of the camera that took the view, whose image plane lies `focal_px` pixels behind the
/// lens: there the focus distance is sharp, so that K = `focal_px` E / df, the CoC of Kraus (GRAPP
/// 2011, section 3) at infinity.
fn of_camera(lens: Lens, focal_px: f64) -> Lens {
    let (focal_mm, focus_mm) = (lens.focal_length_mm, lens.focus_distance_m * MM_PER_M);
    // 1/F = 1/df + 1/dr; at infinity the image plane is in the focal plane.
    let image_distance_mm = focal_mm / (1.0 - focal_mm / focus_mm);
    Lens { image_distance_mm, density_px_per_mm: focal_px / lens.screen_distance_mm, ..lens }
}

fn lighting(light: LightName) -> Lighting {
    match light {
        LightName::Auto => Lighting::Auto,
        LightName::File => Lighting::File,
        LightName::Studio => Lighting::Studio,
    }
}

fn depth_args(options: &SceneOptions, fov: FieldOfView) -> anyhow::Result<DepthArgs> {
    use DepthKindName::{Device, Dioptres, Disparity, Distance, Inverse, Metres, Relative};
    let kind = options.depth_kind;
    let (takes_range, takes_calibration) = (matches!(kind, Inverse | Relative | Device), kind == Disparity);
    ensure!(
        takes_range || options.depth_range.is_none(),
        "--depth-range goes with --depth-kind inverse, relative or device; the other kinds take --depth-scale"
    );
    ensure!(
        !takes_range || options.depth_scale.is_none(),
        "--depth-scale goes with --depth-kind metres, distance, dioptres or disparity; the others take --depth-range NEAR,FAR"
    );
    ensure!(
        takes_calibration || options.depth_calibration.is_none(),
        "--depth-calibration goes with --depth-kind disparity"
    );
    let range = || {
        options.depth_range.context(
            "--depth-kind inverse, relative and device need the depths that they lie between: give --depth-range NEAR,FAR",
        )
    };
    let per_unit = options.depth_scale.unwrap_or(1.0);
    let kind = match kind {
        Metres => DepthKind::Metres { per_unit },
        Distance => DepthKind::Distance { per_unit },
        Dioptres => DepthKind::Dioptres { per_unit },
        Inverse => DepthKind::Inverse { near_m: range()?.near_m, far_m: range()?.far_m },
        Relative => DepthKind::Relative { near_m: range()?.near_m, far_m: range()?.far_m },
        Device => DepthKind::Device { near_m: range()?.near_m, far_m: range()?.far_m },
        Disparity => {
            let given = options.depth_calibration.context(
                "--depth-kind disparity needs the cameras: give --depth-calibration FOCAL_PX,BASELINE_M[,OFFSET_PX]",
            )?;
            let (focal_px, baseline_m, offset_px) = (given.focal_px, given.baseline_m, given.offset_px);
            DepthKind::Disparity { focal_px, baseline_m, offset_px, per_unit }
        }
    };
    let encoding = DepthEncoding { kind, unknown: options.depth_unknown, infinity: options.depth_infinity };
    encoding.check()?;
    let fov_y = match fov {
        FieldOfView::Degrees(degrees) => Some(degrees.to_radians()),
        FieldOfView::Camera | FieldOfView::Display => None,
    };
    let (layer, depth_layer) = (options.layer.clone(), options.depth_layer.clone());
    let scene_scale = options.scene_scale;
    Ok(DepthArgs { file: options.depth.clone(), encoding, layer, depth_layer, fov_y, scene_scale })
}

/// What is said about the lens, with what follows from the display.
struct Given<'a> {
    options: &'a LensOptions,
    /// The pupil by light and age, mm, where E is to be that.
    pupil_mm: Option<f64>,
    screen: Screen,
}

impl Given<'_> {
    /// E, mm, if it is given in either way.
    fn aperture_diameter_mm(&self) -> Option<f64> {
        self.options.aperture_diameter_mm.or(self.pupil_mm).or_else(|| self.camera_aperture_mm())
    }

    /// E = F/N, mm, of a camera.
    fn camera_aperture_mm(&self) -> Option<f64> {
        Some(self.options.focal_length_mm? / self.options.f_number?)
    }
}

/// The lens without focus and, unless given, with a closed aperture; all other parts checked.
fn lens_parts(given: &Given<'_>) -> anyhow::Result<Lens> {
    let options = given.options;
    let preset = presets::preset(options.lens.as_deref().unwrap_or("projection"))?.lens;
    let given_diameter_mm = given.aperture_diameter_mm().or(options.lens.as_ref().map(|_| preset.aperture_diameter_mm));
    let lens = overridden(given, Lens { aperture_diameter_mm: given_diameter_mm.unwrap_or(0.0), ..preset });
    if let Some(n) = options.f_number {
        ensure!(n.is_finite() && n > 0.0, "--f-number is {n}; give a finite number above 0, such as 2.8");
    }
    let unfocused = options.focus.is_none();
    Lens { focus_distance_m: if unfocused { f64::INFINITY } else { lens.focus_distance_m }, ..lens.clone() }.check()?;
    if let Some(px) = options.mean_coc {
        ensure!(px.is_finite() && px >= 0.0, "--mean-coc is {px} px; give a finite number of 0 or more");
    }
    Ok(lens)
}

/// `lens` with what the options say in place of its own.
fn overridden(given: &Given<'_>, lens: Lens) -> Lens {
    let options = given.options;
    Lens {
        aperture_diameter_mm: given.aperture_diameter_mm().unwrap_or(lens.aperture_diameter_mm),
        focal_length_mm: options.focal_length_mm.unwrap_or(lens.focal_length_mm),
        image_distance_mm: options.image_distance_mm.unwrap_or(lens.image_distance_mm),
        screen_distance_mm: options.screen_distance_mm.unwrap_or(lens.screen_distance_mm),
        density_px_per_mm: options.density_px_per_mm.unwrap_or(lens.density_px_per_mm),
        focus_distance_m: options.focus.unwrap_or(lens.focus_distance_m),
        aperture: options.aperture.clone().unwrap_or(lens.aperture),
        eye: options.eye.overridden(lens.eye, &given.screen),
    }
}

/// The margin that a source is made for, with the lens that it is made for; else what the
/// greatest CoC in view asks for.
fn auto_overscan(source: &Source, lens: &Lens, depth: &DepthImage) -> u32 {
    let made_for = source.made_for().filter(|made_for| made_for.lens_at(depth.size.y) == *lens);
    made_for.map_or_else(|| auto_overscan_px(lens, depth), |made_for| made_for.overscan_px_at(depth.size.y))
}

fn focused_and_open(given: &Given<'_>, parts: Lens, depth: &DepthImage, source: &Source) -> anyhow::Result<Lens> {
    let options = given.options;
    // Only a lens that nobody chose is focused and opened by what is in view.
    let made_for = source.made_for().filter(|_| options.lens.is_none());
    let free = options.lens.is_none() && made_for.is_none();
    let mut lens = made_for.map_or(parts, |made_for| overridden(given, made_for.lens_at(depth.size.y)));
    if let Some(at) = options.focus_at {
        lens.focus_distance_m = depth_under(depth, at)?;
    } else if options.focus.is_none() && free {
        lens.focus_distance_m = default_focus_m(depth, source.focus_hint_m()).unwrap_or(lens.focus_distance_m);
        if options.focal_length_mm.is_none() {
            // A scene a few centimetres wide is nearer than an eye's focal length.
            lens.focal_length_mm = lens.focal_length_mm.min(0.5 * lens.focus_distance_m * MM_PER_M);
        }
    }
    if let Some(px) = options.mean_coc {
        lens = lens.with_mean_coc(px, depth.pixels.iter().copied()).context(
            "--mean-coc: all of the image lies at the focus distance, so that no aperture blurs it; choose another --focus",
        )?;
    } else if given.aperture_diameter_mm().is_none() && free {
        lens = visibly_open(lens, depth);
    }
    lens.check()?;
    Ok(lens)
}

fn depth_under(depth: &DepthImage, at: UVec2) -> anyhow::Result<f64> {
    ensure!(
        at.cmplt(depth.size).all(),
        "--focus-at {},{} lies outside the image of {}x{} px; count from 0 at the top left",
        at.x,
        at.y,
        depth.size.x,
        depth.size.y
    );
    Ok(f64::from(depth.at(at.x, at.y)))
}

fn check_fov(fov: FieldOfView) -> anyhow::Result<()> {
    if let FieldOfView::Degrees(degrees) = fov {
        ensure!(degrees > 0.0 && degrees < 180.0, "--fov is {degrees} degrees; give more than 0 and less than 180");
    }
    Ok(())
}

fn check_overscan(overscan: Overscan, source: &Source) -> anyhow::Result<()> {
    ensure!(
        source.is_scene() || matches!(overscan, Overscan::Auto | Overscan::Pixels(0)),
        "an image with depth ends at its border and has no overscan; leave out --overscan or set it to 0"
    );
    Ok(())
}

/// The full vertical field of view, radians, that replaces the camera's.
fn fov_y(fov: FieldOfView, lens: &Lens, size: UVec2) -> Option<f64> {
    match fov {
        FieldOfView::Camera => None,
        FieldOfView::Degrees(degrees) => Some(degrees.to_radians()),
        FieldOfView::Display => {
            let tan_half_x = (0.5 * lens.display_fov_x(size.x)).tan();
            Some(2.0 * (tan_half_x * f64::from(size.y) / f64::from(size.x)).atan())
        }
    }
}
