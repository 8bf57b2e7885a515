//! What is known not to hold, and why: failures that are expected, and that make the run
//! fail once they no longer happen.

use super::cases::{Combination, random_case};
use super::specimen::{ImageCase, Specimen, width_per_coc};
use glam::uvec2;

/// A limit of a method as it was published, or of its input.
#[derive(Clone, Copy)]
pub struct KnownLimit {
    /// The method's id.
    pub method: &'static str,
    /// The check that fails.
    pub check: &'static str,
    /// Whether a failure on this specimen is expected.
    pub applies: fn(&Specimen) -> bool,
    /// Cases of which at least one fails: they are part of every run, whatever the seed.
    pub witnesses: fn() -> Vec<ImageCase>,
    /// Why, and why it is left so.
    pub reason: &'static str,
}

const ODD_PYRAMID: &str = "a pyramid cannot be centred on an odd number of pixels: mirrored, the image lies half a \
    texel elsewhere on it";

const LAYERS: &str = "a pixel goes to the layer in front, at or behind another by a threshold on their CoCs, as the \
    paper has it: one that crosses it moves whole";

const HIDDEN_EMITTERS: &str = "what is brighter than 2 is brought by emitters; an image has none where something nearer \
    hides them, and what is left is not divided by its share as rays are";

const SINGLE_EMITTERS: &str = "what is brighter than 2 is brought by emitters, each by the share of the lens that it \
    covers: where surfaces of several depths meet, shares of those that are seen may add up to more than 1";

const FEW_RAYS: &str = "few rays a pixel, each of which takes part whole: one that steps over an edge shows more of \
    the contrast than the focus step explains";

const FEW_INSIDE: &str = "rays through a blur wider than half of the image mostly leave it: the few that do not decide, \
    and one that steps over an edge counts as many";

const TAPS: &str = "taps that weigh by the depth of one pixel: one that steps over an edge of the depth weighs another \
    amount at once, as published";

const COARSE_DEPTHS: &str = "holes are filled with means of depths, and where one rounding step of a depth changes its CoC \
    by pixels, a mean lies a step to either side";

const DARK: &str = "below 1e-4 of white, colours times the opacity at an edge lie under the least number that f16 \
    has";

/// Colours that are all but black, whose products with small weights f16 cannot hold.
fn is_dark(specimen: &Specimen) -> bool {
    let range = specimen.pixels.as_ref().map(|pixels| pixels.range());
    range.is_some_and(|[_, high]| high.max_element() > 0.0 && high.max_element() < 1e-4)
}

/// Whether the CoC changes by more than a small step of the focus makes from one f32 to the
/// next.
fn depths_are_coarse(specimen: &Specimen) -> bool {
    specimen.step.is_none()
}

fn is_odd(specimen: &Specimen) -> bool {
    specimen.view.size().x % 2 == 1
}

fn has_several_depths(specimen: &Specimen) -> bool {
    specimen.pixels.as_ref().is_none_or(|pixels| pixels.only_depth_m().is_none())
}

/// Whether neighbouring pixels differ in blur by more than a pixel somewhere: where one filter tap or
/// ray steps over such an edge, the picture changes by more than its own blur does.
fn has_edges(specimen: &Specimen) -> bool {
    const EDGE_PX: f64 = 1.0;
    let Some(pixels) = &specimen.pixels else { return true };
    let size = pixels.depth_m.size;
    let width_per_coc = width_per_coc(&specimen.lens);
    let width_px = |x: u32, y: u32| width_per_coc * specimen.lens.coc_diameter_px(f64::from(pixels.depth_m.at(x, y)));
    let differ = |a: f64, b: f64| (a - b).abs() > EDGE_PX;
    (0..size.y).any(|y| {
        (0..size.x).any(|x| {
            let here = width_px(x, y);
            x + 1 < size.x && differ(here, width_px(x + 1, y)) || y + 1 < size.y && differ(here, width_px(x, y + 1))
        })
    })
}

/// The same where a blur is wider than half of the image besides.
fn has_edges_beside_vast_blur(specimen: &Specimen) -> bool {
    let Some(pixels) = &specimen.pixels else { return true };
    let half_px = 0.5 * f64::from(pixels.depth_m.size.min_element());
    let width_px =
        |depth_m: f32| width_per_coc(&specimen.lens) * specimen.lens.coc_diameter_px(f64::from(depth_m)).abs();
    has_edges(specimen) && pixels.depth_m.pixels.iter().any(|&depth_m| width_px(depth_m) > half_px)
}

/// Above the radiance at which `adaptive` makes emitters.
fn is_bright(specimen: &Specimen) -> bool {
    specimen.pixels.as_ref().is_some_and(|pixels| pixels.range()[1].max_element() > 2.0)
}

fn odd_images() -> Vec<ImageCase> {
    vec![
        Combination::named("narrow Gaussian", "near object before a sharp wall", "detail", uvec2(31, 7)).case(),
        Combination::named("CoC wider than the image", "specks before a wall", "0 and 65504", uvec2(17, 11)).case(),
        Combination::named("df 1 % above F", "specks before a wall", "1e-7 and 1", uvec2(33, 17)).case(),
    ]
}

