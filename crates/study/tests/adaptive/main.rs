//! `adaptive`: its tiles against a search over all pixels, its rays against an exhaustive
//! walk, its composite against closed forms, its pictures against accumulation; what lies behind
//! others in `hidden`, what is sampled in `samples`, how it converges and moves in `steadiness`.

#[path = "../../../../tests/common/mod.rs"]
mod common;
mod hidden;
mod kinds;
mod samples;
mod steadiness;

use common::{front_camera, gpu, quad, scene, textured, unlit};
use defocus::aperture::Aperture;
use defocus::gpu::{download, download_rgba};
use defocus::image::{ColorImage, DepthImage, Image};
use defocus::lens::Lens;
use defocus::methods::adaptive::tiles::{BINS, TILE_PX, Tile, TileGrid};
use defocus::methods::adaptive::{Adaptive, TURNED_FRAMES, lens_points};
use defocus::methods::{self, Accumulation, Method};
use defocus::scene::{Material, Mesh};
use defocus::view::{GpuScene, LayerSeparation, SurfaceOptions, View};
use defocus_study::metrics::{self, CompareOptions};
use defocus_study::stress::Combination;
use glam::{DVec2, UVec2, Vec3, Vec4, dvec2, uvec2, vec2, vec3};

const SIZE: UVec2 = uvec2(96, 64);
const OVERSCAN_PX: u32 = 12;
const FOCUS_M: f64 = 2.0;

/// K of the lens in most tests: surfaces at 1 m have c = -12 px.
fn lens() -> Lens {
    common::lens(12.0, FOCUS_M)
}

fn view_of(meshes: Vec<Mesh>, materials: Vec<Material>) -> View {
    let surfaces = GpuScene::new(gpu(), &scene(meshes, materials), SurfaceOptions::default());
    View::of_scene(surfaces, front_camera(), SIZE, OVERSCAN_PX).unwrap()
}

/// A red bar in front of the focus, a green one behind it, before a blue wall.
fn bars() -> View {
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 2);
    let green = quad(3.0, vec2(0.1, -9.0), vec2(0.7, 9.0), 1);
    let red = quad(1.0, vec2(-0.1, -0.2), vec2(0.15, 9.0), 0);
    view_of(vec![wall, green, red], vec![unlit(Vec3::X), unlit(Vec3::Y), unlit(Vec3::Z)])
}

/// With layers of one texel a pixel.
fn coarse() -> Adaptive {
    Adaptive { fineness: 1, ..Adaptive::default() }
}

fn render(method: &dyn Method, view: &mut View, lens: &Lens) -> ColorImage {
    let mut frame = gpu().frame();
    let texture = methods::record(method, &mut frame, view, lens).unwrap();
    frame.finish();
    download(gpu(), &texture)
}

/// What the tile passes left on the GPU, read back.
struct FoundTiles {
    grid: TileGrid,
    /// s by layer, px, of the outer frame.
    radii: Vec<Image<f32>>,
    marked: Vec<Tile>,
    dilated: Vec<Tile>,
    lists: Vec<u32>,
    dispatches: Vec<u32>,
    fineness: u32,
}

/// s of a texel without a surface is far beyond this.
const NO_SURFACE: f32 = 1e4;

fn find_tiles(method: &Adaptive, view: &mut View, lens: &Lens) -> FoundTiles {
    let mut frame = gpu().frame();
    let (grid, tiles) = method.tiles(&mut frame, view, lens).unwrap();
    let marked = frame.read_buffer(&tiles.marked);
    let dilated = frame.read_buffer(&tiles.dilated);
    let (lists, dispatches) = (frame.read_buffer(&tiles.lists.lists), frame.read_buffer(&tiles.lists.dispatches));
    frame.finish();
    FoundTiles {
        grid,
        radii: download_layers(&tiles.radii),
        marked,
        dilated,
        lists,
        dispatches,
        fineness: method.fineness,
    }
}

/// The four components of an RGBA16F texture.
fn download_layers(texture: &defocus::gpu::Texture) -> Vec<Image<f32>> {
    let texels = download_rgba(gpu(), texture);
    (0..4).map(|k| texels.map(|p| p[k])).collect()
}

