//! `mipmap` against an f64 mirror of its shader, function by function, and the measured
//! width of its blur.

mod common;

use common::gpu;
use defocus::gpu::download;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, CircleSampling, Circles, Mipmap, MipmapCalibration, MipmapFilter, MipmapInterpolation};
use defocus::view::View;
use glam::{DVec2, DVec3, UVec2, Vec3, dvec2, uvec2, vec3};

/// The shader in f64: same function names, same order.
struct Mirror<'a> {
    color: &'a ColorImage,
    depth: &'a DepthImage,
    lens: Lens,
    params: Mipmap,
    /// The paper's levels 1, 2, ...
    pyramid: Vec<Image<Texel>>,
    /// Those through the narrow and the wide disc.
    discs: [Vec<Image<Texel>>; 2],
    padding: UVec2,
}

#[derive(Clone, Copy, Debug, Default)]
struct Texel {
    color: DVec3,
    /// c, sigma, rho
    blur: DVec3,
}

const KERNEL: [f64; 4] = [0.125, 0.375, 0.375, 0.125];

/// Diameters of the discs, texels.
const DISCS: [f64; 3] = [2.0, 3.0, 3.0 * std::f64::consts::SQRT_2];

/// Offsets, texels, and weights of a disc drawn on texels.
fn disc(diameter: f64) -> Vec<((i64, i64), f64)> {
    let circles = Circles::new(CircleSampling::default());
    let offsets = (-2..=2).flat_map(|y| (-2..=2).map(move |x| (x, y)));
    let covered =
        |(x, y): (i64, i64)| circles.coverage(0.5 * diameter, x.unsigned_abs() as u32, y.unsigned_abs() as u32);
    let weighted: Vec<_> = offsets.map(|offset| (offset, covered(offset))).collect();
    let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
    weighted.into_iter().map(|(offset, weight)| (offset, weight / total)).collect()
}

fn disc_variance(diameter: f64) -> f64 {
    disc(diameter).iter().map(|((x, _), weight)| weight * (x * x) as f64).sum()
}

fn through_disc(level: &Image<Texel>, diameter: f64) -> Image<Texel> {
    let disc = disc(diameter);
    Image::from_fn(level.size, |x, y| {
        let mut sum = Texel::default();
        for ((dx, dy), weight) in &disc {
            let texel = level.at_clamped(i64::from(x) + dx, i64::from(y) + dy);
            sum.color += *weight * texel.color;
            sum.blur += *weight * texel.blur;
        }
        sum
    })
}

