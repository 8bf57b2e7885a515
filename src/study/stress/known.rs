//! What is known not to hold, and why: failures that are expected, and that make the run
//! fail once they no longer happen.

use super::cases::Combination;
use super::specimen::{ImageCase, Specimen};
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
    /// A case that fails: it is part of every run, whatever the seed.
    pub witness: fn() -> ImageCase,
    /// Why, and why it is left so.
    pub reason: &'static str,
}

const ODD_PYRAMID: &str = "a pyramid cannot be centred on an odd number of pixels: mirrored, the image lies half a \
    texel elsewhere on it";

const LAYERS: &str = "a pixel goes to the layer in front, at or behind another by a threshold on their CoCs, as the \
    paper has it: one that crosses it moves whole";

const EMITTERS: &str = "what is brighter than 2 is brought by emitters, of which there are none beyond the border and \
    256 a tile at most: large bright areas darken there";

const BRIGHT_OR_DARK: &str = "emitters (what is brighter than 2) overshoot where the aperture is far narrower than its \
    CoC; and below 1e-4 of white the buckets' weighted colours lie under the least number that f16 has";

const FEW_RAYS: &str = "few rays a pixel, each of which takes part whole: one that steps over an edge shows more of \
    the contrast than the focus step explains";

/// Colours that are all but black, whose products with small weights f16 cannot hold.
fn is_dark(specimen: &Specimen) -> bool {
    let range = specimen.pixels.as_ref().map(|pixels| pixels.range());
    range.is_some_and(|[_, high]| high.max_element() > 0.0 && high.max_element() < 1e-4)
}

fn is_odd(specimen: &Specimen) -> bool {
    specimen.view.size().x % 2 == 1
}

fn has_several_depths(specimen: &Specimen) -> bool {
    specimen.pixels.as_ref().is_none_or(|pixels| pixels.only_depth_m().is_none())
}

/// Above the radiance at which `adaptive` makes emitters.
fn is_bright(specimen: &Specimen) -> bool {
    specimen.pixels.as_ref().is_some_and(|pixels| pixels.range()[1].max_element() > 2.0)
}

fn odd_wall() -> ImageCase {
    Combination::named("strong blur", "near object before a sharp wall", "detail", uvec2(31, 7)).case()
}

fn bright_wall() -> ImageCase {
    Combination::named("strong blur", "all behind", "65504 everywhere", uvec2(24, 16)).case()
}

/// The known limits.
pub const KNOWN_LIMITS: &[KnownLimit] = &[
    KnownLimit { method: "mipmap", check: "mirror", applies: is_odd, witness: odd_wall, reason: ODD_PYRAMID },
    KnownLimit { method: "opaque", check: "mirror", applies: is_odd, witness: odd_wall, reason: ODD_PYRAMID },
    KnownLimit { method: "pyramid", check: "mirror", applies: is_odd, witness: odd_wall, reason: ODD_PYRAMID },
    KnownLimit {
        method: "splat",
        check: "continuity",
        applies: has_several_depths,
        witness: || super::cases::random_case(1, 1),
        reason: LAYERS,
    },
    KnownLimit {
        method: "adaptive",
        check: "continuity",
        applies: has_several_depths,
        witness: || {
            Combination::named("widest Gaussian", "near object before a sharp wall", "detail", uvec2(31, 7)).case()
        },
        reason: FEW_RAYS,
    },
    KnownLimit {
        method: "adaptive",
        check: "range",
        applies: |specimen| is_bright(specimen) || is_dark(specimen),
        witness: || {
            let dark = "subnormal numbers of f16 and f32";
            Combination::named("rounded pentagon", "near object before a sharp wall", dark, uvec2(100, 1)).case()
        },
        reason: BRIGHT_OR_DARK,
    },
    KnownLimit { method: "adaptive", check: "constancy", applies: is_bright, witness: bright_wall, reason: EMITTERS },
    KnownLimit {
        method: "adaptive",
        check: "mirror",
        applies: is_bright,
        witness: || {
            Combination::named("moderate blur", "noise over all depths", "65504 everywhere", uvec2(24, 16)).case()
        },
        reason: EMITTERS,
    },
];
