//! Small bright things.

use crate::gauntlet::maker::{Maker, Patch};
use glam::{DVec2, dvec2};

/// Radiances of specks: from darker than a wall to a lamp.
const SPECK_RADIANCE: (f64, f64) = (0.1, 1e4);

pub fn specks_near(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let behind_px = if maker.random.index(5) < 2 { 0.0 } else { maker.far_coc_px() };
    maker.any_wall(behind_px);
    let count = 1 + maker.random.index(8);
    for _ in 0..count {
        let side_px = maker.random.between(1.0, 5.0);
        let coc_px = -maker.coc_of_sources_px(count, side_px, 1.0, 40.0);
        speck(maker, side_px, coc_px);
    }
}

pub fn specks_far(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let count = 1 + maker.random.index(8);
    let side_px = maker.random.between(1.0, 5.0);
    let most_px = 0.9 * maker.k_px();
    let coc_px = maker.coc_of_sources_px(count, side_px, 0.5, most_px);
    // What lies behind is nearly as blurred, or anything up to K.
    let behind_px = match maker.random.index(2) {
        0 => coc_px + maker.random.log_between(0.1, 2.0),
        _ => maker.random.between(coc_px, maker.k_px()),
    };
    maker.any_wall(behind_px);
    let mut taken_px: Vec<DVec2> = Vec::new();
    for _ in 0..count {
        let at_px = maker.in_frame(0.0);
        // Two that overlap in one plane would be seen in no certain order.
        if taken_px.iter().all(|other| (at_px - *other).abs().max_element() > side_px + 0.5) {
            taken_px.push(at_px);
            speck_at(maker, at_px, side_px, coc_px);
        }
    }
}

pub fn points(maker: &mut Maker) {
    maker.k_between(4.0, 40.0);
    let behind_px = maker.far_coc_px();
    maker.any_wall(behind_px);
    let count = 1 + maker.random.index(6);
    for _ in 0..count {
        let side_px = maker.random.between(0.3, 1.0);
        let coc_px = maker.coc_of_sources_px(count, side_px, 1.0, 40.0);
        let far = maker.random.index(2) == 0 && coc_px < behind_px;
        speck(maker, side_px, if far { coc_px } else { -coc_px });
    }
}

pub fn lights(maker: &mut Maker) {
    maker.k_between(8.0, 60.0);
    let behind_px = maker.far_coc_px();
    maker.any_wall(behind_px);
    match maker.random.index(2) {
        0 => alone(maker, behind_px),
        _ => in_rows(maker, behind_px),
    }
}

fn alone(maker: &mut Maker, behind_px: f64) {
    let count = 1 + maker.random.index(6);
    for _ in 0..count {
        let half_px = dvec2(maker.random.between(1.5, 10.0), maker.random.between(1.5, 10.0));
        let coc_px = light_coc_px(maker, count, half_px.min_element() * 2.0, behind_px);
        let (angle, at_px) = (maker.random.between(0.0, std::f64::consts::PI), maker.in_frame(0.0));
        let radiance = maker.random.log_between(1.0, 1000.0);
        let radiance = maker.tinted(radiance);
        maker.add_light(Patch::upright(at_px, half_px, coc_px).turned(angle), radiance);
    }
}

fn in_rows(maker: &mut Maker, behind_px: f64) {
    let half_px = DVec2::splat(maker.random.between(1.0, 2.5));
    let spacing_px = maker.random.between(12.0, 32.0);
    let radiance = maker.random.log_between(1.0, 1000.0);
    let radiance = maker.tinted(radiance);
    let count = (maker.size / spacing_px).as_uvec2();
    let coc_px = light_coc_px(maker, count.element_product() as usize, half_px.x * 2.0, behind_px);
    for (x, y) in (0..count.y).flat_map(|y| (0..count.x).map(move |x| (x, y))) {
        let at_px = dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5) * spacing_px;
        maker.add_light(Patch::upright(at_px, half_px, coc_px), radiance);
    }
}

/// A CoC before the focus or, as far as that is before the wall, behind it.
fn light_coc_px(maker: &mut Maker, count: usize, side_px: f64, behind_px: f64) -> f64 {
    let coc_px = maker.coc_of_sources_px(count, side_px, 2.0, 40.0);
    if maker.random.index(2) == 0 && coc_px < behind_px { coc_px } else { -coc_px }
}

fn speck(maker: &mut Maker, side_px: f64, coc_px: f64) {
    let at_px = maker.in_frame(0.0);
    speck_at(maker, at_px, side_px, coc_px);
}

fn speck_at(maker: &mut Maker, at_px: DVec2, side_px: f64, coc_px: f64) {
    let radiance = maker.random.log_between(SPECK_RADIANCE.0, SPECK_RADIANCE.1);
    let radiance = maker.tinted(radiance);
    maker.add_light(Patch::upright(at_px, DVec2::splat(side_px * 0.5), coc_px), radiance);
}
