// The blur spot of a source pixel where the eye may be astigmatic: a disc's sprite
// (lib/sprites.wgsl), stretched to an ellipse along two meridians (lib/lens.wgsl).
//
// In the meridians' coordinates the spot is the aperture, turned and stretched along both axes, and a
// pixel a square that is turned by up to 45 degrees. It is cut into strips along the second meridian,
//
//        /\            and each strip's share is that of a rectangle: four corners of the running
//      _|  |_          sums. Strips lie on a grid about the spot's centre, so that those of
//     |  ||  |         neighbouring pixels fit together without gaps: shares sum to 1 also where one
//      \_||_/          meridian is in focus and the spot is a line.
//        \/

#import sprites

/// Width of a strip, px: edges of pixels are off by half of it at most.
const STRIP_PX = 0.25;

/// Sine of the angle between meridians and pixels below which a pixel is one rectangle: over a spot of
/// 1000 px it is off by a tenth of a pixel.
const ALIGNED = 1e-4;

/// Half the width and height of the spot with its pixels, px.
fn spot_reach_px(sprites: Sprites, lens: Lens, c: f32) -> vec2f {
    return 0.5 * sprites.radius * blur_extent_px(lens, c) + 0.5;
}

/// `sprite_corner` of a spot that may be an ellipse.
fn spot_corner(sprites: Sprites, lens: Lens, corner: u32, centre: vec2f, c: f32) -> vec4f {
    let side = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let ndc = (centre + side * spot_reach_px(sprites, lens, c)) / vec2f(sprites.size) * 2.0 - 1.0;
    return vec4f(ndc.x, -ndc.y, 0.0, 1.0);
}

/// Whether a spot stays within its own pixel.
fn is_single_pixel_spot(sprites: Sprites, lens: Lens, c: f32) -> bool {
    return is_single_pixel(sprites, greatest_diameter_px(lens, c));
}

/// Share of a spot's light that falls on the pixel `offset` px from it.
fn spot_share(sums: texture_2d<f32>, sprites: Sprites, lens: Lens, offset: vec2f, c: f32) -> f32 {
    var share = sprite_share(sums, sprites, offset, c);
    // A loop that ends at once, no branch: software adapters run both sides of those.
    for (var i = 0u; i < select(0u, 1u, lens.astigmatism_px != 0.0); i++) {
        share = share_of_ellipse(sums, sprites, lens, c, Square(offset, 1.0));
    }
    return share;
}

/// A square by the offset of its centre from a spot's, and its side, px.
struct Square {
    offset: vec2f,
    side: f32,
}

/// Strips of a square that is turned by 45 degrees, at most.
const STRIPS = 7u;

/// Integral of the aperture, whose running sums are turned to the meridian, over a square that it
/// is spread over as the ellipse of CoC c.
fn share_of_ellipse(sums: texture_2d<f32>, sprites: Sprites, lens: Lens, c: f32, square: Square) -> f32 {
    let side = square.side;
    let along = lens.meridian;
    let at = by_meridian(lens, square.offset);
    let d = diameters_px(lens, c);
    let diameters = select(max(d, vec2f(1e-3)), min(d, vec2f(-1e-3)), d < vec2f(0.0));
    let v_per_px = 2.0 / diameters;
    // Half of what the turned square measures along each meridian.
    let extent = 0.5 * side * (along.x + abs(along.y));
    let farthest = (abs(at) + extent) * abs(v_per_px);
    if dot(farthest, farthest) <= sprites.solid * sprites.solid {
        return sprites.solid_intensity * abs(v_per_px.x * v_per_px.y) * side * side;
    }
    let turn = sign(v_per_px.x * v_per_px.y);
    let cells_per_px = f32(sprites.cells) / (sprites.radius * abs(diameters));
    if all(side * cells_per_px <= vec2f(1.0)) {
        return share_of_cells(sums, sprites, sign(diameters) * at / side, side * cells_per_px);
    }
    if abs(along.y) < ALIGNED {
        return share_of_box(sums, sprites, (at - 0.5 * side) * v_per_px, (at + 0.5 * side) * v_per_px, turn);
    }
    let strip = STRIP_PX * side;
    let first = floor((at.x - extent) / strip);
    var share = 0.0;
    for (var i = 0u; i < STRIPS; i++) {
        let left = (first + f32(i)) * strip;
        let x = left + 0.5 * strip - at.x;
        // Where the square's four sides cut the strip's middle, from the square's centre.
        let rising = (vec2f(-0.5, 0.5) * side - x * along.y) / along.x;
        let steep = (x * along.x + vec2f(-0.5, 0.5) * side) / along.y;
        let low = max(rising.x, min(steep.x, steep.y));
        let high = min(rising.y, max(steep.x, steep.y));
        if high > low {
            let corner = vec2f(left, at.y + low) * v_per_px;
            share += share_of_box(sums, sprites, corner, vec2f(left + strip, at.y + high) * v_per_px, turn);
        }
    }
    return share;
}

/// Integral of the aperture over a rectangle; `turn` is -1 where its corners are mirrored.
fn share_of_box(sums: texture_2d<f32>, sprites: Sprites, low: vec2f, high: vec2f, turn: f32) -> f32 {
    let right = idf_sum(sums, sprites, high) - idf_sum(sums, sprites, vec2f(high.x, low.y));
    let left = idf_sum(sums, sprites, vec2f(low.x, high.y)) - idf_sum(sums, sprites, low);
    let share = turn * (right - left);
    return select(0.0, share, share > SHARE_NOISE);
}
