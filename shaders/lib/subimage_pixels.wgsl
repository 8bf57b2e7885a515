// Pixels of the pinhole image as sub-images see them, in blocks, and which sub-images they lie
// in (src/methods/subimages.rs).

#import lens
#import subimages

@group(0) @binding(0) var<uniform> lens: Lens;
@group(0) @binding(1) var<uniform> sub_images: SubImages;
/// Bit l is set if any pixel lies in the sub-image of layer l.
@group(0) @binding(2) var<storage, read> occupied: u32;
@group(0) @binding(3) var<storage, read_write> occupied_out: atomic<u32>;
@group(0) @binding(4) var color: texture_2d<f32>;
@group(0) @binding(5) var depth: texture_2d<f32>;

struct Pixel {
    color: vec3f,
    /// Stored depth.
    z: f32,
    /// The ramp variable.
    x: f32,
}

/// In front of every ramp: in no sub-image. Nothing is known of what has it.
const NOWHERE = -3e38;

/// The pixel p from the centre; beyond the border what is nearest, or nothing.
fn pixel(p: vec2i, has_border: bool) -> Pixel {
    let at = p + sub_images.centre;
    let inside = clamp(at, vec2i(0), vec2i(textureDimensions(depth)) - 1);
    let z = textureLoad(depth, inside, 0).r;
    let x = ramp_variable(sub_images.variance_ramps, lens, z);
    return Pixel(textureLoad(color, inside, 0).rgb, z, select(x, NOWHERE, has_border && any(at != inside)));
}

/// The pixels of a block.
struct PixelBlock {
    a: Pixel,
    b: Pixel,
    c: Pixel,
    d: Pixel,
}

fn pixel_block(b: vec2i, has_border: bool) -> PixelBlock {
    return PixelBlock(
        pixel(block_texel(b, 0u), has_border),
        pixel(block_texel(b, 1u), has_border),
        pixel(block_texel(b, 2u), has_border),
        pixel(block_texel(b, 3u), has_border),
    );
}

/// The ramp variable of the four.
fn ramp_variables(block: PixelBlock) -> vec4f {
    return vec4f(block.a.x, block.b.x, block.c.x, block.d.x);
}

/// Layers in which the workgroup's pixels lie, and those that show or lie behind any of them.
var<workgroup> found_here: atomic<u32>;
var<workgroup> known_here: atomic<u32>;

/// Notes which layers a block's pixels lie in.
fn note_layers(x: vec4f) {
    var found = 0u;
    var known = 0u;
    for (var layer = 0u; layer < sub_images.count; layer++) {
        let ramps = sub_images.ramps[layer];
        let behind = x > vec4f(ramps.x);
        known |= select(0u, 1u << layer, any(behind));
        found |= select(0u, 1u << layer, any(behind & (x < vec4f(ramps.w))));
    }
    atomicOr(&found_here, found);
    atomicOr(&known_here, known);
}

/// The block, counted from the centre, in which the image without overscan begins.
fn first_block() -> vec2i {
    // >> rounds down for negative numbers too.
    return (vec2i(i32(sub_images.overscan)) - sub_images.centre + 1) >> vec2u(1u);
}

// ---- results ----
//
// 8x8 blocks have 16x16 pixels. They are handed over through the workgroup's memory: rows of
// pixels next to each other are stored in fewer transactions than corners of blocks.

var<workgroup> results: array<vec3f, 256>;

/// Hands over corner i of the block of an invocation.
fn hand_over(local: vec2u, i: u32, result: vec3f) {
    results[(2u * local.y + (i >> 1u)) * 16u + 2u * local.x + (i & 1u)] = result;
}

/// The pixel, in the image without overscan, of slot i of `results`.
fn result_pixel(group: vec2u, i: u32) -> vec2i {
    let first = block_texel(first_block() + 8 * vec2i(group), 0u);
    return first + vec2i(vec2u(i % 16u, i / 16u)) + sub_images.centre - vec2i(i32(sub_images.overscan));
}
