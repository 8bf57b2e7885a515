//! `defocus gauntlet`: random scenes against the reference.

mod shrinking;

use crate::cli::args::GauntletArgs;
use crate::cli::output::{check_json, is_stdout, print, print_json, write_json};
use crate::cli::progress::{Bar, catch_interrupts};
use crate::cli::select;
use anyhow::ensure;
use comfy_table::{ContentArrangement, Table, presets};
use defocus::gpu::{AdapterSummary, Gpu};
use defocus::methods::{self, Method};
use defocus_study::devices::devices;
use defocus_study::gauntlet::{
    self, Bounds, FAMILIES, GauntletRequest, KnownMethods, LEAST_POINTS, MOST_POINTS, Ranking, SceneResult, Spread,
    Statistics, TIE_DB, Which, family_by_name, known, known_bounds, ranking, statistics,
};
use serde::Serialize;
use std::time::Instant;

/// The method whose place among the others is what this project is judged by.
const OWN: &str = "adaptive";

/// Methods that are no rivals: no blur, and the truth itself.
const NOT_REAL_TIME: [&str; 2] = ["pinhole", "accumulation"];

/// Scenes where nothing is said.
const SCENES: u64 = 1000;

/// The same of a quick run.
const QUICK_SCENES: u64 = 100;

/// Scenes of the own method's losses that are printed; `--json` has all.
const SHOWN_LOSSES: usize = 10;

#[derive(Serialize)]
struct GauntletJson {
    adapter: AdapterSummary,
    seed: u64,
    size: [u32; 2],
    seconds: f64,
    /// Whether it ran to its end.
    complete: bool,
    /// Scenes whose reference does not agree with itself: in no statistics.
    unconverged: Vec<String>,
    statistics: Vec<Statistics>,
    ranking: Vec<Ranking>,
    scenes: Vec<SceneResult>,
}

/// Runs `defocus gauntlet`.
pub fn run(args: &GauntletArgs) -> anyhow::Result<()> {
    if args.families {
        return print_families();
    }
    let methods = chosen(args)?;
    let family = args.family.as_deref().map(family_by_name).transpose()?;
    let bounds = if args.check { Some(bounds_for(args)?) } else { None };
    let json = args.run.json.json.as_ref();
    check_json(json)?;
    catch_interrupts()?;
    let gpu = args.run.gpu()?;
    let adapter = gpu.adapter().clone();
    let start = Instant::now();
    let request = GauntletRequest {
        methods: &methods,
        seed: args.seed,
        scenes: args.scenes.unwrap_or(if args.quick { QUICK_SCENES } else { SCENES }),
        family,
        size: args.size,
        points: [LEAST_POINTS, MOST_POINTS],
    };
    let bar = Bar::new(args.run.quiet);
    let mut scenes = Vec::new();
    let gpus = devices(gpu, args.run.adapter.as_deref())?;
    if args.print_bounds {
        return print_bounds(args, &gpus, &request, &bar);
    }
    let ended = gauntlet::run(&gpus, &request, &mut scenes, &mut |step| bar.step(step));
    drop(bar);
    let ids: Vec<_> = methods.iter().map(|m| m.about().id).collect();
    let found = GauntletJson {
        adapter,
        seed: args.seed,
        size: args.size.to_array(),
        seconds: start.elapsed().as_secs_f64(),
        complete: ended.is_ok(),
        unconverged: scenes.iter().filter(|s| !s.agrees).map(|s| s.scene.clone()).collect(),
        statistics: ids.iter().map(|id| statistics(id, &scenes)).collect(),
        ranking: ids.iter().map(|id| ranking(id, &rivals(&ids), &scenes)).collect(),
        scenes,
    };
    if let Err(stopped) = ended {
        // Whoever stops it wants to know what it has; no file is left half done.
        if is_stdout(json) {
            print_json(&found)?
        } else {
            summarise(&found)?
        }
        return Err(stopped.into());
    }
    write_json(json, &found)?;
    if !args.run.quiet && !is_stdout(json) {
        summarise(&found)?;
    }
    if let Some(bounds) = bounds {
        check(&bounds, &request, &found.scenes)?;
    }
    match args.shrink {
        true => shrinking::run(&args.output, &gpus[0], &request, &found.statistics, &found.ranking, &found.scenes),
        false => Ok(()),
    }
}

fn which(request: &GauntletRequest<'_>) -> Which {
    Which { seed: request.seed, scenes: request.scenes, size: request.size.to_array() }
}

/// The bounds of `--check`, which hold for methods and frames as they are by default.
fn bounds_for(args: &GauntletArgs) -> anyhow::Result<Bounds> {
    let bounds = known_bounds().map_err(|e| anyhow::anyhow!("assets/gauntlet_bounds.ron holds no bounds: {e}"))?;
    ensure!(
        args.size.to_array() == bounds.same.size,
        "--check knows figures of frames of {}x{} px: leave out --size",
        bounds.same.size[0],
        bounds.same.size[1]
    );
    ensure!(args.settings.is_empty(), "--check knows figures of the methods as they are: leave out --set");
    Ok(bounds)
}

/// An error that names the first figure that is worse than it may be.
fn check(bounds: &Bounds, request: &GauntletRequest<'_>, scenes: &[SceneResult]) -> anyhow::Result<()> {
    let worse = bounds.regressions(&which(request), scenes);
    let more = worse.len().saturating_sub(1);
    match worse.first() {
        Some(first) if more > 0 => anyhow::bail!("{first}; so are {more} more"),
        Some(first) => anyhow::bail!("{first}"),
        None => Ok(()),
    }
}

