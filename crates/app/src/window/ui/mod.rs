//! Parts of the interface as functions over the model and over what the engine tells, which say
//! what was changed. They do not know the window: it applies what they say.

pub mod details;
pub mod groups;
mod named;
pub mod panels;
pub mod style;
pub mod timing;
pub mod widgets;
