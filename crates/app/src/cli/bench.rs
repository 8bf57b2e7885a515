//! `defocus bench`: run time against error, and the papers' tables.

use super::args::{BenchAction, BenchArgs, MergeArgs};
use super::output::{check_json, command_line, is_stdout, print, write_json};
use super::progress::{Bar, catch_interrupts, check_interrupt};
use super::select;
use anyhow::{Context, ensure};
use comfy_table::{ContentArrangement, Table, presets};
use defocus::methods::Method;
use defocus::view::Input;
use defocus_study::bench::plan::{MEAN_COCS_PX, Trade, variants};
use defocus_study::bench::report::{self, ReportInput};
use defocus_study::bench::tables::{self, Claim, Comparison, PaperTable};
use defocus_study::bench::{BenchOutcome, BenchResults, BenchRun, Blur, Plan, Shard, Store};
use defocus_study::{builtin, flicker};
use glam::UVec2;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Minutes after which a quick table stops, unless --budget says otherwise: with drawing up
/// the report that stays under five.
const QUICK_BUDGET_MINUTES: f64 = 4.0;

/// What `--quick` leaves out of a table, for its report.
const TABLE_CAPS: &str = "Quick: small images, few lens points for the reference or none, few runs, nothing that takes minutes by itself, at most 4 minutes (--budget says otherwise). Without --quick the table is measured at the paper's size.";

/// What `--quick` leaves out of a sweep, for its report.
const SWEEP_CAPS: &str = "Quick: images of 256x192, cans and atrium, mean CoCs of 4, 16 and 64 px, 64 lens points for the reference and 3 runs, where nothing else was asked for.";

/// Runs the command.
pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    match &args.action {
        Some(BenchAction::Merge(merge)) => run_merge(merge),
        None => run_bench(args),
    }
}

fn run_bench(args: &BenchArgs) -> anyhow::Result<()> {
    catch_interrupts()?;
    check_json(args.run.json.json.as_ref())?;
    if let Some(minutes) = args.budget {
        ensure!(minutes > 0.0 && minutes.is_finite(), "--budget is {minutes} minutes; give a finite number above 0");
    }
    if args.table == Some(PaperTable::TvcgFlicker) {
        return run_flicker(args);
    }
    let plan = plan(args)?;
    let store = Store::open(&args.output, &plan)?;
    let gpu = args.run.gpu()?;
    let cache = args.cache.cache();
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let minutes = args.budget.or((args.quick && args.table.is_some()).then_some(QUICK_BUDGET_MINUTES));
    let deadline = minutes.map(|minutes| Instant::now() + Duration::from_secs_f64(60.0 * minutes));
    let bench = BenchRun { plan: &plan, shard, store: &store, cache: cache.as_ref(), deadline };
    let bar = Bar::new(args.run.quiet);
    let outcome = bench.run(&gpu, &mut |step| bar.step(step))?;
    drop(bar);
    check_interrupt()?;
    if let Some(problem) = &outcome.cache_problem {
        eprintln!("defocus: references are not kept for the next time: {problem}");
    }
    let caps = match (args.quick, args.table) {
        (true, Some(_)) => TABLE_CAPS,
        (true, None) => SWEEP_CAPS,
        (false, _) => "",
    };
    let results = store.results(&plan)?;
    let table = args.table.map(|table| table.compared(&results));
    write_report(&store, &results, table.as_ref(), caps)?;
    finish(args, &results, table.as_ref(), &outcome)
}

/// Measures flicker, which has no cells: all at once, into `table.json`.
fn run_flicker(args: &BenchArgs) -> anyhow::Result<()> {
    let no_cells = args.settings.is_empty() && args.overscan.is_none() && args.budget.is_none() && args.shard.is_none();
    ensure!(no_cells, "tvcg-flicker is measured as a whole: leave out --set, --overscan, --budget and --shard");
    let plan = flicker::Plan::table(args.quick);
    let plan = flicker::Plan { samples: args.samples.unwrap_or(plan.samples), ..plan };
    let gpu = args.run.gpu()?;
    let bar = Bar::new(args.run.quiet);
    let flickers = flicker::flicker(&gpu, &plan, &mut |step| bar.step(step))?;
    drop(bar);
    check_interrupt()?;
    let table = flicker::compared(&plan, &gpu.adapter().name, &flickers);
    let file = args.output.join("table.json");
    std::fs::create_dir_all(&args.output)
        .and_then(|()| std::fs::write(&file, serde_json::to_vec_pretty(&table)?))
        .with_context(|| format!("{}: cannot write it; check that its folder may be written", file.display()))?;
    write_json(args.run.json.json.as_ref(), &table)?;
    if !args.run.quiet && !is_stdout(args.run.json.json.as_ref()) {
        print(&format!("{}\nsee {}", shown(&table), file.display()))?;
    }
    Ok(())
}

