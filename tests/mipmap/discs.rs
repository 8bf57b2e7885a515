//! `mipmap` by discs, in f64: the functions of `shaders/methods/mipmap_levels.wgsl`,
//! `mipmap_read.wgsl` and the libraries they import, by name and in order.

use super::KERNEL;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{CircleSampling, Circles, IN_FOCUS_COC_PX, Mipmap, MipmapCalibration, MipmapInterpolation};
use glam::{DVec2, DVec3, DVec4, UVec2, uvec2};
use std::f64::consts::SQRT_2;

/// Diameters of the discs, texels.
const DISCS: [f64; 3] = [2.0, 3.0, 3.0 * SQRT_2];

/// A disc drawn on texels: offsets in 5x5 of them, and weights.
struct Disc {
    weights: Vec<((i64, i64), f64)>,
    variance: f64,
}

impl Disc {
    fn new(diameter: f64) -> Self {
        let circles = Circles::new(CircleSampling::default());
        let covered =
            |x: i64, y: i64| circles.coverage(0.5 * diameter, x.unsigned_abs() as u32, y.unsigned_abs() as u32);
        let offsets = (-2..=2).flat_map(|y| (-2..=2).map(move |x| (x, y)));
        let weighted: Vec<_> = offsets.map(|(x, y)| ((x, y), covered(x, y))).collect();
        let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
        let weights: Vec<_> = weighted.into_iter().map(|(offset, weight)| (offset, weight / total)).collect();
        let variance = weights.iter().map(|((x, _), weight)| weight * (x * x) as f64).sum();
        Self { weights, variance }
    }
}

/// A texel of the pyramids.
#[derive(Clone, Copy, Debug, Default)]
struct Texel {
    behind: DVec4,
    before: DVec4,
    all: DVec4,
    coc: DVec2,
}

/// A texel of the filtered levels.
#[derive(Clone, Copy, Debug, Default)]
struct Filtered {
    narrow: DVec4,
    wide: DVec4,
    spread: DVec4,
    rest: DVec4,
}

pub struct Mirror<'a> {
    color: &'a ColorImage,
    depth: &'a DepthImage,
    lens: Lens,
    params: Mipmap,
    discs: [Disc; 3],
    /// The paper's levels 1, 2, ...
    pyramid: Vec<Image<Texel>>,
    filtered: Vec<Image<Filtered>>,
    padding: UVec2,
}

fn color_of(read: DVec4, fallback: DVec3) -> DVec3 {
    if read.w > 1e-6 { read.truncate() / read.w } else { fallback }
}

impl<'a> Mirror<'a> {
    pub fn new(color: &'a ColorImage, depth: &'a DepthImage, lens: &Lens, params: &Mipmap, levels: u32) -> Self {
        let coarsest = 2 << levels;
        let padded = uvec2(color.size.x.next_multiple_of(coarsest), color.size.y.next_multiple_of(coarsest));
        let mut mirror = Self {
            color,
            depth,
            lens: lens.clone(),
            params: params.clone(),
            discs: DISCS.map(Disc::new),
            pyramid: Vec::new(),
            filtered: Vec::new(),
            padding: (padded - color.size) / 2,
        };
        for l in 1..=levels as usize {
            let level =
                Image::from_fn((padded / 2) >> (l as u32 - 1), |x, y| mirror.reduced(l, i64::from(x), i64::from(y)));
            mirror.pyramid.push(level);
        }
        for l in 1..=levels as usize {
            let size = mirror.pyramid[l - 1].size;
            let level = Image::from_fn(size, |x, y| mirror.filtered(l, i64::from(x), i64::from(y)));
            mirror.filtered.push(level);
        }
        mirror
    }

    // ---- mipmap.wgsl, mipmap_discs.wgsl ----

    fn disc_variance(&self, l: usize, disc: usize) -> f64 {
        let texel2 = 4f64.powi(l as i32);
        0.25 * (texel2 - 1.0) + texel2 * (1.0 / 6.0 + self.discs[disc].variance)
    }

    fn narrow_disc(&self, l: usize) -> f64 {
        self.disc_variance(l, 1)
    }

    fn widest(&self, l: usize) -> f64 {
        if l == 0 { self.discs[2].variance } else { self.disc_variance(l, 2) }
    }

    fn coc_of(&self, x: i64, y: i64) -> f64 {
        let c = self.lens.coc_diameter_px(f64::from(self.depth.at_clamped(x, y)));
        if c.abs() <= IN_FOCUS_COC_PX { 0.0 } else { c }
    }

    fn variance_of_coc(&self, c: f64) -> f64 {
        let per_coc = match self.params.calibration == MipmapCalibration::Measured as usize {
            true => self.lens.aperture.sigma_per_coc(),
            false => {
                (0.25f64 + 1.0 / 6.0 + 0.375).sqrt() * f64::from(self.params.k) * f64::from(self.params.sigma_per_coc)
            }
        };
        (per_coc * c).powi(2)
    }

