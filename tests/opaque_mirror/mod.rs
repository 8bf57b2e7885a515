//! `opaque` and `pyramid` in f64, back to front as the papers have it.

use defocus::image::{ColorImage, DepthImage};
use defocus::lens::Lens;
use defocus::methods::{Spacing, SpacingCalibration, pyramid_variance_px2};
use std::array::from_fn;

/// r, g, b, opacity (or how well known), depth: premultiplied.
pub type Texel = [f64; 5];
/// Texel or pixel counted from the image's centre.
pub type Position = [i64; 2];

fn plus(a: Texel, weight: f64, b: Texel) -> Texel {
    from_fn(|i| a[i] + weight * b[i])
}

fn scaled(a: Texel, by: f64) -> Texel {
    plus([0.0; 5], by, a)
}

/// Which of the two methods, with what only it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Opaque { transparent_border: bool },
    Pyramid { repeated_inclusion: f64 },
}

/// A level of one sub-image's pyramid.
#[derive(Clone)]
struct Level {
    half: Position,
    texels: Vec<Texel>,
}

impl Level {
    fn build(centre: Position, level: u32, f: impl Fn(Position) -> Texel) -> Self {
        let half = centre.map(|c| (c + (1 << level) - 1) / (1 << level) + 1);
        let texels = (-half[1]..half[1]).flat_map(|y| (-half[0]..half[0]).map(move |x| [x, y])).map(f).collect();
        Self { half, texels }
    }

    fn get(&self, p: Position) -> Option<Texel> {
        let inside = (0..2).all(|a| (-self.half[a]..self.half[a]).contains(&p[a]));
        inside.then(|| self.texels[((p[1] + self.half[1]) * 2 * self.half[0] + p[0] + self.half[0]) as usize])
    }

    fn clamped(&self, p: Position) -> Texel {
        self.get(from_fn(|a| p[a].clamp(-self.half[a], self.half[a] - 1))).unwrap()
    }

    /// One synthesis step: the value at texel p of the next finer level.
    fn expand(&self, p: Position) -> Texel {
        let mut sum = [0.0; 5];
        for i in 0..4 {
            let side = [i & 1, i >> 1];
            let at = from_fn(|a| p[a].div_euclid(2) + side[a] * (2 * p[a].rem_euclid(2) - 1));
            let weight = side.map(|s| if s == 1 { 0.25 } else { 0.75 });
            sum = plus(sum, weight[0] * weight[1], self.clamped(at));
        }
        sum
    }
}

fn box_sum(p: Position, f: impl Fn(Position) -> Texel) -> Texel {
    (0..16).fold([0.0; 5], |sum, i| plus(sum, 1.0, f([2 * p[0] + i % 4 - 1, 2 * p[1] + i / 4 - 1])))
}

pub struct Mirror<'a> {
    pub color: &'a ColorImage,
    pub depth: &'a DepthImage,
    pub lens: Lens,
    pub spacing: Spacing,
    pub kind: Kind,
    pub front: i32,
    pub back: i32,
}

impl<'a> Mirror<'a> {
    pub fn new(color: &'a ColorImage, depth: &'a DepthImage, lens: &Lens, spacing: &Spacing, kind: Kind) -> Self {
        let cocs = || depth.pixels.iter().map(|d| lens.coc_diameter_px(f64::from(*d)));
        let (low, high) = (cocs().fold(f64::INFINITY, f64::min), cocs().fold(f64::NEG_INFINITY, f64::max));
        let mut mirror = Self { color, depth, lens: lens.clone(), spacing: spacing.clone(), kind, front: 0, back: 0 };
        let exists = |i: i32| mirror.measured() || i <= 0 || spacing.coc_px(lens, i) < lens.k_px();
        let front = (-12..=12).rev().find(|i| spacing.coc_px(lens, *i) <= low).unwrap();
        let back = (-12..=12).filter(|i| exists(*i)).find(|i| spacing.coc_px(lens, *i) >= high);
        let back = back.unwrap_or_else(|| (0..=12).rev().find(|i| exists(*i)).unwrap());
        (mirror.front, mirror.back) = (front, back);
        mirror
    }

    fn measured(&self) -> bool {
        self.spacing.calibration == SpacingCalibration::Measured as usize
    }

