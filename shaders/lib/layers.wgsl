// What the passes of `adaptive` share: CoC radii in bins, tiles, and how a layered image
// is laid out. It binds the numbers that all of them need.
//
// s = c / 2 is the signed CoC radius in pixels. A lens ray through pixel p and lens point
// v is p - v * s: straight in (x, y, s).
//
// Bins are equally wide in t = sign(s) sqrt(|s|): 64 of them resolve a tenth of a pixel
// near the focus and a pixel where blur is tens of pixels wide.

#import lens
#import tile_lists

struct Adaptive {
    /// Tiles of the outer frame; tile `first_tile` holds the inner frame's first pixel.
    tiles: vec2u,
    /// Tiles of the inner frame.
    inner_tiles: vec2u,
    /// Inner frame, px.
    size: vec2u,
    first_tile: u32,
    /// Overscan, px.
    overscan: u32,
    layers: u32,
    /// Lens points a pixel.
    points: u32,
    /// Tiles on every side from which a ray can come.
    reach: u32,
    /// 1: bins behind all visible surfaces within reach are dropped.
    cull: u32,
    /// t of the first bin's near edge, and of one bin.
    first_t: f32,
    bin_t: f32,
    /// Least and greatest s in any bin.
    nearest_s: f32,
    farthest_s: f32,
    /// Greatest |v| of a lens point.
    lens_radius: f32,
    /// Variance of the lens over that of a disc.
    lens_variance: f32,
    /// |s| up to which a hit is not filtered, and up to which it is filtered narrowly.
    sharp_s: f32,
    narrow_s: f32,
    /// 1: fetches and hits are counted.
    diagnose: u32,
    /// Texels of the layers a pixel on each side.
    fineness: u32,
    /// Off-centre views, 0 or 4, and how far from the lens's centre each lies on both axes.
    views: u32,
    view_distance: f32,
    lens: Lens,
    /// Samples of the first layer a pixel on each side.
    samples_a_side: u32,
    /// Lens points a pixel of a noisy tile.
    most_points: u32,
    /// Root mean square error of display values from which a tile is noisy.
    noise_limit: f32,
    /// 1: what is seen is an image with depth.
    is_image: u32,
    /// The layer of `nearest_depths` that tiles of rays take their grid from (lib/lens_rays.wgsl).
    grid_layer: u32,
    /// 1: the lens blurs to discs.
    is_disc: u32,
    /// Distance of the grid's places, px.
    grid_spacing: u32,
    /// How far from a tile its first place lies to the left and above, px.
    grid_margin: u32,
    /// How far around a place, px, the grid knows what a ray may meet; 0 where rays are too bent.
    grid_reach_px: f32,
}

@group(0) @binding(0) var<uniform> adaptive: Adaptive;

/// The position, texels, in an image of `a_side` texels a pixel of the position `at` in the
/// outer frame, px: texel `a_side * i` has its centre at that of pixel i.
fn texels_of(a_side: u32, at: vec2f) -> vec2f {
    let k = f32(a_side);
    return k * at - 0.5 * (k - 1.0);
}

/// s of a surface at stored depth z, within the bins.
fn s_of_depth(adaptive: Adaptive, z: f32) -> f32 {
    return clamp(0.5 * coc_diameter_px(adaptive.lens, z), adaptive.nearest_s, adaptive.farthest_s);
}

/// By how much the longer half axis of the ellipse that an astigmatic eye blurs to is longer than
/// |s|, px: 0 for a round blur.
fn astigmatic_s() -> f32 {
    return 0.5 * abs(adaptive.lens.astigmatism_px);
}

/// Longer half axis of the blur at s, px.
fn greatest_s(s: f32) -> f32 {
    return abs(s) + astigmatic_s();
}

/// Shorter half axis of the blur at s, px.
fn least_s(s: f32) -> f32 {
    return abs(abs(s) - astigmatic_s());
}

const BINS = 64u;

/// s of a texel without a surface: beyond all bins.
const EMPTY_S = 60000.0;

/// Buckets of s that hits are gathered in, front to back.
const BUCKETS = 5u;
/// The bucket in focus, which is not filtered.
const SHARP = 2u;

/// Stands beside the bits of a tile's buckets where the tile is in focus.
const IN_FOCUS_TILE = 0x80000000u;

const COPY = 0u;
const UNIFORM = 1u;
const COMPLEX = 2u;

/// Which bins a ray from a tile can hit.
struct Tile {
    /// Bins 0 to 31 and 32 to 63.
    low: u32,
    high: u32,
    /// The farthest bin of the first layer; of the second layer; and of the second where
    /// the first lies in front of its farthest bin in the tile.
    farthest: u32,
    hidden: u32,
    hidden_by_front: u32,
    /// COPY, UNIFORM or COMPLEX.
    class_of: u32,
    /// Length of the tile's list of emitters.
    emitters: u32,
    /// Greatest difference of s, px, between neighbouring texels of the first layer.
    step_s: f32,
    /// Not 0 where the first layer may hold light that is kept apart, here or in a tile beside.
    lit: u32,
}

/// Whether a surface in bin `front` lies in front of those in bin `back` by enough to hide
/// a gap that shows from elsewhere on the lens: half a pixel of s.
fn in_front(adaptive: Adaptive, front: u32, back: u32) -> bool {
    return front < back && edge_of(adaptive, front + 1u) < edge_of(adaptive, back + 1u) - 0.5;
}

fn bin_of(adaptive: Adaptive, s: f32) -> u32 {
    let t = sign(s) * sqrt(abs(s));
    return u32(clamp((t - adaptive.first_t) / adaptive.bin_t, 0.0, f32(BINS - 1u)));
}

/// s of the near edge of bin `i`.
fn edge_of(adaptive: Adaptive, i: u32) -> f32 {
    let t = adaptive.first_t + f32(i) * adaptive.bin_t;
    return sign(t) * t * t;
}

/// The first `n` bins.
fn first_bins(n: u32) -> vec2u {
    let low = select((1u << min(n, 31u)) - 1u, 0xffffffffu, n >= 32u);
    let above = max(n, 32u) - 32u;
    return vec2u(low, select((1u << min(above, 31u)) - 1u, 0xffffffffu, above >= 32u));
}

fn first_bin(mask: vec2u) -> u32 {
    return select(countTrailingZeros(mask.x), 32u + countTrailingZeros(mask.y), mask.x == 0u);
}

fn last_bin(mask: vec2u) -> u32 {
    return select(31u - countLeadingZeros(mask.x), 63u - countLeadingZeros(mask.y), mask.y != 0u);
}
