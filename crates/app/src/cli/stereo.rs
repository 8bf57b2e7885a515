//! `--stereo`: two eyes' images as one.

use super::setup::Setup;
use anyhow::{Context, ensure};
use clap::Args;
use defocus::display::Display;
use defocus::gpu::FrameStats;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::stereo::{Layout, MEAN_IPD_MM, Stereo};
use defocus_study::Rendered;
use serde_json::{Map, Value};
use std::sync::Arc;

/// Two eyes.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Two eyes")]
pub struct StereoOptions {
    /// Both eyes' images as one of --size: side by side (parallel; crossed has the left eye's on the
    /// right), or an anaglyph or grey-anaglyph for red and cyan glasses
    #[arg(long = "stereo", value_name = "LAYOUT", value_parser = parse_layout)]
    pub layout: Option<Layout>,
    /// Distance of the eyes, mm
    #[arg(long, value_name = "MM", default_value_t = MEAN_IPD_MM, value_parser = parse_ipd, requires = "layout", allow_hyphen_values = true)]
    pub ipd_mm: f64,
    /// Depth, metres, of the window that both eyes look through: what lies there has no disparity
    #[arg(long = "stereo-window", value_name = "M|inf", default_value = "inf", value_parser = parse_window, requires = "layout", allow_hyphen_values = true)]
    pub window_m: f64,
}

impl StereoOptions {
    /// Where the eyes are and how their images are put together, if there are two.
    pub fn stereo(&self) -> Option<Stereo> {
        self.layout.map(|layout| Stereo { layout, ipd_mm: self.ipd_mm, window_m: self.window_m })
    }
}

/// An image with what belongs to its pixels.
pub struct Picture {
    /// The method's parameters.
    pub params: Map<String, Value>,
    /// The image, and what it cost.
    pub rendered: Rendered,
    /// Its depth.
    pub depth_m: Arc<DepthImage>,
    /// How its colours are shown.
    pub display: Display,
}

/// What draws the view of a setup.
pub type Draw<'a> = dyn FnMut(&mut Setup) -> anyhow::Result<(Map<String, Value>, Rendered)> + 'a;

impl Picture {
    /// What one eye sees.
    pub fn of_one(setup: &mut Setup, display: Display, draw: &mut Draw<'_>) -> anyhow::Result<Self> {
        let (params, rendered) = draw(setup)?;
        Ok(Self { params, rendered, depth_m: setup.depth_m(), display })
    }

    /// What both eyes see, the middle between them being the setup's camera.
    pub fn of_two(setup: &mut Setup, stereo: Stereo, display: Display, draw: &mut Draw<'_>) -> anyhow::Result<Self> {
        let missing =
            "--stereo needs a scene: what a second eye sees of an image with depth is unknown; leave out --stereo";
        let middle = setup.view.camera().copied().context(missing)?;
        let [left, right] = stereo.eyes(&middle);
        let mut eye = |camera| {
            setup.view.set_camera(camera);
            Self::of_one(setup, display, draw)
        };
        let (left, right) = (eye(left)?, eye(right)?);
        setup.view.set_camera(middle);
        Ok(left.beside(right, stereo.layout))
    }

    fn beside(self, right: Self, layout: Layout) -> Self {
        let passes = [("left", self.rendered.passes), ("right", right.rendered.passes)];
        let named = |eye: &str, mut pass: defocus::gpu::PassTime| {
            pass.label = format!("{eye} eye/{}", pass.label);
            pass
        };
        let passes = passes.into_iter().flat_map(|(eye, passes)| passes.into_iter().map(move |p| named(eye, p)));
        let (l, r) = (&self.rendered.color, &right.rendered.color);
        let (color, display) = match layout.is_side_by_side() {
            true => (layout.side_by_side(l, r), self.display),
            false => (anaglyph(l, r, layout, self.display), Display::default()),
        };
        let depth_m = match layout.is_side_by_side() {
            true => Arc::new(layout.side_by_side(&self.depth_m, &right.depth_m)),
            false => self.depth_m,
        };
        let stats = sum(self.rendered.stats, &right.rendered.stats);
        Self { params: self.params, rendered: Rendered { color, passes: passes.collect(), stats }, depth_m, display }
    }
}

/// Linear display values of an anaglyph.
fn anaglyph(left: &ColorImage, right: &ColorImage, layout: Layout, display: Display) -> ColorImage {
    let (left, right) = (display.linear_image(left), display.linear_image(right));
    Image::from_fn(left.size, |x, y| layout.anaglyph(left.at(x, y), right.at(x, y)))
}

fn sum(mut a: FrameStats, b: &FrameStats) -> FrameStats {
    a.triangles += b.triangles;
    a.views += b.views;
    a.passes += b.passes;
    a.peak_texture_bytes = a.peak_texture_bytes.max(b.peak_texture_bytes);
    for (what, times) in &b.skipped {
        *a.skipped.entry(what.clone()).or_default() += times;
    }
    a
}

/// Errors where an image of that layout cannot be kept as linear light.
pub fn check_linear(stereo: Option<Stereo>) -> anyhow::Result<()> {
    let is_light = stereo.is_none_or(|stereo| stereo.layout.is_side_by_side());
    ensure!(
        is_light,
        "an anaglyph is made of what a display shows, and EXR holds linear light: give a name that ends in .png, or --stereo parallel"
    );
    Ok(())
}

fn parse_layout(text: &str) -> Result<Layout, String> {
    text.parse().map_err(|e: defocus::stereo::UnknownLayout| e.to_string())
}

fn parse_ipd(text: &str) -> Result<f64, String> {
    let known = text.parse().ok().filter(|mm| (0.0..=Stereo::MOST_IPD_MM).contains(mm));
    known.ok_or_else(|| format!("give millimetres from 0 to {}, such as 63", Stereo::MOST_IPD_MM))
}

fn parse_window(text: &str) -> Result<f64, String> {
    let known = text.parse().ok().filter(|m| *m >= Stereo::NEAREST_WINDOW_M);
    known.ok_or_else(|| format!("give metres from {} on, or inf", Stereo::NEAREST_WINDOW_M))
}
