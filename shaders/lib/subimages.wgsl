// Sub-images of a pinhole image by depth, and the pyramids that blur them
// (src/methods/subimages.rs). Kraus 2011, section 3.
//
//   weight of sub-image i over the ramp variable x, which grows with depth:
//
//        1         ______
//                 /      \
//        0  _____/        \_____
//            x(i-2) x(i-1) x(i) x(i+1)
//
// Between x(i-1) and x(i) sub-image i is opaque under a sub-image i-1 that fades out.
//
// Levels are array textures, one layer for each sub-image that is blurred that far.
// Texel p of level k covers the pixels [p 2^k, (p+1) 2^k) counted from the image's centre,
// so that a mirrored image has the mirrored pyramid whatever the number of levels. One
// texel more on every side holds all that a 4x4 box carries over the border.

#import lens

const MAX_SUB_IMAGES = 32u;

struct SubImages {
    /// By layer: the ramp variable at the sub-images i-2, i-1, i and i+1.
    ramps: array<vec4f, MAX_SUB_IMAGES>,
    /// x: by layer, the level |i|. y: from front to back, the layer.
    order: array<vec4u, MAX_SUB_IMAGES>,
    /// The image's centre, px.
    centre: vec2i,
    /// Number of sub-images.
    count: u32,
    /// Overscan, px.
    overscan: u32,
    /// Ramp variable 1: signed variance of the lens's blur, px^2; 0: depth over near.
    variance_ramps: u32,
    /// 1: weights are undone of what the glow adds to them over flat regions.
    glow_undone: u32,
    /// 1: transparent black around the image; 0: what is nearest in it.
    transparent_border: u32,
    /// Share of the light behind a sub-image that its opacity fails to cover.
    repeated_inclusion: f32,
}

/// Depth over near at which everything counts as infinitely far: keeps ramps finite.
const FARTHEST = 1e9;

/// The variable in which weights are linear, for stored depth z.
fn ramp_variable(variance_ramps: u32, lens: Lens, z: f32) -> f32 {
    if variance_ramps == 0u {
        return 1.0 / max(z, 1.0 / FARTHEST);
    }
    let sigma = lens.sigma_per_coc * coc_diameter_px(lens, z);
    return sigma * abs(sigma);
}

/// Whether bit `layer` is set: empty sub-images are passed over.
fn is_occupied(bits: u32, layer: u32) -> bool {
    return ((bits >> layer) & 1u) != 0u;
}

/// How far something at x is not in front of the sub-image: the rising ramp.
fn not_in_front(ramps: vec4f, x: f32) -> f32 {
    return saturate((x - ramps.x) / (ramps.y - ramps.x));
}

/// How far something at x is not behind the sub-image: the falling ramp.
fn not_behind(ramps: vec4f, x: f32) -> f32 {
    return 1.0 - saturate((x - ramps.z) / (ramps.w - ramps.z));
}

/// The 16 texels of the 4x4 box around the centre of texel p of the next level.
fn box_texel(p: vec2i, i: i32) -> vec2i {
    return 2 * p + vec2i(i % 4, i / 4) - 1;
}

/// Texel p, counted from the centre, of a level of `size` texels.
fn texel_index(p: vec2i, size: vec2u) -> vec2i {
    return p + vec2i(size / 2u);
}

/// The reverse of `texel_index`.
fn texel_from_centre(index: vec2u, size: vec2u) -> vec2i {
    return vec2i(index) - vec2i(size / 2u);
}

/// One of the four texels of the coarser level around texel p, with its weight: a step of
/// the subdivision whose limit is a biquadratic B-spline, (3/4, 1/4) per axis.
struct Neighbour {
    at: vec2i,
    weight: f32,
}

fn neighbour(p: vec2i, i: i32) -> Neighbour {
    // >> rounds down for negative p too.
    let near = p >> vec2u(1u);
    let step = 2 * (p & vec2i(1)) - 1;
    let side = vec2i(i & 1, i >> 1);
    let weight = vec2f(0.75) - 0.5 * vec2f(side);
    return Neighbour(near + side * step, weight.x * weight.y);
}
