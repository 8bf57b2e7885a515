//! Which blended materials let anything shine through.

use super::super::{Material, Mesh, Scene};
use super::notes::Notes;

/// Makes materials opaque whose file calls them blended while their alpha is 1 everywhere, as many
/// exporters do, and notes what is approximated for the others.
pub(super) fn settle(scene: &mut Scene, notes: &mut Notes) {
    let Scene { meshes, materials, textures, .. } = scene;
    for (index, material) in materials.iter_mut().enumerate().filter(|(_, material)| material.blended) {
        let texture = material.base_color_texture.map(|slot| &textures[slot.texture]);
        let texture_covers = texture.is_none_or(|texture| texture.rgba8.iter().all(|texel| texel[3] == u8::MAX));
        if texture_covers && material.base_color.w >= 1.0 && vertices_cover(meshes, index) {
            material.blended = false;
        }
    }
    for material in materials.iter().filter(|material| Material::is_sheet(material)) {
        notes.add(
            "what blended and transmissive materials cover is mixed with what lies behind them, and methods that know one surface a pixel give both the depth of the nearest that covers half or more",
            &material.name,
        );
    }
}

fn vertices_cover(meshes: &[Mesh], material: usize) -> bool {
    let of_material = meshes.iter().filter(|mesh| mesh.material == material);
    of_material.flat_map(|mesh| &mesh.vertices).all(|vertex| vertex.color.w >= 1.0)
}
