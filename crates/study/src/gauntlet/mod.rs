//! Random scenes against the reference: a search for what methods get wrong.
//!
//! A scene ([`SceneSpec`]) is plain data made by a [`Family`] from a seed. Every method is
//! compared on it with accumulation, to which lens points are added until two halves of them
//! agree ([`truth()`]). What comes of many scenes is in [`Statistics`]. A scene that shows a
//! fault can be made smaller ([`shrink()`]).
//!
//! A scene is opened by its name wherever the program opens one: `gauntlet:FAMILY:SEED`, or
//! `gauntlet:SEED`, whose family is the one that comes with that number.

mod bounds;
mod families;
mod figures;
mod maker;
mod run;
mod shrink;
mod spec;
mod statistics;
mod truth;

pub use bounds::{
    Bounds, Known, KnownFamily, KnownMethods, Regression, SAME_SCENES_DB, SAME_SCENES_LIGHT, STANDARD_ERRORS, Which,
    known, known_bounds,
};
pub use families::{FAMILIES, Family, family};
pub use figures::{Figures, Rules, SMOOTH_RANGE, figures};
pub use maker::rounded_to;
pub use run::{GauntletRequest, MethodFigures, SceneResult, examine, run};
pub use shrink::{Shrunk, shrink, size_of};
pub use spec::{LEAST_DEPTH_PER_FOCUS, MOST_CELLS, Pattern, QuadSpec, SceneSpec, SpecError};
pub use statistics::{CAP_DB, Ranking, Spread, Statistics, TIE_DB, counted_db, ranking, statistics};
pub use truth::{AGREEMENT_DB, Agreed, LEAST_POINTS, MOST_POINTS, truth};

use crate::random::Random;
use glam::{UVec2, uvec2};
use maker::Maker;

/// Size of a scene's frame where nothing else is asked for, px.
pub const DEFAULT_SIZE: UVec2 = uvec2(128, 96);

/// What names of generated scenes begin with.
pub const PREFIX: &str = "gauntlet:";

/// Scenes of two runs with different seeds are different for up to this many scenes.
pub const SCENES_A_SEED: u64 = 1_000_000;

/// Seed of scene `index` of a run.
pub fn scene_seed(run_seed: u64, index: u64) -> u64 {
    run_seed.wrapping_mul(SCENES_A_SEED).wrapping_add(index)
}

/// The family that comes with a seed.
pub fn family_of(seed: u64) -> &'static Family {
    &FAMILIES[(seed % FAMILIES.len() as u64) as usize]
}

/// The scene of a family and a seed, of a frame of `size` px: the same on every machine.
pub fn generate(family: &Family, seed: u64, size: UVec2) -> SceneSpec {
    // FNV-1a: families with one seed do not draw the same numbers.
    let hash = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    let salt = family.name.bytes().fold(0xcbf2_9ce4_8422_2325, hash);
    let mut maker = Maker::new(format!("{PREFIX}{}:{seed}", family.name), Random::new(seed ^ salt), size);
    (family.make)(&mut maker);
    maker.made()
}

/// What is wrong with a name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NameError {
    /// Neither of the two forms.
    #[error("'{}' names no scene: give gauntlet:SEED or gauntlet:FAMILY:SEED with a whole number of 0 or more", name.escape_debug())]
    Form {
        /// What was given.
        name: String,
    },
    /// A family that does not exist.
    #[error("there is no family '{}'; there are: {known}", family.escape_debug())]
    Family {
        /// What was given.
        family: String,
        /// The names there are.
        known: String,
    },
}

/// The family called `name`.
///
/// # Errors
///
/// [`NameError::Family`].
pub fn family_by_name(name: &str) -> Result<&'static Family, NameError> {
    let known = || FAMILIES.iter().map(|f| f.name).collect::<Vec<_>>().join(", ");
    family(name).ok_or_else(|| NameError::Family { family: name.into(), known: known() })
}

/// The scene that a name asks for, in a frame of [`DEFAULT_SIZE`]; `None` for a name that
/// does not begin with [`PREFIX`].
pub fn named(name: &str) -> Option<Result<SceneSpec, NameError>> {
    let rest = name.strip_prefix(PREFIX)?;
    let form = || NameError::Form { name: name.into() };
    let seed = |text: &str| text.parse::<u64>().map_err(|_| form());
    let family_and_seed = match rest.split_once(':') {
        None => seed(rest).map(|seed| (family_of(seed), seed)),
        Some((family, number)) => family_by_name(family).and_then(|family| Ok((family, seed(number)?))),
    };
    Some(family_and_seed.map(|(family, seed)| generate(family, seed, DEFAULT_SIZE)))
}
