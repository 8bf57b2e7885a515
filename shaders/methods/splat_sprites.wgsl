// `splat` by sprites that are drawn and blended (src/methods/splat/sprites.rs).

#import splat

// ---- sections 3.3 and 3.4: sprites on layers ----

struct Fragment {
    @builtin(position) at: vec4f,
    /// On the inner frame, px.
    @location(0) @interpolate(flat) centre: vec2f,
    @location(1) @interpolate(flat) c: f32,
    /// Colour times weight, and weight: the number of pixels that this one stands for.
    @location(2) @interpolate(flat) light: vec4f,
}

struct Layers {
    @location(0) front: vec4f,
    @location(1) same: vec4f,
    @location(2) behind: vec4f,
}

/// `place` is px on the outer frame.
fn sprite(corner: u32, place: vec2f, spot: Spot) -> Fragment {
    let centre = place - f32(sprites.overscan);
    let position = spot_corner(sprites, lens, corner, centre, spot.c);
    return Fragment(select(NOWHERE, position, spot.light.a > 0.0), centre, spot.c, spot.light);
}

fn pixel_of(index: u32) -> vec2u {
    let width = textureDimensions(depth).x;
    return vec2u(index % width, index / width);
}

@vertex
fn vs_pixel(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let p = pixel_of(index);
    return sprite(corner, vec2f(p) + 0.5, visible_spot(p));
}

/// What the reduced array leaves to the full one.
@vertex
fn vs_pixel_not_reduced(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let p = pixel_of(index);
    if !is_drawn_by(EACH_ITS_OWN, p / 2u) {
        return Fragment(NOWHERE, vec2f(0.0), 0.0, vec4f(0.0));
    }
    return sprite(corner, vec2f(p) + 0.5, visible_spot(p));
}

@vertex
fn vs_block(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let width = textureDimensions(arrays).x;
    let block = vec2u(index % width, index / width);
    if !is_drawn_by(ONE_FOR_FOUR, block) {
        return Fragment(NOWHERE, vec2f(0.0), 0.0, vec4f(0.0));
    }
    return sprite(corner, vec2f(2u * block) + 1.0, block_spot(block));
}

@vertex
fn vs_hidden(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let p = pixel_of(index);
    return sprite(corner, vec2f(p) + 0.5, pixel_spot(p));
}

/// What reaches this pixel, on its layer: equations (5) and (6).
fn layered(in: Fragment) -> Layers {
    let share = spot_share(idf_sums, sprites, lens, in.at.xy - in.centre, in.c);
    if share <= 0.0 {
        discard;
    }
    let light = share * in.light;
    let layer = layer_of(in.c, visible_coc_px(vec2i(floor(in.at.xy)) + i32(sprites.overscan)));
    let none = vec4f(0.0);
    return Layers(
        select(none, light, layer == FRONT),
        select(none, light, layer == SAME),
        select(none, light, layer == BEHIND),
    );
}

@fragment
fn fs_visible(in: Fragment) -> Layers {
    return layered(in);
}

struct HiddenLayers {
    @location(0) same: vec4f,
    @location(1) behind: vec4f,
}

/// Hidden pixels occlude nothing: what would lie in front is dropped.
@fragment
fn fs_hidden(in: Fragment) -> HiddenLayers {
    let layers = layered(in);
    if layers.front.a > 0.0 {
        discard;
    }
    return HiddenLayers(layers.same, layers.behind);
}

/// Sheets in front of the visible surface, and behind it.
@fragment
fn fs_sheets(in: Fragment) -> HiddenLayers {
    let share = spot_share(idf_sums, sprites, lens, in.at.xy - in.centre, in.c);
    if share <= 0.0 {
        discard;
    }
    let light = share * in.light;
    let is_behind = in.c > visible_coc_px(vec2i(floor(in.at.xy)) + i32(sprites.overscan));
    return HiddenLayers(select(light, vec4f(0.0), is_behind), select(vec4f(0.0), light, is_behind));
}

@vertex
fn vs_all(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

/// Visible pixels that stay within themselves: no sprites, and never another layer.
@fragment
fn fs_sharp(@builtin(position) at: vec4f) -> Layers {
    return Layers(vec4f(0.0), sharp_light(vec2u(at.xy) + sprites.overscan), vec4f(0.0));
}
