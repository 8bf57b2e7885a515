//! How far the most exact method of a cell is ahead of each other: at equal time in dB, at
//! equal error in time.

use super::plot::pareto_front;
use super::results::{CellResult, VariantResult};
use defocus::methods::{Accumulation, Method};

/// The most exact method of a cell against another one.
#[derive(Clone, Debug, PartialEq)]
pub struct Lead<'a> {
    /// The method whose default parameters have the greatest PSNR.
    pub leader: &'a str,
    /// The other.
    pub rival: &'a str,
    /// PSNR of the leader with its default parameters over what the rival reaches in the
    /// same time, dB.
    pub db_at_equal_time: f64,
    /// Time in which the leader is as exact as the rival's most exact variant, over that
    /// variant's time; `None` if it never is.
    pub time_at_equal_error: Option<f64>,
    /// Variants of the leader than which one of the rival is both faster and more exact.
    pub beaten: Vec<&'a str>,
}

/// What a method reaches in which time: the variants that none of its others beats, as time
/// and PSNR, both rising.
struct Curve(Vec<[f64; 2]>);

impl Curve {
    fn of(cell: &CellResult, method: &str) -> Self {
        Self(pareto_front(&of_method(cell, method).filter_map(time_and_db).collect::<Vec<_>>()))
    }

    /// PSNR in a time, interpolated over the time's logarithm; that of the fastest variant
    /// if none is as fast. `None` only without variants.
    fn db_at(&self, time: f64) -> Option<f64> {
        between(self.0.iter().map(|[t, db]| [t.ln(), *db]), time.ln()).or(self.0.last().map(|p| p[1]))
    }

    /// The time for a PSNR, so interpolated; that of the fastest variant if all are more
    /// exact, `None` if none is.
    fn time_for(&self, db: f64) -> Option<f64> {
        between(self.0.iter().map(|[t, db]| [*db, t.ln()]), db).map(f64::exp)
    }
}

/// The second number where the first is `at`, linear between points of rising numbers: the
/// first point's before it, `None` after the last one.
fn between(points: impl Iterator<Item = [f64; 2]>, at: f64) -> Option<f64> {
    let mut before: Option<[f64; 2]> = None;
    for [x, y] in points {
        if x >= at {
            return Some(before.map_or(y, |[x0, y0]| y0 + (y - y0) * (at - x0) / (x - x0)));
        }
        before = Some([x, y]);
    }
    None
}

fn of_method<'a>(cell: &'a CellResult, method: &str) -> impl Iterator<Item = &'a VariantResult> {
    cell.variants.iter().filter(move |v| v.method == method)
}

/// Multiples of the copy and PSNR, where both are numbers.
fn time_and_db(variant: &VariantResult) -> Option<[f64; 2]> {
    let point = [variant.ratio()?, variant.metrics.psnr_db?];
    (point[0] > 0.0 && point[1].is_finite()).then_some(point)
}

