//! `defocus profile`: where the time of methods goes on this adapter.

use super::args::{ProfileArgs, WhileName};
use super::options::DisplayOptions;
use super::output::{check_json, is_stdout, print, write_json};
use super::progress::{Bar, catch_interrupts, check_interrupt};
use super::select;
use super::setup::{Setup, SetupOptions};
use anyhow::{Context, ensure};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use defocus::lens::Lens;
use defocus::methods::Method;
use defocus::view::auto_overscan_px;
use defocus_study::compare::{NotRun, runnable};
use defocus_study::profile::{MethodProfile, ProfileRequest, While, profile};
use defocus_study::results::Setting;
use serde::Serialize;
use std::time::Duration;

/// Share of a method's time below which passes are told of as one.
const SMALL_SHARE: f64 = 0.005;

/// One blur of one view.
#[derive(Serialize)]
struct ProfileJson {
    #[serde(flatten)]
    setting: Setting,
    /// What changed between frames.
    #[serde(rename = "while")]
    during: While,
    methods: Vec<MethodAt>,
    not_run: Vec<NotRun>,
}

/// What one method costs at one blur.
#[derive(Serialize)]
struct MethodAt {
    /// Mean CoC diameter over the image, px; null where nothing was asked for.
    mean_coc_px: Option<f64>,
    #[serde(flatten)]
    profile: MethodProfile,
}

/// Runs the command.
pub fn run(args: &ProfileArgs) -> anyhow::Result<()> {
    catch_interrupts()?;
    check_json(args.run.json.json.as_ref())?;
    for px in &args.cocs {
        ensure!(px.is_finite() && *px > 0.0, "--coc {px}: give CoC diameters in px, finite and above 0");
    }
    ensure!(
        args.seconds > 0.0 && args.seconds.is_finite(),
        "--seconds is {}; give a finite number above 0",
        args.seconds
    );
    let mut methods = select::methods(&args.methods)?;
    select::as_published(args.view.as_published, &mut methods);
    select::shade_by_view(args.view.view_dependent, &mut methods)?;
    select::apply(&args.view.settings, &mut methods)?;
    let mut setup = Setup::new(&SetupOptions {
        scene: &args.scene,
        lens: &args.lens,
        view: &args.view,
        // Times do not depend on how the picture is shown: nothing is metered.
        display: &DisplayOptions { exposure: Some(0.0), ..Default::default() },
        adapter: args.run.adapter.as_deref(),
        schedule: args.run.schedule,
        stereo: None,
        mipmaps: true,
    })?;
    if args.view.as_image {
        setup.show_as_image()?;
    }
    let during = match args.during {
        WhileName::Still => While::Still,
        WhileName::Lens => While::Lens,
        WhileName::Camera => While::Camera,
    };
    ensure!(
        during != While::Camera || setup.view.is_scene(),
        "--while camera draws the scene anew, and an image with depth has none: give still or lens"
    );
    let (methods, not_run) = runnable(methods, &setup.view);
    let most = Duration::from_secs_f64(args.seconds);
    let request = ProfileRequest { during, runs: args.runs, most, count_reads: args.count_reads };
    let bar = Bar::new(args.run.quiet);
    let results = all(args, &mut setup, &methods, &request, &bar)?;
    drop(bar);
    check_interrupt()?;
    let json = ProfileJson { setting: setup.setting(), during, methods: results, not_run };
    write_json(args.run.json.json.as_ref(), &json)?;
    if !is_stdout(args.run.json.json.as_ref()) {
        print(&shown(&json))?;
    }
    Ok(())
}

/// All methods at all blurs.
fn all(
    args: &ProfileArgs,
    setup: &mut Setup,
    methods: &[Box<dyn Method>],
    request: &ProfileRequest,
    bar: &Bar,
) -> anyhow::Result<Vec<MethodAt>> {
    let gpu = setup.gpu();
    let depth = setup.depth_m();
    let wanted: Vec<Option<f64>> = match args.cocs[..] {
        [] => vec![args.lens.mean_coc],
        ref cocs => cocs.iter().copied().map(Some).collect(),
    };
    let mut results = Vec::new();
    for mean_coc_px in wanted {
        let lens = match mean_coc_px {
            None => setup.lens.clone(),
            Some(px) => opened(&setup.lens, px, &depth.pixels)?,
        };
        if setup.view.is_scene() && !args.cocs.is_empty() {
            let size = setup.view.size();
            setup.view.set_size(&gpu, size, auto_overscan_px(&lens, &depth))?;
        }
        for method in methods {
            let profile = profile(&gpu, &mut setup.view, &lens, method.as_ref(), request, &mut |step| bar.step(step))?;
            results.push(MethodAt { mean_coc_px, profile });
        }
        setup.lens = lens;
    }
    Ok(results)
}

