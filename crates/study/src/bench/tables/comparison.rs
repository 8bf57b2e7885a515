//! A paper's table beside what was measured here.

use serde::Serialize;

/// A table beside its measurement.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Which table, of which paper, and what it is about.
    pub title: String,
    /// What was measured, on what, and what stands in for the paper's scenes.
    pub setting: String,
    /// Column heads; the first is of the rows' names.
    pub columns: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<String>>,
    /// What the paper says, and what is measured of it.
    pub claims: Vec<Claim>,
    /// Why the two differ, and how to read the numbers.
    pub notes: Vec<String>,
}

/// Something that a paper says.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// What it says.
    pub paper: String,
    /// What was measured.
    pub measured: String,
    /// Whether that agrees; `None` where it could not be measured.
    pub holds: Option<bool>,
    /// Why not, if it does not.
    pub reason: String,
}
