//! The tiles in which panes lie.

use super::pane_id::PaneId;

/// Tiles of panes.
pub type PaneTree = egui_tiles::Tree<PaneId>;
