// A lens ray through peeled layers: what it hits.
//
//   s ^            a ray is straight in (x, y, s); it walks the bins that the tile's mask
//     |  / / ray   says are occupied, front (s < 0) to back, and hits the first surface
//     |_/_/__ x    whose s the texel under it holds
//     |/ /
//
// Rays look for the first layer in its samples, which are finer than the texels of the layers, and
// for what those hide in the layers. Their colours are in lib/ray_colors.wgsl.

#import four_layers
#import layers
#import nearest_grid
#import sampling
#import staggered

// What holds for all rays of a dispatch: a pipeline has no code for the rest.

/// Whether the eye is astigmatic, so that blur is elliptic.
override ASTIGMATIC: bool = true;
/// Whether samples are staggered (`stagger_of`); else they lie in a regular grid.
override STAGGERED: bool = true;
/// Whether what is seen is an image with depth.
override IMAGE: bool = true;
/// Whether there are sheets.
override SHEETS: bool = true;

/// s of up to four layers, nearest first.
@group(2) @binding(0) var radii: texture_2d<f32>;
/// Stored depth of the samples of the first layer.
@group(2) @binding(6) var sample_depths: texture_2d<f32>;

/// How far, px of s, a surface may be from a ray's step to be hit: cracks open at 0, edges
/// thicken from 1 on.
const TOLERANCE_S = 0.25;

/// The texel of the layers at a position, px.
fn texel_at(position: vec2f) -> vec2i {
    return clamp_to_image(vec2i(floor(texels_of(adaptive.fineness, position))), textureDimensions(radii));
}

/// By how much a sample of a row lies to the right of its place in a regular grid, and one of a column
/// below it, samples.
fn stagger(line: f32) -> f32 {
    return select(0.0, stagger_of(line, f32(adaptive.samples_a_side)), STAGGERED);
}

/// The sample of a row that is nearest along it to a place among the samples, and how far away it lies.
fn sample_in_row(at: vec2f, row: f32) -> vec2f {
    let column = floor(at.x - stagger(row));
    let place = vec2f(column + stagger(row), row + stagger(column)) + 0.5;
    return vec2f(column, distance(place, at));
}

/// The sample at a position, px. Staggered samples lie up to one lower than their row of a regular
/// grid: there it is the nearer one of two rows.
fn sample_at(position: vec2f) -> vec2i {
    let at = texels_of(adaptive.samples_a_side, position);
    if !STAGGERED {
        return clamp_to_image(vec2i(floor(at)), textureDimensions(sample_depths));
    }
    let row = floor(at.y);
    let own = sample_in_row(at, row);
    let above = sample_in_row(at, row - 1.0);
    let place = select(vec2f(own.x, row), vec2f(above.x, row - 1.0), above.y < own.y);
    return clamp_to_image(vec2i(place), textureDimensions(sample_depths));
}

fn sample_s(texel: vec2i) -> f32 {
    return s_of_depth(adaptive, textureLoad(sample_depths, texel, 0).r);
}

fn radii_at(position: vec2f) -> vec4f {
    return textureLoad(radii, texel_at(position), 0);
}

/// Longest list of runs of occupied bins: every other one.
const MAX_RUNS = 32u;

/// Most steps of a ray in a run: one that is nearly parallel to the layers ends there.
const MAX_STEPS = 65535u;

/// s of the near and far end of each run of occupied bins.
var<workgroup> runs: array<vec2f, MAX_RUNS>;
var<workgroup> run_count: u32;

