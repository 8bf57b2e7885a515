//! Whether a difference is seen, in words.

use super::jod::PERFECT_JOD;

/// Standard normal quantile of 75 %: by definition the distance of two pictures that differ
/// by 1 JOD, in standard deviations of an observer's judgement.
const DEVIATIONS_PER_JOD: f64 = 0.674_489_750_196_082;

/// How visible a difference is.
///
/// A difference of D JOD means that a share `Phi(0.6745 D)` of observers, asked which of two
/// pictures is better, choose the better one: Thurstone's case V, scaled as Mantiuk et al.
/// (SIGGRAPH 2024) and Perez-Ortiz et al., "From Pairwise Comparisons and Rating to a Unified
/// Quality Scale" (IEEE TIP 2020), scale it, so that 1 JOD are 75 %. The bounds follow from
/// shares that an experiment tells apart; [`Visibility::why`] says which.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Visibility {
    /// Observers do no better than by guessing.
    NotVisible,
    /// Below the threshold of discrimination.
    HardlyVisible,
    /// Above it.
    Visible,
    /// More than nine of ten see it.
    Obvious,
}

impl Visibility {
    /// All, the least visible first.
    pub const ALL: [Self; 4] = [Self::NotVisible, Self::HardlyVisible, Self::Visible, Self::Obvious];

    /// The word for a quality of `jod`.
    pub fn of_jod(jod: f64) -> Self {
        let reached = |word: &Self| word.least_jod().is_some_and(|least| jod >= least);
        Self::ALL.into_iter().find(reached).unwrap_or(Self::Obvious)
    }

    /// The least quality, JOD, that counts as this; `None` for the last word.
    pub fn least_jod(self) -> Option<f64> {
        match self {
            Self::NotVisible => Some(9.64),
            Self::HardlyVisible => Some(9.0),
            Self::Visible => Some(8.0),
            Self::Obvious => None,
        }
    }

    /// The word itself.
    pub fn word(self) -> &'static str {
        match self {
            Self::NotVisible => "not visible",
            Self::HardlyVisible => "hardly visible",
            Self::Visible => "visible",
            Self::Obvious => "obvious",
        }
    }

    /// Where the bound comes from.
    pub fn why(self) -> &'static str {
        match self {
            Self::NotVisible => {
                "9.64 JOD or more: at most 59.6 % of observers choose the reference, which a hundred choices cannot tell from guessing (95 % interval of 50 of 100)"
            }
            Self::HardlyVisible => {
                "9 JOD or more: at most 75 % choose the reference, the threshold of discrimination that defines 1 JOD (Mantiuk et al. 2024)"
            }
            Self::Visible => "8 JOD or more: at most 91 % choose the reference, Phi(2 x 0.6745)",
            Self::Obvious => "less than 8 JOD: more than 91 % choose the reference",
        }
    }

    /// Its colour, sRGB: from green to red, told apart also by those who see no red or green.
    pub fn srgb8(self) -> [u8; 3] {
        match self {
            Self::NotVisible => [0, 158, 115],
            Self::HardlyVisible => [86, 180, 233],
            Self::Visible => [230, 159, 0],
            Self::Obvious => [213, 94, 0],
        }
    }
}

impl std::fmt::Display for Visibility {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.word())
    }
}

/// The share of observers, in [0, 1], who choose the reference over a picture of `jod`.
pub fn share_who_see(jod: f64) -> f64 {
    normal_cdf(DEVIATIONS_PER_JOD * (PERFECT_JOD - jod))
}

/// Standard normal distribution, to 1.5e-7: Abramowitz and Stegun, "Handbook of Mathematical
/// Functions" (1964), equation 7.1.26.
fn normal_cdf(x: f64) -> f64 {
    let z = x.abs() * std::f64::consts::FRAC_1_SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let series =
        t * (0.254_829_592 + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    let erf = 1.0 - series * (-z * z).exp();
    if x < 0.0 { 0.5 * (1.0 - erf) } else { 0.5 * (1.0 + erf) }
}
