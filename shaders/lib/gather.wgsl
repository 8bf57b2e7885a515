// What the passes of `gather` share (src/methods/gather/).
//
// The gathered image is the picture at half of each side or whole, in whole tiles of 8x8
// texels around the picture's centre. Its alpha is the signed CoC diameter, px.

#import lens

struct Params {
    lens: Lens,
    /// Texels of the gathered image.
    grid: vec2u,
    /// Pixels by which it begins left of and above the picture with its overscan.
    margin: vec2f,
    /// px on each side of a texel.
    step: u32,
    /// Pixels on each side that a texel covers all or part of.
    footprint: u32,
    /// Overscan, px.
    overscan: u32,
    /// Taps, the one in the middle included.
    taps: u32,
    /// Tiles on every side whose blur may reach a tile.
    reach_tiles: u32,
    /// Greatest |v| of the aperture: blur reaches so many CoC radii.
    aperture_radius: f32,
    is_disc: u32,
    /// Variance per axis, px^2, that reducing the image and reading it again add.
    spread: f32,
    /// What follows switches a stage each.
    prefilter: u32,
    tiles: u32,
    near: u32,
    fill: u32,
    slight: u32,
    /// Greatest component above which a texel can become a sprite.
    sprite_threshold: f32,
    /// 0: none, 1: median, 2: mean.
    post_filter: u32,
    /// CoC diameter, px, below which a pixel is left as it is.
    in_focus_coc: f32,
}

@group(0) @binding(0) var<uniform> params: Params;

const TILE = 8u;

/// Levels of the gathered image.
const LEVELS = 4u;

/// What is known of a tile of the gathered image, radii and diameters in px.
struct Tile {
    /// CoC diameters in the tile, or in all that its own blur reaches.
    nearest: f32,
    farthest: f32,
    /// Radius of the widest blur of foreground in it, or that reaches it.
    near_radius: f32,
    /// Greatest |c|.
    widest: f32,
}

const PI = 3.14159265;

/// Half the thickness of a surface in c: what lies within it of another surface's c is the same
/// surface, curved or slanted. `splat` has 0.4 |c|; in focus a pixel is the least that is seen.
const SURFACE_PER_COC = 0.4;
const LEAST_SURFACE = 1.0;

fn half_thickness(c: f32) -> f32 {
    return max(SURFACE_PER_COC * abs(c), LEAST_SURFACE);
}

/// How much a surface with `c` lies in front of and behind one with `c_own`: 0 to 1 each, by
/// ramps around half the thickness.
fn in_front(c: f32, c_own: f32) -> f32 {
    return saturate((c_own - c) / half_thickness(c_own) - 0.5);
}

fn behind(c: f32, c_own: f32) -> f32 {
    return saturate((c - c_own) / half_thickness(c_own) - 0.5);
}

/// Radius, px, of the blur that is to be gathered or drawn so that with what reducing and reading
/// add it is as wide as the lens's: a disc of radius r has the variance r^2/4.
fn own_radius(c: f32) -> f32 {
    let radius = 0.5 * abs(c);
    let sigma = 2.0 * params.lens.sigma_per_coc;
    return sqrt(max(radius * radius - params.spread / (sigma * sigma), 0.0));
}

/// The texel of the gathered image at a position, px of the picture with its overscan; texels have
/// their centres at half integers.
fn texel_at(px: vec2f) -> vec2f {
    return (px + params.margin) / f32(params.step);
}
