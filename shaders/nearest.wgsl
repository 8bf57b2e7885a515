// The nearest surface around each pixel (src/view/nearest.rs): where a ray is in front of it, it meets
// nothing there.

struct Spread {
    /// Outer frame, px.
    size: vec2u,
    /// Samples a pixel on each side.
    samples_a_side: u32,
    /// Pixels of the finer level that are asked on each side of a pixel, and their distance.
    taps: u32,
    spacing: u32,
}

/// Most samples a pixel, and taps on each side of a pixel.
const MOST_A_SIDE = 12u;
const MOST_TAPS = 3u;

@group(0) @binding(0) var<uniform> spread: Spread;
/// Stored depth: of the samples, and of pixels.
@group(0) @binding(1) var depth: texture_2d<f32>;
@group(0) @binding(2) var nearest: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn nearest_in_pixels(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= spread.size) {
        return;
    }
    let side = min(spread.samples_a_side, MOST_A_SIDE);
    var z = 0.0;
    for (var y = 0u; y < side; y++) {
        for (var x = 0u; x < side; x++) {
            z = max(z, textureLoad(depth, side * id.xy + vec2u(x, y), 0).r);
        }
    }
    textureStore(nearest, id.xy, vec4f(z));
}

@compute @workgroup_size(8, 8)
fn nearest_around_pixels(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= spread.size) {
        return;
    }
    let taps = min(spread.taps, MOST_TAPS);
    let side = 2u * taps + 1u;
    var z = 0.0;
    for (var i = 0u; i < side * side; i++) {
        let offset = vec2i(vec2u(i % side, i / side)) - i32(taps);
        let at = vec2i(id.xy) + i32(spread.spacing) * offset;
        z = max(z, textureLoad(depth, clamp(at, vec2i(0), vec2i(spread.size) - 1), 0).r);
    }
    textureStore(nearest, id.xy, vec4f(z));
}
