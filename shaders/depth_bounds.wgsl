// Least and greatest stored depth of an image.
//
// Stored depths are not negative, so the order of their bits is the order of the numbers
// and integer atomics find the bounds exactly. A workgroup reduces 64x64 texels first:
// two global atomics for every 4096 texels.

@group(0) @binding(0) var depth: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> result: array<atomic<u32>, 2>;

var<workgroup> lowest: atomic<u32>;
var<workgroup> highest: atomic<u32>;

@compute @workgroup_size(16, 16)
fn depth_bounds(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    if index == 0u {
        atomicStore(&lowest, 0xffffffffu);
        atomicStore(&highest, 0u);
    }
    workgroupBarrier();
    let size = textureDimensions(depth);
    var low = 0xffffffffu;
    var high = 0u;
    for (var i = 0u; i < 16u; i++) {
        let at = group.xy * 64u + local.xy + 16u * vec2u(i % 4u, i / 4u);
        if all(at < size) {
            // max: an empty texel is +0, never -0, whose bits would be the greatest.
            let bits = bitcast<u32>(max(textureLoad(depth, at, 0).r, 0.0));
            low = min(low, bits);
            high = max(high, bits);
        }
    }
    atomicMin(&lowest, low);
    atomicMax(&highest, high);
    workgroupBarrier();
    if index == 0u {
        atomicMin(&result[0], atomicLoad(&lowest));
        atomicMax(&result[1], atomicLoad(&highest));
    }
}