fn bin_edge(grid: &TileGrid, i: u32) -> f64 {
    let t = grid.bins().x + f64::from(i) * grid.bins().y;
    t.signum() * t * t
}

/// Bins that `s` may fall in: two where f16 rounds it over an edge.
fn bins_of(grid: &TileGrid, s: f32) -> impl Iterator<Item = u32> {
    let (s, slack) = (f64::from(s), 1e-3 + f64::from(s.abs()) / 1024.0);
    let (grid, last) = (*grid, BINS - 1);
    (0..BINS).filter(move |&i| {
        let near = if i == 0 { f64::NEG_INFINITY } else { bin_edge(&grid, i) - slack };
        let far = if i == last { f64::INFINITY } else { bin_edge(&grid, i + 1) + slack };
        (near..=far).contains(&s)
    })
}

fn has(tile: &Tile, bin: u32) -> bool {
    tile.bins[(bin / 32) as usize] >> (bin % 32) & 1 != 0
}

/// Outer tile of an outer pixel.
fn outer_tile(grid: &TileGrid, at: UVec2) -> UVec2 {
    (at + grid.first_tile * TILE_PX - OVERSCAN_PX) / TILE_PX
}

#[test]
fn masks_hold_the_bins_of_all_layers_and_no_others() {
    let found = find_tiles(&coarse(), &mut bars(), &lens());
    let outer = found.radii[0].size;
    let mut explained = vec![[0u32; 2]; found.marked.len()];
    for (k, radii) in found.radii.iter().enumerate() {
        for (x, y) in (0..outer.y).flat_map(|y| (0..outer.x).map(move |x| (x, y))) {
            let s = radii.at(x, y);
            if s > NO_SURFACE {
                continue;
            }
            let tile = outer_tile(&found.grid, uvec2(x, y));
            let index = (tile.y * found.grid.tiles.x + tile.x) as usize;
            let bins: Vec<u32> = bins_of(&found.grid, s).collect();
            assert!(bins.iter().any(|b| has(&found.marked[index], *b)), "layer {k} at {x}, {y}: s = {s}");
            bins.iter().for_each(|b| explained[index][(b / 32) as usize] |= 1 << (b % 32));
        }
    }
    for (index, (tile, explained)) in found.marked.iter().zip(&explained).enumerate() {
        let extra = [tile.bins[0] & !explained[0], tile.bins[1] & !explained[1]];
        assert_eq!(extra, [0, 0], "tile {index} has bins that no pixel has");
    }
    assert!(found.radii[2].pixels.iter().any(|s| *s < NO_SURFACE), "nowhere are three layers");
}

/// Where a lens ray can go: from pixel p to q with |p - q| <= |s(q)|.
#[test]
fn dilated_masks_hold_whatever_blurs_into_a_tile_and_little_else() {
    let method = Adaptive { cull: false, ..coarse() };
    let found = find_tiles(&method, &mut bars(), &lens());
    let outer = found.radii[0].size;
    for (index, tile) in found.dilated.iter().enumerate() {
        let at = uvec2(index as u32 % found.grid.inner_tiles.x, index as u32 / found.grid.inner_tiles.x) * TILE_PX;
        let (low, high) = (at.as_dvec2() + 0.5, (at + TILE_PX - 1).min(SIZE - 1).as_dvec2() + 0.5);
        let mut explained = [false; BINS as usize];
        for radii in &found.radii {
            for (i, s) in radii.pixels.iter().enumerate().filter(|(_, s)| **s < NO_SURFACE) {
                let q = dvec2((i as u32 % outer.x) as f64, (i as u32 / outer.x) as f64) + 0.5 - f64::from(OVERSCAN_PX);
                let apart = (q - q.clamp(low, high)).length();
                let square = (q - q.clamp(low, high)).abs().max_element();
                let bins: Vec<u32> = bins_of(&found.grid, *s).collect();
                let reaches = apart <= f64::from(s.abs());
                assert!(!reaches || bins.iter().any(|b| has(tile, *b)), "tile {index} misses s = {s} at {q}");
                for b in bins {
                    let reach = bin_edge(&found.grid, b).abs().max(bin_edge(&found.grid, b + 1).abs());
                    // As in the shader: a quarter of s, half a texel, and whole tiles.
                    explained[b as usize] |= square <= reach + 0.75 + f64::from(TILE_PX);
                }
            }
        }
        let extra: Vec<u32> = (0..BINS).filter(|b| has(tile, *b) && !explained[*b as usize]).collect();
        assert!(extra.is_empty(), "tile {index} has bins {extra:?} that nothing within reach has");
    }
}

