//! What goes into figures for a paper.

use super::pane_id::PaneId;

/// A choice of panes and contents, and the folder they go to.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperChoice {
    /// Panes that do not go in.
    pub left_out: Vec<PaneId>,
    /// Whether a part of each picture is shown magnified.
    pub details: bool,
    /// Whether there are maps of the error.
    pub maps: bool,
    /// Whether there are plots.
    pub plots: bool,
    /// Whether there are tables.
    pub table: bool,
    /// Where they go.
    pub folder: String,
}

impl PaperChoice {
    /// Everything, into `folder`.
    pub fn into_folder(folder: String) -> Self {
        Self { left_out: Vec::new(), details: true, maps: true, plots: true, table: true, folder }
    }
}
