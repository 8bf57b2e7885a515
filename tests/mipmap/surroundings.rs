//! What blurred things do to what lies around them, on generated inputs: specks in front, sky
//! behind, edges in front, small things behind.

use super::{common, render};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::methods::Mipmap;
use glam::{UVec2, Vec3, uvec2};
use std::f64::consts::PI;

const SIZE: UVec2 = uvec2(128, 96);
const FOCUS_M: f64 = 2.0;

/// A chequered wall in focus, with a square speck in front of it and sky over a part.
struct Specked {
    corner: UVec2,
    side: u32,
    coc_px: f64,
    sky_from_x: u32,
}

impl Specked {
    /// Deterministic, all different.
    fn new(seed: u32) -> Self {
        let random = |n: u32, below: u32| {
            let hash = (seed.wrapping_mul(0x9e37_79b9) ^ n.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
            (hash >> 8) % below
        };
        let side = 1 + random(1, 6);
        Self {
            corner: uvec2(random(2, SIZE.x - side), random(3, SIZE.y - side)),
            side,
            coc_px: [5.0, 12.0, 40.0, 150.0, 700.0][(seed % 5) as usize],
            sky_from_x: [SIZE.x, 100, 60][random(4, 3) as usize],
        }
    }

    fn is_speck(&self, x: u32, y: u32) -> bool {
        let p = uvec2(x, y);
        p.cmpge(self.corner).all() && p.cmplt(self.corner + self.side).all()
    }

    /// Distance, px, of a pixel from the speck.
    fn distance_px(&self, x: u32, y: u32) -> f64 {
        let away = |p: u32, low: u32| f64::from(low.saturating_sub(p).max(p.saturating_sub(low + self.side - 1)));
        away(x, self.corner.x).hypot(away(y, self.corner.y))
    }

    fn wall(x: u32, y: u32) -> Vec3 {
        Vec3::splat(if (x / 5 + y / 7).is_multiple_of(2) { 0.9 } else { 0.1 })
    }
}

#[test]
fn specks_in_front_and_sky_behind_leave_what_is_in_focus_sharp() {
    for seed in 0..20 {
        let case = Specked::new(seed);
        let lens = common::lens(case.coc_px, FOCUS_M);
        let near_m = lens.coc().depth_at(-case.coc_px) as f32;
        let is_sky = |x: u32| x >= case.sky_from_x;
        let color = ColorImage::from_fn(SIZE, |x, y| match (case.is_speck(x, y), is_sky(x)) {
            (true, _) => Vec3::ONE,
            (false, true) => Vec3::new(0.2, 0.3, 0.9),
            (false, false) => Specked::wall(x, y),
        });
        let depth = DepthImage::from_fn(SIZE, |x, y| match (case.is_speck(x, y), is_sky(x)) {
            (true, _) => near_m,
            (false, true) => f32::INFINITY,
            (false, false) => FOCUS_M as f32,
        });
        let picture = render(&Mipmap::default(), &color, &depth, &lens);
        // What the speck covers of the middle of its disc, and half as much again for a filter
        // that is no disc; beyond twice the disc's radius and a texel nothing is left.
        let coc2 = case.coc_px * case.coc_px;
        let covered = (1.5 * f64::from(case.side * case.side) / (0.25 * PI * coc2)).min(1.0);
        for (x, y) in (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y))) {
            if case.is_speck(x, y) || is_sky(x) {
                continue;
            }
            let limit = if case.distance_px(x, y) < case.coc_px + 2.0 { covered } else { 0.0 };
            let off = f64::from((picture.at(x, y) - Specked::wall(x, y)).abs().max_element());
            assert!(
                off < limit + 2e-3,
                "seed {seed}, C = {} px, {} px wide at {}, sky from {}: ({x}, {y}) is off by {off}",
                case.coc_px,
                case.side,
                case.corner,
                case.sky_from_x
            );
        }
    }
}

#[test]
fn foreground_reaches_over_its_edge_as_a_disc_does() {
    println!("C px | distance outside px: share of the foreground, of a disc");
    for coc_px in [3.0, 6.0, 12.0, 24.0, 40.0] {
        let lens = common::lens(60.0, FOCUS_M);
        let near_m = lens.coc().depth_at(-coc_px) as f32;
        let is_near = |x: u32| x < 60;
        let color = ColorImage::from_fn(SIZE, |x, _| if is_near(x) { Vec3::ONE } else { Vec3::ZERO });
        let depth = DepthImage::from_fn(SIZE, |x, _| if is_near(x) { near_m } else { FOCUS_M as f32 });
        let picture = render(&Mipmap::default(), &color, &depth, &lens);
        for x in 60..85 {
            let distance_px = f64::from(x - 60) + 0.5;
            let t = (2.0 * distance_px / coc_px).min(1.0);
            let of_disc = (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
            let share = f64::from(picture.at(x, 48).x);
            println!("{coc_px} | {distance_px}: {share:.3}, {of_disc:.3}");
            // Discs on texels, read between texels, are rounder at the rim than discs.
            assert!((share - of_disc).abs() < 0.07, "C = {coc_px}, {distance_px} px outside: {share}, not {of_disc}");
        }
    }
}

#[test]
fn small_things_behind_the_focus_keep_their_light() {
    for (coc_px, wall_px) in [(8.0, 11.0), (20.0, 28.0), (21.5, 30.5), (10.0, 10.0), (16.0, 12.0)] {
        for side in [1, 3] {
            let lens = common::lens(40.0, FOCUS_M);
            let depth_of = |c: f64| lens.coc().depth_at(c) as f32;
            let is_light = |x: u32, y: u32| (60..60 + side).contains(&x) && (45..45 + side).contains(&y);
            let depth: DepthImage =
                Image::from_fn(SIZE, |x, y| if is_light(x, y) { depth_of(coc_px) } else { depth_of(wall_px) });
            let color = ColorImage::from_fn(SIZE, |x, y| if is_light(x, y) { Vec3::ONE } else { Vec3::ZERO });
            let picture = render(&Mipmap::default(), &color, &depth, &lens);
            let kept = picture.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / f64::from(side * side);
            println!("C = {coc_px} px before {wall_px} px, {side} px wide: {kept:.3} of the light");
            assert!((kept - 1.0).abs() < 0.15, "C = {coc_px} before {wall_px} px, {side} px wide: {kept}");
        }
    }
}