    fn handed_on(&self, variance: f64, l: usize) -> f64 {
        ((variance - self.widest(l)) / (self.narrow_disc(l + 1) - self.widest(l))).clamp(0.0, 1.0)
    }

    fn part(&self, variance: f64, of_variance: f64) -> f64 {
        ((f64::from(self.params.reach).powi(2) * variance / of_variance - 1.0) / 3.0).clamp(0.0, 1.0)
    }

    // ---- mipmap_levels.wgsl ----

    /// A pixel's part in level 1.
    fn pixel_of_level_1(&self, x: i64, y: i64) -> Texel {
        let (x, y) = (x - i64::from(self.padding.x), y - i64::from(self.padding.y));
        let c = self.coc_of(x, y);
        let color = self.color.at_clamped(x, y).as_dvec3();
        let variance = self.variance_of_coc(c);
        let (behind, before) =
            if c < 0.0 { (0.0, self.handed_on(variance, 0)) } else { (self.part(variance, self.narrow_disc(1)), 0.0) };
        Texel {
            behind: behind * color.extend(1.0),
            before: before * color.extend(1.0),
            all: color.extend(f64::from(u8::from(c < 0.0))),
            coc: DVec2::new(behind, before) * c.abs(),
        }
    }

    fn settled(&self, t: Texel, l: usize) -> Texel {
        let coc = |coc: f64, weight: f64| coc / weight.max(1e-20);
        let behind = self.part(self.variance_of_coc(coc(t.coc.x, t.behind.w)), self.narrow_disc(l));
        let before = self.handed_on(self.variance_of_coc(coc(t.coc.y, t.before.w)), l - 1);
        Texel {
            behind: behind * t.behind,
            before: before * t.before,
            all: t.all,
            coc: DVec2::new(behind, before) * t.coc,
        }
    }

    fn reduced(&self, l: usize, x: i64, y: i64) -> Texel {
        let mut sum = Texel::default();
        for i in 0..16 {
            let (dx, dy) = (i % 4, i / 4);
            let w = KERNEL[dx] * KERNEL[dy];
            let (fx, fy) = (2 * x + dx as i64 - 1, 2 * y + dy as i64 - 1);
            let t = if l == 1 { self.pixel_of_level_1(fx, fy) } else { self.pyramid[l - 2].at_clamped(fx, fy) };
            sum.behind += w * t.behind;
            sum.before += w * t.before;
            sum.all += w * t.all;
            sum.coc += w * t.coc;
        }
        if l == 1 { sum } else { self.settled(sum, l) }
    }

    fn filtered(&self, l: usize, x: i64, y: i64) -> Filtered {
        let level = &self.pyramid[l - 1];
        let mut sum = Filtered::default();
        for (i, ((dx, dy), narrow)) in self.discs[1].weights.iter().enumerate() {
            let wide = self.discs[2].weights[i].1;
            let t = level.at_clamped(x + dx, y + dy);
            let variance = self.variance_of_coc(t.coc.y / t.before.w.max(1e-20));
            let wider = ((variance - self.narrow_disc(l)) / (self.widest(l) - self.narrow_disc(l))).clamp(0.0, 1.0);
            let (by_narrow, by_wide) = match l == self.pyramid.len() {
                true => (DVec3::ZERO.extend(t.all.w), DVec4::ZERO),
                false => ((1.0 - wider) * t.before, (wider - self.handed_on(variance, l)) * t.before),
            };
            sum.narrow += *narrow * t.behind;
            sum.wide += wide * t.behind;
            sum.spread += *narrow * by_narrow + wide * by_wide;
            sum.rest += *narrow * (t.all.truncate().extend(1.0) - t.before).max(DVec4::ZERO);
        }
        sum
    }

    // ---- mipmap_read.wgsl ----

    fn read_level(&self, at: DVec2, l: usize, layer: impl Fn(&Filtered) -> DVec4) -> DVec4 {
        let l = l.min(self.filtered.len());
        let image = &self.filtered[l - 1];
        let p = (at + self.padding.as_dvec2()) * (-(l as f64)).exp2() - 0.5;
        let (corner, w) = (p.floor(), p - p.floor());
        let texel = |dx: i64, dy: i64| layer(&image.at_clamped(corner.x as i64 + dx, corner.y as i64 + dy));
        texel(0, 0).lerp(texel(1, 0), w.x).lerp(texel(0, 1).lerp(texel(1, 1), w.x), w.y)
    }

    fn level_of_variance(&self, wanted: f64) -> f64 {
        0.5 * ((wanted + 0.25) / (0.25 + 1.0 / 6.0 + self.discs[1].variance)).log2()
    }

    fn blend_levels(&self, fine: DVec3, coarse: DVec3, beta: f64) -> DVec3 {
        if self.params.interpolation == MipmapInterpolation::Geometric as usize {
            let least = DVec3::splat(1e-12);
            return fine.max(least).powf(1.0 - beta) * coarse.max(least).powf(beta);
        }
        fine.lerp(coarse, beta)
    }

