//! Painting textures: display-referred RGB canvases, shapes and lettering.

use super::noise::{mix, smoothstep};
use glam::{Vec2, Vec3, vec2, vec3};
use image::codecs::{jpeg::JpegEncoder, png};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

/// An image being painted; values are sRGB display values in [0, 1].
#[derive(Clone)]
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Vec3>,
    /// Opacity of each pixel in [0, 1]; empty where all is opaque.
    pub cover: Vec<f32>,
}

/// 0xRRGGBB as display values.
pub fn rgb(hex: u32) -> Vec3 {
    let channel = |shift: u32| ((hex >> shift) & 255) as f32 / 255.0;
    vec3(channel(16), channel(8), channel(0))
}

impl Canvas {
    /// One colour.
    pub fn filled(width: usize, height: usize, colour: Vec3) -> Self {
        Self { width, height, pixels: vec![colour; width * height], cover: Vec::new() }
    }

    /// `colour(uv)` at every pixel centre, averaged over 2x2 samples.
    pub fn paint(width: usize, height: usize, colour: impl Fn(Vec2) -> Vec3 + Sync) -> Self {
        let size = vec2(width as f32, height as f32);
        let pixel = |i: usize| {
            let corner = vec2((i % width) as f32, (i / width) as f32);
            let at = |x, y| colour((corner + vec2(x, y)) / size);
            (at(0.25, 0.25) + at(0.75, 0.25) + at(0.25, 0.75) + at(0.75, 0.75)) * 0.25
        };
        Self { width, height, pixels: (0..width * height).into_par_iter().map(pixel).collect(), cover: Vec::new() }
    }

    /// Opaque where `cover(uv)` is 1, nothing where it is 0.
    pub fn covered(mut self, cover: impl Fn(Vec2) -> f32 + Sync) -> Self {
        let mask = Self::paint(self.width, self.height, |uv| Vec3::splat(cover(uv)));
        self.cover = mask.pixels.iter().map(|p| p.x).collect();
        self
    }

    /// Darkens and brightens as if `height(uv)` were lit from the upper left.
    pub fn emboss(mut self, strength: f32, height: impl Fn(Vec2) -> f32 + Sync) -> Self {
        let (w, h) = (self.width, self.height);
        let at = |i: usize| height(vec2(((i % w) as f32 + 0.5) / w as f32, ((i / w) as f32 + 0.5) / h as f32));
        let heights: Vec<f32> = (0..w * h).into_par_iter().map(at).collect();
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            let (x, y) = (i % w, i / w);
            let before = heights[(y + h - 1) % h * w + (x + w - 1) % w];
            let after = heights[(y + 1) % h * w + (x + 1) % w];
            let shade = (1.0 + strength * (after - before)).clamp(0.35, 1.6);
            *pixel = (*pixel * shade).clamp(Vec3::ZERO, Vec3::ONE);
        }
        self
    }

    /// Blends `colour` over the pixels within `lo..hi` (px) by `cover(pixel centre)`.
    pub fn blend(&mut self, lo: Vec2, hi: Vec2, colour: Vec3, cover: impl Fn(Vec2) -> f32) {
        let (x0, y0) = (lo.x.floor().max(0.0) as usize, lo.y.floor().max(0.0) as usize);
        let (x1, y1) = ((hi.x.ceil() as usize).min(self.width), (hi.y.ceil() as usize).min(self.height));
        for y in y0..y1 {
            for x in x0..x1 {
                let a = cover(vec2(x as f32 + 0.5, y as f32 + 0.5)).clamp(0.0, 1.0);
                let pixel = &mut self.pixels[y * self.width + x];
                *pixel = pixel.lerp(colour, a);
            }
        }
    }

    /// A filled rectangle, px.
    pub fn rect(&mut self, x: f32, y: f32, w: f32, h: f32, colour: Vec3) {
        self.blend(vec2(x, y), vec2(x + w, y + h), colour, |p| {
            f32::from(p.x >= x && p.x < x + w && p.y >= y && p.y < y + h)
        });
    }

    /// A filled disc, px.
    pub fn disc(&mut self, centre: Vec2, radius: f32, colour: Vec3) {
        let r = Vec2::splat(radius + 1.0);
        self.blend(centre - r, centre + r, colour, |p| radius + 0.5 - (p - centre).length());
    }

    /// A ring, px.
    pub fn ring(&mut self, centre: Vec2, radius: f32, thickness: f32, colour: Vec3) {
        let r = Vec2::splat(radius + thickness);
        self.blend(centre - r, centre + r, colour, |p| thickness * 0.5 + 0.5 - ((p - centre).length() - radius).abs());
    }

    /// Lettering: upper-left corner, cap height and stroke width in px. Returns the width.
    pub fn text(&mut self, corner: Vec2, cap_height: f32, stroke: f32, colour: Vec3, text: &str) -> f32 {
        let unit = cap_height / 6.0;
        let mut x = corner.x;
        for c in text.chars() {
            for line in glyph(c).split('|').filter(|line| !line.is_empty()) {
                let points: Vec<Vec2> = line
                    .split(' ')
                    .map(|xy| {
                        let (px, py) = (f32::from(xy.as_bytes()[0] - b'0'), f32::from(xy.as_bytes()[1] - b'0'));
                        vec2(x + px * unit, corner.y + (6.0 - py) * unit)
                    })
                    .collect();
                self.stroke(&points, stroke, colour);
            }
            x += text_advance(c) * unit;
        }
        x - corner.x
    }

    /// [`Canvas::text`] centred on `x`.
    pub fn text_centred(&mut self, x: f32, y: f32, cap_height: f32, stroke: f32, colour: Vec3, text: &str) {
        let width: f32 = text.chars().map(text_advance).sum::<f32>() * cap_height / 6.0 - cap_height / 4.0;
        self.text(vec2(x - width * 0.5, y), cap_height, stroke, colour, text);
    }

    /// A polyline with round joints, px.
    pub fn stroke(&mut self, points: &[Vec2], width: f32, colour: Vec3) {
        let (lo, hi) = points.iter().fold((Vec2::MAX, Vec2::MIN), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let margin = Vec2::splat(width);
        self.blend(lo - margin, hi + margin, colour, |p| {
            let distance = |ab: &[Vec2]| segment_distance(p, ab[0], ab[1]);
            let nearest = points.windows(2).map(distance).fold(f32::MAX, f32::min);
            width * 0.5 + 0.5 - nearest
        });
    }

    /// Mottles everything by `amount` with `cover(uv)` in [0, 1].
    pub fn wear(&mut self, amount: f32, cover: impl Fn(Vec2) -> f32) {
        let (w, h) = (self.width as f32, self.height as f32);
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            let uv = vec2((i % self.width) as f32 / w, (i / self.width) as f32 / h);
            *pixel *= mix(1.0, cover(uv), amount);
        }
    }

    /// RGB bytes, or RGBA of a canvas that is not opaque everywhere.
    pub fn bytes(&self) -> Vec<u8> {
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let colors = self.pixels.iter().map(|p| [byte(p.x), byte(p.y), byte(p.z)]);
        match self.cover.is_empty() {
            true => colors.flatten().collect(),
            false => colors.zip(&self.cover).flat_map(|([r, g, b], &a)| [r, g, b, byte(a)]).collect(),
        }
    }

    /// The file's bytes: JPEG of the quality given, which has no opacity, or PNG without one.
    pub fn encode(&self, jpeg_quality: Option<u8>) -> Vec<u8> {
        let (mut file, bytes) = (Vec::new(), self.bytes());
        let (w, h) = (self.width as u32, self.height as u32);
        let color = if self.cover.is_empty() { ExtendedColorType::Rgb8 } else { ExtendedColorType::Rgba8 };
        let written = match jpeg_quality {
            Some(quality) => JpegEncoder::new_with_quality(&mut file, quality).write_image(&bytes, w, h, color),
            None => png::PngEncoder::new_with_quality(&mut file, png::CompressionType::Best, png::FilterType::Adaptive)
                .write_image(&bytes, w, h, color),
        };
        written.expect("encoding into memory with matching sizes cannot fail");
        file
    }
}

