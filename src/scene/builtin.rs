//! The scenes that come with the program. `examples/make_scenes` makes their files.

use super::{Scene, SceneError, gltf};

/// A scene inside the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// What it is called on the command line and in lists.
    pub name: &'static str,
    /// What there is to see, in one sentence.
    pub about: &'static str,
    /// The binary glTF file.
    pub glb: &'static [u8],
}

impl Builtin {
    /// Reads the scene.
    ///
    /// # Errors
    ///
    /// Those of [`gltf::load_bytes`]; none for the files as they are committed.
    pub fn load(&self) -> Result<Scene, SceneError> {
        gltf::load_bytes(self.name, self.glb)
    }
}

/// Every built-in scene, in the order in which lists show them.
pub fn all() -> &'static [Builtin] {
    &ALL
}

/// The built-in scene called `name`.
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    ALL.iter().find(|scene| scene.name == name)
}

const ALL: [Builtin; 7] = [
    Builtin {
        name: "cans",
        about: "Labelled cans on a counter before a brick wall: focus near, blur behind.",
        glb: include_bytes!("../../assets/scenes/cans.glb"),
    },
    Builtin {
        name: "atrium",
        about: "A two-storey colonnade of over a million triangles: focus far, a column blurred right before the lens.",
        glb: include_bytes!("../../assets/scenes/atrium.glb"),
    },
    Builtin {
        name: "branches",
        about: "Two thin branches that cross, one on each side of the focus, before leaves and a wall.",
        glb: include_bytes!("../../assets/scenes/branches.glb"),
    },
    Builtin {
        name: "highlights",
        about: "A wet street at night: small lights a hundred times brighter than white, at all depths.",
        glb: include_bytes!("../../assets/scenes/highlights.glb"),
    },
    Builtin {
        name: "herd",
        about: "Elephants at many depths on dry ground.",
        glb: include_bytes!("../../assets/scenes/herd.glb"),
    },
    Builtin {
        name: "mirrors",
        about: "Polished metal at many depths: reflections that change with the point of the lens.",
        glb: include_bytes!("../../assets/scenes/mirrors.glb"),
    },
    Builtin {
        name: "handrail",
        about: "One rail and its balusters through all depths from half a metre to fifteen.",
        glb: include_bytes!("../../assets/scenes/handrail.glb"),
    },
];