fn find_runs(mask: vec2u) {
    var rest = mask;
    var count = 0u;
    while count < MAX_RUNS && any(rest != vec2u(0u)) {
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
    /// Layer, NO_HIT for none, or SAMPLE for a sample of the first.
    layer: i32,
    s: f32,
    /// s of the place on the ray that shows what was hit: `place_on_ray`.
    at_s: f32,
}

const NO_HIT = -1;
const SAMPLE = 4;

/// Half axis of a blur, px, up to which silhouettes are sharp enough to need a step for each sample.
const FINE_UP_TO_S = 1.5;

/// |s| up to which a silhouette may be so sharp: one meridian of an astigmatic eye is in focus in
/// front of s = 0 and one behind it.
fn fine_up_to_s() -> f32 {
    return FINE_UP_TO_S + astigmatic_s();
}

/// Whether samples are asked, by a ray at `s` that moves on.
fn is_fine(s: f32) -> bool {
    return s >= -fine_up_to_s() && s < fine_up_to_s();
}

/// What a ray's steps are like.
struct Steps {
    /// Length, px of s, of a step near focus, and of one elsewhere.
    fine: f32,
    wide: f32,
    /// Half of the way, px of s, over which a place of the grid knows what a ray may meet.
    reach: f32,
}

fn steps_of(v: vec2f) -> Steps {
    let s_per_px = 1.0 / max(length(v), 1e-3);
    // Between two steps of a ray through an image lies at most the corner of a pixel.
    let samples_a_side = select(adaptive.samples_a_side, 2u, IMAGE);
    let fine_px = select(2.0, 1.0 / f32(samples_a_side), samples_a_side > 1u);
    // Windows are squares.
    let s_per_side = 1.0 / max(max(abs(v.x), abs(v.y)), 1e-3);
    return Steps(
        fine_px * s_per_px,
        2.0 * s_per_px,
        adaptive.grid_reach_px * s_per_side,
    );
}

/// Where the steps of a ray from s = `start` on, in a run that ends at `end`, change their length at
/// the latest, px of s.
fn same_steps_up_to(start: f32, end: f32) -> f32 {
    let fine_s = fine_up_to_s();
    let limit = select(-fine_s, fine_s, start >= -fine_s);
    return select(end, min(end, limit), start < fine_s);
}

/// Length, px of s, of the step of a ray that starts at `start` in a run that ends at `end`.
fn step_from(steps: Steps, start: f32, end: f32) -> f32 {
    return min(select(steps.wide, steps.fine, is_fine(start)), same_steps_up_to(start, end) - start);
}

/// Where a ray at s = `start` gets by whole steps in front of everything that the grid knows of what lies
/// around them. It is asked for the place that the ray passes half way to where it knows no more.
fn free_up_to(from_p: vec2f, v: vec2f, start: f32, end: f32, full: f32, reach: f32) -> f32 {
    let nearest_s = nearest_around(from_p - v * (start + reach));
    let free = min(2.0 * reach, nearest_s - TOLERANCE_S - ROUNDING_S - start);
    return select(start + full * max(floor(free / full), 0.0), end, start + free >= end);
}

/// More than places on a ray are rounded by, px of s.
const ROUNDING_S = 1e-3;

/// Where the ray through pixel `p` and lens point `v` begins, px: astigmatism moves it as a whole.
fn ray_from(p: vec2f, v: vec2f) -> vec2f {
    if !ASTIGMATIC {
        return p;
    }
    return p - astigmatic_offset_px(adaptive.lens, v);
}

/// A ray on its way through the runs of bins.
struct Ray {
    from_p: vec2f,
    v: vec2f,
    steps: Steps,
    /// Surfaces behind this s may be found or not.
    last_s: f32,
    /// The run that it is in, s where it is and where the run ends.
    run: u32,
    start: f32,
    end: f32,
    /// Where the last step ended, and s of the sample there.
    known_at: f32,
    known: f32,
}

/// The ray through `p` and lens point `v`, that looks for surfaces up to `last_s`.
fn ray_up_to(p: vec2f, v: vec2f, last_s: f32) -> Ray {
    var ray = Ray(ray_from(p, v), v, steps_of(v), last_s, 0u, 0.0, 0.0, EMPTY_S, 0.0);
    begin_run(&ray);
    return ray;
}

fn begin_run(ray: ptr<function, Ray>) {
    let run = runs[min((*ray).run, MAX_RUNS - 1u)];
    (*ray).start = run.x;
    (*ray).end = min(run.y, (*ray).last_s + TOLERANCE_S);
    (*ray).known_at = EMPTY_S;
}

/// Whether a ray has met nothing, and is at its end.
fn is_over(ray: Ray) -> bool {
    return ray.run >= run_count;
}

/// Samples and radii that rays of this invocation have read.
var<private> texels_read: u32;

/// Where a ray gets from s = `start` by steps of one length through empty space.
fn free_from(from_p: vec2f, v: vec2f, steps: Steps, start: f32, end: f32) -> f32 {
    let full = select(steps.wide, steps.fine, is_fine(start));
    let free = free_up_to(from_p, v, start, same_steps_up_to(start, end), full, steps.reach);
    return select(start, max(free, start), start < end);
}

/// Moves a ray over steps in front of everything, and then by one in which it may hit something.
///
/// It ends with its last run, and what it calls has few loops: llvmpipe ends all loops of an invocation
/// after 65,535 rounds in all, inner ones counted, and of many lights the last ones would be missed.
fn advance(ray: ptr<function, Ray>) -> Hit {
    let from_p = (*ray).from_p;
    let v = (*ray).v;
    let steps = (*ray).steps;
    let end = (*ray).end;
    var start = (*ray).start;
    // Steps through empty space are left out, all others are as long as they would be.
    // No loop: its rounds would count among those that llvmpipe grants.
    start = free_from(from_p, v, steps, start, end);
    start = free_from(from_p, v, steps, start, end);
    let before = start;
    start = free_from(from_p, v, steps, start, end);
    let is_free = start > before;
    var hit = Hit(NO_HIT, 0.0, 0.0);
    if !is_free && start < end {
        let width = step_from(steps, start, end);
        let fine = is_fine(start);
        // What is near the front of a step hides what is near its end; near focus, where steps are
        // short, they ask once.
        let front_s = start + select(0.0, 0.25 * width, fine);
        var s = (*ray).known;
        if (*ray).known_at != start || fine {
            s = sample_s(sample_at(place_on_ray(from_p, v, front_s)));
            texels_read += 1u;
        }
        hit = met(from_p, v, front_s, s, start, width);
        let is_one = fine || width * f32(adaptive.samples_a_side) < SAME_SAMPLE * 0.5 * steps.wide;
        start += width;
        if hit.layer == NO_HIT && !is_one {
            s = sample_s(sample_at(place_on_ray(from_p, v, start)));
            texels_read += 1u;
            hit = met(from_p, v, start, s, start - width, width);
            (*ray).known_at = start;
            (*ray).known = s;
        }
    }
    (*ray).start = start;
    if start >= end {
        (*ray).run += 1u;
        begin_run(ray);
    }
    return hit;
}

/// The first surface on the ray through `p` and lens point `v`, of those up to `last_s`.
fn trace_up_to(p: vec2f, v: vec2f, last_s: f32) -> Hit {
    var ray = ray_up_to(p, v, last_s);
    for (var step = 0u; step < MAX_STEPS && !is_over(ray); step++) {
        let hit = advance(&ray);
        if hit.layer != NO_HIT {
            return hit;
        }
    }
    return Hit(NO_HIT, 0.0, 0.0);
}

/// Whether `composite` filters what the rays of this pass find.
var<private> rays_are_filtered: bool = true;

/// Where the ray that begins at `from_p` and goes through lens point v meets s. What is filtered
/// afterwards keeps that much closer to its pixel: outlines end up as wide as the lens blurs them.
fn place_on_ray(from_p: vec2f, v: vec2f, s: f32) -> vec2f {
    if !rays_are_filtered || abs(s) - astigmatic_s() <= adaptive.sharp_s {
        return from_p - v * s;
    }
    if !ASTIGMATIC {
        let blur = select(NARROW_BLUR, WIDE_BLUR, abs(s) > adaptive.narrow_s) / adaptive.lens_variance;
        return from_p - v * sign(s) * sqrt(max(s * s - blur, 0.1 * s * s));
    }
    let axes = half_axes(s);
    let shrunk = sqrt(1.0 - min(filter_blur(bucket_of(s)) / (axes * axes * adaptive.lens_variance), vec2f(0.9)));
    return from_p + astigmatic_offset_px(adaptive.lens, v) - shrunk_offset(v, s, shrunk);
}

/// Signed half axes of the blur at s, px, along and across the eye's meridian.
fn half_axes(s: f32) -> vec2f {
    return 0.5 * diameters_px(adaptive.lens, 2.0 * s);
}

/// How far from its pixel, px, a ray through lens point v meets s, shrunk along and across the eye's
/// meridian.
fn shrunk_offset(v: vec2f, s: f32, shrunk: vec2f) -> vec2f {
    let lens = adaptive.lens;
    if !ASTIGMATIC {
        return v * (s * shrunk.x);
    }
    return from_meridian(lens, shrunk * by_meridian(lens, v * s + astigmatic_offset_px(lens, v)));
}

/// Length, samples, of a step that is not worth asking at both of its ends.
const SAME_SAMPLE = 0.5;

/// What a ray hits of the surfaces that lie between s = `start` and `width` behind it where it passes
/// s = `asked`, if the sample there lies at s: that sample, or the other layers where it hides them. It
/// is hit where the ray meets it.
fn met(from_p: vec2f, v: vec2f, asked: f32, s: f32, start: f32, width: f32) -> Hit {
    let low = start - TOLERANCE_S;
    let high = start + width + TOLERANCE_S;
    if s > high {
        return Hit(NO_HIT, 0.0, asked);
    }
    var expected = s;
    var layer = SAMPLE;
    if s < low {
        texels_read += 1u;
        let hidden = radii_at(place_on_ray(from_p, v, asked));
        layer = first_within(hidden, max(low, s + MERGED_S), high);
        if layer < 0 {
            return Hit(NO_HIT, 0.0, asked);
        }
        expected = component(hidden, layer);
    }
    let met_at = place_on_ray(from_p, v, expected);
    let seen = sample_s(sample_at(met_at));
    texels_read += 1u;
    if is_met(seen, expected, width) {
        return Hit(SAMPLE, seen, seen);
    }
    if layer == SAMPLE {
        // Where there is only what lies behind, the ray passes beside the surface.
        return Hit(select(SAMPLE, NO_HIT, seen > expected), expected, asked);
    }
    let there = radii_at(met_at);
    texels_read += 1u;
    let j = nearest_to(there, expected);
    let other = component(there, j);
    if is_same(other, expected) {
        return Hit(j, other, expected);
    }
    return Hit(select(NO_HIT, layer, there.x <= expected), expected, asked);
}

/// A component of a vector: what is indexed at run time leaves the registers.
fn component(vector: vec4f, i: i32) -> f32 {
    return select(select(vector.x, vector.y, i == 1), select(vector.z, vector.w, i == 3), i >= 2);
}

/// Difference of s, px, within which a texel of the first layer may be the surface that a
/// sample shows.
const MERGED_S = 0.5;

/// Whether what lies where a ray meets s = `expected` is what the ray was to meet there. Near
/// focus a step is short, and the surface may lie anywhere in it.
fn is_met(s: f32, expected: f32, width: f32) -> bool {
    let within_step = abs(s - expected) <= max(0.5, TOLERANCE_S + width);
    return is_same(s, expected) || (is_fine(expected) && within_step);
}

/// Whether both are s of one surface.
fn is_same(s: f32, other: f32) -> bool {
    return abs(s - other) <= same_within(other);
}

/// How far s of two places of one surface may lie apart, px.
fn same_within(s: f32) -> f32 {
    return 0.25 + 0.08 * abs(s);
}

/// The bucket of what is hit at s: filters are chosen by the sharper meridian, and buckets stay in
/// order of depth, so that all between an astigmatic eye's two foci is sharp.
fn bucket_of(s: f32) -> u32 {
    let size = max(abs(s) - astigmatic_s(), 0.0);
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
    return select(NARROW_BLUR, WIDE_BLUR, bucket == 0u || bucket == BUCKETS - 1u);
}

const NARROW_BLUR = 2.0;
const WIDE_BLUR = 6.0;
