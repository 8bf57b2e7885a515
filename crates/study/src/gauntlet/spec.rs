//! A scene as plain data: flat quads before a sky, a lens, a frame.
//!
//! Small enough to be printed, to be read by a person, and to be made smaller where it shows
//! a fault.

use defocus::camera::Camera;
use defocus::lens::Lens;
use defocus::raytrace::{RayOptions, RayRender, RayScene};
use defocus::scene::rgbd::RgbdScene;
use defocus::scene::{Environment, Instance, MadeFor, Material, Mesh, NamedCamera, Scene, Vertex};
use glam::{DAffine3, DVec3, UVec2, Vec2, Vec3, Vec4, dvec3, vec2};
use std::path::Path;
use std::sync::Arc;

/// Least depth of a corner over the focus distance: the camera's near plane is at half of it.
pub const LEAST_DEPTH_PER_FOCUS: f64 = 0.01;

/// Most cells of a pattern on one side of a quad.
pub const MOST_CELLS: u32 = 256;

/// What a quad shows.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Pattern {
    /// Its radiance everywhere.
    Plain,
    /// Cells of its radiance and another, in turns along both sides: sharp edges.
    Checker {
        /// Cells along the first side (corner 0 to 1) and the second (corner 0 to 3), 1 to
        /// [`MOST_CELLS`].
        cells: [u32; 2],
        /// Linear radiance of every other cell.
        other: [f32; 3],
    },
    /// From its radiance at the first side (corners 0 and 1) to another at the opposite one.
    Gradient {
        /// Linear radiance at the opposite side.
        other: [f32; 3],
    },
}

/// A flat quadrilateral that shines by itself, seen from both sides.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct QuadSpec {
    /// Corners in turn, metres: to the right of the axis, above it, and the depth along it.
    pub corners_m: [[f64; 3]; 4],
    /// Linear radiance, 1 is white.
    pub radiance: [f32; 3],
    /// What it shows.
    pub pattern: Pattern,
    /// Whether it counts as a light, whose energy is to be kept.
    pub light: bool,
}

/// A scene with the lens and the frame that it is looked at with.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SceneSpec {
    /// What it is called; [`super::named`] makes those of the generator by their names.
    pub name: String,
    /// Size of the frame, px.
    pub size_px: [u32; 2],
    /// Margin drawn around the frame, px.
    pub overscan_px: u32,
    /// Full vertical field of view, degrees.
    pub fov_y_deg: f64,
    /// Focus distance, metres.
    pub focus_m: f64,
    /// K: CoC diameter at infinity, px of this frame.
    pub k_px: f64,
    /// Linear radiance where no quad is, infinitely far.
    pub sky: [f32; 3],
    /// Whether methods are given an image with depth only, which ends at the frame.
    pub as_image: bool,
    /// What there is to see.
    pub quads: Vec<QuadSpec>,
}

/// What a scene that was read from a file has wrong.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecError {
    /// A file that cannot be read.
    #[error("cannot read it: {0}")]
    Read(String),
    /// Text that is no scene.
    #[error("it is no scene of `defocus gauntlet`: {0}")]
    Syntax(String),
    /// A value out of its range.
    #[error("{what} is {value}: give {range}")]
    OutOfRange {
        /// Which value.
        what: String,
        /// The value.
        value: String,
        /// The range, in words.
        range: &'static str,
    },
}

impl QuadSpec {
    /// Signed CoC diameters of its corners, px.
    pub fn coc_px(&self, lens: &Lens) -> [f64; 4] {
        self.corners_m.map(|corner| lens.coc().at_depth(corner[2]))
    }

