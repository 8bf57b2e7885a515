//! `defocus diff`: metrics of two images.

use super::args::DiffArgs;
use super::output::{check_json, is_stdout, print, write_json};
use comfy_table::{Table, presets};
use defocus::image_io::read_color;
use defocus::viewing::Viewing;
use defocus_study::metrics::{CompareOptions, compare};
use defocus_study::results::MetricsJson;
use serde::Serialize;
use std::path::Path;

/// The JSON of a difference.
#[derive(Serialize)]
struct DiffJson<'a> {
    image: &'a Path,
    reference: &'a Path,
    size: [u32; 2],
    #[serde(flatten)]
    metrics: MetricsJson,
}

/// Runs the command.
pub fn run(args: &DiffArgs) -> anyhow::Result<()> {
    check_json(args.json.json.as_ref())?;
    let (image, reference) = (read_color(&args.image)?, read_color(&args.reference)?);
    let viewing = Viewing { screen: args.display.screen(None)?, ..Viewing::default() }.with_ppd(args.display.ppd);
    let options = CompareOptions { display: args.display.display(), viewing, ..Default::default() };
    let metrics = MetricsJson::from(&compare(&image, &reference, &options)?);
    let size = image.size.to_array();
    write_json(
        args.json.json.as_ref(),
        &DiffJson { image: &args.image, reference: &args.reference, size, metrics: metrics.clone() },
    )?;
    if !is_stdout(args.json.json.as_ref()) {
        print(&table(&metrics).to_string())?;
    }
    Ok(())
}

fn table(metrics: &MetricsJson) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY);
    let mut row = |name: &str, value: Option<String>| {
        table.add_row([name.to_owned(), value.unwrap_or_else(|| "–".into())]);
    };
    row("identical", metrics.identical.map(|same| if same { "yes" } else { "no" }.into()));
    row("PSNR", metrics.psnr_db.map(|db| format!("{db:.2} dB")));
    row("SSIM", metrics.ssim.map(|v| format!("{v:.5}")));
    let at = metrics.ppd.map_or(String::new(), |ppd| format!(" at {ppd:.2} px per degree"));
    row("FLIP", metrics.flip.map(|v| format!("{v:.5}{at}")));
    let seen = metrics.visibility.map_or(String::new(), |v| format!(", {v}"));
    row("JOD", metrics.jod.map(|v| format!("{v:.3}{seen}")));
    row("relMSE", metrics.rel_mse.map(|v| format!("{v:.6}")));
    let at = metrics.worst_block.map_or(String::new(), |[x, y]| format!(" at {x},{y}"));
    row("worst block", metrics.worst_block_psnr_db.map(|db| format!("{db:.2} dB{at}")));
    table
}
