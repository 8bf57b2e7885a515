// The scene rasteriser: colour and stored depth of a layer of surfaces.
//
// Everything is in view space (right, up, backwards; metres), brought there in f64 by the
// CPU, so that a camera far from the origin is as steady as one at it. The CPU ray tracer
// derives the shading of lib/shading.wgsl independently.

#import scene_surface
#import thresholds

@vertex
fn vs_surface(in: VertexIn) -> Surface {
    return surface_at(in);
}

/// Opaque surfaces of the nearest layer: no fragment is dropped.
@fragment
fn fs_opaque(in: Surface, @builtin(front_facing) front: bool) -> Layer {
    return layer(radiance(in, front, base_color(in)), in.clip.z);
}

/// Alpha-masked surfaces of the nearest layer.
@fragment
fn fs_masked(in: Surface, @builtin(front_facing) front: bool) -> Layer {
    let base = base_color(in);
    let color = radiance(in, front, base);
    if base.a < material.alpha_cutoff {
        discard;
    }
    return layer(color, in.clip.z);
}

/// Surfaces, opaque or masked, of a farther layer or a slab.
@fragment
fn fs_layer(in: Surface, @builtin(front_facing) front: bool) -> Layer {
    let belongs = in_layer(in.clip);
    if !any_of_quad(belongs) {
        discard;
    }
    let base = base_color(in);
    let color = radiance(in, front, base);
    if base.a < material.alpha_cutoff || !belongs {
        discard;
    }
    return layer(color, in.clip.z);
}

// ---- sheets: surfaces that cover a part of what lies behind them (src/scene/mod.rs) ----

struct Sheet {
    @builtin(position) @invariant clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(5) @interpolate(flat) instance: u32,
}

@vertex
fn vs_sheet(in: VertexIn, @builtin(instance_index) instance: u32) -> Sheet {
    let at = surface_at(in);
    return Sheet(at.clip, at.position, at.normal, at.tangent, at.uv, at.color, instance);
}

/// Radiance of what is seen of a sheet, and its coverage: `Material::is_sheet`.
fn sheet_seen(in: Surface, front: bool) -> vec4f {
    let base = base_color(in);
    let alpha = select(select(1.0, base.a, material.blended != 0u), 0.0, base.a < material.alpha_cutoff);
    var passes = material.transmission * (base.r + base.g + base.b) / 3.0;
    if has(TRANSMISSION) {
        passes *= sample(transmission_texture, transmission_sampler, transformed_uv(in.uv, TRANSMISSION)).r;
    }
    if UNLIT {
        return vec4f(base.rgb, clamp(alpha * (1.0 - passes), 0.0, 1.0));
    }
    var point = surface_point(in, front, base);
    passes = clamp(passes * (1.0 - point.metallic), 0.0, 1.0);
    let mirrors = passes * (0.04 + 0.96 * pow(1.0 - facing(point, view.shading_eye).n_dot_v, 5.0));
    let covers = 1.0 - passes + mirrors;
    let mirror_share = mirrors / max(covers, 1e-6);
    point.base_color = mix(point.base_color, vec3f(1.0), mirror_share);
    point.metallic = mix(point.metallic, 1.0, mirror_share);
    return vec4f(lit(point), clamp(alpha * covers, 0.0, 1.0));
}

fn surface_of(in: Sheet) -> Surface {
    return Surface(in.clip, in.position, in.normal, in.tangent, in.uv, in.color);
}

/// Sheets as solid surfaces that are there or not, by chance: the mean over lens points is right.
@fragment
fn fs_sampled_sheet(in: Sheet, @builtin(front_facing) front: bool) -> Layer {
    let seen = sheet_seen(surface_of(in), front);
    if seen.a <= threshold(vec2u(in.clip.xy), 2u * in.instance + u32(front), in.clip.z, view.lens_point) {
        discard;
    }
    return layer(seen.rgb, in.clip.z);
}

/// Coverage below which a sheet counts as not there: half of what 8 bits of alpha tell apart.
const LEAST_COVERAGE = 1.0 / 512.0;

/// Sheets that lie below a bound, with their coverage as alpha.
@fragment
fn fs_sheet(in: Sheet, @builtin(front_facing) front: bool) -> Layer {
    let belongs = in_layer(in.clip);
    if !any_of_quad(belongs) {
        discard;
    }
    let seen = sheet_seen(surface_of(in), front);
    if seen.a < LEAST_COVERAGE || !belongs {
        discard;
    }
    return Layer(vec4f(layer(seen.rgb, 0.0).color.rgb, seen.a), in.clip.z);
}