fn opened(lens: &Lens, px: f64, depths_m: &[f32]) -> anyhow::Result<Lens> {
    lens.with_mean_coc(px, depths_m.iter().copied()).context(
        "--coc: all of the image lies at the focus distance, so that no aperture blurs it; choose another --focus",
    )
}

/// For a terminal: a line a method, then their passes.
fn shown(json: &ProfileJson) -> String {
    let mut methods = styled([
        "method",
        "CoC px",
        "GPU ms",
        "95 %",
        "copies",
        "back to back",
        "record",
        "passes",
        "dispatches",
        "indirect",
        "draws",
        "triangles",
        "reads/px",
        "MB",
    ]);
    let number = |v: Option<f64>, digits: usize| v.map_or("-".into(), |v| format!("{v:.digits$}"));
    for MethodAt { mean_coc_px, profile: p } in &json.methods {
        methods.add_row([
            p.method.to_owned(),
            mean_coc_px.map_or("-".into(), |px| px.to_string()),
            number(p.gpu_ms, 3),
            p.gpu_ms_95.map_or("-".into(), |[low, high]| format!("{low:.3} to {high:.3}")),
            number(p.copy_ratio, 1),
            format!("{:.3}", p.back_to_back_ms),
            format!("{:.3}", p.record_ms),
            p.passes.to_string(),
            p.dispatches.to_string(),
            p.indirect_dispatches.to_string(),
            p.scene_draws.to_string(),
            p.triangles.to_string(),
            number(p.reads_per_px, 1),
            format!("{:.0}", p.peak_bytes as f64 / 1e6),
        ]);
    }
    let Setting { adapter, backend, scene, size: [width, height], .. } = &json.setting;
    let during = match json.during {
        While::Still => "nothing changes",
        While::Lens => "the lens changes",
        While::Camera => "the camera moves",
    };
    let mut text = format!("{scene}, {width}x{height} px, {during}; {adapter} ({backend}); times in ms\n{methods}");
    let passes = passes(json);
    if passes.row_count() > 0 {
        text += &format!("\n{passes}");
    }
    text
}

/// The passes of each method, most expensive first.
fn passes(json: &ProfileJson) -> Table {
    let mut table = styled(["method", "CoC px", "pass", "GPU ms", "share"]);
    for MethodAt { mean_coc_px, profile } in &json.methods {
        let all_ms: f64 = profile.pass_times.iter().map(|p| p.ms).sum();
        let mut row = |label: String, ms: f64| {
            let coc = mean_coc_px.map_or("-".into(), |px| px.to_string());
            let share = if all_ms > 0.0 { format!("{:.1} %", 100.0 * ms / all_ms) } else { "-".into() };
            table.add_row([profile.method.to_owned(), coc, label, format!("{ms:.4}"), share]);
        };
        let is_large = |ms: f64| ms >= SMALL_SHARE * all_ms;
        let short = |label: &str| label.split_once('/').map_or(label, |(_, pass)| pass).to_owned();
        for pass in profile.pass_times.iter().filter(|p| is_large(p.ms)) {
            row(short(&pass.label), pass.ms);
        }
        let small: Vec<_> = profile.pass_times.iter().filter(|p| !is_large(p.ms)).collect();
        if !small.is_empty() {
            row(format!("{} others", small.len()), small.iter().map(|p| p.ms).sum());
        }
    }
    table
}

fn styled<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header);
    for (index, column) in table.column_iter_mut().enumerate() {
        let is_text = index == 0 || header[index] == "pass";
        column.set_cell_alignment(if is_text { CellAlignment::Left } else { CellAlignment::Right });
    }
    table
}
