//! The built-in scenes, made from nothing but this code.

pub mod bake;
mod canvas;
pub mod glb;
pub mod nature;
mod noise;
pub mod patterns;
mod scenes;
pub mod shape;
pub mod stage;

/// Names of the scenes that are files of the repository. "forest" is not: only a picture of
/// it is.
pub const NAMES: [&str; 9] =
    ["cans", "atrium", "branches", "highlights", "herd", "mirrors", "handrail", "fence", "glasshouse"];

/// The scene called `name`, its vertex colours still white; `None` if there is none.
pub fn unlit(name: &str) -> Option<stage::Stage> {
    Some(match name {
        "cans" => scenes::cans::stage(),
        "branches" => scenes::branches::stage(),
        "highlights" => scenes::highlights::stage(),
        "herd" => scenes::herd::stage(),
        "mirrors" => scenes::mirrors::stage(),
        "handrail" => scenes::handrail::stage(),
        "fence" => scenes::fence::stage(),
        "glasshouse" => scenes::glasshouse::stage(),
        "atrium" => scenes::atrium::stage(),
        "forest" => scenes::forest::stage(),
        _ => return None,
    })
}
