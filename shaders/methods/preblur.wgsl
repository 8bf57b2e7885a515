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
fn mean_of_texel(texel: vec2i, copy: vec2u) -> vec3f {
    let size = textureDimensions(color);
    let centre = STEP * (vec2f(texel) + 0.5) - margin(size, copy);
    let first = vec2i(floor(centre - 0.5 * STEP));
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 0; i < 25; i++) {
        let p = first + vec2i(i % 5, i / 5);
        let covered = saturate(0.5 * STEP + 0.5 - abs(vec2f(p) + 0.5 - centre));
        let weight = covered.x * covered.y;
        // Most images have no texel that cuts a pixel.
        if any(p < vec2i(0)) || any(p >= vec2i(size)) || weight == 0.0 {
            continue;
        }
        let rgb = textureLoad(color, p, 0).rgb;
        if is_finite(rgb) {
            sum += weight * rgb;
            weights += weight;
        }
    }
    return select(vec3f(0.0), sum / weights, weights > 0.0);
}

/// Texels along a side of which a workgroup makes 16x16 filtered ones.
const SPAN = 18u;
var<workgroup> means: array<vec3f, 324>;

/// The copy: means through the 3x3 Gaussian 1 2 1.
@compute @workgroup_size(16, 16)
fn reduce(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let copy = textureDimensions(reduced_out);
    let corner = 16 * vec2i(group.xy) - 1;
    for (var i = index; i < SPAN * SPAN; i += 256u) {
        means[i] = mean_of_texel(clamp_to_image(corner + vec2i(vec2u(i % SPAN, i / SPAN)), copy), copy);
    }
    workgroupBarrier();
    var sum = vec3f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let weight = vec2f(2 - abs(vec2i(vec2u(i % 3u, i / 3u)) - 1)) * 0.25;
        sum += weight.x * weight.y * means[(local.y + i / 3u) * SPAN + local.x + i % 3u];
    }
    let texel = 16u * group.xy + local.xy;
    if all(texel < copy) {
        textureStore(reduced_out, texel, vec4f(sum, 1.0));
    }
}

/// Signed CoC diameter, px, that blurriness follows.
fn coc_of(z: f32) -> f32 {
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
const INNER = vec2f(0.2282895, 0.3384532);
const MIDDLE = vec2f(0.6685826, 0.2302114);
const OUTER = vec2f(0.5008804, 0.7631855);

fn blurriness(coc: f32) -> f32 {
    return saturate(abs(coc) / params.full_coc);
}

/// What all taps of a pixel have in common.
struct Centre {
    pixel: vec2i,
    z: f32,
    /// Radius of the disc, px.
    radius: f32,
    base: vec3f,
    /// Coordinates in the image, and of a pixel there.
    uv: vec2f,
    uv_per_px: vec2f,
    /// The same in the copy, for a tap's offset px in the image.
    blurred_uv: vec2f,
    blurred_uv_per_px: vec2f,
}

/// Sums of differences from the centre, so that a constant colour stays exactly that, and
/// what they lie between.
struct Sums {
    light: vec3f,
    weight: f32,
    low: vec3f,
    high: vec3f,
}

/// With the tap at a point of the first quadrant, turned to the one of `side`.
fn with_tap(sums: Sums, centre: Centre, point: vec2f, side: vec2f) -> Sums {
    let distance = centre.radius * point;
    let offset = side * distance;
    // Rounded as a distance, not as a position: that would round to either side by where in the
    // image it is.
    let p = clamp_to_image(centre.pixel + vec2i(side * floor(distance + 0.5)), textureDimensions(color));
    let z = textureLoad(depth, p, 0).r;
    let tap_blurriness = blurriness(coc_of(z));
    let sharp = textureSampleLevel(color, linear_clamp, centre.uv + centre.uv_per_px * offset, 0.0).rgb;
    let blurred_uv = centre.blurred_uv + centre.blurred_uv_per_px * offset;
    let blurred = textureSampleLevel(reduced, linear_clamp, blurred_uv, 0.0).rgb;
    // z = near / d: greater is nearer.
    let leaks = params.leak_test != 0u && z > centre.z;
    let weight = select(1.0, tap_blurriness, leaks);
    // A pixel that is not finite reaches the bilinear reads around it only.
    let mixed = mix(sharp, blurred, tap_blurriness);
    if !is_finite(mixed) {
        return sums;
    }
    return Sums(
        sums.light + weight * (mixed - centre.base),
        sums.weight + weight,
        min(sums.low, mixed),
        max(sums.high, mixed),
    );
}

@compute @workgroup_size(8, 8)
fn gather_taps(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let size = textureDimensions(color);
    let copy = textureDimensions(reduced);
    let pixel = vec2i(id.xy) + i32(params.overscan);
    let at = vec2f(pixel) + 0.5;
    let z = textureLoad(depth, pixel, 0).r;
    let own = textureLoad(color, pixel, 0).rgb;
    let base = select(vec3f(0.0), own, is_finite(own));
    let uv_per_px = 1.0 / vec2f(size);
    let copy_uv_per_px = 1.0 / (STEP * vec2f(copy));
    let centre = Centre(
        pixel,
        z,
        0.5 * params.diameter_per_coc * abs(coc_of(z)),
        base,
        at * uv_per_px,
        uv_per_px,
        (at + margin(size, copy)) * copy_uv_per_px,
        STEP * params.radius_scale * copy_uv_per_px,
    );
    var sums = Sums(vec3f(0.0), 0.0, base, base);
    for (var i = 0u; i < 4u; i++) {
        let side = select(vec2f(1.0), vec2f(-1.0), vec2<bool>((i & 1u) != 0u, (i & 2u) != 0u));
        sums = with_tap(sums, centre, INNER, side);
        sums = with_tap(sums, centre, MIDDLE, side);
        sums = with_tap(sums, centre, OUTER, side);
    }
    // All taps may be refused: nearer, and sharp. Rounded, a mean may leave what it is of.
    let mean = clamp(base + sums.light / sums.weight, sums.low, sums.high);
    textureStore(result, id.xy, vec4f(select(base, mean, sums.weight > 0.0), 1.0));
}
