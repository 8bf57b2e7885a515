//! How work on tiles of several kinds is dispatched.

use super::device::SOFTWARE;
use std::str::FromStr;

/// How the tiles of an image that need different work get it. Pictures are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// Lists of tiles, made by the GPU, and a dispatch a list whose grid is as long: nothing
    /// runs where it is not needed. For software adapters, which pay for every workgroup.
    TileLists,
    /// Dispatches over all tiles, where each workgroup looks at its tile first: no atomic
    /// counts, and no grid that waits for another dispatch. For hardware.
    Branches,
}

/// Not the name of a [`Schedule`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no schedule '{}'; there are: lists, branches", .0.escape_debug())]
pub struct ParseScheduleError(String);

impl Schedule {
    /// What suits an adapter of this [`kind`](super::AdapterSummary::kind).
    pub(super) fn of(kind: &str) -> Self {
        if kind == SOFTWARE { Self::TileLists } else { Self::Branches }
    }
}

impl FromStr for Schedule {
    type Err = ParseScheduleError;

    /// "lists" or "branches".
    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "lists" => Ok(Self::TileLists),
            "branches" => Ok(Self::Branches),
            _ => Err(ParseScheduleError(name.into())),
        }
    }
}

impl std::fmt::Display for Schedule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::TileLists => "lists",
            Self::Branches => "branches",
        })
    }
}
