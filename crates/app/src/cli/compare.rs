//! `defocus compare`: methods against a reference.

use super::args::CompareArgs;
use super::output::{check_json, check_target, command_line, is_stdout, parent_of, print, print_notes, write_json};
use super::progress::{Bar, catch_interrupts, check_interrupt};
use super::select;
use super::setup::{Setup, SetupOptions};
use anyhow::{Context, ensure};
use comfy_table::{Cell, CellAlignment, Color, ContentArrangement, Table, presets};
use defocus::image::Image;
use defocus::image_io::{write_atomically, write_exr, write_png_rgb};
use defocus::methods::Method;
use defocus::view::Tone;
use defocus_study::cache::cached_reference;
use defocus_study::compare::{CompareRequest, GoodEnough, compare, runnable};
use defocus_study::reference::{Reference, ReferenceRequest};
use defocus_study::report::{self, ReportInput, good_enough_in_words};
use defocus_study::results::{CompareJson, MetricsJson, ResultJson};
use defocus_study::timing::Rounds;
use defocus_study::{Comparison, Truth};
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;

/// Runs the command.
pub fn run(args: &CompareArgs) -> anyhow::Result<()> {
    catch_interrupts()?;
    check_json(args.run.json.json.as_ref())?;
    args.output.as_deref().map_or(Ok(()), check_target)?;
    let mut methods = select::methods(&args.methods)?;
    select::as_published(args.view.as_published, &mut methods);
    select::shade_by_view(args.view.view_dependent, &mut methods)?;
    select::apply(&args.view.settings, &mut methods)?;
    let reference = args.reference.as_deref().map(Reference::by_id).transpose()?;

    let mut setup = Setup::new(&SetupOptions {
        scene: &args.scene,
        lens: &args.lens,
        view: &args.view,
        display: &args.display,
        adapter: args.run.adapter.as_deref(),
        schedule: args.run.schedule,
        // The tracer reads textures without mipmaps: like is compared with like.
        stereo: None,
        mipmaps: !matches!(reference, Some(Reference::RayTrace)),
    })?;
    let gpu = setup.gpu();
    let image = args.view.as_image.then(|| setup.view.as_image(&gpu)).transpose()?;
    let (methods, not_run) = runnable(methods, image.as_ref().unwrap_or(&setup.view));
    ensure!(
        args.methods == "all" || not_run.is_empty(),
        "{}",
        not_run.iter().map(|left| format!("{}: {}", left.method, left.reason)).collect::<Vec<_>>().join("; ")
    );

    print_notes(&setup.notes(), args.run.quiet);
    let bar = Bar::new(args.run.quiet);
    let mut truth = truth(args, &mut setup, reference, &bar)?;
    // The truth is the scene's; methods see the image, and what is left of its light.
    setup.view = image.unwrap_or(setup.view);
    let tone = setup.give(args.input)?;
    if let Some(truth) = truth.as_mut().filter(|_| tone != Tone::Linear) {
        truth.color = truth.color.map(|color| tone.apply(color));
    }
    let comparison = compare_all(args, &mut setup, &methods, truth.as_ref(), &bar)?;
    drop(bar);
    let mut json = CompareJson::new(setup.setting(), setup.viewing, truth.as_ref(), &comparison, not_run);
    json.good_enough = args.good_enough.map(|jod| GoodEnough::among(&comparison.results, jod));
    check_interrupt()?;
    if let Some(folder) = &args.output {
        let results = Results { json: &json, comparison: &comparison, truth: truth.as_ref() };
        write_folder(folder, &setup, &results)?;
    }
    write_json(args.run.json.json.as_ref(), &json)?;
    if !is_stdout(args.run.json.json.as_ref()) {
        print(&table(&json))?;
    }
    Ok(())
}

/// The truth, from the cache if it is there; none of an image unless one is asked for.
fn truth(
    args: &CompareArgs,
    setup: &mut Setup,
    reference: Option<Reference>,
    bar: &Bar,
) -> anyhow::Result<Option<Truth>> {
    let reference = match reference {
        Some(reference) => reference,
        None if setup.view.is_scene() => Reference::Accumulation,
        None => return Ok(None),
    };
    let (view_dependent, display) = (args.view.view_dependent, setup.display);
    let request = ReferenceRequest { reference, samples: args.samples, view_dependent, display };
    let (source, view) = (&setup.source, &mut setup.view);
    let cache = args.cache.cache();
    let (truth, problem) =
        cached_reference(cache.as_ref(), source, view, &setup.lens, &request, &mut |step| bar.step(step))?;
    if let Some(problem) = problem {
        eprintln!("defocus: the reference is not kept for the next time: {problem}");
    }
    Ok(Some(truth))
}

fn compare_all(
    args: &CompareArgs,
    setup: &mut Setup,
    methods: &[Box<dyn Method>],
    truth: Option<&Truth>,
    bar: &Bar,
) -> anyhow::Result<Comparison> {
    let gpu = setup.gpu();
    let (display, viewing) = (setup.display, setup.viewing);
    let rounds = Rounds { warmup: args.warmup, runs: args.runs, redraw: false };
    let request = CompareRequest { lens: &setup.lens, methods, truth, display, viewing, rounds };
    Ok(compare(&gpu, &mut setup.view, &request, &mut |step| bar.step(step))?)
}

