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

/// Texel p, counted from the centre, of a level of `size` texels.
fn texel_index(p: vec2i, size: vec2u) -> vec2i {
    return p + vec2i(size / 2u);
}

/// The reverse of `texel_index`.
fn texel_from_centre(index: vec2u, size: vec2u) -> vec2i {
    return vec2i(index) - vec2i(size / 2u);
}

// ---- blocks of 2x2 texels ----
//
// Block b of a level has the texels 2b - 1 and 2b on each axis. Both directions between
// levels go by blocks, so that each texel is read once:
//
//   the 4x4 box of texel p of the next level is the blocks p and p + 1 on each axis;
//   the four texels of block b lie between the texels b - 1 and b of the next level.

/// Texels along a side of which a workgroup makes the next level: with one block more there
/// are as many blocks as invocations.
const BOXES = 15u;
const BLOCKS = 16u;

/// Corner i of block b: one of its four texels.
fn block_texel(b: vec2i, i: u32) -> vec2i {
    return 2 * b - 1 + vec2i(vec2u(i & 1u, i >> 1u));
}

/// Four texels of a level: those between which a block of the finer one lies.
struct Quad {
    top_left: vec4f,
    top_right: vec4f,
    bottom_left: vec4f,
    bottom_right: vec4f,
}

/// What a quad gives corner i of its block: a step of the subdivision whose limit is a
/// biquadratic B-spline, (3/4, 1/4) per axis.
fn expanded(quad: Quad, i: u32) -> vec4f {
    let right = select(0.25, 0.75, (i & 1u) != 0u);
    let bottom = select(0.25, 0.75, (i & 2u) != 0u);
    let top = (1.0 - right) * quad.top_left + right * quad.top_right;
    return (1.0 - bottom) * top + bottom * ((1.0 - right) * quad.bottom_left + right * quad.bottom_right);
}

/// Where a quad's texels lie in a level of `size`: the first and the last one. Beyond the
/// border is what is nearest to it.
struct QuadPlace {
    first: vec2i,
    last: vec2i,
}

fn quad_place(b: vec2i, size: vec2u) -> QuadPlace {
    let last = texel_index(b, size);
    return QuadPlace(clamp(last - 1, vec2i(0), vec2i(size) - 1), clamp(last, vec2i(0), vec2i(size) - 1));
}

fn quad_of(level: texture_2d_array<f32>, at: QuadPlace, layer: u32) -> Quad {
    return Quad(
        textureLoad(level, at.first, layer, 0),
        textureLoad(level, vec2i(at.last.x, at.first.y), layer, 0),
        textureLoad(level, vec2i(at.first.x, at.last.y), layer, 0),
        textureLoad(level, at.last, layer, 0),
    );
}

/// The opacities of a quad's texels.
fn opacities(quad: Quad) -> Quad {
    return Quad(vec4f(quad.top_left.a), vec4f(quad.top_right.a), vec4f(quad.bottom_left.a), vec4f(quad.bottom_right.a));
}

// ---- synthesis: a workgroup has 16x16 texels of the finer level ----

const TILE = 16u;
/// Texels of the coarser level along a side that they lie between.
const AROUND = 10u;

/// Those texels: a colour, and another number.
var<workgroup> around_colors: array<vec4f, 100>;
var<workgroup> around_numbers: array<f32, 100>;

/// The first of them, from the centre, for the tile whose first texel lies at p.
fn first_around(p: vec2i) -> vec2i {
    // >> rounds down for negative numbers too.
    return ((p + 1) >> vec2u(1u)) - 1;
}

/// Slot i of them in a level of `size`. Beyond the border is what is nearest to it.
fn around_texel(first: vec2i, i: u32, size: vec2u) -> vec2i {
    let p = first + vec2i(vec2u(i % AROUND, i / AROUND));
    return clamp(texel_index(p, size), vec2i(0), vec2i(size) - 1);
}

/// Where a texel p of the tile lies between them: the first slot, and its corner of the block.
struct Place {
    slot: u32,
    corner: u32,
}

fn place_in(first: vec2i, p: vec2i) -> Place {
    let b = (p + 1) >> vec2u(1u);
    let slot = vec2u(b - 1 - first);
    let corner = vec2u(p - (2 * b - 1));
    return Place(slot.y * AROUND + slot.x, corner.y * 2u + corner.x);
}

fn expanded_color(place: Place) -> vec4f {
    let below = place.slot + AROUND;
    let quad = Quad(
        around_colors[place.slot],
        around_colors[place.slot + 1u],
        around_colors[below],
        around_colors[below + 1u],
    );
    return expanded(quad, place.corner);
}

fn expanded_number(place: Place) -> f32 {
    let below = place.slot + AROUND;
    let quad = Quad(
        vec4f(around_numbers[place.slot]),
        vec4f(around_numbers[place.slot + 1u]),
        vec4f(around_numbers[below]),
        vec4f(around_numbers[below + 1u]),
    );
    return expanded(quad, place.corner).x;
}