/// The first surface on a ray, walked in steps far finer than any tolerance: (layer, s,
/// texel).
fn exhaustive_hit(found: &FoundTiles, p: DVec2, v: DVec2) -> Option<(usize, f64, UVec2)> {
    let [near, far] = found.grid.radii_px;
    let outer = found.radii[0].size;
    let k = f64::from(found.fineness);
    let step = 0.02;
    let steps = ((far - near) / step).ceil() as u32 + 1;
    for i in 0..steps {
        let s = near + f64::from(i) * step;
        let q = (k * (p - v * s) - 0.5 * (k - 1.0)).floor().clamp(DVec2::ZERO, outer.as_dvec2() - 1.0).as_uvec2();
        for (k, radii) in found.radii.iter().enumerate() {
            if (f64::from(radii.at(q.x, q.y)) - s).abs() <= 0.25 {
                return Some((k, f64::from(radii.at(q.x, q.y)), q));
            }
        }
    }
    None
}

#[test]
fn the_umbra_cull_drops_no_bin_that_a_ray_hits() {
    check_cull(&mut bars());
    // The middle ends behind the front, so that between them there is a gap that no pixel
    // sees.
    check_cull(&mut textured_view(SIZE, OVERSCAN_PX));
}

fn check_cull(view: &mut View) {
    let all = find_tiles(&Adaptive { cull: false, ..coarse() }, view, &lens());
    let culled = find_tiles(&coarse(), view, &lens());
    let bins = |tiles: &[Tile]| tiles.iter().map(|t| t.bins[0].count_ones() + t.bins[1].count_ones()).sum::<u32>();
    assert!(bins(&culled.dilated) < bins(&all.dilated), "nothing was culled, so nothing is tested");
    let points = Aperture::Disc.lens_points(16);
    for (x, y) in (0..SIZE.y).step_by(3).flat_map(|y| (0..SIZE.x).step_by(3).map(move |x| (x, y))) {
        let tile = culled.dilated[(y / TILE_PX * culled.grid.inner_tiles.x + x / TILE_PX) as usize];
        let p = uvec2(x, y).as_dvec2() + 0.5 + f64::from(OVERSCAN_PX);
        for v in &points {
            let (k, s, _) = exhaustive_hit(&culled, p, *v).expect("the wall ends every ray");
            let kept = bins_of(&culled.grid, s as f32).any(|b| has(&tile, b));
            assert!(kept, "pixel {x}, {y} and lens point {v} hit layer {k} at s = {s}, which is culled");
        }
    }
}

#[test]
fn every_tile_is_in_the_list_of_its_class_once() {
    let found = find_tiles(&coarse(), &mut bars(), &lens());
    let total = found.dilated.len();
    let mut seen = vec![0; total];
    for class in 0..3 {
        let length = found.dispatches[4 * class + 3] as usize;
        let groups = found.dispatches[4 * class] as usize * found.dispatches[4 * class + 1] as usize;
        assert!(groups >= length, "class {class}: {groups} workgroups for {length} tiles");
        for listed in &found.lists[class * total..][..length] {
            let index = (listed >> 16) * found.grid.inner_tiles.x + (listed & 0xffff);
            assert_eq!(found.dilated[index as usize].class as usize, class);
            seen[index as usize] += 1;
        }
    }
    assert!(seen.iter().all(|n| *n == 1), "{seen:?}");
    assert!(found.dispatches[11] > 0, "no complex tile");
}

/// Without the filter a pixel is the mean of its rays; surfaces of one colour each say
/// which of them every ray hit.
#[test]
fn rays_hit_what_an_exhaustive_walk_hits() {
    for fineness in [1, 2] {
        check_hits(&Adaptive { filter: false, fineness, draws: 1, refine: 1, ..Adaptive::default() });
    }
}

