//! Units in which a person reads distances.

use defocus::focus::{dioptres, metres};

/// Unit of the focus distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum DistanceUnit {
    /// Metres.
    #[default]
    Metres,
    /// Centimetres.
    Centimetres,
    /// Feet of 0.3048 m.
    Feet,
    /// Reciprocal metres; 0 is infinitely far.
    Dioptres,
}

impl DistanceUnit {
    /// All, with their symbols.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Metres, "m"), (Self::Centimetres, "cm"), (Self::Feet, "ft"), (Self::Dioptres, "dpt")];

    /// A distance in metres in this unit.
    pub fn of_metres(self, distance_m: f64) -> f64 {
        match self {
            Self::Metres => distance_m,
            Self::Centimetres => distance_m * 100.0,
            Self::Feet => distance_m / 0.3048,
            Self::Dioptres => dioptres(distance_m),
        }
    }

    /// A distance of this unit in metres.
    pub fn to_metres(self, value: f64) -> f64 {
        match self {
            Self::Metres => value,
            Self::Centimetres => value * 0.01,
            Self::Feet => value * 0.3048,
            Self::Dioptres => metres(value),
        }
    }
}
