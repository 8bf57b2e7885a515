//! What a method cannot show of what is asked for, in words.

use super::method::MethodChoice;
use defocus::aperture::Aperture;
use defocus::methods::{self, Apertures};

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
