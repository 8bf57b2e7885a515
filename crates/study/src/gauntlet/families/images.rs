//! Scenes that are handed over as an image with depth.
//!
//! What such an image hides is not known, and nothing outside its frame. So that there is a
//! truth all the same (the scene's), these hide nothing that could not be told: behind
//! everything lies one colour, what a nearer strip hides is what goes on beside it, and what
//! crosses the border goes on beyond it.

use super::edges::next_step;
use crate::gauntlet::maker::{Maker, Patch};
use crate::gauntlet::spec::Pattern;
use glam::dvec2;

/// How far beyond the frame, px, goes on what crosses its border.
const BEYOND_PX: f64 = 110.0;

/// Greatest CoC of strips, px, and their least width.
const MOST_STEP_COC_PX: f64 = 16.0;

fn strip_px(maker: &mut Maker) -> f64 {
    maker.random.between(MOST_STEP_COC_PX, 48.0).floor()
}

fn one_colour(maker: &mut Maker) -> f64 {
    let coc_px = if maker.random.index(3) == 0 { 0.0 } else { maker.far_coc_px() };
    let radiance = maker.dim_color();
    maker.wall(coc_px, radiance, Pattern::Plain);
    coc_px
}

pub fn specks(maker: &mut Maker) {
    maker.as_image();
    maker.k_between(4.0, 40.0);
    let behind_px = one_colour(maker);
    let count = 1 + maker.random.index(6);
    for _ in 0..count {
        // Whole pixels: an image knows nothing finer.
        let side = dvec2(1.0 + maker.random.index(5) as f64, 1.0 + maker.random.index(5) as f64);
        let low = maker.in_frame(5.0).floor();
        let coc_px = maker.coc_of_sources_px(count, side.element_product().sqrt(), 1.0, 40.0);
        let far = maker.random.index(2) == 0 && coc_px < behind_px;
        let radiance = maker.random.log_between(0.1, 1e4);
        let radiance = maker.tinted(radiance);
        maker.add_light(Patch::between(low, low + side, if far { coc_px } else { -coc_px }), radiance);
    }
}

pub fn cards(maker: &mut Maker) {
    maker.as_image();
    maker.k_between(4.0, 40.0);
    let behind_px = one_colour(maker);
    let cell = maker.size / dvec2(3.0, 2.0);
    for (x, y) in (0..2).flat_map(|y| (0..3).map(move |x| (x, y))) {
        if maker.random.index(3) == 0 {
            continue;
        }
        let middle_px = (dvec2(f64::from(x), f64::from(y)) + 0.5) * cell;
        let half_px = dvec2(maker.random.between(3.0, 0.35 * cell.x), maker.random.between(3.0, 0.35 * cell.y));
        // Before the wall, also where that is in focus.
        let coc_px = match maker.random.index(if behind_px > 0.0 { 3 } else { 1 }) {
            0 => -maker.random.log_between(1.0, 30.0),
            1 => 0.0,
            _ => behind_px * maker.random.unit(),
        };
        let (radiance, pattern) = (maker.dim_color(), maker.any_pattern(half_px.min_element() * 2.0));
        // All edges between pixels, those of a pattern's cells too: an image knows nothing finer.
        let cells = match pattern {
            Pattern::Checker { cells, .. } => dvec2(cells[0].into(), cells[1].into()),
            Pattern::Plain | Pattern::Gradient { .. } => dvec2(1.0, 1.0),
        };
        let low_px = (middle_px - half_px).floor();
        let side_px = (2.0 * half_px / cells).floor().max(dvec2(1.0, 1.0)) * cells;
        maker.add(Patch::between(low_px, low_px + side_px, coc_px), radiance, pattern);
    }
}

pub fn bands(maker: &mut Maker) {
    maker.as_image();
    maker.k_between(4.0, 40.0);
    let behind_px = one_colour(maker);
    let horizontal = maker.random.index(2) == 0;
    let side_px = if horizontal { maker.size.y } else { maker.size.x };
    let from_px = maker.random.between(0.0, 0.7 * side_px).floor();
    let to_px = from_px + maker.random.log_between(1.0, 30.0).ceil();
    let (low, high) = (dvec2(-BEYOND_PX, from_px), dvec2(maker.size.max_element() + BEYOND_PX, to_px));
    let turn = |p: glam::DVec2| if horizontal { p } else { dvec2(p.y, p.x) };
    let coc_px = match maker.random.index(if behind_px > 0.0 { 2 } else { 1 }) {
        0 => -maker.random.log_between(1.0, 30.0),
        _ => behind_px * maker.random.unit(),
    };
    let radiance = maker.random.log_between(0.1, 50.0);
    let radiance = maker.tinted(radiance);
    maker.add_light(Patch::between(turn(low), turn(high), coc_px), radiance);
}

pub fn steps(maker: &mut Maker) {
    maker.as_image();
    // No CoC is wider than a strip: what a neighbour's neighbour hides stays hidden.
    maker.k_between(4.0, MOST_STEP_COC_PX);
    let mut strips: Vec<(f64, f64, f64)> = Vec::new();
    let mut coc_px = maker.far_coc_px();
    let mut from_px = -BEYOND_PX;
    let mut to_px = strip_px(maker);
    while from_px < maker.size.x {
        if to_px > maker.size.x - MOST_STEP_COC_PX {
            to_px = maker.size.x + BEYOND_PX;
        }
        strips.push((from_px, to_px, coc_px));
        from_px = to_px;
        to_px += strip_px(maker);
        coc_px = next_step(maker, coc_px, MOST_STEP_COC_PX);
    }
    for (i, &(from_px, to_px, coc_px)) in strips.iter().enumerate() {
        // A strip goes on behind its neighbour where that is nearer.
        let before = i.checked_sub(1).map(|i| strips[i]).filter(|s| s.2 < coc_px);
        let after = strips.get(i + 1).filter(|s| s.2 < coc_px);
        let (low, high) = (before.map_or(from_px, |s| s.0), after.map_or(to_px, |s| s.1));
        let radiance = maker.dim_color();
        let patch = Patch::between(dvec2(low, -BEYOND_PX), dvec2(high, maker.size.y + BEYOND_PX), coc_px);
        maker.add(patch, radiance, Pattern::Plain);
    }
}

pub fn planes(maker: &mut Maker) {
    maker.as_image();
    let k_px = maker.k_between(6.0, 30.0);
    let (near_px, far_px) = (-maker.random.log_between(2.0, 20.0), maker.random.between(0.2, 0.6) * k_px);
    let sign = maker.sign();
    let (middle_px, growth_px) = (0.5 * (near_px + far_px), 0.5 * (far_px - near_px) * sign);
    // Twice as wide as the frame, over whose width the CoC thus covers half of the range.
    let half = maker.size * 0.5;
    let [radiance, other] = maker.contrast();
    let patch = Patch::upright(half, half + dvec2(half.x, BEYOND_PX), middle_px).leaning(growth_px, 0.0);
    maker.add(patch, radiance, Pattern::Gradient { other });
}
