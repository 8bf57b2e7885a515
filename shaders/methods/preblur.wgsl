// preblur: twelve taps that mix the image with a blurred copy (src/methods/preblur.rs).
//
// The copy is a quarter of each side, centred on the image, so that a mirrored image has
// the mirrored copy: where the side is no multiple of four, its texels lie at half pixels.

#import lens
#import color
#import sampling

struct Params {
    /// Depth of z = 1, metres.
    near: f32,
    /// Depth at which the ramp is 0, metres.
    focus: f32,
    /// Slope of the ramp before and behind the focus, px per metre.
    coc_per_depth: vec2f,
    /// Least and greatest CoC diameter of the ramp, px.
    coc_bounds: vec2f,
    /// Diameter of the disc of taps over the CoC.
    diameter_per_coc: f32,
    /// CoC diameter of full blurriness, px.
    full_coc: f32,
    /// Radius of the disc in the copy's texels over that in pixels.
    radius_scale: f32,
    /// 1: blurriness follows the ramp; 0: the lens.
    ramp: u32,
    leak_test: u32,
    /// Overscan, px.
    overscan: u32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var reduced_out: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(5) var reduced: texture_2d<f32>;
@group(0) @binding(6) var linear_clamp: sampler;
@group(0) @binding(7) var result: texture_storage_2d<COLOR_FORMAT, write>;

const STEP = 4.0;

/// Pixels by which the copy begins left of and above the image.
fn margin(image: vec2u, copy: vec2u) -> vec2f {
    return 0.5 * (STEP * vec2f(copy) - vec2f(image));
}

/// Mean over the 4x4 px of a texel, pixels that it cuts in half by half.
@compute @workgroup_size(8, 8)
fn reduce(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(color);
    let copy = textureDimensions(reduced_out);
    if any(id.xy >= copy) {
        return;
    }
    let centre = STEP * (vec2f(id.xy) + 0.5) - margin(size, copy);
    let first = vec2i(floor(centre - 0.5 * STEP));
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 0; i < 25; i++) {
        let p = first + vec2i(i % 5, i / 5);
        if any(p < vec2i(0)) || any(p >= vec2i(size)) {
            continue;
        }
        let covered = saturate(0.5 * STEP + 0.5 - abs(vec2f(p) + 0.5 - centre));
        let rgb = textureLoad(color, p, 0).rgb;
        if is_finite(rgb) {
            sum += covered.x * covered.y * rgb;
            weights += covered.x * covered.y;
        }
    }
    textureStore(reduced_out, id.xy, vec4f(select(vec3f(0.0), sum / weights, weights > 0.0), 1.0));
}

/// The 3x3 Gaussian 1 2 1.
@compute @workgroup_size(8, 8)
fn filter_reduced(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(reduced);
    if any(id.xy >= size) {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0; i < 9; i++) {
        let offset = vec2i(i % 3, i / 3) - 1;
        let weight = vec2f(2 - abs(offset)) * 0.25;
        sum += weight.x * weight.y * textureLoad(reduced, clamp_to_image(vec2i(id.xy) + offset, size), 0).rgb;
    }
    textureStore(reduced_out, id.xy, vec4f(sum, 1.0));
}

/// Signed CoC diameter, px, that blurriness follows.
fn coc_at(p: vec2i) -> f32 {
    let z = textureLoad(depth, p, 0).r;
    if !is_finite(vec3f(z)) {
        return 0.0;
    }
    if params.ramp == 0u {
        return coc_diameter_px(lens, z);
    }
    // z = 0 is infinity, where the ramp has its greatest value.
    let from_focus = params.near / max(z, 1e-30) - params.focus;
    let slope = select(params.coc_per_depth.y, params.coc_per_depth.x, from_focus < 0.0);
    return clamp(slope * from_focus, params.coc_bounds.x, params.coc_bounds.y);
}

/// Three points in each quadrant, one in each ring of a third of the disc's area, at the
/// angles that keep the twelve farthest apart (0.45 radii) while both axes have the
/// disc's second moment, 1/4. Symmetric, so that a mirrored image is blurred alike.
const QUADRANT = array<vec2f, 3>(
    vec2f(0.2282895, 0.3384532),
    vec2f(0.6685826, 0.2302114),
    vec2f(0.5008804, 0.7631855),
);

fn tap(i: u32) -> vec2f {
    return QUADRANT[i / 4u] * vec2f(select(1.0, -1.0, (i & 1u) != 0u), select(1.0, -1.0, (i & 2u) != 0u));
}

/// The pixel that lies `offset` px from a pixel's centre. Rounded as a distance, not as a
/// position: that would round to either side by where in the image it is.
fn pixel_offset(offset: vec2f) -> vec2i {
    return vec2i(sign(offset) * floor(abs(offset) + 0.5));
}

fn blurriness(coc: f32) -> f32 {
    return saturate(abs(coc) / params.full_coc);
}

@compute @workgroup_size(8, 8)
fn gather_taps(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let size = textureDimensions(color);
    let copy = textureDimensions(reduced);
    let centre = vec2i(id.xy) + i32(params.overscan);
    let at = vec2f(centre) + 0.5;
    let centre_z = textureLoad(depth, centre, 0).r;
    let radius = 0.5 * params.diameter_per_coc * abs(coc_at(centre));
    let own = textureLoad(color, centre, 0).rgb;
    // Differences from the centre are summed, so that a constant colour stays exactly that.
    let base = select(vec3f(0.0), own, is_finite(own));
    var low = base;
    var high = base;
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 0u; i < 12u; i++) {
        let offset = radius * tap(i);
        let sharp_at = at + offset;
        let blurred_at = at + STEP * params.radius_scale * offset;
        let p = clamp_to_image(centre + pixel_offset(offset), size);
        let tap_blurriness = blurriness(coc_at(p));
        let sharp = textureSampleLevel(color, linear_clamp, sharp_at / vec2f(size), 0.0).rgb;
        let blurred_uv = (blurred_at + margin(size, copy)) / (STEP * vec2f(copy));
        let blurred = textureSampleLevel(reduced, linear_clamp, blurred_uv, 0.0).rgb;
        // z = near / d: greater is nearer.
        let leaks = params.leak_test != 0u && textureLoad(depth, p, 0).r > centre_z;
        let weight = select(1.0, tap_blurriness, leaks);
        // A pixel that is not finite reaches the bilinear reads around it only.
        let mixed = mix(sharp, blurred, tap_blurriness);
        if is_finite(mixed) {
            sum += weight * (mixed - base);
            weights += weight;
            low = min(low, mixed);
            high = max(high, mixed);
        }
    }
    // All taps may be refused: nearer, and sharp. Rounded, a mean may leave what it is of.
    let color = select(base, clamp(base + sum / weights, low, high), weights > 0.0);
    textureStore(result, id.xy, vec4f(color, 1.0));
}
