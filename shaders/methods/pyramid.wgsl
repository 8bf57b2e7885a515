// pyramid: sub-images with disocclusion, Kraus and Strengert 2007 (src/methods/pyramid.rs).
//
// Sub-images and levels as in lib/subimages.wgsl. Here: pull-push, which fills what nearer
// surfaces hide; the matte, fused with the first analysis step; and the last synthesis
// step, fused with blending. What reads pixels works on blocks of 2x2 of them, in all
// sub-images: a pixel is read once.
//
// Pull-push texels are premultiplied with w, how well a texel is known: (w rgb, w), w z.

#import subimage_pixels

@group(0) @binding(6) var known_color: texture_2d_array<f32>;
@group(0) @binding(7) var known_depth: texture_2d_array<f32>;
@group(0) @binding(8) var filled_color: texture_2d_array<f32>;
@group(0) @binding(9) var filled_depth: texture_2d_array<f32>;
@group(0) @binding(10) var color_out: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(11) var depth_out: texture_storage_2d_array<r32float, write>;
@group(0) @binding(12) var coarser: texture_storage_2d_array<COLOR_FORMAT, write>;
@group(0) @binding(13) var analysis: texture_2d_array<f32>;
@group(0) @binding(14) var blur: texture_2d_array<f32>;
@group(0) @binding(15) var result: texture_storage_2d<COLOR_FORMAT, write>;

struct Filling {
    /// Levels that one workgroup a layer makes: those coarser than `finest`, up to `coarsest`.
    finest: u32,
    coarsest: u32,
    /// Texels of all of them, a layer.
    texels: u32,
    /// First layer of which the filled level 1 is stored.
    first_stored: u32,
}

@group(0) @binding(16) var<uniform> filling: Filling;
@group(0) @binding(17) var<storage, read_write> coarse_color: array<vec4f>;
@group(0) @binding(18) var<storage, read_write> coarse_depth: array<f32>;

/// A premultiplied texel of pull-push.
struct Known {
    color: vec4f,
    z: f32,
}

fn nothing() -> Known {
    return Known(vec4f(0.0), 0.0);
}

fn plus(a: Known, weight: f32, b: Known) -> Known {
    return Known(a.color + weight * b.color, a.z + weight * b.z);
}

/// A pixel, as far as it is not in front of the layer's sub-image. Nothing is known beyond the
/// border: that is extrapolated.
fn culled(layer: u32, p: Pixel) -> Known {
    let w = not_in_front(sub_images.ramps[layer], p.x);
    if w == 0.0 {
        return nothing();
    }
    return Known(w * vec4f(p.color, 1.0), w * p.z);
}

// ---- disocclusion: pull ----

/// Sums over blocks; where layers follow one another, of two of them.
var<workgroup> block_colors: array<vec4f, 512>;
var<workgroup> block_depths: array<f32, 512>;

/// The box that begins with the block in `slot`. One known texel in the box is enough to know
/// its mean.
fn mean_of_box(slot: u32) -> Known {
    let below = slot + BLOCKS;
    let color = block_colors[slot] + block_colors[slot + 1u] + block_colors[below] + block_colors[below + 1u];
    let z = block_depths[slot] + block_depths[slot + 1u] + block_depths[below] + block_depths[below + 1u];
    let scale = 1.0 / max(color.a, 1.0);
    return Known(scale * color, scale * z);
}

fn store(texel: vec2u, layer: u32, known: Known) {
    textureStore(color_out, texel, layer, known.color);
    textureStore(depth_out, texel, layer, vec4f(known.z));
}

