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
