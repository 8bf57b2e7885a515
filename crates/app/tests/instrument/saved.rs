//! What is saved and copied is what is shown.

use crate::common::window::{Tiny, Window, name_file, press, settle, tiny};
use crate::tiny_files;
use defocus_app::window::{
    Action, Document, MethodChoice, PaneId, PaneMetrics, PaneState, command_line, command_text, left_out,
};
use eframe::egui::{Key, Modifiers};
use glam::uvec2;

fn window(methods: &[&str]) -> Tiny {
    tiny(&tiny_files::squares().glb(), methods)
}

fn report(window: &mut Window, folder: &std::path::Path) -> String {
    let file = folder.join("comparison.html");
    press(window, Modifiers::COMMAND, Key::R);
    name_file(window, &file);
    settle(window);
    assert_eq!(window.state().last_error(), None);
    std::fs::read_to_string(&file).expect("it was written")
}

#[test]
fn a_report_has_the_figures_of_the_window_and_its_reference() {
    let Tiny { mut window, folder } = window(&["mipmap", "accumulation"]);
    let PaneMetrics::Current(measured) = window.state().engine().pane_metrics(PaneId(1)) else {
        panic!("they were measured")
    };
    let psnr_db = measured.result.as_ref().expect("they can be compared").psnr_db.expect("they differ");
    let frames = window.state().engine().rendered_frames();
    let html = report(&mut window, folder.path());
    assert!(html.contains(&format!("{psnr_db:.2}")), "the report has {psnr_db:.2} dB too");
    assert!(html.contains("accumulation, 8 lens points"));
    assert_eq!(window.state().engine().rendered_frames(), frames, "the window's device drew nothing for it");
    assert!(!html.contains("times may be too long"), "nothing disturbed the times");
}

#[test]
fn a_report_judges_no_reference_and_brings_its_numbers() {
    let Tiny { mut window, folder } = window(&["mipmap", "accumulation", "accumulation"]);
    let html = report(&mut window, folder.path());
    let (_, rest) = html.split_once("<tr class=\"reference\">").expect("the second accumulation is set apart");
    let (row, after) = rest.split_once("</tr>").expect("the row ends");
    assert!(row.contains("as the reference") && !row.contains("class=\"best\""), "{row}");
    assert!(!after.split("</tbody>").next().unwrap_or_default().contains("<tr"), "it stands last");
    assert!(html.contains("class=\"best\""), "the method is the best of those that are judged");
    assert!(html.contains("download=\"squares.csv\"") && html.contains("download=\"squares.json\""));
    assert!(html.contains("Quality against time") && html.contains("class=\"plot\""));
}

#[test]
fn a_report_waits_for_a_reference_that_converges_and_does_not_draw_another() {
    let Tiny { mut window, folder } = window(&["mipmap", "accumulation"]);
    let ctx = window.ctx.clone();
    // It starts to converge again, and the report is asked for at once.
    window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), "pinhole".into()));
    let file = folder.path().join("comparison.html");
    let mut document = window.state().document().clone();
    document.lens.aperture_diameter_mm *= 1.5;
    let state = folder.path().join("other.ron");
    defocus_app::window::write_state(&state, &document).expect("it can be written");
    window.state_mut().perform(&ctx, Action::OpenNamed(state.to_string_lossy().into_owned()));
    window.step();
    window.state_mut().perform(&ctx, Action::SaveReport);
    name_file(&mut window, &file);
    settle(&mut window);
    assert_eq!(window.state().last_error(), None);
    let html = std::fs::read_to_string(&file).expect("it was written");
    assert!(html.contains("accumulation, 8 lens points"));
}

/// A document with a camera, as a scene has one.
fn document(panes: &[(&str, &[(&str, &str)])]) -> Document {
    let choice = |(id, params): &(&str, &[(&str, &str)])| {
        let mut choice = MethodChoice::new(id);
        choice.params.extend(params.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())));
        choice
    };
    let camera = Some(crate::common::front_camera());
    Document { camera, ..Document::of_methods(panes.iter().map(choice)) }
}

#[test]
fn a_copied_command_reproduces_what_is_seen() {
    let line = |panes: &[(&str, &[(&str, &str)])]| command_line(&document(panes), uvec2(64, 48));
    let alone = line(&[("mipmap", &[])]);
    assert!(alone.starts_with("defocus render ") && alone.contains("--method mipmap"), "{alone}");
    let beside = line(&[("mipmap", &[]), ("accumulation", &[("samples", "256")])]);
    assert!(beside.starts_with("defocus compare ") && beside.contains("--methods mipmap "), "{beside}");
    assert!(beside.contains("--samples 256") && !beside.contains("--view-dependent"), "{beside}");
    let by_view: &[(&str, &str)] = &[("samples", "32"), ("view_dependent", "on")];
    let by_view = line(&[("mipmap", &[]), ("multiview", &[]), ("accumulation", by_view)]);
    assert!(by_view.contains("--samples 32") && by_view.contains("--view-dependent"), "{by_view}");
    assert!(by_view.contains("--set multiview.view_dependent=off"), "only the reference shades so: {by_view}");
    let reference = line(&[("accumulation", &[("samples", "9")])]);
    assert!(
        reference.starts_with("defocus render ") && reference.contains("--set accumulation.samples=9"),
        "{reference}"
    );
    let measured = Document { measure: true, ..document(&[("mipmap", &[])]) };
    let measured = command_line(&measured, uvec2(64, 48));
    assert!(measured.starts_with("defocus compare ") && measured.contains("--samples 256"), "{measured}");
}

#[test]
fn what_a_command_leaves_out_is_in_its_text() {
    let plain = document(&[("mipmap", &[])]);
    assert!(left_out(&plain).is_empty() && !command_text(&plain, uvec2(64, 48)).contains('#'));
    let two = Document { stereo: Some(Default::default()), ..document(&[("mipmap", &[]), ("accumulation", &[])]) };
    let text = command_text(&two, uvec2(64, 48));
    assert!(text.ends_with("\n# left out: the right eye"), "{text}");
    let mut same = document(&[("mipmap", &[])]);
    same.panes.push(PaneState::new(PaneId(7), MethodChoice::new("mipmap")));
    assert!(command_text(&same, uvec2(64, 48)).contains("# left out: further panes of one method"));
}