@compute @workgroup_size(16, 16)
fn pull_image(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(color_out);
    let texel = BOXES * group.xy + local.xy;
    let pixels = pixel_block(texel_from_centre(texel, size), true);
    note_layers(ramp_variables(pixels));
    workgroupBarrier();
    if index == 0u {
        atomicOr(&occupied_out, atomicLoad(&found_here));
    }
    let known = atomicLoad(&known_here);
    let stores = all(local.xy < vec2u(BOXES)) && all(texel < size);
    var slot = index;
    for (var layer = 0u; layer < sub_images.count; layer++) {
        if !is_occupied(known, layer) {
            if stores {
                store(texel, layer, nothing());
            }
            continue;
        }
        var sum = plus(culled(layer, pixels.a), 1.0, culled(layer, pixels.b));
        sum = plus(plus(sum, 1.0, culled(layer, pixels.c)), 1.0, culled(layer, pixels.d));
        block_colors[slot] = sum.color;
        block_depths[slot] = sum.z;
        workgroupBarrier();
        if stores {
            store(texel, layer, mean_of_box(slot));
        }
        // The other half is free: all have read it before they came to the barrier.
        slot ^= 256u;
    }
}

fn known_at(at: vec2i, layer: u32) -> Known {
    return Known(textureLoad(known_color, at, layer, 0), textureLoad(known_depth, at, layer, 0).r);
}

@compute @workgroup_size(16, 16)
fn pull_level(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(color_out);
    let finer = textureDimensions(known_color);
    let texel = BOXES * group.xy + local.xy;
    let is_here = is_occupied(occupied, group.z);
    if is_here {
        let b = texel_from_centre(texel, size);
        var sum = nothing();
        for (var i = 0u; i < 4u; i++) {
            let at = texel_index(block_texel(b, i), finer);
            if all(at >= vec2i(0)) && all(at < vec2i(finer)) {
                sum = plus(sum, 1.0, known_at(at, group.z));
            }
        }
        block_colors[index] = sum.color;
        block_depths[index] = sum.z;
    }
    workgroupBarrier();
    if is_here && all(local.xy < vec2u(BOXES)) && all(texel < size) {
        store(texel, group.z, mean_of_box(index));
    }
}

// ---- disocclusion: push ----

/// `known`, completed with what is known around it on the coarser level.
fn completed(known: Known, around: Known) -> Known {
    if known.color.a >= 1.0 {
        return known;
    }
    let missing = 1.0 - known.color.a;
    return plus(known, missing / max(around.color.a, 1e-6), around);
}

/// What the filled coarser level has around a block.
struct Around {
    color: Quad,
    depth: Quad,
}

fn around_block(b: vec2i, layer: u32) -> Around {
    let place = quad_place(b, textureDimensions(filled_color));
    return Around(quad_of(filled_color, place, layer), quad_of(filled_depth, place, layer));
}

fn at_corner(around: Around, i: u32) -> Known {
    return Known(expanded(around.color, i), expanded(around.depth, i).r);
}

@compute @workgroup_size(16, 16)
fn push_level(
    @builtin(workgroup_id) group: vec3u,
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(color_out);
    let first = first_around(texel_from_centre(TILE * group.xy, size));
    let is_here = is_occupied(occupied, group.z);
    if is_here && index < AROUND * AROUND {
        let at = around_texel(first, index, textureDimensions(filled_color));
        around_colors[index] = textureLoad(filled_color, at, group.z, 0);
        around_numbers[index] = textureLoad(filled_depth, at, group.z, 0).r;
    }
    workgroupBarrier();
    if is_here && all(id.xy < size) {
        let place = place_in(first, texel_from_centre(id.xy, size));
        let around = Known(expanded_color(place), expanded_number(place));
        store(id.xy, id.z, completed(known_at(vec2i(id.xy), id.z), around));
    }
}

// ---- disocclusion: coarse levels ----
//
// Of levels of few texels a workgroup makes all, down and up again: dispatches of their own
// would take longer to start than to run.

fn coarse_size(l: u32) -> vec2u {
    let cells = vec2u(sub_images.centre) + (1u << l) - 1u;
    return 2u * ((cells >> vec2u(l)) + 1u);
}

/// Where texel `at` of a level that begins at `first` lies; one beyond the border is the nearest.
fn coarse_place(first: u32, at: vec2i, size: vec2u) -> u32 {
    let inside = vec2u(clamp(at, vec2i(0), vec2i(size) - 1));
    return first + inside.y * size.x + inside.x;
}

fn coarse_texel(place: u32) -> Known {
    return Known(coarse_color[place], coarse_depth[place]);
}

