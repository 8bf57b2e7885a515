//! Which of an EXR's layers is the picture and which is its depth.
//!
//! Renderers write dozens of passes under names that differ by program: what is called like
//! colour or depth is taken, exact names first; what is not clear is not guessed.

use std::collections::BTreeMap;

/// Last name of a layer that holds the picture, without case and punctuation.
const COLOR_NAMES: &[&str] =
    &["beauty", "color", "colour", "combined", "composite", "final", "main", "rgb", "rgba", "rgbcolor", "rgbacolor"];

/// Last name of a layer or channel that holds depth.
const DEPTH_NAMES: &[&str] = &["depth", "z", "zdepth", "vrayzdepth", "worlddepth", "depthz", "zbuffer"];

/// Words in the names of layers that are neither the picture nor depth, whatever their
/// channels are called: a normal has a Z, and mist is a number a pixel.
const DATA_WORDS: &[&str] = &[
    "ao",
    "crypto",
    "cryptomatte",
    "forward",
    "id",
    "index",
    "mask",
    "matte",
    "mist",
    "motion",
    "n",
    "normal",
    "normals",
    "p",
    "pos",
    "position",
    "occlusion",
    "speed",
    "uv",
    "vector",
    "velocity",
    "disparity",
];

/// Channels of a depth layer, the first that it has.
const DEPTH_COMPONENTS: &[&str] = &["z", "v", "y", "r", "x", "depth", "d", "distance", "value", "l"];

/// Channels of one part that share a name before their last dot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    /// Index of the part.
    pub part: usize,
    /// The part's view, or one that the layer is named after; empty for none.
    pub view: String,
    /// As it is shown and chosen: part and layer names.
    pub name: String,
    /// Names of part and layer, without case, punctuation and view.
    path: Vec<String>,
    /// Words of those names.
    words: Vec<String>,
    /// Channel indices by the last part of their names, lower case.
    pub channels: BTreeMap<String, usize>,
}

/// What a layer was chosen by: less is more certain.
type Rank = u8;

