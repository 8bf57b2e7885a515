//! Numbers that can be saved.

/// Numbers that can be saved for other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// Figures of all panes, a line each.
    FiguresCsv,
    /// The same with the whole state.
    FiguresJson,
    /// The curve of CoC against depth.
    Coc,
    /// What a batch has measured.
    Batch,
}

impl Numbers {
    /// What its dialog says, how its file is called, and what that ends with.
    pub fn about(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::FiguresCsv => ("Save all figures as CSV", "figures", "csv"),
            Self::FiguresJson => ("Save all figures as JSON, with the state", "figures", "json"),
            Self::Coc => ("Save CoC against depth as CSV", "coc", "csv"),
            Self::Batch => ("Save the batch as CSV", "batch", "csv"),
        }
    }
}
