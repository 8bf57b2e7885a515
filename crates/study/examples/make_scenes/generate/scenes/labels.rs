//! Printed matter: the labels of the cans and a poster.

use super::prelude::*;

const W: f32 = 1024.0;
const H: f32 = 440.0;

struct Label {
    title: &'static str,
    below: &'static str,
    ground: u32,
    band: u32,
    ink: u32,
    gold: u32,
}

/// Six labels; the front is the middle of the image, the back its borders.
pub fn all() -> Vec<Canvas> {
    let label = |title, below, ground, band, ink, gold| Label { title, below, ground, band, ink, gold };
    [
        label("TOMATO", "SUN RIPENED - NO. 7", 0xb3201c, 0xf3e6c8, 0x8f1512, 0xe0b040),
        label("COFFEE", "DARK ROAST 250 G", 0x2a1a12, 0xc8963c, 0x1c100a, 0xf0dca0),
        label("PEAS", "SMALL & TENDER", 0x1f6b3a, 0xf2efd8, 0x174f2b, 0xf2c230),
        label("CORN", "GOLDEN KERNELS", 0xf0b81e, 0x1f3f7a, 0xfff2c4, 0xd23c1e),
        label("BEANS", "IN TOMATO SAUCE", 0x1c6f94, 0xf6f1e2, 0x12324a, 0xe8562a),
        label("SOUP", "CREAM OF CELERY", 0xe9e4d8, 0xb5121b, 0xfdf6e6, 0xc9a24a),
    ]
    .iter()
    .enumerate()
    .map(|(i, l)| paint(l, i as u32))
    .collect()
}

fn paint(l: &Label, index: u32) -> Canvas {
    let (ground, band, ink, gold) = (rgb(l.ground), rgb(l.band), rgb(l.ink), rgb(l.gold));
    let mut c = Canvas::filled(W as usize, H as usize, ground);
    background(&mut c, index, ground, band, gold);
    // The front: a framed panel with the name.
    let (x, y, w, h) = (W * 0.5 - 180.0, 92.0, 360.0, 250.0);
    c.rect(x - 10.0, y - 10.0, w + 20.0, h + 20.0, gold);
    c.rect(x - 5.0, y - 5.0, w + 10.0, h + 10.0, ink);
    c.rect(x, y, w, h, band);
    let stroke_colour = if index == 3 || index == 5 { rgb(0xfff4d2) } else { ink };
    c.text_centred(W * 0.5, y + 20.0, 14.0, 2.6, stroke_colour, "APERTURE & SONS - 1827");
    c.rect(x + 20.0, y + 46.0, w - 40.0, 3.0, gold);
    let cap = (318.0 / l.title.len() as f32).min(80.0);
    c.text_centred(W * 0.5 + 3.0, y + 107.0 - cap * 0.5, cap, 0.22 * cap, gold.lerp(ink, 0.3), l.title);
    c.text_centred(W * 0.5, y + 103.0 - cap * 0.5, cap, 0.2 * cap, stroke_colour, l.title);
    c.text_centred(W * 0.5, y + 166.0, 19.0, 3.8, stroke_colour, l.below);
    c.rect(x + 20.0, y + 200.0, w - 40.0, 3.0, gold);
    c.text_centred(W * 0.5, y + 214.0, 11.0, 1.9, stroke_colour, "NET WT. 400 G - BEST BEFORE 05/31");
    for side in [-1.0, 1.0] {
        medallion(&mut c, vec2(W * 0.5 + side * 188.0, y + h * 0.5), ink, gold, band, l.title);
    }
    facts(&mut c, 18.0, index);
    barcode(&mut c, W - 196.0, 150.0, index);
    c.rect(0.0, 0.0, W, 12.0, gold);
    c.rect(0.0, 15.0, W, 3.0, gold);
    c.rect(0.0, H - 12.0, W, 12.0, gold);
    c.rect(0.0, H - 18.0, W, 3.0, gold);
    c
}

fn background(c: &mut Canvas, index: u32, ground: Vec3, band: Vec3, gold: Vec3) {
    let all = vec2(W, H);
    match index {
        // Small fruit in a lattice.
        0 => (0..9).for_each(|row| {
            (0..33).for_each(|k| {
                let p = vec2(k as f32 * W / 32.0 + 16.0 * (row % 2) as f32, 30.0 + row as f32 * 48.0);
                c.disc(p, 11.0, ground * 0.62);
                c.disc(p - vec2(3.0, 3.0), 3.0, rgb(0xff9a80));
                c.stroke(&[p - vec2(5.0, 10.0), p - vec2(0.0, 14.0), p + vec2(5.0, -10.0)], 3.0, rgb(0x3f7a2c));
            });
        }),
        1 => c.blend(Vec2::ZERO, all, gold * 0.8, |p| {
            lines(p.x / 16.0, 0.12, 0.06).max(lines(p.y / 16.0, 0.12, 0.06)) * 0.7
        }),
        2 => c.blend(Vec2::ZERO, all, band, |p| lines((p.x + p.y) / 32.0, 0.4, 0.03)),
        3 => (0..11).for_each(|row| {
            (0..32).for_each(|k| {
                c.disc(vec2(k as f32 * 32.0 + 16.0 * (row % 2) as f32, row as f32 * 40.0 + 20.0), 9.0, band);
            });
        }),
        4 => c.blend(Vec2::ZERO, all, band, |p| {
            let (a, b) = ((p.x / 32.0).floor() as i32, (p.y / 32.0).floor() as i32);
            f32::from((a + b) % 2 == 0) * 0.9
        }),
        _ => c.rect(0.0, 0.0, W, H * 0.5, band),
    }
}

