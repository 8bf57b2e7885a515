//! Images with depth that are hard on arithmetic.

use crate::random::Random;
use defocus::image::{ColorImage, DepthImage, Image};
use glam::{UVec2, Vec3, uvec2, vec3};

/// A colour image with what it is a case of.
#[derive(Clone, Copy)]
pub struct ColorCondition {
    /// In words.
    pub name: &'static str,
    /// Makes one of a size, px.
    pub make: fn(UVec2) -> ColorImage,
}

/// A depth map with what it is a case of.
#[derive(Clone, Copy)]
pub struct DepthCondition {
    /// In words.
    pub name: &'static str,
    /// Makes one of a size, px, around the focus distance, metres.
    pub make: fn(UVec2, f32) -> DepthImage,
}

/// Sizes, px: a pixel, lines, odd, prime and even sides, one pixel more than a power of
/// two, an aspect of 1:100 both ways.
pub const SIZES: &[UVec2] = &[
    uvec2(24, 16),
    uvec2(1, 1),
    uvec2(1, 13),
    uvec2(13, 1),
    uvec2(2, 2),
    uvec2(3, 5),
    uvec2(17, 11),
    uvec2(31, 7),
    uvec2(16, 16),
    uvec2(33, 17),
    uvec2(100, 1),
    uvec2(1, 100),
];

/// Sizes, px, so wide that they are tried with few lenses only.
pub const LONG_SIZES: &[UVec2] = &[uvec2(8191, 1), uvec2(1, 8191)];

/// Light of the brightest points: bright enough for highlights.
const POINT: f32 = 64.0;

/// Greatest finite f16.
const MAX_F16: f32 = 65504.0;

fn is_checker(x: u32, y: u32) -> bool {
    (x + y).is_multiple_of(2)
}

/// A hash of a position in [0, 1): noise without a seed.
fn noise(x: u32, y: u32) -> f32 {
    let mut random = Random::new(u64::from(y) << 32 | u64::from(x));
    random.unit() as f32
}

/// Hard edges and fine detail in [0.05, 1].
pub fn busy(size: UVec2) -> ColorImage {
    Image::from_fn(size, |x, y| {
        let bar = if (x / 7 + y / 5) % 2 == 0 { 0.9 } else { 0.1 };
        vec3(bar, 0.05 + 0.95 * noise(x, y), (x as f32 / size.x as f32).max(0.05))
    })
}

fn checker(size: UVec2, a: f32, b: f32) -> ColorImage {
    Image::from_fn(size, |x, y| Vec3::splat(if is_checker(x, y) { a } else { b }))
}

/// Black but for one pixel in the middle.
pub fn point(size: UVec2, brightness: f32) -> ColorImage {
    Image::from_fn(size, |x, y| if uvec2(x, y) == size / 2 { Vec3::splat(brightness) } else { Vec3::ZERO })
}

/// The colours.
pub const COLORS: &[ColorCondition] = &[
    ColorCondition { name: "detail", make: busy },
    ColorCondition { name: "one colour", make: |size| Image::filled(size, vec3(0.25, 0.5, 2.0)) },
    ColorCondition { name: "black", make: |size| Image::filled(size, Vec3::ZERO) },
    ColorCondition { name: "1e-7 and 1", make: |size| checker(size, 1e-7, 1.0) },
    ColorCondition {
        name: "subnormal numbers of f16 and f32",
        make: |size| Image::from_fn(size, |x, y| vec3(6e-8, 1e-40, 3e-5) * (1.0 + noise(x, y))),
    },
    ColorCondition { name: "65504 everywhere", make: |size| Image::filled(size, Vec3::splat(MAX_F16)) },
    ColorCondition { name: "0 and 65504", make: |size| checker(size, 0.0, MAX_F16) },
    ColorCondition { name: "beyond f16", make: |size| checker(size, 1e38, 1e5) },
    ColorCondition {
        name: "NaN and infinite pixels",
        make: |size| {
            Image::from_fn(size, |x, y| match (x * 5 + y * 3) % 7 {
                0 => vec3(0.5, f32::NAN, 0.5),
                3 => vec3(f32::INFINITY, 0.5, 0.5),
                5 => vec3(0.5, 0.5, f32::NEG_INFINITY),
                _ => vec3(0.2, 0.4, 0.6),
            })
        },
    },
    ColorCondition { name: "negative colours", make: |size| checker(size, -3.0, 2.0) },
    ColorCondition { name: "a bright point", make: |size| point(size, POINT) },
    ColorCondition { name: "a point of 65504", make: |size| point(size, MAX_F16) },
];

