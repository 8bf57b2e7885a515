// Display values (sRGB-encoded, RGBA8) of two pictures made into one (src/combine.rs).
//
//   side_by_side   | first | second |
//   weighted       encode(rows[0..3] * decode(first) + rows[3..6] * decode(second))

struct Weights {
    rows: array<vec4f, 6>,
}

@group(0) @binding(0) var<uniform> weights: Weights;
@group(0) @binding(1) var first: texture_2d<f32>;
@group(0) @binding(2) var second: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba8unorm, write>;

/// sRGB decoding of values in [0, 1] (IEC 61966-2-1).
fn srgb_decode(encoded: vec3f) -> vec3f {
    let curve = pow((encoded + 0.055) / 1.055, vec3f(2.4));
    return select(curve, encoded / 12.92, encoded <= vec3f(0.04045));
}

/// sRGB encoding of linear values in [0, 1] (IEC 61966-2-1).
fn srgb_encode(linear: vec3f) -> vec3f {
    let curve = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear <= vec3f(0.0031308));
}

@compute @workgroup_size(8, 8)
fn side_by_side(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let width = textureDimensions(first).x;
    if id.x < width {
        textureStore(result, id.xy, textureLoad(first, id.xy, 0));
    } else {
        textureStore(result, id.xy, textureLoad(second, vec2u(id.x - width, id.y), 0));
    }
}

@compute @workgroup_size(8, 8)
fn weighted(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let a = srgb_decode(textureLoad(first, id.xy, 0).rgb);
    let b = srgb_decode(textureLoad(second, id.xy, 0).rgb);
    var sum = vec3f(0.0);
    for (var i = 0u; i < 3u; i++) {
        sum[i] = dot(weights.rows[i].xyz, a) + dot(weights.rows[i + 3u].xyz, b);
    }
    textureStore(result, id.xy, vec4f(srgb_encode(clamp(sum, vec3f(0.0), vec3f(1.0))), 1.0));
}
