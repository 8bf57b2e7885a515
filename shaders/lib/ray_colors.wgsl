// The colour of what a lens ray hits: the mean over the samples of a texel; near focus, where the
// picture is sharp, that of samples.

#import emitters
#import lens_rays

/// The layers, the first as the mean of its samples.
@group(2) @binding(1) var colors: texture_2d_array<f32>;
/// Radiance of the samples of the first layer.
@group(2) @binding(5) var sample_colors: texture_2d<f32>;
@group(2) @binding(2) var linear_clamp: sampler;
@group(2) @binding(8) var nearest_clamp: sampler;

/// What the pinhole sees at the centre of a pixel.
fn pinhole_color(p: vec2f) -> vec3f {
    return textureLoad(sample_colors, sample_at(p), 0).rgb;
}

/// By how much a ray's offset shrinks along and across the eye's meridian so that the blur of
/// reading a texel (`read_blur`) and of the filter, both four times a variance, are not added to the
/// lens's own.
fn shrink(s: f32, read_blur: f32) -> vec2f {
    let filtered = filter_blur(bucket_of(s));
    if !ASTIGMATIC {
        return vec2f(shrink_of_axis(s, read_blur, filtered));
    }
    let axes = half_axes(s);
    return vec2f(shrink_of_axis(axes.x, read_blur, filtered), shrink_of_axis(axes.y, read_blur, filtered));
}

fn shrink_of_axis(s: f32, read_blur: f32, filtered: f32) -> f32 {
    let s2 = s * s * adaptive.lens_variance;
    // Where the read alone blurs as much as the lens, no offset is right; the read's blur
    // then fades in with the lens's.
    if s2 < 2.16 * read_blur {
        return 0.481 * sqrt(s2 / read_blur);
    }
    return sqrt(1.0 - min((read_blur + filtered) / s2, 0.9));
}

/// Four times the variance, texel^2, of a bilinear read at arbitrary phases.
const BILINEAR_BLUR = 0.667;

/// Difference of s, px, between texels of one surface and another near focus.
const EDGE_S = 0.05;

/// |s|, px, from which fewer rays show means of texels at edges, and none from twice that:
/// there rays spread over several texels and resolve the edge themselves.
const SPREAD_FROM_S = 0.3;

/// Whether the ray through lens point v shows the samples around it interpolated, or one.
/// In focus the image is made of samples; the wider the lens's blur, the more rays show the
/// mean, until that blurs as much as the lens: a thin bar fades in.
fn shows_mean(hit_s: f32, v: vec2f) -> bool {
    let s = greatest_s(hit_s);
    let share = min(s * s * adaptive.lens_variance / sample_blur(), 1.0) * clamp(2.0 - abs(s) / SPREAD_FROM_S, 0.0, 1.0);
    // Any number that differs from ray to ray will do.
    return fract(43.7585 * dot(v, vec2f(12.9898, 78.233))) < share;
}

/// Four times the variance, px^2 per axis, of a bilinear read of samples.
fn sample_blur() -> f32 {
    return BILINEAR_BLUR / f32(adaptive.samples_a_side * adaptive.samples_a_side);
}

/// The place of a position, px, in the colours of a layer, texels. A texel of the first
/// layer is the mean of samples from its centre on to the right and down, not around it.
fn color_place(layer: i32, position: vec2f) -> vec2f {
    let draws = f32(adaptive.samples_a_side) / f32(adaptive.fineness);
    let staggered = select(0.0, mean_stagger(f32(adaptive.samples_a_side)) / draws, STAGGERED);
    return texels_of(adaptive.fineness, position) - select(0.0, 0.5 - 0.5 / draws + staggered, layer == 0);
}

/// A hit of a sample as one of the layer that shows the same surface, whose colour is a mean
/// over samples; the sample's own where no layer does.
fn in_layers(hit: Hit, at: vec2f) -> Hit {
    if hit.layer != SAMPLE {
        return hit;
    }
    let there = radii_at(at);
    let j = nearest_to(there, hit.s);
    let s = component(there, j);
    if is_same(s, hit.s) {
        return Hit(j, s, hit.at_s);
    }
    return hit;
}

