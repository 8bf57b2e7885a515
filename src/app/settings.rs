//! All of the user's choices in one value: what is saved, restored and undone.

use crate::camera::Camera;
use crate::display::Display;
use crate::lens::Lens;
use crate::methods::{self, Method};
use std::collections::BTreeMap;

/// Most methods shown at once.
pub const MAX_PANES: usize = 2;

/// What the user has chosen; plain data, apart from everything computed from it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Settings {
    /// A built-in name or a file, as [`crate::study::Source::open`] takes it.
    pub scene: String,
    /// Which of the scene's cameras was chosen last.
    pub camera_index: usize,
    /// The camera as it was moved since; `None` until a scene is there, and for images.
    pub camera: Option<Camera>,
    /// Distance from the camera of the point it orbits, metres.
    pub pivot_m: f64,
    /// The lens.
    pub lens: Lens,
    /// Whether E, F, dr, ds and DPI follow each newly opened scene, which is so until the
    /// user sets one of them.
    pub automatic_lens: bool,
    /// The methods shown, 1 to `MAX_PANES`.
    pub methods: Vec<MethodChoice>,
    /// Where the divider between two methods stands, from 0 (left) to 1.
    pub divider: f32,
    /// Exposure and tone map.
    pub display: Display,
    /// What is shown: the picture or something behind it.
    pub show: Show,
    /// |c| up to which a point counts as sharp, px.
    pub acceptable_coc_px: f32,
    /// |c| at the ends of the CoC's colour map, px.
    pub coc_scale_px: f32,
    /// Whether focus moves smoothly to where one clicks.
    pub smooth_focus: bool,
    /// What dragging does to the camera.
    pub navigation: Navigation,
    /// Margin drawn around the picture so that blur can come in from outside, px.
    pub overscan_px: u32,
    /// Light, dark, or as the system has it.
    pub theme: Theme,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            scene: "cans".into(),
            camera_index: 0,
            camera: None,
            pivot_m: 1.0,
            lens: Lens::PINHOLE,
            automatic_lens: true,
            methods: vec![MethodChoice::new("mipmap")],
            divider: 0.5,
            display: Display::default(),
            show: Show::Picture,
            acceptable_coc_px: 2.0,
            coc_scale_px: 32.0,
            smooth_focus: true,
            navigation: Navigation::Orbit,
            overscan_px: 32,
            theme: Theme::System,
        }
    }
}

impl Settings {
    /// The same with what a file could have wrong put right: at least one pane and at most
    /// `MAX_PANES`, the divider inside the picture.
    pub fn repaired(mut self) -> Self {
        self.methods.truncate(MAX_PANES);
        if self.methods.is_empty() {
            self.methods = Self::default().methods;
        }
        self.divider = if self.divider.is_nan() { 0.5 } else { self.divider.clamp(0.0, 1.0) };
        self
    }
}

/// A method with those of its parameters that differ from their defaults.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct MethodChoice {
    /// [`methods::About::id`].
    pub id: String,
    /// Values by key, as text that [`methods::set_param`] takes.
    #[serde(default)]
    pub params: BTreeMap<String, String>,
}

impl MethodChoice {
    /// The method with its default parameters.
    pub fn new(id: &str) -> Self {
        Self { id: id.into(), params: BTreeMap::new() }
    }

    /// The method itself.
    ///
    /// # Errors
    ///
    /// A sentence, if there is no such method or parameter: settings come from files too.
    pub fn build(&self) -> Result<Box<dyn Method>, String> {
        let mut method = methods::by_id(&self.id).map_err(|e| e.to_string())?;
        for (key, text) in &self.params {
            methods::set_param(method.as_mut(), key, text).map_err(|e| e.to_string())?;
        }
        Ok(method)
    }
}

/// What the viewport shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Show {
    /// The methods' pictures.
    #[default]
    Picture,
    /// The signed CoC.
    Coc,
    /// Depth.
    Depth,
    /// Which part is sharp.
    Zone,
    /// The difference between the two methods.
    Difference,
}

impl Show {
    /// All, with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Picture, "Picture"),
        (Self::Coc, "Circle of confusion"),
        (Self::Depth, "Depth"),
        (Self::Zone, "Depth of field"),
        (Self::Difference, "Difference"),
    ];
}

/// What dragging does to the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Navigation {
    /// It moves around what it looks at.
    #[default]
    Orbit,
    /// It turns where it is.
    Fly,
}

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Theme {
    /// As the system has it.
    #[default]
    System,
    /// Dark on light.
    Light,
    /// Light on dark.
    Dark,
}
