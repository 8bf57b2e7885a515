// gather, after the rings: sprites, and the picture from its layers
// (src/methods/gather/passes.rs).

#import color
#import gather
#import sampling
#import sprites

@group(0) @binding(1) var<uniform> sprites: Sprites;
@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var image: texture_2d<f32>;
/// In front, premultiplied.
@group(0) @binding(5) var front: texture_2d<f32>;
/// At and behind the surface, with the surface's own share.
@group(0) @binding(6) var base: texture_2d<f32>;
@group(0) @binding(7) var light: texture_2d<f32>;
@group(0) @binding(8) var idf_sums: texture_2d<f32>;
@group(0) @binding(9) var<storage, read> sprite_list: array<vec4u>;
@group(0) @binding(10) var result: texture_storage_2d<COLOR_FORMAT, write>;
@group(0) @binding(11) var explained: texture_storage_2d<rgba16float, write>;

// ---- sprites ----

struct Fragment {
    @builtin(position) at: vec4f,
    /// Texels of the gathered image.
    @location(0) @interpolate(flat) centre: vec2f,
    @location(1) @interpolate(flat) c: f32,
    @location(2) @interpolate(flat) rgb: vec3f,
}

/// The CoC diameter, texels, that a spot is drawn with.
fn drawn_coc(c: f32) -> f32 {
    return sign(c) * 2.0 * own_radius(c) / f32(params.step);
}

@vertex
fn vs_sprite(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Fragment {
    let listed = sprite_list[index];
    let centre = vec2f(vec2u(listed.x & 0xffffu, listed.x >> 16u)) + 0.5;
    let c = bitcast<f32>(listed.y);
    let rgb = vec3f(unpack2x16float(listed.z), unpack2x16float(listed.w).x);
    return Fragment(sprite_corner(sprites, corner, centre, drawn_coc(c)), centre, c, rgb);
}

/// How much is seen of light from a surface with `c`, where one with `c_own` is.
fn seen(c: f32, id: vec2i, c_own: f32) -> f32 {
    let open = 1.0 - textureLoad(front, id, 0).a;
    let own_share = textureLoad(base, id, 0).a;
    let nearer = in_front(c, c_own);
    let farther = behind(c, c_own);
    return nearer + open * (1.0 - nearer - farther * own_share);
}

@fragment
fn fs_sprite(in: Fragment) -> @location(0) vec4f {
    let share = sprite_share(idf_sums, sprites, in.at.xy - in.centre, drawn_coc(in.c));
    if share <= 0.0 {
        discard;
    }
    let id = vec2i(floor(in.at.xy));
    return share * seen(in.c, id, textureLoad(image, id, 0).a) * vec4f(in.rgb, 1.0);
}

// ---- recombination ----

/// CoC diameters, px, between which the full image gives way to the gathered one.
const SLIGHT = vec2f(1.5, 3.0);

/// A pixel's colour from the 3x3 pixels of the full image: their shares of its disc, what lies in
/// front left out.
fn slightly_blurred(p: vec2i, c_own: f32, own: vec3f) -> vec3f {
    let size = textureDimensions(color);
    // Differences from the pixel are summed, so that in focus it stays exactly that.
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 0; i < 9; i++) {
        let offset = vec2i(i % 3, i / 3) - 1;
        let q = clamp_to_image(p + offset, size);
        let c = coc_diameter_px(params.lens, textureLoad(depth, q, 0).r);
        // A spot of a tap in front or sharper is no wider than its own; what is behind is seen
        // through the pixel's own disc.
        let radius = 0.5 * min(abs(c_own), max(abs(c), abs(c_own) * behind(c, c_own)));
        let reaches = saturate(radius + 0.5 - length(vec2f(offset)));
        let weight = select(reaches, 1.0, all(offset == vec2i(0)));
        let rgb = textureLoad(color, q, 0).rgb;
        sum += select(vec3f(0.0), weight * (rgb - own), is_finite(rgb));
        weights += weight;
    }
    return own + sum / weights;
}

