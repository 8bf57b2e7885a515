// The scene rasteriser: colour and stored depth of a layer of surfaces.
//
// Everything is in view space (right, up, backwards; metres), brought there in f64 by the
// CPU, so that a camera far from the origin is as steady as one at it. Shading is glTF 2.0
// metallic-roughness (appendix B) under punctual lights and the analytic environment that
// src/scene/mod.rs defines; the CPU ray tracer derives the same independently.

#import color

const PI = 3.14159265;

struct View {
    /// Reversed, infinite depth; sheared for a lens point (src/camera.rs).
    clip_from_view: mat4x4f,
    /// World axes in view space: columns x, y, z.
    view_from_world_x: vec4f,
    view_from_world_y: vec4f,
    view_from_world_z: vec4f,
    zenith: vec4f,
    horizon: vec4f,
    ground: vec4f,
    /// Position that shading looks from: the lens centre, or the lens point if what a
    /// surface emits is to depend on the view.
    shading_eye: vec3f,
    softbox: f32,
    /// Fragments whose stored depth z lies outside [z_far, z_near] are not in the layer.
    z_near: f32,
    z_far: f32,
    light_count: u32,
    /// 1: the base colour is what is seen, whatever the light.
    unlit: u32,
}

struct Light {
    position: vec3f,
    /// Reciprocal of the range; 0 for none.
    inverse_range: f32,
    direction: vec3f,
    /// 0 directional, 1 point, 2 spot.
    kind: u32,
    intensity: vec3f,
    cos_inner: f32,
    cos_outer: f32,
}

struct Material {
    base_color: vec4f,
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    alpha_cutoff: f32,
    unlit: u32,
    /// Texture transforms, two rows each: base colour, metallic-roughness, normal, emissive.
    uv_rows: array<vec4f, 8>,
    /// Bit k: texture k of that list is there.
    textures: u32,
}

const BASE_COLOR = 0u;
const METALLIC_ROUGHNESS = 1u;
const NORMAL = 2u;
const EMISSIVE = 3u;

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

struct VertexIn {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    @location(4) color: vec4f,
    /// Rows of the instance's affine map from object to view space.
    @location(5) row_x: vec4f,
    @location(6) row_y: vec4f,
    @location(7) row_z: vec4f,
}

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    @location(4) color: vec4f,
}

struct Layer {
    /// Linear radiance; alpha 1 where the layer has a surface.
    @location(0) color: vec4f,
    /// Stored depth z = near / d.
    @location(1) z: f32,
}

