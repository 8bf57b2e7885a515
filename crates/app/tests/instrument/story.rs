//! The story of a pixel.

use crate::common::window::{Tiny, Window, point, settle, tiny};
use crate::{says, tiny_files};
use defocus::gpu::download;
use defocus_app::window::{Action, PaneId, PictureSize};
use eframe::egui::{self, Role};
use egui_kittest::kittest::Queryable;
use glam::DVec2;

/// Unfolds the inspector with its story and points at the picture.
fn told(window: &mut Window, at: DVec2) {
    window.get_by_label("Inspector").scroll_to_me();
    window.run_steps(3);
    window.get_by_label("Inspector").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::CheckBox, "Story of the pixel").click_accesskit();
    settle(window);
    let at = point(window, at.x as f32, at.y as f32);
    window.event(egui::Event::PointerMoved(at));
    settle(window);
}

#[test]
fn every_texture_of_a_method_is_read_under_the_pointer() {
    for method in ["mipmap", "adaptive", "splat", "gather"] {
        let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["pinhole"]);
        let ctx = window.ctx.clone();
        window.state_mut().perform(&ctx, Action::SetSize(PictureSize::Pixels(64, 48)));
        window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), method.into()));
        settle(&mut window);
        let at = DVec2::new(0.4, 0.45);
        told(&mut window, at);
        let engine = window.state().engine();
        let pane = engine.pane(PaneId(1)).expect("the pane is there");
        let names: Vec<String> = pane.exposed().map(|(name, _)| name.to_owned()).collect();
        assert!(!names.is_empty(), "{method} keeps its textures");
        let story = engine.story_at(PaneId(1), at).expect("there is a picture");
        assert!(!story.lines.is_empty(), "{method}");
        // In the order in which the method makes them.
        let mut order = names.iter();
        let mut last = "";
        for line in &story.lines {
            if line.texture != last {
                assert!(order.any(|name| *name == line.texture), "{method}: {} is out of order", line.texture);
                last = &line.texture;
            }
        }
        assert!(says(&window, "On its way through"), "{method}");
        assert!(says(&window, &story.lines[0].texture), "{method}");
    }
}

#[test]
fn what_is_told_is_what_the_texture_holds() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["mipmap"]);
    let at = DVec2::new(0.3, 0.6);
    told(&mut window, at);
    let engine = window.state().engine();
    let story = engine.story_at(PaneId(1), at).expect("there is a picture");
    let pane = engine.pane(PaneId(1)).expect("the pane is there");
    let mut compared = 0;
    for line in story.lines.iter().filter(|line| line.level.unwrap_or(0) == 0 && line.layer.is_none()) {
        let (_, texture) = pane.exposed().find(|(name, _)| *name == line.texture).expect("it is kept");
        if texture.format() != wgpu::TextureFormat::Rgba16Float && texture.format() != wgpu::TextureFormat::Rgba32Float
        {
            continue;
        }
        let image = download(engine.gpu(), texture);
        let held = image.at(line.texel.x, line.texel.y).to_array();
        for (told, held) in line.values.iter().zip(held) {
            assert!((told - held).abs() <= 1e-3 * held.abs() + 1e-6, "{}: {told} and not {held}", line.texture);
        }
        compared += 1;
    }
    assert!(compared > 0, "{:?}", story.lines);
}
