//! What a pane shows of its method.

use super::method::MethodChoice;
use super::pane_id::PaneId;
use defocus::methods::meaning;

/// What a pane shows.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Show {
    /// The method's picture.
    #[default]
    Picture,
    /// The signed CoC.
    Coc,
    /// Depth.
    Depth,
    /// Which part is sharp.
    Zone,
    /// How it differs from another pane.
    Difference(Difference),
    /// A texture from inside the method.
    Inside(Inside),
}

impl Show {
    /// Names of all, in the order of the list.
    pub const NAMES: [&'static str; 6] =
        ["Picture", "Circle of confusion", "Depth", "Depth of field", "Difference", "Inside the method"];

    /// Place in the list.
    pub fn index(&self) -> usize {
        match self {
            Self::Picture => 0,
            Self::Coc => 1,
            Self::Depth => 2,
            Self::Zone => 3,
            Self::Difference(_) => 4,
            Self::Inside(_) => 5,
        }
    }

    /// The entry of that place for a pane that can be compared with `other`; `None` for a
    /// difference where there is no other.
    pub fn of_index(index: usize, other: Option<PaneId>) -> Option<Self> {
        Some(match index {
            1 => Self::Coc,
            2 => Self::Depth,
            3 => Self::Zone,
            4 => Self::Difference(Difference::new(other?, DifferenceKind::Absolute)),
            5 => Self::Inside(Inside::default()),
            _ => Self::Picture,
        })
    }

    /// The pane it compares with.
    pub fn against(&self) -> Option<PaneId> {
        match self {
            Self::Difference(difference) => Some(difference.against),
            _ => None,
        }
    }
}

/// A difference from another pane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Difference {
    /// The other pane.
    pub against: PaneId,
    /// Which difference.
    pub kind: DifferenceKind,
    /// How much the colour scale is stretched, as a power of two.
    #[serde(default)]
    pub gain_log2: u8,
}

impl Difference {
    /// Greatest power of two by which the scale is stretched: 0.4 % of white then reach its
    /// end, one step of an 8-bit display.
    pub const GREATEST_GAIN_LOG2: u8 = 6;

    /// A difference on its whole scale.
    pub fn new(against: PaneId, kind: DifferenceKind) -> Self {
        Self { against, kind, gain_log2: 0 }
    }

    /// The number at the end of the colour scale of a map that is not computed on the GPU.
    pub fn map_end(&self) -> f32 {
        let whole = if self.kind == DifferenceKind::Jod { defocus_study::report::JOD_MAP_WHITE } else { 1.0 };
        whole / self.gain()
    }

    /// How much the colour scale is stretched.
    pub fn gain(&self) -> f32 {
        f32::from(self.gain_log2.min(Self::GREATEST_GAIN_LOG2)).exp2()
    }
}

/// Ways to look at a difference, each with one fixed colour scale, which can be stretched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum DifferenceKind {
    /// |a - b| of the display values, the greatest channel.
    #[default]
    Absolute,
    /// a - b of the display values, mean of the channels.
    Signed,
    /// |a - b| over b of the linear values, the greatest channel.
    Relative,
    /// Andersson et al. 2020.
    Flip,
    /// What an eye sees of it on the display: Mantiuk et al. 2024.
    Jod,
}

impl DifferenceKind {
    /// All, with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Absolute, "absolute"),
        (Self::Signed, "signed"),
        (Self::Relative, "relative"),
        (Self::Flip, "FLIP"),
        (Self::Jod, "visible"),
    ];
}

/// A texture from inside a method.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Inside {
    /// The name under which the method exposes it; the first where there is none of it.
    pub name: String,
    /// Mipmap level.
    pub level: u32,
    /// Array layer.
    pub layer: u32,
    /// Which channels.
    pub channel: Channel,
}

impl Inside {
    /// What a method tells of each pixel or tile, by name: what is worth laying over its
    /// picture.
    pub fn overlays(method: &MethodChoice) -> Vec<(&'static str, Self)> {
        let Ok(method) = method.build() else { return Vec::new() };
        let channels = || Channel::ALL.iter().skip(1).map(|(channel, _)| *channel);
        let mut overlays: Vec<(&'static str, Self)> = Vec::new();
        for texture in method.explains() {
            for (quantity, channel) in meaning(method.as_ref(), texture).quantities().iter().zip(channels()) {
                // The circle of confusion is shown of every method, under its own name.
                if quantity.name != "CoC" && overlays.iter().all(|(name, _)| *name != quantity.name) {
                    let inside = Self { name: (*texture).to_owned(), channel, ..Self::default() };
                    overlays.push((quantity.name, inside));
                }
            }
        }
        overlays
    }
}

/// Channels of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Channel {
    /// As a picture: red, green and blue.
    #[default]
    Color,
    /// The first, on a colour scale.
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
    /// The fourth.
    Alpha,
}

impl Channel {
    /// All, with their names.
    pub const ALL: [(Self, &'static str); 5] =
        [(Self::Color, "RGB"), (Self::Red, "R"), (Self::Green, "G"), (Self::Blue, "B"), (Self::Alpha, "A")];

    /// Place of the one channel, from 0; `None` for all three.
    pub fn index(self) -> Option<u32> {
        Self::ALL.iter().position(|(c, _)| *c == self).and_then(|i| (i as u32).checked_sub(1))
    }
}
