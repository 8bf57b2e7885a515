//! What can be wrong with a scene file, each with its cause and its remedy.

use std::path::PathBuf;

/// A scene file that cannot be used: which file, and why.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", file.display())]
pub struct SceneError {
    /// The file that was asked for.
    pub file: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: SceneProblem,
}

/// Why a scene file cannot be used. `item` names the part of the file: a path into its
/// JSON such as `accessors[3]`, with the author's name for it where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneProblem {
    /// The file itself, or one that it refers to, cannot be read.
    #[error("cannot read {what}: {source}; check that the file exists and may be read")]
    Unreadable {
        /// The file as the scene names it.
        what: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Neither a binary glTF nor JSON of one.
    #[error("not a glTF 2.0 file ({detail}); export the scene as .glb or .gltf, version 2.0")]
    NotGltf {
        /// What was found instead.
        detail: String,
    },
    /// A binary glTF whose chunks do not fit the file.
    #[error("damaged binary glTF ({detail}); copy or export the file again")]
    Container {
        /// Which length or chunk is wrong.
        detail: String,
    },
    /// JSON that breaks the glTF schema.
    #[error("{item} {detail}; export the scene again, or repair it with the help of a glTF validator")]
    Invalid {
        /// Path into the JSON.
        item: String,
        /// What is wrong there.
        detail: String,
    },
    /// `extensionsRequired` names something that cannot be read here.
    #[error("requires the glTF extension {name}, which is not supported; export the scene without it{hint}")]
    RequiredExtension {
        /// The extension's name.
        name: String,
        /// How to do that, if it is known.
        hint: &'static str,
    },
    /// A reference to data that cannot be followed.
    #[error("{item} refers to {uri:?}: {detail}")]
    Uri {
        /// The buffer or image.
        item: String,
        /// The reference, shortened.
        uri: String,
        /// Cause and remedy.
        detail: String,
    },
    /// Fewer bytes than the file itself declares.
    #[error(
        "{item} needs {needed} bytes but {holder} has {available}; the file is truncated or damaged, export it again"
    )]
    OutOfBytes {
        /// The buffer, buffer view or accessor.
        item: String,
        /// Where it should lie.
        holder: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes there are.
        available: u64,
    },
    /// A count or offset so large that it overflows or exceeds what is loaded.
    #[error("{item} has an absurd size ({detail}); the file is damaged, export it again")]
    Oversize {
        /// The accessor or buffer view.
        item: String,
        /// The number and the limit.
        detail: String,
    },
    /// A vertex index beyond the vertices, or a sparse index beyond its accessor.
    #[error("{item} has the index {index}, but there are only {count} {things}; export the scene again")]
    IndexOutOfRange {
        /// The primitive or accessor.
        item: String,
        /// The offending index.
        index: u64,
        /// How many there are.
        count: u64,
        /// Of what.
        things: &'static str,
    },
    /// NaN or infinity where there must be a number.
    #[error("{item} is not a finite number ({detail}); repair the model in its editor and export it again")]
    NotFinite {
        /// The attribute and vertex, or the node.
        item: String,
        /// The value.
        detail: String,
    },
    /// Nodes that are not a forest.
    #[error("{item} {detail}; the node hierarchy must be a tree, export the scene again")]
    Hierarchy {
        /// The node.
        item: String,
        /// Cycle, second parent or depth.
        detail: String,
    },
    /// An image that does not decode.
    #[error("{item} does not decode ({detail}); use a PNG, JPEG or WebP image")]
    Image {
        /// The image.
        item: String,
        /// The decoder's reason.
        detail: String,
    },
    /// An animation that was asked for and is not there.
    #[error("has no animation{}; {}", wanted.as_ref().map(|name| format!(" '{name}'")).unwrap_or_default(), if known.is_empty() { "leave out the time and the animation".to_owned() } else { format!("it has {known} (numbers from 0 are accepted too)") })]
    NoAnimation {
        /// The name that was given.
        wanted: Option<String>,
        /// The names there are.
        known: String,
    },
    /// Nothing to draw.
    #[error("has no triangles to draw ({detail}); export a scene with at least one triangle mesh")]
    NoGeometry {
        /// What there was instead.
        detail: String,
    },
}

impl SceneProblem {
    /// Shorthand for [`SceneProblem::Invalid`].
    pub(super) fn invalid(item: impl Into<String>, detail: impl Into<String>) -> Self {
        Self::Invalid { item: item.into(), detail: detail.into() }
    }
}
