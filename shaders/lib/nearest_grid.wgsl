// The nearest surface around all places that a tile's rays pass, in workgroup memory
// (src/methods/adaptive/nearest_grid.rs).

#import layers
#import sampling

/// The greatest stored depth of the samples around each pixel, in layers that look ever farther around
/// it (src/view/nearest.rs).
@group(2) @binding(7) var nearest_depths: texture_2d_array<f32>;

/// Places of the grid on each side (src/methods/adaptive/nearest_grid.rs).
const GRID_SIDE = 34u;

/// s of the nearest surface around places in a grid over all that the tile's rays pass.
var<workgroup> grid_s: array<f32, GRID_SIDE * GRID_SIDE>;
/// Where the grid begins, px of the outer frame.
var<private> grid_from: vec2f;

/// Fills the grid of a tile, each of its 64 invocations some places.
fn find_nearest(tile: vec2u, index: u32) {
    let first = vec2i(tile * TILE + adaptive.overscan) - i32(adaptive.grid_margin);
    grid_from = vec2f(first);
    for (var i = index; i < GRID_SIDE * GRID_SIDE; i += TILE * TILE) {
        // The pixel in the middle of the square for which the place stands.
        let place = vec2u(i % GRID_SIDE, i / GRID_SIDE);
        let pixel = first + vec2i(adaptive.grid_spacing * place + adaptive.grid_spacing / 2u);
        let at = clamp_to_image(pixel, textureDimensions(nearest_depths));
        grid_s[i] = s_of_depth(adaptive, textureLoad(nearest_depths, at, adaptive.grid_layer, 0).r);
    }
}

/// s of the nearest surface that a ray at a place, px of the outer frame, may meet within
/// `adaptive.grid_reach_px`.
fn nearest_around(place: vec2f) -> f32 {
    let at = vec2i(floor((place - grid_from) / f32(adaptive.grid_spacing)));
    let inside = vec2u(clamp(at, vec2i(0), vec2i(i32(GRID_SIDE) - 1)));
    return grid_s[inside.y * GRID_SIDE + inside.x];
}
