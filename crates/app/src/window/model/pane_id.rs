//! What a pane is called.

/// Number of a pane, which stays its own while panes come and go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct PaneId(pub u32);

impl PaneId {
    /// The reference that converges where no pane shows it.
    pub const HIDDEN: Self = Self(u32::MAX);
}

impl std::fmt::Display for PaneId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}