fn run_merge(args: &MergeArgs) -> anyhow::Result<()> {
    let (store, plan) = Store::merge(&args.parts, &args.output)?;
    let results = store.results(&plan)?;
    let table = tables::ALL.iter().map(|(_, table)| *table);
    let table = table.into_iter().find(|t| t.plan(false) == plan || t.plan(true) == plan).map(|t| t.compared(&results));
    write_report(&store, &results, table.as_ref(), "")?;
    let (done, wanted) = (results.cells.len(), results.cells_wanted);
    print(&format!("{done} of {wanted} cells; see {}", args.output.join("report.html").display()))
}

/// What there is to measure.
fn plan(args: &BenchArgs) -> anyhow::Result<Plan> {
    let plan = match args.table {
        Some(table) => with_settings(table.plan(args.quick), &args.settings)?,
        None => sweep(args)?,
    };
    Ok(Plan {
        overscan_px: args.overscan.or(plan.overscan_px),
        runs: args.runs.unwrap_or(plan.runs),
        warmup: args.warmup.unwrap_or(plan.warmup),
        reference_samples: args.samples.or(plan.reference_samples),
        redraw: args.redraw || plan.redraw,
        count_reads: args.count_reads || plan.count_reads,
        ..plan
    })
}

/// A table's plan with every `--set [ID.]KEY=VALUE` in all variants that have the key.
fn with_settings(mut plan: Plan, settings: &[String]) -> anyhow::Result<Plan> {
    for setting in settings {
        let (name, value) =
            setting.split_once('=').with_context(|| format!("--set {setting}: give [ID.]KEY=VALUE, such as k=0.5"))?;
        let (id, key) = name.split_once('.').map_or((None, name), |(id, key)| (Some(id), key));
        let mut is_used = false;
        for variant in plan.variants.iter_mut().filter(|v| id.is_none_or(|id| id == v.method)) {
            if select::has_param(variant.method()?.as_ref(), key) {
                variant.settings.retain(|(k, _)| k != key);
                variant.settings.push((key.to_owned(), value.to_owned()));
                variant.method()?;
                is_used = true;
            }
        }
        ensure!(
            is_used,
            "--set {setting}: no method of the table has it; `defocus methods` lists the parameters of each"
        );
    }
    Ok(plan)
}

fn sweep(args: &BenchArgs) -> anyhow::Result<Plan> {
    let quick = args.quick;
    let mut methods = select::methods(args.methods.as_deref().unwrap_or("all"))?;
    // A copy of the input says nothing about time or error that the copy does not say.
    if args.methods.is_none() {
        methods.retain(|m| m.about().id != "pinhole");
    }
    select::as_published(args.as_published, &mut methods);
    select::apply(&args.settings, &mut methods)?;
    let scenes = match (&args.scenes, quick) {
        (Some(list), _) if list == "all" => all_scenes(),
        (Some(list), _) => list.split(',').map(|scene| scene.trim().to_owned()).collect(),
        (None, true) => vec!["cans".into(), "atrium".into()],
        (None, false) => all_scenes(),
    };
    let sizes = match (args.sizes.is_empty(), quick) {
        (false, _) => args.sizes.iter().map(UVec2::to_array).collect(),
        (true, true) => vec![[256, 192]],
        (true, false) => vec![[512, 384], [1024, 768], [1920, 1080], [3840, 2160]],
    };
    let cocs_px = match (args.cocs.is_empty(), quick) {
        (false, _) => args.cocs.clone(),
        (true, true) => vec![4.0, 16.0, 64.0],
        (true, false) => MEAN_COCS_PX.to_vec(),
    };
    for px in &cocs_px {
        ensure!(px.is_finite() && *px > 0.0, "--coc {px}: give CoC diameters in px, finite and above 0");
    }
    Ok(Plan {
        scenes,
        sizes,
        blurs: cocs_px.into_iter().map(Blur::MeanCocPx).collect(),
        variants: sweep_variants(args, &methods)?,
        reference_samples: Some(if quick { 64 } else { 1024 }),
        reference_only_at: None,
        warmup: 1,
        runs: if quick { 3 } else { 9 },
        redraw: false,
        count_reads: false,
        error_maps: true,
        overscan_px: None,
        view_dependent: false,
        input: Input::Hdr,
    })
}

