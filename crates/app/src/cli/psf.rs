//! `defocus psf`: each method's point spread function beside the lens's own.

use super::args::{PsfArgs, PsfSide};
use super::output::{check_json, check_target, command_line, is_stdout, print, write_json};
use super::progress::{Bar, catch_interrupts, check_interrupt};
use super::select;
use anyhow::{Context, ensure};
use comfy_table::{CellAlignment, Table, presets};
use defocus::image_io::{write_atomically, write_exr, write_png_rgb};
use defocus::lens::Lens;
use defocus_study::psf::report::{PsfPage, csv, html, picture, sheet};
use defocus_study::psf::{Psf, Side, measure};
use serde::Serialize;
use std::io::Write;

/// Widest CoC, px, that is measured: the picture has about four times its area.
const WIDEST_PX: f64 = 256.0;

#[derive(Serialize)]
struct PsfJson<'a> {
    adapter: &'a str,
    aperture: String,
    psfs: &'a [Psf],
}

/// Runs the command.
pub fn run(args: &PsfArgs) -> anyhow::Result<()> {
    catch_interrupts()?;
    check_json(args.run.json.json.as_ref())?;
    args.output.as_deref().map_or(Ok(()), check_target)?;
    for px in &args.cocs {
        ensure!((0.1..=WIDEST_PX).contains(px), "--coc {px}: give CoC diameters from 0.1 to {WIDEST_PX} px");
    }
    let mut methods = select::methods(&args.methods)?;
    select::apply(&args.settings, &mut methods)?;
    let lens = Lens { aperture: args.aperture.clone().unwrap_or_default(), ..Lens::PINHOLE };
    lens.check()?;
    let gpu = args.run.gpu()?;
    let bar = Bar::new(args.run.quiet);
    let side = match args.side {
        PsfSide::Front => Side::Front,
        PsfSide::Behind => Side::Behind,
    };
    let found = measure(&gpu, &lens, &methods, (&args.cocs, side), &mut |step| bar.step(step))?;
    drop(bar);
    check_interrupt()?;
    let adapter = &gpu.adapter().name;
    if let Some(folder) = &args.output {
        let page = PsfPage { found: &found, adapter, aperture: &lens.aperture, command: &command_line() };
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make it; check that its folder may be written", folder.display()))?;
        let text = html(&page).context("cannot make the page")?;
        write_atomically(&folder.join("psf.html"), |file| file.write_all(text.as_bytes()))?;
        let lines = csv(&found).context("cannot make the table")?;
        write_atomically(&folder.join("psf.csv"), |file| file.write_all(&lines))?;
        write_png_rgb(&folder.join("psf.png"), &picture(&found))?;
    }
    if let Some(file) = &args.export {
        write_exr(file, &sheet(&found), None, None)?;
    }
    write_json(args.run.json.json.as_ref(), &PsfJson { adapter, aperture: lens.aperture.to_string(), psfs: &found })?;
    if !is_stdout(args.run.json.json.as_ref()) {
        print(&table(&found))?;
    }
    Ok(())
}

fn table(found: &[Psf]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["method", "CoC px", "energy", "sigma px", "lens's", "centroid px", "symmetry", "MTF error"]);
    for psf in found {
        let [x, y] = psf.centroid_px;
        table.add_row([
            psf.method.to_owned(),
            psf.coc_px.to_string(),
            format!("{:.4}", psf.energy),
            format!("{:.3}", psf.sigma_px),
            format!("{:.3}", psf.lens_sigma_px),
            format!("{x:+.3}, {y:+.3}"),
            format!("{:.3}", psf.symmetry),
            format!("{:.3}", psf.mtf_error),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}
