//! What belongs to the person at the window and not to the picture in it: kept from one
//! session to the next and left alone by undo.

use super::units::DistanceUnit;
use defocus::presets::LensPreset;
use std::path::{Path, PathBuf};

/// Files that are remembered.
const MAX_RECENT: usize = 10;

/// The person's own choices.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Whether focus moves smoothly to where one clicks.
    pub smooth_focus: bool,
    /// What dragging does to the camera.
    pub navigation: Navigation,
    /// Light, dark, or as the system has it.
    pub theme: Theme,
    /// Unit of the focus distance.
    pub distance_unit: DistanceUnit,
    /// Whether the lens's display is given by field of view and resolution.
    pub display_by_view: bool,
    /// Lenses saved under a name.
    pub own_lenses: Vec<LensPreset>,
    /// Files opened before, the last first.
    pub recent: Vec<PathBuf>,
    /// Whether the shaders are watched while the program runs from its source tree.
    pub reload_shaders: bool,
    /// Whether only the picture is shown, with a strip of aperture and focus.
    pub panels_hidden: bool,
    /// Parts of the panel beside the picture that are unfolded at first, beside those that
    /// always are.
    pub open_groups: Vec<String>,
    /// Size of the interface, as a multiple of the normal one.
    pub ui_scale: f32,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            smooth_focus: true,
            navigation: Navigation::Orbit,
            theme: Theme::System,
            distance_unit: DistanceUnit::default(),
            display_by_view: false,
            own_lenses: Vec::new(),
            recent: Vec::new(),
            reload_shaders: false,
            panels_hidden: false,
            open_groups: Vec::new(),
            ui_scale: 1.0,
        }
    }
}

impl Preferences {
    /// Changes what `preference` names.
    pub fn apply(&mut self, preference: Preference) {
        match preference {
            Preference::DistanceUnit(unit) => self.distance_unit = unit,
            Preference::DisplayByView(is_by_view) => self.display_by_view = is_by_view,
            Preference::OwnLenses(lenses) => self.own_lenses = lenses,
            Preference::Navigation(navigation) => self.navigation = navigation,
            Preference::SmoothFocus(is_smooth) => self.smooth_focus = is_smooth,
            Preference::Theme(theme) => self.theme = theme,
        }
    }

    /// Puts a file first among those opened.
    pub fn remember(&mut self, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        self.recent.retain(|known| *known != file);
        self.recent.insert(0, file);
        self.recent.truncate(MAX_RECENT);
    }
}

/// A change of one choice, as a panel asks for it.
#[derive(Clone, Debug, PartialEq)]
pub enum Preference {
    /// Unit of the focus distance.
    DistanceUnit(DistanceUnit),
    /// Whether the lens's display is given by field of view and resolution.
    DisplayByView(bool),
    /// Lenses saved under a name.
    OwnLenses(Vec<LensPreset>),
    /// What dragging does to the camera.
    Navigation(Navigation),
    /// Whether focus moves smoothly to where one clicks.
    SmoothFocus(bool),
    /// Light, dark, or as the system has it.
    Theme(Theme),
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
