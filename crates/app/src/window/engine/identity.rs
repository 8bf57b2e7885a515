//! What a picture is: plain data by which figures, differences and reports are held to the
//! pictures that they are about.

use super::request::RenderRequest;
use crate::window::model::MethodChoice;
use crate::window::model::numbers::significant;
use defocus::display::Display;
use defocus::viewing::Viewing;

/// All that a linear picture depends on: two of one identity are equal pixel for pixel on
/// one adapter.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// Which scene or image, and which shaders: a number that is never used for others.
    pub world: u64,
    /// The method with its parameters.
    pub method: MethodChoice,
    /// View, size and lens.
    pub render: RenderRequest,
    /// Lens points, of a picture that converges.
    pub samples: Option<u32>,
}

/// Two pictures that were compared, and how they were shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// The picture.
    pub picture: Identity,
    /// What it was compared with.
    pub truth: Identity,
    /// How both were shown.
    pub display: Display,
    /// Under what angle and in what light.
    pub viewing: Viewing,
}

impl Identity {
    /// The same but for the lens points.
    pub(super) fn is_of(&self, other: &Self) -> bool {
        self.world == other.world && self.method == other.method && self.render == other.render
    }

    /// In what this picture differs from `now`, in words that say what it is of.
    fn departures(&self, now: &Self) -> Vec<String> {
        let (was, is) = (&self.render, &now.render);
        let mut departures = Vec::new();
        if self.world != now.world {
            departures.push("another scene or shader".to_owned());
        }
        if self.method.id != now.method.id {
            departures.push(self.method.title());
        } else if self.method != now.method {
            departures.push("other parameters".into());
        }
        if was.size != is.size {
            departures.push(format!("{} x {} px", was.size.x, was.size.y));
        }
        if was.camera != is.camera {
            departures.push("another view".into());
        }
        if was.draft != is.draft && was.camera == is.camera {
            departures.push("a draft".into());
        }
        if was.overscan_px != is.overscan_px {
            departures.push(format!("{} px of overscan", was.overscan_px));
        }
        if let Some(samples) = self.samples.filter(|_| self.samples != now.samples) {
            departures.push(format!("{samples} lens points"));
        }
        let (lens, lens_now) = (&was.lens, &is.lens);
        if lens.focus_distance_m != lens_now.focus_distance_m {
            departures.push(format!("focus {} m", significant(lens.focus_distance_m)));
        }
        let focused = defocus::lens::Lens { focus_distance_m: lens_now.focus_distance_m, ..lens.clone() };
        // Drawn smaller, a lens has another density and is the same.
        if focused != *lens_now && was.size == is.size {
            departures.push(match lens.aperture_diameter_mm == lens_now.aperture_diameter_mm {
                true => "another lens".into(),
                false => format!("E {} mm", significant(lens.aperture_diameter_mm)),
            });
        }
        departures
    }
}

impl Pairing {
    /// Whether figures of this pair hold for `now`, the lens points of the truth aside.
    pub(super) fn is_of(&self, now: &Self) -> bool {
        self.picture == now.picture
            && self.truth.is_of(&now.truth)
            && self.display == now.display
            && self.viewing == now.viewing
    }

    /// In what it differs from `now`, in words; empty where [`Pairing::is_of`] holds.
    pub(super) fn departures(&self, now: &Self) -> Vec<String> {
        let mut departures = self.picture.departures(&now.picture);
        if self.truth.method != now.truth.method {
            departures.push("another reference".into());
        }
        if self.display != now.display {
            departures.push("another exposure or tone map".into());
        }
        if departures.is_empty() && self.viewing != now.viewing {
            departures.push(format!("{} px per degree or another display", significant(self.viewing.px_per_degree)));
        }
        if departures.is_empty() && !self.is_of(now) {
            departures.push("a reference of another view".into());
        }
        departures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use defocus::lens::Lens;
    use glam::uvec2;

    fn identity() -> Identity {
        let render =
            RenderRequest { camera: None, size: uvec2(64, 48), overscan_px: 0, lens: Lens::PINHOLE, draft: false };
        Identity { world: 1, method: MethodChoice::new("mipmap"), render, samples: None }
    }

    #[test]
    fn every_departure_is_said_and_equals_have_none() {
        let now = Pairing {
            picture: identity(),
            truth: identity(),
            display: Display::default(),
            viewing: Viewing::default(),
        };
        assert_eq!(now.departures(&now), Vec::<String>::new());
        let lens =
            |focus_distance_m, aperture_diameter_mm| Lens { focus_distance_m, aperture_diameter_mm, ..Lens::PINHOLE };
        let with = |change: &dyn Fn(&mut Pairing)| {
            let mut changed = now.clone();
            change(&mut changed);
            assert!(!changed.is_of(&now));
            changed.departures(&now).join(", ")
        };
        assert_eq!(with(&|p| p.picture.method.id = "pinhole".into()), "Pinhole");
        assert_eq!(with(&|p| p.picture.render.size.x = 32), "32 x 48 px");
        assert_eq!(with(&|p| p.picture.render.lens = lens(1.5, 4.0)), "focus 1.5 m, E 4 mm");
        assert_eq!(with(&|p| p.picture.world = 2), "another scene or shader");
        assert_eq!(with(&|p| p.truth.render.size.x = 32), "a reference of another view");
        assert_eq!(with(&|p| p.truth.method.id = "pinhole".into()), "another reference");
        assert_eq!(with(&|p| p.display.exposure_ev = 1.0), "another exposure or tone map");
        assert!(with(&|p| p.viewing.px_per_degree = 25.0).starts_with("25 px per degree"));
        assert!(with(&|p| p.viewing.screen.peak_cd_m2 = 100.0).ends_with("another display"));
        let mut more = now.clone();
        more.truth.samples = Some(8);
        assert!(more.is_of(&now), "lens points are told beside the figures");
    }
}
