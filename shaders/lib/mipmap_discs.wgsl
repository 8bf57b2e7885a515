// `mipmap` by discs: which part of a pixel's light is found where (src/methods/mipmap/).
//
// Blurs are known at nodes: the pixel itself, discs of 2, 3 and 3 sqrt(2) px drawn on the
// image, and the narrow and the wide disc on each level of the pyramids. Any other blur is a
// blend of the two nodes around its variance.
//
// The pyramids have four layers:
//
//   BEHIND   colour times weight, weight: what lies behind the focus distance, as far as its
//            own blur reaches the level. What is sharp has no part in any level, so that
//            nothing leaks from it, by whatever filter a level is read.
//   BEFORE   the same of what lies in front, as far as its own blur is at least the level's:
//            each level hands on what is wider than its own disc.
//   ALL      colour of everything, and how much of it is in front of the focus distance
//   COC      CoC diameter, px, times weight, of the first two layers

#import mipmap

const BEHIND = 0;
const BEFORE = 1;
const ALL = 2;
const COC = 3;

/// Variance, px^2 per axis, of level l (of the paper) through disc 1 (narrow) or 2 (wide).
fn disc_variance(l: f32, disc: u32) -> f32 {
    let texel2 = exp2(2.0 * l);
    return level_variance(texel2) + texel2 * (BILINEAR_VARIANCE + params.disc_variance[disc]);
}

/// The narrow disc of level l, px^2.
fn narrow_disc(l: u32) -> f32 {
    return disc_variance(f32(l), 1u);
}

/// Signed CoC, px, of a stored depth; 0 for what counts as in focus.
fn coc_of(z: f32) -> f32 {
    let c = coc_diameter_px(lens, z);
    return select(c, 0.0, abs(c) <= params.in_focus_coc_px);
}

/// Variance, px^2 per axis, of the blur of a CoC, px.
fn variance_of_coc(c: f32) -> f32 {
    let sigma = params.sigma_px_per_coc * c;
    return sigma * sigma;
}

/// The widest disc of level l, px^2; of level 0 that on the image.
fn widest(l: u32) -> f32 {
    return select(disc_variance(f32(l), 2u), params.disc_variance.z, l == 0u);
}

/// Which part of a blur lies beyond the discs of level l: it is handed on to the next.
fn handed_on(variance: f32, l: u32) -> f32 {
    let own = widest(l);
    return clamp((variance - own) / (narrow_disc(l + 1u) - own), 0.0, 1.0);
}

/// Which part something blurred by `variance` has in what is blurred by `of_variance`,
/// behind the focus distance: all if its blur is at least 2 / reach as wide, none if it is
/// 1 / reach as wide or less.
fn part(variance: f32, of_variance: f32) -> f32 {
    return clamp((params.reach * params.reach * variance / of_variance - 1.0) / 3.0, 0.0, 1.0);
}
