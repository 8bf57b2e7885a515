//! A pane: its method and what it shows of it.

use super::method::MethodChoice;
use super::pane_id::PaneId;
use super::show::Show;

/// A pane: a method and which of its aspects to show.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PaneState {
    /// Its number.
    pub id: PaneId,
    /// The method.
    pub method: MethodChoice,
    /// What of it is shown.
    #[serde(default)]
    pub show: Show,
    /// How much an overlay hides of the picture, from 0 to 1: the overlay alone.
    #[serde(default = "default_opacity")]
    pub opacity: f32,
}

/// Enough to tell colours apart, and little enough to find one's way in the picture.
pub const DEFAULT_OPACITY: f32 = 0.6;

fn default_opacity() -> f32 {
    DEFAULT_OPACITY
}

impl PaneState {
    /// A pane that shows the method's picture.
    pub fn new(id: PaneId, method: MethodChoice) -> Self {
        Self { id, method, show: Show::Picture, opacity: DEFAULT_OPACITY }
    }
}
