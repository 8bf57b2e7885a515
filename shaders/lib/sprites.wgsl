// Drawing a pixel as the blur spot that the lens makes of it (src/methods/sprites.rs).
//
// A source pixel p with the signed CoC diameter c is drawn as a square whose pixels q
// each get the share of p's light that falls on it: the integral of the
// aperture's intensity distribution (IDF) over the pixel, seen at v = 2 (q - p) / c.
//
//        +---+---+---+       The integral over a rectangle is that of four corners of the
//        |   |## |   |       IDF's running sums, so neighbouring pixels share corners and
//        +---+###+---+       the shares of a sprite sum to 1 for every c and shape. For
//        |  #|###|#  |       c -> 0 the pixel itself gets all.
//        +---+---+---+       c < 0 turns the shape by half a turn, as in front of focus.

#import lens

struct Sprites {
    /// Size of what is drawn on, the inner frame, px.
    size: vec2u,
    /// Greatest |v| of the aperture: a spot reaches radius * C / 2 px from its centre.
    radius: f32,
    /// Cells per side of the table of running sums.
    cells: u32,
    /// Margin around the inner frame, px: image position minus position on the target.
    overscan: u32,
    /// |v| up to which the IDF is constant, and what it is there, its integral being 1.
    solid: f32,
    solid_intensity: f32,
}

/// Integral of the IDF over the rectangle between 0 and v, signed. `sums` holds, per cell,
/// the sums at its top left, top right, bottom left and bottom right corner; within a cell
/// the IDF is constant, so the sum is bilinear.
fn idf_sum(sums: texture_2d<f32>, sprites: Sprites, v: vec2f) -> f32 {
    let at = clamp(0.5 + 0.5 * v / sprites.radius, vec2f(0.0), vec2f(1.0)) * f32(sprites.cells);
    let cell = min(floor(at), vec2f(f32(sprites.cells - 1u)));
    let corners = textureLoad(sums, vec2i(cell), 0);
    let inside = at - cell;
    let rows = mix(corners.xy, corners.zw, inside.y);
    return mix(rows.x, rows.y, inside.x);
}

/// What rounding leaves where the sums of the table differ by nothing: a few roundings of
/// numbers up to 1. Inside a spot a cell, or a pixel that is larger, has some hundred times
/// as much. Less would weigh nothing, were sums not divided by their alpha, however small.
const SHARE_NOISE = 2.4e-7;

/// Share of a sprite's light in a cell of the table.
fn cell_share(sums: texture_2d<f32>, sprites: Sprites, cell: vec2f) -> f32 {
    let corners = textureLoad(sums, vec2i(cell), 0);
    let share = (corners.w - corners.z) - (corners.y - corners.x);
    let inside = all(cell >= vec2f(0.0)) && all(cell < vec2f(f32(sprites.cells)));
    return select(0.0, share, inside && share > SHARE_NOISE);
}

/// As a sum of up to four cells, for a pixel that is no larger than one, `side` cells wide and high:
/// there the differences of the table's sums are all rounding.
fn share_of_cells(sums: texture_2d<f32>, sprites: Sprites, offset: vec2f, side: vec2f) -> f32 {
    let low = 0.5 * f32(sprites.cells) + (offset - 0.5) * side;
    let cell = floor(low);
    let first = min(side, cell + 1.0 - low);
    let second = side - first;
    let top = first.x * cell_share(sums, sprites, cell) + second.x * cell_share(sums, sprites, cell + vec2f(1.0, 0.0));
    let bottom = first.x * cell_share(sums, sprites, cell + vec2f(0.0, 1.0)) + second.x * cell_share(sums, sprites, cell + 1.0);
    return first.y * top + second.y * bottom;
}

/// Share of a sprite's light that falls on the pixel `offset` px from it: the paper's
/// alpha, kn(C) / C^2 inside the IDF.
fn sprite_share(sums: texture_2d<f32>, sprites: Sprites, offset: vec2f, c: f32) -> f32 {
    let cells_per_px = f32(sprites.cells) / (sprites.radius * max(abs(c), 1e-3));
    if cells_per_px <= 1.0 {
        return share_of_cells(sums, sprites, select(offset, -offset, c < 0.0), vec2f(cells_per_px));
    }
    // Below a thousandth of a pixel nothing but the pixel itself is reached.
    let v_per_px = 2.0 / select(max(c, 1e-3), min(c, -1e-3), c < 0.0);
    let low = (offset - 0.5) * v_per_px;
    let high = (offset + 0.5) * v_per_px;
    let right = idf_sum(sums, sprites, high) - idf_sum(sums, sprites, vec2f(high.x, low.y));
    let left = idf_sum(sums, sprites, vec2f(low.x, high.y)) - idf_sum(sums, sprites, low);
    let share = right - left;
    return select(0.0, share, share > SHARE_NOISE);
}

/// Whether a spot stays within its own pixel.
fn is_single_pixel(sprites: Sprites, c: f32) -> bool {
    return sprites.radius * abs(c) <= 1.0;
}

/// Clip position of corner 0..3 of the square around `centre` (px on the target) that
/// covers every pixel with a share in the sprite.
fn sprite_corner(sprites: Sprites, corner: u32, centre: vec2f, c: f32) -> vec4f {
    let reach = 0.5 * sprites.radius * abs(c) + 0.5;
    let side = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let ndc = (centre + side * reach) / vec2f(sprites.size) * 2.0 - 1.0;
    return vec4f(ndc.x, -ndc.y, 0.0, 1.0);
}

/// Where all corners of a sprite go that is not drawn.
const NOWHERE = vec4f(2.0, 2.0, 0.0, 1.0);

fn is_finite_number(x: f32) -> bool {
    // By its bits: compilers may assume that there are no others and drop a comparison.
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

/// Whether a source pixel is one that can be drawn; one that is not must not spread.
fn is_finite_source(color: vec3f, z: f32) -> bool {
    return is_finite_number(color.r) && is_finite_number(color.g) && is_finite_number(color.b) && is_finite_number(z);
}
