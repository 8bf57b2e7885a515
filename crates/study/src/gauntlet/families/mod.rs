//! Kinds of scenes: each is what one thing goes wrong with.

mod cards;
mod edges;
mod images;
mod lights;
mod walls;

use super::maker::Maker;

/// A kind of scenes.
#[derive(Clone, Copy)]
pub struct Family {
    /// Its name in `gauntlet:NAME:SEED`.
    pub name: &'static str,
    /// What there is to see, in one sentence.
    pub about: &'static str,
    /// Puts it together.
    pub(super) make: fn(&mut Maker),
}

/// Every family; `gauntlet:SEED` takes them in turn.
pub const FAMILIES: &[Family] = &[
    Family {
        name: "specks_near",
        about: "Specks of 1 to 5 px before the focus, of all brightnesses.",
        make: lights::specks_near,
    },
    Family {
        name: "specks_far",
        about: "Specks of 1 to 5 px behind the focus, before what is farther.",
        make: lights::specks_far,
    },
    Family { name: "points", about: "Specks of 0.3 to 1 px, which a pixel sees or misses.", make: lights::points },
    Family { name: "lights", about: "Lights of 3 to 20 px, alone or in rows.", make: lights::lights },
    Family { name: "cards", about: "Cards at random angles.", make: cards::cards },
    Family {
        name: "planes",
        about: "A plane from near to far through the focus, with things on it.",
        make: cards::planes,
    },
    Family { name: "stacks", about: "Several near things over each other.", make: cards::stacks },
    Family { name: "mixed", about: "Quads of all sizes, depths and angles.", make: cards::mixed },
    Family { name: "fences_near", about: "Bars before the focus.", make: walls::fences_near },
    Family { name: "fences_far", about: "Bars behind the focus, before what is farther.", make: walls::fences_far },
    Family { name: "slots", about: "A wall with slots through which something else is seen.", make: walls::slots },
    Family { name: "holes", about: "A wall with a hole.", make: walls::holes },
    Family {
        name: "diagonals",
        about: "Thin slanted lines, also such that pass through the focus.",
        make: walls::diagonals,
    },
    Family {
        name: "near_before_sharp",
        about: "Small near things before a sharp wall.",
        make: edges::near_before_sharp,
    },
    Family { name: "borders", about: "Bright areas across the border of the frame.", make: edges::borders },
    Family { name: "margin", about: "Things, or the sky, in the margin only.", make: edges::margin },
    Family { name: "skies", about: "Things before the open sky.", make: edges::skies },
    Family { name: "steps", about: "Strips side by side whose CoC differs by 0.1 to 100 px.", make: edges::steps },
    Family {
        name: "image_specks",
        about: "Specks of whole pixels before one colour, as an image with depth.",
        make: images::specks,
    },
    Family {
        name: "image_cards",
        about: "Cards beside each other before one colour, as an image with depth.",
        make: images::cards,
    },
    Family {
        name: "image_bands",
        about: "Bright bands across the border, as an image with depth.",
        make: images::bands,
    },
    Family { name: "image_steps", about: "Strips whose CoC differs, as an image with depth.", make: images::steps },
    Family { name: "image_planes", about: "A plane through the focus, as an image with depth.", make: images::planes },
];

/// The family called `name`.
pub fn family(name: &str) -> Option<&'static Family> {
    FAMILIES.iter().find(|family| family.name == name)
}
