//! Edges: of sharp walls, of the frame, between depths.

use crate::gauntlet::maker::{Maker, Patch};
use crate::gauntlet::spec::Pattern;
use glam::{DVec2, dvec2};

pub fn near_before_sharp(maker: &mut Maker) {
    maker.k_between(2.0, 40.0);
    let cell_px = maker.random.log_between(2.0, 10.0);
    maker.checkered_wall(0.0, cell_px);
    let count = 1 + maker.random.index(6);
    for _ in 0..count {
        let side_px = maker.random.log_between(0.5, 8.0);
        let coc_px = -maker.coc_of_sources_px(count, side_px, 2.0, 40.0);
        let at_px = maker.in_frame(0.0);
        let radiance = maker.random.log_between(0.01, 5.0);
        let radiance = maker.tinted(radiance);
        maker.add(Patch::upright(at_px, DVec2::splat(0.5 * side_px), coc_px), radiance, Pattern::Plain);
    }
}

pub fn borders(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let behind_px = if maker.random.index(3) == 0 { 0.0 } else { maker.far_coc_px() };
    maker.any_wall(behind_px);
    for _ in 0..1 + maker.random.index(3) {
        let coc_px = match maker.random.index(if behind_px > 0.0 { 2 } else { 1 }) {
            0 => -maker.random.log_between(2.0, 40.0),
            _ => behind_px * maker.random.unit(),
        };
        let half_px = dvec2(maker.random.between(5.0, 40.0), maker.random.between(5.0, 40.0));
        let at_px = on_border(maker, 0.0);
        let radiance = maker.random.log_between(1.0, 100.0);
        let radiance = maker.tinted(radiance);
        maker.add_light(Patch::upright(at_px, half_px, coc_px), radiance);
    }
}

pub fn margin(maker: &mut Maker) {
    maker.k_between(10.0, 100.0);
    let radiance = maker.tinted(1.0);
    maker.sky(radiance);
    let [dark, bright] = maker.contrast();
    match maker.random.index(2) {
        0 => {
            // The wall ends a few pixels outside the frame, and there is sky beyond.
            let over_px = DVec2::splat(maker.random.log_between(0.5, 10.0));
            let cell_px = maker.random.between(3.0, 16.0);
            let cells = (maker.size / cell_px).as_uvec2().max(glam::UVec2::ONE).to_array();
            let patch = Patch::between(-over_px, maker.size + over_px, 0.0);
            maker.add(patch, dark, Pattern::Checker { cells, other: bright });
            // Without a blurred thing in view there is no margin at all.
            let coc_px = -maker.random.between(10.0, 40.0);
            thing_at(maker, 0.0, coc_px, 1.5);
        }
        _ => {
            let cell_px = maker.random.between(3.0, 16.0);
            maker.checkered_wall(0.0, cell_px);
            for _ in 0..1 + maker.random.index(4) {
                let coc_px = -maker.random.between(10.0, 60.0);
                let half_px = maker.random.between(2.0, 8.0);
                let outside_px = half_px + maker.random.between(0.5, -0.5 * coc_px);
                thing_at(maker, outside_px, coc_px, half_px);
            }
        }
    }
}

/// A square so far outside the border; 0 is anywhere in the frame.
fn thing_at(maker: &mut Maker, outside_px: f64, coc_px: f64, half_px: f64) {
    let at_px = if outside_px == 0.0 { maker.in_frame(5.0) } else { on_border(maker, outside_px) };
    let radiance = maker.random.log_between(0.05, 20.0);
    let radiance = maker.tinted(radiance);
    maker.add(Patch::upright(at_px, DVec2::splat(half_px), coc_px), radiance, Pattern::Plain);
}

/// A point so far outside one of the four borders.
fn on_border(maker: &mut Maker, outside_px: f64) -> DVec2 {
    let at_px = maker.in_frame(0.0);
    match maker.random.index(4) {
        0 => dvec2(-outside_px, at_px.y),
        1 => dvec2(maker.size.x + outside_px, at_px.y),
        2 => dvec2(at_px.x, -outside_px),
        _ => dvec2(at_px.x, maker.size.y + outside_px),
    }
}

pub fn skies(maker: &mut Maker) {
    maker.k_between(2.0, 60.0);
    let radiance = maker.random.log_between(0.05, 4.0);
    let radiance = maker.tinted(radiance);
    maker.sky(radiance);
    for _ in 0..1 + maker.random.index(6) {
        let coc_px = match maker.random.index(3) {
            0 => -maker.random.log_between(1.0, 40.0),
            // Two in one plane would be seen in no certain order.
            1 => maker.random.between(-0.1, 0.1),
            _ => maker.far_coc_px(),
        };
        let half_px = dvec2(maker.random.log_between(1.0, 40.0), maker.random.log_between(1.0, 40.0));
        let (at_px, angle) = (maker.in_frame(0.0), maker.random.between(0.0, std::f64::consts::PI));
        let (radiance, pattern) = (maker.dim_color(), maker.any_pattern(2.0 * half_px.min_element()));
        maker.add(Patch::upright(at_px, half_px, coc_px).turned(angle), radiance, pattern);
    }
}

pub fn steps(maker: &mut Maker) {
    maker.k_between(8.0, 80.0);
    let mut coc_px = maker.far_coc_px();
    let farthest_px = 0.98 * maker.k_px();
    maker.any_wall(farthest_px);
    let mut from_px = -20.0;
    while from_px < maker.size.x {
        let (to_px, over_px) = (from_px + maker.random.between(10.0, 50.0), maker.random.between(0.0, 40.0));
        let patch =
            Patch::between(dvec2(from_px - over_px, -110.0), dvec2(to_px + over_px, maker.size.y + 110.0), coc_px);
        let (radiance, pattern) = (maker.dim_color(), maker.any_pattern(to_px - from_px));
        maker.add(patch, radiance, pattern);
        from_px = to_px;
        coc_px = next_step(maker, coc_px, 60.0);
    }
}

/// A CoC that differs by 0.1 to 100 px, back and forth so that it stays between `-most_px`
/// and nearly K.
pub fn next_step(maker: &mut Maker, coc_px: f64, most_px: f64) -> f64 {
    let step_px = maker.random.log_between(0.1, 100.0) * maker.sign();
    let range_px = -most_px..=0.95 * maker.k_px();
    let fitting = [coc_px + step_px, coc_px - step_px].into_iter().find(|c| range_px.contains(c));
    fitting.unwrap_or_else(|| maker.random.between(*range_px.start(), *range_px.end()))
}
