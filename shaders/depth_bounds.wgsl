// Least and greatest stored depth of an image, the greatest step between neighbours, and
// the greatest colour component.
//
// None of them is negative, so the order of their bits is the order of the numbers
// and integer atomics find the bounds exactly. A workgroup reduces 64x64 texels first:
// four global atomics for every 4096 texels.

@group(0) @binding(0) var depth: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> result: array<atomic<u32>, 4>;
@group(0) @binding(2) var color: texture_2d<f32>;

var<workgroup> lowest: atomic<u32>;
var<workgroup> highest: atomic<u32>;
var<workgroup> steepest: atomic<u32>;
var<workgroup> brightest: atomic<u32>;

@compute @workgroup_size(16, 16)
fn depth_bounds(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    if index == 0u {
        atomicStore(&lowest, 0xffffffffu);
        atomicStore(&highest, 0u);
        atomicStore(&steepest, 0u);
        atomicStore(&brightest, 0u);
    }
    workgroupBarrier();
    let size = textureDimensions(depth);
    var low = 0xffffffffu;
    var high = 0u;
    var step = 0.0;
    var bright = 0.0;
    for (var i = 0u; i < 16u; i++) {
        let at = group.xy * 64u + local.xy + 16u * vec2u(i % 4u, i / 4u);
        if all(at < size) {
            // max: an empty texel is +0, never -0, whose bits would be the greatest.
            let z = max(textureLoad(depth, at, 0).r, 0.0);
            let bits = bitcast<u32>(z);
            low = min(low, bits);
            high = max(high, bits);
            let right = textureLoad(depth, min(at + vec2u(1u, 0u), size - 1u), 0).r;
            let lower = textureLoad(depth, min(at + vec2u(0u, 1u), size - 1u), 0).r;
            step = max(step, max(abs(z - right), abs(z - lower)));
            let texel = textureLoad(color, at, 0).rgb;
            bright = max(bright, max(texel.r, max(texel.g, texel.b)));
        }
    }
    atomicMin(&lowest, low);
    atomicMax(&highest, high);
    atomicMax(&steepest, bitcast<u32>(step));
    atomicMax(&brightest, bitcast<u32>(bright));
    workgroupBarrier();
    if index == 0u {
        atomicMin(&result[0], atomicLoad(&lowest));
        atomicMax(&result[1], atomicLoad(&highest));
        atomicMax(&result[2], atomicLoad(&steepest));
        atomicMax(&result[3], atomicLoad(&brightest));
    }
}