fn check_hits(method: &Adaptive) {
    let mut view = bars();
    let image = render(method, &mut view, &lens());
    let found = find_tiles(method, &mut view, &lens());
    let points = lens_points(&Aperture::Disc, 16, 16, true, 0);
    let color_of_s = |s: f64| {
        let depth = lens().coc().depth_at(2.0 * s);
        if depth < 2.0 {
            Vec3::X
        } else if depth < 5.0 {
            Vec3::Y
        } else {
            Vec3::Z
        }
    };
    let (mut differing, mut worst, mut mixed) = (0.0, 0.0f32, 0);
    for (x, y) in (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y))) {
        let p = uvec2(x, y).as_dvec2() + 0.5 + f64::from(OVERSCAN_PX);
        let phase = (y % 8 * 8 + x % 8) as usize;
        let hits = points.iter().skip(phase).step_by(64).map(|v| {
            let v = dvec2(f64::from(v[0]), f64::from(v[1]));
            color_of_s(exhaustive_hit(&found, p, v).expect("the wall ends every ray").1)
        });
        let expected = hits.sum::<Vec3>() / 16.0;
        let difference = (image.at(x, y) - expected).abs().max_element();
        mixed += usize::from(expected.max_element() < 0.99);
        differing += difference;
        worst = worst.max(difference);
    }
    println!("mean {} worst {worst}, {mixed} pixels mixed", differing / (SIZE.x * SIZE.y) as f32);
    assert!(mixed > 500, "only {mixed} pixels see more than one surface");
    // Steps of up to 2 px find an edge half a texel off: one ray of 16 in pixels at edges,
    // in a few two or three.
    assert!(differing / (SIZE.x * SIZE.y) as f32 <= 0.005, "{}", differing / (SIZE.x * SIZE.y) as f32);
    assert!(worst <= 4.0 / 16.0, "{worst}");
}

/// Share of a disc of radius 1 on the left of x = t.
fn disc_left_of(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 + (t.asin() + t * (1.0 - t * t).sqrt()) / std::f64::consts::PI
}

/// The width of a pixel at 1 m, metres.
fn pixel_m() -> f32 {
    30f32.to_radians().tan() / (0.5 * SIZE.y as f32)
}

/// Layers that lie `z` of stored depth apart wherever they are.
fn alike_at_all_depths(z: f32) -> LayerSeparation {
    LayerSeparation { z, widening_from_z: 1.0 }
}

/// A half plane in front of a wall: the composite is the disc's share of both.
#[test]
fn a_straight_edge_composites_to_the_share_of_the_disc() {
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 1);
    for (depth_m, points, filter) in [(0.8f32, 1, true), (1.0, 2, true), (1.4, 0, true), (1.0, 3, false)] {
        // A quarter of a pixel right of the centre: halfway between fine texels.
        let edge_px = 0.25;
        let front = quad(depth_m, vec2(-9.0, -9.0), vec2(edge_px * depth_m * pixel_m(), 9.0), 0);
        let mut view = view_of(vec![wall.clone(), front], vec![unlit(Vec3::X), unlit(Vec3::Z)]);
        let image = render(&Adaptive { points, filter, ..Adaptive::default() }, &mut view, &lens());
        let s = 0.5 * lens().coc_diameter_px(f64::from(depth_m)).abs();
        for x in 0..SIZE.x {
            // Rows average the noise of the lens points: 64 rows of at least 8 rays.
            let mean = (0..SIZE.y).map(|y| image.at(x, y)).sum::<Vec3>() / SIZE.y as f32;
            let from_edge = f64::from(x) + 0.5 - f64::from(SIZE.x) / 2.0 - f64::from(edge_px);
            let expected = disc_left_of(-from_edge / s) as f32;
            // The edge lies between texels, so half a texel of the steepest part of the
            // disc's share is what one sample a pixel leaves open.
            let limit = 0.02 + 0.25 * std::f32::consts::FRAC_2_PI / s as f32;
            let error = (mean - vec3(expected, 0.0, 1.0 - expected)).abs().max_element();
            assert!(
                error <= limit,
                "{depth_m} m, points {points}: column {x} is {mean}, not {expected}, limit {limit}"
            );
        }
    }
}

