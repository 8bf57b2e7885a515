//! Groups of the panel: functions over what is shown and over what the engine tells, which return
//! what is to be done. The window does it; undo, keys and tests go through the same door.

mod aperture;
mod eye;
mod lens;
mod method;
mod pane;
mod stereo;
mod view;

pub use aperture::{ApertureView, aperture_group};
pub use eye::eye_group;
pub use lens::{LensView, lens_group};
pub use method::method_group;
pub use pane::{difference_edit, inside_edits};
pub use stereo::stereo_group;
pub use view::{PanelView, view_group};
