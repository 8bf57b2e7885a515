// The first layer from more samples than it has texels (src/view/samples.rs): the mean
// colour of each texel's surface, and what in each pixel is far brighter than white.

#import emitters
#import staggered

struct Sampling {
    /// Samples a pixel, and a texel of the layer, on each side.
    samples_a_side: u32,
    samples_a_texel: u32,
    /// Stored depth within which a sample shows the texel's own surface.
    same_z: f32,
    /// 1: what is over the limit is left to the lights.
    limited: u32,
    /// Outer frame, px.
    size: vec2u,
    /// 1: samples are staggered (`stagger_of`).
    staggered: u32,
}

/// Most samples a texel, and a pixel, on each side.
const MOST_A_TEXEL = 4u;
const MOST_A_SIDE = 12u;

@group(0) @binding(0) var<uniform> sampling: Sampling;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> lights: array<Light>;
@group(0) @binding(4) var own_depth: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var mean: texture_storage_2d<rgba16float, write>;

fn sampled_color(texel: vec2u) -> vec3f {
    let radiance = textureLoad(color, texel, 0).rgb;
    return select(radiance, radiance - over_limit(radiance), sampling.limited != 0u);
}

@compute @workgroup_size(8, 8)
fn mean_of_samples(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(mean)) {
        return;
    }
    let side = min(sampling.samples_a_texel, MOST_A_TEXEL);
    let first = id.xy * side;
    let own = textureLoad(depth, first, 0).r;
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var y = 0u; y < side; y++) {
        for (var x = 0u; x < side; x++) {
            let texel = first + vec2u(x, y);
            if abs(textureLoad(depth, texel, 0).r - own) <= sampling.same_z {
                sum += sampled_color(texel);
                count += 1.0;
            }
        }
    }
    textureStore(mean, id.xy, vec4f(sum / max(count, 1.0), 1.0));
    textureStore(own_depth, id.xy, vec4f(own));
}

@compute @workgroup_size(8, 8)
fn find_lights(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= sampling.size) {
        return;
    }
    let side = min(sampling.samples_a_side, MOST_A_SIDE);
    let share = 1.0 / f32(side * side);
    var light = Light();
    for (var y = 0u; y < side; y++) {
        for (var x = 0u; x < side; x++) {
            let texel = side * id.xy + vec2u(x, y);
            let radiance = textureLoad(color, texel, 0).rgb;
            let place = vec2f(vec2u(x, y));
            let moved = vec2f(stagger_of(place.y, f32(side)), stagger_of(place.x, f32(side)));
            let offset = (place + f32(sampling.staggered) * moved) / f32(side);
            light = with_sample(light, radiance, textureLoad(depth, texel, 0).r, offset, share);
        }
    }
    lights[id.y * sampling.size.x + id.x] = light;
}

struct Marking {
    /// Outer frame, px.
    size: vec2u,
    layers: u32,
    /// Texels of the layers a pixel on each side.
    texels_a_side: u32,
}

@group(1) @binding(0) var<uniform> marking: Marking;
@group(1) @binding(1) var colors: texture_2d_array<f32>;
@group(1) @binding(2) var depths: texture_2d_array<f32>;
@group(1) @binding(3) var<storage, read> found_lights: array<Light>;
@group(1) @binding(4) var<storage, read_write> light_tiles: array<u32>;

/// Side of a tile, px: the workgroup's (`TILE_PX` in src/view/samples.rs).
const TILE = 8u;

/// Most layers, and texels a pixel on each side.
const MOST_LAYERS = 4u;
const MOST_TEXELS = 3u;

/// Layers of the tile that hold light, a bit each.
var<workgroup> layers_lit: atomic<u32>;

/// The layers that hold light in a pixel, a bit each.
fn lit_layers(pixel: vec2u) -> u32 {
    var lit = u32(found_lights[pixel.y * marking.size.x + pixel.x].weight > 0.0);
    let side = min(marking.texels_a_side, MOST_TEXELS);
    for (var layer = 1u; layer < min(marking.layers, MOST_LAYERS); layer++) {
        for (var i = 0u; i < side * side; i++) {
            let texel = side * pixel + vec2u(i % side, i / side);
            if textureLoad(depths, texel, layer, 0).r >= 0.0 {
                let over = over_limit(textureLoad(colors, texel, layer, 0).rgb);
                lit |= select(0u, 1u << layer, any(over > vec3f(0.0)));
            }
        }
    }
    return lit;
}

@compute @workgroup_size(8, 8)
fn mark_lights(
    @builtin(workgroup_id) group: vec3u,
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    if all(id.xy < marking.size) {
        atomicOr(&layers_lit, lit_layers(id.xy));
    }
    workgroupBarrier();
    if index == 0u {
        light_tiles[group.y * ((marking.size.x + TILE - 1u) / TILE) + group.x] = atomicLoad(&layers_lit);
    }
}