/// Standard deviation, px, on an axis of the light in an image: the mean of both axes.
fn sigma_px(image: &ColorImage) -> f64 {
    let moment = |f: &dyn Fn(DVec2) -> DVec2| -> DVec2 {
        let at = |i: usize| dvec2((i % image.size.x as usize) as f64, (i / image.size.x as usize) as f64);
        image.pixels.iter().enumerate().map(|(i, p)| f(at(i)) * f64::from(p.y)).sum()
    };
    let light = moment(&|_| DVec2::ONE);
    let mean = moment(&|at| at) / light;
    (moment(&|at| (at - mean) * (at - mean)) / light).element_sum().sqrt() * std::f64::consts::FRAC_1_SQRT_2
}

/// Variance, px^2, of what samples `sample_px` apart say lies between two positions, px from
/// a pixel's border.
fn sampled_variance(from_px: f64, to_px: f64, sample_px: f64) -> f64 {
    let samples: Vec<f64> =
        (-100..100).map(|i| f64::from(i) * sample_px).filter(|x| (from_px..to_px).contains(x)).collect();
    let mean = |f: &dyn Fn(f64) -> f64| samples.iter().map(|x| f(*x)).sum::<f64>() / samples.len() as f64;
    mean(&|x| x * x) - mean(&|x| x).powi(2) + sample_px.powi(2) / 12.0
}

/// A bright square before the focus and one behind it, at half, full and double resolution,
/// with every number of lens points.
#[test]
fn an_outline_is_as_wide_as_the_lens_blurs_it_at_every_resolution_and_number_of_points() {
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 1);
    let mut worst = 0.0f64;
    for depth_m in [1.0f32, 5.0] {
        // Six pixels wide at full resolution.
        let px_m = depth_m * pixel_m();
        let card = quad(depth_m, vec2(-2.8, -2.8) * px_m, vec2(3.2, 3.2) * px_m, 0);
        let materials = vec![unlit(Vec3::ONE), unlit(Vec3::ZERO)];
        let surfaces = GpuScene::new(gpu(), &scene(vec![wall.clone(), card], materials), SurfaceOptions::default());
        for scale in [0.5, 1.0, 2.0] {
            let size = (SIZE.as_dvec2() * scale).as_uvec2();
            let lens = common::lens(16.0 * scale, FOCUS_M);
            let mut view = View::of_scene(surfaces.clone(), front_camera(), size, (16.0 * scale) as u32).unwrap();
            let blurred_px = 0.25 * lens.coc_diameter_px(f64::from(depth_m)).abs();
            let expected = (blurred_px.powi(2) + sampled_variance(-2.8 * scale, 3.2 * scale, 0.5)).sqrt();
            for points in 0..4 {
                // Eight turns of the lens points: 72 rays of one would leave 8 % to chance.
                let method = Adaptive { points, frames: TURNED_FRAMES, ..Adaptive::default() };
                let sigma = sigma_px(&render(&method, &mut view, &lens));
                let ratio = sigma / expected;
                println!(
                    "{depth_m} m, {size} px, {} points: sigma {sigma:.3} of {expected:.3} px, {ratio:.4}",
                    8 << points
                );
                worst = worst.max((ratio - 1.0).abs());
            }
        }
    }
    assert!(worst <= 0.02, "{worst}");
}

/// Textured surfaces at three depths.
fn textured_view(size: UVec2, overscan_px: u32) -> View {
    let wall = quad(6.0, vec2(-6.0, -5.0), vec2(6.0, 5.0), 0);
    let middle = quad(2.0, vec2(-1.0, -0.6), vec2(0.2, 0.7), 0);
    let front = quad(1.1, vec2(0.1, -0.5), vec2(0.5, 0.8), 0);
    let surfaces = GpuScene::new(gpu(), &scene(vec![wall, middle, front], vec![textured()]), SurfaceOptions::default());
    View::of_scene(surfaces, front_camera(), size, overscan_px).unwrap()
}

fn psnr_db(a: &ColorImage, b: &ColorImage) -> f64 {
    metrics::compare(a, b, &CompareOptions::default()).unwrap().psnr_db.unwrap_or(f64::INFINITY)
}

