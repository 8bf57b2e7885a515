//! Plots the total energy of a circle of confusion against its radius: why the paper of
//! the `linear` method draws circles antialiased (its section 3.1.2 and Fig. 4).
//!
//! `cargo run --example linear_energy [OUT.svg]` writes a plot and prints the worst error
//! over ranges of the radius.

use anyhow::Context;
use defocus::methods::{CircleSampling, Circles, Coverage};
use plotters::prelude::*;

/// Greatest radius, px.
const MAX_RADIUS_PX: f64 = 64.0;

/// Radii along the axis.
const STEPS: u32 = 2048;

/// Name, colour, drawing of circles, and whether their energies are divided by their sum.
type Curve = (&'static str, RGBColor, Coverage, bool);

const CURVES: [Curve; 4] = [
    ("naive", RGBColor(213, 94, 0), Coverage::Naive, false),
    ("10x10 jittered, as printed", RGBColor(204, 121, 167), Coverage::Jittered, false),
    ("10x10 uniform, as printed", RGBColor(0, 114, 178), Coverage::Uniform, false),
    ("10x10 uniform, divided by the area drawn", RGBColor(0, 0, 0), Coverage::Uniform, true),
];

fn energies((_, _, coverage, divided): Curve) -> Vec<(f64, f64)> {
    let circles = Circles::new(CircleSampling { coverage, sub_pixels: 10 });
    let energy = |radius_px: f64| {
        if divided && radius_px >= 0.5 {
            circles.area_px2(radius_px) * circles.energy_per_coverage(radius_px)
        } else {
            circles.total_energy_as_printed(radius_px)
        }
    };
    let radii = (0..=STEPS).map(|i| MAX_RADIUS_PX * f64::from(i) / f64::from(STEPS));
    radii.map(|radius_px| (radius_px, energy(radius_px))).collect()
}

fn print_worst(name: &str, points: &[(f64, f64)]) {
    print!("{name:42}");
    for (from, to) in [(0.5, 1.0), (1.0, 3.0), (3.0, 10.0), (10.0, 64.0)] {
        let within = points.iter().filter(|(radius, _)| (from..=to).contains(radius));
        let worst = within.map(|(_, energy)| (energy - 1.0).abs()).fold(0.0, f64::max);
        print!("  {from:4} to {to:2} px: {worst:.4}");
    }
    println!();
}

fn main() -> anyhow::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "linear_energy.svg".into());
    let root = SVGBackend::new(&path, (960, 480)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .caption("Total energy of a circle of confusion", ("sans-serif", 18))
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d((0.0..MAX_RADIUS_PX).log_scale().zero_point(-1.0).base(2.0), 0.4..1.6)?;
    chart.configure_mesh().light_line_style(TRANSPARENT).x_desc("radius, px").y_desc("energy, 1 wanted").draw()?;
    for curve in CURVES {
        let points = energies(curve);
        print_worst(curve.0, &points);
        let color = curve.1;
        chart
            .draw_series(LineSeries::new(points, color))?
            .label(curve.0)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .draw()?;
    root.present().with_context(|| format!("cannot write {path}"))?;
    println!("wrote {path}");
    Ok(())
}
