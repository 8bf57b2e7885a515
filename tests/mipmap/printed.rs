//! `mipmap` as printed, in f64: the functions of `shaders/methods/mipmap.wgsl` and of the
//! library it imports, by name and in order.

use super::{KERNEL, variance_as_printed};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{Mipmap, MipmapCalibration, MipmapInterpolation};
use glam::{DVec2, DVec3, UVec2, dvec2, uvec2};

/// The shader in f64: same function names, same order.
pub struct Mirror<'a> {
    color: &'a ColorImage,
    depth: &'a DepthImage,
    lens: Lens,
    params: Mipmap,
    /// The paper's levels 1, 2, ...
    pyramid: Vec<Image<Texel>>,
    padding: UVec2,
}

#[derive(Clone, Copy, Debug, Default)]
struct Texel {
    color: DVec3,
    /// c, sigma, rho
    blur: DVec3,
}

impl<'a> Mirror<'a> {
    pub fn new(color: &'a ColorImage, depth: &'a DepthImage, lens: &Lens, params: &Mipmap, levels: u32) -> Self {
        let coarsest = 2 << levels;
        let padded = uvec2(color.size.x.next_multiple_of(coarsest), color.size.y.next_multiple_of(coarsest));
        let padding = (padded - color.size) / 2;
        let mut mirror =
            Self { color, depth, lens: lens.clone(), params: params.clone(), pyramid: Vec::new(), padding };
        for level in 0..levels {
            let size = (padded / 2) >> level;
            let next = Image::from_fn(size, |x, y| {
                let texel = |i: i64| {
                    let at = (2 * i64::from(x) + i % 4 - 1, 2 * i64::from(y) + i / 4 - 1);
                    match mirror.pyramid.last() {
                        None => mirror.level_0(at.0, at.1),
                        Some(finer) => finer.at_clamped(at.0, at.1),
                    }
                };
                mirror.reduce(&std::array::from_fn(|i| texel(i as i64)))
            });
            mirror.pyramid.push(next);
        }
        mirror
    }

    fn dob(&self, c: f64) -> f64 {
        f64::from(self.params.sigma_per_coc) * c.abs()
    }

    fn level_0(&self, x: i64, y: i64) -> Texel {
        let (x, y) = (x - i64::from(self.padding.x), y - i64::from(self.padding.y));
        let c = self.lens.coc_diameter_px(f64::from(self.depth.at_clamped(x, y)));
        Texel { color: self.color.at_clamped(x, y).as_dvec3(), blur: DVec3::new(c, self.dob(c), 0.0) }
    }

    fn refuses(&self, centre: DVec3, sigma: f64) -> bool {
        self.params.anisotropic && centre.x > 0.0 && centre.y > sigma + f64::from(self.params.delta_px)
    }

    fn reduce(&self, texels: &[Texel; 16]) -> Texel {
        let gaussian = |i: usize| KERNEL[i % 4] * KERNEL[i / 4];
        let blur: DVec3 = texels.iter().enumerate().map(|(i, t)| gaussian(i) * t.blur).sum();
        let (mut color, mut weight, mut rho) = (DVec3::ZERO, 0.0, 0.0f64);
        for (i, texel) in texels.iter().enumerate() {
            if !self.refuses(blur, texel.blur.y) {
                color += gaussian(i) * texel.color;
                weight += gaussian(i);
            }
            if texel.blur.x < 0.0 && texel.blur.x < blur.x {
                rho = rho.max(texel.blur.y);
            }
        }
        assert!(weight > 1e-6);
        Texel { color: color / weight, blur: DVec3::new(blur.x, blur.y, rho) }
    }

    fn level_of_dob(&self, sigma: f64) -> f64 {
        if self.params.calibration == MipmapCalibration::Paper as usize {
            let k_sigma = f64::from(self.params.k) * sigma;
            return if k_sigma >= 0.5 { 1.0 + k_sigma.log2() } else { 0.0 };
        }
        let wanted = self.lens.aperture.sigma_per_coc() / f64::from(self.params.sigma_per_coc) * sigma;
        let variance = wanted * wanted;
        let first = variance_as_printed(1.0);
        if variance <= first {
            return variance / first;
        }
        let l = (1.0 + 0.5 * ((variance + 0.25) / (0.25 + 1.0 / 6.0 + 0.375)).log2()).floor().max(1.0);
        let (low, high) = (variance_as_printed(l), variance_as_printed(l + 1.0));
        l + ((variance - low) / (high - low)).clamp(0.0, 1.0)
    }

