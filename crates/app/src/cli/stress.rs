//! `defocus stress`: numerical stability.

use super::args::{StressArgs, StressPart};
use super::output::{check_json, is_stdout, print, print_json, write_json};
use super::progress::{Bar, catch_interrupts};
use super::select;
use comfy_table::{ContentArrangement, Table, presets as styles};
use defocus::gpu::{AdapterSummary, Gpu};
use defocus::methods::Method;
use defocus_study::stress::precision::{ACCEPTABLE_LOSS_DB, PrecisionRow, measure};
use defocus_study::stress::soak::{GROWTH_A_FRAME_BYTES, Soak, soak};
use defocus_study::stress::{self, Outcome, StressRequest};
use serde::Serialize;
use std::time::{Instant, SystemTime};

/// Frames of the soak after its warm-up.
const SOAK_FRAMES: u32 = 1000;

/// Failures printed; `--json` has all.
const SHOWN_FAILURES: usize = 20;

#[derive(Serialize)]
struct StressJson {
    adapter: AdapterSummary,
    quick: bool,
    seed: u64,
    seconds: f64,
    /// Whether it ran to its end.
    complete: bool,
    outcome: Option<Outcome>,
    precision: Option<Vec<PrecisionRow>>,
    soak: Option<Soak>,
}

/// Runs `defocus stress`; an error where anything failed.
pub fn run(args: &StressArgs) -> anyhow::Result<()> {
    let methods = select::methods(&args.methods)?;
    let json = args.run.json.json.as_ref();
    check_json(json)?;
    catch_interrupts()?;
    let gpu = args.run.gpu()?;
    let start = Instant::now();
    let mut found = StressJson {
        adapter: gpu.adapter().clone(),
        quick: args.quick,
        seed: seed(args),
        seconds: 0.0,
        complete: false,
        outcome: None,
        precision: None,
        soak: None,
    };
    let ended = find(args, &gpu, &methods, &mut found);
    found.seconds = start.elapsed().as_secs_f64();
    found.complete = ended.is_ok();
    if let Err(stopped) = ended {
        // Whoever stops it wants to know what it has, `--quiet` or not; no file is left half
        // done.
        if is_stdout(json) {
            print_json(&found)?
        } else {
            summarise(&found)?
        }
        return Err(stopped);
    }
    write_json(json, &found)?;
    if !args.run.quiet && !is_stdout(json) {
        summarise(&found)?;
    }
    pane_metrics(&found)
}

/// Seconds of a day.
const DAY_S: u64 = 24 * 60 * 60;

/// The seed that is asked for, or that of the day.
fn seed(args: &StressArgs) -> u64 {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    args.seed.unwrap_or(if args.quick { since_1970.as_secs() / DAY_S } else { 1 })
}

/// Runs the parts that are wanted. What they found is in `found` also if they are stopped.
fn find(args: &StressArgs, gpu: &Gpu, methods: &[Box<dyn Method>], found: &mut StressJson) -> anyhow::Result<()> {
    let bar = Bar::new(args.run.quiet);
    let wanted = |part| args.only.is_none_or(|only| only == part);
    if wanted(StressPart::Cases) {
        let gpus = stress::devices(gpu.clone(), args.run.adapter.as_deref())?;
        let request = StressRequest { methods, quick: args.quick, seed: found.seed };
        let outcome = found.outcome.insert(Outcome::default());
        stress::run(&gpus, &request, outcome, &mut |step| bar.step(step))?;
    }
    if wanted(StressPart::F16) {
        found.precision = Some(measure(gpu, methods, args.quick, &mut |step| bar.step(step))?);
    }
    if wanted(StressPart::Soak) {
        found.soak = Some(soak(gpu, &stress::prepared(methods), SOAK_FRAMES, &mut |step| bar.step(step))?);
    }
    Ok(())
}

