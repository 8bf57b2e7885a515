//! Plots of a comparison: the CoC against depth, and error against time, as SVG and as numbers.

use super::bench::plot::{Axis, Plot, Point, Series};
use super::results::{CompareJson, ResultJson};
use defocus::lens::Lens;
use std::fmt::Write as _;

/// Points of the curve of CoC against depth: a line joins them without corners that are seen.
const CURVE_POINTS: usize = 241;

/// Depths around the least and the greatest that are shown, as a factor.
const MARGIN: f64 = 1.25;

/// CoC against depth at regular steps of its logarithm.
#[derive(Clone, Debug, PartialEq)]
pub struct CocCurve {
    /// Depth, metres, and signed CoC diameter, px, negative in front of the focus.
    pub points: Vec<[f64; 2]>,
}

impl CocCurve {
    /// Of a lens over depths from `low_m` to `high_m`, both positive and finite, with a margin.
    pub fn of(lens: &Lens, [low_m, high_m]: [f64; 2]) -> Self {
        let (low_m, high_m) = (low_m / MARGIN, high_m.max(low_m) * MARGIN);
        let coc = lens.coc();
        let depth_m = |i: usize| low_m * (high_m / low_m).powf(i as f64 / (CURVE_POINTS - 1) as f64);
        let points = (0..CURVE_POINTS).map(depth_m).map(|depth_m| [depth_m, coc.at_depth(depth_m)]);
        Self { points: points.collect() }
    }

    /// Least and greatest of depths, metres; `None` where none is positive and finite.
    pub fn range_m(depths_m: impl IntoIterator<Item = f32>) -> Option<[f64; 2]> {
        let finite = depths_m.into_iter().map(f64::from).filter(|d| d.is_finite() && *d > 0.0);
        let range = finite.fold([f64::INFINITY, 0.0_f64], |[low, high], d| [low.min(d), high.max(d)]);
        (range[1] > 0.0).then_some(range)
    }

    /// As CSV.
    pub fn csv(&self) -> String {
        let mut text = String::from("depth_m,coc_px\n");
        for [depth_m, coc_px] in &self.points {
            // Writing into a String cannot fail.
            let _ = writeln!(text, "{depth_m},{coc_px}");
        }
        text
    }

    /// As a plot.
    pub fn plot(&self) -> Plot<'static> {
        let part = |name: &str, style, behind: bool| {
            let of = self.points.iter().filter(|[_, c]| (*c >= 0.0) == behind);
            let label = |[m, c]: &[f64; 2]| format!("{m:.3} m: {c:.2} px");
            let point = |p: &[f64; 2]| Point { x: p[0], y: p[1].abs(), interval: None, label: label(p) };
            Series { name: name.into(), style, points: of.map(point).collect(), markers: false }
        };
        let parts = [part("in front of the focus", 1, false), part("behind it", 0, true)];
        Plot {
            x: Axis { title: "depth, m", logarithmic: true },
            y: Axis { title: "CoC diameter, px", logarithmic: false },
            series: parts.into_iter().filter(|part| !part.points.is_empty()).collect(),
            front: false,
        }
    }
}

/// Error against time, a point for each method that has both; `None` where none has, as on an
/// adapter without times. The reference is no method among others.
pub fn error_plot(json: &CompareJson) -> Option<Plot<'static>> {
    let has_jod = json.results.iter().any(|r| r.metrics.jod.is_some());
    let value: fn(&ResultJson) -> Option<f64> = if has_jod { |r| r.metrics.jod } else { |r| r.metrics.psnr_db };
    let (title, unit) = if has_jod { ("quality as seen, JOD", "JOD") } else { ("PSNR, dB", "dB") };
    let of = |(style, result): (usize, &ResultJson)| {
        let (x, y) = result.gpu_ms.map(|t| t.median).filter(|ms| *ms > 0.0).zip(value(result))?;
        let label = format!("{}: {y:.2} {unit} in {x:.3} ms", result.method);
        let point = Point { x, y, interval: None, label };
        Some(Series { name: result.method.into(), style, points: vec![point], markers: true })
    };
    let methods = json.results.iter().enumerate().filter(|(_, result)| !is_reference(json, result));
    let series: Vec<Series> = methods.filter_map(of).collect();
    let (x, y) = (Axis { title: "GPU time, ms", logarithmic: true }, Axis { title, logarithmic: false });
    (!series.is_empty()).then_some(Plot { x, y, series, front: true })
}

/// Whether a result is by the method that the reference is by: it is not judged among the others.
pub fn is_reference(json: &CompareJson, result: &ResultJson) -> bool {
    json.reference.as_ref().is_some_and(|reference| reference.method == result.method)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_that_of_the_lens_and_has_no_markers() {
        let lens = Lens { aperture_diameter_mm: 4.0, focus_distance_m: 1.0, ..Lens::PINHOLE };
        let range_m = CocCurve::range_m([0.5, f32::INFINITY, -1.0, 4.0]).expect("two depths are finite");
        assert_eq!(range_m, [0.5, 4.0]);
        let curve = CocCurve::of(&lens, range_m);
        let csv = curve.csv();
        assert_eq!(csv.lines().count(), CURVE_POINTS + 1);
        for line in csv.lines().skip(1) {
            let (depth, coc) = line.split_once(',').expect("two columns");
            let [depth_m, coc_px] = [depth, coc].map(|text| text.parse::<f64>().expect("a number"));
            assert!((coc_px - lens.coc_diameter_px(depth_m)).abs() < 1e-9, "{line}");
        }
        let svg = curve.plot().svg_file();
        assert!(svg.starts_with("<svg xmlns") && svg.contains("polyline"));
        assert!(svg.contains("fill=\"none\"") && !svg.contains("class=\"line\""), "a curve is no area");
        assert_eq!(svg.matches("<circle").count() + svg.matches("<polygon").count(), 0, "no markers on a curve");
        assert_eq!(CocCurve::range_m([f32::INFINITY, 0.0]), None);
    }
}
