// A lens ray through peeled layers: what it hits, and the colour there.
//
//   s ^            a ray is straight in (x, y, s); it walks the bins that the tile's mask
//     |  / / ray   says are occupied, front (s < 0) to back, and hits the first surface
//     |_/_/__ x    whose s the texel under it holds
//     |/ /

#import emitters
#import layers
#import sampling

/// s of up to four layers, nearest first.
@group(2) @binding(0) var radii: texture_2d<f32>;
/// The layers, and behind them the mean of the first.
@group(2) @binding(1) var colors: texture_2d_array<f32>;
@group(2) @binding(2) var linear_clamp: sampler;

/// How far, px of s, a surface may be from a ray's step to be hit: cracks open at 0, edges
/// thicken from 1 on.
const TOLERANCE_S = 0.25;

/// The texel of the layers at a position, px.
fn texel_at(position: vec2f) -> vec2i {
    return clamp_to_image(vec2i(floor(texels_of(adaptive, position))), textureDimensions(radii));
}

fn radii_at(position: vec2f) -> vec4f {
    return textureLoad(radii, texel_at(position), 0);
}

/// Longest list of runs of occupied bins: every other one.
const MAX_RUNS = 32u;

/// s of the near and far end of each run of occupied bins.
var<workgroup> runs: array<vec2f, MAX_RUNS>;
var<workgroup> run_count: u32;
var<workgroup> emitter_count: u32;

fn find_runs(mask: vec2u) {
    var rest = mask;
    var count = 0u;
    while any(rest != vec2u(0u)) {
        let start = first_bin(rest);
        // The first bin from `start` on that is not occupied.
        let free = ~rest & ~first_bins(start);
        let end = select(BINS, first_bin(free), any(free != vec2u(0u)));
        runs[count] = vec2f(edge_of(adaptive, start), edge_of(adaptive, end));
        count += 1u;
        rest &= ~first_bins(end);
    }
    run_count = count;
}

struct Hit {
    /// Layer, or -1 for none.
    layer: i32,
    s: f32,
    /// Where the ray meets it, px of the outer frame.
    at: vec2f,
    /// Texels of radii that were read.
    reads: u32,
}

fn first_within(s: vec4f, low: f32, high: f32) -> i32 {
    for (var k = 0; k < 4; k++) {
        if s[k] >= low && s[k] <= high {
            return k;
        }
    }
    return -1;
}

fn nearest_to(s: vec4f, wanted: f32) -> i32 {
    let d = abs(s - wanted);
    let first = select(0, 1, d.y < d.x);
    let second = select(2, 3, d.w < d.z);
    return select(first, second, min(d.z, d.w) < min(d.x, d.y));
}

/// |s|, px, up to which silhouettes are sharp enough to need a step for each texel.
const FINE_UP_TO_S = 2.5;

/// Length, px of s, of the step of a ray that starts at `start` in a run that ends at `end`.
fn step_from(start: f32, end: f32, v: vec2f) -> f32 {
    let fine = adaptive.fineness > 1u && abs(start) < FINE_UP_TO_S;
    let px = select(2.0, 1.0 / f32(adaptive.fineness), fine);
    let limit = select(end, min(end, -FINE_UP_TO_S), start < -FINE_UP_TO_S);
    return min(px / max(length(v), 1e-3), limit - start);
}

/// The first surface on the ray through `p` and lens point `v`.
fn trace(p: vec2f, v: vec2f) -> Hit {
    var reads = 0u;
    for (var r = 0u; r < run_count; r++) {
        let end = runs[r].y;
        var width = 0.0;
        for (var start = runs[r].x; start < end; start += width) {
            width = step_from(start, end, v);
            let at = p - v * (start + 0.5 * width);
            let s = radii_at(at);
            reads += 1u;
            let k = first_within(s, start - TOLERANCE_S, start + width + TOLERANCE_S);
            if k < 0 {
                continue;
            }
            // Where the ray meets the surface that this texel holds, there may be another.
            let refined = p - v * s[k];
            let there = radii_at(refined);
            let j = nearest_to(there, s[k]);
            if abs(there[j] - s[k]) <= max(0.5, TOLERANCE_S + width) {
                return Hit(j, there[j], p - v * there[j], reads + 1u);
            }
            return Hit(k, s[k], at, reads + 1u);
        }
    }
    return Hit(-1, 0.0, p, reads);
}

// ---- colour ----

fn bucket_of(s: f32) -> u32 {
    let size = abs(s);
    if size <= adaptive.sharp_s {
        return SHARP;
    }
    let offset = select(1u, 2u, size > adaptive.narrow_s);
    return select(SHARP + offset, SHARP - offset, s < 0.0);
}

