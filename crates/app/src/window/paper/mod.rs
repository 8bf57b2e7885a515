//! Figures for a paper: pictures, details, error maps, plots and tables of the chosen panes in one
//! folder, with a caption that has every parameter and a README that repeats them.

mod caption;
mod form;
mod write;

pub use form::PaperForm;
