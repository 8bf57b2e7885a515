//! Things of some size, at any angle.

use crate::gauntlet::maker::{Maker, Patch};
use crate::gauntlet::spec::Pattern;
use glam::dvec2;
use std::f64::consts::PI;

pub fn cards(maker: &mut Maker) {
    maker.k_between(6.0, 40.0);
    backdrop(maker);
    for _ in 0..2 + maker.random.index(5) {
        let coc_px = maker.random.between(-30.0, 0.8 * maker.k_px());
        card(maker, 8.0, 40.0, coc_px, 0.5);
    }
}

pub fn planes(maker: &mut Maker) {
    maker.k_between(6.0, 30.0);
    backdrop(maker);
    let (near_px, far_px) = (-maker.random.log_between(2.0, 30.0), 0.8 * maker.far_coc_px() + 0.5);
    let (middle_px, growth_px) = ((near_px + far_px) * 0.5, (far_px - near_px) * 0.5);
    let half = maker.size * 0.5;
    // From one border to the opposite one, a little beyond both.
    let patch = match maker.random.index(3) {
        0 => Patch::between(
            dvec2(-60.0, 0.35 * maker.size.y),
            dvec2(maker.size.x + 60.0, maker.size.y + 60.0),
            middle_px,
        )
        .leaning(0.0, -growth_px),
        1 => {
            let growth_px = growth_px * maker.sign();
            Patch::upright(half, half * dvec2(1.2, 2.0), middle_px).leaning(growth_px, 0.0)
        }
        _ => {
            let angle = maker.random.between(0.0, PI);
            Patch::upright(half, half * dvec2(1.0, 0.7), middle_px).turned(angle).leaning(growth_px, 0.0)
        }
    };
    let [radiance, other] = maker.contrast();
    let pattern = match maker.random.index(3) {
        0 => Pattern::Gradient { other },
        _ => Pattern::Checker { cells: [0; 2].map(|_| 2 + maker.random.index(10) as u32), other },
    };
    maker.add(patch, radiance, pattern);
    for _ in 0..maker.random.index(4) {
        let coc_px = maker.random.between(near_px, far_px);
        card(maker, 2.0, 15.0, coc_px, 0.0);
    }
}

pub fn stacks(maker: &mut Maker) {
    maker.k_between(4.0, 30.0);
    let behind_px = if maker.random.index(2) == 0 { 0.0 } else { maker.far_coc_px() };
    maker.any_wall(behind_px);
    let around_px = maker.in_frame(20.0);
    for _ in 0..2 + maker.random.index(4) {
        let coc_px = -maker.random.log_between(2.0, 40.0);
        let half_px = dvec2(maker.random.between(5.0, 30.0), maker.random.between(5.0, 30.0));
        let aside_px = dvec2(maker.random.between(-1.0, 1.0), maker.random.between(-1.0, 1.0)) * half_px;
        let angle = maker.random.between(0.0, PI);
        let (radiance, pattern) = (maker.dim_color(), maker.any_pattern(half_px.min_element() * 2.0));
        maker.add(Patch::upright(around_px + aside_px, half_px, coc_px).turned(angle), radiance, pattern);
    }
}

pub fn mixed(maker: &mut Maker) {
    maker.k_between(3.0, 50.0);
    backdrop(maker);
    for _ in 0..3 + maker.random.index(15) {
        let low = -maker.random.log_between(1.0, 60.0);
        let coc_px = maker.random.between(low, 0.9 * maker.k_px());
        let lean = if maker.random.index(2) == 0 { 0.0 } else { 0.7 };
        card(maker, 1.0, 60.0, coc_px, lean);
    }
}

/// A wall in focus or behind it, or nothing but a sky.
fn backdrop(maker: &mut Maker) {
    match maker.random.index(5) {
        0 => {
            let radiance = maker.dim_color();
            maker.sky(radiance);
        }
        1 => maker.any_wall(0.0),
        _ => {
            let coc_px = maker.far_coc_px();
            maker.any_wall(coc_px);
        }
    }
}

/// A card with half sides between two lengths, leaning by up to a share of its CoC.
fn card(maker: &mut Maker, low_px: f64, high_px: f64, coc_px: f64, lean: f64) {
    let half_px = dvec2(maker.random.log_between(low_px, high_px), maker.random.log_between(low_px, high_px));
    let (at_px, angle) = (maker.in_frame(0.0), maker.random.between(0.0, PI));
    // The sum of both growths stays below the distance to K, where depths end.
    let most_px = lean * coc_px.abs().max(4.0).min(0.9 * maker.k_px() - coc_px).max(0.0);
    let growth = [0; 2].map(|_| 0.5 * maker.random.between(-most_px, most_px));
    let (radiance, pattern) = (maker.dim_color(), maker.any_pattern(half_px.min_element() * 2.0));
    maker.add(Patch::upright(at_px, half_px, coc_px).turned(angle).leaning(growth[0], growth[1]), radiance, pattern);
}