    fn mesh(&self) -> Mesh {
        let corners = self.corners_m.map(|[x, y, depth]| dvec3(x, y, -depth));
        let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or(DVec3::Z).as_vec3();
        let vertex = |at: Vec2, color: Vec3| {
            let across = |from: DVec3, to: DVec3, t: f32| from + (to - from) * f64::from(t);
            let position = across(across(corners[0], corners[1], at.x), across(corners[3], corners[2], at.x), at.y);
            let (position, tangent) = (position.as_vec3(), Vec4::new(1.0, 0.0, 0.0, 1.0));
            Vertex { position, normal, tangent, uv: at, uv1: at, color: color.extend(1.0) }
        };
        let own = Vec3::from_array(self.radiance);
        let (cells, other) = match &self.pattern {
            Pattern::Plain => ([1, 1], own),
            Pattern::Checker { cells, other } => (*cells, Vec3::from_array(*other)),
            Pattern::Gradient { other } => ([1, 1], Vec3::from_array(*other)),
        };
        let steps = vec2(cells[0] as f32, cells[1] as f32);
        let mut mesh = Mesh { name: "quad".into(), ..Mesh::default() };
        for (x, y) in (0..cells[1]).flat_map(|y| (0..cells[0]).map(move |x| (x, y))) {
            let colors = match &self.pattern {
                Pattern::Plain => [own; 2],
                Pattern::Checker { .. } => [if (x + y).is_multiple_of(2) { own } else { other }; 2],
                Pattern::Gradient { .. } => [own, other],
            };
            let first = mesh.vertices.len() as u32;
            let corner = |dx: u32, dy: u32| vertex(vec2((x + dx) as f32, (y + dy) as f32) / steps, colors[dy as usize]);
            mesh.vertices.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
        mesh
    }
}

impl SceneSpec {
    /// The size of the frame, px.
    pub fn size(&self) -> UVec2 {
        UVec2::from_array(self.size_px)
    }

    /// The lens: a disc, with the E that gives K.
    pub fn lens(&self) -> Lens {
        let unit = Lens { aperture_diameter_mm: 1.0, focus_distance_m: self.focus_m, ..Lens::PINHOLE };
        Lens { aperture_diameter_mm: self.k_px / unit.k_px(), ..unit }
    }

    /// The camera: at the origin, along -z.
    pub fn camera(&self) -> Camera {
        let near_m = 0.5 * LEAST_DEPTH_PER_FOCUS * self.focus_m;
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, self.fov_y_deg.to_radians(), near_m);
        Camera { aspect: Some(f64::from(self.size_px[0]) / f64::from(self.size_px[1])), ..camera }
    }

    /// The quads and the sky as a scene, with the lens that it is made for.
    pub fn scene(&self) -> Scene {
        let material = Material { name: "light".into(), unlit: true, double_sided: true, ..Material::default() };
        let meshes: Vec<_> = self.quads.iter().map(QuadSpec::mesh).collect();
        let sky = Vec3::from_array(self.sky);
        Scene {
            name: self.name.clone(),
            instances: (0..meshes.len()).map(|mesh| Instance { mesh, world_from_object: DAffine3::IDENTITY }).collect(),
            meshes,
            materials: vec![material],
            environment: Environment::Studio { zenith: sky, horizon: sky, ground: sky, softbox: 0.0 },
            cameras: vec![NamedCamera { name: "gauntlet".into(), camera: self.camera() }],
            focus_hint_m: Some(self.focus_m),
            made_for: Some(self.made_for()),
            ..Scene::default()
        }
    }

    fn made_for(&self) -> MadeFor {
        MadeFor { lens: self.lens(), size: self.size(), overscan_px: self.overscan_px }
    }

    /// The pinhole image with its depth, traced on the CPU.
    pub fn image(&self) -> RgbdScene {
        let projection = self.camera().projection(self.size(), 0);
        let scene = Arc::new(Scene { made_for: None, ..self.scene() });
        let options = RayOptions { lens_points: 0..0, ..RayOptions::default() };
        let traced = RayScene::new(scene, &self.camera())
            .and_then(|rays| RayRender::new(Arc::new(rays), &projection, &Lens::PINHOLE, &options))
            .expect("a pinhole and a checked camera")
            .image();
        RgbdScene {
            name: self.name.clone(),
            color: traced.pinhole,
            depth: traced.depth,
            fov_y: self.fov_y_deg.to_radians(),
            unknown_share: 0.0,
            nonfinite_pixels: 0,
            notes: Vec::new(),
            made_for: Some(self.made_for()),
        }
    }

