//! The moment of an animation that is shown.

use defocus::scene::gltf;

/// A moment of one of a file's animations.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Moment {
    /// The animation's name, or its number from 0 where it has none.
    pub animation: String,
    /// Seconds from its beginning.
    pub time_s: f64,
}

impl Moment {
    /// The same with what a file could have wrong put right.
    pub fn repaired(self) -> Self {
        let time_s = if self.time_s.is_finite() { self.time_s.max(0.0) } else { 0.0 };
        Self { time_s, ..self }
    }

    /// The same `by_s` later, from the beginning again after an animation of `duration_s`.
    pub fn later(&self, by_s: f64, duration_s: f64) -> Self {
        let time_s = self.time_s + by_s.max(0.0);
        let time_s = if duration_s > 0.0 { time_s.rem_euclid(duration_s) } else { 0.0 };
        Self { time_s, ..self.clone() }
    }
}

impl From<&Moment> for gltf::Moment {
    fn from(moment: &Moment) -> Self {
        Self { animation: Some(moment.animation.clone()), time_s: moment.time_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_animation_begins_again_at_its_end() {
        let moment = Moment { animation: "walk".into(), time_s: 1.5 };
        assert_eq!(moment.later(0.25, 2.0).time_s, 1.75);
        assert_eq!(moment.later(0.75, 2.0).time_s, 0.25);
        assert_eq!(moment.later(0.75, 0.0).time_s, 0.0);
        assert_eq!(Moment { time_s: f64::NAN, ..moment }.repaired().time_s, 0.0);
    }
}
