//! Lessons: the findings of docs/guide.md, each a state with one sentence and one thing to drag.

use super::document::{Arrangement, Document, Zoom};
use super::method::MethodChoice;
use super::size::PictureSize;
use defocus::aperture::Aperture;
use defocus::eye::amplitude_d;
use defocus::lens::Lens;
use std::ops::RangeInclusive;

/// Size of a lesson's picture, px: small enough for a class before laptops, whose adapters may
/// be programs.
const SIZE_PX: (u32, u32) = (640, 480);

/// How a lesson's lens is found once its scene is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Optics {
    /// The lens that suits the scene, opened to this mean CoC, px.
    MeanCoc(f64),
    /// A preset by its name, with this E, mm.
    Preset(&'static str, f64),
}

/// The one thing to drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dragged {
    /// The divider between the panes.
    Divider,
    /// E.
    Aperture,
    /// The focus distance.
    Focus,
    /// How round the polygon of the aperture is.
    Roundness,
    /// The age that limits the eye's accommodation.
    Age,
}

/// A finding.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// What it is called.
    pub title: &'static str,
    /// What is seen, in one sentence.
    pub sentence: &'static str,
    /// What to drag, and what to look at.
    pub task: &'static str,
    /// The one thing to drag.
    pub dragged: Dragged,
    /// Its lens.
    pub optics: Optics,
    /// Where it is focused, metres; where the scene's author recommends it without.
    pub focus_m: Option<f64>,
    /// Vertical field of view, degrees; the camera's own without.
    pub fov_deg: Option<f64>,
    scene: &'static str,
    exposure_ev: f32,
    blades: Option<u32>,
    age_years: Option<f64>,
    methods: &'static [(&'static str, &'static [(&'static str, &'static str)])],
    arrangement: Arrangement,
}

const PLAIN: Lesson = Lesson {
    title: "",
    sentence: "",
    task: "",
    dragged: Dragged::Divider,
    optics: Optics::MeanCoc(12.0),
    focus_m: None,
    fov_deg: Some(20.0),
    scene: "cans",
    exposure_ev: 0.0,
    blades: None,
    age_years: None,
    methods: &[],
    arrangement: Arrangement::Wipe,
};

/// All lessons, in the order of the guide.
pub static LESSONS: [Lesson; 6] = [
    Lesson {
        title: "Leakage",
        sentence: "What is blurred behind runs over what is sharp in front, unless the method asks who is nearer.",
        task: "Drag the divider over the rim of the red can: a halo on the left, a clean rim on the right.",
        methods: &[("linear", &[]), ("mipmap", &[])],
        ..PLAIN
    },
    Lesson {
        title: "Discontinuity",
        sentence: "A blurred foreground must not end at its outline: its blur reaches over what is sharp behind it.",
        task: "Drag the focus from the wall to the near can: on the left its blur ends at a hard edge.",
        dragged: Dragged::Focus,
        focus_m: Some(3.5),
        methods: &[("mipmap", &[("smoothing", "off")]), ("mipmap", &[("smoothing", "on")])],
        ..PLAIN
    },
    Lesson {
        title: "Partial occlusion",
        sentence: "Behind a blurred edge one sees what no pinhole picture shows: it must be drawn, or be invented.",
        task: "Open the aperture: the cans behind the near lid keep their edges on the right, and smear on the left.",
        dragged: Dragged::Aperture,
        focus_m: Some(3.5),
        methods: &[("mipmap", &[]), ("multiview", &[])],
        arrangement: Arrangement::Tiles,
        ..PLAIN
    },
    Lesson {
        title: "Bokeh",
        sentence: "A small light out of focus is drawn in the shape of the aperture.",
        task: "Drag the blades from straight to round: only the right picture follows.",
        dragged: Dragged::Roundness,
        scene: "highlights",
        optics: Optics::MeanCoc(14.0),
        exposure_ev: -2.0,
        blades: Some(6),
        methods: &[("mipmap", &[]), ("scatter", &[])],
        arrangement: Arrangement::Tiles,
        ..PLAIN
    },
    Lesson {
        title: "Pupil and focus in a headset",
        sentence: "The blur of an eye depends on two things only: how wide its pupil is, and how many dioptres lie between.",
        task: "Drag the pupil from 2 mm, in bright light, to 6 mm, in the dark: three times as wide, three times the blur.",
        dragged: Dragged::Aperture,
        optics: Optics::Preset("hmd", 2.0),
        focus_m: Some(0.46),
        fov_deg: None,
        methods: &[("mipmap", &[])],
        arrangement: Arrangement::One,
        ..PLAIN
    },
    Lesson {
        title: "An eye that grows old",
        sentence: "An eye that cannot focus near sees near things blurred, wherever the program puts the focus.",
        task: "Drag the age: from some 45 years on the near cans are not sharp any more.",
        dragged: Dragged::Age,
        optics: Optics::Preset("hmd", 4.0),
        focus_m: Some(0.3),
        fov_deg: None,
        age_years: Some(20.0),
        methods: &[("mipmap", &[])],
        arrangement: Arrangement::One,
        ..PLAIN
    },
];