/// Texel p from the centre of the level above `finer`, which begins at `first`.
fn coarse_mean(p: vec2i, finer: u32, first: u32) -> Known {
    let size = coarse_size(finer);
    var sum = nothing();
    for (var i = 0; i < 16; i++) {
        let at = texel_index(2 * p - 1 + vec2i(i % 4, i / 4), size);
        let texel = coarse_texel(coarse_place(first, at, size));
        sum = plus_inside(sum, texel, all(at >= vec2i(0)) && all(at < vec2i(size)));
    }
    return mean_of(sum);
}

/// The same of the level above the finest, which is a texture.
fn mean_above_finest(p: vec2i, layer: u32) -> Known {
    let size = textureDimensions(known_color);
    var sum = nothing();
    for (var i = 0; i < 16; i++) {
        let at = texel_index(2 * p - 1 + vec2i(i % 4, i / 4), size);
        let inside = clamp(at, vec2i(0), vec2i(size) - 1);
        sum = plus_inside(sum, known_at(inside, layer), all(at == inside));
    }
    return mean_of(sum);
}

/// All texels are read, so that they can be read at once; one beyond the border counts nothing.
fn plus_inside(sum: Known, texel: Known, is_inside: bool) -> Known {
    return Known(
        sum.color + select(vec4f(0.0), texel.color, is_inside),
        sum.z + select(0.0, texel.z, is_inside),
    );
}

fn mean_of(sum: Known) -> Known {
    let scale = 1.0 / max(sum.color.a, 1.0);
    return Known(scale * sum.color, scale * sum.z);
}

/// What level l, which begins at `first` and is filled, has around texel p of the finer one.
fn coarse_around(p: vec2i, l: u32, first: u32) -> Known {
    let size = coarse_size(l);
    let b = (p + 1) >> vec2u(1u);
    let last = texel_index(b, size);
    let top_left = coarse_texel(coarse_place(first, last - 1, size));
    let top_right = coarse_texel(coarse_place(first, last - vec2i(0, 1), size));
    let bottom_left = coarse_texel(coarse_place(first, last - vec2i(1, 0), size));
    let bottom_right = coarse_texel(coarse_place(first, last, size));
    let corner = vec2u(p - (2 * b - 1));
    return at_corner(
        Around(
            Quad(top_left.color, top_right.color, bottom_left.color, bottom_right.color),
            Quad(vec4f(top_left.z), vec4f(top_right.z), vec4f(bottom_left.z), vec4f(bottom_right.z)),
        ),
        corner.x + 2u * corner.y,
    );
}

fn texels_of(size: vec2u) -> u32 {
    return size.x * size.y;
}

/// Stores what is known of a level, which begins at `first`: a texel an invocation.
fn pull_coarse(l: u32, first: u32, finer_first: u32, layer: u32, index: u32) {
    let size = coarse_size(l);
    let texels = texels_of(size);
    for (var i = index; i < texels; i += 256u) {
        let p = texel_from_centre(vec2u(i % size.x, i / size.x), size);
        var mean: Known;
        if l == filling.finest + 1u {
            mean = mean_above_finest(p, layer);
        } else {
            mean = coarse_mean(p, l - 1u, finer_first);
        }
        coarse_color[first + i] = mean.color;
        coarse_depth[first + i] = mean.z;
    }
}

/// Fills a level, which begins at `first`, from the coarser one.
fn push_coarse(l: u32, first: u32, coarser_first: u32, index: u32) {
    let size = coarse_size(l);
    let texels = texels_of(size);
    for (var i = index; i < texels; i += 256u) {
        let p = texel_from_centre(vec2u(i % size.x, i / size.x), size);
        let filled = completed(coarse_texel(first + i), coarse_around(p, l + 1u, coarser_first));
        coarse_color[first + i] = filled.color;
        coarse_depth[first + i] = filled.z;
    }
}

