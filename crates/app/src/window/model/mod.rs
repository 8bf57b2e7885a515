//! What the window shows and what belongs to the person at it: plain data that is saved,
//! restored and undone. Imports nothing of the engine or the interface.

mod batch;
mod document;
mod edit;
mod focus;
mod lens;
mod lessons;
mod limits;
mod method;
mod moment;
pub(super) mod numbers;
mod numbers_kind;
mod pane;
mod pane_id;
mod pane_tree;
mod paper;
mod picture_kind;
mod preferences;
mod show;
mod size;
pub(super) mod state;
mod tiles;
mod ui_scale;
mod units;

pub use batch::{BatchRow, MOST_BATCH_ROWS};
pub use document::{Arrangement, Document, MAX_PANES, Zoom};
pub use edit::{Edit, EyeSettings, ViewSettings};
pub use focus::{FocusMode, FocusSettings};
pub use lens::same_but_focus;
pub use lessons::{LESSONS, Lesson, Optics};
pub use limits::{aperture_limit, astigmatism_limit};
pub use method::{MethodChoice, REFERENCE_SAMPLES};
pub use moment::Moment;
pub use numbers_kind::Numbers;
pub use pane::{DEFAULT_OPACITY, PaneState};
pub use pane_id::PaneId;
pub use pane_tree::PaneTree;
pub use paper::PaperChoice;
pub use picture_kind::PictureKind;
pub use preferences::{Navigation, Preference, Preferences, Theme};
pub use show::{Channel, Difference, DifferenceKind, Inside, Show};
pub use size::{GREATEST_SIDE_PX, LEAST_SIDE_PX, PictureSize};
pub(super) use tiles::tree_of;
pub use ui_scale::{UI_SCALES, scale_name};
pub use units::DistanceUnit;
