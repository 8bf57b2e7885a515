//! The conflict of vergence and accommodation: on a display the eyes converge at what is
//! shown and focus at the screen.

/// Vergence-accommodation conflict, D: how much nearer than the display's focal distance the
/// eyes converge; negative for what is farther. Distances in metres, infinity included.
pub fn conflict_d(converged_m: f64, display_m: f64) -> f64 {
    1.0 / converged_m - 1.0 / display_m
}

/// The zone of comfort: Shibata, Kim, Hoffman and Banks, "The Zone of Comfort: Predicting
/// Visual Discomfort with Stereo Displays" (Journal of Vision 11(8):11, 2011).
///
/// Its borders are lines in the plane of vergences: what is converged at is comfortable
/// between `slope * display + offset` of both, dioptres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComfortZone {
    /// Slope and offset (D) of the near border.
    pub near: [f64; 2],
    /// Slope and offset (D) of the far border.
    pub far: [f64; 2],
}

impl Default for ComfortZone {
    /// The estimate of the paper, section "Zone of comfort": `D_far = 1.129 D + 0.442` and
    /// `D_near = 1.035 D - 0.626` for a display at distance 1/D, as the vergences of the focal
    /// distance by that of convergence. Here they are turned about: by display.
    fn default() -> Self {
        Self { near: [1.0 / 1.035, 0.626 / 1.035], far: [1.0 / 1.129, -0.442 / 1.129] }
    }
}

/// How comfortable it is to look at something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Comfort {
    /// Inside the zone.
    Comfortable,
    /// Nearer than it reaches.
    TooNear,
    /// Farther than it reaches.
    TooFar,
}

impl ComfortZone {
    /// The vergences, D, nearest and farthest, that are comfortable to converge at before a
    /// display at `display_d` D. The far one may lie beyond infinity, below 0.
    pub fn at(&self, display_d: f64) -> [f64; 2] {
        [self.near, self.far].map(|[slope, offset]| slope * display_d + offset)
    }

    /// The distances, m, nearest and farthest, that are comfortable before a display at
    /// `display_m` metres; the far one may be infinite.
    pub fn distances_m(&self, display_m: f64) -> [f64; 2] {
        self.at(1.0 / display_m).map(|d| if d > 0.0 { 1.0 / d } else { f64::INFINITY })
    }

    /// How comfortable it is to converge at `converged_m` before a display at `display_m`.
    pub fn judge(&self, converged_m: f64, display_m: f64) -> Comfort {
        let [near, far] = self.at(1.0 / display_m);
        let converged = 1.0 / converged_m;
        if converged > near {
            Comfort::TooNear
        } else if converged < far {
            Comfort::TooFar
        } else {
            Comfort::Comfortable
        }
    }
}