    fn taps(&self) -> [(DVec2, f64); 9] {
        std::array::from_fn(|i| {
            let (x, y) = ((i % 3) as f64 - 1.0, (i / 3) as f64 - 1.0);
            let shrink = if self.params.circular && x * y != 0.0 { std::f64::consts::FRAC_1_SQRT_2 } else { 1.0 };
            (shrink * dvec2(x, y), (2.0 - x.abs()) * (2.0 - y.abs()) / 16.0)
        })
    }

    /// Bilinear read of a pyramid level (0 is the paper's level 1) at a level-0 position.
    fn sample(&self, pyramid: &[Image<Texel>], at: DVec2, level: usize) -> Texel {
        let image = &pyramid[level];
        let p = (at + self.padding.as_dvec2()) / f64::from(2u32 << level) - 0.5;
        let (corner, w) = (p.floor(), p - p.floor());
        let mut sum = Texel::default();
        for i in 0..4 {
            let (dx, dy) = (i & 1, i >> 1);
            let weight = (if dx == 1 { w.x } else { 1.0 - w.x }) * (if dy == 1 { w.y } else { 1.0 - w.y });
            let texel = image.at_clamped(corner.x as i64 + dx, corner.y as i64 + dy);
            sum.color += weight * texel.color;
            sum.blur += weight * texel.blur;
        }
        sum
    }

    fn trilinear(&self, pyramid: &[Image<Texel>], at: DVec2, level: f64) -> Texel {
        let low = (level.floor() as usize).min(pyramid.len() - 1);
        let high = (low + 1).min(pyramid.len() - 1);
        let (a, b, beta) = (self.sample(pyramid, at, low), self.sample(pyramid, at, high), level - low as f64);
        Texel { color: a.color.lerp(b.color, beta), blur: a.blur.lerp(b.blur, beta) }
    }

    fn blur_at(&self, pyramid: &[Image<Texel>], at: DVec2, level: f64) -> DVec3 {
        if level < 1.0 {
            let c =
                self.lens.coc_diameter_px(f64::from(self.depth.at_clamped(at.x.floor() as i64, at.y.floor() as i64)));
            let sharp = DVec3::new(c, self.dob(c), 0.0);
            return sharp.lerp(self.sample(pyramid, at, 0).blur, level);
        }
        self.trilinear(pyramid, at, level - 1.0).blur
    }

