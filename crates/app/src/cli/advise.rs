//! `defocus advise`: which methods are good enough for a display.

use super::args::AdviseArgs;
use super::output::{check_json, check_target, command_line, is_stdout, print, print_notes, write_json};
use super::progress::{Bar, catch_interrupts, check_interrupt};
use super::select;
use super::setup::{Setup, SetupOptions};
use anyhow::{Context, ensure};
use comfy_table::{ContentArrangement, Table, presets};
use defocus::image_io::write_atomically;
use defocus::lens::MM_PER_M;
use defocus::viewing::Viewing;
use defocus_study::advise::{Advice, AdviceCell, AdviceRequest, PUPILS_MM, advise, focus_distances_m, html, in_words};
use defocus_study::compare::{NotRun, runnable};
use defocus_study::results::Setting;
use serde::Serialize;
use std::io::Write;

#[derive(Serialize)]
struct AdviceJson {
    #[serde(flatten)]
    setting: Setting,
    viewing: Viewing,
    #[serde(flatten)]
    advice: Advice,
    not_run: Vec<NotRun>,
}

/// Runs the command.
pub fn run(args: &AdviseArgs) -> anyhow::Result<()> {
    catch_interrupts()?;
    check_json(args.run.json.json.as_ref())?;
    args.output.as_deref().map_or(Ok(()), check_target)?;
    for mm in &args.pupils {
        ensure!(mm.is_finite() && *mm > 0.0, "--pupils {mm}: give diameters in mm, finite and above 0");
    }
    let mut methods = select::methods(&args.methods)?;
    if args.methods == "all" {
        // The truth itself is good enough by definition, and costs as many views as it has.
        methods.retain(|method| method.about().id != "accumulation");
    }
    select::apply(&args.view.settings, &mut methods)?;
    let mut setup = Setup::new(&SetupOptions {
        scene: &args.scene,
        lens: &args.lens,
        view: &args.view,
        display: &args.display,
        adapter: args.run.adapter.as_deref(),
        schedule: args.run.schedule,
        stereo: None,
        mipmaps: true,
    })?;
    ensure!(
        setup.view.is_scene(),
        "advise needs a scene: an image with depth has no reference to judge by; give a built-in name or a .glb file"
    );
    let (methods, not_run) = runnable(methods, &setup.view);
    print_notes(&setup.notes(), args.run.quiet);
    let focus_m = if args.focus_distances.is_empty() {
        focus_distances_m(&setup.depth_m())
    } else {
        args.focus_distances.clone()
    };
    for m in &focus_m {
        let inside = *m * MM_PER_M > setup.lens.focal_length_mm;
        ensure!(inside, "a focus distance of {m} m is nearer than an image forms; give others with --focus-distances");
    }
    let pupils_mm: &[f64] = if args.pupils.is_empty() { &PUPILS_MM } else { &args.pupils };
    let request = AdviceRequest {
        lens: &setup.lens,
        pupils_mm,
        focus_m: &focus_m,
        methods: &methods,
        samples: args.samples,
        runs: args.runs,
        good_enough_jod: args.good_enough,
        display: setup.display,
        viewing: setup.viewing,
    };
    let gpu = setup.source.gpu().clone();
    let bar = Bar::new(args.run.quiet);
    let advice = advise(&gpu, &setup.source, &mut setup.view, &request, &mut |step| bar.step(step))?;
    drop(bar);
    check_interrupt()?;
    let json = AdviceJson { setting: setup.setting(), viewing: setup.viewing, advice, not_run };
    let head = head(&json, args.lens.lens.as_deref());
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make it; check that its folder may be written", folder.display()))?;
        let page = html(&json.advice, &json.setting.scene, &head, &command_line()).context("cannot make the page")?;
        write_atomically(&folder.join("advice.html"), |file| file.write_all(page.as_bytes()))?;
        let text = serde_json::to_string_pretty(&json)?;
        write_atomically(&folder.join("advice.json"), |file| writeln!(file, "{text}"))?;
    }
    write_json(args.run.json.json.as_ref(), &json)?;
    if !is_stdout(args.run.json.json.as_ref()) {
        print(&format!("{head}\n{}\n{}", table(&json.advice), in_words(&json.advice)))?;
    }
    Ok(())
}

fn head(json: &AdviceJson, preset: Option<&str>) -> String {
    let [width, height] = json.setting.size;
    let screen = &json.viewing.screen;
    format!(
        "{}, {width}x{height} px, {}: {:.2} px per degree, {} to {} cd/m2; {}",
        json.setting.scene,
        preset.unwrap_or("own display"),
        json.viewing.px_per_degree,
        screen.black_cd_m2,
        screen.peak_cd_m2,
        json.setting.adapter
    )
}

fn table(advice: &Advice) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header([
        "focus m",
        "pupil mm",
        "mean CoC px",
        "cheapest",
        "good enough, with JOD and ms",
        "not good enough",
    ]);
    table.add_rows(advice.cells.iter().map(row));
    table
}

fn row(cell: &AdviceCell) -> [String; 6] {
    let of = |good: bool| {
        let methods = cell.methods.iter().filter(move |m| m.good_enough == good);
        let text = methods.map(|m| {
            let jod = m.jod.map_or("–".into(), |jod| format!("{jod:.2}"));
            let ms = m.gpu_ms.map_or(String::new(), |ms| format!(", {ms:.1}"));
            format!("{} ({jod}{ms})", m.method)
        });
        text.collect::<Vec<_>>().join(", ")
    };
    [
        cell.focus_m.map_or("infinity".into(), |m| format!("{m:.2}")),
        cell.pupil_mm.to_string(),
        format!("{:.2}", cell.mean_coc_px),
        cell.cheapest.unwrap_or("none").into(),
        of(true),
        of(false),
    ]
}
