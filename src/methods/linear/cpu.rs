//! The paper's own program, on all cores: the oracle of the GPU port.

use super::circle::{CircleSampling, Circles, OWN_PIXEL_RADIUS_PX};
use crate::image::{ColorImage, Image};
use glam::{DVec4, Vec3};
use rayon::prelude::*;

/// The linear filter: every pixel's light, spread evenly over its circle and summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearFilter {
    /// How circles are drawn.
    pub sampling: CircleSampling,
    /// Radius, px, to which greater circles are cut.
    pub max_radius_px: f32,
    /// Whether each pixel is divided by the energy of a white image there: not in the
    /// paper, and not conserving energy, but a constant colour then stays that colour.
    pub normalise: bool,
}

impl Default for LinearFilter {
    fn default() -> Self {
        Self { sampling: CircleSampling::default(), max_radius_px: super::MAX_RADIUS_PX, normalise: false }
    }
}

/// A pixel on its way: where it lands, how far it spreads, what it carries.
struct Spread {
    radius_px: f64,
    /// Energy for each covered pixel.
    energy: f64,
    /// Colour, and 1.
    light: DVec4,
}

/// The paper's filter with its own constants; see [`LinearFilter::apply`].
pub fn linear_cpu(color: &ColorImage, coc_diameter_px: &Image<f32>) -> ColorImage {
    LinearFilter::default().apply(color, coc_diameter_px)
}

impl LinearFilter {
    /// Spreads every pixel over its circle, whose diameter, px, may have either sign.
    ///
    /// Light that leaves the frame is lost, and none comes in from outside. A pixel that is
    /// not finite spreads nothing; a CoC that is not counts as 0. The result is the same
    /// for any number of threads.
    ///
    /// Panics if the images differ in size.
    pub fn apply(&self, color: &ColorImage, coc_diameter_px: &Image<f32>) -> ColorImage {
        assert_eq!(color.size, coc_diameter_px.size, "colour and CoC have one size");
        let circles = Circles::new(self.sampling);
        let pixels = color.pixels.par_iter().zip(&coc_diameter_px.pixels);
        let spreads: Vec<Spread> = pixels.map(|(e, c)| self.spread(&circles, *e, *c)).collect();
        let width = color.size.x as usize;
        let reach = spreads.par_iter().map(|s| reach_px(s.radius_px)).max().unwrap_or(0);
        let rows = (0..color.size.y).into_par_iter().flat_map_iter(|y| {
            let mut row = vec![DVec4::ZERO; width];
            let last = (y + reach).min(color.size.y - 1);
            for from in y.saturating_sub(reach)..=last {
                let sources = &spreads[from as usize * width..][..width];
                add_to_row(&mut row, &circles, sources, from.abs_diff(y));
            }
            row.into_iter().map(|sum| self.finished(sum))
        });
        Image { size: color.size, pixels: rows.collect() }
    }

    fn spread(&self, circles: &Circles, color: Vec3, coc_px: f32) -> Spread {
        let light = if color.is_finite() { color.as_dvec3().extend(1.0) } else { DVec4::ZERO };
        let radius_px = f64::from((0.5 * coc_px.abs()).min(self.max_radius_px));
        if !coc_px.is_finite() || radius_px < OWN_PIXEL_RADIUS_PX {
            return Spread { radius_px: 0.0, energy: 1.0, light };
        }
        Spread { radius_px, energy: circles.energy_per_coverage(radius_px), light }
    }

    fn finished(&self, sum: DVec4) -> Vec3 {
        let white = if self.normalise && sum.w > 0.0 { sum.w } else { 1.0 };
        (sum.truncate() / white).as_vec3()
    }
}

/// Pixels that a circle reaches along each axis.
fn reach_px(radius_px: f64) -> u32 {
    if radius_px < OWN_PIXEL_RADIUS_PX { 0 } else { (radius_px + 0.5).floor() as u32 }
}

/// Adds what the circles of a row of pixels leave in the row `dy` px away.
fn add_to_row(row: &mut [DVec4], circles: &Circles, sources: &[Spread], dy: u32) {
    for (x, source) in sources.iter().enumerate() {
        let reach = reach_px(source.radius_px);
        if dy > reach {
            continue;
        }
        for dx in 0..=reach {
            let share = if reach == 0 { 1.0 } else { circles.coverage(source.radius_px, dx, dy) };
            if share == 0.0 {
                continue;
            }
            let light = source.light * (source.energy * share);
            if let Some(right) = row.get_mut(x + dx as usize) {
                *right += light;
            }
            if dx > 0 && x >= dx as usize {
                row[x - dx as usize] += light;
            }
        }
    }
}
