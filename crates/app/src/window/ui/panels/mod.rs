//! The panels beside the picture: functions over plain state that say what was changed.
//!
//! They know the library and egui, not the rest of the window: a test drives each alone,
//! without a GPU.

mod animation;
mod aperture;
mod batch;
mod eye;
mod fields;
mod focus;
mod inspector;
mod kernel;
mod lens;
mod lesson;
mod paper;
mod plot;
mod presets;
mod scale;
mod story;
mod strip;
mod vr;

pub use animation::{AnimationAction, AnimationView, animation_bar};
pub use aperture::{ApertureChange, aperture_panel};
pub use batch::{BatchAction, BatchCells, BatchView, batch_panel};
pub use eye::eye_panel;
pub(in crate::window) use fields::fit_slider;
pub use fields::{Field, distance_text};
pub use focus::{Focusing, Follow, focus_panel};
pub use inspector::{Inspection, PaneValue, image_histogram, inspector_panel, neighbourhood};
pub use kernel::{KernelView, kernel_panel};
pub use lens::{LensChanges, LensPanel, LensReadings, OPTICS};
pub use lesson::{LessonAction, LessonView, lesson_card};
pub use paper::{PaperAction, PaperView, paper_form};
pub use plot::{PlotReadings, coc_plot};
pub use presets::{PresetList, preset_label};
pub use scale::{ScaleAction, ScaleView, scale_offer};
pub use story::story_panel;
pub use strip::{StripAction, StripView, strip};
pub use vr::{VrAction, VrReadings, refresh_text, vr_panel};