    /// Whether anything counts as a light.
    pub fn has_lights(&self) -> bool {
        self.quads.iter().any(|quad| quad.light)
    }

    /// The same without its lights.
    pub fn without_lights(&self) -> Self {
        Self { quads: self.quads.iter().filter(|quad| !quad.light).cloned().collect(), ..self.clone() }
    }

    /// As text that [`SceneSpec::from_text`] reads.
    pub fn to_text(&self) -> String {
        let pretty = ron::ser::PrettyConfig::new().depth_limit(3).compact_arrays(true);
        ron::ser::to_string_pretty(self, pretty).unwrap_or_default() + "\n"
    }

    /// Reads what [`SceneSpec::to_text`] wrote.
    ///
    /// # Errors
    ///
    /// Text that is no scene, and values out of their ranges.
    pub fn from_text(text: &str) -> Result<Self, SpecError> {
        let spec: Self = ron::from_str(text).map_err(|e| SpecError::Syntax(e.to_string()))?;
        spec.check()?;
        Ok(spec)
    }

    /// Reads a file that holds what [`SceneSpec::to_text`] wrote.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, and those of [`SceneSpec::from_text`].
    pub fn read(path: &Path) -> Result<Self, SpecError> {
        let text = std::fs::read_to_string(path).map_err(|e| SpecError::Read(e.to_string()))?;
        Self::from_text(&text)
    }

    /// # Errors
    ///
    /// A value out of its range.
    pub fn check(&self) -> Result<(), SpecError> {
        let ensure = |good: bool, what: &str, value: String, range: &'static str| {
            if good { Ok(()) } else { Err(SpecError::OutOfRange { what: what.into(), value, range }) }
        };
        let [width, height] = self.size_px;
        let drawable = 1..=8192;
        ensure(
            drawable.contains(&width) && drawable.contains(&height),
            "size_px",
            format!("{width}x{height}"),
            "1 to 8192 px on both sides",
        )?;
        ensure(self.overscan_px <= 1024, "overscan_px", self.overscan_px.to_string(), "at most 1024")?;
        ensure((1.0..=170.0).contains(&self.fov_y_deg), "fov_y_deg", self.fov_y_deg.to_string(), "1 to 170 degrees")?;
        // A focus nearer than the focal length forms no image.
        ensure((0.1..=1e6).contains(&self.focus_m), "focus_m", self.focus_m.to_string(), "0.1 to 1000000 m")?;
        ensure((0.0..=1e5).contains(&self.k_px), "k_px", self.k_px.to_string(), "0 to 100000 px")?;
        ensure(shines(&self.sky), "sky", format!("{:?}", self.sky), "radiances of 0 to 65504")?;
        for (i, quad) in self.quads.iter().enumerate() {
            let least_m = LEAST_DEPTH_PER_FOCUS * self.focus_m;
            let good = |c: &[f64; 3]| c.iter().all(|v| v.abs() <= 1e6) && c[2] >= least_m;
            ensure(
                quad.corners_m.iter().all(good),
                &format!("a corner of quad {i}"),
                format!("{:?}", quad.corners_m),
                "metres up to a million, with a depth of at least a hundredth of the focus distance",
            )?;
            let (radiances, cells) = match &quad.pattern {
                Pattern::Plain => ([quad.radiance; 2], [1, 1]),
                Pattern::Checker { cells, other } => ([quad.radiance, *other], *cells),
                Pattern::Gradient { other } => ([quad.radiance, *other], [1, 1]),
            };
            ensure(
                radiances.iter().all(shines),
                &format!("the radiance of quad {i}"),
                format!("{radiances:?}"),
                "0 to 65504",
            )?;
            ensure(
                cells.iter().all(|n| (1..=MOST_CELLS).contains(n)),
                &format!("the number of cells of quad {i}"),
                format!("{cells:?}"),
                "1 to 256",
            )?;
        }
        Ok(())
    }
}

fn shines(radiance: &[f32; 3]) -> bool {
    radiance.iter().all(|v| (0.0..=65504.0).contains(v))
}