fn layered_images() -> Vec<ImageCase> {
    let slope = "slope of 1 % around the focus";
    vec![Combination::named("df 1 % above F", slope, "subnormal numbers of f16 and f32", uvec2(1, 100)).case()]
}

fn noisy_depths() -> Vec<ImageCase> {
    let noise = "noise over all depths";
    vec![
        Combination::named("moderate blur", noise, "65504 everywhere", uvec2(24, 16)).case(),
        Combination::named("rounded pentagon", noise, "1e-7 and 1", uvec2(33, 17)).case(),
        Combination::named("Gaussian", "checkerboard of near and far", "detail", uvec2(17, 11)).case(),
    ]
}

fn coarse_depths() -> Vec<ImageCase> {
    let depth = "one rounding step around the focus";
    vec![Combination::named("df a millionth above F", depth, "a bright point", uvec2(2, 2)).case()]
}

fn tapped_edges() -> Vec<ImageCase> {
    vec![
        Combination::named("strong blur", "depths that are none", "detail", uvec2(24, 16)).case(),
        Combination::named("slight blur", "noise over all depths", "1e-7 and 1", uvec2(16, 16)).case(),
    ]
}

fn vast_blur() -> Vec<ImageCase> {
    vec![random_case(9, 2001), random_case(19, 2001)]
}

fn noisy_taps() -> Vec<ImageCase> {
    let noise = "noise over all depths";
    vec![
        random_case(0, 703),
        random_case(17, 703),
        Combination::named("slight blur", noise, "0 and 65504", uvec2(16, 16)).case(),
        Combination::named("slight blur", noise, "1e-7 and 1", uvec2(100, 1)).case(),
    ]
}

fn dark_edges() -> Vec<ImageCase> {
    let dark = "subnormal numbers of f16 and f32";
    vec![Combination::named("E = 1e30 mm", "near object before a sharp wall", dark, uvec2(33, 17)).case()]
}

fn dark_holes() -> Vec<ImageCase> {
    let dark = "subnormal numbers of f16 and f32";
    vec![Combination::named("CoC of a million px", "holes of a pixel", dark, uvec2(13, 1)).case()]
}

fn bright_noise() -> Vec<ImageCase> {
    vec![random_case(9, 703), random_case(16, 704), random_case(18, 705)]
}

fn bright_steps() -> Vec<ImageCase> {
    vec![Combination::named("strong blur", "checkerboard of near and far", "65504 everywhere", uvec2(13, 1)).case()]
}

const fn odd_pyramid(method: &'static str) -> KnownLimit {
    KnownLimit { method, check: "mirror", applies: is_odd, witnesses: odd_images, reason: ODD_PYRAMID }
}

/// The known limits.
pub const KNOWN_LIMITS: &[KnownLimit] = &[
    odd_pyramid("mipmap"),
    odd_pyramid("opaque"),
    odd_pyramid("pyramid"),
    KnownLimit {
        method: "pyramid",
        check: "mirror",
        applies: depths_are_coarse,
        witnesses: coarse_depths,
        reason: COARSE_DEPTHS,
    },
    KnownLimit { method: "splat", check: "continuity", applies: has_edges, witnesses: layered_images, reason: LAYERS },
    KnownLimit { method: "preblur", check: "continuity", applies: has_edges, witnesses: tapped_edges, reason: TAPS },
    KnownLimit {
        method: "multiview",
        check: "continuity",
        applies: has_edges_beside_vast_blur,
        witnesses: vast_blur,
        reason: FEW_INSIDE,
    },
    KnownLimit { method: "opaque", check: "range", applies: is_dark, witnesses: dark_edges, reason: DARK },
    KnownLimit { method: "mipmap", check: "range", applies: is_dark, witnesses: dark_holes, reason: DARK },
    KnownLimit { method: "separable", check: "continuity", applies: has_edges, witnesses: noisy_taps, reason: TAPS },
    KnownLimit { method: "gather", check: "continuity", applies: has_edges, witnesses: noisy_taps, reason: TAPS },
    KnownLimit { method: "mipmap", check: "continuity", applies: has_edges, witnesses: noisy_taps, reason: TAPS },
    KnownLimit {
        method: "adaptive",
        check: "continuity",
        applies: has_edges,
        witnesses: noisy_depths,
        reason: FEW_RAYS,
    },
    KnownLimit {
        method: "adaptive",
        check: "range",
        applies: |specimen| is_bright(specimen) && has_several_depths(specimen),
        witnesses: bright_noise,
        reason: SINGLE_EMITTERS,
    },
    KnownLimit {
        method: "adaptive",
        check: "constancy",
        applies: |specimen| is_bright(specimen) && has_several_depths(specimen),
        witnesses: bright_steps,
        reason: HIDDEN_EMITTERS,
    },
];
