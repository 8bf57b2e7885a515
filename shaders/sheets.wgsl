// Sheets that were peeled one behind another (src/view/sheets.rs): merged to few layers for lens
// rays, or laid over the solid surfaces as the pinhole sees them.

struct Merge {
    /// Layers that were peeled.
    peels: u32,
    /// Stored depth by which a sheet lies behind another's layer at least to begin one of its own.
    separation_z: f32,
}

/// `MAX_SHEETS` in src/view/sheets.rs.
const MOST_PEELS = 8u;
/// `SHEET_LAYERS` there.
const LAYERS = 4u;

@group(0) @binding(0) var<uniform> merging: Merge;
/// Radiance and coverage, nearest sheet first.
@group(0) @binding(1) var peeled_color: texture_2d_array<f32>;
@group(0) @binding(2) var peeled_depth: texture_2d_array<f32>;
@group(0) @binding(3) var new_color: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(4) var new_depths: texture_storage_2d<rgba32float, write>;
@group(0) @binding(5) var solid_color: texture_2d<f32>;
@group(0) @binding(6) var solid_depth: texture_2d<f32>;
@group(0) @binding(7) var seen_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var seen_depth: texture_storage_2d<r32float, write>;

/// What is seen in front, premultiplied, over one more sheet.
fn over(front: vec4f, sheet: vec4f) -> vec4f {
    return front + (1.0 - front.a) * vec4f(sheet.rgb * sheet.a, sheet.a);
}

@compute @workgroup_size(8, 8)
fn merge_sheets(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(new_depths)) {
        return;
    }
    var layers: array<vec4f, LAYERS>;
    var depths = vec4f(-1.0);
    var count = 0u;
    for (var i = 0u; i < min(merging.peels, MOST_PEELS); i++) {
        let sheet = textureLoad(peeled_color, id.xy, i, 0);
        let z = textureLoad(peeled_depth, id.xy, i, 0).r;
        if sheet.a <= 0.0 {
            break;
        }
        let is_apart = count == 0u || z < depths[max(count, 1u) - 1u] - merging.separation_z;
        if is_apart && count < LAYERS {
            depths[count] = z;
            count += 1u;
        }
        layers[count - 1u] = over(layers[count - 1u], sheet);
    }
    for (var k = 0u; k < LAYERS; k++) {
        textureStore(new_color, id.xy, k, layers[k]);
    }
    textureStore(new_depths, id.xy, depths);
}

@compute @workgroup_size(8, 8)
fn lay_over(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(seen_color)) {
        return;
    }
    let solid_z = textureLoad(solid_depth, id.xy, 0).r;
    var seen = vec4f(0.0);
    var z = -1.0;
    for (var i = 0u; i < min(merging.peels, MOST_PEELS); i++) {
        let sheet = textureLoad(peeled_color, id.xy, i, 0);
        let sheet_z = textureLoad(peeled_depth, id.xy, i, 0).r;
        if sheet.a <= 0.0 || sheet_z <= solid_z {
            break;
        }
        seen = over(seen, sheet);
        z = select(z, sheet_z, z < 0.0 && sheet.a >= 0.5);
    }
    let solid = textureLoad(solid_color, id.xy, 0);
    textureStore(seen_color, id.xy, vec4f(seen.rgb + (1.0 - seen.a) * solid.rgb, solid.a));
    textureStore(seen_depth, id.xy, vec4f(select(z, solid_z, z < 0.0)));
}
