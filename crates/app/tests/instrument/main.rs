//! The window as an instrument: what it shows is what it says it is, however it is laid out
//! and however long a method takes.

#![cfg(feature = "window")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../../../../tests/tiny_files/mod.rs"]
mod tiny_files;

mod animation;
mod class;
mod fields;
mod figures;
mod kernel;
mod labels;
mod opening;
mod pace;
mod panel;
mod paper;
mod saved;
mod size;
mod story;

use common::window::Window;
use egui_kittest::kittest::NodeT;

/// All that is written in the window.
fn texts(window: &Window) -> Vec<String> {
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    nodes.filter_map(|node| node.value().or(node.label())).collect()
}

/// Whether one of the texts contains a part.
fn says(window: &Window, part: &str) -> bool {
    texts(window).iter().any(|text| text.contains(part))
}
