// Light far brighter than white, apart from all other: taken out of what lens rays read,
// and brought to the pixels that its blur covers one by one.

/// Radiance above which a blurred texel becomes an emitter: the same in src/view/samples.rs.
const HIGHLIGHT_LIMIT = 2.0;

/// What of a surface's radiance is light to be kept apart: all of it from twice the limit
/// on, as what rays still read of a light is filtered, and shows as a ring around its disc.
fn over_limit(color: vec3f) -> vec3f {
    let greatest = max(color.r, max(color.g, color.b));
    return color * clamp(greatest / HIGHLIGHT_LIMIT - 1.0, 0.0, 1.0);
}

/// The share of that which emitters bring, for a surface with CoC radius s: none in focus,
/// where rays read it as it is, no step on the way, and all where they read layers, which
/// hold means without lights (`FINE_UP_TO_S`). The pixels of an image are `squares`, whose light is
/// known exactly wherever it leaves them.
fn emitted_share(s: f32, lens_radius: f32, squares: bool) -> f32 {
    let leaves = abs(s) * max(lens_radius, 1.0) > IN_FOCUS_PX;
    return select(clamp(2.0 * abs(s) - 2.0, 0.0, 1.0), select(0.0, 1.0, leaves), squares);
}

/// Radius of a blur, px, up to which the light of a pixel is read by rays and not brought by the
/// square: half of what keeps a ray's end within its pixel.
const IN_FOCUS_PX = 0.25;

/// Light kept apart in one pixel of the outer frame: sums over samples.
struct Light {
    /// Its radiance, divided by the number of samples.
    excess: vec3f,
    /// Sum of the components of `excess`: the weight of what follows.
    weight: f32,
    /// Weighted: offset from the pixel's centre, px.
    offset: vec2f,
    /// Weighted: stored depth.
    z: f32,
    /// Weighted: xx, yy and xy of the offset.
    moments: vec3f,
}

/// xx, yy and xy of an offset.
fn moments_of(offset: vec2f) -> vec3f {
    return offset.xyx * offset.xyy;
}

fn with_sample(light: Light, color: vec3f, z: f32, offset: vec2f, share: f32) -> Light {
    let over = share * over_limit(color);
    let weight = over.r + over.g + over.b;
    return Light(
        light.excess + over,
        light.weight + weight,
        light.offset + weight * offset,
        light.z + weight * z,
        light.moments + weight * moments_of(offset),
    );
}

/// The same light about a place `by` px to the left and above.
fn moved(light: Light, by: vec2f) -> Light {
    let crossed = vec3f(2.0 * light.offset * by, dot(light.offset, by.yx));
    return Light(
        light.excess,
        light.weight,
        light.offset + light.weight * by,
        light.z,
        light.moments + crossed + light.weight * moments_of(by),
    );
}

/// Both, about one place.
fn added(a: Light, b: Light) -> Light {
    return Light(a.excess + b.excess, a.weight + b.weight, a.offset + b.offset, a.z + b.z, a.moments + b.moments);
}

/// One or many pixels' light, as one ellipse of even radiance.
struct Emitter {
    /// Radiance kept apart times its area, px^2.
    excess: vec3f,
    /// CoC radius, px.
    s: f32,
    /// Centroid, px of the outer frame.
    at: vec2f,
    /// Covariance, px^2: xx, yy and xy.
    spread: vec3f,
}

struct Highlights {
    /// Emitters that a tile can list.
    capacity: u32,
    /// Distance of a light's samples, px.
    sample_px: f32,
    /// 1: the lens is a disc.
    is_disc: u32,
    /// Tiles around those of the outer frame that light from its stretched border reaches from.
    margin_tiles: u32,
    /// Side, px, of the block of an invocation that looks for emitters: 1, or 4 for large cells.
    block_px: u32,
}

/// Side, px, of the square that has the emitter's mean variance, a twelfth of its area.
fn side_of(emitter: Emitter) -> f32 {
    return sqrt(6.0 * (emitter.spread.x + emitter.spread.y));
}

const PI = 3.14159265;

/// Density, over the square of the lens's radius, of a disc lens seen from `offset` px
/// beside the emitter, averaged over the emitter: the share of a circle with the emitter's
/// variance towards there that a straight edge cuts off. The edge lies closer than the
/// lens's radius by so much that the light adds up to all of it.
fn disc_density(emitter: Emitter, offset: vec2f, lens_radius: f32) -> f32 {
    let distance = max(length(offset), 1e-6);
    let u = offset / distance;
    let radius = 2.0 * sqrt(dot(emitter.spread, vec3f(u.x * u.x, u.y * u.y, 2.0 * u.x * u.y)));
    let blur = abs(emitter.s) * lens_radius;
    let x = clamp((blur - radius * radius / (8.0 * blur) - distance) / radius, -1.0, 1.0);
    return (0.5 + (x * sqrt(1.0 - x * x) + asin(x)) / PI) / (PI * lens_radius * lens_radius);
}

/// Area under the upper half of a circle from its left end to x = `t`.
fn half_circle_area(r: f32, t: f32) -> f32 {
    return 0.5 * (t * sqrt(max(r * r - t * t, 0.0)) + r * r * asin(clamp(t / r, -1.0, 1.0))) + 0.25 * PI * r * r;
}

/// Area of the part of a circle about the origin that lies to the left of `corner` and below it.
fn circle_before(r: f32, corner: vec2f) -> f32 {
    let x = clamp(corner.x, -r, r);
    let y = clamp(corner.y, -r, r);
    // From -w to w the line at y cuts the circle.
    let w = sqrt(max(r * r - y * y, 0.0));
    let c = clamp(x, -w, w);
    let cut = half_circle_area(r, c) - half_circle_area(r, -w);
    return select(cut + y * (c + w), 2.0 * half_circle_area(r, x) - cut + y * (c + w), y >= 0.0);
}

/// Density, over the square of the lens's radius, of a disc lens seen from `offset` px beside the
/// emitter, averaged over its square: exact for any blur.
fn disc_density_of_square(emitter: Emitter, offset: vec2f, lens_radius: f32) -> f32 {
    let r = abs(emitter.s) * lens_radius;
    let side = side_of(emitter);
    let low = offset - 0.5 * side;
    let high = low + side;
    let area = circle_before(r, high) - circle_before(r, vec2f(low.x, high.y)) - circle_before(r, vec2f(high.x, low.y))
        + circle_before(r, low);
    // What is left of a difference of equal areas is rounding.
    return select(0.0, area, area > 1e-5 * r * r) / (side * side * PI * lens_radius * lens_radius);
}