/// Colour of a hit. `limited`: without what emitters bring.
fn color_of(found: Hit, p: vec2f, v: vec2f, limited: bool) -> vec3f {
    if found.layer == SAMPLE && is_fine(found.s) {
        return color_of_samples(found, p, v, limited);
    }
    let read_blur = BILINEAR_BLUR / f32(adaptive.fineness * adaptive.fineness);
    let size = vec2f(textureDimensions(radii));
    if found.layer == SAMPLE || found.layer == 0 {
        // Mostly all four texels of the first layer around the place show the surface that was hit.
        let ray = color_place(0, p - shrunk_offset(v, found.s, shrink(found.s, read_blur)));
        let at = clamp(ray, vec2f(0.5), size - 0.5) / size;
        let around = textureGather(0, radii, linear_clamp, at);
        if all(abs(around - found.s) <= vec4f(same_within(found.s))) {
            return textureSampleLevel(colors, linear_clamp, at * size / vec2f(textureDimensions(colors)), 0, 0.0).rgb;
        }
    }
    let shown_at = place_on_ray(ray_from(p, v), v, found.at_s);
    let hit = in_layers(found, shown_at);
    if hit.layer == SAMPLE {
        return color_of_sample(hit, shown_at, limited);
    }
    let ray = color_place(hit.layer, p - shrunk_offset(v, hit.s, shrink(hit.s, read_blur)));
    let at = clamp(ray, vec2f(0.5), size - 0.5);
    let b = bilinear(at);
    // What lights bring is left out of the first layer's mean.
    let with_lights = limited && hit.layer > 0;
    var same = true;
    var s: vec4f;
    for (var i = 0; i < 4; i++) {
        s[i] = component(textureLoad(radii, corner_of(b, i), 0), hit.layer);
        same = same && is_same(s[i], hit.s);
    }
    if !same {
        let texel = texel_at(shown_at);
        return without_lights(textureLoad(colors, texel, hit.layer, 0).rgb, hit.s, with_lights);
    }
    if !with_lights {
        return textureSampleLevel(colors, linear_clamp, at / vec2f(textureDimensions(colors)), hit.layer, 0.0).rgb;
    }
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let color = textureLoad(colors, corner_of(b, i), hit.layer, 0).rgb;
        sum += corner_weight(b, i) * without_lights(color, s[i], true);
    }
    return sum;
}

/// Colour of a sample that was hit.
fn color_of_samples(hit: Hit, p: vec2f, v: vec2f, limited: bool) -> vec3f {
    // The pixels of an image are squares of one colour, and not points of a finer one.
    if IMAGE {
        return color_of_sample(hit, place_on_ray(ray_from(p, v), v, hit.at_s), limited);
    }
    let ray = p - shrunk_offset(v, hit.s, shrink(hit.s, sample_blur()));
    let around = sample_s_around(ray);
    let same = all(abs(around - hit.s) <= vec4f(same_within(hit.s)));
    let at_edge = any(abs(around - hit.s) > vec4f(EDGE_S));
    // An edge is as blurred as what lies in front.
    let front = min(hit.s, min(min(around.x, around.y), min(around.z, around.w)));
    if at_edge && shows_mean(front, v) {
        return interpolated(ray_from(p, v) - v * front, limited);
    }
    if same {
        return interpolated(ray, limited);
    }
    return color_of_sample(hit, place_on_ray(ray_from(p, v), v, hit.at_s), limited);
}

fn color_of_sample(hit: Hit, at: vec2f, limited: bool) -> vec3f {
    return without_lights(textureLoad(sample_colors, sample_at(at), 0).rgb, hit.s, limited);
}

