// The filtered levels of `mipmap` in one image: level 1 at the left, the others in a column
// beside it.

#import mipmap

/// Layers, all colour times weight: what is behind the focus distance through the narrow and
/// the wide disc; through the narrow one what in front of it ends on the level, and all that
/// is not in front or not blurred as much. Nothing ends on the front level or above: alpha on
/// that one is how much is in front of the focus distance at all.
const NARROW = 0;
const WIDE = 1;
const SPREAD = 2;
const REST = 3;

/// Workgroups along x: what every adapter allows. More of them go on along y.
const MAX_GROUPS = 65535u;

/// Size, texels, of a level: sides of level 1 are multiples of 2^(levels - 1).
fn level_size(level: u32) -> vec2u {
    return params.level_1 >> vec2u(level - 1u);
}

/// Where a level begins in the image.
fn level_origin(level: u32) -> vec2u {
    let above = params.level_1.y - (2u * level_size(level)).y;
    return select(vec2u(params.level_1.x, above), vec2u(0u), level == 1u);
}
