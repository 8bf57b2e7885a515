//! No name is cut where the window is as small as a projector or an old laptop.

use crate::common::window::{Window, settle, window_with};
use defocus_app::window::{Action, AppOptions, Document, MethodChoice, PaneId, PictureSize};
use eframe::egui::{Color32, FontId, Role};
use egui_kittest::kittest::NodeT;

/// What a text may be wider than its place by, points: places are rounded to pixels.
const SLACK: f32 = 1.5;

/// Text sizes of the window, points, and the heights of their lines.
const SIZES: [(f32, f32); 3] = [(11.0, 14.5), (13.0, 18.0), (15.0, 22.0)];

/// Room that the arrow of a list and its margins take, points.
const LIST_FRAME: f32 = 30.0;

/// Texts that do not fit into their places. A line of text is as high as its size asks, which is
/// how its size is known.
fn cut(window: &Window) -> Vec<String> {
    let adapter = window.state().engine().gpu().adapter().name.clone();
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    let mut found = Vec::new();
    for node in nodes.filter(|node| !node.is_hidden()) {
        let (text, frame) = match node.role() {
            Role::Label => (node.value().or(node.label()), 0.0),
            Role::ComboBox => (node.value(), LIST_FRAME),
            _ => continue,
        };
        let (Some(text), Some(bounds)) = (text, node.raw_bounds()) else { continue };
        // The adapter's name stands at the end of the line, with all of it in the tooltip.
        if text == adapter || text.contains('\n') {
            continue;
        }
        let (width, height) = ((bounds.x1 - bounds.x0) as f32, (bounds.y1 - bounds.y0) as f32);
        let line =
            if frame > 0.0 { Some(13.0) } else { SIZES.iter().find(|(_, h)| height <= *h).map(|(size, _)| *size) };
        let Some(size) = line else { continue };
        let wanted = window
            .ctx
            .fonts_mut(|fonts| fonts.layout_no_wrap(text.clone(), FontId::proportional(size), Color32::WHITE).size().x);
        if wanted + frame > width + SLACK {
            found.push(format!("{:?} “{text}”: {wanted:.0} + {frame:.0} points in {width:.0}", node.role()));
        }
    }
    found
}

/// Inputs that reach beyond the window.
fn outside(window: &Window) -> Vec<String> {
    let right = f64::from(window.ctx.content_rect().right());
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    let inputs = nodes.filter(|n| [Role::SpinButton, Role::ComboBox, Role::Slider, Role::CheckBox].contains(&n.role()));
    let outside = inputs.filter(|node| node.raw_bounds().is_some_and(|bounds| bounds.x1 > right - 8.0));
    outside.map(|node| format!("{:?} {:?}", node.role(), node.label())).collect()
}

#[test]
fn no_name_is_cut_at_1280_by_720() {
    let choices = defocus::methods::all();
    let about: Vec<_> =
        choices.iter().map(|m| m.about()).filter(|a| !["raytrace", "accumulation"].contains(&a.id)).collect();
    let document = Document {
        size: PictureSize::Pixels(32, 24),
        ..Document::of_methods([MethodChoice::new("mipmap"), MethodChoice::new("pinhole")])
    };
    let mut window = window_with([1280.0, 720.0], AppOptions { document: Some(document), ..AppOptions::default() });
    for group in ["Aperture", "Eye and display", "Stereo and headsets", "Inspector"] {
        use egui_kittest::kittest::Queryable;
        window.get_by_label(group).scroll_to_me();
        window.run_steps(3);
        window.get_by_label(group).click();
        window.run_steps(3);
    }
    for about in about {
        let ctx = window.ctx.clone();
        window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), about.id.into()));
        settle(&mut window);
        let found = [cut(&window), outside(&window)].concat();
        assert!(found.is_empty(), "{}: {found:#?}", about.id);
    }
    let ctx = window.ctx.clone();
    for index in 0..6 {
        window.state_mut().perform(&ctx, Action::SetShow(PaneId(1), index));
        settle(&mut window);
        let found = cut(&window);
        assert!(found.is_empty(), "show {index}: {found:#?}");
    }
}