impl Layer {
    /// The layers of a file's parts, each given by name, view and channel names.
    pub(super) fn all<'a>(parts: impl Iterator<Item = (&'a str, &'a str, Vec<&'a str>)>) -> Vec<Self> {
        let parts: Vec<_> = parts.collect();
        let is_single = parts.len() == 1;
        let mut layers: Vec<Self> = Vec::new();
        for (part, (part_name, view, channels)) in parts.into_iter().enumerate() {
            // An empty name stands for a channel that does not count.
            for (index, channel) in channels.into_iter().enumerate().filter(|(_, channel)| !channel.is_empty()) {
                let (prefix, component) = channel.rsplit_once('.').unwrap_or(("", channel));
                // A single part's name says nothing: programs put their own there.
                let names: Vec<&str> = if is_single { vec![prefix] } else { vec![part_name, prefix] };
                let name = names.into_iter().filter(|name| !name.is_empty()).collect::<Vec<_>>().join(".");
                let component = component.to_lowercase();
                match layers.iter_mut().find(|layer| layer.part == part && layer.name == name) {
                    Some(layer) => {
                        layer.channels.insert(component, index);
                    }
                    None => layers.push(Self::new(part, view, name, (component, index))),
                }
            }
        }
        layers
    }

    fn new(part: usize, view: &str, name: String, channel: (String, usize)) -> Self {
        let mut view = view.to_lowercase();
        let mut path = Vec::new();
        let mut all_words = Vec::new();
        for component in name.split('.') {
            let mut words = words(component);
            words.retain(|word| {
                let is_view = ["left", "right"].contains(&word.as_str());
                if is_view && view.is_empty() {
                    view.clone_from(word);
                }
                !is_view
            });
            path.extend(Some(words.concat()).filter(|name| !name.is_empty()));
            all_words.extend(words);
        }
        Self { part, view, name, path, words: all_words, channels: BTreeMap::from([channel]) }
    }

    /// How it is called in messages.
    pub(super) fn shown(&self) -> String {
        let channels = self.channels.keys().map(|c| c.to_uppercase()).collect::<Vec<_>>().join("");
        if self.name.is_empty() { channels } else { format!("{} ({channels})", self.name) }
    }

    fn has(&self, components: &[&str]) -> bool {
        components.iter().all(|component| self.channels.contains_key(*component))
    }

    fn last(&self) -> &str {
        self.path.last().map_or("", String::as_str)
    }

    fn is_data(&self) -> bool {
        self.words.iter().any(|word| DATA_WORDS.iter().any(|data| word == data))
    }

    /// Whether the layer's own name says that it is depth, and how exactly.
    fn depth_name(&self) -> Option<Rank> {
        if DEPTH_NAMES.contains(&self.last()) {
            return Some(2);
        }
        (!self.is_data() && self.words.iter().any(|word| word.ends_with("depth"))).then_some(3)
    }

    /// How certain it is that the layer is the picture; `None` if it cannot be.
    pub(super) fn color_rank(&self) -> Option<Rank> {
        let is_color = self.has(&["r", "g", "b"]) || self.has(&["y"]) && !self.has(&["x"]);
        if !is_color || self.is_data() && !self.words.iter().any(|w| w == "ao") || self.depth_name().is_some() {
            return None;
        }
        let is_luminance = if self.has(&["r", "g", "b"]) { 0 } else { 4 };
        let by_name = match self.last() {
            "" => 0,
            name if COLOR_NAMES.contains(&name) => 1,
            _ => 2,
        };
        Some(is_luminance + by_name)
    }

    /// The channels of the layer that may be depth, of which all must be the same where
    /// there are several, with how certain it is; `None` if it has none.
    pub(super) fn depth(&self) -> Option<(Rank, Vec<usize>)> {
        let is_vector = self.has(&["x", "y"]);
        // A channel that is called depth itself, beside colour or alone.
        let own = DEPTH_NAMES.iter().find_map(|name| self.channels.get(*name).map(|&index| (*name, index)));
        if let Some((name, index)) = own
            && !is_vector
            && !self.is_data()
            && self.depth_name().is_none()
        {
            let is_bare = self.path.is_empty() || COLOR_NAMES.contains(&self.last());
            let rank = match (is_bare, name) {
                (true, "z") => 0,
                (true, _) => 1,
                _ => 2,
            };
            return Some((rank, vec![index]));
        }
        let rank = self.depth_name()?;
        if self.has(&["r", "g", "b"]) && !self.has(&["z"]) && !self.has(&["v"]) {
            return Some((rank, ["r", "g", "b"].iter().map(|c| self.channels[*c]).collect()));
        }
        if is_vector {
            let all = ["x", "y", "z"].iter().filter_map(|c| self.channels.get(*c).copied());
            return Some((rank, all.collect()));
        }
        let named = DEPTH_COMPONENTS.iter().find_map(|c| self.channels.get(*c).copied());
        let single = || self.channels.values().next().copied().filter(|_| self.channels.len() == 1);
        named.or_else(single).map(|index| (rank, vec![index]))
    }

    /// The channels of a layer without a telling name whose values can only be one number a
    /// pixel: a single one, or three of a grey picture. Mist and the like are none.
    pub(super) fn only_values(&self) -> Option<Vec<usize>> {
        let is_candidate = self.channels.len() == 1 || self.has(&["r", "g", "b"]);
        let own_name = self.channels.keys().any(|name| DATA_WORDS.contains(&name.as_str()) && name != "n");
        let colors = |name: &&String| self.channels.len() == 1 || ["r", "g", "b"].contains(&name.as_str());
        (is_candidate && !self.is_data() && !own_name)
            .then(|| self.channels.iter().filter(|(name, _)| colors(name)).map(|(_, &index)| index).collect())
    }

    /// Whether the layer is meant by a name that someone typed: its own, or the end of it.
    pub(super) fn is_called(&self, wanted: &str) -> bool {
        let (own, wanted) = (self.name.to_lowercase(), wanted.to_lowercase());
        own == wanted || own.strip_suffix(&wanted).is_some_and(|rest| rest.ends_with('.'))
    }

    /// How much the layer has in common with another one: view, enclosing layer, part.
    pub(super) fn kinship(&self, other: &Self) -> u8 {
        let parent = |layer: &Self| layer.path.split_last().map(|(_, parent)| parent.to_vec()).unwrap_or_default();
        4 * u8::from(self.view == other.view)
            + 2 * u8::from(parent(self) == parent(other))
            + u8::from(self.part == other.part)
    }
}

/// Words of a name, lower case: split where letters and digits end and where a capital
/// follows a small letter.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for letter in name.chars() {
        if !letter.is_alphanumeric() || (after_small && letter.is_uppercase()) {
            words.push(String::new());
        }
        if letter.is_alphanumeric() {
            words.iter_mut().last().into_iter().for_each(|word| word.extend(letter.to_lowercase()));
        }
        after_small = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The one layer of the least rank; `Err` with all that are equally good, and empty if