/// Share of texels on the pixel's own surface from which on they count alone.
const FEW_TEXELS = 0.1;

fn combined(id: vec2u) -> vec3f {
    let p = vec2i(id + params.overscan);
    let z = textureLoad(depth, p, 0).r;
    let c_own = coc_diameter_px(params.lens, z);
    let loaded = textureLoad(color, p, 0).rgb;
    let own = select(vec3f(0.0), loaded, is_finite(loaded));
    let read = bilinear(texel_at(vec2f(p) + 0.5));
    var front_sum = vec4f(0.0);
    var base_sum = vec4f(0.0);
    var weights = 0.0;
    var alike = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let q = clamp_to_image(read.corner + corner, params.grid);
        let share = mix(1.0 - read.weight, read.weight, vec2f(corner));
        let c = textureLoad(image, q, 0).a;
        let nearer = in_front(c, c_own);
        let same = 1.0 - max(nearer, behind(c, c_own));
        // Of a texel of foreground all that is not behind it is in front of this pixel, as far as
        // it is blurred wider than a texel: what is sharp ends at its outline.
        let texel_front = textureLoad(front, q, 0);
        let texel_base = textureLoad(base, q, 0);
        let spreads = saturate(0.5 * abs(c) / f32(params.step) - 0.5);
        let part = nearer * spreads * (1.0 - texel_front.a) * texel_base.a;
        let weight = share.x * share.y;
        front_sum += weight * (texel_front + part * vec4f(texel_base.rgb, 1.0));
        base_sum += weight * same * texel_base;
        weights += weight;
        alike += weight * same;
    }
    let in_front_of = front_sum / weights;
    let gathered = base_sum.rgb / max(alike, 1e-6);
    var sharp = own;
    if params.slight != 0u {
        sharp = slightly_blurred(p, c_own, own);
    }
    let range = select(vec2f(0.5, 1.0), SLIGHT, params.slight != 0u);
    let limits = select(range, vec2f(0.0, 0.5), params.step == 1u);
    let blurred = smoothstep(limits.x, limits.y, abs(c_own));
    // A surface that no texel around has is known from the full image alone.
    let known = alike / weights;
    let behind_it = mix(sharp, gathered, blurred * saturate(known / FEW_TEXELS));
    return in_front_of.rgb + (1.0 - in_front_of.a) * behind_it;
}

/// What sprites bring to a pixel, and their share of it.
fn light_at(id: vec2u) -> vec4f {
    let read = bilinear(texel_at(vec2f(id + params.overscan) + 0.5));
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let share = mix(1.0 - read.weight, read.weight, vec2f(corner));
        sum += share.x * share.y * textureLoad(light, clamp_to_image(read.corner + corner, params.grid), 0);
    }
    // Where spots of several sizes overlap, shares may add up to more than all there is.
    return sum / max(sum.a, 1.0);
}

@compute @workgroup_size(8, 8)
fn combine(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(result)) {
        textureStore(result, id.xy, vec4f(combined(id.xy), 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn combine_with_sprites(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(result)) {
        // Sprites stand for light that no tap has: a mean of both.
        let bright = light_at(id.xy);
        textureStore(result, id.xy, vec4f(bright.rgb + (1.0 - bright.a) * combined(id.xy), 1.0));
    }
}

// ---- to look at ----

fn explained_at(id: vec2u, light_share: f32) -> vec4f {
    return vec4f(
        textureLoad(front, id, 0).a,
        textureLoad(base, id, 0).a,
        min(light_share, 1.0),
        textureLoad(image, id, 0).a,
    );
}

@compute @workgroup_size(8, 8)
fn explain(@builtin(global_invocation_id) id: vec3u) {
    textureStore(explained, id.xy, explained_at(id.xy, 0.0));
}

@compute @workgroup_size(8, 8)
fn explain_with_sprites(@builtin(global_invocation_id) id: vec3u) {
    textureStore(explained, id.xy, explained_at(id.xy, textureLoad(light, id.xy, 0).a));
}