/// The depths.
pub const DEPTHS: &[DepthCondition] = &[
    DepthCondition { name: "all in focus", make: Image::filled },
    DepthCondition { name: "all in front", make: |size, focus| Image::filled(size, 0.6 * focus) },
    DepthCondition { name: "all behind", make: |size, focus| Image::filled(size, 4.0 * focus) },
    DepthCondition { name: "all infinite", make: |size, _| Image::filled(size, f32::INFINITY) },
    DepthCondition {
        name: "from a millionth of df to infinity",
        make: |size, focus| {
            let last = (size.x * size.y - 1).max(1) as f32;
            Image::from_fn(size, |x, y| {
                let t = (y * size.x + x) as f32 / last;
                if t == 1.0 { f32::INFINITY } else { focus * 1e-6 * (1e12_f32).powf(t) }
            })
        },
    },
    DepthCondition {
        name: "checkerboard of near and far",
        make: |size, focus| Image::from_fn(size, |x, y| focus * if is_checker(x, y) { 0.5 } else { 4.0 }),
    },
    DepthCondition {
        name: "checkerboard of nearest and infinite",
        make: |size, focus| {
            Image::from_fn(size, |x, y| if is_checker(x / 2, y / 2) { 0.01 * focus } else { f32::INFINITY })
        },
    },
    DepthCondition {
        name: "ramp through the focus",
        make: |size, focus| Image::from_fn(size, |x, _| focus * (0.5 + 1.5 * (x as f32 + 0.5) / size.x as f32)),
    },
    DepthCondition {
        name: "slope of 1 % around the focus",
        make: |size, focus| Image::from_fn(size, |_, y| focus * (0.99 + 0.02 * (y as f32 + 0.5) / size.y as f32)),
    },
    DepthCondition {
        name: "one rounding step around the focus",
        make: |size, focus| Image::from_fn(size, |x, y| if is_checker(x, y) { focus } else { focus.next_up() }),
    },
    DepthCondition {
        name: "holes of a pixel",
        make: |size, focus| Image::from_fn(size, |x, y| if noise(x, y) < 0.1 { f32::INFINITY } else { 0.7 * focus }),
    },
    DepthCondition {
        name: "specks before a wall",
        make: |size, focus| Image::from_fn(size, |x, y| if noise(y, x) < 0.1 { 0.05 * focus } else { 3.0 * focus }),
    },
    DepthCondition {
        name: "near object before a sharp wall",
        make: |size, focus| {
            let inside = |at: u32, side: u32| at >= side / 3 && at < side - side / 3;
            Image::from_fn(size, |x, y| if inside(x, size.x) && inside(y, size.y) { 0.4 * focus } else { focus })
        },
    },
    DepthCondition {
        name: "noise over all depths",
        make: |size, focus| Image::from_fn(size, |x, y| focus * 0.01 * (1e4_f32).powf(noise(x + 7, y + 3))),
    },
    DepthCondition {
        name: "depths that are none",
        make: |size, focus| {
            Image::from_fn(size, |x, y| match (x * 3 + y * 5) % 7 {
                0 => f32::NAN,
                2 => -1.0,
                4 => 0.0,
                6 => f32::NEG_INFINITY,
                _ => 2.0 * focus,
            })
        },
    },
];

/// Colours over the whole range of f16, in blocks or by the pixel.
pub fn random_color(random: &mut Random, size: UVec2) -> ColorImage {
    let block = 1 + random.index(6) as u32;
    let seed = random.bits();
    let top = random.log_between(1e-3, 60000.0);
    Image::from_fn(size, |x, y| {
        let cell = u64::from(y / block) << 32 | u64::from(x / block);
        let mut random = Random::new(seed ^ cell.wrapping_mul(0x2545_f491_4f6c_dd1d));
        Vec3::from_array(
            [0; 3].map(|_| if random.index(4) == 0 { 0.0 } else { random.log_between(1e-6 * top, top) } as f32),
        )
    })
}

/// Depths over many scales around the focus, in blocks or by the pixel.
pub fn random_depth(random: &mut Random, size: UVec2, focus_m: f32) -> DepthImage {
    let block = 1 + random.index(6) as u32;
    let seed = random.bits();
    let spread = random.log_between(1.01, 1e4);
    Image::from_fn(size, |x, y| {
        let cell = u64::from(y / block) << 32 | u64::from(x / block);
        let mut random = Random::new(seed ^ cell.wrapping_mul(0x2545_f491_4f6c_dd1d));
        match random.index(12) {
            0 => f32::INFINITY,
            1 | 2 => focus_m,
            _ => focus_m * random.log_between(1.0 / spread, spread) as f32,
        }
    })
}
