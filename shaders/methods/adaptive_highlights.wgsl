// adaptive, highlights: what is far brighter than white becomes emitters, listed by the
// tiles that their blur covers (src/methods/adaptive/highlights.rs).
//
// A few rays a pixel hit a small light once or never. So what a texel has above a limit
// is taken out of what rays read, and each pixel that its blur covers asks once whether it
// sees it. Pixels of one cell, an eighth to a quarter of the blur's radius wide, make one
// emitter: however large a light is, a tile sees only so many.

#import emitters
#import layers

@group(0) @binding(2) var<uniform> highlights: Highlights;
/// Of the first layer, by pixel of the outer frame.
@group(0) @binding(3) var<storage, read> lights: array<Light>;
@group(0) @binding(4) var colors: texture_2d_array<f32>;
@group(0) @binding(5) var depth: texture_2d_array<f32>;
/// By 8x8 pixels of the outer frame, the layers that hold light, a bit each.
@group(0) @binding(10) var<storage, read> light_tiles: array<u32>;
/// The number of emitters, then for each inner tile how many cover it.
@group(0) @binding(6) var<storage, read_write> emitter_counts: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> emitter_lists: array<u32>;
@group(0) @binding(8) var<storage, read_write> emitters: array<Emitter>;
/// For each inner tile the length of its list.
@group(0) @binding(9) var<storage, read_write> listed_counts: array<atomic<u32>>;

const NO_CELL = 9u;

/// By how many levels cells of the stretched border are larger: it is the same everywhere across
/// the border, and a tile sees only so many emitters.
const STRETCHED_LEVELS = 2.0;

/// Most layers that there are (`MAX_LAYERS` in src/methods/adaptive/mod.rs).
const MAX_LAYERS = 4u;

/// Of the blocks of the workgroup, in one layer.
var<workgroup> light_of: array<Light, 64>;
/// log2 of the cell's side, blocks; NO_CELL where there is nothing over the limit.
var<workgroup> cell_levels: array<u32, 64>;
/// The levels of each layer's cells, a bit each: none without light.
var<workgroup> levels_seen: array<atomic<u32>, MAX_LAYERS>;

/// Cells of sides of 1, 2, 4 and 8 blocks in 8x8 of them.
const CELLS = 85u;

/// Levels of the cells that a dispatch with larger blocks makes: 16 and 32 px.
const LARGE_LEVEL = 4u;
const MAX_LEVEL = 5u;

/// Each invocation has a block of pixels, of the outer frame and of its stretched border.
@compute @workgroup_size(8, 8)
fn find_emitters(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let block_px = highlights.block_px;
    let corner = first_pixel() + vec2i(block_px * TILE * group.xy);
    let at = corner + vec2i(block_px * local.xy);
    for (var layer = 0u; layer < adaptive.layers; layer++) {
        let light = block_light(at, layer);
        light_of[index] = light;
        cell_levels[index] = NO_CELL;
        if light.weight > 0.0 {
            let level = block_level(at, light);
            cell_levels[index] = level;
            atomicOr(&levels_seen[layer], 1u << level);
        }
        workgroupBarrier();
        // Loops that end at once, no branches: software adapters run both sides of those.
        let seen = atomicLoad(&levels_seen[layer]);
        for (var cell = index; cell < select(0u, CELLS, seen != 0u); cell += 64u) {
            emit(corner, cell, seen);
        }
        workgroupBarrier();
    }
}

/// The first pixel of the first tile in which emitters are looked for.
fn first_pixel() -> i32 {
    return i32(adaptive.overscan) - i32((adaptive.first_tile + highlights.margin_tiles) * TILE);
}

fn frame_size() -> vec2u {
    return textureDimensions(depth) / adaptive.fineness;
}

/// The light of a block's pixels, about the centre of the first, that belongs to cells of the sizes
/// that this dispatch makes.
fn block_light(at: vec2i, layer: u32) -> Light {
    let size = frame_size();
    var sum = Light();
    for (var i = 0u; i < min(highlights.block_px * highlights.block_px, 16u); i++) {
        let part = vec2u(i % highlights.block_px, i / highlights.block_px);
        let place = at + vec2i(part);
        // Rays that leave the frame meet its border stretched outwards, and so does light.
        let pixel = vec2u(clamp(place, vec2i(0), vec2i(size) - 1));
        var light = Light();
        if !holds_light(pixel, layer, size) {
            continue;
        }
        if layer == 0u {
            light = lights[pixel.y * size.x + pixel.x];
        } else {
            light = light_at(pixel, layer);
        }
        let level = cell_level(place, light, size);
        if level != NO_CELL && (level >= LARGE_LEVEL) == (highlights.block_px > 1u) {
            sum = added(sum, moved(light, vec2f(part)));
        }
    }
    return sum;
}