/// The most exact method against each other one, in the order of the variants; nothing
/// where no error or time is known. Accumulation, which the reference is made with, is left
/// out: it is as exact as it is given time.
pub fn leads(cell: &CellResult) -> Vec<Lead<'_>> {
    let mut defaults: Vec<(&str, [f64; 2])> = Vec::new();
    for variant in &cell.variants {
        let known = defaults.iter().any(|(method, _)| *method == variant.method);
        if !known && variant.method != Accumulation::default().about().id {
            defaults.extend(time_and_db(variant).map(|point| (variant.method.as_str(), point)));
        }
    }
    let Some(&(leader, [time, db])) = defaults.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1])) else {
        return Vec::new();
    };
    let ahead = Curve::of(cell, leader);
    let lead = |&(rival, _): &(_, _)| {
        let curve = Curve::of(cell, rival);
        let &[best_time, best_db] = curve.0.last()?;
        let is_beaten = |v: &&VariantResult| {
            time_and_db(v).is_some_and(|[time, db]| curve.0.iter().any(|p| p[0] < time && p[1] > db))
        };
        Some(Lead {
            leader,
            rival,
            db_at_equal_time: db - curve.db_at(time)?,
            time_at_equal_error: ahead.time_for(best_db).map(|time| time / best_time),
            beaten: of_method(cell, leader).filter(is_beaten).map(|v| v.label.as_str()).collect(),
        })
    };
    defaults.iter().filter(|(method, _)| *method != leader).filter_map(lead).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A cell with variants: method, time in copies, PSNR in dB.
    fn cell(variants: &[(&str, f64, f64)]) -> CellResult {
        let variants = variants.iter().map(|(method, copies, db)| {
            let times =
                json!({"median": copies, "low": copies, "high": copies, "min": copies, "max": copies, "runs": 1});
            json!({
                "label": format!("{method} {copies}"), "method": method, "params": {}, "psnr_db": db,
                "copy_ratio": times, "passes": [], "drawn": {"triangles": 0, "views": 0},
                "peak_texture_bytes": 0, "skipped": {},
            })
        });
        let cell = json!({
            "cell": {"index": 0, "scene": "s", "size": [8, 8], "blur": {"mean_coc_px": 4.0}},
            "adapter": "", "version": "", "scene": "s", "scene_triangles": 0, "size": [8, 8], "mean_coc_px": 4.0,
            "greatest_coc_px": 8.0, "in_focus": 0.0, "variants": variants.collect::<Vec<_>>(), "not_run": [],
        });
        serde_json::from_value(cell).expect("a cell")
    }

    #[test]
    fn a_lead_is_read_off_between_the_variants() {
        let cell = cell(&[
            ("exact", 10.0, 40.0),
            ("exact", 40.0, 44.0),
            ("rough", 1.0, 20.0),
            ("slow", 1000.0, 42.0),
            ("slow", 1.0, 30.0),
            ("slow", 100.0, 34.0),
            ("slow", 90.0, 29.0),
            ("accumulation", 5000.0, 60.0),
        ]);
        // Defaults come first: 42 dB of "slow" beat 40 of "exact".
        let [exact, rough] = leads(&cell).try_into().expect("two rivals, accumulation is none");
        assert_eq!((exact.leader, exact.rival, rough.rival), ("slow", "exact", "rough"));
        assert!((exact.db_at_equal_time - (42.0 - 44.0)).abs() < 1e-12, "{exact:?}");
        assert_eq!(exact.time_at_equal_error, None, "44 dB are never reached");
        assert_eq!(exact.beaten, ["slow 1000", "slow 100", "slow 90"]);
        assert!((rough.db_at_equal_time - 22.0).abs() < 1e-12 && rough.beaten.is_empty(), "{rough:?}");
        assert_eq!(rough.time_at_equal_error, Some(1.0), "the fastest is more exact already");
    }

    #[test]
    fn between_variants_time_is_logarithmic() {
        let cell =
            cell(&[("a", 10.0, 40.0), ("a", 1000.0, 44.0), ("b", 1.0, 30.0), ("b", 100.0, 38.0), ("b", 200.0, 41.0)]);
        let [lead] = leads(&cell).try_into().expect("one rival");
        assert_eq!(lead.leader, "a");
        // Halfway between 1 and 100 copies b has 34 dB; 41 dB are a quarter of the way from 10 to 1000.
        assert!((lead.db_at_equal_time - 6.0).abs() < 1e-9, "{lead:?}");
        let share = lead.time_at_equal_error.expect("it is reached");
        assert!((share - 10f64.powf(1.5) / 200.0).abs() < 1e-9, "{share}");
        assert!(lead.beaten.is_empty());
    }

    #[test]
    fn without_errors_nobody_leads() {
        let mut cell = cell(&[("a", 1.0, 40.0), ("b", 2.0, 30.0)]);
        for variant in &mut cell.variants {
            variant.metrics.psnr_db = None;
        }
        assert_eq!(leads(&cell), []);
    }
}
