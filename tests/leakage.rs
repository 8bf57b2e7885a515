//! Leakage: what is sharp must not flow into what is blurred. A red and a green surface meet,
//! one in focus, the other blurred; the table says how much of the other's colour each method
//! shows where a lens shows none, and how far from the edge.
//!
//! cargo test --test leakage -- --nocapture

mod common;
mod views;

use common::lens;
use defocus::image::Image;
use defocus::methods::{self, Method, Mipmap, MipmapFilter};
use glam::{UVec2, Vec3, uvec2};
use views::blurred;

const SIZE: UVec2 = uvec2(64, 48);

/// Where the red surface lies: signed distances, px, of pixel centres from its edge, positive
/// outside of it.
type Shape = (&'static str, fn(f64, f64) -> f64);

const SHAPES: [Shape; 4] = [
    ("straight", |x, _| x - 31.0),
    ("diagonal", |x, y| (x + y - 57.0) * std::f64::consts::FRAC_1_SQRT_2),
    ("slanted", |x, y| (3.0 * x + y - 118.0) / 10f64.sqrt()),
    ("thin", |x, y| (x - 0.25 * y - 24.0).abs() - 1.5),
];

const COCS_PX: [f32; 4] = [2.0, 4.0, 8.0, 26.0];

/// This much counts as seen: two steps of 8 bits.
const SEEN: f64 = 2.0 / 255.0;

/// What leaks where.
#[derive(Clone, Copy, Default)]
struct Leak {
    /// Greatest share of the other's colour where a lens shows none of it.
    amount: f64,
    /// Greatest distance, px, from where it may be at which it is seen.
    reach_px: f64,
}

/// Distance, px, of a pixel's centre outside of the red surface.
fn outside_px(shape: Shape, x: u32, y: u32) -> f64 {
    (shape.1)(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// One value on the red surface, another on the rest.
fn painted<T: Copy>(shape: Shape, red: T, rest: T) -> Image<T> {
    Image::from_fn(SIZE, |x, y| if outside_px(shape, x, y) < 0.0 { red } else { rest })
}

/// The red in the picture of `method` farther than `allowed_px` outside of the red surface.
fn leak(method: &dyn Method, shape: Shape, green_coc_px: f32, allowed_px: f64) -> Leak {
    let (color, coc_px) = (painted(shape, Vec3::X, Vec3::Y), painted(shape, 0.0, green_coc_px));
    let picture = blurred(method, &color, &lens(60.0, 2.0), &coc_px);
    let mut leak = Leak::default();
    for (x, y) in (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y))) {
        let beyond_px = outside_px(shape, x, y) - allowed_px;
        if beyond_px > 0.0 {
            let red = f64::from(picture.at(x, y).x);
            leak.amount = leak.amount.max(red);
            leak.reach_px = leak.reach_px.max(if red > SEEN { beyond_px } else { 0.0 });
        }
    }
    leak
}

/// A sharp surface before a blurred one: no red anywhere on the green.
fn sharp_in_front(method: &dyn Method, shape: Shape, coc_px: f32) -> Leak {
    leak(method, shape, coc_px, 0.0)
}

/// A blurred surface before a sharp one: it is seen through as far as half its CoC inside of
/// its edge, and a pixel more that straddles that.
fn blurred_in_front(method: &dyn Method, shape: Shape, coc_px: f32) -> Leak {
    leak(method, shape, -coc_px, 0.5 * f64::from(coc_px) + 1.0)
}

/// All that can render a picture, and `mipmap` as printed.
fn subjects() -> Vec<(String, Box<dyn Method>)> {
    let all = methods::all().into_iter().filter(|m| !m.about().needs_scene && m.about().id != "pinhole");
    let mut subjects: Vec<_> = all.map(|m| (m.about().id.to_owned(), m)).collect();
    let printed = Mipmap { filter: MipmapFilter::AsPrinted as usize, ..Mipmap::default() };
    subjects.push(("mipmap, as printed".into(), Box::new(printed)));
    subjects
}

/// How much of the other's colour a method may show where a lens shows none, and how far, px,
/// from where it may be.
#[derive(Clone, Copy)]
struct Allowed {
    amount: f64,
    reach_px: f64,
}

const NONE: Allowed = Allowed { amount: SEEN, reach_px: 0.0 };

/// What a method's own construction lets through, with the sharp surface in front and with the
/// blurred one in front; of all others nothing.
fn allowed(name: &str, coc_px: f32) -> [Allowed; 2] {
    let c = f64::from(coc_px);
    match name {
        // Scheuermann 2004 gathers from a copy of a quarter of the size, whose texels are 4 px and
        // blurred once more, over a disc of C: it reaches C / 2 and three such texels.
        "preblur" => {
            let in_front = Allowed { amount: 0.4, reach_px: 0.5 * c + 12.0 };
            [in_front, Allowed { amount: 0.15, reach_px: 12.0 }]
        }
        // Kraus 2011, Fig. 2: omega_1 is 1 at z_0 as well, so that what is in focus is part of
        // the first blurred sub-image too, and is laid over what lies behind with the blur of one
        // level: a 4x4 box and a biquadratic spline of 2 px, which reach 4 px. Half of an edge is
        // outside of it; the glow of equation (8) makes up to 1 - (1 - 1/2)^2 of that.
        "pyramid" => [Allowed { amount: 0.5, reach_px: 4.0 }, NONE],
        "opaque" => [Allowed { amount: 0.75, reach_px: 4.0 }, NONE],
        // Lee, Eisemann and Seidel 2009, section 4.3: a slab is a height field, solid behind its
        // surface. Where one slab holds both surfaces (delta is 3 px) a ray that passes under the
        // nearer one meets its texel: by half the CoC and a texel.
        "multiview" if coc_px < 3.0 => [Allowed { amount: 0.5, reach_px: 0.5 * c + 1.0 }, NONE],
        // TVCG 2009, equation (9): delta of 1 px of DoB, which is a CoC of 2 px, is not refused,
        // nor is half of that around it on a level whose texels hold both.
        "mipmap, as printed" => {
            let sharp = if coc_px <= 8.0 { Allowed { amount: 0.25, reach_px: 3.0 } } else { NONE };
            [sharp, Allowed { amount: 0.02, reach_px: 2.0 }]
        }
        _ => [NONE; 2],
    }
}

#[test]
fn no_method_leaks_more_or_farther_than_its_construction_lets_it() {
    let _turn = views::turn();
    let mut broken = Vec::new();
    println!("C = {COCS_PX:?} px: red where a lens shows none, and how far away (px) it is seen");
    println!("method | shape | sharp in front | blurred in front");
    for (name, method) in subjects() {
        for shape in SHAPES {
            let orders = [sharp_in_front, blurred_in_front].map(|order| COCS_PX.map(|c| order(&*method, shape, c)));
            let within =
                |leak: Leak, allowed: Allowed| leak.amount <= allowed.amount && leak.reach_px <= allowed.reach_px;
            let all_within = (0..2)
                .all(|order| (0..COCS_PX.len()).all(|i| within(orders[order][i], allowed(&name, COCS_PX[i])[order])));
            let text = |leaks: &[Leak]| {
                let cells: Vec<_> = leaks.iter().map(|l| format!("{:.3} {:4.1}", l.amount, l.reach_px)).collect();
                cells.join(", ")
            };
            println!("{name} | {} | {} | {}", shape.0, text(&orders[0]), text(&orders[1]));
            if !all_within {
                broken.push(format!("{name}, {}: {} | {}", shape.0, text(&orders[0]), text(&orders[1])));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
