//! Figures for a paper, batches, numbers and pictures with more pixels.

use crate::common::window::{Tiny, Window, name_file, settle, tiny};
use crate::{says, tiny_files};
use defocus_app::window::{Action, BatchRow, MethodChoice, Numbers, PaneId, PaneMetrics, PictureKind, read_state};
use eframe::egui::Role;
use egui_kittest::kittest::Queryable;
use std::path::Path;

fn window(methods: &[&str]) -> Tiny {
    tiny(&tiny_files::squares().glb(), methods)
}

fn perform(window: &mut Window, action: Action) {
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, action);
    window.run_steps(3);
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// Head and lines of a CSV file without quoted cells.
fn columns(text: &str, name: &str) -> Vec<String> {
    let mut lines = text.lines();
    let place = lines.next().expect("there is a head").split(',').position(|c| c == name);
    let place = place.unwrap_or_else(|| panic!("no column {name} in {text}"));
    lines.map(|line| line.split(',').nth(place).unwrap_or_default().to_owned()).collect()
}

fn psnr_db(window: &Window) -> f64 {
    let PaneMetrics::Current(measured) = window.state().engine().pane_metrics(PaneId(1)) else {
        panic!("it was measured")
    };
    measured.result.as_ref().expect("they can be compared").psnr_db.expect("they differ")
}

#[test]
fn figures_for_a_paper_have_what_they_are_of() {
    let Tiny { mut window, folder } = window(&["mipmap", "pinhole", "accumulation"]);
    let psnr_db = psnr_db(&window);
    perform(&mut window, Action::FiguresForPaper);
    window.get_by_role_and_label(Role::CheckBox, "2 Pinhole").click_accesskit();
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Make figures").click_accesskit();
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(window.state().last_error(), None);
    let figures = folder.path().join("squares-figures");
    for file in ["README.md", "state.ron", "caption.txt", "table.csv", "table.json", "coc.svg", "coc.csv", "scales.svg"]
    {
        assert!(!read(&figures.join(file)).is_empty(), "{file}");
    }
    let size = window.state().engine().size().expect("there is a picture");
    for name in ["pinhole", "reference", "1-mipmap", "1-mipmap-flip", "1-mipmap-visible", "1-mipmap-error"] {
        let image = image::open(figures.join(format!("{name}.png"))).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((image.width(), image.height()), (size.x, size.y), "{name}");
        assert!(figures.join(format!("{name}-detail.png")).exists(), "{name} has a detail");
    }
    assert!(!figures.join("2-pinhole.png").exists(), "it was left out");
    let caption = read(&figures.join("caption.txt"));
    for part in
        [&format!("PSNR {psnr_db:.2} dB"), "E = ", "focus at ", "Reference: accumulation, 8 lens points", "smoothing="]
    {
        assert!(caption.contains(part), "no {part} in {caption}");
    }
    let readme = read(&figures.join("README.md"));
    assert!(readme.contains("defocus compare ") && readme.contains("--methods mipmap "), "{readme}");
    for entry in std::fs::read_dir(&figures).expect("the folder is there") {
        let name = entry.expect("it can be read").file_name().to_string_lossy().into_owned();
        assert!(readme.contains(&name), "the README does not name {name}");
    }
    assert_eq!(columns(&read(&figures.join("table.csv")), "method"), ["mipmap"]);
    let state = read_state(&figures.join("state.ron")).expect("it is a state");
    assert_eq!(state.lens, window.state().document().lens);
}

#[test]
fn a_batch_has_the_figures_of_its_rows() {
    let Tiny { mut window, folder } = window(&["mipmap", "accumulation"]);
    let shown_db = psnr_db(&window);
    perform(&mut window, Action::Batch);
    window.get_by_role_and_label(Role::Button, "Batch: Add panes").click_accesskit();
    window.run_steps(3);
    let row = window.state().document().batch[0].clone();
    assert_eq!(row.method, MethodChoice::new("mipmap"));
    // A second row with half of the aperture, set as one sets it in the table.
    let mut document = window.state().document().clone();
    document.batch.push(BatchRow { aperture_mm: 0.5 * row.aperture_mm, ..row });
    let file = folder.path().join("two.ron");
    defocus_app::window::write_state(&file, &document).expect("it can be written");
    perform(&mut window, Action::OpenNamed(file.to_string_lossy().into_owned()));
    settle(&mut window);
    window.get_by_role_and_label(Role::Button, "Batch: Run").click_accesskit();
    window.run_steps(2);
    settle(&mut window);
    assert_eq!(window.state().last_error(), None);
    let results = window.state().batch_results();
    assert_eq!(results.len(), 2);
    let db: Vec<f64> = results.iter().map(|json| json.results[0].metrics.psnr_db.expect("they differ")).collect();
    assert!((db[0] - shown_db).abs() < 0.01, "the row of the pane has {} dB and the pane {shown_db}", db[0]);
    assert!(db[1] > db[0], "less blur is nearer to the truth: {db:?}");
    perform(&mut window, Action::SaveNumbers(Numbers::Batch));
    let csv = folder.path().join("batch.csv");
    name_file(&mut window, &csv);
    settle(&mut window);
    let saved: Vec<f64> = columns(&read(&csv), "psnr_db").iter().map(|text| text.parse().expect("a number")).collect();
    assert_eq!(saved, db);
    // What was measured of another view is not told of this one.
    perform(&mut window, Action::SetSize(defocus_app::window::PictureSize::Pixels(40, 30)));
    settle(&mut window);
    assert!(window.state().batch_results().is_empty());
}

