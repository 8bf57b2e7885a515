// The scene rasteriser: colour and stored depth of a layer of surfaces.
//
// Everything is in view space (right, up, backwards; metres), brought there in f64 by the
// CPU, so that a camera far from the origin is as steady as one at it. The CPU ray tracer
// derives the shading of lib/shading.wgsl independently.

#import color
#import shading
#import thresholds

struct View {
    /// Reversed, infinite depth; sheared for a lens point (src/camera.rs).
    clip_from_view: mat4x4f,
    environment: Environment,
    /// Position that shading looks from: the lens centre, or the lens point if what a
    /// surface emits is to depend on the view.
    shading_eye: vec3f,
    /// Fragments whose stored depth z lies outside [z_far, z_near] are not in the layer.
    z_near: f32,
    z_far: f32,
    /// Texels of the targets a pixel on each side.
    texels_a_side: f32,
    /// Which of the texels of `below` under a texel of the targets counts, and how many there are
    /// on each side.
    below_part: vec2u,
    below_texels: u32,
    /// Number of the lens point that is looked from: which part of a sheet covers.
    lens_point: u32,
    /// What becomes of colours before anything is blurred (src/view/tone.rs): 0 nothing, 1 they
    /// are cut at `tone_scale`, 2 Reinhard's curve over `tone_scale` times their luminance.
    tone: u32,
    tone_scale: f32,
}

struct Material {
    base_color: vec4f,
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    alpha_cutoff: f32,
    /// Share of light that passes through a sheet.
    transmission: f32,
    /// 1: alpha is coverage.
    blended: u32,
    /// Texture transforms, two rows each: base colour, metallic-roughness, normal, emissive,
    /// transmission. The first row's w is 1 where the texture is looked up by the second
    /// coordinates.
    uv_rows: array<vec4f, 10>,
}

// Constants of a pipeline and not of a buffer: software adapters execute both sides of a
// branch, and an anisotropic read is costly.

/// Bit k: the material has texture k of the list below.
override TEXTURES: u32 = 31u;
/// Whether surfaces show their base colour, whatever the light.
override UNLIT: bool = false;
/// Whether the targets have several texels a pixel.
override FINE: bool = false;

const BASE_COLOR = 0u;
const METALLIC_ROUGHNESS = 1u;
const NORMAL = 2u;
const EMISSIVE = 3u;
const TRANSMISSION = 4u;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
/// Per pixel, the layer holds what is farther than this stored depth (z below it).
@group(0) @binding(2) var below: texture_2d<f32>;

@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(3) var normal_texture: texture_2d<f32>;
@group(1) @binding(4) var emissive_texture: texture_2d<f32>;
@group(1) @binding(5) var base_color_sampler: sampler;
@group(1) @binding(6) var metallic_roughness_sampler: sampler;
@group(1) @binding(7) var normal_sampler: sampler;
@group(1) @binding(8) var emissive_sampler: sampler;
@group(1) @binding(9) var transmission_texture: texture_2d<f32>;
@group(1) @binding(10) var transmission_sampler: sampler;

struct VertexIn {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) tangent: vec4f,
    /// First and second texture coordinates.
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    /// Rows of the instance's affine map from object to view space.
    @location(5) row_x: vec4f,
    @location(6) row_y: vec4f,
    @location(7) row_z: vec4f,
}

struct Surface {
    /// The same whichever pipeline draws it: depths of one draw are looked for in another.
    @builtin(position) @invariant clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
}

struct Layer {
    /// Linear radiance; alpha 1 where the layer has a surface.
    @location(0) color: vec4f,
    /// Stored depth z = near / d.
    @location(1) z: f32,
}

fn surface_at(in: VertexIn) -> Surface {
    let linear = transpose(mat3x3f(in.row_x.xyz, in.row_y.xyz, in.row_z.xyz));
    let position = linear * in.position + vec3f(in.row_x.w, in.row_y.w, in.row_z.w);
    // The cofactor matrix is the inverse transpose times the determinant, whose sign puts
    // normals of mirrored objects right.
    let cofactor = mat3x3f(cross(linear[1], linear[2]), cross(linear[2], linear[0]), cross(linear[0], linear[1]));
    let handedness = sign(determinant(linear));
    var out: Surface;
    out.clip = view.clip_from_view * vec4f(position, 1.0);
    out.position = position;
    out.normal = cofactor * in.normal.xyz * handedness;
    out.tangent = vec4f(linear * in.tangent.xyz, in.tangent.w * handedness);
    out.uv = in.uv;
    out.color = in.color;
    return out;
}

@vertex
fn vs_surface(in: VertexIn) -> Surface {
    return surface_at(in);
}

fn transformed_uv(uv: vec4f, slot: u32) -> vec2f {
    let p = vec3f(select(uv.xy, uv.zw, material.uv_rows[2u * slot].w > 0.5), 1.0);
    return vec2f(dot(material.uv_rows[2u * slot].xyz, p), dot(material.uv_rows[2u * slot + 1u].xyz, p));
}

/// Whether the material has that texture.
fn has(slot: u32) -> bool {
    return (TEXTURES & (1u << slot)) != 0u;
}