@compute @workgroup_size(256)
fn fill_coarse(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let layer = group.z;
    if !is_occupied(occupied, layer) {
        return;
    }
    let above = filling.coarsest - filling.finest;
    var finer_first = layer * filling.texels;
    var first = finer_first;
    for (var step = 1u; step <= above; step++) {
        let l = filling.finest + step;
        pull_coarse(l, first, finer_first, layer, index);
        storageBarrier();
        finer_first = first;
        first += texels_of(coarse_size(l));
    }
    // Now `finer_first` is where the coarsest begins. It is as filled as it will be.
    var filled_first = finer_first;
    for (var step = 1u; step < above; step++) {
        let l = filling.coarsest - step;
        let begin = filled_first - texels_of(coarse_size(l));
        push_coarse(l, begin, filled_first, index);
        storageBarrier();
        filled_first = begin;
    }
    let size = textureDimensions(known_color);
    for (var i = index; i < size.x * size.y; i += 256u) {
        let at = vec2u(i % size.x, i / size.x);
        let around = coarse_around(texel_from_centre(at, size), filling.finest + 1u, filled_first);
        store(at, layer, completed(known_at(vec2i(at), layer), around));
    }
}

// ---- matte and blur ----

/// The disoccluded sub-image, matted and premultiplied, at a pixel: corner i of its block.
fn matted(layer: u32, p: Pixel, around: Around, i: u32) -> vec4f {
    let filled = completed(culled(layer, p), at_corner(around, i));
    // The rising ramp was the culling's: what is in front has been replaced.
    let omega = not_behind(sub_images.ramps[layer], ramp_variable(sub_images.variance_ramps, lens, filled.z));
    return omega * filled.color;
}

/// Layers in front of whose sub-image any of a block's pixels lies, by whatever part.
fn layers_with_holes(x: vec4f) -> u32 {
    var layers = 0u;
    for (var layer = 0u; layer < sub_images.count; layer++) {
        layers |= select(0u, 1u << layer, any(x < vec4f(sub_images.ramps[layer].y)));
    }
    return layers;
}

/// Texels along a side of which a workgroup makes the matted level 1: with one more on each side,
/// as many as there are invocations, all are filled that its blocks lie between.
const MATTED = 14u;

/// Level 1 filled, of the layer at hand, is in the first half of `block_colors` and in
/// `block_depths`: what a block lies between.
fn around_invocation(index: u32) -> Around {
    let above = index - BLOCKS;
    return Around(
        Quad(block_colors[above - 1u], block_colors[above], block_colors[index - 1u], block_colors[index]),
        Quad(
            vec4f(block_depths[above - 1u]),
            vec4f(block_depths[above]),
            vec4f(block_depths[index - 1u]),
            vec4f(block_depths[index]),
        ),
    );
}

@compute @workgroup_size(16, 16)
fn matte_and_reduce(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let size = textureDimensions(coarser);
    let begin = vec2i(MATTED * group.xy) - 1;
    let texel = begin + vec2i(local.xy);
    let b = texel - vec2i(size / 2u);
    let pixels = pixel_block(b, true);
    atomicOr(&known_here, layers_with_holes(ramp_variables(pixels)));
    workgroupBarrier();
    let holes = atomicLoad(&known_here);
    // Beyond the border is what is nearest to it.
    let inside = clamp(texel, vec2i(0), vec2i(size) - 1);
    let first = first_around(begin - vec2i(size / 2u));
    let place = place_in(first, inside - vec2i(size / 2u));
    let has_block = all(local.xy > vec2u(0u));
    let is_own = has_block && all(local.xy <= vec2u(MATTED)) && all(texel < vec2i(size));
    for (var layer = 0u; layer < sub_images.count; layer++) {
        let is_stored = layer >= filling.first_stored;
        let is_blurred = sub_images.order[layer].x > 0u;
        if !is_occupied(occupied, layer) || !(is_stored || is_blurred) {
            continue;
        }
        let is_filled = is_stored || is_occupied(holes, layer);
        if is_filled && index < AROUND * AROUND {
            let at = around_texel(first, index, textureDimensions(filled_color));
            around_colors[index] = textureLoad(filled_color, at, layer, 0);
            around_numbers[index] = textureLoad(filled_depth, at, layer, 0).r;
        }
        workgroupBarrier();
        if is_filled {
            let around = Known(expanded_color(place), expanded_number(place));
            let filled = completed(known_at(inside, layer), around);
            block_colors[index] = filled.color;
            block_depths[index] = filled.z;
            if is_stored && is_own {
                store(vec2u(texel), layer - filling.first_stored, filled);
            }
        }
        workgroupBarrier();
        if !is_blurred {
            continue;
        }
        var around: Around;
        if is_filled && has_block {
            around = around_invocation(index);
        }
        block_colors[256u + index] = matted(layer, pixels.a, around, 0u) + matted(layer, pixels.b, around, 1u)
            + matted(layer, pixels.c, around, 2u) + matted(layer, pixels.d, around, 3u);
        workgroupBarrier();
        if is_own {
            let slot = 256u + index;
            let below = slot + BLOCKS;
            let sum = block_colors[slot] + block_colors[slot + 1u] + block_colors[below] + block_colors[below + 1u];
            textureStore(coarser, texel, layer, sum / 16.0);
        }
    }
}