#[test]
fn numbers_are_saved_with_what_they_are_of() {
    let Tiny { mut window, folder } = window(&["mipmap", "accumulation"]);
    let psnr_db = psnr_db(&window);
    let lens = window.state().document().lens.clone();
    let save = |window: &mut Window, numbers: Numbers, name: &str| {
        let file = folder.path().join(name);
        perform(window, Action::SaveNumbers(numbers));
        name_file(window, &file);
        settle(window);
        assert_eq!(window.state().last_error(), None);
        read(&file)
    };
    let csv = save(&mut window, Numbers::FiguresCsv, "figures.csv");
    assert_eq!(columns(&csv, "psnr_db"), [psnr_db.to_string()]);
    assert_eq!(columns(&csv, "aperture_diameter_mm"), [lens.aperture_diameter_mm.to_string()]);
    assert_eq!(columns(&csv, "reference_samples"), ["8"]);
    let json: serde_json::Value =
        serde_json::from_str(&save(&mut window, Numbers::FiguresJson, "figures.json")).expect("it is JSON");
    assert_eq!(json["figures"][0]["psnr_db"].as_f64(), Some(psnr_db));
    let state = folder.path().join("from-json.ron");
    std::fs::write(&state, json["state"].as_str().expect("it has the state")).expect("it can be written");
    assert_eq!(read_state(&state).expect("it is a state").lens, lens);
    let curve = save(&mut window, Numbers::Coc, "coc.csv");
    for (depth, coc) in columns(&curve, "depth_m").iter().zip(columns(&curve, "coc_px")) {
        let [depth_m, coc_px] = [depth, &coc].map(|text| text.parse::<f64>().expect("a number"));
        assert!((coc_px - lens.coc_diameter_px(depth_m)).abs() < 1e-6, "{depth_m} m: {coc_px} px");
    }
    // Without a reference there is nothing to be saved, and that is said.
    let Tiny { mut window, folder } = self::window(&["mipmap"]);
    perform(&mut window, Action::SaveNumbers(Numbers::FiguresCsv));
    name_file(&mut window, &folder.path().join("none.csv"));
    settle(&mut window);
    assert!(window.state().last_error().is_some_and(|error| error.contains("press Figures")));
}

#[test]
fn a_picture_with_more_pixels_shows_the_same() {
    let Tiny { mut window, folder } = window(&["mipmap"]);
    let size = window.state().engine().size().expect("there is a picture");
    let file = folder.path().join("twice.png");
    perform(&mut window, Action::SavePicture(PaneId(1), PictureKind::Png));
    window.get_by_role_and_label(Role::ComboBox, "Pixels").click();
    window.run_steps(3);
    window.get_by_label_contains("2 times: ").click();
    window.run_steps(3);
    name_file(&mut window, &file);
    settle(&mut window);
    assert_eq!(window.state().last_error(), None);
    let large = image::open(&file).expect("it was written").into_rgb8();
    assert_eq!((large.width(), large.height()), (2 * size.x, 2 * size.y));
    // Four of its pixels are one of the window's, in the mean over the picture.
    let shown = window.state().engine().pane(PaneId(1)).and_then(|p| p.shown()).expect("it is shown").clone();
    let small = defocus::gpu::download_rgba8(window.state().engine().gpu(), &shown);
    let mean = |values: &mut dyn Iterator<Item = u8>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + f64::from(v), count + 1.0));
        sum / count
    };
    let large_mean = mean(&mut large.pixels().flat_map(|p| p.0));
    let small_mean = mean(&mut small.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]));
    assert!((large_mean - small_mean).abs() < 2.0, "{large_mean} and {small_mean}");
    assert!(!says(&window, "cannot"));
}