    fn behind_through(&self, at: DVec2, wanted: f64, sharp: DVec3) -> DVec3 {
        let level = self.level_of_variance(wanted).floor().max(1.0) as usize;
        let (narrow, wide) = (self.narrow_disc(level), self.widest(level));
        let (low, high, fine, coarse) = match wanted >= wide {
            false => (narrow, wide, self.read_level(at, level, |f| f.narrow), self.read_level(at, level, |f| f.wide)),
            true => {
                let coarse = self.read_level(at, level + 1, |f| f.narrow);
                (wide, self.narrow_disc(level + 1), self.read_level(at, level, |f| f.wide), coarse)
            }
        };
        let fine = color_of(fine, sharp);
        self.blend_levels(fine, color_of(coarse, fine), ((wanted - low) / (high - low)).clamp(0.0, 1.0))
    }

    fn rest_through(&self, at: DVec2, wanted: f64, sharp: DVec3) -> DVec3 {
        let level = self.level_of_variance(wanted).floor().max(1.0) as usize;
        let fine = color_of(self.read_level(at, level, |f| f.rest), sharp);
        let coarse = color_of(self.read_level(at, level + 1, |f| f.rest), fine);
        let (low, high) = (self.narrow_disc(level), self.narrow_disc(level + 1));
        self.blend_levels(fine, coarse, ((wanted - low) / (high - low)).clamp(0.0, 1.0))
    }

    /// The share of a pixel's light that neighbour `i` of 25 gets from the discs on the image.
    fn share_of(&self, variance: f64, i: usize) -> f64 {
        let nodes = [0.0, self.discs[0].variance, self.discs[1].variance, self.discs[2].variance];
        let beyond: Vec<f64> = nodes.windows(2).map(|n| ((variance - n[0]) / (n[1] - n[0])).clamp(0.0, 1.0)).collect();
        let ends = [beyond[1], beyond[2], self.handed_on(variance, 0)];
        let drawn: f64 = (0..3).map(|disc| (beyond[disc] - ends[disc]) * self.discs[disc].weights[i].1).sum();
        drawn + if i == 12 { 1.0 - beyond[0] } else { 0.0 }
    }

    pub fn pixel(&self, x: u32, y: u32) -> DVec3 {
        let at = uvec2(x, y).as_dvec2() + 0.5;
        let (x, y) = (i64::from(x), i64::from(y));
        let sharp = self.color.at_clamped(x, y).as_dvec3();
        let own_coc = self.coc_of(x, y);
        let own_variance = self.variance_of_coc(own_coc);
        let in_front = own_coc < 0.0;
        let sees_front = in_front || self.params.smoothing;
        let (mut sum, mut spread) = (DVec4::ZERO, DVec4::ZERO);
        for (i, ((dx, dy), _)) in self.discs[0].weights.iter().enumerate() {
            let color = self.color.at_clamped(x + dx, y + dy).as_dvec3().extend(1.0);
            let c = self.coc_of(x + dx, y + dy);
            let variance = self.variance_of_coc(c);
            let before = match (c < 0.0, in_front) {
                (false, _) => 0.0,
                (true, false) => 1.0,
                (true, true) => (2.0 * c / own_coc - 1.0).clamp(0.0, 1.0),
            };
            let taken = match (in_front, i == 12) {
                (true, _) => 1.0 - before,
                (false, true) => 1.0,
                (false, false) if c < 0.0 => 0.0,
                (false, false) if self.params.anisotropic => self.part(variance, own_variance.max(1e-12)),
                (false, false) => 1.0,
            };
            sum += taken * self.share_of(own_variance, i) * color;
            if sees_front {
                spread += before * self.share_of(variance, i) * color;
            }
        }
        let own_level = self.level_of_variance(own_variance).max(0.0) as usize;
        let mut behind = DVec4::ZERO;
        let mut finest = |read: DVec4| {
            behind += (1.0 - behind.w) * (2.0 * read.w).min(1.0) * color_of(read, DVec3::ZERO).extend(1.0);
        };
        if in_front {
            finest(sum);
        }
        for l in 1..self.filtered.len() {
            let mut before = f64::from(u8::from(sees_front));
            if in_front {
                before = match l >= own_level {
                    true => 1.0,
                    false if l + 1 == own_level => 1.0 - self.handed_on(own_variance, own_level),
                    false => 0.0,
                };
                if l <= own_level + 1 {
                    finest(self.read_level(at, l, |f| f.rest));
                }
            }
            spread += before * self.read_level(at, l, |f| f.spread);
        }
        let mut own = color_of(sum, sharp);
        let on = self.handed_on(own_variance, 0);
        if in_front {
            let front = color_of(spread, sharp);
            own = front.lerp(color_of(behind, front), behind.w);
        } else if on > 0.0 {
            let wanted = own_variance.max(self.narrow_disc(1));
            let coarse = match self.params.anisotropic {
                true => self.behind_through(at, wanted, sharp),
                false => self.rest_through(at, wanted, sharp),
            };
            own = self.blend_levels(own, coarse, on);
        }
        spread.truncate() / spread.w.max(1.0) + (1.0 - spread.w.min(1.0)) * own
    }
}