/// Prints the bounds that two runs give: the one that is asked for, of as many scenes as a
/// quick one has, whose own figures are kept, and one of many scenes.
fn print_bounds(args: &GauntletArgs, gpus: &[Gpu], many: &GauntletRequest<'_>, bar: &Bar) -> anyhow::Result<()> {
    let same = GauntletRequest { scenes: QUICK_SCENES, ..*many };
    let many = GauntletRequest { seed: args.seed.wrapping_add(1), ..*many };
    let of = |request: &GauntletRequest<'_>| -> anyhow::Result<KnownMethods> {
        let mut scenes = Vec::new();
        gauntlet::run(gpus, request, &mut scenes, &mut |step| bar.step(step))?;
        Ok(known(&scenes))
    };
    let bounds = Bounds { same: which(&same), on_same: of(&same)?, on_many: of(&many)? };
    print(bounds.to_text().trim_end())
}

fn rivals(ids: &[&'static str]) -> Vec<&'static str> {
    ids.iter().copied().filter(|id| !NOT_REAL_TIME.contains(id)).collect()
}

fn chosen(args: &GauntletArgs) -> anyhow::Result<Vec<Box<dyn Method>>> {
    let mut methods = match &args.methods {
        Some(list) => select::methods(list)?,
        None => methods::all().into_iter().filter(|m| !NOT_REAL_TIME.contains(&m.about().id)).collect(),
    };
    select::apply(&args.settings, &mut methods)?;
    Ok(methods)
}

fn print_families() -> anyhow::Result<()> {
    let mut table = table(&["family", "what there is to see"]);
    for family in FAMILIES {
        table.add_row([family.name, family.about]);
    }
    print(&table.to_string())
}

fn summarise(found: &GauntletJson) -> anyhow::Result<()> {
    print(&format!("Adapter: {} ({})", found.adapter.name, found.adapter.driver))?;
    print(&method_table(&found.statistics))?;
    for one in &found.statistics {
        if let Some(first) = one.failed.first() {
            print(&format!("{} made no picture of {} scenes; the first: {first}", one.method, one.failed.len()))?;
        }
    }
    if let Some(own) = found.statistics.iter().find(|s| s.method == OWN) {
        print(&family_table(own))?;
    }
    if let Some(own) = found.ranking.iter().find(|r| r.method == OWN && r.scenes > 0) {
        print(&ranking_lines(own))?;
    }
    let stopped = if found.complete { "" } else { "; stopped before it was done" };
    print(&format!(
        "{} scenes, {} more whose reference does not agree with itself; {:.0} s{stopped}",
        found.scenes.len() - found.unconverged.len(),
        found.unconverged.len(),
        found.seconds
    ))
}

fn method_table(all: &[Statistics]) -> String {
    let mut table = table(&[
        "method",
        "mean dB",
        "1 % dB",
        "10 % dB",
        "50 % dB",
        "worst dB",
        "worst scene",
        "worst family",
        "block 1 %",
        "block 50 %",
        "light off 50 %",
        "light off 99 %",
        "light off most",
        "sharp 99 %",
        "smooth 99 %",
        "s",
    ]);
    for one in all {
        let db = |value: f64| format!("{value:.1}");
        let share = |spread: &Spread, value: f64| if spread.count == 0 { "–".into() } else { format!("{value:.3}") };
        let (psnr, light) = (&one.psnr_db, &one.light_error);
        table.add_row([
            one.method.to_owned(),
            format!("{:.2}", psnr.mean),
            db(psnr.p1),
            db(psnr.p10),
            db(psnr.p50),
            db(psnr.worst),
            psnr.worst_scene.clone(),
            one.worst_family.unwrap_or("–").into(),
            db(one.worst_block_db.p1),
            db(one.worst_block_db.p50),
            share(light, light.p50),
            share(light, light.p1),
            share(light, light.worst),
            share(&one.sharp_error, one.sharp_error.p1),
            share(&one.smooth_error, one.smooth_error.p1),
            format!("{:.0}", one.seconds),
        ]);
    }
    table.to_string()
}

fn family_table(own: &Statistics) -> String {
    let mut table = table(&["family", "scenes", "mean dB", "10 % dB", "50 % dB", "worst dB", "worst scene"]);
    for (family, spread) in &own.families {
        let db = |value: f64| format!("{value:.1}");
        table.add_row([
            (*family).to_owned(),
            spread.count.to_string(),
            db(spread.mean),
            db(spread.p10),
            db(spread.p50),
            db(spread.worst),
            spread.worst_scene.clone(),
        ]);
    }
    format!("{}, by family:\n{table}", own.method)
}

fn ranking_lines(own: &Ranking) -> String {
    let head = format!(
        "{}: the most exact, or within {TIE_DB} dB of it, on {:.1} % of {} scenes; at most {:.2} dB below the best",
        own.method,
        100.0 * own.best_share,
        own.scenes,
        own.greatest_loss_db
    );
    let loss = |(scene, better, db): &(String, &str, f64)| format!("\n  {db:5.2} dB below {better} on {scene}");
    head + &own.losses.iter().take(SHOWN_LOSSES).map(loss).collect::<String>()
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.iter().copied());
    table
}
