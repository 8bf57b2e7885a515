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

#import hash
#import lens
#import shading
#import sheet_rays
#import tile_lists

struct Params {
    /// For each slab: side of the square that its rays cross around a pixel, and of the
    /// windows that its N-buffer holds, px.
    windows: array<vec4u, 16>,
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
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> params: Params;
@group(0) @binding(2) var slab_color: texture_2d_array<f32>;
@group(0) @binding(3) var slab_depth: texture_2d_array<f32>;
@group(0) @binding(4) var n_buffer: texture_2d_array<f32>;
@group(0) @binding(5) var linear_clamp: sampler;
@group(0) @binding(6) var<storage, read> content: array<vec2u>;
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

/// c of the slab's surface under a position, EMPTY_C without one.
fn surface_c(p: vec2f, slab: u32) -> f32 {
    if !in_frame(p) {
        return EMPTY_C;
    }
    let z = textureLoad(slab_depth, vec2i(on_image(p)), slab, 0).r;
    return select(coc_diameter_px(lens, z), EMPTY_C, z < 0.0);
}

// ---- where a ray meets a slab ----

/// Nearest and farthest c that the slab really holds.
fn bounds(slab: u32) -> vec2f {
    let bits = content[slab];
    return vec2f(coc_diameter_px(lens, bitcast<f32>(bits.x - 1u)), coc_diameter_px(lens, bitcast<f32>(bits.y)));
}

/// Method of false position (section 4.3, Fig. 5): the surface between two points of the
/// ray is taken as straight. It starts between the slab's bounds, as if the surface lay at
/// the far one where the ray enters and at the near one where it leaves.
fn false_position(ray: Ray, slab: u32, near: f32, far: f32) -> f32 {
    var low = near;
    var low_height = far;
    var high = far;
    var high_height = near;
    var c = 0.5 * (near + far);
    for (var i = 0u; i < 3u; i++) {
        let height = surface_c(at(ray, c), slab);
        if height == EMPTY_C {
            if i > 0u {
                break;
            }
            // Only now are the ends looked up; an empty one keeps the bound with which the
            // intersection stays in the slab.
            let entry = surface_c(at(ray, near), slab);
            let exit = surface_c(at(ray, far), slab);
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
/// was and behind which it is.
fn stepped(ray: Ray, slab: u32, near: f32, far: f32) -> f32 {
    let steps = ceil(max(0.5 * length(ray.v) * (far - near), 1.0));
    let step = (far - near) / steps;
    for (var i = 0u; i < min(u32(steps), MAX_STEPS); i++) {
        let c = near + (f32(i) + 0.5) * step;
        let height = surface_c(at(ray, c), slab);
        if height <= c + 0.5 * step + ROUNDING {
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
    let uv = p / vec2f(textureDimensions(array));
    return textureSampleLevel(array, linear_clamp, uv, slab, log2(max(diameter, 1.0)));
}

/// Radiance times coverage, and coverage, of the slab where the ray is at c.
///
/// With shading by the lens point, the slab's own radiance, which its mipmap filters over the
/// cone, is kept, and what is shaded per ray is only by how much the lens point sees another
/// radiance than the lens's centre: rays that shade all of it show as noise what the mipmap
/// has filtered. Both of that difference are shaded as rough as the normals over the cone are
/// spread: a reflection that is narrower falls between the rays.
fn seen(ray: Ray, slab: u32, c: f32) -> vec4f {
    let place = at(ray, c);
    if !in_frame(place) {
        return vec4f(0.0);
    }
    let p = on_image(place);
    let part = over_cone(slab_color, p, slab, c);
    if params.shading == 0u || part.a <= 0.0 {
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

/// Radiance times weight, and weight in [0, 1], along a ray; `slabs` are those that may
/// be hit, a bit each.
fn trace(ray: Ray, slabs: u32, sheets: vec2f) -> vec4f {
    let frame = over_frame(ray);
    var sum = vec4f(0.0);
    var past_sheets = sheet_ray(ray.pixel - params.frame_low, ray.v, sheets);
    // What sheets bring: in front of what is not yet covered.
    var of_sheets = vec4f(0.0);
    var left = slabs;
    while left != 0u {
        let slab = firstTrailingBit(left);
        left &= left - 1u;
        let range = bounds(slab);
        let near = max(range.x, frame.x);
        let far = min(range.y, frame.y);
        if near > far {
            continue;
        }
        var c: f32;
        if params.false_position != 0u {
            c = false_position(ray, slab, near, far);
        } else {
            c = stepped(ray, slab, near, far);
        }
        let in_front = cross_sheets(&past_sheets, 0.5 * c);
        of_sheets += (1.0 - sum.a) * in_front;
        let part = seen(ray, slab, c);
        let through = past_sheets.left;
        // Section 4.4 has v1 c1 + (1 - v1) rest. Surfaces cut by a slab's bound cover
        // disjoint parts of the cone: their coverages add up instead of multiplying.
        if params.over != 0u {
            let share = 1.0 - sum.a;
            sum += vec4f(through * part.rgb, part.a) * share;
        } else if part.a > 0.0 {
            let share = min(part.a, 1.0 - sum.a) / part.a;
            sum += vec4f(through * part.rgb, part.a) * share;
        }
        if sum.a > 0.998 {
            break;
        }
    }
    of_sheets += (1.0 - sum.a) * cross_sheets(&past_sheets, GREATEST_SHEET_S);
    // A ray that finds no solid surface counts as far as sheets cover.
    return vec4f(sum.rgb + of_sheets.rgb, sum.a + (1.0 - sum.a) * of_sheets.a);
}

// ---- which slabs can be hit at all: the N-buffer, section 4.3 ----

fn nearest_z(corner: vec2i, slab: u32) -> f32 {
    return textureLoad(n_buffer, clamp(corner, vec2i(0), vec2i(textureDimensions(n_buffer)) - 1), slab, 0).r;
}

fn may_hit(pixel: vec2i, slab: u32) -> bool {
    if content[slab].x == 0u {
        return false;
    }
    if params.culling == 0u {
        return true;
    }
    // Four windows that overlap make any square up to twice their side.
    let side = i32(params.windows[slab].x);
    let low = pixel - side / 2;
    let high = low + side - i32(params.windows[slab].y);
    let left = max(nearest_z(low, slab), nearest_z(vec2i(low.x, high.y), slab));
    let right = max(nearest_z(vec2i(high.x, low.y), slab), nearest_z(high, slab));
    return max(left, right) >= 0.0;
}

@compute @workgroup_size(8, 8)
fn trace_tiles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile = listed_tile(group);
    let id = tile * TILE + local.xy;
    if !is_tile(tile) || any(id >= textureDimensions(result)) {
        return;
    }
    let pixel = params.origin + vec2f(id) + 0.5;
    var slabs = 0u;
    for (var i = 0u; i < params.slab_count; i++) {
        if may_hit(vec2i(pixel), i) {
            slabs |= 1u << i;
        }
    }
    let noise = hash(id.x + hash(id.y));
    let first = (noise % params.sets) * params.samples;
    // Section 4.5: four values make 16 pairs, each for a sixteenth of the lens points.
    let four = params.jitter * (vec4f(vec4u(noise, noise >> 8u, noise >> 16u, noise >> 24u) & vec4u(255u)) / 127.5 - 1.0);
    let sheets = sheet_bounds_of(tile.y * ((textureDimensions(result).x + TILE - 1u) / TILE) + tile.x);
    var sum = vec4f(0.0);
    for (var i = 0u; i < params.samples; i++) {
        let pair = i * 16u / params.samples;
        let v = lens_points[first + i] + vec2f(four[pair & 3u], four[pair >> 2u]);
        sum += trace(Ray(pixel - astigmatic_offset_px(lens, v), v), slabs, sheets);
    }
    // Rays that leave the frame find nothing: the others stand for them. Where all leave
    // it, the pinhole image is the best guess.
    var color = max(sum.rgb, vec3f(0.0)) / max(sum.a, 1e-6);
    if sum.a < 1e-3 {
        color = textureLoad(pinhole, vec2i(pixel - params.frame_low), 0).rgb;
    }
    textureStore(result, id, vec4f(color, 1.0));
}