/// Light so far, from the front; the share of what is behind that shows through, and that
/// without what repeated inclusion adds.
struct Seen {
    light: vec3f,
    through: f32,
    transparency: f32,
}

fn behind(seen: Seen, sub: vec4f) -> Seen {
    return Seen(
        seen.light + seen.through * sub.rgb,
        seen.through * (1.0 - (1.0 - sub_images.repeated_inclusion) * sub.a),
        seen.transparency * (1.0 - sub.a),
    );
}

/// Divided by the opacity that was reached.
fn color_of(seen: Seen) -> vec3f {
    return seen.light / max(1.0 - seen.transparency, 1e-6);
}

/// Blending from front to back.
@compute @workgroup_size(8, 8)
fn blur_and_blend(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let b = first_block() + vec2i(id.xy);
    let place = quad_place(b, textureDimensions(analysis));
    let start = Seen(vec3f(0.0), 1.0, 1.0);
    var seen_a = start;
    var seen_b = start;
    var seen_c = start;
    var seen_d = start;
    var open = true;
    for (var i = 0u; i < sub_images.count && open; i++) {
        let layer = sub_images.order[i].y;
        if !is_occupied(occupied, layer) {
            continue;
        }
        let level = sub_images.order[layer].x;
        if level == 0u {
            let pixels = pixel_block(b, true);
            var around: Around;
            if is_occupied(layers_with_holes(ramp_variables(pixels)), layer) {
                around = around_block(b, layer - filling.first_stored);
            }
            seen_a = behind(seen_a, matted(layer, pixels.a, around, 0u));
            seen_b = behind(seen_b, matted(layer, pixels.b, around, 1u));
            seen_c = behind(seen_c, matted(layer, pixels.c, around, 2u));
            seen_d = behind(seen_d, matted(layer, pixels.d, around, 3u));
        } else {
            var quad: Quad;
            if level == 1u {
                quad = quad_of(analysis, place, layer);
            } else {
                quad = quad_of(blur, place, layer);
            }
            seen_a = behind(seen_a, expanded(quad, 0u));
            seen_b = behind(seen_b, expanded(quad, 1u));
            seen_c = behind(seen_c, expanded(quad, 2u));
            seen_d = behind(seen_d, expanded(quad, 3u));
        }
        open = max(max(seen_a.through, seen_b.through), max(seen_c.through, seen_d.through)) > 0.0;
    }
    hand_over(local.xy, 0u, color_of(seen_a));
    hand_over(local.xy, 1u, color_of(seen_b));
    hand_over(local.xy, 2u, color_of(seen_c));
    hand_over(local.xy, 3u, color_of(seen_d));
    workgroupBarrier();
    for (var i = index; i < 256u; i += 64u) {
        let at = result_pixel(group.xy, i);
        if all(at >= vec2i(0)) && all(at < vec2i(textureDimensions(result))) {
            textureStore(result, at, vec4f(results[i], 1.0));
        }
    }
}
