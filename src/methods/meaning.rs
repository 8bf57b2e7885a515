//! What the channels of exposed textures mean: units, scale and names for display. One description
//! serves all methods, none needs an overlay of its own.

/// How an exposed texture is to be read.
#[derive(Clone, Debug, PartialEq)]
pub enum Meaning {
    /// As a picture: linear red, green and blue.
    Picture,
    /// Each channel is a number of its own, in their order.
    Numbers(Vec<Quantity>),
}

/// What the numbers of a channel are.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// What it is called.
    pub name: &'static str,
    /// Its unit with a leading space, or nothing.
    pub unit: &'static str,
    /// What a stored 1 stands for, in units.
    pub one: f32,
    /// How values become colours.
    pub scale: Scale,
}

/// How the values of a channel become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// From the least to the greatest value there is.
    Found,
    /// 0 in the middle, the greatest magnitude there is at both ends.
    Signed,
    /// Whole numbers from the least to the greatest there is, a colour each.
    Whole,
    /// Stored values with names, in rising order, a colour each.
    Classes(&'static [(f32, &'static str)]),
}

impl Scale {
    /// Stored values at the ends of the colours, where values lie from `found[0]` to
    /// `found[1]`.
    pub fn ends(self, found: [f32; 2]) -> [f32; 2] {
        let [low, high] = found;
        match self {
            Self::Found => found,
            Self::Signed => {
                let most = low.abs().max(high.abs());
                [-most, most]
            }
            Self::Whole => [low.round(), high.round()],
            Self::Classes(classes) => {
                [classes.first().map_or(0.0, |(value, _)| *value), classes.last().map_or(1.0, |(value, _)| *value)]
            }
        }
    }
}

impl Quantity {
    /// A number of that name; `unit` has its leading space.
    pub fn new(name: &'static str, unit: &'static str, scale: Scale) -> Self {
        Self { name, unit, one: 1.0, scale }
    }

    /// The same where a stored 1 stands for `one` units.
    pub fn worth(self, one: f32) -> Self {
        Self { one, ..self }
    }
}

impl Default for Quantity {
    /// A number of which nothing is known.
    fn default() -> Self {
        Self::new("value", "", Scale::Found)
    }
}

impl Meaning {
    /// Channels with a number each.
    pub fn numbers(channels: impl IntoIterator<Item = Quantity>) -> Self {
        Self::Numbers(channels.into_iter().collect())
    }

    /// One channel with stored depth, near over depth.
    pub fn stored_depth() -> Self {
        Self::numbers([Quantity::new("near / depth", "", Scale::Found)])
    }

    /// The numbers of a texture with so many channels; none of a picture.
    pub fn channels(&self, components: u8) -> Vec<Quantity> {
        match self {
            Self::Picture if components == 1 => vec![Quantity::default()],
            Self::Picture => Vec::new(),
            Self::Numbers(channels) => channels.clone(),
        }
    }

    /// The numbers, if it is none of a picture.
    pub fn quantities(&self) -> &[Quantity] {
        match self {
            Self::Picture => &[],
            Self::Numbers(channels) => channels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_hold_what_was_found() {
        assert_eq!(Scale::Found.ends([1.0, 3.0]), [1.0, 3.0]);
        assert_eq!(Scale::Signed.ends([-2.0, 6.0]), [-6.0, 6.0]);
        assert_eq!(Scale::Whole.ends([0.9, 3.1]), [1.0, 3.0]);
        assert_eq!(Scale::Classes(&[(0.0, "a"), (0.5, "b"), (1.0, "c")]).ends([0.0, 0.5]), [0.0, 1.0]);
    }
}