    fn smooth_blur_at(&self, at: DVec2, level: f64) -> DVec3 {
        let read = |offset: DVec2| self.blur_at(&self.pyramid, at + level.exp2() * offset, level);
        if self.params.blur_points == 1 {
            let around: DVec3 = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].into_iter().map(read).sum();
            return 0.5 * read(DVec2::ZERO) + 0.125 * around;
        }
        self.taps().iter().map(|(offset, weight)| *weight * read(*offset)).sum()
    }

    fn image_at(&self, at: DVec2) -> DVec3 {
        let p = at - 0.5;
        let (corner, w) = (p.floor(), p - p.floor());
        let texel = |dx: i64, dy: i64| self.color.at_clamped(corner.x as i64 + dx, corner.y as i64 + dy).as_dvec3();
        texel(0, 0).lerp(texel(1, 0), w.x).lerp(texel(0, 1).lerp(texel(1, 1), w.x), w.y)
    }

    /// Colour and weight.
    fn accepted_image_at(&self, at: DVec2, centre: DVec3) -> (DVec3, f64) {
        let p = at - 0.5;
        let (corner, w) = (p.floor(), p - p.floor());
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (x, y) = (corner.x as i64 + dx, corner.y as i64 + dy);
            let share = (if dx == 1 { w.x } else { 1.0 - w.x }) * (if dy == 1 { w.y } else { 1.0 - w.y });
            let c = self.lens.coc_diameter_px(f64::from(self.depth.at_clamped(x, y)));
            if !self.refuses(centre, self.dob(c)) {
                sum += share * self.color.at_clamped(x, y).as_dvec3();
                weight += share;
            }
        }
        (sum, weight)
    }

    fn accepted_at(&self, at: DVec2, l: usize, centre: DVec3) -> (DVec3, f64) {
        if l == 0 {
            return self.accepted_image_at(at, centre);
        }
        let texel = self.sample(&self.pyramid, at, l - 1);
        if self.refuses(centre, texel.blur.y) { (DVec3::ZERO, 0.0) } else { (texel.color, 1.0) }
    }

    fn blend_levels(&self, fine: DVec3, coarse: DVec3, beta: f64) -> DVec3 {
        if self.params.interpolation == MipmapInterpolation::Geometric as usize {
            let least = DVec3::splat(1e-12);
            return fine.max(least).powf(1.0 - beta) * coarse.max(least).powf(beta);
        }
        fine.lerp(coarse, beta)
    }

    fn filtered(&self, at: DVec2, l: usize, beta: f64, radius: f64, centre: DVec3) -> DVec3 {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for (offset, share) in self.taps() {
            let p = at + radius * offset;
            let (fine, fine_weight) = self.accepted_at(p, l, centre);
            let (mut c, mut w) = (fine / fine_weight.max(1e-6), fine_weight);
            if beta > 0.0 {
                let (coarse, coarse_weight) = self.accepted_at(p, l + 1, centre);
                if fine_weight == 0.0 {
                    c = coarse;
                } else if coarse_weight > 0.0 {
                    c = self.blend_levels(c, coarse, beta);
                }
                w = fine_weight.max(coarse_weight);
            }
            sum += share * w * c;
            weight += share * w;
        }
        if weight > 1e-6 { sum / weight } else { self.image_at(at) }
    }

    fn magnified_level_of_dob(&self, sigma: f64) -> f64 {
        if self.params.calibration == MipmapCalibration::Paper as usize {
            return self.level_of_dob(sigma);
        }
        // Of level l: all reductions to it, and one bilinear read of its texels.
        let of_level = |l: f64| 0.25 * (4f64.powf(l) - 1.0) + 4f64.powf(l) / 6.0;
        let wanted = self.lens.aperture.sigma_per_coc() / f64::from(self.params.sigma_per_coc) * sigma;
        let variance = wanted * wanted;
        if variance <= of_level(1.0) {
            return variance / of_level(1.0);
        }
        let l = (1..30).map(f64::from).find(|l| of_level(l + 1.0) > variance).unwrap();
        l + (variance - of_level(l)) / (of_level(l + 1.0) - of_level(l))
    }

    fn magnified(&self, at: DVec2, level: f64, centre: DVec3) -> DVec3 {
        let l = (level.floor() as usize).min(self.pyramid.len());
        let (fine, fine_weight) = self.accepted_at(at, l, centre);
        let (coarse, coarse_weight) = self.accepted_at(at, (l + 1).min(self.pyramid.len()), centre);
        match (fine_weight > 1e-6, coarse_weight > 1e-6) {
            (false, false) => self.image_at(at),
            (false, true) => coarse,
            (true, false) => fine / fine_weight,
            (true, true) => self.blend_levels(fine / fine_weight, coarse, level - l as f64),
        }
    }

    fn interpolate(&self, at: DVec2, sigma: f64) -> DVec3 {
        let level = self.level_of_dob(sigma).clamp(0.0, self.pyramid.len() as f64 + 0.999);
        if level <= 3e-4 {
            return self.image_at(at);
        }
        let centre = DVec3::new(self.blur_at(&self.pyramid, at, 0.0).x, sigma, 0.0);
        if self.params.bilinear {
            return self.magnified(at, self.magnified_level_of_dob(sigma).min(self.pyramid.len() as f64), centre);
        }
        if level < 1.0 {
            return self.blend_levels(self.image_at(at), self.filtered(at, 0, 0.0, 1.0, centre), level);
        }
        let l = level.floor();
        let beta = level - l;
        let texel2 = 4f64.powf(l - 1.0);
        self.filtered(at, l as usize - 1, beta, (texel2 * (1.0 + 3.0 * beta)).sqrt(), centre)
    }

    fn as_printed(&self, at: DVec2) -> DVec3 {
        let top = self.pyramid.len() as f64;
        let n = self.level_of_dob(self.smooth_blur_at(at, top).z).min(top);
        let sharp = self.blur_at(&self.pyramid, at, 0.0).y;
        let sigma = if n > 0.0 && self.params.smoothing { self.smooth_blur_at(at, n).y } else { sharp };
        self.interpolate(at, sigma)
    }

    pub fn pixel(&self, x: u32, y: u32) -> DVec3 {
        self.as_printed(uvec2(x, y).as_dvec2() + 0.5)
    }
}
