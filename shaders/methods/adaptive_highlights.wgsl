// adaptive, highlights: what is far brighter than white becomes emitters, listed by the
// tiles that their blur covers (src/methods/adaptive/highlights.rs).
//
// A few rays a pixel hit a small light once or never. So what a texel has above a limit
// is taken out of what rays read, and each pixel that its blur covers asks once whether it
// sees it. Texels of one cell, an eighth to a quarter of the blur's radius wide, make one
// emitter: however large a light is, a tile sees only so many.

#import layers

struct Highlights {
    /// Emitters that a tile can list.
    capacity: u32,
}

@group(0) @binding(0) var<uniform> adaptive: Adaptive;
@group(0) @binding(1) var<uniform> highlights: Highlights;
@group(0) @binding(2) var radii: texture_2d<f32>;
@group(0) @binding(3) var colors: texture_2d_array<f32>;
/// The number of emitters, then for each inner tile the length of its list.
@group(0) @binding(4) var<storage, read_write> emitter_counts: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> emitter_lists: array<u32>;
@group(0) @binding(6) var<storage, read_write> emitters: array<Emitter>;

/// Excess over the limit, and s.
var<workgroup> excess: array<vec4f, 64>;
/// log2 of the cell's side; 9 where there is no excess.
var<workgroup> cell_levels: array<u32, 64>;

const NO_CELL = 9u;

/// Cells of sides 1, 2, 4 and 8 texels in 8x8 of them.
const CELLS = 85u;

@compute @workgroup_size(8, 8)
fn find_emitters(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let k = i32(adaptive.fineness);
    let margin = i32(adaptive.first_tile * TILE) - i32(adaptive.overscan);
    let corner = vec2i(group.xy * TILE) - k * margin;
    let at = corner + vec2i(local.xy);
    cell_levels[index] = NO_CELL;
    if all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(radii))) {
        let s = textureLoad(radii, at, 0).x;
        let color = textureLoad(colors, at, 0, 0).rgb;
        let over = color - min(color, vec3f(highlight_limit(s)));
        if any(over > vec3f(0.0)) {
            excess[index] = vec4f(over, s);
            cell_levels[index] = u32(clamp(floor(log2(0.25 * abs(s) * f32(k))), 0.0, 3.0));
        }
    }
    workgroupBarrier();
    for (var cell = index; cell < CELLS; cell += 64u) {
        emit(corner, cell);
    }
}

/// Sums the texels of one cell, if there are any, to an emitter.
fn emit(corner: vec2i, cell: u32) {
    let level = select(select(select(3u, 2u, cell < 84u), 1u, cell < 80u), 0u, cell < 64u);
    let place = cell - array<u32, 4>(0u, 64u, 80u, 84u)[level];
    let side = 1u << level;
    let origin = side * vec2u(place % (TILE / side), place / (TILE / side));
    var emitter = Emitter();
    var sum = 0.0;
    for (var i = 0u; i < side * side; i++) {
        let offset = origin + vec2u(i % side, i / side);
        let index = offset.y * TILE + offset.x;
        if cell_levels[index] == level {
            let texel = excess[index];
            let weight = texel.r + texel.g + texel.b;
            emitter.excess += texel.rgb;
            emitter.at += weight * (vec2f(corner + vec2i(offset)) + 0.5);
            emitter.s += weight * texel.w;
            sum += weight;
        }
    }
    if sum == 0.0 {
        return;
    }
    let k = f32(adaptive.fineness);
    emitter.at = (emitter.at / sum + 0.5 * (k - 1.0)) / k;
    emitter.excess /= k * k;
    emitter.s /= sum;
    emitter.side = f32(side) / k;
    let number = atomicAdd(&emitter_counts[0], 1u);
    if number >= arrayLength(&emitters) {
        return;
    }
    emitters[number] = emitter;
    list(emitter, number);
}

/// Adds the emitter to the inner tiles that its blur, or the reading of its texels, covers.
fn list(emitter: Emitter, number: u32) {
    let reach = abs(emitter.s) * adaptive.lens_radius + 1.5 * emitter.side + 1.0;
    let centre = emitter.at - f32(adaptive.overscan);
    let first = vec2i(floor((centre - reach) / f32(TILE)));
    let last = vec2i(floor((centre + reach) / f32(TILE)));
    let from_tile = max(first, vec2i(0));
    let to_tile = min(last, vec2i(adaptive.inner_tiles) - 1);
    for (var y = from_tile.y; y <= to_tile.y; y++) {
        for (var x = from_tile.x; x <= to_tile.x; x++) {
            let tile = u32(y) * adaptive.inner_tiles.x + u32(x);
            let place = atomicAdd(&emitter_counts[1u + tile], 1u);
            if place < highlights.capacity {
                emitter_lists[tile * highlights.capacity + place] = number;
            }
        }
    }
}
