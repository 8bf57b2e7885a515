//! What the window shows, kept up to date: renders when something it depends on changed
//! and does nothing when nothing did. Knows the library, not the user interface.

mod activity;
mod beside;
mod device_errors;
mod errand;
mod figures;
mod flight;
mod history;
mod identity;
mod inside;
mod kernel;
mod lane;
mod learning;
mod measuring;
mod milestone;
mod pace;
mod pane;
mod progress;
mod reading;
mod recording;
mod renderer;
mod request;
mod schedule;
mod story;
mod tempo;
mod values;
mod views;
mod wake;
mod warm;

pub use activity::Activity;
pub use errand::PassTimes;
pub use figures::{Figures, Measured, PaneMetrics};
pub(super) use history::FRAMES_KEPT;
pub use history::{History, Quantiles};
pub use identity::{Identity, Pairing};
pub use kernel::{Kernel, KernelOf, MeasuredKernel};
pub use pane::Pane;
pub use reading::Reading;
pub(super) use reading::channel_of;
pub use renderer::Engine;
pub use request::{DisplaySettings, RenderRequest, Request};
pub use story::{Story, StoryLine};
pub use tempo::{DISPLAY_INTERVAL_MS, Tempo};
pub use wake::Wake;
pub use warm::FrameTime;
