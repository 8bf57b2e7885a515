//! A pixel as the blur spot that the lens makes of it: what the scattering methods share.
//!
//! Lee, Kim and Choi, "Real-Time Depth-of-Field Rendering Using Point Splatting on
//! Per-Pixel Layers" (Pacific Graphics 2008), section 3.3: a source pixel of CoC diameter
//! C becomes a sprite with alpha `kn(C) / C^2` inside the aperture's intensity
//! distribution (IDF). There `kn(C)` is tabulated, because a sprite that is sampled at
//! pixel centres sums to 1 only after a correction that jumps with C. Here each fragment
//! *integrates* the IDF over its pixel, from the IDF's running sums (Crow, "Summed-Area
//! Tables for Texture Mapping", SIGGRAPH 1984). Neighbouring pixels share their corners,
//! so the sum telescopes to 1 for every continuous C and every shape: what is tabulated
//! is the shape, and kn(C) is `C^2` times the share. This is also exactly how often the
//! accumulation buffer's views show the source pixel at the destination.

use crate::aperture::Aperture;
use crate::gpu::{Buffer, Gpu, Texture};
use crate::lens::Lens;
use crate::uniform;
use crate::view::View;
use glam::{DVec2, UVec2, dvec2};
use std::sync::{Arc, Mutex};

/// Cells per side of the table: half a pixel each in a spot of 64 px.
const CELLS: usize = 128;

/// The IDF is sampled this often per side of a cell, at the middles of its parts.
const SAMPLES_PER_CELL: usize = 4;

/// Tables kept, a quarter of a MiB each: making one takes longer than a frame, and a
/// comparison alternates between few apertures.
const KEPT_TABLES: usize = 16;

/// Running sums of an aperture's IDF.
#[derive(Debug)]
pub struct SpriteTable {
    /// The sums reach from -radius to radius in v.
    radius: f64,
    /// |v| up to which the IDF is constant.
    solid: f64,
    /// What it is there, its integral being 1.
    solid_intensity: f64,
    /// Per cell: integrals of the IDF over the rectangles from 0 to its four corners.
    corners: Vec<[f32; 4]>,
}

/// A [`SpriteTable`] on the GPU.
struct IdfSums(Texture);

/// The same as a buffer.
struct IdfTable(Buffer);

uniform! {
    /// `Sprites` in `shaders/lib/sprites.wgsl`.
    pub(super) struct SpritesUniform {
        size: [u32; 2],
        radius: f32,
        cells: u32,
        pub(super) overscan: u32,
        solid: f32,
        solid_intensity: f32,
        _pad: u32,
    }
}

/// An aperture, and by how much it is turned, radians.
type Turned = (Aperture, f64);

static TABLES: Mutex<Vec<(Turned, Arc<SpriteTable>)>> = Mutex::new(Vec::new());

/// The aperture of a lens and the angle of the eye's meridian, which `shaders/lib/spots.wgsl` takes the
/// table's axes for.
fn turned(lens: &Lens) -> Turned {
    let (meridian, _) = lens.meridian();
    (lens.aperture.clone(), if lens.aperture.is_round() { 0.0 } else { meridian.to_angle() })
}

impl SpriteTable {
    /// The table for an aperture, made when it is new.
    pub fn of(aperture: &Aperture) -> Arc<Self> {
        Self::of_turned((aperture.clone(), 0.0))
    }

    /// The table for a lens's aperture along its meridians ([`Lens::meridian`]).
    pub fn of_lens(lens: &Lens) -> Arc<Self> {
        Self::of_turned(turned(lens))
    }

    fn of_turned(wanted: Turned) -> Arc<Self> {
        let mut tables = TABLES.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(known) = tables.iter().position(|(turned, _)| *turned == wanted) {
            let entry = tables.remove(known);
            tables.push(entry);
        } else {
            if tables.len() == KEPT_TABLES {
                tables.remove(0);
            }
            let table = Arc::new(Self::new(&wanted.0, wanted.1));
            tables.push((wanted, table));
        }
        tables[tables.len() - 1].1.clone()
    }