fn holds_light(pixel: vec2u, layer: u32, size: vec2u) -> bool {
    let tile = pixel / TILE;
    return (light_tiles[tile.y * ((size.x + TILE - 1u) / TILE) + tile.x] & (1u << layer)) != 0u;
}

/// log2 of the side, blocks, of a block's cell.
fn block_level(at: vec2i, light: Light) -> u32 {
    let level = cell_level(at, light, frame_size());
    if highlights.block_px == 1u {
        return level;
    }
    // In blocks of 4 px; where pixels differ in blur their mean may be beyond the frame's reach.
    return clamp(select(level, LARGE_LEVEL, level == NO_CELL), LARGE_LEVEL, MAX_LEVEL) - 2u;
}

/// How far a light's blur reaches, px.
fn blur_px(light: Light) -> f32 {
    return greatest_s(s_of(light)) * adaptive.lens_radius;
}

/// log2 of the side, px, of cells for a blur of that radius, px.
fn level_of_blur(blur: f32) -> f32 {
    return floor(log2(0.25 * blur));
}

/// log2 of the side, px, of the cell that a pixel's light belongs to: larger beyond the frame, where
/// the cell has no pixels of the frame; NO_CELL without light, or where its blur does not reach the
/// frame.
fn cell_level(at: vec2i, light: Light, size: vec2u) -> u32 {
    if light.weight <= 0.0 {
        return NO_CELL;
    }
    // In the frame no cell is wider than the narrower side of an astigmatic eye's blur allows.
    let inside = level_of_blur(least_s(s_of(light)) * adaptive.lens_radius);
    let exact = level_of_blur(blur_px(light));
    let coarse = u32(clamp(max(exact, min(exact + STRETCHED_LEVELS, 3.0)), 0.0, f32(MAX_LEVEL)));
    let corner = first_pixel();
    let first = corner + (((at - corner) >> vec2u(coarse)) << vec2u(coarse));
    // 1 px from the last pixel of the cell to the frame's first: next to it.
    let gaps = max(-(first + (1 << coarse) - 1), first - vec2i(size) + 1);
    let gap = max(gaps.x, gaps.y);
    let beyond = select(NO_CELL, coarse, f32(gap) <= blur_px(light) + 1.0);
    return select(u32(clamp(inside, 0.0, f32(MAX_LEVEL))), beyond, gap > 0);
}

/// CoC radius of a light, px.
fn s_of(light: Light) -> f32 {
    return s_of_depth(adaptive, light.z / light.weight);
}

/// What a hidden layer has over the limit in a pixel.
fn light_at(pixel: vec2u, layer: u32) -> Light {
    let k = adaptive.fineness;
    var nearest = -1.0;
    for (var i = 0u; i < k * k; i++) {
        nearest = max(nearest, textureLoad(depth, k * pixel + vec2u(i % k, i / k), layer, 0).r);
    }
    // Most of a hidden layer is empty.
    let count = select(0u, k * k, nearest >= 0.0);
    var light = Light();
    for (var i = 0u; i < count; i++) {
        let part = vec2u(i % k, i / k);
        let z = textureLoad(depth, k * pixel + part, layer, 0).r;
        if z >= 0.0 {
            let color = textureLoad(colors, k * pixel + part, layer, 0).rgb;
            light = with_sample(light, color, z, vec2f(part) / f32(k), 1.0 / f32(k * k));
        }
    }
    return light;
}

/// Sums the blocks of one cell, if there is light in any, to an emitter; `seen` are the
/// levels of all that there is.
fn emit(corner: vec2i, cell: u32, seen: u32) {
    let level = select(select(select(3u, 2u, cell < 84u), 1u, cell < 80u), 0u, cell < 64u);
    let place = cell - array<u32, 4>(0u, 64u, 80u, 84u)[level];
    let side = 1u << level;
    let origin = side * vec2u(place % (TILE / side), place / (TILE / side));
    var emitter = Emitter();
    var weight = 0.0;
    // First and second moments about the centre of the cell's first pixel.
    var mean = vec2f(0.0);
    var moments = vec3f(0.0);
    let count = select(0u, side * side, ((seen >> level) & 1u) != 0u);
    for (var i = 0u; i < count; i++) {
        let from_origin = vec2u(i % side, i / side);
        let index = (origin.y + from_origin.y) * TILE + origin.x + from_origin.x;
        if cell_levels[index] == level {
            let light = light_of[index];
            let s = s_of(light);
            let share = emitted_share(greatest_s(s), adaptive.lens_radius, adaptive.is_image != 0u);
            let here = moved(light, f32(highlights.block_px) * vec2f(from_origin));
            emitter.excess += share * here.excess;
            emitter.s += share * here.weight * s;
            mean += share * here.offset;
            moments += share * here.moments;
            weight += share * here.weight;
        }
    }
    if weight == 0.0 {
        return;
    }
    mean /= weight;
    emitter.s /= weight;
    emitter.at = vec2f(corner + vec2i(highlights.block_px * origin)) + 0.5 + mean;
    emitter.spread = moments / weight - moments_of(mean);
    // A square of side a has the variance a^2 / 12 on each axis; samples stand for squares.
    let sample_variance = highlights.sample_px * highlights.sample_px / 12.0;
    emitter.spread = vec3f(max(emitter.spread.xy, vec2f(0.0)) + sample_variance, emitter.spread.z);
    let number = atomicAdd(&emitter_counts[0], 1u);
    if number >= arrayLength(&emitters) {
        return;
    }
    emitters[number] = emitter;
}

