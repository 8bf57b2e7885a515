// The CoC radii s of four layers at a pixel, as a vector: which of them lies where.

/// The first layer with s from `low` to `high`, -1 for none.
fn first_within(s: vec4f, low: f32, high: f32) -> i32 {
    let within = (s >= vec4f(low)) & (s <= vec4f(high));
    let second_half = select(select(-1, 3, within.w), 2, within.z);
    return select(select(second_half, 1, within.y), 0, within.x);
}

/// The layer whose s is nearest to `wanted`.
fn nearest_to(s: vec4f, wanted: f32) -> i32 {
    let d = abs(s - wanted);
    let first = select(0, 1, d.y < d.x);
    let second = select(2, 3, d.w < d.z);
    return select(first, second, min(d.z, d.w) < min(d.x, d.y));
}