    fn new(aperture: &Aperture, angle_rad: f64) -> Self {
        let radius = aperture.radius();
        let masses = cell_masses(aperture, angle_rad, radius);
        // From the centre outwards: small numbers where most of the light is, and
        // symmetric ones where the aperture is.
        let side = CELLS + 1;
        let mut sums = vec![0.0; side * side];
        for y in 0..CELLS {
            let mut row = 0.0;
            for x in 0..CELLS {
                row += masses[y * CELLS + x];
                sums[(y + 1) * side + x + 1] = sums[y * side + x + 1] + row;
            }
        }
        let total = sums[side * side - 1];
        let from_centre = |x: usize, y: usize| {
            let middle = CELLS / 2;
            let at = |x: usize, y: usize| sums[y * side + x];
            ((at(x, y) - at(middle, y) - at(x, middle) + at(middle, middle)) / total) as f32
        };
        let corners_of = |i: usize| {
            let (x, y) = (i % CELLS, i / CELLS);
            [from_centre(x, y), from_centre(x + 1, y), from_centre(x, y + 1), from_centre(x + 1, y + 1)]
        };
        let (solid, solid_intensity) = solid_part(&masses, radius, total);
        Self { radius, solid, solid_intensity, corners: (0..CELLS * CELLS).map(corners_of).collect() }
    }

    /// The share of a sprite's light on the pixel `offset_px` from it, at the signed CoC
    /// diameter `c_px`: what the shader computes, in f64.
    pub fn share(&self, offset_px: DVec2, c_px: f64) -> f64 {
        let c = if c_px < 0.0 { c_px.min(-1e-3) } else { c_px.max(1e-3) };
        let (low, high) = ((offset_px - 0.5) * (2.0 / c), (offset_px + 0.5) * (2.0 / c));
        let right = self.sum(high) - self.sum(dvec2(high.x, low.y));
        let left = self.sum(dvec2(low.x, high.y)) - self.sum(low);
        (right - left).max(0.0)
    }

    /// How far from its centre a sprite's pixels lie, px, at the CoC diameter `c_px`.
    pub fn reach_px(&self, c_px: f64) -> f64 {
        0.5 * self.radius * c_px.abs() + 0.5
    }

    fn sum(&self, v: DVec2) -> f64 {
        let at = (0.5 + 0.5 * v / self.radius).clamp(DVec2::ZERO, DVec2::ONE) * CELLS as f64;
        let cell = at.floor().min(DVec2::splat((CELLS - 1) as f64));
        let [a, b, c, d] = self.corners[cell.y as usize * CELLS + cell.x as usize].map(f64::from);
        let inside = at - cell;
        (a * (1.0 - inside.x) + b * inside.x) * (1.0 - inside.y) + (c * (1.0 - inside.x) + d * inside.x) * inside.y
    }

    /// The table of an aperture as `idf_sums`, kept while it is used.
    pub(super) fn texture_of(aperture: &Aperture, gpu: &Gpu) -> Texture {
        Self::texture_of_turned((aperture.clone(), 0.0), gpu)
    }

    /// As [`SpriteTable::of_lens`].
    pub(super) fn texture_of_lens(lens: &Lens, gpu: &Gpu) -> Texture {
        Self::texture_of_turned(turned(lens), gpu)
    }

    /// As [`SpriteTable::texture_of_lens`], row by row.
    pub(super) fn buffer_of_lens(lens: &Lens, gpu: &Gpu) -> Buffer {
        let turned = turned(lens);
        let make = || IdfTable(gpu.buffer_of("IDF sums", &Self::of_turned(turned.clone()).corners));
        gpu.memo().get(&turned.clone(), make).0.clone()
    }