/// Widest footprint of a pixel, in repeats of the texture, that is filtered; over a wider
/// one any texture is its mean, which is its last level.
const WIDEST_FOOTPRINT = 16.0;

/// A texture at the level that a pixel needs.
///
/// Beside a steep triangle that reaches the near plane, the coordinates of a quad's outer
/// pixels may be infinite, and so is then the loop of an anisotropic filter in software.
/// The coarse derivatives are one for all pixels of a quad: it is dropped as a whole.
fn sample(image: texture_2d<f32>, filtering: sampler, uv: vec2f) -> vec4f {
    let right = dpdxCoarse(uv);
    let down = dpdyCoarse(uv);
    let footprint = view.texels_a_side * (abs(right) + abs(down));
    let filtered = all(footprint < vec2f(WIDEST_FOOTPRINT));
    let safe = select(vec2f(0.5), uv, filtered);
    let mean = textureLoad(image, vec2i(0), textureNumLevels(image) - 1);
    if FINE {
        let over_x = select(vec2f(0.0), view.texels_a_side * right, filtered);
        let over_y = select(vec2f(0.0), view.texels_a_side * down, filtered);
        return select(mean, textureSampleGrad(image, filtering, safe, over_x, over_y), filtered);
    }
    return select(mean, textureSample(image, filtering, safe), filtered);
}

fn base_color(in: Surface) -> vec4f {
    var base = material.base_color * in.color;
    if has(BASE_COLOR) {
        base *= sample(base_color_texture, base_color_sampler, transformed_uv(in.uv, BASE_COLOR));
    }
    return base;
}

fn shading_normal(in: Surface, front: bool) -> vec3f {
    let toward_eye = unit(-in.position, vec3f(0.0, 0.0, 1.0));
    var normal = unit(in.normal, toward_eye);
    if has(NORMAL) {
        let texel = sample(normal_texture, normal_sampler, transformed_uv(in.uv, NORMAL)).xyz * 2.0 - 1.0;
        if dot(in.tangent.xyz, in.tangent.xyz) > 1e-20 {
            let tangent = unit(in.tangent.xyz, vec3f(1.0, 0.0, 0.0));
            let bitangent = cross(normal, tangent) * in.tangent.w;
            let scaled = vec3f(texel.xy * material.normal_scale, texel.z);
            normal = unit(tangent * scaled.x + bitangent * scaled.y + normal * scaled.z, normal);
        }
    }
    return select(-normal, normal, front);
}

fn surface_point(in: Surface, front: bool, base: vec4f) -> SurfacePoint {
    let normal = shading_normal(in, front);
    var emitted = material.emissive;
    if has(EMISSIVE) {
        emitted *= sample(emissive_texture, emissive_sampler, transformed_uv(in.uv, EMISSIVE)).rgb;
    }
    var metallic = material.metallic;
    var roughness = material.roughness;
    if has(METALLIC_ROUGHNESS) {
        let texel = sample(metallic_roughness_texture, metallic_roughness_sampler, transformed_uv(in.uv, METALLIC_ROUGHNESS));
        metallic *= texel.b;
        roughness *= texel.g;
    }
    return SurfacePoint(in.position, normal, base.rgb, metallic, roughness, emitted);
}

fn radiance(in: Surface, front: bool, base: vec4f) -> vec3f {
    if UNLIT {
        return base.rgb;
    }
    return lit(surface_point(in, front, base));
}

fn lit(point: SurfacePoint) -> vec3f {
    let seen = facing(point, view.shading_eye);
    var sum = point.emitted + from_environment(view.environment, point, seen);
    for (var i = 0u; i < view.environment.light_count; i++) {
        sum += from_light(lights[i], point, seen);
    }
    return sum;
}

fn toned(color: vec3f) -> vec3f {
    if view.tone == 1u {
        return min(color, vec3f(view.tone_scale));
    }
    if view.tone == 2u {
        let scaled = view.tone_scale * color;
        return min(scaled / (1.0 + max(luminance(scaled), 0.0)), vec3f(1.0));
    }
    return color;
}

fn layer(color: vec3f, z: f32) -> Layer {
    return Layer(vec4f(clamp(toned(color), vec3f(0.0), vec3f(MAX_F16)), 1.0), z);
}

/// What the layer lies below at a pixel: a stored depth.
fn limit_at(pixel: vec4f) -> f32 {
    let texel = view.below_texels * vec2u(pixel.xy) + view.below_part;
    return textureLoad(below, min(texel, textureDimensions(below) - 1u), 0).r;
}

/// Whether a fragment at this pixel and stored depth belongs to the layer.
fn in_layer(pixel: vec4f) -> bool {
    return pixel.z >= view.z_far && pixel.z <= view.z_near && pixel.z < limit_at(pixel);
}

/// Whether any fragment of a quad is one that counts: all of the quad has to be shaded then,
/// for the derivatives of texture coordinates.
fn any_of_quad(counts: bool) -> bool {
    let own = select(0.0, 1.0, counts);
    let of_row = max(own, abs(dpdxFine(own)));
    return max(of_row, abs(dpdyFine(of_row))) > 0.0;
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
