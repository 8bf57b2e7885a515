//! Leakage: what is sharp must not flow into what is blurred. A red and a green surface meet,
//! one in focus, the other blurred; the table says how much of the other's colour each method
//! shows where a lens shows none, and how far from the edge.
//!
//! cargo test --test leakage -- --nocapture

mod common;
mod views;

use common::lens;
use defocus::image::{ColorImage, Image};
use defocus::methods::{self, Method, Mipmap, MipmapFilter};
use glam::{UVec2, Vec3, uvec2};
use views::blurred;

const SIZE: UVec2 = uvec2(96, 72);

/// Where the red surface lies: signed distances, px, of pixel centres from its edge, positive
/// outside of it.
type Shape = (&'static str, fn(f64, f64) -> f64);

const SHAPES: [Shape; 5] = [
    ("straight", |x, _| x - 47.0),
    ("straight, other phase", |x, _| x - 50.0),
    ("diagonal", |x, y| (x + y - 83.0) * std::f64::consts::FRAC_1_SQRT_2),
    ("slanted", |x, y| (3.0 * x + y - 183.0) / 10f64.sqrt()),
    ("thin", |x, y| (x - 0.25 * y - 38.0).abs() - 1.5),
];

const COCS_PX: [f32; 4] = [2.0, 4.0, 8.0, 26.0];

/// Beyond what the lens shows, this much counts as seen: two steps of 8 bits.
const SEEN: f64 = 2.0 / 255.0;

/// What leaks where.
#[derive(Clone, Copy, Default)]
struct Leak {
    /// Greatest share of the other's colour where a lens shows none of it.
    amount: f64,
    /// Greatest distance, px, from where it may be at which it is seen.
    reach_px: f64,
}

fn distance(shape: Shape, i: usize) -> f64 {
    let (x, y) = (i as u32 % SIZE.x, i as u32 / SIZE.x);
    (shape.1)(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

fn red_and_green(shape: Shape) -> ColorImage {
    let pixels = (0..SIZE.element_product() as usize);
    let color = |i| if distance(shape, i) < 0.0 { Vec3::X } else { Vec3::Y };
    Image { size: SIZE, pixels: pixels.map(color).collect() }
}

/// CoCs of the red surface and of the rest.
fn cocs(shape: Shape, red_px: f32, green_px: f32) -> Image<f32> {
    let pixels = (0..SIZE.element_product() as usize);
    let coc = |i| if distance(shape, i) < 0.0 { red_px } else { green_px };
    Image { size: SIZE, pixels: pixels.map(coc).collect() }
}

/// The red in the picture of `method` farther than `allowed_px` outside of the red surface.
fn leak(method: &dyn Method, shape: Shape, [red_px, green_px]: [f32; 2], allowed_px: f64) -> Leak {
    let picture = blurred(method, &red_and_green(shape), &lens(60.0, 2.0), &cocs(shape, red_px, green_px));
    let mut leak = Leak::default();
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let beyond_px = distance(shape, i) - allowed_px;
        if beyond_px > 0.0 {
            let red = f64::from(pixel.x);
            leak.amount = leak.amount.max(red);
            leak.reach_px = leak.reach_px.max(if red > SEEN { beyond_px } else { 0.0 });
        }
    }
    leak
}

/// A sharp surface before a blurred one: no red anywhere on the green.
fn sharp_in_front(method: &dyn Method, shape: Shape, coc_px: f32) -> Leak {
    leak(method, shape, [0.0, coc_px], 0.0)
}

/// A blurred surface before a sharp one: it is seen through as far as half its CoC inside of
/// its edge, and a pixel more that straddles that.
fn blurred_in_front(method: &dyn Method, shape: Shape, coc_px: f32) -> Leak {
    leak(method, shape, [0.0, -coc_px], 0.5 * f64::from(coc_px) + 1.0)
}

/// All that can render a picture, and `mipmap` as printed.
fn subjects() -> Vec<(String, Box<dyn Method>)> {
    let all = methods::all().into_iter().filter(|m| !m.about().needs_scene && m.about().id != "pinhole");
    let mut subjects: Vec<_> = all.map(|m| (m.about().id.to_owned(), m)).collect();
    let printed = Mipmap { filter: MipmapFilter::AsPrinted as usize, ..Mipmap::default() };
    subjects.push(("mipmap, as printed".into(), Box::new(printed)));
    subjects
}

/// How much a method may leak over all shapes and CoCs.
#[derive(Clone, Copy)]
struct Bound {
    /// With the sharp surface in front.
    sharp_in_front: f64,
    /// With the blurred surface in front.
    blurred_in_front: f64,
}

/// What is held to: by default nothing in front, and behind blurred foreground the tails of
/// filters that are no discs.
fn bound(name: &str) -> Option<Bound> {
    match name {
        // Their limits say that they leak.
        "preblur" | "linear" => None,
        _ => Some(Bound { sharp_in_front: SEEN, blurred_in_front: 0.05 }),
    }
}

#[test]
fn no_method_that_claims_so_lets_what_is_sharp_leak() {
    let _turn = views::turn();
    let mut broken = Vec::new();
    println!("method | shape | sharp in front: red on green, and how far (px), at C = {COCS_PX:?} px | blurred in front: beyond C/2");
    for (name, method) in subjects() {
        for shape in SHAPES {
            let front = COCS_PX.map(|coc_px| sharp_in_front(&*method, shape, coc_px));
            let behind = COCS_PX.map(|coc_px| blurred_in_front(&*method, shape, coc_px));
            let text = |leaks: &[Leak]| {
                let cells: Vec<_> = leaks.iter().map(|l| format!("{:.3} {:4.1}", l.amount, l.reach_px)).collect();
                cells.join(", ")
            };
            println!("{name} | {} | {} | {}", shape.0, text(&front), text(&behind));
            let Some(bound) = bound(&name) else { continue };
            for (order, leaks, most) in
                [("sharp", front, bound.sharp_in_front), ("blurred", behind, bound.blurred_in_front)]
            {
                for (leak, coc_px) in leaks.iter().zip(COCS_PX) {
                    if leak.amount > most {
                        broken.push(format!("{name}, {}, {order} in front, C = {coc_px} px: {:.3}", shape.0, leak.amount));
                    }
                }
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
