//! `--shrink`: the worst scenes of a method, made as small as still shows what is wrong.

use super::OWN;
use crate::cli::output::print;
use crate::cli::progress::check_interrupt;
use anyhow::Context;
use defocus::gpu::Gpu;
use defocus::image_io::write_atomically;
use defocus_study::StudyError;
use defocus_study::gauntlet::{
    self, CAP_DB, GauntletRequest, Ranking, SceneResult, SceneSpec, Statistics, TIE_DB, counted_db, examine, shrink,
};
use std::io::Write;
use std::path::Path;

/// Scenes that are made smaller.
const SHRUNK_SCENES: usize = 3;

/// Scenes tried for each of them.
const MOST_TRIES: u32 = 300;

/// Share of what is wrong that a smaller scene must still show.
const SHOWN_SHARE: f64 = 0.8;

/// A scene with what is wrong on it.
struct Fault {
    scene: String,
    method: &'static str,
    /// The method that is better; none where it is only far from the truth.
    better: Option<&'static str>,
    /// How far below the better one, or below [`CAP_DB`].
    loss_db: f64,
}

/// Shrinks the worst scenes of the own method, or of the first where that was not run, into
/// files of `folder`, and prints them.
pub fn run(
    folder: &Path,
    gpu: &Gpu,
    request: &GauntletRequest<'_>,
    statistics: &[Statistics],
    rankings: &[Ranking],
    scenes: &[SceneResult],
) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot make this folder", folder.display()))?;
    for fault in faults(statistics, rankings, scenes) {
        let Some(spec) = found_again(&fault.scene, request) else { continue };
        let methods: Vec<_> = request.methods.iter().filter(|m| involved(&fault, m.about().id)).cloned().collect();
        let shrunk = shrink(&spec, MOST_TRIES, |spec| {
            if check_interrupt().is_err() {
                return Err(StudyError::Stopped);
            }
            let result = examine(gpu, spec, "", &methods, request.points)?;
            Ok(result.agrees && loss_db(&fault, &result) >= SHOWN_SHARE * fault.loss_db)
        })?;
        let name = format!("{}.ron", fault.scene.trim_start_matches(gauntlet::PREFIX).replace(':', "-"));
        let file = folder.join(name);
        let smaller = SceneSpec { name: format!("part of {}", fault.scene), ..shrunk.spec };
        write_atomically(&file, |out| out.write_all(smaller.to_text().as_bytes()))?;
        print(&describe(&fault, &spec, &smaller, &file))?;
    }
    Ok(())
}

fn faults(statistics: &[Statistics], rankings: &[Ranking], scenes: &[SceneResult]) -> Vec<Fault> {
    let Some(method) =
        statistics.iter().map(|s| s.method).find(|id| *id == OWN).or(statistics.first().map(|s| s.method))
    else {
        return Vec::new();
    };
    let losses = rankings.iter().filter(|r| r.method == method).flat_map(|r| &r.losses);
    let losses = losses.map(|(scene, better, loss_db)| Fault {
        scene: scene.clone(),
        method,
        better: Some(*better),
        loss_db: *loss_db,
    });
    let mut found: Vec<_> = losses.collect();
    if found.is_empty() {
        // Nobody is better: what is farthest from the truth.
        let of = |result: &SceneResult| Some(CAP_DB - counted_db(result.methods.get(method)?));
        let all = scenes.iter().filter(|r| r.agrees).filter_map(|r| Some((r.scene.clone(), of(r)?)));
        found.extend(all.filter(|f| f.1 > TIE_DB).map(|(scene, loss_db)| Fault {
            scene,
            method,
            better: None,
            loss_db,
        }));
        found.sort_by(|a, b| b.loss_db.total_cmp(&a.loss_db));
    }
    found.truncate(SHRUNK_SCENES);
    found
}

/// The scene of that name at the size of the run.
fn found_again(name: &str, request: &GauntletRequest<'_>) -> Option<SceneSpec> {
    let (family, seed) = name.strip_prefix(gauntlet::PREFIX)?.split_once(':')?;
    Some(gauntlet::generate(gauntlet::family(family)?, seed.parse().ok()?, request.size))
}

fn involved(fault: &Fault, id: &str) -> bool {
    id == fault.method || fault.better == Some(id)
}

fn loss_db(fault: &Fault, result: &SceneResult) -> f64 {
    let db = |id: &str| result.methods.get(id).map(counted_db);
    let best = fault.better.map_or(Some(CAP_DB), db).unwrap_or(0.0);
    best - db(fault.method).unwrap_or(CAP_DB)
}

fn describe(fault: &Fault, before: &SceneSpec, after: &SceneSpec, file: &Path) -> String {
    let against = fault.better.map_or_else(|| format!("{CAP_DB} dB"), str::to_owned);
    format!(
        "{}: {} {:.1} dB below {against}; {} quads at {}x{} became {} at {}x{}, in {}:\n{}",
        fault.scene,
        fault.method,
        fault.loss_db,
        before.quads.len(),
        before.size_px[0],
        before.size_px[1],
        after.quads.len(),
        after.size_px[0],
        after.size_px[1],
        file.display(),
        after.to_text()
    )
}