    fn ramp_variable(&self, d: f64) -> f64 {
        if !self.measured() {
            return d;
        }
        let sigma = self.lens.aperture.sigma_per_coc() * self.lens.coc_diameter_px(d);
        sigma * sigma.abs()
    }

    /// The ramp variable at sub-image i.
    fn node(&self, i: i32) -> f64 {
        if !self.measured() {
            return self.lens.coc().depth_at(self.spacing.coc_px(&self.lens, i));
        }
        pyramid_variance_px2(i.unsigned_abs()) * f64::from(i.signum())
    }

    fn not_in_front(&self, i: i32, d: f64) -> f64 {
        if i == self.front {
            return 1.0;
        }
        let (from, to) = (self.node(i - 2), self.node(i - 1));
        ((self.ramp_variable(d) - from) / (to - from)).clamp(0.0, 1.0)
    }

    fn not_behind(&self, i: i32, d: f64) -> f64 {
        if i == self.back {
            return 1.0;
        }
        let (from, to) = (self.node(i), self.node(i + 1));
        if to.is_infinite() {
            return 1.0;
        }
        1.0 - ((self.ramp_variable(d) - from) / (to - from)).clamp(0.0, 1.0)
    }

    /// omega_i of Fig. 2 at depth d.
    pub fn omega(&self, i: i32, d: f64) -> f64 {
        self.not_in_front(i, d).min(self.not_behind(i, d))
    }

    /// What is multiplied to the pixel: omega_i, undone of the glow if measured.
    pub fn weight(&self, i: i32, d: f64) -> f64 {
        let omega = self.omega(i, d);
        if !self.measured() {
            return omega;
        }
        1.0 - (1.0 - omega).powf(1.0 / f64::from(i.unsigned_abs() + 1))
    }

    fn centre(&self) -> Position {
        self.color.size.to_array().map(|side| i64::from(side.div_ceil(2)))
    }

    fn pixel(&self, p: Position) -> Option<(Texel, f64)> {
        let at: Position = from_fn(|a| p[a] + self.centre()[a]);
        let size = self.color.size.to_array().map(i64::from);
        if (0..2).any(|a| at[a] < 0 || at[a] >= size[a]) {
            return None;
        }
        let [r, g, b] = self.color.at(at[0] as u32, at[1] as u32).as_dvec3().to_array();
        let d = f64::from(self.depth.at(at[0] as u32, at[1] as u32));
        Some(([r, g, b, 1.0, 1.0 / d], d))
    }

    fn opaque_matted(&self, i: i32, p: Position, transparent_border: bool) -> Texel {
        let clamped = || {
            let size = self.color.size.to_array().map(i64::from);
            self.pixel(from_fn(|a| p[a].clamp(-self.centre()[a], size[a] - 1 - self.centre()[a])))
        };
        let pixel = self.pixel(p).or_else(|| if transparent_border { None } else { clamped() });
        pixel.map_or([0.0; 5], |(texel, d)| scaled(texel, self.weight(i, d)))
    }

    fn culled(&self, i: i32, p: Position) -> Texel {
        self.pixel(p).map_or([0.0; 5], |(texel, d)| scaled(texel, self.not_in_front(i, d)))
    }

    fn completed(known: Texel, coarser: &Level, p: Position) -> Texel {
        if known[3] >= 1.0 {
            return known;
        }
        let around = coarser.expand(p);
        plus(known, (1.0 - known[3]) / around[3].max(1e-6), around)
    }

    /// Level 1 of sub-image i with its holes filled.
    fn disoccluded(&self, i: i32) -> Level {
        let mean = |sum: Texel| scaled(sum, 1.0 / sum[3].max(1.0));
        let largest = *self.centre().iter().max().unwrap() as u64;
        let coarsest = largest.next_power_of_two().ilog2() + 2;
        let mut known = vec![Level::build(self.centre(), 1, |p| mean(box_sum(p, |q| self.culled(i, q))))];
        for level in 2..=coarsest {
            let finer = &known[known.len() - 1];
            let coarser = |p| mean(box_sum(p, |q| finer.get(q).unwrap_or([0.0; 5])));
            known.push(Level::build(self.centre(), level, coarser));
        }
        let mut filled = known.pop().unwrap();
        for (level, known) in (1..coarsest).zip(known).rev() {
            filled = Level::build(self.centre(), level, |p| Self::completed(known.get(p).unwrap(), &filled, p));
        }
        filled
    }