@vertex
fn vs_surface(in: VertexIn) -> Surface {
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

fn transformed_uv(uv: vec2f, slot: u32) -> vec2f {
    let p = vec3f(uv, 1.0);
    return vec2f(dot(material.uv_rows[2u * slot].xyz, p), dot(material.uv_rows[2u * slot + 1u].xyz, p));
}

/// Whether the material has that texture. Uniform over a draw, so that derivatives stay
/// defined where a missing texture's read is skipped.
fn has(slot: u32) -> bool {
    return (material.textures & (1u << slot)) != 0u;
}

fn base_color(in: Surface) -> vec4f {
    var base = material.base_color * in.color;
    if has(BASE_COLOR) {
        base *= textureSample(base_color_texture, base_color_sampler, transformed_uv(in.uv, BASE_COLOR));
    }
    return base;
}

fn unit(v: vec3f, otherwise: vec3f) -> vec3f {
    let length2 = dot(v, v);
    return select(otherwise, v * inverseSqrt(max(length2, 1e-30)), length2 > 1e-30);
}

fn shading_normal(in: Surface, front: bool) -> vec3f {
    let toward_eye = unit(-in.position, vec3f(0.0, 0.0, 1.0));
    var normal = unit(in.normal, toward_eye);
    if has(NORMAL) {
        let texel = textureSample(normal_texture, normal_sampler, transformed_uv(in.uv, NORMAL)).xyz * 2.0 - 1.0;
        if dot(in.tangent.xyz, in.tangent.xyz) > 1e-20 {
            let tangent = unit(in.tangent.xyz, vec3f(1.0, 0.0, 0.0));
            let bitangent = cross(normal, tangent) * in.tangent.w;
            let scaled = vec3f(texel.xy * material.normal_scale, texel.z);
            normal = unit(tangent * scaled.x + bitangent * scaled.y + normal * scaled.z, normal);
        }
    }
    return select(-normal, normal, front);
}

// ---- the environment (see Environment in src/scene/mod.rs) ----

fn height(direction: vec3f) -> f32 {
    return dot(direction, view.view_from_world_y.xyz);
}

fn environment_radiance(direction: vec3f) -> vec3f {
    let y = height(direction);
    if y >= 0.0 {
        return mix(view.horizon.rgb, view.zenith.rgb, y);
    }
    return mix(view.horizon.rgb, view.ground.rgb, min(-3.0 * y, 1.0));
}

fn ambient(normal: vec3f) -> vec3f {
    let low = 0.5 * (view.ground.rgb + view.horizon.rgb);
    let high = 0.5 * (view.zenith.rgb + view.horizon.rgb);
    return mix(low, high, 0.5 * (height(normal) + 1.0));
}

fn reflected(direction: vec3f, roughness: f32) -> vec3f {
    let base = mix(environment_radiance(direction), ambient(direction), roughness);
    let width = 0.02 + 0.3 * roughness;
    var boxes = 0.0;
    if view.softbox == 0.0 {
        return base;
    }
    for (var i = 0u; i < 4u; i++) {
        let sx = select(-1.0, 1.0, (i & 1u) != 0u);
        let sz = select(-0.6, 0.6, (i & 2u) != 0u);
        let world = normalize(vec3f(sx, 1.2, sz));
        let axis = view.view_from_world_x.xyz * world.x + view.view_from_world_y.xyz * world.y + view.view_from_world_z.xyz * world.z;
        boxes += smoothstep(0.9 - width, 0.9 + width, dot(direction, axis));
    }
    return base + view.softbox * boxes;
}

/// Split-sum environment BRDF, analytic fit (Karis, "Physically Based Shading on Mobile", 2014).
fn environment_brdf(f0: vec3f, roughness: f32, n_dot_v: f32) -> vec3f {
    let r = roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a004 = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
    let ab = vec2f(-1.04, 1.04) * a004 + r.zw;
    return f0 * ab.x + ab.y;
}

// ---- punctual lights (KHR_lights_punctual) ----

struct Incident {
    to_light: vec3f,
    radiance: vec3f,
}

fn incident(light: Light, position: vec3f) -> Incident {
    if light.kind == 0u {
        return Incident(-light.direction, light.intensity);
    }
    let offset = light.position - position;
    let distance2 = max(dot(offset, offset), 1e-8);
    let to_light = offset * inverseSqrt(distance2);
    let relative2 = distance2 * light.inverse_range * light.inverse_range;
    var falloff = clamp(1.0 - relative2 * relative2, 0.0, 1.0) / distance2;
    if light.kind == 2u {
        let cosine = dot(-to_light, light.direction);
        let cone = clamp((cosine - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-4), 0.0, 1.0);
        falloff *= cone * cone;
    }
    return Incident(to_light, light.intensity * falloff);
}

fn radiance(in: Surface, front: bool, base: vec4f) -> vec3f {
    if (material.unlit | view.unlit) != 0u {
        return base.rgb;
    }
    let normal = shading_normal(in, front);
    var emitted = material.emissive;
    if has(EMISSIVE) {
        emitted *= textureSample(emissive_texture, emissive_sampler, transformed_uv(in.uv, EMISSIVE)).rgb;
    }
    var metallic = material.metallic;
    var roughness = material.roughness;
    if has(METALLIC_ROUGHNESS) {
        let texel = textureSample(metallic_roughness_texture, metallic_roughness_sampler, transformed_uv(in.uv, METALLIC_ROUGHNESS));
        metallic *= texel.b;
        roughness *= texel.g;
    }
    // Below this the highlight of a punctual light is smaller than a pixel can hold.
    let alpha = pow(max(roughness, 0.045), 2.0);
    let alpha2 = alpha * alpha;
    let f0 = mix(vec3f(0.04), base.rgb, metallic);
    let diffuse_albedo = base.rgb * (1.0 - metallic);
    let to_eye = unit(view.shading_eye - in.position, normal);
    let n_dot_v = clamp(dot(normal, to_eye), 1e-4, 1.0);

    var sum = emitted;
    for (var i = 0u; i < view.light_count; i++) {
        let light = incident(lights[i], in.position);
        let n_dot_l = dot(normal, light.to_light);
        if n_dot_l <= 0.0 {
            continue;
        }
        let halfway = unit(to_eye + light.to_light, normal);
        let n_dot_h = clamp(dot(normal, halfway), 0.0, 1.0);
        let v_dot_h = clamp(dot(to_eye, halfway), 0.0, 1.0);
        let d_root = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
        let distribution = alpha2 / (PI * d_root * d_root);
        let smith_v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - alpha2) + alpha2);
        let smith_l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - alpha2) + alpha2);
        let visibility = 0.5 / max(smith_v + smith_l, 1e-6);
        let fresnel = f0 + (1.0 - f0) * pow(1.0 - v_dot_h, 5.0);
        let brdf = (1.0 - fresnel) * diffuse_albedo / PI + fresnel * (distribution * visibility);
        sum += brdf * light.radiance * n_dot_l;
    }
    let mirror = reflect(-to_eye, normal);
    sum += diffuse_albedo * ambient(normal);
    sum += environment_brdf(f0, roughness, n_dot_v) * reflected(mirror, roughness);
    return sum;
}

fn layer(color: vec3f, z: f32) -> Layer {
    return Layer(vec4f(clamp(color, vec3f(0.0), vec3f(MAX_F16)), 1.0), z);
}

/// Whether a fragment at this pixel and stored depth belongs to the layer.
fn in_layer(pixel: vec4f) -> bool {
    let at = min(vec2u(pixel.xy), textureDimensions(below) - 1u);
    return pixel.z >= view.z_far && pixel.z <= view.z_near && pixel.z < textureLoad(below, at, 0).r;
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
    let base = base_color(in);
    let color = radiance(in, front, base);
    if base.a < material.alpha_cutoff || !in_layer(in.clip) {
        discard;
    }
    return layer(color, in.clip.z);
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
    return environment_radiance(normalize(vec3f(slope, -1.0)));
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
