//! Triangles from strips and fans, and the normals and tangents that a file leaves out.

use super::super::Vertex;
use ::gltf::mesh::Mode;
use glam::{Vec2, Vec3};

/// Whether a primitive mode is made of triangles.
pub(super) fn is_triangles(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// Three indices a triangle from the indices of a list, strip or fan, in the winding of
/// glTF 2.0 section 3.7.2.1. Triangles that use a vertex twice have no area and are dropped.
pub(super) fn triangle_list(mode: Mode, indices: &[u32]) -> Vec<u32> {
    let windows = 0..indices.len().saturating_sub(2);
    let triangles: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => windows.map(|i| [indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]]).collect(),
        Mode::TriangleFan => windows.map(|i| [indices[i + 1], indices[i + 2], indices[0]]).collect(),
        _ => indices.as_chunks::<3>().0.to_vec(),
    };
    let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    triangles.into_iter().filter(has_area).flatten().collect()
}

/// Gives every triangle vertices of its own with its geometric normal, as glTF asks for
/// where a primitive has no normals.
pub(super) fn flatten(vertices: &[Vertex], indices: &[u32]) -> (Vec<Vertex>, Vec<u32>) {
    let mut flat: Vec<Vertex> = indices.iter().map(|&i| vertices[i as usize]).collect();
    for triangle in flat.as_chunks_mut::<3>().0 {
        let normal = face_vector(triangle.each_ref().map(|v| v.position)).normalize_or(Vec3::Y);
        triangle.iter_mut().for_each(|v| v.normal = normal);
    }
    let indices = (0..flat.len() as u32).collect();
    (flat, indices)
}

/// Normal times twice the area, scaled so that neither tiny nor huge triangles leave the
/// range of f32.
fn face_vector([a, b, c]: [Vec3; 3]) -> Vec3 {
    let (e1, e2) = (b - a, c - a);
    let scale = e1.abs().max_element().max(e2.abs().max_element()).max(f32::MIN_POSITIVE);
    (e1 / scale).cross(e2 / scale)
}

/// Replaces normals that are not unit vectors: scales those that have a direction, takes
/// the mean of the adjacent faces for those that have none. Returns how many had none.
pub(super) fn repair_normals(vertices: &mut [Vertex], indices: &[u32]) -> usize {
    let mut directionless = 0;
    let mut sums: Option<Vec<Vec3>> = None;
    for i in 0..vertices.len() {
        if let Some(normal) = unit(vertices[i].normal) {
            vertices[i].normal = normal;
            continue;
        }
        directionless += 1;
        let sums = sums.get_or_insert_with(|| face_sums(vertices, indices));
        vertices[i].normal = unit(sums[i]).unwrap_or(Vec3::Y);
    }
    directionless
}

fn face_sums(vertices: &[Vertex], indices: &[u32]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; vertices.len()];
    for triangle in indices.as_chunks::<3>().0 {
        let face = face_vector(triangle.map(|i| vertices[i as usize].position)).normalize_or_zero();
        triangle.iter().for_each(|&i| sums[i as usize] += face);
    }
    sums
}

/// The direction of `v`; `None` for zero, NaN and infinity.
fn unit(v: Vec3) -> Option<Vec3> {
    let largest = v.abs().max_element();
    (v.is_finite() && largest > 0.0).then(|| (v / largest).normalize())
}

/// Replaces tangents that are not unit vectors with a sign: scales those that have a
/// direction, takes any perpendicular to the normal for those that have none. Returns how
/// many had none.
pub(super) fn repair_tangents(vertices: &mut [Vertex]) -> usize {
    let mut directionless = 0;
    for vertex in vertices {
        let direction = unit(vertex.tangent.truncate());
        directionless += usize::from(direction.is_none());
        let direction = direction.unwrap_or_else(|| vertex.normal.any_orthonormal_vector());
        vertex.tangent = direction.extend(if vertex.tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
    directionless
}

/// Tangents from texture coordinates, summed over the triangles at each vertex and made
/// perpendicular to its normal (Lengyel, "Computing Tangent Space Basis Vectors for an
/// Arbitrary Mesh", 2001).
///
/// Weights are not those of MikkTSpace, which glTF names as the reference: baked normal
/// maps of strongly curved low-polygon meshes can show faint seams. `uv` gives the
/// coordinates at which the normal map is looked up. The sign in w makes
/// `cross(normal, tangent) * w` point to the image's top, where v decreases.
pub(super) fn generate_tangents(vertices: &mut [Vertex], indices: &[u32], uv: impl Fn(&Vertex) -> Vec2) {
    let mut along_u = vec![Vec3::ZERO; vertices.len()];
    let mut along_v = vec![Vec3::ZERO; vertices.len()];
    for triangle in indices.as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(|i| &vertices[i as usize]);
        let (e1, e2) = (b.position - a.position, c.position - a.position);
        let (d1, d2) = (uv(b) - uv(a), uv(c) - uv(a));
        let orientation = if d1.perp_dot(d2) < 0.0 { -1.0 } else { 1.0 };
        // The sums need directions alone: dividing by the determinant would let slivers
        // in texture space outweigh everything else.
        let du = unit((e1 * d2.y - e2 * d1.y) * orientation).unwrap_or_default();
        let dv = unit((e2 * d1.x - e1 * d2.x) * orientation).unwrap_or_default();
        for &i in triangle {
            along_u[i as usize] += du;
            along_v[i as usize] += dv;
        }
    }
    for (vertex, (u, v)) in vertices.iter_mut().zip(along_u.into_iter().zip(along_v)) {
        let in_plane = u - vertex.normal * vertex.normal.dot(u);
        let tangent = unit(in_plane).unwrap_or_else(|| vertex.normal.any_orthonormal_vector());
        let upwards = -v;
        let sign = if vertex.normal.cross(tangent).dot(upwards) < 0.0 { -1.0 } else { 1.0 };
        vertex.tangent = tangent.extend(sign);
    }
}