/// s of the samples around a position, px.
fn sample_s_around(position: vec2f) -> vec4f {
    var z: vec4f;
    if STAGGERED {
        let around = samples_around(position);
        for (var i = 0; i < 4; i++) {
            z[i] = textureLoad(sample_depths, sample_corner(around, i), 0).r;
        }
    } else {
        let at = texels_of(adaptive.samples_a_side, position) / vec2f(textureDimensions(sample_depths));
        z = textureGather(0, sample_depths, nearest_clamp, at);
    }
    return vec4f(s_of_depth(adaptive, z.x), s_of_depth(adaptive, z.y), s_of_depth(adaptive, z.z), s_of_depth(adaptive, z.w));
}

/// The colours of the samples around a position, px, of whatever surfaces.
fn interpolated(position: vec2f, limited: bool) -> vec3f {
    if !STAGGERED && !limited {
        // A regular grid is what the hardware's filter reads.
        let size = vec2f(textureDimensions(sample_colors));
        let at = clamp(texels_of(adaptive.samples_a_side, position), vec2f(0.5), size - 0.5);
        return textureSampleLevel(sample_colors, linear_clamp, at / size, 0.0).rgb;
    }
    let around = samples_around(position);
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let texel = sample_corner(around, i);
        var color = textureLoad(sample_colors, texel, 0).rgb;
        if limited {
            color = without_lights(color, sample_s(texel), true);
        }
        sum += sample_weight(around, i) * color;
    }
    return sum;
}

/// Two neighbouring samples of each of two rows.
struct SamplesAround {
    /// The upper row, and the left column of the upper and of the lower row.
    row: f32,
    columns: vec2f,
    /// The shares of the right samples of both rows, and of the lower row.
    right: vec2f,
    lower: f32,
}

/// The left one of two samples of a row around x, the share of the right one, and how far down the two
/// lie there: samples of the regular grid.
fn along_row(row: f32, x: f32) -> vec3f {
    let from_first = x - stagger(row);
    let column = floor(from_first);
    let right = from_first - column;
    return vec3f(column, right, row + mix(stagger(column), stagger(column + 1.0), right));
}

fn samples_around(position: vec2f) -> SamplesAround {
    let at = texels_of(adaptive.samples_a_side, position) - 0.5;
    let row = floor(at.y);
    let own = along_row(row, at.x);
    // The row lies up to a sample lower.
    let is_below = own.z > at.y;
    let other = along_row(select(row + 1.0, row - 1.0, is_below), at.x);
    let upper = select(own, other, is_below);
    let lower = select(other, own, is_below);
    let share = clamp((at.y - upper.z) / max(lower.z - upper.z, 1e-3), 0.0, 1.0);
    return SamplesAround(select(row, row - 1.0, is_below), vec2f(upper.x, lower.x), vec2f(upper.y, lower.y), share);
}

fn sample_corner(around: SamplesAround, i: i32) -> vec2i {
    let is_lower = i >= 2;
    let column = select(around.columns.x, around.columns.y, is_lower) + f32(i & 1);
    let row = around.row + select(0.0, 1.0, is_lower);
    return clamp_to_image(vec2i(vec2f(column, row)), textureDimensions(sample_depths));
}

fn sample_weight(around: SamplesAround, i: i32) -> f32 {
    let is_lower = i >= 2;
    let right = select(around.right.x, around.right.y, is_lower);
    return select(1.0 - right, right, (i & 1) != 0) * select(1.0 - around.lower, around.lower, is_lower);
}

fn corner_of(b: Bilinear, i: i32) -> vec2i {
    return clamp_to_image(b.corner + vec2i(i & 1, i >> 1), textureDimensions(radii));
}

fn corner_weight(b: Bilinear, i: i32) -> f32 {
    let w = mix(1.0 - b.weight, b.weight, vec2f(vec2i(i & 1, i >> 1)));
    return w.x * w.y;
}

fn without_lights(color: vec3f, s: f32, limited: bool) -> vec3f {
    return select(color, color - emitted_share(greatest_s(s), adaptive.lens_radius, IMAGE) * over_limit(color), limited);
}
