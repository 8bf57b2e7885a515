//! Which conditions are combined, and in what order.

use super::images::{COLORS, DEPTHS, LONG_SIZES, SIZES, point, random_color, random_depth};
use super::lenses::{LENSES, blurring, random_lens};
use super::specimen::ImageCase;
use crate::random::Random;
use defocus::image::Image;
use glam::UVec2;

/// Indices into the tables of conditions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Combination {
    /// Of [`LENSES`].
    pub lens: usize,
    /// Of [`DEPTHS`].
    pub depth: usize,
    /// Of [`COLORS`].
    pub color: usize,
    /// px.
    pub size: UVec2,
}

impl Combination {
    /// The images and the lens.
    pub fn case(&self) -> ImageCase {
        let (lens, depth, color) = (&LENSES[self.lens], &DEPTHS[self.depth], &COLORS[self.color]);
        let optics = (lens.make)();
        // Depths lie around the focus; around 2 m where that is infinitely far.
        let focus_m = if optics.focus_distance_m.is_finite() { optics.focus_distance_m as f32 } else { 2.0 };
        ImageCase {
            name: format!("{}; {}; {}; {}x{} px", lens.name, depth.name, color.name, self.size.x, self.size.y),
            color: (color.make)(self.size),
            depth_m: (depth.make)(self.size, focus_m),
            lens: optics,
        }
    }

    /// The combination of conditions by their names.
    ///
    /// Panics if a table has no such name: names are written in this program only.
    pub fn named(lens: &str, depth: &str, color: &str, size: UVec2) -> Self {
        let found = |position: Option<usize>, name: &str| position.unwrap_or_else(|| panic!("no condition '{name}'"));
        Self {
            lens: found(LENSES.iter().position(|l| l.name == lens), lens),
            depth: found(DEPTHS.iter().position(|d| d.name == depth), depth),
            color: found(COLORS.iter().position(|c| c.name == color), color),
            size,
        }
    }
}

/// Lone points of light at one depth, in the middle of [`POINT_SIZE`].
const POINTS: usize = 16;
const POINT_SIZE: UVec2 = UVec2::new(24, 18);

/// Greatest CoC of those, px: most apertures' spots then lie inside.
const POINT_COC_PX: f64 = 7.0;

/// Random cases in a quick run, and in a full one.
const RANDOM: [usize; 2] = [24, 400];

/// Makes a case when it is its turn: all of them at once would fill memory.
pub type ImageCaseMaker = Box<dyn Fn() -> ImageCase + Send + Sync>;

/// Everything that image methods are tried on, in an order that depends on the seed.
pub fn image_cases(quick: bool, seed: u64) -> Vec<ImageCaseMaker> {
    let combinations = if quick { pairs(seed) } else { triples(seed) };
    let mut cases: Vec<ImageCaseMaker> = Vec::new();
    for combination in combinations.into_iter().chain(long_images()) {
        cases.push(Box::new(move || combination.case()));
    }
    for index in 0..POINTS {
        cases.push(Box::new(move || point_case(index, seed)));
    }
    for index in 0..RANDOM[usize::from(!quick)] {
        cases.push(Box::new(move || random_case(index, seed)));
    }
    // In any order: a run that is stopped has seen something of everything.
    let mut random = Random::new(seed);
    for last in (1..cases.len()).rev() {
        cases.swap(last, random.index(last + 1));
    }
    cases
}

/// Every lens with every depth and every colour at every size, the others in turn.
fn pairs(seed: u64) -> Vec<Combination> {
    let mut random = Random::new(seed);
    let mut combinations = Vec::new();
    for lens in 0..LENSES.len() {
        for depth in 0..DEPTHS.len() {
            let (color, size) = (random.index(COLORS.len()), SIZES[random.index(SIZES.len())]);
            combinations.push(Combination { lens, depth, color, size });
        }
    }
    combinations.extend(sizes_of_colors(&mut random));
    combinations
}

/// Every lens with every depth and every colour, and every colour at every size.
fn triples(seed: u64) -> Vec<Combination> {
    let mut random = Random::new(seed);
    let mut combinations = Vec::new();
    for lens in 0..LENSES.len() {
        for depth in 0..DEPTHS.len() {
            for color in 0..COLORS.len() {
                let size = SIZES[random.index(SIZES.len())];
                combinations.push(Combination { lens, depth, color, size });
            }
        }
    }
    combinations.extend(sizes_of_colors(&mut random));
    combinations
}

fn sizes_of_colors(random: &mut Random) -> Vec<Combination> {
    let mut combinations = Vec::new();
    for color in 0..COLORS.len() {
        for &size in SIZES {
            let (lens, depth) = (random.index(LENSES.len()), random.index(DEPTHS.len()));
            combinations.push(Combination { lens, depth, color, size });
        }
    }
    combinations
}

fn long_images() -> Vec<Combination> {
    let at = |&size: &UVec2| {
        [
            Combination::named("moderate blur", "ramp through the focus", "detail", size),
            Combination::named("CoC wider than the image", "holes of a pixel", "one colour", size),
        ]
    };
    LONG_SIZES.iter().flat_map(at).collect()
}

/// A point of light at one depth: what keeps its light shows it here.
fn point_case(index: usize, seed: u64) -> ImageCase {
    let mut random = Random::new(seed ^ 0x9e37 ^ (index as u64) << 32);
    let shape = (LENSES[index % LENSES.len()].make)().aperture;
    let coc_px = random.between(-POINT_COC_PX, POINT_COC_PX);
    let lens = defocus::lens::Lens { aperture: shape, ..blurring(2.0 * POINT_COC_PX) };
    let depth_m = lens.coc().depth_at(coc_px) as f32;
    ImageCase {
        name: format!("a point of light, aperture {index}, c = {coc_px:.2} px"),
        color: point(POINT_SIZE, random.log_between(0.01, 30000.0) as f32),
        depth_m: Image::filled(POINT_SIZE, depth_m),
        lens,
    }
}

/// Random colours, depths, size and lens.
pub fn random_case(index: usize, seed: u64) -> ImageCase {
    let mut random = Random::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ index as u64);
    let size = UVec2::new(1 + random.index(40) as u32, 1 + random.index(30) as u32);
    let lens = random_lens(&mut random);
    let focus_m = lens.focus_distance_m as f32;
    ImageCase {
        name: format!("random {index} of seed {seed}"),
        color: random_color(&mut random, size),
        depth_m: random_depth(&mut random, size, focus_m),
        lens,
    }
}
