//! Which light a file is shown in.

use super::super::error::SceneProblem;
use super::super::{Environment, Light, LightKind, Material, Scene};
use super::exact::Exact;
use super::notes::Notes;
use ::gltf::Document;
use glam::{DVec3, Vec3};
use serde::Deserialize;

/// Illuminance of the default light, lux in the scene's own scale: a white diffuse surface
/// that faces it has the radiance 2.5 / pi = 0.8, just below display white.
const DEFAULT_LIGHT: f32 = 2.5;

/// The default surroundings: soft, nearly neutral, cooler from above than from below.
const DEFAULT_ENVIRONMENT: Environment = Environment::Studio {
    zenith: Vec3::new(0.52, 0.56, 0.62),
    horizon: Vec3::new(0.40, 0.41, 0.43),
    ground: Vec3::new(0.17, 0.16, 0.15),
    softbox: 2.0,
};

/// Radiance above which a surface counts as a light rather than as a label or a screen.
const LUMINOUS: f32 = 1.0;

/// Share of the surfaces' area that must be luminous for a file to count as lit by itself.
/// Emission lights nothing else here: all other surfaces of such a file are black, so at
/// least half of what there is must show itself.
const LIT_SHARE: f64 = 0.5;

/// Which light a scene is shown in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// The file's own, with the default light added where it has hardly any.
    #[default]
    Auto,
    /// The file's own alone.
    File,
    /// The default light beside the file's own.
    Studio,
}

/// Changes the light of a loaded scene, and notes it. [`Lighting::Auto`] leaves it as it
/// was loaded.
pub fn relight(scene: &mut Scene, lighting: Lighting) {
    let added = default_light(scene);
    let is_added = scene.lights.contains(&added);
    match lighting {
        Lighting::Auto => {}
        Lighting::File => {
            scene.lights.retain(|light| *light != added);
            if scene.environment == DEFAULT_ENVIRONMENT {
                scene.environment = Environment::Black;
            }
            scene.notes.push("light: the file's own alone, as asked for".to_owned());
        }
        Lighting::Studio => {
            scene.lights.extend((!is_added).then_some(added));
            if scene.environment == Environment::Black {
                scene.environment = DEFAULT_ENVIRONMENT;
            }
            scene.notes.push("light: a directional light and a neutral studio are added, as asked for".to_owned());
        }
    }
}

/// Chooses the light of a scene, and says so in the notes. The first rule that fits:
///
/// 1. A file with punctual lights is lit by them alone.
/// 2. If every material is unlit, nothing is added: the base colours are the radiance.
/// 3. If materials that emit more than radiance 1 (factor times strength, any channel) cover
///    at least half of all surfaces, or the author says how to show the file, the emissive
///    surfaces are the file's own light, and nothing is added.
/// 4. Otherwise the default light: one directional light over the left shoulder of the
///    first camera's viewer, and a neutral studio.
pub(super) fn light(scene: &mut Scene, file_lights: Vec<Light>, has_hints: bool, notes: &mut Notes) {
    let luminous = |material: &Material| material.emissive.max_element() > LUMINOUS;
    scene.environment = Environment::Black;
    let is_luminous = scene.materials.iter().any(luminous);
    let sentence = if !file_lights.is_empty() {
        scene.lights = file_lights;
        "light: the file's own punctual lights alone".to_owned()
    } else if scene.materials.iter().all(|material| material.unlit) {
        "light: none, every material is unlit".to_owned()
    } else if is_luminous && (has_hints || area_share(scene, luminous) >= LIT_SHARE) {
        "light: the file's emissive surfaces alone".to_owned()
    } else {
        let own = if is_luminous { "emissive surfaces of the file light nothing else" } else { "the file has none" };
        scene.lights = vec![default_light(scene)];
        scene.environment = DEFAULT_ENVIRONMENT;
        format!("light: {own}; a directional light and a neutral studio are added")
    };
    notes.add(sentence, "");
}

/// Share of the area of all instances whose material is one of these.
fn area_share(scene: &Scene, is_one: impl Fn(&Material) -> bool) -> f64 {
    let (mut ones, mut all) = (0.0, 0.0);
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let corner =
            |i: u32| instance.world_from_object.transform_point3(mesh.vertices[i as usize].position.as_dvec3());
        let triangles = mesh.indices.as_chunks::<3>().0.iter().map(|t| t.map(corner));
        let area: f64 = triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        all += area;
        ones += if is_one(&scene.materials[mesh.material]) { area } else { 0.0 };
    }
    if all > 0.0 { ones / all } else { 0.0 }
}

fn default_light(scene: &Scene) -> Light {
    // View space: from the upper left behind the viewer, to the lower right and away.
    let direction_view = DVec3::new(0.5, -0.7, -1.0).normalize();
    let world_from_view = scene.cameras.first().map(|named| named.camera.orientation).unwrap_or_default();
    let kind = LightKind::Directional { direction: (world_from_view * direction_view).normalize() };
    Light { intensity: Vec3::splat(DEFAULT_LIGHT), kind }
}

/// `extras.defocus` of a glTF scene: what its author says about showing it here.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AuthorHints {
    environment: Option<AuthorEnvironment>,
    focus_m: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AuthorEnvironment {
    zenith: [f32; 3],
    horizon: [f32; 3],
    ground: [f32; 3],
    #[serde(default)]
    softbox: f32,
}

/// `extras.defocus` of the glTF scene: `{"defocus": {"environment": {"zenith": [r,g,b],
/// "horizon": .., "ground": .., "softbox": x}, "focus_m": 1.2}}`, all of it optional.
pub(super) fn author_hints(document: &Document, exact: &Exact) -> Result<Option<AuthorHints>, SceneProblem> {
    let index = document.default_scene().map_or(0, |scene| scene.index());
    let extras = exact.scenes.get(index).and_then(|scene| scene.extras.as_ref());
    let Some(hints) = extras.and_then(|extras| extras.get("defocus")) else { return Ok(None) };
    let item = format!("scenes[{index}].extras.defocus");
    let hints = AuthorHints::deserialize(hints)
        .map_err(|e| SceneProblem::invalid(&item, format!("is not understood ({e})")))?;
    if let Some(AuthorEnvironment { zenith, horizon, ground, softbox }) = &hints.environment {
        let colors = [*zenith, *horizon, *ground];
        let radiances = colors.as_flattened().iter().chain([softbox]).all(|x| x.is_finite() && *x >= 0.0);
        if !radiances {
            return Err(SceneProblem::invalid(
                format!("{item}.environment"),
                "has a radiance that is negative or too large",
            ));
        }
    }
    if let Some(focus_m) = hints.focus_m
        && !(focus_m > 0.0 && focus_m.is_finite())
    {
        return Err(SceneProblem::invalid(format!("{item}.focus_m"), format!("is {focus_m}, not a positive distance")));
    }
    Ok(Some(hints))
}

/// Lets the author override environment and focus distance.
pub(super) fn apply(hints: Option<AuthorHints>, scene: &mut Scene, notes: &mut Notes) {
    let Some(hints) = hints else { return };
    if let Some(AuthorEnvironment { zenith, horizon, ground, softbox }) = hints.environment {
        let (zenith, horizon, ground) = (zenith.into(), horizon.into(), ground.into());
        scene.environment = Environment::Studio { zenith, horizon, ground, softbox };
        notes.add("environment: the one that the file's author gives", "");
    }
    scene.focus_hint_m = hints.focus_m.or(scene.focus_hint_m);
}
