// Red of one picture, green of another and blue of a third (src/methods/primaries.rs).

@group(0) @binding(0) var red: texture_2d<f32>;
@group(0) @binding(1) var green: texture_2d<f32>;
@group(0) @binding(2) var blue: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn one_of_each(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) {
        return;
    }
    let r = textureLoad(red, id.xy, 0).r;
    let g = textureLoad(green, id.xy, 0);
    let b = textureLoad(blue, id.xy, 0).b;
    textureStore(result, id.xy, vec4f(r, g.g, b, g.a));
}
