//! The scenes that come with the program. `crates/study/examples/make_scenes` makes their files.

use defocus::image::Image;
use defocus::image_io::srgb::linear_from_srgb8_table;
use defocus::scene::rgbd::RgbdScene;
use defocus::scene::{Scene, SceneError, gltf};
use glam::{UVec2, Vec3};

/// A scene inside the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// What it is called on the command line and in lists.
    pub name: &'static str,
    /// What there is to see, in one sentence.
    pub about: &'static str,
    /// The binary glTF file, deflated by `build.rs`: it takes half the room.
    deflated_glb: &'static [u8],
}

impl Builtin {
    /// Reads the scene.
    ///
    /// # Errors
    ///
    /// Those of [`gltf::load_bytes`]; none for the files as they are committed.
    pub fn load(&self) -> Result<Scene, SceneError> {
        gltf::load_bytes(self.name, &self.glb())
    }

    /// The binary glTF file.
    pub fn glb(&self) -> Vec<u8> {
        miniz_oxide::inflate::decompress_to_vec(self.deflated_glb).expect("the build deflated it")
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

// Static and not constant: a constant is a copy, scenes and all, in every crate and place
// that names it.
static ALL: [Builtin; 9] = [
    Builtin {
        name: "cans",
        about: "Labelled cans on a counter before a brick wall: focus near, blur behind.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/cans.glb.deflated")),
    },
    Builtin {
        name: "atrium",
        about: "A two-storey colonnade of over a million triangles: focus far, a column blurred right before the lens.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/atrium.glb.deflated")),
    },
    Builtin {
        name: "branches",
        about: "Two thin branches that cross, one on each side of the focus, before leaves and a wall.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/branches.glb.deflated")),
    },
    Builtin {
        name: "highlights",
        about: "A wet street at night: small lights a hundred times brighter than white, at all depths.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/highlights.glb.deflated")),
    },
    Builtin {
        name: "herd",
        about: "Elephants at many depths on dry ground.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/herd.glb.deflated")),
    },
    Builtin {
        name: "mirrors",
        about: "Polished metal at many depths: reflections that change with the point of the lens.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/mirrors.glb.deflated")),
    },
    Builtin {
        name: "handrail",
        about: "One rail and its balusters through all depths from half a metre to fifteen.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/handrail.glb.deflated")),
    },
    Builtin {
        name: "fence",
        about: "What is hard: a cut-out fence through the focus, wires a millimetre thick, lamps half behind a near post.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/fence.glb.deflated")),
    },
    Builtin {
        name: "glasshouse",
        about: "What is seen through: panes, bottles, smoke and leaves with soft edges, before and behind the focus.",
        deflated_glb: include_bytes!(concat!(env!("OUT_DIR"), "/glasshouse.glb.deflated")),
    },
];

/// A picture with depth inside the program: what the papers call an offline image.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinPicture {
    /// What it is called on the command line and in lists.
    pub name: &'static str,
    /// What there is to see, in one sentence.
    pub about: &'static str,
    /// 8-bit sRGB.
    color_png: &'static [u8],
    /// 16-bit disparity v: `1/d = (v / 65535) / near_m`, 0 being infinitely far.
    disparity_png: &'static [u8],
    near_m: f32,
    fov_y_deg: f64,
}

/// Every built-in picture.
pub fn pictures() -> &'static [BuiltinPicture] {
    &PICTURES
}

static PICTURES: [BuiltinPicture; 1] = [BuiltinPicture {
    name: "forest",
    about: "A wood of 4.6 million triangles as a picture with a depth map: no scene behind it.",
    color_png: include_bytes!("../../../assets/images/forest.png"),
    disparity_png: include_bytes!("../../../assets/images/forest_depth.png"),
    near_m: 0.8,
    fov_y_deg: 42.0,
}];

impl BuiltinPicture {
    /// Decodes the picture.
    pub fn load(&self) -> RgbdScene {
        let decode = |png| image::load_from_memory(png).expect("the embedded pictures are decoded by a test");
        let (color, disparity) = (decode(self.color_png).to_rgb8(), decode(self.disparity_png).to_luma16());
        let size = UVec2::new(color.width(), color.height());
        let linear = linear_from_srgb8_table();
        let pixels = color.pixels().map(|p| Vec3::from_array(p.0.map(|v| linear[usize::from(v)]))).collect();
        let depths = disparity.pixels().map(|v| self.near_m * 65535.0 / f32::from(v.0[0])).collect();
        RgbdScene {
            name: self.name.into(),
            color: Image { size, pixels },
            depth: Image { size, pixels: depths },
            fov_y: self.fov_y_deg.to_radians(),
            unknown_share: 0.0,
            nonfinite_pixels: 0,
            notes: Vec::new(),
            made_for: None,
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn pictures_decode_to_colours_with_depths() {
        for picture in super::pictures() {
            let loaded = picture.load();
            assert_eq!(loaded.color.size, loaded.depth.size);
            assert!(loaded.depth.pixels.iter().all(|d| *d >= picture.near_m), "{}", picture.name);
            assert!(loaded.depth.pixels.iter().any(|d| d.is_infinite()), "{}: no sky", picture.name);
        }
    }
}