/// A rectangle of tiles of the inner frame.
struct Covered {
    first: vec2u,
    columns: u32,
    /// How many there are in all.
    count: u32,
}

/// The inner tiles that an emitter's blur, or the reading of its texels, covers.
fn covered_by(emitter: Emitter) -> Covered {
    let blur = 0.5 * blur_extent_px(adaptive.lens, 2.0 * emitter.s);
    let reach = blur * adaptive.lens_radius + 1.5 * side_of(emitter) + 1.0;
    let centre = emitter.at - f32(adaptive.overscan);
    let first = vec2i(floor((centre - reach) / f32(TILE)));
    let last = vec2i(floor((centre + reach) / f32(TILE)));
    let from_tile = max(first, vec2i(0));
    let sides = vec2u(max(min(last + 1, vec2i(adaptive.inner_tiles)) - from_tile, vec2i(0)));
    return Covered(vec2u(from_tile), max(sides.x, 1u), sides.x * sides.y);
}

/// The index of one of them among all inner tiles.
fn covered_tile(covered: Covered, i: u32) -> u32 {
    let tile = covered.first + vec2u(i % covered.columns, i / covered.columns);
    return tile.y * adaptive.inner_tiles.x + tile.x;
}

/// Counts the emitters of each tile.
@compute @workgroup_size(64)
fn count_emitters(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let count = min(atomicLoad(&emitter_counts[0]), arrayLength(&emitters));
    let all_tiles = adaptive.inner_tiles.x * adaptive.inner_tiles.y;
    for (var number = group.x; number < count; number += LISTING) {
        let covered = covered_by(emitters[number]);
        for (var i = index; i < min(covered.count, all_tiles); i += 64u) {
            atomicAdd(&emitter_counts[1u + covered_tile(covered, i)], 1u);
        }
    }
}

/// A number in [0, 1) for each emitter, by its place: the lattice R2 of Roberts, "The Unreasonable
/// Effectiveness of Quasirandom Sequences" (2018), so that a share of an even light is even.
fn rank_of(emitter: Emitter) -> f32 {
    return fract(dot(emitter.at, vec2f(0.7548776662, 0.5698402910)));
}

/// How full, of 1, lists are made of tiles with more emitters than fit: were they chosen by chance,
/// their number would have a standard deviation of 22, and a fifth of the capacity is five of those.
const FILLED = 0.8;

/// Workgroups that count and list emitters (src/methods/adaptive/highlights.rs): each takes an emitter
/// after the other, and its invocations the tiles that the emitter covers.
const LISTING = 1024u;

/// Lists emitters by tile, after all are counted: where there are more than fit, a share by
/// their places, so that the same are listed whichever comes first.
@compute @workgroup_size(64)
fn list_emitters(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let count = min(atomicLoad(&emitter_counts[0]), arrayLength(&emitters));
    let all_tiles = adaptive.inner_tiles.x * adaptive.inner_tiles.y;
    for (var number = group.x; number < count; number += LISTING) {
        let covered = covered_by(emitters[number]);
        let rank = rank_of(emitters[number]);
        for (var i = index; i < min(covered.count, all_tiles); i += 64u) {
            let tile = covered_tile(covered, i);
            let wanted = atomicLoad(&emitter_counts[1u + tile]);
            let share = FILLED * f32(highlights.capacity) / f32(max(wanted, 1u));
            if wanted <= highlights.capacity || rank < share {
                let place = atomicAdd(&listed_counts[tile], 1u);
                if place < highlights.capacity {
                    emitter_lists[tile * highlights.capacity + place] = number;
                }
            }
        }
    }
}