    fn texture_of_turned(turned: Turned, gpu: &Gpu) -> Texture {
        gpu.memo().get(&turned.clone(), || IdfSums(Self::of_turned(turned).upload(gpu))).0.clone()
    }

    /// A texture of its own, not a pooled one: it is written before the frame's passes run,
    /// whatever they did with a pooled one.
    fn upload(&self, gpu: &Gpu) -> Texture {
        let side = CELLS as u32;
        let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
        let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("IDF sums"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 16), rows_per_image: None };
        gpu.queue().write_texture(texture.as_image_copy(), bytemuck::cast_slice(&self.corners), layout, size);
        Texture::external(texture)
    }

    pub(super) fn uniform(&self, view: &View) -> SpritesUniform {
        SpritesUniform { overscan: view.overscan_px(), ..self.uniform_on(view.size()) }
    }

    /// For sprites on a target of its own, with no margin.
    pub(super) fn uniform_on(&self, size: UVec2) -> SpritesUniform {
        SpritesUniform {
            size: size.to_array(),
            radius: self.radius as f32,
            cells: CELLS as u32,
            overscan: 0,
            solid: self.solid as f32,
            solid_intensity: self.solid_intensity as f32,
            _pad: 0,
        }
    }
}

/// The IDF's integral over each cell, up to a common factor. The table's axes are turned by
/// `angle_rad` from x to y.
fn cell_masses(aperture: &Aperture, angle_rad: f64, radius: f64) -> Vec<f64> {
    let turn = DVec2::from_angle(angle_rad);
    let side = CELLS * SAMPLES_PER_CELL;
    let v_at = |i: usize| ((i as f64 + 0.5) / side as f64 * 2.0 - 1.0) * radius;
    let mut masses = vec![0.0; CELLS * CELLS];
    for y in 0..side {
        for x in 0..side {
            let cell = y / SAMPLES_PER_CELL * CELLS + x / SAMPLES_PER_CELL;
            masses[cell] += aperture.intensity(turn.rotate(dvec2(v_at(x), v_at(y))));
        }
    }
    masses
}

/// Up to which |v| the cells of `masses` hold as much as those in the middle, and how much
/// that is of their `total`, for an area of 1 in v.
fn solid_part(masses: &[f64], radius: f64, total: f64) -> (f64, f64) {
    let cell = 2.0 * radius / CELLS as f64;
    let middle = masses[CELLS / 2 * CELLS + CELLS / 2];
    let differs = |i: &usize| (masses[*i] - middle).abs() > 1e-12 * middle;
    // Of a cell's corners the one that is nearest to the middle of the table.
    let nearest = |i: usize| {
        let along =
            |at: usize| (at as f64 - CELLS as f64 / 2.0).abs().min((at as f64 + 1.0 - CELLS as f64 / 2.0).abs());
        along(i % CELLS).hypot(along(i / CELLS)) * cell
    };
    let solid = (0..masses.len()).filter(differs).map(nearest).fold(radius, f64::min);
    (solid, middle / total / (cell * cell))
}

/// The format in which sprites are summed into `targets` textures at once.
///
/// RGBA32F where the adapter can blend it and hold so many; else RGBA16F, which is biased:
/// at C = 64 px a sprite adds 3e-4 to a pixel, less than the 5e-4 between f16 numbers from
/// 1/2 on, and an adapter that truncates gets no farther. Small spots lose little, and
/// dividing by the sum of alpha, which loses likewise, takes most of that back.
pub(super) fn sum_format(gpu: &Gpu, targets: u32) -> wgpu::TextureFormat {
    let bytes = 16 * targets;
    let room = gpu.device().limits().max_color_attachment_bytes_per_sample >= bytes;
    if room && gpu.has(wgpu::Features::FLOAT32_BLENDABLE) {
        wgpu::TextureFormat::Rgba32Float
    } else {
        wgpu::TextureFormat::Rgba16Float
    }
}
