//! What a method cannot show of what is asked for, in words.

use super::method::MethodChoice;
use defocus::aperture::Aperture;
use defocus::eye::Eye;
use defocus::methods::{self, Apertures};

/// What `choice` makes of an astigmatic eye, where it cannot show its elliptical blur, and which
/// methods can.
pub fn astigmatism_limit(choice: &MethodChoice, eye: &Eye) -> Option<String> {
    let about = methods::by_id(&choice.id).ok()?.about();
    if eye.refraction.cylinder_d == 0.0 || about.astigmatism || about.apertures == Apertures::None {
        return None;
    }
    let all = methods::all().into_iter().map(|method| method.about());
    let can: Vec<&str> = all.filter(|other| other.astigmatism).map(|other| other.title).collect();
    Some(format!("{} blurs as the eye's mean meridian does: the ellipse is shown by {}.", about.title, can.join(", ")))
}

/// What `choice` makes of an aperture that has a shape of its own, where it cannot show it,
/// and which methods can.
pub fn aperture_limit(choice: &MethodChoice, aperture: &Aperture) -> Option<String> {
    let has_shape = match aperture {
        Aperture::Polygon { roundness, .. } => *roundness < 1.0,
        Aperture::Image(_) => true,
        Aperture::Disc | Aperture::Gaussian { .. } => false,
    };
    let about = methods::by_id(&choice.id).ok()?.about();
    if !has_shape || about.apertures != Apertures::Round {
        return None;
    }
    let all = methods::all().into_iter().map(|method| method.about());
    let can: Vec<&str> = all.filter(|other| other.apertures == Apertures::Any).map(|other| other.title).collect();
    Some(format!("{} blurs roundly, as wide as this aperture: its shape is shown by {}.", about.title, can.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use defocus::eye::Refraction;

    #[test]
    fn only_an_ellipse_that_is_not_shown_is_spoken_of() {
        let refraction = Refraction { cylinder_d: -1.5, axis_deg: 90.0, ..Refraction::default() };
        for about in methods::all().into_iter().map(|method| method.about()) {
            let choice = MethodChoice::new(about.id);
            assert_eq!(astigmatism_limit(&choice, &Eye::default()), None);
            let told = astigmatism_limit(&choice, &Eye { refraction, ..Eye::default() });
            let is_limited = !about.astigmatism && about.apertures != Apertures::None;
            assert_eq!(told.is_some(), is_limited, "{}", about.id);
        }
    }

    #[test]
    fn only_a_shape_that_is_not_shown_is_spoken_of() {
        for about in methods::all().into_iter().map(|method| method.about()) {
            let choice = MethodChoice::new(about.id);
            assert_eq!(aperture_limit(&choice, &Aperture::Disc), None);
            let told = aperture_limit(&choice, &Aperture::polygon(5));
            assert_eq!(told.is_some(), about.apertures == Apertures::Round, "{}", about.id);
            if let Some(told) = told {
                assert!(told.starts_with(about.title) && told.contains("Accumulation buffer"), "{told}");
            }
        }
    }
}