/// there is none.
pub(super) fn best<'a, T>(
    ranked: impl Iterator<Item = (Rank, &'a Layer, T)>,
) -> Result<(&'a Layer, T), Vec<&'a Layer>> {
    let mut all: Vec<_> = ranked.collect();
    let Some(least) = all.iter().map(|(rank, ..)| *rank).min() else { return Err(Vec::new()) };
    all.retain(|(rank, ..)| *rank == least);
    // Layers of several views are alike: the first view is shown.
    let first_view = all[0].1.view.clone();
    if all.iter().any(|(_, layer, _)| layer.view != first_view) {
        all.retain(|(_, layer, _)| layer.view == first_view);
    }
    if all.len() > 1 {
        return Err(all.into_iter().map(|(_, layer, _)| layer).collect());
    }
    all.into_iter().next().map(|(_, layer, found)| (layer, found)).ok_or_else(Vec::new)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(channels: &[&'static str]) -> Vec<Layer> {
        Layer::all(std::iter::once(("", "", channels.to_vec())))
    }

    /// The channel that is taken as depth.
    fn depth(channels: &[&'static str]) -> Option<&'static str> {
        let layers = layers(channels);
        let ranked = layers.iter().filter_map(|layer| layer.depth().map(|(rank, found)| (rank, layer, found)));
        best(ranked).ok().map(|(_, found)| channels[found[0]])
    }

    fn color(channels: &[&'static str]) -> Option<String> {
        let layers = layers(channels);
        let ranked = layers.iter().filter_map(|layer| layer.color_rank().map(|rank| (rank, layer, ())));
        best(ranked).ok().map(|(layer, ())| layer.name.clone())
    }

    #[test]
    fn depth_by_the_names_of_many_programs() {
        for name in [
            "Z",
            "z",
            "depth",
            "Depth",
            "DEPTH",
            "Depth.Z",
            "Depth.V",
            "ViewLayer.Depth.Z",
            "ViewLayer.Depth.V",
            "View Layer.Depth.V",
            "depth.z",
            "depth.x",
            "depth.r",
            "depth.y",
            "VRayZDepth",
            "VRayZDepth.R",
            "WorldDepth.R",
            "rgba.Z",
            "RenderLayer.Z",
            "ZDepth.Z",
            "camera_depth.V",
        ] {
            let others = [
                "A",
                "B",
                "G",
                "R",
                "Normal.X",
                "Normal.Y",
                "Normal.Z",
                "Mist.V",
                "Position.X",
                "Position.Y",
                "Position.Z",
            ];
            assert_eq!(depth(&[&others[..], &[name]].concat()), Some(name), "{name}");
        }
        for none in [
            &["R", "G", "B"][..],
            &["Mist.Z"],
            &["ViewLayer.Mist.V"],
            &["Normal.X", "Normal.Y", "Normal.Z"],
            &["N.X", "N.Y", "N.Z"],
            &["Position.X", "Position.Y", "Position.Z"],
            &["X", "Y", "Z"],
            &["AO.Z", "UV.Z"],
            &["worldPosition.Z"],
        ] {
            assert_eq!(depth(none), None, "{none:?}");
        }
        assert_eq!(depth(&["ViewLayer.Denoising Depth.Z", "ViewLayer.Depth.Z"]), Some("ViewLayer.Depth.Z"));
        assert_eq!(depth(&["Z", "depth.V"]), Some("Z"));
        // Two layers of equal right: not clear.
        assert_eq!(depth(&["A.Depth.Z", "B.Depth.Z"]), None);
    }

    #[test]
    fn the_picture_before_its_passes() {
        let rgb = |layer: &str| ["R", "G", "B"].map(|c| format!("{layer}.{c}").leak() as &'static str);
        let passes =
            [rgb("ViewLayer.AO"), rgb("ViewLayer.DiffDir"), rgb("ViewLayer.Combined"), rgb("ViewLayer.Normal")];
        assert_eq!(color(passes.as_flattened()).as_deref(), Some("ViewLayer.Combined"));
        assert_eq!(color(&[&["R", "G", "B"][..], &rgb("beauty")].concat()).as_deref(), Some(""));
        assert_eq!(color(&[rgb("diffuse"), rgb("Beauty")].concat()).as_deref(), Some("Beauty"));
        assert_eq!(color(&rgb("AO")).as_deref(), Some("AO"));
        assert_eq!(color(&[rgb("diffuse"), rgb("specular")].concat()), None);
        assert_eq!(color(&rgb("Normal")), None);
        assert_eq!(color(&["Y"]).as_deref(), Some(""));
    }

    #[test]
    fn depth_goes_with_the_view_and_the_layer_of_the_picture() {
        let part = |name: &'static str, channels: &[&'static str]| (name, "", channels.to_vec());
        let layers = Layer::all(
            [
                part("rgba_left", &["B", "G", "R"]),
                part("depth_left", &["Z"]),
                part("rgba_right", &["B", "G", "R"]),
                part("depth_right", &["Z"]),
            ]
            .into_iter(),
        );
        assert_eq!(layers.iter().map(|l| l.view.as_str()).collect::<Vec<_>>(), ["left", "left", "right", "right"]);
        assert!(layers[2].kinship(&layers[3]) > layers[2].kinship(&layers[1]));
        assert_eq!(layers[1].depth(), Some((2, vec![0])));
    }
}
