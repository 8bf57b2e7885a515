//! What decides where the lens is focused.

use defocus::focus::ACCOMMODATION_SECONDS;

/// What decides where the lens is focused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum FocusMode {
    /// A click: the depth of the pixel under the pointer.
    #[default]
    Point,
    /// A click: the median depth around it.
    Area,
    /// A click: the surface there, which stays in focus while the camera moves.
    Object,
    /// The pointer, as a stand-in for the gaze, followed as an eye does.
    Gaze,
    /// The middle of the picture, followed as an eye does.
    Centre,
}

impl FocusMode {
    /// All, with their names and what they do.
    pub const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Point, "Point clicked", "Click what should be sharp."),
        (Self::Area, "Area clicked", "Click what should be sharp: the median depth around it counts."),
        (Self::Object, "Object clicked", "Click an object: it stays sharp while the camera moves."),
        (Self::Gaze, "Follow pointer", "The pointer stands for the gaze; the focus follows as an eye accommodates."),
        (Self::Centre, "Autofocus", "What lies in the middle is sharp; the focus follows as an eye accommodates."),
    ];

    /// Whether the focus moves by itself, without a click.
    pub fn follows(self) -> bool {
        matches!(self, Self::Gaze | Self::Centre)
    }
}

/// How focus is chosen; plain data.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct FocusSettings {
    /// What decides.
    pub mode: FocusMode,
    /// The area reaches so many pixels in each direction from its middle.
    pub area_radius_px: u32,
    /// Time constant of the eye, seconds; 0 for an eye without lag.
    pub time_constant_s: f64,
}

impl Default for FocusSettings {
    fn default() -> Self {
        Self { mode: FocusMode::Point, area_radius_px: 4, time_constant_s: ACCOMMODATION_SECONDS }
    }
}

impl FocusSettings {
    /// Greatest radius of the area, px: a square of 513 px.
    const GREATEST_RADIUS_PX: u32 = 256;

    /// The same with what a file could have wrong put right.
    pub fn repaired(self) -> Self {
        let time_constant_s = match self.time_constant_s {
            t if t.is_finite() => t.clamp(0.0, 60.0),
            _ => ACCOMMODATION_SECONDS,
        };
        Self { time_constant_s, area_radius_px: self.area_radius_px.min(Self::GREATEST_RADIUS_PX), ..self }
    }

    /// Radius, px, over which depths are taken: 0 where a single pixel decides.
    pub fn radius_px(&self) -> u32 {
        if self.mode == FocusMode::Point { 0 } else { self.area_radius_px }
    }
}
