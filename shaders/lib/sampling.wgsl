// Reading images by pixel position.

/// p clamped to the texels of an image of `size`.
fn clamp_to_image(p: vec2i, size: vec2u) -> vec2i {
    return clamp(p, vec2i(0), vec2i(size) - 1);
}

/// Texel and weight of a bilinear read at `at`, in texels with centres at half integers.
struct Bilinear {
    corner: vec2i,
    weight: vec2f,
}

/// The 2x2 texels around `at`: `corner` is the top left one (unclamped), `weight` the
/// share of its right and lower neighbours.
fn bilinear(at: vec2f) -> Bilinear {
    let from_centre = at - 0.5;
    let corner = floor(from_centre);
    return Bilinear(vec2i(corner), from_centre - corner);
}
