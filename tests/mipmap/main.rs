//! `mipmap` against f64 mirrors of its shaders, function by function, and the measured
//! width of its blur.

#[path = "../common/mod.rs"]
mod common;
mod discs;
mod printed;
mod surroundings;

use common::gpu;
use defocus::gpu::download;
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::{self, Mipmap, MipmapCalibration, MipmapFilter, MipmapInterpolation};
use defocus::view::View;
use glam::{DVec3, UVec2, Vec3, dvec2, uvec2, vec3};

/// `KERNEL` of the shaders.
const KERNEL: [f64; 4] = [0.125, 0.375, 0.375, 0.125];

/// As in the shaders.
fn variance_as_printed(m: f64) -> f64 {
    if m < 1.5 {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        return 0.375 + 0.25 * half * (1.0 - half);
    }
    let texel2 = 4f64.powf(m - 1.0);
    0.25 * (texel2 - 1.0) + texel2 * (1.0 / 6.0 + 0.375)
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
        ("as printed, square filter", Mipmap { circular: false, ..printed.clone() }),
        ("as printed, blur at 5 points", Mipmap { blur_points: 1, ..printed.clone() }),
        ("as printed, bilinear", Mipmap { bilinear: true, ..printed.clone() }),
        ("as printed, bilinear, paper's level", Mipmap { bilinear: true, calibration: paper, ..printed }),
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
        let levels = method.levels(&lens, greatest);
        let pixel: Box<dyn Fn(u32, u32) -> DVec3> = match method.filter == MipmapFilter::Discs as usize {
            true => {
                let mirror = discs::Mirror::new(&color, &depth, &lens, &method, levels);
                Box::new(move |x, y| mirror.pixel(x, y))
            }
            false => {
                let mirror = printed::Mirror::new(&color, &depth, &lens, &method, levels);
                Box::new(move |x, y| mirror.pixel(x, y))
            }
        };
        let difference = |i: u32| {
            let (x, y) = (i % SIZE.x, i / SIZE.x);
            (gpu_image.at(x, y).as_dvec3() - pixel(x, y)).abs().max_element()
        };
        let differences: Vec<f64> = (0..SIZE.element_product()).map(difference).collect();
        // Five levels stored as f16, each truncated by up to 2^-10 of at most 1; blurs of up
        // to 9 px stored likewise move the level by 1e-2, and with it the colour by as much
        // of the difference between two levels, 0.3 here.
        let limit = 5.0 / 1024.0 + 3e-3;
        let off = differences.iter().filter(|d| **d > limit).count();
        let worst = differences.iter().copied().fold(0.0, f64::max);
        println!("{name}: differs by at most {worst:.5}, by more than {limit:.4} at {off} pixels");
        // As printed a read is refused by a threshold: rounding decides where the blur is just
        // there. A read weighs up to a quarter.
        let refuses = method.filter == MipmapFilter::AsPrinted as usize && method.anisotropic;
        let allowed = if refuses { SIZE.element_product() as usize / 1000 } else { 0 };
        assert!(off <= allowed, "{name}: {off} pixels differ by up to {worst}");
        assert!(worst < limit + 0.25, "{name}: differs by {worst}");
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
    let measured = Mipmap::default();
    let paper = Mipmap {
        calibration: MipmapCalibration::Paper as usize,
        filter: MipmapFilter::AsPrinted as usize,
        ..Mipmap::default()
    };
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