    fn pyramid_matted(&self, i: i32, p: Position, filled: &Level) -> Texel {
        let texel = Self::completed(self.culled(i, p), filled, p);
        scaled(texel, self.not_behind(i, 1.0 / texel[4]))
    }

    /// Sub-image i, blurred, as a function of the pixel; for `opaque` the fifth entry is
    /// the weight before the blur.
    pub fn sub_image(&self, i: i32) -> Box<dyn Fn(Position) -> Texel + '_> {
        let matted: Box<dyn Fn(Position) -> Texel> = match self.kind {
            Kind::Opaque { transparent_border } => Box::new(move |p| self.opaque_matted(i, p, transparent_border)),
            Kind::Pyramid { .. } => {
                let filled = self.disoccluded(i);
                Box::new(move |p| self.pyramid_matted(i, p, &filled))
            }
        };
        if i == 0 {
            return Box::new(move |p| {
                let texel = matted(p);
                [texel[0], texel[1], texel[2], texel[3], texel[3]]
            });
        }
        let transparent = self.kind == Kind::Opaque { transparent_border: true };
        let mut analysis = vec![Level::build(self.centre(), 1, |p| scaled(box_sum(p, &matted), 1.0 / 16.0))];
        for level in 2..=i.unsigned_abs() {
            let finer = &analysis[analysis.len() - 1];
            let read = |q| finer.get(q).unwrap_or(if transparent { [0.0; 5] } else { finer.clamped(q) });
            analysis.push(Level::build(self.centre(), level, |p| scaled(box_sum(p, read), 1.0 / 16.0)));
        }
        // From here on the fifth entry is the glow's opacity.
        let mut synthesis = analysis.pop().unwrap();
        synthesis.texels.iter_mut().for_each(|t| t[4] = t[3]);
        let with_glow = |mut expanded: Texel, analysed: f64| {
            expanded[4] = 1.0 - (1.0 - expanded[4]) * (1.0 - analysed);
            expanded
        };
        for (level, analysed) in (1..i.unsigned_abs()).zip(analysis).rev() {
            let finer = |p| with_glow(synthesis.expand(p), analysed.get(p).unwrap()[3]);
            synthesis = Level::build(self.centre(), level, finer);
        }
        Box::new(move |p| {
            let own = matted(p)[3];
            let blurred = with_glow(synthesis.expand(p), own);
            match self.kind {
                Kind::Pyramid { .. } => blurred,
                Kind::Opaque { .. } if blurred[3] <= 0.0 => [0.0; 5],
                Kind::Opaque { .. } => {
                    let scale = blurred[4] / blurred[3];
                    [blurred[0] * scale, blurred[1] * scale, blurred[2] * scale, blurred[4], own]
                }
            }
        })
    }

    /// The image, by the papers' loop from back to front, as (r, g, b, opacity).
    pub fn render(&self) -> Vec<[f64; 4]> {
        let size = self.color.size.to_array().map(i64::from);
        let pixels: Vec<Position> = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).collect();
        let mut buffer = vec![[0.0; 4]; pixels.len()];
        let repeated = match self.kind {
            Kind::Pyramid { repeated_inclusion } => repeated_inclusion,
            Kind::Opaque { .. } => 0.0,
        };
        for i in (self.front..=self.back).rev() {
            let sub_image = self.sub_image(i);
            for (buffer, p) in buffer.iter_mut().zip(&pixels) {
                let sub = sub_image(from_fn(|a| p[a] - self.centre()[a]));
                let through = 1.0 - (1.0 - repeated) * sub[3];
                for channel in 0..3 {
                    buffer[channel] = sub[channel] + through * buffer[channel];
                }
                buffer[3] = sub[3] + (1.0 - sub[3]) * buffer[3];
            }
        }
        if let Kind::Pyramid { .. } = self.kind {
            buffer.iter_mut().for_each(|b| *b = [b[0] / b[3], b[1] / b[3], b[2] / b[3], b[3]]);
        }
        buffer
    }
}
