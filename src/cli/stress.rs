//! `defocus stress`: numerical stability.

use super::args::StressArgs;
use super::output::{check_json, is_stdout, print, print_json, write_json};
use super::progress::{Bar, catch_interrupts};
use super::select;
use comfy_table::{ContentArrangement, Table, presets as styles};
use defocus::gpu::{AdapterSummary, Gpu};
use defocus::study::stress::precision::{ACCEPTABLE_LOSS_DB, PrecisionRow, measure};
use defocus::study::stress::soak::{GROWTH_A_FRAME_BYTES, Soak, soak};
use defocus::study::stress::{self, Outcome, StressRequest};
use serde::Serialize;
use std::time::Instant;

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
    outcome: Outcome,
    precision: Vec<PrecisionRow>,
    soak: Soak,
}

/// Runs `defocus stress`; an error where anything failed.
pub fn run(args: &StressArgs) -> anyhow::Result<()> {
    let methods = select::methods(&args.methods)?;
    let json = args.run.json.json.as_ref();
    check_json(json)?;
    catch_interrupts()?;
    let adapter = args.run.adapter.as_deref();
    let gpu = Gpu::open(adapter)?;
    let start = Instant::now();
    let bar = Bar::new(args.run.quiet);
    let request = StressRequest { methods: &methods, quick: args.quick, seed: args.seed };
    let mut outcome = Outcome::default();
    let gpus = stress::devices(gpu.clone(), adapter)?;
    if let Err(stopped) = stress::run(&gpus, &request, &mut outcome, &mut |step| bar.step(step)) {
        drop(bar);
        // Whoever stops it wants to know, `--quiet` or not.
        report_stopped(json.is_some(), &outcome)?;
        return Err(stopped.into());
    }
    drop(gpus);
    let precision = measure(&gpu, &methods, args.quick, &mut |step| bar.step(step))?;
    let soak = soak(&gpu, &stress::prepared(&methods), SOAK_FRAMES, &mut |step| bar.step(step))?;
    drop(bar);
    let seconds = start.elapsed().as_secs_f64();
    let adapter = gpu.adapter().clone();
    let result = StressJson { adapter, quick: args.quick, seed: args.seed, seconds, outcome, precision, soak };
    write_json(json, &result)?;
    if !args.run.quiet && !is_stdout(json) {
        summarise(&result)?;
    }
    verdict(&result)
}

fn summarise(result: &StressJson) -> anyhow::Result<()> {
    print(&format!("Adapter: {} ({})", result.adapter.name, result.adapter.driver))?;
    report_outcome(&result.outcome)?;
    print(&precision_table(&result.precision).to_string())?;
    print(&soak_line(&result.soak))?;
    let total = result.outcome.total();
    print(&format!(
        "{} cases, {} checks, {} failures, {} known limits shown, {:.0} s",
        total.cases, total.checks, total.failed, total.expected, result.seconds
    ))
}

/// What was found so far: as JSON where that was asked for, on standard output in any case,
/// as no file is left half done.
fn report_stopped(json: bool, outcome: &Outcome) -> anyhow::Result<()> {
    if json { print_json(outcome) } else { report_outcome(outcome) }
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
    Ok(())
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

fn verdict(result: &StressJson) -> anyhow::Result<()> {
    if let Some(first) = result.outcome.unexpected().next() {
        anyhow::bail!(
            "{} of {} cases failed; the first: {first}",
            result.outcome.total().failed,
            result.outcome.total().cases
        );
    }
    if let Some(first) = result.outcome.unexpected_passes.first() {
        anyhow::bail!("{first}");
    }
    if let Some(row) = result.precision.iter().find(|row| row.loss_db() > ACCEPTABLE_LOSS_DB) {
        anyhow::bail!(
            "{}: f16 costs {:.2} dB on {}, more than {ACCEPTABLE_LOSS_DB} dB: an intermediate needs f32",
            row.method,
            row.loss_db(),
            row.scene
        );
    }
    anyhow::ensure!(
        result.soak.is_bounded(),
        "memory grows from frame to frame ({}; the limit is {GROWTH_A_FRAME_BYTES} bytes): something is kept that should be freed",
        soak_line(&result.soak)
    );
    Ok(())
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_preset(styles::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header);
    table
}
