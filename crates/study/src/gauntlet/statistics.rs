//! Results of many scenes.

use super::{FAMILIES, MethodFigures, SceneResult};
use std::collections::BTreeMap;

/// PSNR, dB, above which methods count as equally exact: differences are then invisible and
/// within the reference's own.
pub const CAP_DB: f64 = 50.0;

/// Difference, dB, up to which two methods are equally exact.
pub const TIE_DB: f64 = 0.3;

/// How a figure is spread over scenes, from bad to good.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Spread {
    /// Scenes.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// 1st percentile: of the bad end.
    pub p1: f64,
    /// 10th percentile.
    pub p10: f64,
    /// Median.
    pub p50: f64,
    /// Worst.
    pub worst: f64,
    /// The scene of the worst.
    pub worst_scene: String,
}

/// What one method did.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Statistics {
    /// The method's id.
    pub method: &'static str,
    /// PSNR, dB, at most [`CAP_DB`].
    pub psnr_db: Spread,
    /// The same of the worst block of each scene.
    pub worst_block_db: Spread,
    /// Difference of the light kept from 1, over scenes with lights.
    pub light_error: Spread,
    /// Greatest difference of display values where the truth is sharp.
    pub sharp_error: Spread,
    /// The same where the truth is smooth.
    pub smooth_error: Spread,
    /// PSNR by family, dB, at most [`CAP_DB`].
    pub families: BTreeMap<&'static str, Spread>,
    /// The family with the lowest mean.
    pub worst_family: Option<&'static str>,
    /// Time that it took on the clock over all scenes, s.
    pub seconds: f64,
    /// Scenes on which it made no picture, or one that holds what is no number: 0 dB.
    pub failed: Vec<String>,
}

/// How a method stands against the others, scene by scene.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Ranking {
    /// The method's id.
    pub method: &'static str,
    /// Scenes on which it and another were compared.
    pub scenes: usize,
    /// Share of them on which no other is more exact by more than [`TIE_DB`].
    pub best_share: f64,
    /// How far below the best it is at most, dB.
    pub greatest_loss_db: f64,
    /// The scenes on which it is not the best, the greatest loss first: the scene, the method
    /// that is better, the loss in dB.
    pub losses: Vec<(String, &'static str, f64)>,
}

/// The PSNR that counts, dB.
pub fn counted_db(figures: &MethodFigures) -> f64 {
    match figures {
        MethodFigures::Compared(figures) => figures.psnr_db.map_or(CAP_DB, |db| db.min(CAP_DB)),
        MethodFigures::Failed { .. } => 0.0,
    }
}

/// The statistics of a method over the scenes whose reference agrees.
pub fn statistics(method: &'static str, results: &[SceneResult]) -> Statistics {
    let tried: Vec<_> = results.iter().filter(|r| r.agrees).filter_map(|r| Some((r, r.methods.get(method)?))).collect();
    let compared: Vec<_> = tried
        .iter()
        .filter_map(|(result, figures)| match figures {
            MethodFigures::Compared(figures) => Some((*result, figures)),
            MethodFigures::Failed { .. } => None,
        })
        .collect();
    let of = |value: &dyn Fn(&super::Figures) -> Option<f64>, high_is_good: bool| {
        spread(compared.iter().filter_map(|(r, f)| Some((value(f)?, r.scene.as_str()))).collect(), high_is_good)
    };
    let psnr = |family: Option<&str>| {
        let inside = tried.iter().filter(|(r, _)| family.is_none_or(|family| family == r.family));
        spread(inside.map(|(r, f)| (counted_db(f), r.scene.as_str())).collect(), true)
    };
    let names = FAMILIES.iter().map(|f| f.name).filter(|name| tried.iter().any(|(r, _)| r.family == *name));
    let families: BTreeMap<_, _> = names.map(|name| (name, psnr(Some(name)))).collect();
    let worst = families.iter().min_by(|a, b| a.1.mean.total_cmp(&b.1.mean));
    Statistics {
        method,
        psnr_db: psnr(None),
        worst_block_db: of(&|f| Some(f.worst_block_db.map_or(CAP_DB, |db| db.min(CAP_DB))), true),
        light_error: of(&|f| f.light_kept.map(|kept| (kept - 1.0).abs()), false),
        sharp_error: of(&|f| f.sharp_error, false),
        smooth_error: of(&|f| f.smooth_error, false),
        worst_family: worst.map(|(name, _)| *name),
        families,
        seconds: results.iter().filter_map(|r| r.seconds.get(method)).sum(),
        failed: results
            .iter()
            .filter(|r| matches!(r.methods.get(method), Some(MethodFigures::Failed { .. })))
            .map(|r| r.scene.clone())
            .collect(),
    }
}

/// How `method` stands against the methods of `rivals`, on scenes whose reference agrees.
pub fn ranking(method: &'static str, rivals: &[&'static str], results: &[SceneResult]) -> Ranking {
    let mut ranking = Ranking { method, scenes: 0, best_share: 0.0, greatest_loss_db: 0.0, losses: Vec::new() };
    for result in results.iter().filter(|r| r.agrees) {
        let Some(own) = result.methods.get(method).map(counted_db) else { continue };
        let others = rivals.iter().filter(|id| **id != method);
        let others = others.filter_map(|id| Some((counted_db(result.methods.get(id)?), *id)));
        let Some((best_db, best)) = others.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        ranking.scenes += 1;
        let loss_db = (best_db - own).max(0.0);
        ranking.greatest_loss_db = ranking.greatest_loss_db.max(loss_db);
        if loss_db > TIE_DB {
            ranking.losses.push((result.scene.clone(), best, loss_db));
        }
    }
    ranking.losses.sort_by(|a, b| b.2.total_cmp(&a.2));
    if ranking.scenes > 0 {
        ranking.best_share = 1.0 - ranking.losses.len() as f64 / ranking.scenes as f64;
    }
    ranking
}

fn spread(mut values: Vec<(f64, &str)>, high_is_good: bool) -> Spread {
    let from_bad =
        |a: &(f64, &str), b: &(f64, &str)| if high_is_good { a.0.total_cmp(&b.0) } else { b.0.total_cmp(&a.0) };
    values.sort_by(from_bad);
    let Some((worst, worst_scene)) = values.first().copied() else { return Spread::default() };
    // The nearest rank: a value that one of the scenes has.
    let percentile = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize].0;
    Spread {
        count: values.len(),
        mean: values.iter().map(|v| v.0).sum::<f64>() / values.len() as f64,
        p1: percentile(0.01),
        p10: percentile(0.1),
        p50: percentile(0.5),
        worst,
        worst_scene: worst_scene.into(),
    }
}