impl<'a> Mirror<'a> {
    fn new(color: &'a ColorImage, depth: &'a DepthImage, lens: &Lens, params: &Mipmap, levels: u32) -> Self {
        let coarsest = 1 << levels;
        let padded = uvec2(color.size.x.next_multiple_of(coarsest), color.size.y.next_multiple_of(coarsest));
        let padding = (padded - color.size) / 2;
        let mut mirror = Self {
            color,
            depth,
            lens: lens.clone(),
            params: params.clone(),
            pyramid: Vec::new(),
            discs: Default::default(),
            padding,
        };
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
        for (discs, diameter) in [(0, DISCS[1]), (1, DISCS[2])] {
            mirror.discs[discs] = mirror.pyramid.iter().map(|level| through_disc(level, diameter)).collect();
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

    fn reduce(&self, texels: &[Texel; 16]) -> Texel {
        let gaussian = |i: usize| KERNEL[i % 4] * KERNEL[i / 4];
        let blur: DVec3 = texels.iter().enumerate().map(|(i, t)| gaussian(i) * t.blur).sum();
        let (mut color, mut weight, mut rho) = (DVec3::ZERO, 0.0, 0.0f64);
        for (i, texel) in texels.iter().enumerate() {
            let tolerated = texel.blur.y + f64::from(self.params.delta_px);
            let refused = self.params.anisotropic && blur.x > 0.0 && blur.y > tolerated;
            if !refused {
                color += gaussian(i) * texel.color;
                weight += gaussian(i);
            }
            rho = rho.max(texel.blur.z);
            if texel.blur.x < 0.0 && texel.blur.x < blur.x {
                rho = rho.max(texel.blur.y);
            }
        }
        assert!(weight > 1e-6);
        Texel { color: color / weight, blur: DVec3::new(blur.x, blur.y, rho) }
    }

    /// A disc of diameter `DISCS[i]` on the paper's level l, as pixels read it.
    fn node_variance(l: f64, i: usize) -> f64 {
        if l == 0.0 {
            return disc_variance(DISCS[i]);
        }
        0.25 * (4f64.powf(l) - 1.0) + 4f64.powf(l) * (1.0 / 6.0 + disc_variance(DISCS[i]))
    }

    fn level_variance(l: f64) -> f64 {
        if l < 1.5 {
            let half = std::f64::consts::FRAC_1_SQRT_2;
            return 0.375 + 0.25 * half * (1.0 - half);
        }
        let texel2 = 4f64.powf(l - 1.0);
        0.25 * (texel2 - 1.0) + texel2 * (1.0 / 6.0 + 0.375)
    }

    fn level_of_dob(&self, sigma: f64) -> f64 {
        if self.params.calibration == MipmapCalibration::Paper as usize {
            let k_sigma = f64::from(self.params.k) * sigma;
            return if k_sigma >= 0.5 { 1.0 + k_sigma.log2() } else { 0.0 };
        }
        let wanted = self.lens.aperture.sigma_per_coc() / f64::from(self.params.sigma_per_coc) * sigma;
        let variance = wanted * wanted;
        let first = Self::level_variance(1.0);
        if variance <= first {
            return variance / first;
        }
        let l = (1.0 + 0.5 * ((variance + 0.25) / (0.25 + 1.0 / 6.0 + 0.375)).log2()).floor().max(1.0);
        let (low, high) = (Self::level_variance(l), Self::level_variance(l + 1.0));
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
        self.taps().iter().map(|(offset, weight)| *weight * read(*offset)).sum()
    }

    fn image_at(&self, at: DVec2) -> DVec3 {
        let p = at - 0.5;
        let (corner, w) = (p.floor(), p - p.floor());
        let texel = |dx: i64, dy: i64| self.color.at_clamped(corner.x as i64 + dx, corner.y as i64 + dy).as_dvec3();
        texel(0, 0).lerp(texel(1, 0), w.x).lerp(texel(0, 1).lerp(texel(1, 1), w.x), w.y)
    }

    fn color_at(&self, at: DVec2, l: usize) -> DVec3 {
        if l == 0 { self.image_at(at) } else { self.sample(&self.pyramid, at, l - 1).color }
    }

    fn blend_levels(&self, fine: DVec3, coarse: DVec3, beta: f64) -> DVec3 {
        if self.params.interpolation == MipmapInterpolation::Geometric as usize {
            let least = DVec3::splat(1e-12);
            return fine.max(least).powf(1.0 - beta) * coarse.max(least).powf(beta);
        }
        fine.lerp(coarse, beta)
    }

    fn filtered(&self, at: DVec2, l: usize, beta: f64, radius: f64) -> DVec3 {
        let read = |at: DVec2| match beta > 0.0 {
            true => self.blend_levels(self.color_at(at, l), self.color_at(at, l + 1), beta),
            false => self.color_at(at, l),
        };
        self.taps().iter().map(|(offset, weight)| *weight * read(at + radius * *offset)).sum()
    }

    fn interpolate(&self, at: DVec2, m: f64) -> DVec3 {
        let level = m.clamp(0.0, self.pyramid.len() as f64 + 0.999);
        if level <= 0.0 {
            return self.image_at(at);
        }
        if level < 1.0 {
            return self.blend_levels(self.image_at(at), self.filtered(at, 0, 0.0, 1.0), level);
        }
        let l = level.floor();
        let beta = level - l;
        let texel2 = 4f64.powf(l - 1.0);
        self.filtered(at, l as usize - 1, beta, (texel2 * (1.0 + 3.0 * beta)).sqrt())
    }

    fn as_printed(&self, at: DVec2) -> DVec3 {
        let top = self.pyramid.len() as f64;
        let n = self.level_of_dob(self.smooth_blur_at(at, top).z).min(top);
        let sharp = self.blur_at(&self.pyramid, at, 0.0).y;
        let sigma = if n > 0.0 && self.params.smoothing { self.smooth_blur_at(at, n).y } else { sharp };
        self.interpolate(at, self.level_of_dob(sigma))
    }

    /// Variance, px^2, of the blur of a DoB.
    fn variance_of_dob(&self, sigma: f64) -> f64 {
        if self.params.calibration == MipmapCalibration::Measured as usize {
            return (self.lens.aperture.sigma_per_coc() / f64::from(self.params.sigma_per_coc) * sigma).powi(2);
        }
        let m = self.level_of_dob(sigma);
        let (low, high) =
            (if m < 1.0 { 0.0 } else { Self::level_variance(m.floor()) }, Self::level_variance(m.floor() + 1.0));
        low + (m - m.floor()) * (high - low)
    }

    /// The image through a disc of a variance, between the two nearest that are known.
    fn disc_at(&self, at: DVec2, variance: f64) -> DVec3 {
        let on_image = |i: usize| {
            let read = |(dx, dy): (i64, i64)| self.color.at_clamped(at.x as i64 + dx, at.y as i64 + dy).as_dvec3();
            disc(DISCS[i]).into_iter().map(|(offset, weight)| weight * read(offset)).sum()
        };
        let mut known = vec![(0.0, self.image_at(at))];
        known.extend((0..3).map(|i| (Self::node_variance(0.0, i), on_image(i))));
        for l in 1..=self.pyramid.len() {
            for i in 1..3 {
                let color = self.sample(&self.discs[i - 1], at, l - 1).color;
                known.push((Self::node_variance(l as f64, i), color));
            }
        }
        let above = known.iter().position(|(v, _)| *v > variance).unwrap();
        let ((low, fine), (high, coarse)) = (known[above - 1], known[above]);
        self.blend_levels(fine, coarse, (variance - low) / (high - low))
    }

    fn through_discs(&self, at: DVec2) -> DVec3 {
        let top = self.pyramid.len() as f64;
        let narrow = &self.discs[0];
        let n = if self.params.smoothing { self.level_of_dob(self.blur_at(narrow, at, top).z).min(top) } else { 0.0 };
        self.disc_at(at, self.variance_of_dob(self.blur_at(narrow, at, n).y))
    }

    fn pixel(&self, x: u32, y: u32) -> DVec3 {
        let at = uvec2(x, y).as_dvec2() + 0.5;
        match self.params.filter == MipmapFilter::Discs as usize {
            true => self.through_discs(at),
            false => self.as_printed(at),
        }
    }
}

const SIZE: UVec2 = uvec2(96, 64);

fn render(method: &Mipmap, color: &ColorImage, depth: &DepthImage, lens: &Lens) -> ColorImage {
    let mut view = View::of_image(gpu(), color, depth, 0.8).unwrap();
    let mut frame = gpu().frame();
    let texture = methods::record(method, &mut frame, &mut view, lens).unwrap();
    frame.finish();
    download(gpu(), &texture)
}

fn variants() -> Vec<(&'static str, Mipmap)> {
    let default = Mipmap::default();
    let printed = Mipmap { filter: MipmapFilter::AsPrinted as usize, ..default.clone() };
    let paper = MipmapCalibration::Paper as usize;
    let geometric = MipmapInterpolation::Geometric as usize;
    vec![
        ("default", default.clone()),
        ("paper's level", Mipmap { calibration: paper, ..default.clone() }),
        ("geometric", Mipmap { interpolation: geometric, ..default.clone() }),
        ("isotropic", Mipmap { anisotropic: false, ..default.clone() }),
        ("not smoothed", Mipmap { smoothing: false, ..default }),
        ("as printed", printed.clone()),
        ("as printed, paper's level", Mipmap { calibration: paper, ..printed.clone() }),
        ("as printed, geometric", Mipmap { interpolation: geometric, ..printed.clone() }),
        ("as printed, not smoothed", Mipmap { smoothing: false, ..printed.clone() }),
        ("as printed, square filter", Mipmap { circular: false, ..printed }),
    ]
}

#[test]
fn the_shader_computes_what_the_mirror_computes() {
    let color = Image::from_fn(SIZE, |x, y| {
        let stripe = if (x / 6 + y / 9) % 2 == 0 { 0.8 } else { 0.2 };
        vec3(stripe, x as f32 / 96.0, 0.1 + 0.9 * (y as f32 / 64.0))
    });
    // Far steps of CoC, so that no weight hangs on a rounding; foreground and background.
    let depth = Image::from_fn(SIZE, |x, y| match (x, y) {
        (10..=35, 12..=40) => 0.9,
        (50.., ..=30) => f32::INFINITY,
        (50.., _) => 4.0,
        _ => 2.0,
    });
    let lens = common::lens(9.0, 2.0);
    for (name, method) in variants() {
        let gpu_image = render(&method, &color, &depth, &lens);
        let greatest = depth.pixels.iter().map(|d| lens.coc_diameter_px(f64::from(*d)).abs()).fold(0.0, f64::max);
        let mirror = Mirror::new(&color, &depth, &lens, &method, method.levels(&lens, greatest));
        let differences = (0..SIZE.x * SIZE.y).map(|i| {
            let (x, y) = (i % SIZE.x, i / SIZE.x);
            let difference = (gpu_image.at(x, y).as_dvec3() - mirror.pixel(x, y)).abs().max_element();
            (difference, (x, y))
        });
        let (worst, at) = differences.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        println!("{name}: differs by at most {worst:.5} at {at:?}");
        // Five levels stored as f16, each truncated by up to 2^-10 of at most 1; blurs of up
        // to 9 px stored likewise move the level by 1e-2, and with it the colour by as much
        // of the difference between two levels, 0.3 here.
        assert!(worst < 5.0 / 1024.0 + 3e-3, "{name}: differs by {worst} at {at:?}");
    }
}

/// Standard deviation per axis, px, of a lone white point's image, averaged over the
/// phases of the pyramid's grid that `steps` x `steps` positions meet.
fn measured_sigma(method: &Mipmap, c_px: f64, steps: u32) -> f64 {
    let lens = common::lens(80.0, 2.0);
    let size = uvec2(192, 192);
    let depth = Image::filled(size, lens.coc().depth_at(c_px) as f32);
    let mut variance = 0.0;
    for phase in 0..steps * steps {
        let point = size / 2 + uvec2(phase % steps, phase / steps) * 5;
        let color = Image::from_fn(size, |x, y| if uvec2(x, y) == point { Vec3::splat(1000.0) } else { Vec3::ZERO });
        let image = render(method, &color, &depth, &lens);
        let mut moments = [0.0; 5];
        for (i, pixel) in image.pixels.iter().enumerate() {
            let p = dvec2(f64::from(i as u32 % size.x), f64::from(i as u32 / size.x));
            let e = f64::from(pixel.y);
            for (moment, value) in moments.iter_mut().zip([1.0, p.x, p.y, p.x * p.x, p.y * p.y]) {
                *moment += e * value;
            }
        }
        let [m, x, y, xx, yy] = moments;
        variance += (xx / m - (x / m).powi(2) + yy / m - (y / m).powi(2)) / 2.0 / f64::from(steps * steps);
    }
    variance.sqrt()
}

#[test]
fn a_white_point_is_blurred_as_wide_as_the_lens_blurs_it() {
    let (measured, paper) =
        (Mipmap::default(), Mipmap { calibration: MipmapCalibration::Paper as usize, ..Mipmap::default() });
    println!("C px | lens sigma px | measured calibration | paper's calibration");
    for c_px in [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0] {
        let wanted = c_px / 4.0;
        let [own, papers] = [&measured, &paper].map(|m| measured_sigma(m, c_px, 3));
        println!(
            "{c_px:4} | {wanted:6.3} | {own:6.3} ({:+5.1} %) | {papers:6.3} ({:+5.1} %)",
            (own / wanted - 1.0) * 100.0,
            (papers / wanted - 1.0) * 100.0
        );
        // The variance of a bilinear read depends on where between texels it falls: 1/6 of a
        // texel on average, 0 to 1/4 at single places. Nine places leave a few per cent.
        assert!((own / wanted - 1.0).abs() < 0.05, "C = {c_px}: sigma {own} px, the lens's is {wanted} px");
    }
}
