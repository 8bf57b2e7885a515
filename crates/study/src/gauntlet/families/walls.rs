//! What is seen through something, and thin things.

use crate::gauntlet::maker::{Maker, Patch};
use crate::gauntlet::spec::Pattern;
use glam::dvec2;
use std::f64::consts::PI;

/// Widest CoC of a line over its width: with `n = N/2 / (pi/4 r)` lens points of N that meet
/// it from a pixel, as in `maker`'s reckoning for specks, the halves of a line as long as the
/// frame agree well beyond 50 dB.
const MOST_COC_PER_WIDTH: f64 = 20.0;

/// How far beyond the frame, px, bars and walls with openings reach.
const BEYOND_PX: f64 = 110.0;

pub fn fences_near(maker: &mut Maker) {
    maker.k_between(4.0, 30.0);
    let behind_px = if maker.random.index(2) == 0 { 0.0 } else { maker.far_coc_px() };
    maker.any_wall(behind_px);
    let coc_px = -maker.random.log_between(1.0, 40.0);
    bars(maker, coc_px);
}

pub fn fences_far(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let (one_px, other_px) = (maker.far_coc_px(), maker.far_coc_px());
    if maker.random.index(4) == 0 {
        let radiance = maker.dim_color();
        maker.sky(radiance);
    } else {
        maker.any_wall(one_px.max(other_px));
    }
    bars(maker, one_px.min(other_px));
}

fn bars(maker: &mut Maker, coc_px: f64) {
    let (width_px, gap_px) = (maker.random.log_between(1.0, 10.0), maker.random.log_between(2.0, 24.0));
    let angle = if maker.random.index(2) == 0 { 0.0 } else { maker.random.between(0.0, PI) };
    let (radiance, middle_px) = (maker.dim_color(), maker.size * 0.5);
    let reach_px = maker.size.length() * 0.5;
    let count = (2.0 * reach_px / (width_px + gap_px)).floor().min(40.0);
    for i in 0..count as u32 {
        let aside_px = (f64::from(i) - 0.5 * (count - 1.0)) * (width_px + gap_px);
        let patch = Patch::upright(middle_px, dvec2(0.5 * width_px, reach_px + BEYOND_PX), coc_px).turned(angle);
        let centre_px = middle_px + patch.u_px.normalize() * aside_px;
        maker.add(Patch { centre_px, ..patch }, radiance, Pattern::Plain);
    }
}

pub fn slots(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let (wall_px, behind_px) = before_and_behind(maker);
    maker.any_wall(behind_px);
    let radiance = maker.dim_color();
    let horizontal = maker.random.index(2) == 0;
    let side_px = if horizontal { maker.size.y } else { maker.size.x };
    let mut from_px = -BEYOND_PX;
    let mut to_px = maker.random.between(0.0, 30.0);
    while from_px < side_px + BEYOND_PX {
        let end_px = if to_px > side_px { side_px + BEYOND_PX } else { to_px };
        let (low, high) = (dvec2(from_px, -BEYOND_PX), dvec2(end_px, maker.size.max_element() + BEYOND_PX));
        let turn = |p: glam::DVec2| if horizontal { dvec2(p.y, p.x) } else { p };
        maker.add(Patch::between(turn(low), turn(high), wall_px), radiance, Pattern::Plain);
        from_px = end_px + maker.random.log_between(1.0, 8.0);
        to_px = from_px + maker.random.between(5.0, 40.0);
    }
}

pub fn holes(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let (wall_px, behind_px) = before_and_behind(maker);
    maker.any_wall(behind_px);
    let half_px = dvec2(maker.random.log_between(1.0, 25.0), maker.random.log_between(1.0, 25.0));
    let centre_px = maker.in_frame(10.0);
    let (low, high) = (centre_px - half_px, centre_px + half_px);
    let (start, end) = (-dvec2(BEYOND_PX, BEYOND_PX), maker.size + BEYOND_PX);
    let radiance = maker.dim_color();
    let parts = [
        (start, dvec2(end.x, low.y)),
        (dvec2(start.x, high.y), end),
        (dvec2(start.x, low.y), dvec2(low.x, high.y)),
        (dvec2(high.x, low.y), dvec2(end.x, high.y)),
    ];
    for (low, high) in parts {
        maker.add(Patch::between(low, high, wall_px), radiance, Pattern::Plain);
    }
}

/// CoCs of a wall, anywhere, and of what is seen through it.
fn before_and_behind(maker: &mut Maker) -> (f64, f64) {
    match maker.random.index(3) {
        0 => (-maker.random.log_between(1.0, 30.0), maker.far_coc_px()),
        1 => (0.0, maker.far_coc_px()),
        _ => {
            let (one_px, other_px) = (maker.far_coc_px(), maker.far_coc_px());
            (one_px.min(other_px), one_px.max(other_px))
        }
    }
}

pub fn diagonals(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let behind_px = maker.far_coc_px();
    maker.any_wall(behind_px);
    for _ in 0..1 + maker.random.index(6) {
        let half_width_px = maker.random.log_between(0.25, 1.5);
        let half_px = dvec2(maker.random.between(20.0, 90.0), half_width_px);
        // A line is met by far more lens points than a speck as thin.
        let widest_px = MOST_COC_PER_WIDTH * 2.0 * half_width_px;
        let near_px = -maker.random.log_between(1.0, widest_px.min(30.0));
        let far_px = behind_px.min(widest_px);
        let (at_px, angle) = (maker.in_frame(10.0), maker.random.between(0.0, PI));
        let radiance = maker.random.log_between(0.05, 4.0);
        let radiance = maker.tinted(radiance);
        let patch = match maker.random.index(3) {
            0 => Patch::upright(at_px, half_px, near_px),
            1 => Patch::upright(at_px, half_px, far_px),
            // From before the focus to behind it.
            _ => Patch::upright(at_px, half_px, 0.5 * (near_px + far_px)).leaning(0.5 * (far_px - near_px), 0.0),
        };
        maker.add(patch.turned(angle), radiance, Pattern::Plain);
    }
}
