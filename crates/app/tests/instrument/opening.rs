//! Opening files of which something has to be said: layers, depth, and light of another scale.

use crate::common::window::{Tiny, choose, settle, tiny_with};
use crate::{says, tiny_files};
use defocus_app::window::{Action, AppOptions, Edit, command_line};
use egui_kittest::kittest::Queryable;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage};
use serde_json::json;
use std::path::Path;

fn tiny() -> Tiny {
    tiny_with(&tiny_files::squares().glb(), &["pinhole"], AppOptions::default())
}

/// Writes an EXR of 16 x 12 px whose channels are of one number each.
fn exr(path: &Path, channels: &[(&str, f32)]) {
    let plane = |value: f32| FlatSamples::F32(vec![value; 16 * 12]);
    let channels = channels.iter().map(|(name, value)| AnyChannel::new(*name, plane(*value))).collect();
    let layer = Layer::new((16, 12), LayerAttributes::default(), Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    exr::prelude::Image::from_layer(layer).write().to_file(path).expect("it can be written");
}

#[test]
fn layers_that_are_not_clear_are_asked_for() {
    let Tiny { mut window, folder } = tiny();
    let file = folder.path().join("passes.exr");
    let rgb = |layer: &str| ["R", "G", "B"].map(|channel| format!("{layer}.{channel}"));
    let names = [rgb("diffuse"), rgb("specular")].concat();
    let mut channels: Vec<(&str, f32)> = names.iter().map(|name| (name.as_str(), 0.5)).collect();
    channels.extend([("near.Depth.Z", 2.0), ("far.Depth.Z", 5.0)]);
    exr(&file, &channels);
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::OpenNamed(file.to_string_lossy().into_owned()));
    let start = std::time::Instant::now();
    while window.query_by_label("Picture layer").is_none() {
        assert!(start.elapsed().as_secs() < 30, "the dialog does not open: {:?}", window.state().last_error());
        window.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    choose(&mut window, "Picture layer", "specular");
    choose(&mut window, "Depth layer", "far.Depth");
    // The preview tells which depths these would be.
    let start = std::time::Instant::now();
    while !says(&window, "nearest 5 m · median 5 m · farthest 5 m") {
        assert!(start.elapsed().as_secs() < 30, "no preview");
        window.step();
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    window.run_steps(3);
    window.get_by_label("Open").click_accesskit();
    window.run_steps(2);
    settle(&mut window);
    let depth = &window.state().document().depth;
    assert_eq!((depth.layer.as_deref(), depth.depth_layer.as_deref()), (Some("specular"), Some("far.Depth")));
    let at = window.state_mut().depth_at_m(glam::DVec2::splat(0.5));
    assert!(at.is_some_and(|m| (m - 5.0).abs() < 1e-3), "{at:?}");
}

#[test]
fn light_of_another_scale_is_metered_said_and_can_be_set() {
    let mut scene = tiny_files::squares();
    // Daylight: 100,000 lx along the view.
    scene.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    scene.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 100_000.0}]}});
    let lamp = json!({"extensions": {"KHR_lights_punctual": {"light": 0}}});
    scene.list("nodes").push(lamp);
    let last = scene.list("nodes").len() - 1;
    scene.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(last));
    let Tiny { mut window, folder: _folder } = tiny_with(&scene.glb(), &["pinhole"], AppOptions::default());
    let metered_ev = window.state().document().display.exposure_ev;
    assert!(metered_ev < -8.0, "{metered_ev} EV for daylight");
    assert!(says(&window, "metered:"), "it is said");
    let line = command_line(window.state().document(), glam::uvec2(64, 48));
    assert!(line.contains(&format!("--exposure {metered_ev}")), "{line}");
    let mut view = window.state().document().view_settings();
    view.display.exposure_ev = 0.0;
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::Edit(Edit::View(view)));
    settle(&mut window);
    assert!(says(&window, "set by hand"), "and that it was overridden");
    let line = command_line(window.state().document(), glam::uvec2(64, 48));
    assert!(line.contains("--exposure 0"), "the command line would meter it again: {line}");
    window.get_by_label("Meter").click_accesskit();
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(window.state().document().display.exposure_ev, metered_ev);
    assert!(window.state().document().automatic_exposure);
}