#[test]
fn it_is_close_to_accumulation_and_far_closer_than_mipmap() {
    let reference = Accumulation { samples: 128, ..Accumulation::default() };
    let mipmap = methods::by_id("mipmap").unwrap();
    for aperture in [Aperture::Disc, Aperture::polygon(3)] {
        let lens = Lens { aperture, ..lens() };
        let mut view = textured_view(uvec2(128, 96), 16);
        let truth = render(&reference, &mut view, &lens);
        let db = [0, 1, 2]
            .map(|points| psnr_db(&render(&Adaptive { points, ..Adaptive::default() }, &mut view, &lens), &truth));
        let mipmap_db = psnr_db(&render(&*mipmap, &mut view, &lens), &truth);
        println!("{:?}: {db:.2?} dB with 8, 16, 32 points, mipmap {mipmap_db:.2} dB", lens.aperture);
        // Half a dB under what they are; with means read beside where they lie, 48.5, 50.7, 49.0.
        assert!(db[0] >= 49.5 && db[1] >= 51.2 && db[2] >= 51.6, "{:?}: {db:?} dB", lens.aperture);
        assert!(db[1] >= mipmap_db + 6.0, "{:?}: {db:?} dB, mipmap {mipmap_db} dB", lens.aperture);
    }
}

/// By how much `image` lies below `truth`, px: the least squares of what a shift changes,
/// which the gradient says.
fn shift_down_px(image: &ColorImage, truth: &ColorImage) -> f64 {
    let green = |image: &ColorImage, x: u32, y: u32| f64::from(image.at(x, y).y);
    let (mut changed, mut gradients) = (0.0, 0.0);
    for (x, y) in (1..truth.size.y - 1).flat_map(|y| (0..truth.size.x).map(move |x| (x, y))) {
        let gradient = 0.5 * (green(truth, x, y + 1) - green(truth, x, y - 1));
        changed -= (green(image, x, y) - green(truth, x, y)) * gradient;
        gradients += gradient * gradient;
    }
    changed / gradients
}

/// Means of samples are read where they lie: of one wall, whose tiles have one blur, and
/// where two meet, whose tiles are traced.
#[test]
fn what_is_blurred_stays_where_it_is() {
    let wall = |depth_m: f32, from_x: f32, to_x: f32| quad(depth_m, vec2(from_x, -5.0), vec2(to_x, 5.0), 0);
    for walls in [vec![wall(4.0, -7.0, 7.0)], vec![wall(4.0, -7.0, 0.0), wall(5.0, -1.0, 8.0)]] {
        let mut view = view_of(walls, vec![textured()]);
        let truth = render(&Accumulation { samples: 64, ..Accumulation::default() }, &mut view, &lens());
        for draws in [1, 2, 3] {
            let shift = shift_down_px(&render(&Adaptive { draws, ..Adaptive::default() }, &mut view, &lens()), &truth);
            println!("{draws} draws: {shift:.4} px");
            // What is left (up to 0.066) has another cause; read at the texel's centre, means stand
            // 0.085 and more too far up.
            assert!(shift.abs() <= 0.07, "{draws} draws: {shift} px");
        }
    }
}

/// A light of 4x4 texels, up to 200 times white, blurred before a dark wall.
#[test]
fn highlights_keep_their_light_and_shape() {
    let wall = quad(8.0, vec2(-20.0, -20.0), vec2(20.0, 20.0), 1);
    // Edges halfway between fine texels, and 4 pixel centres on each side within them, so
    // that all images have exactly its light.
    let (low, high) = (vec2(-1.75, -2.25) * pixel_m(), vec2(2.25, 1.75) * pixel_m());
    let light = quad(1.0, low, high, 0);
    let bright = Material { base_color: Vec4::new(200.0, 100.0, 50.0, 1.0), ..unlit(Vec3::ONE) };
    for aperture in [Aperture::Disc, Aperture::polygon(5)] {
        let lens = Lens { aperture, ..lens() };
        let mut view = view_of(vec![wall.clone(), light.clone()], vec![bright.clone(), unlit(Vec3::splat(0.01))]);
        let truth = render(&Accumulation { samples: 256, ..Accumulation::default() }, &mut view, &lens);
        let image = render(&Adaptive::default(), &mut view, &lens);
        let sum = |image: &ColorImage| image.pixels.iter().map(|p| f64::from(p.x)).sum::<f64>();
        let (kept, db) = (sum(&image) / sum(&truth), psnr_db(&image, &truth));
        println!("{:?}: light {kept:.4}, {db:.2} dB", lens.aperture);
        // The table of the aperture and the cells' squares are integrated in mipmaps.
        assert!((kept - 1.0).abs() < 0.03, "{:?}: {kept} of the light is left", lens.aperture);
        assert!(db >= 32.0, "{:?}: {db} dB", lens.aperture);
    }
}

