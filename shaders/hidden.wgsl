// What an image hides, guessed from what is seen beside it (src/view/hidden.rs).
//
// A surface that passes behind a nearer one goes on there. Each row and column is followed in
// both directions by one invocation, which remembers the surfaces that nearer ones have
// interrupted, last one first:
//
//   wall | card in front of it | wall
//   ---> remembers "wall" from here on, until it is seen again
//
// A pixel gets the mean of what the four directions remember, the nearer the end of a surface
// the more, where they agree on the depth; else what ends nearest.

struct Params {
    /// Stored depth that a hidden surface lies behind what hides it at least.
    separation_z: f32,
    /// 0 to the right, 1 to the left, 2 down, 3 up.
    direction: u32,
    /// Of the image, px.
    size: vec2u,
}

struct Guess {
    color: vec3f,
    /// 0: none.
    weight: f32,
    z: f32,
}

struct Surface {
    color: vec3f,
    z: f32,
    /// Pixel of the row or column where it was seen last.
    last: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> guesses: array<Guess>;
/// REMEMBERED for each row or column.
@group(0) @binding(4) var<storage, read_write> interrupted: array<Surface>;
/// Stored depth in front of which no hidden surface may lie; -1: none is wanted.
@group(0) @binding(5) var below: texture_2d<f32>;
@group(0) @binding(6) var hidden_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(7) var hidden_depth: texture_storage_2d<r32float, write>;

/// Most interrupted surfaces; of more the first are forgotten.
const REMEMBERED = 16u;

/// Share of a pixel in the mean colour of a surface that goes on: outlines of photographs hold
/// some of both sides, and one pixel's noise is not to be drawn out to a streak.
const SHARE = 0.3;

fn pixel_of(row: u32, i: u32) -> vec2u {
    let length = select(params.size.y, params.size.x, params.direction < 2u);
    let along = select(i, length - 1u - i, (params.direction & 1u) == 1u);
    return select(vec2u(row, along), vec2u(along, row), params.direction < 2u);
}

@compute @workgroup_size(64)
fn follow(@builtin(global_invocation_id) id: vec3u) {
    let is_row = params.direction < 2u;
    let row = id.x;
    let length = select(0u, select(params.size.y, params.size.x, is_row), row < select(params.size.x, params.size.y, is_row));
    let first = row * REMEMBERED;
    // The stack is a ring: `count` surfaces end at `top`.
    var top = 0u;
    var count = 0u;
    var seen = Surface();
    for (var i = 0u; i < length; i++) {
        let at = pixel_of(row, i);
        let z = textureLoad(depth, at, 0).r;
        let here = textureLoad(color, at, 0).rgb;
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
        if count > 0u {
            add_guess(at, interrupted[first + top], i);
        }
        let goes_on = i > 0u && abs(z - seen.z) <= params.separation_z;
        seen = Surface(mix(here, seen.color, select(0.0, 1.0 - SHARE, goes_on)), z, i);
    }
}

fn add_guess(at: vec2u, surface: Surface, i: u32) {
    let distance = f32(i - surface.last);
    let weight = 1.0 / (distance * distance);
    let index = at.y * params.size.x + at.x;
    var guess = guesses[index];
    if abs(guess.z - surface.z) > params.separation_z && guess.weight > 0.0 {
        // They disagree: what ends nearer.
        if weight <= guess.weight {
            return;
        }
        guess = Guess();
    }
    let sum = guess.weight + weight;
    let share = weight / sum;
    guesses[index] = Guess(mix(guess.color, surface.color, share), sum, mix(guess.z, surface.z, share));
}

/// The image of what is hidden: alpha 0, and what was seen, where nothing is.
@compute @workgroup_size(8, 8)
fn show_hidden(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.size) {
        return;
    }
    let guess = guesses[id.y * params.size.x + id.x];
    if guess.weight > 0.0 && guess.z <= textureLoad(below, id.xy, 0).r {
        textureStore(hidden_color, id.xy, vec4f(guess.color, 1.0));
        textureStore(hidden_depth, id.xy, vec4f(guess.z));
    } else {
        textureStore(hidden_color, id.xy, vec4f(textureLoad(color, id.xy, 0).rgb, 0.0));
        textureStore(hidden_depth, id.xy, textureLoad(depth, id.xy, 0));
    }
}