/// Four times the variance, px^2 per axis, of the filter that `composite` applies to a
/// bucket: [1 2 1] / 4 has 1/2, [1 2 2 2 1] / 8 has 3/2.
fn filter_blur(bucket: u32) -> f32 {
    if bucket == SHARP {
        return 0.0;
    }
    return select(2.0, 6.0, bucket == 0u || bucket == BUCKETS - 1u);
}

/// By how much a ray's offset shrinks so that the blur of reading a texel (`read_blur`)
/// and of the filter, both four times a variance, are not added to the lens's own.
fn shrink(s: f32, read_blur: f32) -> f32 {
    let s2 = s * s * adaptive.lens_variance;
    // Where the read alone blurs as much as the lens, no offset is right; the read's blur
    // then fades in with the lens's.
    if s2 < 2.16 * read_blur {
        return 0.481 * sqrt(s2 / read_blur);
    }
    return sqrt(1.0 - min((read_blur + filter_blur(bucket_of(s))) / s2, 0.9));
}

/// Four times the variance, texel^2, of a bilinear read at arbitrary phases.
const BILINEAR_BLUR = 0.667;

/// |s|, px, from which the first layer shows its mean over more samples, from which all
/// that emitters bring is left out. Nearer to focus a sample is where its texel says.
const MEAN_FROM_S = 2.5;

/// Difference of s, px, between texels of one surface and another near focus.
const EDGE_S = 0.05;

/// |s|, px, from which fewer rays show means of texels at edges, and none from twice that:
/// there rays spread over several texels and resolve the edge themselves.
const SPREAD_FROM_S = 0.3;

/// Whether the ray through lens point v shows the mean of a texel, 1/fineness px wide, or one
/// sample. In focus the image is made of samples; the wider the lens's blur, the more rays
/// show the mean, until the mean blurs as much as the lens: a thin bar fades in.
fn shows_mean(s: f32, v: vec2f) -> bool {
    let share = min(s * s * adaptive.lens_variance / texel_blur(), 1.0) * clamp(2.0 - abs(s) / SPREAD_FROM_S, 0.0, 1.0);
    // Any number that differs from ray to ray will do.
    return fract(43.7585 * dot(v, vec2f(12.9898, 78.233))) < share;
}

/// Four times the variance, px^2 per axis, of the mean over a texel.
fn texel_blur() -> f32 {
    return 1.0 / f32(3u * adaptive.fineness * adaptive.fineness);
}

/// Colour of a hit. `limited`: without what emitters bring.
fn color_of(hit: Hit, p: vec2f, v: vec2f, limited: bool) -> vec3f {
    let size = vec2f(textureDimensions(radii));
    let read_blur = BILINEAR_BLUR / f32(adaptive.fineness * adaptive.fineness);
    let ray = texels_of(adaptive, p - v * (hit.s * shrink(hit.s, read_blur)));
    let at = clamp(ray, vec2f(0.5), size - 0.5);
    let b = bilinear(at);
    let is_mean = hit.layer == 0 && abs(hit.s) >= MEAN_FROM_S;
    let image = select(hit.layer, i32(adaptive.layers), is_mean);
    var same = true;
    var s: vec4f;
    for (var i = 0; i < 4; i++) {
        s[i] = textureLoad(radii, corner_of(b, i), 0)[hit.layer];
        same = same && abs(s[i] - hit.s) <= 0.25 + 0.08 * abs(hit.s);
    }
    let at_edge = any(abs(s - hit.s) > vec4f(EDGE_S));
    if at_edge && hit.layer == 0 && !limited && shows_mean(hit.s, v) {
        return textureLoad(colors, texel_at(hit.at), i32(adaptive.layers), 0).rgb;
    }
    if !same {
        return limited_color(texel_at(hit.at), image, hit.s, limited && !is_mean);
    }
    if is_mean || !limited {
        return textureSampleLevel(colors, linear_clamp, at / vec2f(textureDimensions(colors)), image, 0.0).rgb;
    }
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let w = mix(1.0 - b.weight, b.weight, vec2f(vec2i(i & 1, i >> 1)));
        sum += w.x * w.y * limited_color(corner_of(b, i), image, s[i], true);
    }
    return sum;
}

fn corner_of(b: Bilinear, i: i32) -> vec2i {
    return clamp_to_image(b.corner + vec2i(i & 1, i >> 1), textureDimensions(radii));
}

fn limited_color(texel: vec2i, image: i32, s: f32, limited: bool) -> vec3f {
    let color = textureLoad(colors, texel, image, 0).rgb;
    return select(color, color - emitted_share(s) * over_limit(color), limited);
}
