//! Long work in steps that are short on whatever adapter does it.

use std::time::Duration;

/// Time between two looks at whether the work is still wanted: nobody notices it.
pub const STEP: Duration = Duration::from_millis(50);

/// Units of a step at most, however fast they are: what is recorded at once takes memory.
const MOST_UNITS: u32 = 32;

/// How many units of work, such as views, fit into a step: learned from the steps before.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    ms_per_unit: f64,
}

impl Default for Steps {
    /// Nothing is known: the first step has one unit.
    fn default() -> Self {
        Self { ms_per_unit: STEP.as_secs_f64() * 1e3 }
    }
}

impl Steps {
    /// Units of the next step where `left` are left: at least 1 of them.
    pub fn next(&self, left: u32) -> u32 {
        let units = (STEP.as_secs_f64() * 1e3 / self.ms_per_unit).min(f64::from(MOST_UNITS)) as u32;
        units.max(1).min(left)
    }

    /// Takes in how long a step of so many units took.
    pub fn took(&mut self, units: u32, elapsed: Duration) {
        // A clock that did not move says that the units are as short as it can tell.
        self.ms_per_unit = (elapsed.as_secs_f64() * 1e3 / f64::from(units.max(1))).max(1e-3);
    }

    /// Time of a unit of the last step, ms.
    pub fn ms_per_unit(&self) -> f64 {
        self.ms_per_unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_as_long_as_the_adapter_allows() {
        let mut steps = Steps::default();
        assert_eq!(steps.next(100), 1, "nothing is known yet");
        steps.took(1, Duration::from_millis(400));
        assert_eq!(steps.next(100), 1, "a view that takes long is a step of its own");
        steps.took(1, Duration::from_millis(10));
        assert_eq!(steps.next(100), 5);
        assert_eq!(steps.next(3), 3);
        steps.took(5, Duration::ZERO);
        assert_eq!(steps.next(1000), MOST_UNITS);
    }
}
