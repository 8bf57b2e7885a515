// Surfaces of a scene: their materials, what is seen of them, and to which layer they belong
// (src/view/pipelines.rs). scene.wgsl draws them.

#import color
#import shading

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
