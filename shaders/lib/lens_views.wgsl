// The same rays through four true views from off the lens's centre, each the nearest to a
// part of the lens: what they see needs no guess at what is hidden. A view knows one layer;
// where a ray passes behind that, the layers of the centre are asked.
//
// View i, from the lens point w, shows a surface of radius s at p + w * s where the pinhole
// shows it at p: in its image the ray through lens point v is p - (v - w) * s.

#import ray_colors

/// Whether there are off-centre views.
override VIEWS: bool = true;

/// s of the four views, px of the inner frame.
@group(2) @binding(3) var view_radii: texture_2d<f32>;
@group(2) @binding(4) var view_colors: texture_2d_array<f32>;

fn view_point(i: i32) -> vec2f {
    return adaptive.view_distance * vec2f(2.0 * f32(i & 1) - 1.0, f32(i & 2) - 1.0);
}

/// The view nearest to a lens point; -1 for the centre.
fn serving_view(v: vec2f) -> i32 {
    if !VIEWS {
        return -1;
    }
    let i = select(0, 1, v.x > 0.0) + select(0, 2, v.y > 0.0);
    let offset = v - view_point(i);
    return select(-1, i, dot(offset, offset) < dot(v, v));
}

/// The texel of a view at a position, px of the outer frame; outside of it -1.
fn view_texel(position: vec2f) -> vec2i {
    let texel = vec2i(floor(position)) - i32(adaptive.overscan);
    let inside = all(texel >= vec2i(0)) && all(texel < vec2i(adaptive.size));
    return select(vec2i(-1), texel, inside);
}

/// What a ray hits in a view.
struct ViewHit {
    /// 0, or NO_HIT.
    layer: i32,
    s: f32,
    /// The centre of the view's pixel that shows it, px of the inner frame.
    at: vec2f,
    /// Texels that were read.
    reads: u32,
}

/// The first surface on the ray in view i; no layer where the view cannot tell.
fn trace_in_view(p: vec2f, v: vec2f, i: i32) -> ViewHit {
    let from_view = v - view_point(i);
    let from_p = ray_from(p, from_view);
    let steps = steps_of(from_view);
    var reads = 0u;
    for (var r = 0u; r < run_count; r++) {
        let end = runs[r].y;
        var start = runs[r].x;
        for (var step = 0u; step < MAX_STEPS && start < end; step++) {
            let width = step_from(steps, start, end);
            let texel = view_texel(from_p - from_view * (start + 0.5 * width));
            if texel.x < 0 {
                return ViewHit(NO_HIT, 0.0, p, reads);
            }
            let s = textureLoad(view_radii, texel, 0)[i];
            reads += 1u;
            if s < start - TOLERANCE_S {
                // Behind what the view sees.
                return ViewHit(NO_HIT, s, p, reads);
            }
            if s <= start + width + TOLERANCE_S {
                return ViewHit(0, s, vec2f(texel) + 0.5, reads);
            }
            start += width;
        }
    }
    return ViewHit(NO_HIT, 0.0, p, reads);
}

/// Colour of a hit in view i. `limited`: without what emitters bring.
fn color_in_view(hit: ViewHit, p: vec2f, v: vec2f, i: i32, limited: bool) -> vec3f {
    let offset = shrunk_offset(v, hit.s, shrink(hit.s, BILINEAR_BLUR)) - view_point(i) * hit.s;
    let moved = astigmatic_offset_px(adaptive.lens, view_point(i));
    let b = bilinear(p + moved - offset - f32(adaptive.overscan));
    var sum = vec4f(0.0);
    for (var corner = 0; corner < 4; corner++) {
        let texel = clamp_to_image(b.corner + vec2i(corner & 1, corner >> 1), adaptive.size);
        let s = textureLoad(view_radii, texel, 0)[i];
        let w = mix(1.0 - b.weight, b.weight, vec2f(vec2i(corner & 1, corner >> 1)));
        let same = abs(s - hit.s) <= 0.25 + 0.08 * abs(hit.s);
        sum += select(0.0, w.x * w.y, same) * vec4f(view_color(texel, i, s, limited), 1.0);
    }
    if sum.a < 0.99 {
        return view_color(vec2i(floor(hit.at)), i, hit.s, limited);
    }
    return sum.rgb;
}

fn view_color(texel: vec2i, i: i32, s: f32, limited: bool) -> vec3f {
    let color = textureLoad(view_colors, texel, i, 0).rgb;
    return select(color, color - emitted_share(greatest_s(s), adaptive.lens_radius, IMAGE) * over_limit(color), limited);
}