fn sweep_variants(args: &BenchArgs, methods: &[Box<dyn Method>]) -> anyhow::Result<Vec<defocus_study::bench::Variant>> {
    let trades = args.sweeps.iter().map(|text| trade(text)).collect::<Result<Vec<_>, _>>()?;
    Ok(variants(methods, &trades)?)
}

fn trade(text: &str) -> anyhow::Result<Trade> {
    let example = "give [ID.]KEY=VALUE,VALUE,..., such as multiview.samples=16,64";
    let (name, values) = text.split_once('=').with_context(|| format!("--sweep {text}: {example}"))?;
    let (method, key) = name.split_once('.').map_or((None, name), |(id, key)| (Some(id.to_owned()), key));
    let values = values.split(',').map(|value| value.trim().to_owned()).collect();
    Ok(Trade { method, key: key.into(), values })
}

fn all_scenes() -> Vec<String> {
    builtin::all().iter().map(|scene| scene.name.to_owned()).collect()
}

#[derive(Serialize)]
struct BenchJson<'a> {
    #[serde(flatten)]
    results: &'a BenchResults,
    table: Option<&'a Comparison>,
}

fn write_report(store: &Store, results: &BenchResults, table: Option<&Comparison>, caps: &str) -> anyhow::Result<()> {
    let command = command_line();
    let html =
        report::html(&ReportInput { results, table, caps, command: &command }).context("cannot make the report")?;
    store.write("results.json", &serde_json::to_vec_pretty(&BenchJson { results, table })?)?;
    store.write("results.csv", &results.csv().context("cannot make the CSV file")?)?;
    store.write("report.html", html.as_bytes())?;
    Ok(())
}

fn finish(
    args: &BenchArgs,
    results: &BenchResults,
    table: Option<&Comparison>,
    outcome: &BenchOutcome,
) -> anyhow::Result<()> {
    write_json(args.run.json.json.as_ref(), &BenchJson { results, table })?;
    if args.run.quiet || is_stdout(args.run.json.json.as_ref()) {
        return Ok(());
    }
    if let Some(table) = table {
        print(&shown(table))?;
    }
    let BenchOutcome { measured, found, left, .. } = outcome;
    let mut summary = format!("{measured} cells measured");
    if *found > 0 {
        summary += &format!(", {found} found from before");
    }
    if *left > 0 {
        summary += &format!(", {left} left for want of time: run the command again to go on");
    }
    print(&format!("{summary}; see {}", args.output.join("report.html").display()))
}

/// A paper's table beside its measurement, for a terminal.
fn shown(comparison: &Comparison) -> String {
    let mut grid = styled();
    grid.set_header(&comparison.columns).add_rows(&comparison.rows);
    let mut claims = styled();
    claims.set_header(["paper", "measured", "agrees"]);
    let pane_metrics = |claim: &Claim| match claim.holds {
        Some(true) => "yes".to_owned(),
        Some(false) => format!("no. {}", claim.reason),
        None => "not measured".to_owned(),
    };
    claims.add_rows(comparison.claims.iter().map(|c| [c.paper.clone(), c.measured.clone(), pane_metrics(c)]));
    let notes = comparison.notes.join("\n");
    format!("{}\n{}\n{grid}\n{claims}\n{notes}", comparison.title, comparison.setting)
}

fn styled() -> Table {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    table
}
