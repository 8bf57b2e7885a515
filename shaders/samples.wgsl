// The first layer from more samples than it has texels (src/view/samples.rs): the mean
// colour of each texel's surface, and what in each pixel is far brighter than white.

#import emitters

struct Sampling {
    /// Texels a pixel on each side.
    fineness: u32,
    /// Reciprocal of the number of samples a pixel, those of all draws.
    share: f32,
    /// How far the samples are moved, px.
    shift: vec2f,
    /// Outer frame, px.
    size: vec2u,
    /// Stored depth within which a sample shows the texel's own surface.
    same_z: f32,
    /// 1: what is over the limit is left to the lights.
    limited: u32,
}

@group(0) @binding(0) var<uniform> sampling: Sampling;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> lights: array<Light>;
/// Stored depth of the layer.
@group(0) @binding(4) var own_depth: texture_2d<f32>;
/// Mean so far, and in alpha the number of samples that made it over 16.
@group(0) @binding(5) var mean: texture_2d<f32>;
@group(0) @binding(6) var next_mean: texture_storage_2d<rgba16float, write>;

/// One over the greatest number of draws.
const COUNT_SCALE = 1.0 / 16.0;

fn sampled_color(texel: vec2u) -> vec3f {
    let radiance = textureLoad(color, texel, 0).rgb;
    return select(radiance, radiance - over_limit(radiance), sampling.limited != 0u);
}

@compute @workgroup_size(8, 8)
fn first_sample(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(color)) {
        textureStore(next_mean, id.xy, vec4f(sampled_color(id.xy), COUNT_SCALE));
    }
}

@compute @workgroup_size(8, 8)
fn add_sample(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(color)) {
        return;
    }
    var sum = textureLoad(mean, id.xy, 0);
    if abs(textureLoad(depth, id.xy, 0).r - textureLoad(own_depth, id.xy, 0).r) <= sampling.same_z {
        sum.a += COUNT_SCALE;
        sum = vec4f(mix(sum.rgb, sampled_color(id.xy), COUNT_SCALE / sum.a), sum.a);
    }
    textureStore(next_mean, id.xy, sum);
}

@compute @workgroup_size(8, 8)
fn add_lights(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= sampling.size) {
        return;
    }
    let k = sampling.fineness;
    var light = lights[id.y * sampling.size.x + id.x];
    for (var i = 0u; i < k * k; i++) {
        let part = vec2u(i % k, i / k);
        let texel = k * id.xy + part;
        let radiance = textureLoad(color, texel, 0).rgb;
        let offset = vec2f(part) / f32(k) + sampling.shift;
        light = with_sample(light, radiance, textureLoad(depth, texel, 0).r, offset, sampling.share);
    }
    lights[id.y * sampling.size.x + id.x] = light;
}