/// Distance of `p` from the segment `a` to `b`.
pub fn segment_distance(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_squared().max(1e-9)).clamp(0.0, 1.0);
    (p - a - ab * t).length()
}

/// 1 inside a line of `width` around multiples of 1 in `x`, with soft edges of `soft`.
pub fn lines(x: f32, width: f32, soft: f32) -> f32 {
    let d = (x - x.round()).abs();
    smoothstep(width * 0.5 + soft, width * 0.5 - soft, d)
}

fn text_advance(c: char) -> f32 {
    match c {
        'I' | '1' | '.' | ':' | '!' => 4.0,
        ' ' => 4.0,
        _ => 5.6,
    }
}

/// Strokes on a grid of 4 by 6, as "xy xy xy|xy xy", y upwards.
fn glyph(c: char) -> &'static str {
    match c {
        'A' => "00 04 16 36 44 40|02 42",
        'B' => "00 06 36 45 44 33 03|33 42 41 30 00",
        'C' => "45 36 16 05 01 10 30 41",
        'D' => "00 06 36 45 41 30 00",
        'E' => "46 06 00 40|03 33",
        'F' => "46 06 00|03 33",
        'G' => "45 36 16 05 01 10 30 41 43 23",
        'H' => "00 06|40 46|03 43",
        'I' => "10 16",
        'J' => "46 41 30 10 01",
        'K' => "00 06|46 03 40",
        'L' => "06 00 40",
        'M' => "00 06 23 46 40",
        'N' => "00 06 40 46",
        'O' => "01 05 16 36 45 41 30 10 01",
        'P' => "00 06 36 45 44 33 03",
        'Q' => "01 05 16 36 45 41 30 10 01|22 40",
        'R' => "00 06 36 45 44 33 03|23 40",
        'S' => "45 36 16 05 04 13 33 42 41 30 10 01",
        'T' => "06 46|26 20",
        'U' => "06 01 10 30 41 46",
        'V' => "06 20 46",
        'W' => "06 10 23 30 46",
        'X' => "00 46|06 40",
        'Y' => "06 23 46|23 20",
        'Z' => "06 46 00 40",
        '0' => "01 05 16 36 45 41 30 10 01|12 34",
        '1' => "05 16 10",
        '2' => "05 16 36 45 44 00 40",
        '3' => "05 16 36 45 44 33 42 41 30 10 01|13 33",
        '4' => "30 36 02 42",
        '5' => "46 06 03 33 42 41 30 10 01",
        '6' => "45 36 16 05 01 10 30 41 42 33 03",
        '7' => "06 46 20",
        '8' => "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33",
        '9' => "01 10 30 41 45 36 16 05 04 13 43",
        '&' => "40 05 16 26 35 02 01 10 20 42",
        '%' => "00 46|05 06 16 15 05|30 31 41 40 30",
        '/' => "00 46",
        '-' => "13 33",
        '+' => "13 33|22 24",
        '.' => "10 10",
        ':' => "11 11|14 14",
        '!' => "10 10|12 16",
        '*' => "23 26|23 52|23 02|21 25|05 41|01 45",
        _ => "",
    }
}
