// scatter: depth-sorted sprites, blended over each other (src/methods/scatter.rs).
//
// Potmesil and Chakravarty, SIGGRAPH 1981.

#import spots

struct Params {
    /// Of pixels at one depth: 1 draws the right ones first.
    from_right: u32,
    /// 1 draws the lower ones first.
    from_below: u32,
    /// Number of drawing orders that the result is the mean of, reciprocal.
    weight: f32,
}

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> sprites: Sprites;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var color: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var idf_sums: texture_2d<f32>;
@group(0) @binding(6) var sum_before: texture_2d<f32>;
@group(0) @binding(7) var<storage, read_write> depth_bits: array<u32>;
@group(0) @binding(8) var<storage, read_write> pixels: array<u32>;
@group(0) @binding(9) var<storage, read> far_to_near: array<u32>;
@group(0) @binding(10) var blended: texture_2d<f32>;
@group(0) @binding(11) var sum: texture_storage_2d<rgba32float, write>;

/// Keys and values to sort: the bits of z >= 0 order as z does, farthest first.
@compute @workgroup_size(8, 8)
fn list_pixels(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(depth);
    if any(id.xy >= size) {
        return;
    }
    let p = select(id.xy, size - 1u - id.xy, vec2<bool>(params.from_right != 0u, params.from_below != 0u));
    let i = id.y * size.x + id.x;
    depth_bits[i] = bitcast<u32>(max(textureLoad(depth, p, 0).r, 0.0));
    pixels[i] = p.y * size.x + p.x;
}

struct Fragment {
    @builtin(position) at: vec4f,
    @location(0) @interpolate(flat) centre: vec2f,
    @location(1) @interpolate(flat) c: f32,
    @location(2) @interpolate(flat) color: vec3f,
}

@vertex
fn vs_sorted(@builtin(vertex_index) corner: u32, @builtin(instance_index) rank: u32) -> Fragment {
    let width = textureDimensions(depth).x;
    let p = vec2u(far_to_near[rank] % width, far_to_near[rank] / width);
    let rgb = textureLoad(color, p, 0).rgb;
    let z = textureLoad(depth, p, 0).r;
    let c = coc_diameter_px(lens, z);
    let centre = vec2f(p) + 0.5 - f32(sprites.overscan);
    let drawn = spot_corner(sprites, lens, corner, centre, c);
    return Fragment(select(NOWHERE, drawn, is_finite_source(rgb, z)), centre, c, rgb);
}

/// Premultiplied, alpha = what the pixel gets of the sprite's light.
@fragment
fn fs_over(in: Fragment) -> @location(0) vec4f {
    let alpha = spot_share(idf_sums, sprites, lens, in.at.xy - in.centre, in.c);
    if alpha <= 0.0 {
        discard;
    }
    return vec4f(in.color, 1.0) * alpha;
}

/// Black where there is nothing to divide.
fn normalised(light: vec4f) -> vec4f {
    return select(vec4f(0.0), vec4f(light.rgb / light.a, 1.0), light.a > 0.0);
}

@compute @workgroup_size(8, 8)
fn normalise_first(@builtin(global_invocation_id) id: vec3u) {
    textureStore(sum, id.xy, params.weight * normalised(textureLoad(blended, id.xy, 0)));
}

@compute @workgroup_size(8, 8)
fn normalise_next(@builtin(global_invocation_id) id: vec3u) {
    let before = textureLoad(sum_before, id.xy, 0);
    textureStore(sum, id.xy, before + params.weight * normalised(textureLoad(blended, id.xy, 0)));
}