fn medallion(c: &mut Canvas, p: Vec2, ink: Vec3, gold: Vec3, band: Vec3, title: &str) {
    c.disc(p, 52.0, gold);
    c.disc(p, 47.0, ink.lerp(Vec3::ZERO, 0.2));
    for k in 0..24 {
        let (sin, cos) = (k as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
        c.stroke(&[p + vec2(cos, sin) * 33.0, p + vec2(cos, sin) * 43.0], 3.0, gold);
    }
    c.ring(p, 29.0, 2.5, gold);
    let lettering = if band.element_sum() > ink.element_sum() { band } else { gold };
    c.text_centred(p.x, p.y - 13.0, 26.0, 6.0, lettering, &title[..1]);
}

fn facts(c: &mut Canvas, x: f32, index: u32) {
    let (paper, black) = (rgb(0xf4f1e8), rgb(0x151515));
    c.rect(x, 62.0, 196.0, 316.0, paper);
    c.rect(x + 4.0, 66.0, 188.0, 2.0, black);
    c.text(vec2(x + 10.0, 76.0), 17.0, 3.6, black, "NUTRITION");
    c.rect(x + 4.0, 100.0, 188.0, 6.0, black);
    let rows = ["ENERGY", "FAT", "SUGARS", "FIBRE", "PROTEIN", "SALT", "IRON", "WATER", "BOKEH"];
    for (k, row) in rows.iter().enumerate() {
        let y = 114.0 + 27.0 * k as f32;
        c.text(vec2(x + 10.0, y), 11.0, 2.0, black, row);
        let amount = format!("{:.1} G", 40.0 * hash(k as i32, 2, index));
        c.text(vec2(x + 122.0, y), 11.0, 2.0, black, &amount);
        c.rect(x + 6.0, y + 18.0, 184.0, 1.5, black);
    }
}

fn barcode(c: &mut Canvas, x: f32, y: f32, index: u32) {
    let (paper, black) = (rgb(0xfbfaf5), rgb(0x0c0c0c));
    c.rect(x, y, 170.0, 150.0, paper);
    let mut bar = x + 14.0;
    let mut k = 0;
    while bar < x + 150.0 {
        let width = 2.0 + (hash(k, 0, index + 31) * 3.0).floor() * 2.0;
        c.rect(bar, y + 12.0, width, 104.0, black);
        bar += width + 2.0 + (hash(k, 1, index + 31) * 3.0).floor() * 2.0;
        k += 1;
    }
    let digits: String = (0..9).map(|k| char::from(b'0' + (hash(k, 7, index) * 10.0) as u8)).collect();
    c.text_centred(x + 85.0, y + 124.0, 14.0, 2.4, black, &digits);
}

/// A fairground poster.
pub fn poster() -> Canvas {
    let (w, h) = (640.0, 848.0);
    let (paper, ink, red) = (rgb(0xead9b0), rgb(0x1b2a3c), rgb(0xb9351f));
    let mut c = Canvas::filled(w as usize, h as usize, paper);
    for k in 0..36 {
        let (a, b) = (k as f32 / 36.0 * std::f32::consts::TAU, (k as f32 + 0.5) / 36.0 * std::f32::consts::TAU);
        let centre = vec2(w * 0.5, 420.0);
        c.blend(vec2(40.0, 210.0), vec2(w - 40.0, 640.0), rgb(0xdca23a), |p| {
            let d = p - centre;
            let angle = d.y.atan2(d.x).rem_euclid(std::f32::consts::TAU);
            f32::from(angle > a && angle < b)
        });
    }
    c.disc(vec2(w * 0.5, 420.0), 150.0, ink);
    c.disc(vec2(w * 0.5, 420.0), 138.0, paper);
    // An iris of six blades.
    for k in 0..6 {
        let edge = |turn: f32, r: f32| {
            let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
            vec2(w * 0.5, 420.0) + vec2(cos, sin) * r
        };
        let t = k as f32 / 6.0;
        c.stroke(&[edge(t, 130.0), edge(t + 0.155, 52.0), edge(t + 0.32, 62.0)], 7.0, red);
    }
    c.disc(vec2(w * 0.5, 420.0), 44.0, ink);
    c.text_centred(w * 0.5, 60.0, 78.0, 17.0, red, "GRAND");
    c.text_centred(w * 0.5, 158.0, 40.0, 9.0, ink, "EXPOSITION");
    c.text_centred(w * 0.5, 662.0, 52.0, 11.0, ink, "OF LIGHT");
    c.text_centred(w * 0.5, 738.0, 24.0, 4.5, red, "LENSES - LANTERNS - LIMES");
    c.text_centred(w * 0.5, 782.0, 20.0, 3.5, ink, "DAILY 9 - 5  MARKET HALL 1827");
    for (inset, width) in [(14.0, 8.0), (28.0, 3.0)] {
        let (a, b, d, e) =
            (vec2(inset, inset), vec2(w - inset, inset), vec2(w - inset, h - inset), vec2(inset, h - inset));
        c.stroke(&[a, b, d, e, a], width, ink);
    }
    c.wear(0.5, |uv| 0.55 + 0.6 * fbm(uv, ivec2(5, 6), 5, 77));
    c
}