/// Hundreds of lights at all depths: a ray to each, and few rounds of loops a ray, of which
/// llvmpipe allows an invocation 65,535. Lights are listed in another order each time.
#[test]
fn many_lights_are_all_there_each_time() {
    let noise = Combination::named("moderate blur", "noise over all depths", "65504 everywhere", uvec2(24, 16)).case();
    let mut view = View::of_image(gpu(), &noise.color, &noise.depth_m, 1.0).unwrap();
    let first = render(&Adaptive::default(), &mut view, &noise.lens);
    for _ in 0..8 {
        let again = render(&Adaptive::default(), &mut view, &noise.lens);
        for (a, b) in first.pixels.iter().zip(&again.pixels) {
            // Two roundings of f16: sums are of another order.
            assert!((*a - *b).abs().max_element() <= 2e-3 * a.max_element(), "{a} and then {b}");
        }
    }
}

#[test]
fn an_image_with_depth_needs_no_scene() {
    let color = Image::from_fn(SIZE, |x, y| vec3((x % 9) as f32 / 9.0, (y % 7) as f32 / 7.0, 0.5));
    let depth: DepthImage = Image::from_fn(SIZE, |x, _| if x < 40 { 1.0 } else { 8.0 });
    let mut view = View::of_image(gpu(), &color, &depth, 0.8).unwrap();
    let image = render(&Adaptive::default(), &mut view, &lens());
    assert!(image.pixels.iter().all(|p| p.is_finite()));
    // Blur only averages: the extremes are the image's own, and much of the contrast goes.
    assert!(image.pixels.iter().all(|p| p.max_element() < 1.0 && p.min_element() > -1e-3));
    let spread = |image: &ColorImage| image.pixels.iter().map(|p| (p.x - 0.44).powi(2)).sum::<f32>();
    assert!(spread(&image) < 0.5 * spread(&color));
}

#[test]
fn nothing_is_traced_where_all_tiles_are_in_focus() {
    let mut view = view_of(vec![quad(2.015, vec2(-9.0, -9.0), vec2(9.0, 9.0), 0)], vec![textured()]);
    let mut frame = gpu().frame();
    let texture = methods::record(&Adaptive::default(), &mut frame, &mut view, &lens()).unwrap();
    let stats = frame.finish().stats;
    // |s| = 6 * 0.015 / 2.015 px = 0.045 px: less than what counts as in focus.
    assert_eq!(stats.skipped.get("all tiles in focus"), Some(&1), "{stats:?}");
    // The pinhole image, its bounds, and the copy of its inner frame.
    assert_eq!((stats.views, stats.passes), (1, 3), "{stats:?}");
    let pinhole = render(&methods::Pinhole, &mut view, &lens());
    assert_eq!(download(gpu(), &texture), pinhole);
}

#[test]
fn off_centre_views_see_what_layers_guess() {
    let lens = lens();
    let mut view = textured_view(uvec2(128, 96), 16);
    let truth = render(&Accumulation { samples: 256, ..Accumulation::default() }, &mut view, &lens);
    // One layer cannot know what the foreground hides; true views do.
    let one = Adaptive { layers: 1, fineness: 1, draws: 1, ..Adaptive::default() };
    let without = psnr_db(&render(&one, &mut view, &lens), &truth);
    let with = psnr_db(&render(&Adaptive { views: 1, ..one }, &mut view, &lens), &truth);
    println!("one layer {without:.2} dB, with four views {with:.2} dB");
    assert!(with >= without + 3.0, "{with} dB with views, {without} dB without");
}
