//! What is known not to hold, and why: failures that are expected, and that make the run
//! fail once they no longer happen.

use super::specimen::ImageCase;

/// A limit of a method as it was published, or of its input.
#[derive(Clone, Copy)]
pub struct KnownLimit {
    /// The method's id.
    pub method: &'static str,
    /// The check that fails.
    pub check: &'static str,
    /// Conditions, any of which must be in a specimen's name for the failure to be expected;
    /// empty for all.
    pub within: &'static [&'static str],
    /// A case that fails: it is part of every run, whatever the seed.
    pub witness: fn() -> ImageCase,
    /// Why, and why it is left so.
    pub reason: &'static str,
}

impl KnownLimit {
    /// Whether a failure of this check on this specimen is expected.
    pub fn covers(&self, method: &str, check: &str, specimen: &str) -> bool {
        let within = self.within.is_empty() || self.within.iter().any(|condition| specimen.contains(condition));
        self.method == method && self.check == check && within
    }
}

/// The known limits.
pub const KNOWN_LIMITS: &[KnownLimit] = &[];
