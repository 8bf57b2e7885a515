// multiview: lens rays traced through slabs of the scene (src/methods/multiview/mod.rs).
//
// Lee, Eisemann and Seidel, SIGGRAPH Asia 2009, sections 4.3 to 4.5. In (x, y, c) lens rays
// are straight: the ray through output pixel p and lens point v is at
//
//   p - v * c / 2        (src/lib.rs)
//
// and a slab is a height field of c over the image, bounded in c:
//
//        p                        c grows away from the eye
//   -----|-----  slab 0           the ray leans over by |v|/2 px for each px of c:
//      \ |                        little within a slab
//   ----\|-----  slab 1
//        |\  ....  c = 0: in focus, every ray is at p
//   -----|-\---  slab 2
//
// An astigmatic eye only moves where they begin (lib/lens.wgsl).
//
// A workgroup has a tile of 8x8 pixels. Point k of a pixel's set of lens points lies in cell k of
// the lens, whichever of the sets that is (src/methods/multiview/points.rs). So the rays of a tile
// through point k cross a small rectangle of each slab, and one look at an N-buffer says for
// all of them whether anything is there, and how near its nearest surface is.

#import hash
#import lens
#import shading
#import sheet_rays
#import tile_lists

struct Params {
    /// Position of the output's corner in the arrays, px.
    origin: vec2f,
    /// What of the arrays is image.
    frame_low: vec2f,
    frame_high: vec2f,
    slab_count: u32,
    /// Lens points per pixel.
    samples: u32,
    /// Sets of lens points: each pixel uses one of them.
    sets: u32,
    /// Greatest offset of a jittered lens point per axis.
    jitter: f32,
    /// 1: false position; 0: steps.
    false_position: u32,
    /// Lambda: diameter of a ray's cone over C; 0 for a ray without width.
    cone_per_coc: f32,
    culling: u32,
    /// 1: slabs hold what surfaces are made of, and rays shade by their lens points.
    shading: u32,
    /// Where the optical axis meets the image in the arrays, px.
    axis: vec2f,
    /// Distance of the image plane, px.
    focal_px: f32,
    near_m: f32,
    /// Radius of the lens, metres.
    lens_radius_m: f32,
    /// 1: coverages are composed as in section 4.4; 0: they add up.
    over: u32,
    /// How far beyond the image what its border shows goes on, px.
    stretched_px: f32,
    /// Side of the N-buffer's blocks, px, a power of two.
    block_px: u32,
    /// Blocks along x and y.
    blocks: vec2u,
    /// Greatest component of any lens point, with the jitter.
    greatest_v: f32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var slab_color: texture_2d_array<f32>;
@group(0) @binding(3) var slab_depth: texture_2d_array<f32>;
/// By level, slab and block: greatest z in the 2^level x 2^level blocks right of and below
/// each block; less than 0 for none.
@group(0) @binding(4) var<storage, read> n_buffer: array<f32>;
@group(0) @binding(5) var linear_clamp: sampler;
@group(0) @binding(6) var<storage, read> content: array<vec2u>;
/// By cell and set; then for each cell its least and greatest point, with the jitter.
@group(0) @binding(7) var<storage, read> lens_points: array<vec2f>;
@group(0) @binding(8) var pinhole: texture_2d<f32>;
@group(0) @binding(9) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(10) var slab_base: texture_2d_array<f32>;
@group(0) @binding(11) var slab_normal: texture_2d_array<f32>;
@group(0) @binding(12) var<uniform> environment: Environment;
@group(0) @binding(13) var<storage, read> lights: array<Light>;

struct Ray {
    /// Position in the arrays where c = 0, px.
    pixel: vec2f,
    /// Lens point.
    v: vec2f,
}

fn at(ray: Ray, c: f32) -> vec2f {
    return ray.pixel - ray.v * (0.5 * c);
}

fn in_frame(p: vec2f) -> bool {
    return all(p >= params.frame_low - params.stretched_px) && all(p < params.frame_high + params.stretched_px);
}

/// The place in the image that stands for one in its stretched border.
fn on_image(p: vec2f) -> vec2f {
    return clamp(p, params.frame_low + 0.5, params.frame_high - 0.5);
}

/// Nearest and farthest c between which a ray is over the image and its stretched border: however
/// blurred the slabs are, only that part of it is searched.
fn over_frame(ray: Ray) -> vec2f {
    let v = select(ray.v, vec2f(1e-9), abs(ray.v) < vec2f(1e-9));
    let a = 2.0 * (ray.pixel - params.frame_low + params.stretched_px) / v;
    let b = 2.0 * (ray.pixel - params.frame_high - params.stretched_px) / v;
    let nearest = min(a, b);
    let farthest = max(a, b);
    return vec2f(max(nearest.x, nearest.y), min(farthest.x, farthest.y));
}

/// c of a texel with nothing: farther than anything.
const EMPTY_C = 1e30;

/// c of the slab's surface under a position, EMPTY_C without one. `leaves`: whether the position
/// may lie beside the image.
fn surface_c(p: vec2f, slab: u32, leaves: bool) -> f32 {
    var place = p;
    if leaves {
        if !in_frame(p) {
            return EMPTY_C;
        }
        place = on_image(p);
    }
    let z = textureLoad(slab_depth, vec2i(place), slab, 0).r;
    return select(coc_diameter_px(lens, z), EMPTY_C, z < 0.0);
}

// ---- where a ray meets a slab ----

/// Method of false position (section 4.3, Fig. 5): the surface between two points of the
/// ray is taken as straight. It starts between the slab's bounds, as if the surface lay at
/// the far one where the ray enters and at the near one where it leaves.
fn false_position(ray: Ray, slab: u32, near: f32, far: f32, leaves: bool) -> f32 {
    var low = near;
    var low_height = far;
    var high = far;
    var high_height = near;
    var c = 0.5 * (near + far);
    for (var i = 0u; i < 3u; i++) {
        let height = surface_c(at(ray, c), slab, leaves);
        if height == EMPTY_C {
            if i > 0u {
                break;
            }
            // Only now are the ends looked up; an empty one keeps the bound with which the
            // intersection stays in the slab.
            let entry = surface_c(at(ray, near), slab, leaves);
            let exit = surface_c(at(ray, far), slab, leaves);
            low_height = select(entry, far, entry == EMPTY_C);
            high_height = select(exit, near, exit == EMPTY_C);
        } else if height < c {
            high = c;
            high_height = height;
        } else {
            low = c;
            low_height = height;
        }
        let low_gap = max(low_height - low, 0.0);
        let high_gap = max(high - high_height, 0.0);
        if low_gap + high_gap < 1e-4 {
            break;
        }
        c = mix(low, high, low_gap / (low_gap + high_gap));
    }
    return c;
}

/// By how much a surface at a slab's bound may lie beyond it after rounding, px: a wall that
/// faces the eye lies there as a whole.
const ROUNDING = 1e-3;

/// Most steps of a ray in a slab: more than any image is wide.
const MAX_STEPS = 65535u;

/// Steps over which the ray moves by a pixel at most: the first surface before which it
/// was and behind which it is. `empty`: share of the way in which no surface around lies: the
/// steps in it are left out.
fn stepped(ray: Ray, slab: u32, near: f32, far: f32, empty: f32, leaves: bool) -> f32 {
    let steps = ceil(max(0.5 * length(ray.v) * (far - near), 1.0));
    let step = (far - near) * (1.0 / steps);
    // Step i meets nothing that is farther than near + (i + 1) step. A hundredth of a step is
    // more than what that is rounded by.
    let first = ceil(empty * steps - 1.01);
    let reach = 0.5 * step + ROUNDING;
    for (var i = u32(clamp(first, 0.0, steps)); i < min(u32(steps), MAX_STEPS); i++) {
        let c = near + (f32(i) + 0.5) * step;
        let height = surface_c(at(ray, c), slab, leaves);
        if height <= c + reach {
            return max(height, c - 0.5 * step);
        }
    }
    return 0.5 * (near + far);
}

// ---- what it finds there: sections 4.4 and 5 ----

/// One of the slab arrays over the cone at position p. A ray without width takes a texel.
fn over_cone(array: texture_2d_array<f32>, p: vec2f, slab: u32, c: f32) -> vec4f {
    if params.cone_per_coc == 0.0 {
        return textureLoad(array, vec2i(p), slab, 0);
    }
    // No wider than the gaps across the ellipse, so that it stays as narrow as it is.
    let diameter = params.cone_per_coc * least_diameter_px(lens, c);
    let uv = p * (1.0 / vec2f(textureDimensions(array)));
    return textureSampleLevel(array, linear_clamp, uv, slab, log2(max(diameter, 1.0)));
}

/// Radiance times coverage, and coverage, of the slab where the ray is at c.
///
/// With shading by the lens point, the slab's own radiance, which its mipmap filters over the
/// cone, is kept, and what is shaded per ray is only by how much the lens point sees another
/// radiance than the lens's centre: rays that shade all of it show as noise what the mipmap
/// has filtered. Both of that difference are shaded as rough as the normals over the cone are
/// spread: a reflection that is narrower falls between the rays.
fn seen(ray: Ray, slab: u32, c: f32, rays: Rays) -> vec4f {
    var p = at(ray, c);
    if rays.leave {
        if !in_frame(p) {
            return vec4f(0.0);
        }
        p = on_image(p);
    }
    let part = over_cone(slab_color, p, slab, c);
    if !rays.shade || part.a <= 0.0 {
        return part;
    }
    let normal = over_cone(slab_normal, p, slab, c) / part.a;
    let length2 = dot(normal.xyz, normal.xyz);
    if length2 < 1e-4 {
        return part;
    }
    let base = over_cone(slab_base, p, slab, c) / part.a;
    let depth_m = params.near_m / max((lens.k_px - c) / lens.slope_px, 1e-9);
    let position = vec3f((p - params.axis) * vec2f(1.0, -1.0) / params.focal_px, -1.0) * depth_m;
    let roughness = rougher(base.a, length2);
    let point = SurfacePoint(position, normal.xyz * inverseSqrt(length2), base.rgb, normal.a, roughness, vec3f(0.0));
    let shift = shaded(point, vec3f(ray.v * vec2f(1.0, -1.0) * params.lens_radius_m, 0.0)) - shaded(point, vec3f(0.0));
    return vec4f(part.rgb + shift * part.a, part.a);
}

/// Roughness of a surface over a footprint, from the squared length of its mean normal: for
/// small angles 1 minus that length is the variance of the normals per axis, and the square of
/// GGX's alpha is twice the variance of slopes (after Toksvig, "Mipmapping normal maps", 2005).
fn rougher(roughness: f32, length2: f32) -> f32 {
    let alpha = roughness * roughness;
    return sqrt(sqrt(alpha * alpha + 2.0 * (1.0 - sqrt(min(length2, 1.0)))));
}

/// What the point shows an eye.
fn shaded(point: SurfacePoint, eye: vec3f) -> vec3f {
    let seen = facing(point, eye);
    var radiance = from_environment(environment, point, seen);
    for (var i = 0u; i < environment.light_count; i++) {
        radiance += from_light(lights[i], point, seen);
    }
    return radiance;
}

/// What the ray crosses of sheets up to CoC radius s, times what of it had come so far.
fn cross_sheets(ray: ptr<function, SheetRay>, s: f32) -> vec4f {
    var sum = vec4f(0.0);
    for (var i = 0u; i < MOST_CROSSINGS && (*ray).s < (*ray).end_s; i++) {
        let crossing = next_sheet(ray, lens, s);
        if crossing.light.a <= 0.0 {
            break;
        }
        sum += crossing.light;
    }
    return sum;
}

/// What the rays of a tile have in common.
struct Rays {
    /// Whether any may come beside the image.
    leave: bool,
    /// Whether they shade.
    shade: bool,
    /// Whether they can meet sheets, and which.
    meet_sheets: bool,
    sheets: vec2f,
}

/// Radiance times weight, and weight in [0, 1], along the ray through point `k` of those that
/// slabs were looked up for.
fn trace(ray: Ray, k: u32, rays: Rays) -> vec4f {
    var frame = vec2f(-EMPTY_C, EMPTY_C);
    if rays.leave {
        frame = over_frame(ray);
    }
    var sum = vec4f(0.0);
    var past_sheets = sheet_ray(ray.pixel - params.frame_low, ray.v, rays.sheets);
    // What sheets bring: in front of what is not yet covered.
    var of_sheets = vec4f(0.0);
    var left = slabs_by_point[k];
    while left != 0u {
        let slab = firstTrailingBit(left);
        left &= left - 1u;
        let range = slab_bounds[slab];
        let near = max(range.x, frame.x);
        let far = min(range.y, frame.y);
        if near > far {
            continue;
        }
        var c: f32;
        if params.false_position != 0u {
            c = false_position(ray, slab, near, far, rays.leave);
        } else {
            let empty = select(empty_share[slab * POINTS_AT_ONCE + k], 0.0, rays.leave);
            c = stepped(ray, slab, near, far, empty, rays.leave);
        }
        let part = seen(ray, slab, c, rays);
        if part.a <= 0.0 {
            continue;
        }
        // Only in front of what is met: where a search for sheets ends, it may miss one.
        if rays.meet_sheets {
            of_sheets += (1.0 - sum.a) * cross_sheets(&past_sheets, 0.5 * c);
        }
        // Section 4.4 has v1 c1 + (1 - v1) rest. Surfaces cut by a slab's bound cover
        // disjoint parts of the cone: their coverages add up instead of multiplying.
        let free = 1.0 - sum.a;
        var share = select(1.0, free, params.over != 0u);
        if params.over == 0u && part.a > free {
            share = free / part.a;
        }
        sum += vec4f(past_sheets.left * part.rgb, part.a) * share;
        if sum.a > 0.998 {
            break;
        }
    }
    if rays.meet_sheets {
        of_sheets += (1.0 - sum.a) * cross_sheets(&past_sheets, GREATEST_SHEET_S);
    }
    // A ray that finds no solid surface counts as far as sheets cover.
    return vec4f(sum.rgb + of_sheets.rgb, sum.a + (1.0 - sum.a) * of_sheets.a);
}

// ---- which slabs can be hit at all: the N-buffer, section 4.3 ----

/// Lens points for which slabs are looked up at a time: one an invocation.
const POINTS_AT_ONCE = 64u;
const MOST_SLABS = 16u;

/// Nearest and farthest c that each slab really holds; the first is greater for an empty one.
var<workgroup> slab_bounds: array<vec2f, MOST_SLABS>;
/// The slabs that rays through each of the points may hit, a bit each.
var<workgroup> slabs_by_point: array<u32, POINTS_AT_ONCE>;
/// By slab and point: how much of their way through it lies before the nearest surface there.
var<workgroup> empty_share: array<f32, MOST_SLABS * POINTS_AT_ONCE>;
/// The slabs that any ray of the tile may hit.
var<workgroup> slabs_of_tile: atomic<u32>;
/// Whether any ray may come beside the image.
var<workgroup> any_leaves: atomic<u32>;

/// Nearest and farthest c that the slab really holds.
fn bounds(slab: u32) -> vec2f {
    let bits = content[slab];
    if bits.x == 0u {
        return vec2f(EMPTY_C, -EMPTY_C);
    }
    return vec2f(coc_diameter_px(lens, bitcast<f32>(bits.x - 1u)), coc_diameter_px(lens, bitcast<f32>(bits.y)));
}

/// The rectangle, least and greatest position, that rays of the tile at `corner` cross between two
/// c of `range`, through any point of a cell.
fn crossed(corner: vec2f, cell: vec4f, range: vec2f) -> vec4f {
    let middle = 0.5 * (cell.xy + cell.zw);
    let half_cell = 0.5 * (cell.zw - cell.xy);
    let begin = corner - astigmatic_offset_px(lens, middle);
    let near = begin - 0.5 * range.x * middle;
    let far = begin - 0.5 * range.y * middle;
    // Astigmatism turns and mirrors a point and stretches it by no more than its amount.
    let coc_px = max(abs(range.x), abs(range.y));
    let spread = 0.5 * (coc_px * half_cell + abs(lens.astigmatism_px) * length(half_cell));
    return vec4f(min(near, far) - spread, max(near, far) + spread + f32(TILE));
}

/// How far from where a ray is it reads, px.
fn read_margin_px(range: vec2f) -> f32 {
    let coc_px = max(greatest_diameter_px(lens, range.x), greatest_diameter_px(lens, range.y));
    let widest = f32(1u << (textureNumLevels(slab_color) - 1u));
    // Of the level above a cone's width, whose texels are up to twice as wide, the two that
    // are next to it reach up to one and a half away.
    return 1.5 * clamp(2.0 * params.cone_per_coc * coc_px, 1.0, widest);
}

/// Greatest z of a slab in a rectangle of the image, less than 0 where there is nothing.
fn nearest_z(slab: u32, low: vec2f, high: vec2f) -> f32 {
    let block = f32(params.block_px);
    let end = vec2i(params.blocks) - 1;
    let first = clamp(vec2i(floor(low / block)), vec2i(0), end);
    let last = clamp(vec2i(floor(high / block)), vec2i(0), end);
    // Four windows that overlap make any square up to twice their side.
    let side = max(last.x - first.x, last.y - first.y) + 1;
    let level = firstLeadingBit(u32(side));
    let second = max(last + 1 - (1i << level), vec2i(0));
    let base = (level * params.slab_count + slab) * params.blocks.y;
    let top = (base + u32(first.y)) * params.blocks.x;
    let bottom = (base + u32(second.y)) * params.blocks.x;
    let left = max(n_buffer[top + u32(first.x)], n_buffer[bottom + u32(first.x)]);
    let right = max(n_buffer[top + u32(second.x)], n_buffer[bottom + u32(second.x)]);
    return max(left, right);
}

/// Greatest z of a slab that rays of the tile at `corner` through a cell of the lens may meet, less than
/// 0 where there is nothing.
fn nearest_met(slab: u32, corner: vec2f, cell: vec4f) -> f32 {
    let range = slab_bounds[slab];
    let rectangle = crossed(corner, cell, range);
    let margin = read_margin_px(range);
    let low = clamp(rectangle.xy, params.frame_low, params.frame_high) - margin;
    let high = clamp(rectangle.zw, params.frame_low, params.frame_high) + margin;
    return nearest_z(slab, low, high);
}

/// Whether those rays may come beside the image.
fn may_leave(slab: u32, corner: vec2f, cell: vec4f) -> bool {
    let range = slab_bounds[slab];
    let rectangle = crossed(corner, cell, range);
    let margin = read_margin_px(range);
    return any(rectangle.xy < params.frame_low + margin) || any(rectangle.zw > params.frame_high - margin);
}

/// Looks up whether rays of the tile at `corner` may hit a slab at all, and may leave the image.
fn find_slab(slab: u32, corner: vec2f) {
    let range = bounds(slab);
    slab_bounds[slab] = range;
    if range.x > range.y {
        return;
    }
    let whole = vec4f(-params.greatest_v, -params.greatest_v, params.greatest_v, params.greatest_v);
    if params.culling == 0u || may_leave(slab, corner, whole) {
        atomicStore(&any_leaves, 1u);
    }
    if params.culling == 0u || nearest_met(slab, corner, whole) >= 0.0 {
        atomicOr(&slabs_of_tile, 1u << slab);
    }
}

/// Least and greatest point of a cell.
fn cell_of(point: u32) -> vec4f {
    let first = params.samples * params.sets + 2u * point;
    return vec4f(lens_points[first], lens_points[first + 1u]);
}

/// Looks up which of the tile's slabs its rays through the points of cell `point` may hit.
fn find_slabs(k: u32, point: u32, corner: vec2f) {
    var found = 0u;
    var left = atomicLoad(&slabs_of_tile);
    while left != 0u {
        let slab = firstTrailingBit(left);
        left &= left - 1u;
        var empty = 0.0;
        if params.culling != 0u {
            let z = nearest_met(slab, corner, cell_of(point));
            if z < 0.0 {
                continue;
            }
            let range = slab_bounds[slab];
            empty = (coc_diameter_px(lens, z) - ROUNDING - range.x) / max(range.y - range.x, 1e-6);
        }
        empty_share[slab * POINTS_AT_ONCE + k] = empty;
        found |= 1u << slab;
    }
    slabs_by_point[k] = found;
}

/// The values at index `i` of four, without an array that is indexed at run time.
fn one_of(four: vec4f, i: u32) -> f32 {
    let pair = select(four.xy, four.zw, i >= 2u);
    return select(pair.x, pair.y, (i & 1u) != 0u);
}

/// Traces a tile; `has_more`: rays may shade or meet sheets.
fn traced(tile: vec2u, local: vec2u, has_more: bool) {
    let id = tile * TILE + local;
    let index = local.y * TILE + local.x;
    let corner = params.origin + vec2f(tile * TILE);
    if index == 0u {
        atomicStore(&slabs_of_tile, 0u);
        atomicStore(&any_leaves, 0u);
    }
    workgroupBarrier();
    if index < min(params.slab_count, MOST_SLABS) {
        find_slab(index, corner);
    }
    workgroupBarrier();
    let pixel = params.origin + vec2f(id) + 0.5;
    let noise = hash(id.x + hash(id.y));
    let of_sets = noise % params.sets;
    // Section 4.5: four values make 16 pairs, each for a sixteenth of the lens points.
    let four = params.jitter * (vec4f(vec4u(noise, noise >> 8u, noise >> 16u, noise >> 24u) & vec4u(255u)) / 127.5 - 1.0);
    var rays = Rays(atomicLoad(&any_leaves) != 0u, has_more && params.shading != 0u, false, vec2f(1.0, -1.0));
    if has_more {
        rays.sheets = sheet_bounds_of(tile.y * ((textureDimensions(result).x + TILE - 1u) / TILE) + tile.x);
        rays.meet_sheets = rays.sheets.x <= rays.sheets.y;
    }
    var sum = vec4f(0.0);
    for (var begin = 0u; begin < params.samples; begin += POINTS_AT_ONCE) {
        workgroupBarrier();
        if begin + index < params.samples {
            find_slabs(index, begin + index, corner);
        }
        workgroupBarrier();
        let count = min(params.samples - begin, POINTS_AT_ONCE);
        for (var k = 0u; k < count; k++) {
            let i = begin + k;
            var v = lens_points[i * params.sets + of_sets];
            if params.jitter != 0.0 {
                let pair = i * 16u / params.samples;
                v += vec2f(one_of(four, pair & 3u), one_of(four, pair >> 2u));
            }
            var begins = pixel;
            if lens.astigmatism_px != 0.0 {
                begins -= astigmatic_offset_px(lens, v);
            }
            sum += trace(Ray(begins, v), k, rays);
        }
    }
    if any(id >= textureDimensions(result)) {
        return;
    }
    // Rays that leave the frame find nothing: the others stand for them. Where all leave
    // it, the pinhole image is the best guess.
    var color = max(sum.rgb, vec3f(0.0)) / max(sum.a, 1e-6);
    if sum.a < 1e-3 {
        color = textureLoad(pinhole, vec2i(pixel - params.frame_low), 0).rgb;
    }
    textureStore(result, id, vec4f(color, 1.0));
}

@compute @workgroup_size(8, 8)
fn trace_tiles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = listed_tile(group);
    if is_tile(tile) {
        traced(tile, local.xy, false);
    }
}

/// With rays that shade, or that cross sheets.
@compute @workgroup_size(8, 8)
fn trace_tiles_with_more(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = listed_tile(group);
    if is_tile(tile) {
        traced(tile, local.xy, true);
    }
}