impl Lesson {
    /// The state that it begins with; its lens and camera are chosen once the scene is there.
    pub fn document(&self) -> Document {
        let choice = |(id, params): &(&str, &[(&str, &str)])| MethodChoice {
            id: (*id).to_owned(),
            params: params.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect(),
            as_built: false,
        };
        let mut document = Document::of_methods(self.methods.iter().map(choice));
        document.scene = self.scene.into();
        document.size = PictureSize::Pixels(SIZE_PX.0, SIZE_PX.1);
        document.arrangement = self.arrangement;
        document.zoom = Zoom::default();
        document.display.exposure_ev = self.exposure_ev;
        document.automatic_exposure = false;
        document.age_years = self.age_years;
        document
    }

    /// Completes a lens with what the lesson says of aperture and eye.
    pub fn lens(&self, lens: Lens) -> Lens {
        let mut lens = lens;
        if let Some(blades) = self.blades {
            lens.aperture = Aperture::polygon(blades);
        }
        lens.eye.accommodation_d = self.age_years.map(amplitude_d);
        lens
    }
}

impl Dragged {
    /// What it is called, with its unit and its reach.
    pub fn about(self) -> (&'static str, &'static str, RangeInclusive<f64>) {
        match self {
            Self::Divider => ("divider", " %", 0.0..=100.0),
            Self::Aperture => ("aperture E", " mm", 0.0..=40.0),
            Self::Focus => ("focus", " m", 0.3..=4.0),
            Self::Roundness => ("roundness of the blades", "", 0.0..=1.0),
            Self::Age => ("age", " years", 20.0..=75.0),
        }
    }

    /// Its value in a document.
    pub fn value(self, document: &Document) -> f64 {
        match self {
            Self::Divider => 100.0 * f64::from(document.divider),
            Self::Aperture => document.lens.aperture_diameter_mm,
            Self::Focus => document.lens.focus_distance_m,
            Self::Roundness => match document.lens.aperture {
                Aperture::Polygon { roundness, .. } => roundness,
                _ => 1.0,
            },
            Self::Age => document.age_years.unwrap_or(20.0),
        }
    }

    /// Gives it a value, within its reach.
    pub fn set(self, document: &mut Document, value: f64) {
        let (.., range) = self.about();
        if value.is_nan() {
            return;
        }
        let value = value.clamp(*range.start(), *range.end());
        match self {
            Self::Divider => document.divider = (value / 100.0) as f32,
            Self::Aperture => document.lens.aperture_diameter_mm = value,
            Self::Focus => document.lens.focus_distance_m = value,
            Self::Roundness => {
                if let Aperture::Polygon { roundness, .. } = &mut document.lens.aperture {
                    *roundness = value;
                }
            }
            Self::Age => {
                document.age_years = Some(value);
                document.lens.eye.accommodation_d = Some(amplitude_d(value));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lesson_is_a_state_whose_one_thing_can_be_dragged() {
        for lesson in &LESSONS {
            let mut document = lesson.document();
            assert_eq!(document.panes.len(), lesson.methods.len(), "{}", lesson.title);
            assert_eq!(document.clone().repaired(), document, "{}", lesson.title);
            for pane in &document.panes {
                pane.method.build().unwrap_or_else(|e| panic!("{}: {e}", lesson.title));
            }
            document.lens = lesson.lens(Lens { aperture_diameter_mm: 4.0, ..Lens::PINHOLE });
            let (.., range) = lesson.dragged.about();
            for value in [*range.start(), *range.end()] {
                lesson.dragged.set(&mut document, value);
                let is = lesson.dragged.value(&document);
                assert!((is - value).abs() < 1e-4, "{}: {is} and not {value}", lesson.title);
            }
            lesson.dragged.set(&mut document, f64::NAN);
            assert!(lesson.dragged.value(&document).is_finite());
            assert!(lesson.sentence.matches(". ").count() == 0, "one sentence: {}", lesson.sentence);
        }
    }
}
