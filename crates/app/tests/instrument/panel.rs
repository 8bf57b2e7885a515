//! The panel: one screen of what is always used, and nothing in it jumps.

use crate::common::window::{Window, settle, window_as_asked};
use crate::says;
use defocus::lens::Lens;
use defocus_app::window::{Action, AppOptions, Document, Edit, MethodChoice, PaneId, PictureSize};
use eframe::egui::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use std::collections::BTreeMap;

fn window() -> Window {
    let document =
        Document { size: PictureSize::Pixels(32, 24), ..Document::of_methods([MethodChoice::new("mipmap")]) };
    window_as_asked([1280.0, 720.0], AppOptions { document: Some(document), ..AppOptions::default() })
}

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
    settle(window);
}

/// The title of the panel's last part.
const LAST: &str = "Timing";

#[test]
fn one_screen_of_720_points_has_what_is_always_used() {
    let mut window = window();
    let mut too_high = Vec::new();
    let methods: Vec<_> = defocus::methods::all().iter().map(|method| method.about().id).collect();
    for id in methods.into_iter().filter(|id| !["raytrace", "accumulation"].contains(id)) {
        perform(&mut window, Action::SetMethod(PaneId(1), id.into()));
        let status = window.get_by_label("K").rect();
        let last = window.get_by_label(LAST).rect();
        if last.bottom() > status.top() {
            too_high.push(format!("{id}: the panel ends at {}, and its room at {}", last.bottom(), status.top()));
        }
    }
    assert!(too_high.is_empty(), "{too_high:#?}");
}

/// Where the inputs are, from the top of the window, by role and name.
fn places(window: &Window) -> BTreeMap<String, f64> {
    let nodes = window.root().children_recursive().map(|node| node.accesskit_node());
    let inputs = nodes.filter(|n| [Role::SpinButton, Role::ComboBox, Role::Slider, Role::CheckBox].contains(&n.role()));
    inputs.filter_map(|n| Some((format!("{:?} {}", n.role(), n.label()?), n.raw_bounds()?.y0))).collect()
}

#[test]
fn what_comes_and_goes_has_a_place_of_its_own() {
    let mut window = window();
    let before = places(&window);
    assert!(before.len() > 8, "{before:?}");
    let lens = window.state().document().lens.clone();
    let size = window.state().document().camera.expect("a scene has one");
    let no_image = Lens { focus_distance_m: 0.5e-3 * lens.focal_length_mm, ..lens.clone() };
    let other_view = defocus::camera::Camera { fov_y: 0.6 * size.fov_y, aspect: None, ..size };
    let pinhole = Lens { aperture_diameter_mm: 0.0, ..lens.clone() };
    let states: [(&str, Edit, &str); 3] = [
        ("a lens that forms no image", Edit::Lens(no_image), "no image forms"),
        ("another field of view", Edit::Camera(other_view, 1.0), "Fit the display"),
        ("a pinhole", Edit::Lens(pinhole), "Mean blur"),
    ];
    for (what, edit, told) in states {
        perform(&mut window, Action::Edit(edit));
        assert!(says(&window, told), "{what}: “{told}” is not told");
        assert_eq!(places(&window), before, "{what} moves the panel");
        perform(&mut window, Action::Edit(Edit::Camera(size, 1.0)));
        perform(&mut window, Action::Edit(Edit::Lens(lens.clone())));
    }
}

#[test]
fn panels_change_the_document_through_actions() {
    let mut window = window();
    let before = window.state().document().clone();
    // Each part given back as it is changes nothing, and is no step that could be undone.
    for edit in [Edit::Focus(before.focus), Edit::View(before.view_settings()), Edit::Stereo(before.stereo)] {
        perform(&mut window, Action::Edit(edit));
        assert_eq!(*window.state().document(), before);
    }
    perform(&mut window, Action::Edit(Edit::ApertureDiameter(3.0)));
    assert_eq!(window.state().document().lens.aperture_diameter_mm, 3.0);
    window.run_steps(6);
    perform(&mut window, Action::Undo);
    assert_eq!(window.state().document().lens, before.lens, "what a panel does is undone like any other action");
}