struct Results<'a> {
    json: &'a CompareJson,
    comparison: &'a Comparison,
    truth: Option<&'a Truth>,
}

/// Writes everything to a temporary folder beside the target and then moves it there.
fn write_folder(folder: &Path, setup: &Setup, results: &Results<'_>) -> anyhow::Result<()> {
    let cannot =
        || format!("{}: cannot write it; check that its folder may be written and has space", folder.display());
    let temporary = tempfile::Builder::new().prefix(".defocus-").tempdir_in(parent_of(folder)).with_context(cannot)?;
    write_files(temporary.path(), setup, results)?;
    check_interrupt()?;
    std::fs::create_dir_all(folder).with_context(cannot)?;
    for file in std::fs::read_dir(temporary.path()).with_context(cannot)? {
        let file = file.with_context(cannot)?;
        std::fs::rename(file.path(), folder.join(file.file_name())).with_context(cannot)?;
    }
    Ok(())
}

fn write_files(folder: &Path, setup: &Setup, results: &Results<'_>) -> anyhow::Result<()> {
    let display = setup.display;
    let images: Vec<_> = results
        .comparison
        .results
        .par_iter()
        .map(|result| report::method_images(result, results.truth, display, &setup.viewing))
        .collect::<Result<_, _>>()?;
    check_interrupt()?;
    let png = |name: String, image: Option<&Image<[u8; 3]>>| {
        image.map_or(Ok(()), |image| write_png_rgb(&folder.join(name + ".png"), image))
    };
    for image in &images {
        png(image.method.to_owned(), Some(&image.image))?;
        png(format!("{}-flip", image.method), image.flip.as_ref())?;
        png(format!("{}-jod", image.method), image.jod.as_ref())?;
        png(format!("{}-error", image.method), image.abs_error.as_ref())?;
    }
    if let Some(truth) = results.truth {
        png("reference".into(), Some(&report::shown(&truth.color, display)))?;
        write_exr(&folder.join("reference.exr"), &truth.color, None, None)?;
    }
    let text = serde_json::to_string_pretty(results.json)?;
    write_atomically(&folder.join("results.json"), |file| writeln!(file, "{text}"))?;
    let html = report::html(&ReportInput {
        json: results.json,
        comparison: results.comparison,
        truth: results.truth,
        images: &images,
        display,
        command: &command_line(),
        notes: &setup.notes(),
    })
    .context("cannot make the report")?;
    write_atomically(&folder.join("report.html"), |file| file.write_all(html.as_bytes()))?;
    Ok(())
}

/// The results as a table, with what they were made with above it.
fn table(json: &CompareJson) -> String {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    let header = [
        "method",
        "difference",
        "JOD",
        "PSNR dB",
        "defocused dB",
        "worst block dB",
        "SSIM",
        "FLIP",
        "relMSE",
        "GPU ms",
        "copies",
    ];
    table.set_header(header).add_rows(json.results.iter().map(row));
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let left = json.not_run.iter().map(|left| format!("\n{} was left out: {}", left.method, left.reason));
    let good_enough = json.good_enough.as_ref();
    let good_enough = good_enough.map_or(String::new(), |found| "\n".to_owned() + &good_enough_in_words(found, json));
    format!("{}\n{table}{}{good_enough}", head(json), left.collect::<String>())
}

fn row(result: &ResultJson) -> [Cell; 11] {
    let m: &MetricsJson = &result.metrics;
    let number = |value: Option<f64>, decimals: usize| value.map_or("–".into(), |v| format!("{v:.decimals$}"));
    let psnr = if m.identical == Some(true) { "identical".into() } else { number(m.psnr_db, 2) };
    let texts = [
        result.method.into(),
        String::new(),
        number(m.jod, 2),
        psnr,
        number(m.psnr_defocused_db, 2),
        number(m.worst_block_psnr_db, 2),
        number(m.ssim, 4),
        number(m.flip, 4),
        number(m.rel_mse, 5),
        number(result.gpu_ms.map(|t| t.median), 3),
        number(result.copy_ratio.map(|t| t.median), 2),
    ];
    let mut cells = texts.map(Cell::new);
    if let Some(visibility) = m.visibility {
        let [r, g, b] = visibility.srgb8();
        cells[1] = Cell::new(visibility.word()).fg(Color::Rgb { r, g, b });
    }
    cells
}

fn head(json: &CompareJson) -> String {
    let setting = &json.setting;
    let [width, height] = setting.size;
    let coc = setting.coc.map_or(String::new(), |coc| format!(", mean CoC {:.2} px", coc.mean_px));
    let reference = json.reference.as_ref().map_or("none".into(), |r| {
        let samples = r.samples.map_or(String::new(), |n| format!(", {n} lens points"));
        let db = r.self_psnr_db.map_or(String::new(), |db| format!(", converged to about {db:.1} dB"));
        format!("{}{samples}{db}", r.method)
    });
    let ppd = json.viewing.px_per_degree;
    let screen = &json.viewing.screen;
    let seen = format!("{ppd:.2} px per degree, {} to {} cd/m2", screen.black_cd_m2, screen.peak_cd_m2);
    format!("{}, {width}x{height} px{coc}; {seen}; {}; reference: {reference}", setting.scene, setting.adapter)
}
