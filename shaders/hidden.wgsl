// What an image hides, guessed from what is seen beside it (src/view/hidden.rs).
//
// A surface that passes behind a nearer one goes on there. Each row and column is followed in
// both directions by one invocation, which remembers the surfaces that nearer ones have
// interrupted, last one first:
//
//   wall | card in front of it | wall
//   ---> remembers "wall" from here on, until it is seen again
//
// A pixel gets the mean of what the four directions remember, where they agree (`hidden_at`).

struct Params {
    /// Stored depth that a hidden surface lies behind what hides it at least.
    separation_z: f32,
    _unused: u32,
    /// Of the image, px.
    size: vec2u,
}

struct Surface {
    z: f32,
    /// Pixel of the row or column where it was seen last.
    last: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
/// For each pixel and direction the distance back to the end of the surface that it remembers, px;
/// 0: none.
@group(0) @binding(3) var<storage, read_write> distances: array<u32>;
/// REMEMBERED for each row or column in each direction.
@group(0) @binding(4) var<storage, read_write> interrupted: array<Surface>;
/// Stored depth in front of which no hidden surface may lie; -1: none is wanted.
@group(0) @binding(5) var below: texture_2d<f32>;
@group(0) @binding(6) var hidden_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(7) var hidden_depth: texture_storage_2d<r32float, write>;

/// To the right, to the left, down, up.
const DIRECTIONS = 4u;

/// Most interrupted surfaces; of more the first are forgotten.
const REMEMBERED = 16u;

fn pixel_of(direction: u32, row: u32, i: u32) -> vec2u {
    let length = select(params.size.y, params.size.x, direction < 2u);
    let along = select(i, length - 1u - i, (direction & 1u) == 1u);
    return select(vec2u(row, along), vec2u(along, row), direction < 2u);
}

@compute @workgroup_size(64)
fn follow(@builtin(global_invocation_id) id: vec3u) {
    let row = id.x;
    let direction = id.y;
    let sides = select(params.size, params.size.yx, direction < 2u);
    let length = select(0u, sides.y, row < sides.x);
    let first = (direction * max(params.size.x, params.size.y) + row) * REMEMBERED;
    // The stack is a ring: `count` surfaces end at `top`.
    var top = 0u;
    var count = 0u;
    var seen = Surface();
    for (var i = 0u; i < length; i++) {
        let at = pixel_of(direction, row, i);
        let z = textureLoad(depth, at, 0).r;
        if i > 0u && z > seen.z + params.separation_z {
            top = (top + 1u) % REMEMBERED;
            count = min(count + 1u, REMEMBERED);
            interrupted[first + top] = seen;
        }
        for (var k = 0u; k < REMEMBERED; k++) {
            if count == 0u {
                break;
            }
            if interrupted[first + top].z < z - params.separation_z {
                break;
            }
            top = (top + REMEMBERED - 1u) % REMEMBERED;
            count -= 1u;
        }
        let last = interrupted[first + top].last;
        distances[DIRECTIONS * (at.y * params.size.x + at.x) + direction] = select(0u, i - last, count > 0u);
        seen = Surface(z, i);
    }
}

/// Share of the last pixel in the colour with which a surface goes on, of the one before it in what
/// is left, and so on: outlines of photographs hold some of both sides, and one pixel's noise is
/// not to be drawn out to a streak.
const SHARE = 0.3;

/// Pixels whose mean that is, the last with what is left: 0.7^7, 8 %.
const AVERAGED = 8u;

/// Where a direction comes from.
fn back(direction: u32) -> vec2i {
    let sign = select(-1, 1, (direction & 1u) == 1u);
    return select(vec2i(0, sign), vec2i(sign, 0), direction < 2u);
}

fn z_at(pixel: vec2i) -> f32 {
    return textureLoad(depth, pixel, 0).r;
}

/// The colour of the surface that ends at `pixel`, seen in `direction`.
fn color_before(pixel: vec2i, direction: u32) -> vec3f {
    var at = pixel;
    var sum = vec3f(0.0);
    var left = 1.0;
    for (var k = 0u; k < AVERAGED; k++) {
        let next = at + back(direction);
        let goes_on = all(next >= vec2i(0)) && all(next < vec2i(params.size))
            && abs(z_at(next) - z_at(at)) <= params.separation_z;
        let is_last = !goes_on || k + 1u == AVERAGED;
        let share = select(SHARE * left, left, is_last);
        sum += share * textureLoad(color, at, 0).rgb;
        if is_last {
            break;
        }
        left -= share;
        at = next;
    }
    return sum;
}

/// Radiance and depth of what a pixel hides.
struct Hidden {
    color: vec3f,
    z: f32,
    is_there: bool,
}

/// The mean of what the directions remember, the nearer the end of a surface the more, of those
/// that agree on the depth with what ends nearest; of two that end as near, with the farther one,
/// so that no direction comes first.
fn hidden_at(pixel: vec2u) -> Hidden {
    let first = DIRECTIONS * (pixel.y * params.size.x + pixel.x);
    var least = 0u;
    var z = 0.0;
    for (var i = 0u; i < DIRECTIONS; i++) {
        let distance = distances[first + i];
        if distance > 0u {
            let end_z = z_at(vec2i(pixel) + i32(distance) * back(i));
            if least == 0u || distance < least || (distance == least && end_z < z) {
                least = distance;
                z = end_z;
            }
        }
    }
    var hidden = Hidden(vec3f(0.0), 0.0, least > 0u);
    var sum = 0.0;
    for (var i = 0u; i < DIRECTIONS; i++) {
        let distance = distances[first + i];
        if distance > 0u {
            let end = vec2i(pixel) + i32(distance) * back(i);
            let end_z = z_at(end);
            if abs(end_z - z) <= params.separation_z {
                // Of the nearest 1, so that no sum is too great or too small.
                let weight = f32(least * least) / f32(distance * distance);
                hidden.color += weight * color_before(end, i);
                hidden.z += weight * end_z;
                sum += weight;
            }
        }
    }
    hidden.color /= max(sum, 1.0);
    hidden.z /= max(sum, 1.0);
    return hidden;
}

/// The image of what is hidden: alpha 0, and what was seen, where nothing is.
@compute @workgroup_size(8, 8)
fn show_hidden(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.size) {
        return;
    }
    let hidden = hidden_at(id.xy);
    if hidden.is_there && hidden.z <= textureLoad(below, id.xy, 0).r {
        textureStore(hidden_color, id.xy, vec4f(hidden.color, 1.0));
        textureStore(hidden_depth, id.xy, vec4f(hidden.z));
    } else {
        textureStore(hidden_color, id.xy, vec4f(textureLoad(color, id.xy, 0).rgb, 0.0));
        textureStore(hidden_depth, id.xy, textureLoad(depth, id.xy, 0));
    }
}