fn summarise(result: &StressJson) -> anyhow::Result<()> {
    print(&format!("Adapter: {} ({})", result.adapter.name, result.adapter.driver))?;
    print(&format!("Seed: {} (--seed {} repeats it)", result.seed, result.seed))?;
    if let Some(outcome) = &result.outcome {
        report_outcome(outcome)?;
    }
    if let Some(rows) = &result.precision {
        print(&precision_table(rows).to_string())?;
    }
    if let Some(soak) = &result.soak {
        print(&soak_line(soak))?;
    }
    if !result.complete {
        print("stopped before it was done")?;
    }
    print(&format!("{:.0} s", result.seconds))
}

fn report_outcome(outcome: &Outcome) -> anyhow::Result<()> {
    let mut table = table(["method", "cases", "checks", "failed", "known limits", "seconds"]);
    for (method, tally) in &outcome.methods {
        let counts = [tally.cases, tally.checks, tally.failed, tally.expected].map(|n| n.to_string());
        table.add_row([method.to_string()].into_iter().chain(counts).chain([format!("{:.1}", tally.seconds)]));
    }
    print(&table.to_string())?;
    for failure in outcome.unexpected().take(SHOWN_FAILURES) {
        print(&failure.to_string())?;
    }
    for pass in &outcome.unexpected_passes {
        print(pass)?;
    }
    let total = outcome.total();
    print(&format!(
        "{} cases, {} checks, {} failures, {} known limits shown",
        total.cases, total.checks, total.failed, total.expected
    ))
}

fn precision_table(rows: &[PrecisionRow]) -> Table {
    let mut table =
        table(["method", "scene", "f16 dB", "f32 dB", "f16 costs dB", "f16 to f32 dB", "greatest difference"]);
    let db = |value: Option<f64>| value.map_or("equal".to_owned(), |v| format!("{v:.2}"));
    for row in rows {
        table.add_row([
            row.method.to_owned(),
            row.scene.clone(),
            db(row.half_psnr_db),
            db(row.full_psnr_db),
            format!("{:.4}", row.loss_db()),
            db(row.between_psnr_db),
            format!("{:.1e}", row.greatest_difference),
        ]);
    }
    table
}

fn soak_line(soak: &Soak) -> String {
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let process = soak
        .process_growth_a_frame()
        .map_or("not told by this system".to_owned(), |growth| format!("{:+.0} bytes a frame", growth));
    format!(
        "{} frames: the texture pool held {:.2} MiB at most, {:.2} MiB while warming up; process memory: {process}",
        soak.frames,
        mib(soak.pool_bytes),
        mib(soak.pool_warm_bytes)
    )
}

fn pane_metrics(result: &StressJson) -> anyhow::Result<()> {
    result.outcome.as_ref().map_or(Ok(()), judge_outcome)?;
    judge_precision(result.precision.as_deref().unwrap_or_default())?;
    result.soak.as_ref().map_or(Ok(()), judge_soak)
}

fn judge_outcome(outcome: &Outcome) -> anyhow::Result<()> {
    if let Some(first) = outcome.unexpected().next() {
        let total = outcome.total();
        anyhow::bail!("{} of {} cases failed; the first: {first}", total.failed, total.cases);
    }
    match outcome.unexpected_passes.first() {
        Some(first) => anyhow::bail!("{first}"),
        None => Ok(()),
    }
}

fn judge_precision(rows: &[PrecisionRow]) -> anyhow::Result<()> {
    match rows.iter().find(|row| row.loss_db() > ACCEPTABLE_LOSS_DB) {
        Some(row) => anyhow::bail!(
            "{}: f16 costs {:.2} dB on {}, more than {ACCEPTABLE_LOSS_DB} dB: an intermediate needs f32",
            row.method,
            row.loss_db(),
            row.scene
        ),
        None => Ok(()),
    }
}

fn judge_soak(soak: &Soak) -> anyhow::Result<()> {
    anyhow::ensure!(
        soak.is_bounded(),
        "memory grows from frame to frame ({}; the limit is {GROWTH_A_FRAME_BYTES} bytes): something is kept that should be freed",
        soak_line(soak)
    );
    Ok(())
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_preset(styles::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header);
    table
}
