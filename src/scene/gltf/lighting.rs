//! Which light a file is shown in.

use super::super::error::SceneProblem;
use super::super::{Environment, Light, LightKind, Scene};
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

/// Chooses the light of a scene, and says so in the notes. The first rule that fits:
///
/// 1. A file with punctual lights is lit by them alone.
/// 2. If every material is unlit, nothing is added: the base colours are the radiance.
/// 3. If a material emits more than radiance 1 (factor times strength, any channel), the
///    emissive surfaces are the file's own light, and nothing is added.
/// 4. Otherwise the default light: one directional light over the left shoulder of the
///    first camera's viewer, and a neutral studio.
pub(super) fn light(scene: &mut Scene, file_lights: Vec<Light>, notes: &mut Notes) {
    let luminous = |emissive: Vec3| emissive.max_element() > LUMINOUS;
    scene.environment = Environment::Black;
    let sentence = if !file_lights.is_empty() {
        scene.lights = file_lights;
        "light: the file's own punctual lights alone"
    } else if scene.materials.iter().all(|material| material.unlit) {
        "light: none, every material is unlit"
    } else if scene.materials.iter().any(|material| luminous(material.emissive)) {
        "light: the file's emissive surfaces alone"
    } else {
        scene.lights = vec![default_light(scene)];
        scene.environment = DEFAULT_ENVIRONMENT;
        "light: the file has none; a directional light and a neutral studio are added"
    };
    notes.add(sentence, "");
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
struct AuthorHints {
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

/// Lets `extras.defocus` of the glTF scene override environment and focus distance:
/// `{"defocus": {"environment": {"zenith": [r,g,b], "horizon": .., "ground": ..,
/// "softbox": x}, "focus_m": 1.2}}`, all of it optional.
pub(super) fn apply_author_hints(
    scene: &mut Scene,
    document: &Document,
    exact: &Exact,
    notes: &mut Notes,
) -> Result<(), SceneProblem> {
    let index = document.default_scene().map_or(0, |scene| scene.index());
    let extras = exact.scenes.get(index).and_then(|scene| scene.extras.as_ref());
    let Some(hints) = extras.and_then(|extras| extras.get("defocus")) else { return Ok(()) };
    let item = format!("scenes[{index}].extras.defocus");
    let hints = AuthorHints::deserialize(hints)
        .map_err(|e| SceneProblem::invalid(&item, format!("is not understood ({e})")))?;
    if let Some(AuthorEnvironment { zenith, horizon, ground, softbox }) = hints.environment {
        let radiances =
            [zenith, horizon, ground].as_flattened().iter().chain([&softbox]).all(|x| x.is_finite() && *x >= 0.0);
        if !radiances {
            return Err(SceneProblem::invalid(
                format!("{item}.environment"),
                "has a radiance that is negative or too large",
            ));
        }
        let (zenith, horizon, ground) = (zenith.into(), horizon.into(), ground.into());
        scene.environment = Environment::Studio { zenith, horizon, ground, softbox };
        notes.add("environment: the one that the file's author gives", "");
    }
    if let Some(focus_m) = hints.focus_m {
        if !(focus_m > 0.0 && focus_m.is_finite()) {
            return Err(SceneProblem::invalid(
                format!("{item}.focus_m"),
                format!("is {focus_m}, not a positive distance"),
            ));
        }
        scene.focus_hint_m = Some(focus_m);
    }
    Ok(())
}