// ---- surfaces with what they are made of, for a method that looks from many eyes ----

struct Attributes {
    /// As `Layer::color`: what the lens's centre sees.
    @location(0) color: vec4f,
    @location(1) z: f32,
    /// Base colour, roughness.
    @location(2) base_roughness: vec4f,
    /// Normal, metallic; a normal of 0 where light plays no part.
    @location(3) normal_metallic: vec4f,
}

fn unshaded(color: vec3f, z: f32) -> Attributes {
    let seen = layer(color, z);
    return Attributes(seen.color, z, vec4f(0.0), vec4f(0.0));
}

@fragment
fn fs_attributes(in: Surface, @builtin(front_facing) front: bool) -> Attributes {
    let belongs = in_layer(in.clip);
    if !any_of_quad(belongs) {
        discard;
    }
    let base = base_color(in);
    var point = SurfacePoint(in.position, vec3f(0.0), vec3f(0.0), 0.0, 0.0, base.rgb);
    var color = base.rgb;
    if !UNLIT {
        point = surface_point(in, front, base);
        color = lit(point);
    }
    if base.a < material.alpha_cutoff || !belongs {
        discard;
    }
    let seen = layer(color, in.clip.z).color;
    let base_roughness = vec4f(point.base_color, point.roughness);
    return Attributes(seen, in.clip.z, base_roughness, vec4f(point.normal, point.metallic));
}

// ---- what is seen where nothing is: the environment, at infinity ----

struct Sky {
    @builtin(position) clip: vec4f,
    @location(0) ndc: vec2f,
}

@vertex
fn vs_sky(@builtin(vertex_index) index: u32) -> Sky {
    let ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Sky(vec4f(ndc, 0.0, 1.0), ndc);
}

fn sky_color(in: Sky) -> vec3f {
    // At infinity only the direction counts: x_ndc = sx * x/d + shear.
    let m = view.clip_from_view;
    let slope = vec2f((in.ndc.x + m[2][0]) / m[0][0], (in.ndc.y + m[2][1]) / m[1][1]);
    return environment_radiance(view.environment, normalize(vec3f(slope, -1.0)));
}

@fragment
fn fs_sky(in: Sky) -> Layer {
    return layer(sky_color(in), 0.0);
}

@fragment
fn fs_sky_layer(in: Sky) -> Layer {
    if !in_layer(vec4f(in.clip.xy, 0.0, 1.0)) {
        discard;
    }
    return layer(sky_color(in), 0.0);
}

@fragment
fn fs_sky_attributes(in: Sky) -> Attributes {
    if !in_layer(vec4f(in.clip.xy, 0.0, 1.0)) {
        discard;
    }
    return unshaded(sky_color(in), 0.0);
}

// ---- many slabs at once: their depths, then what is there ----

struct SlabDraw {
    /// Greatest and least stored depth of each slab, both included; both fall from slab to slab.
    ranges: array<vec4f, 16>,
    /// Size of the arrays, and texels left of and above the frame in them.
    size: vec2u,
    padding: vec2u,
    /// Layer of the first slab, and how many there are.
    first: u32,
    count: u32,
}

@group(2) @binding(0) var<uniform> slabs: SlabDraw;
/// By slab and texel: bits of the greatest z plus 1, 0 where nothing was found.
@group(2) @binding(1) var<storage, read_write> nearest: array<atomic<u32>>;
/// Stored depth of what was found.
@group(2) @binding(1) var slab_depths: texture_2d_array<f32>;
@group(2) @binding(2) var slab_color: texture_storage_2d_array<rgba16float, write>;
@group(2) @binding(3) var slab_base: texture_storage_2d_array<rgba16float, write>;
@group(2) @binding(4) var slab_normal: texture_storage_2d_array<rgba16float, write>;

/// z as it is stored: not -0, whose bits would be the greatest.
fn slab_z(pixel: vec4f) -> f32 {
    return max(pixel.z, 0.0);
}

/// The first slab that does not end before z. Those after it hold z up to the first that begins
/// behind it.
fn first_slab(z: f32) -> u32 {
    var first = 0u;
    for (var i = 0u; i < 5u; i++) {
        let next = first + (16u >> i);
        if next <= slabs.count && slabs.ranges[next - 1u].y > z {
            first = next;
        }
    }
    return first;
}

fn begins_before(i: u32, z: f32) -> bool {
    return slabs.ranges[i].x >= z;
}

fn slab_texel(pixel: vec4f) -> vec2u {
    return vec2u(pixel.xy) + slabs.padding;
}

fn mark_depth(pixel: vec4f) {
    let texel = slab_texel(pixel);
    let z = slab_z(pixel);
    for (var i = first_slab(z); i < slabs.count && begins_before(i, z); i++) {
        atomicMax(&nearest[(i * slabs.size.y + texel.y) * slabs.size.x + texel.x], bitcast<u32>(z) + 1u);
    }
}

@fragment
fn fs_slab_depths(in: Surface) {
    mark_depth(in.clip);
}

@fragment
fn fs_masked_slab_depths(in: Surface) {
    if base_color(in).a >= material.alpha_cutoff {
        mark_depth(in.clip);
    }
}

/// The slabs whose nearest surface this fragment is, a bit each.
fn slabs_of(pixel: vec4f) -> u32 {
    let z = slab_z(pixel);
    var found = 0u;
    for (var i = first_slab(z); i < slabs.count && begins_before(i, z); i++) {
        if textureLoad(slab_depths, slab_texel(pixel), slabs.first + i, 0).r == z {
            found |= 1u << i;
        }
    }
    return found;
}

fn finite_color(rgb: vec3f) -> vec3f {
    return select(vec3f(0.0), rgb, vec3<bool>(is_finite(vec3f(rgb.r)), is_finite(vec3f(rgb.g)), is_finite(vec3f(rgb.b))));
}

fn store_color(pixel: vec4f, found: u32, color: vec3f) {
    let seen = vec4f(finite_color(layer(color, 0.0).color.rgb), 1.0);
    var left = found;
    while left != 0u {
        let slab = slabs.first + firstTrailingBit(left);
        left &= left - 1u;
        textureStore(slab_color, slab_texel(pixel), slab, seen);
    }
}

@fragment
fn fs_slabs(in: Surface, @builtin(front_facing) front: bool) {
    let found = slabs_of(in.clip);
    if any_of_quad(found != 0u) {
        let base = base_color(in);
        let color = radiance(in, front, base);
        if base.a >= material.alpha_cutoff {
            store_color(in.clip, found, color);
        }
    }
}

@fragment
fn fs_slab_surfaces(in: Surface, @builtin(front_facing) front: bool) {
    let found = slabs_of(in.clip);
    if any_of_quad(found != 0u) {
        let base = base_color(in);
        var point = SurfacePoint(in.position, vec3f(0.0), vec3f(0.0), 0.0, 0.0, base.rgb);
        var color = base.rgb;
        if !UNLIT {
            point = surface_point(in, front, base);
            color = lit(point);
        }
        if base.a >= material.alpha_cutoff {
            store_color(in.clip, found, color);
            var left = found;
            while left != 0u {
                let slab = slabs.first + firstTrailingBit(left);
                left &= left - 1u;
                textureStore(slab_base, slab_texel(in.clip), slab, vec4f(point.base_color, point.roughness));
                textureStore(slab_normal, slab_texel(in.clip), slab, vec4f(point.normal, point.metallic));
            }
        }
    }
}

@fragment
fn fs_sky_slab_depths(in: Sky) {
    mark_depth(vec4f(in.clip.xy, 0.0, 1.0));
}

@fragment
fn fs_sky_slabs(in: Sky) {
    let pixel = vec4f(in.clip.xy, 0.0, 1.0);
    store_color(pixel, slabs_of(pixel), sky_color(in));
}

@fragment
fn fs_sky_slab_surfaces(in: Sky) {
    let pixel = vec4f(in.clip.xy, 0.0, 1.0);
    let found = slabs_of(pixel);
    store_color(pixel, found, sky_color(in));
    var left = found;
    while left != 0u {
        let slab = slabs.first + firstTrailingBit(left);
        left &= left - 1u;
        textureStore(slab_base, slab_texel(pixel), slab, vec4f(0.0));
        textureStore(slab_normal, slab_texel(pixel), slab, vec4f(0.0));
    }
}

// ---- where a layer is said to hold nothing: in front of everything ----

@vertex
fn vs_closed(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 1.0, 1.0);
}

@fragment
fn fs_closed(@builtin(position) pixel: vec4f) {
    if limit_at(pixel) > 0.0 {
        discard;
    }
}
