//! The ray-traced reference against closed forms.

mod common;

use common::{front_camera, lens, quad, scene, sphere, textured, unlit, uv_grid_texture};
use defocus::camera::{Camera, Projection};
use defocus::image::{ColorImage, DepthImage};
use defocus::lens::Lens;
use defocus::raytrace::{RayError, RayImage, RayOptions, RayRender, RayScene, Shading};
use defocus::scene::{Environment, Light, LightKind, Material, Scene, TextureImage};
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3, dvec2, dvec3, uvec2, vec2, vec3};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn points(n: u32) -> RayOptions {
    RayOptions { lens_points: 0..n, ..RayOptions::default() }
}

fn start(scene: Scene, camera: &Camera, projection: &Projection, lens: &Lens, options: &RayOptions) -> RayRender {
    let rays = RayScene::new(Arc::new(scene), camera).expect("a scene that can be traced");
    RayRender::new(Arc::new(rays), projection, lens, options).expect("a lens that forms an image")
}

fn trace(scene: Scene, projection: &Projection, lens: &Lens, options: &RayOptions) -> RayImage {
    start(scene, &front_camera(), projection, lens, options).run(|_, _| ControlFlow::Continue(()))
}

fn frame(width: u32, height: u32) -> Projection {
    front_camera().projection(uvec2(width, height), 0)
}

fn greatest_difference(a: &ColorImage, b: &ColorImage) -> f32 {
    a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

/// A quad larger than the frame with the grid texture.
fn wide_quad(depth_m: f32) -> Scene {
    scene(vec![quad(depth_m, Vec2::splat(-4.0 * depth_m), Vec2::splat(4.0 * depth_m), 0)], vec![textured()])
}

/// Metres at `depth_m` that a pixel covers.
fn metres_per_px(projection: &Projection, depth_m: f64) -> f64 {
    depth_m / projection.focal_px
}

#[test]
fn what_is_in_focus_is_the_pinhole_image() {
    let projection = frame(40, 30);
    let image = trace(wide_quad(3.0), &projection, &lens(20.0, 3.0), &points(64));
    // All rays of a pixel meet in one point; f32 corners leave 1e-7 of its position, and
    // the texture changes by no more than 1 over a texel, 1/8 of u: 8 * 1e-7 and rounding.
    assert!(greatest_difference(&image.color, &image.pinhole) < 3e-6);
    let contrast = image.pinhole.pixels.iter().fold(0.0, |most: f32, p| most.max(p.x));
    assert!(contrast > 0.2, "the texture is in view: {contrast}");
    assert!(image.depth.pixels.iter().all(|d| (d - 3.0).abs() < 1e-5));
}

#[test]
fn a_pinhole_lens_gives_the_pinhole_image() {
    let projection = frame(40, 30);
    let image = trace(wide_quad(3.0), &projection, &lens(0.0, 7.0), &points(16));
    assert_eq!(image.color, image.pinhole);
    let blurred = trace(wide_quad(3.0), &projection, &lens(8.0, 7.0), &points(16));
    assert!(greatest_difference(&blurred.color, &blurred.pinhole) > 0.01, "E > 0 blurs");
}

/// A patch of exactly one pixel at depth `d` around the centre of the middle pixel.
fn one_pixel_patch(projection: &Projection, depth_m: f64) -> Scene {
    let side = metres_per_px(projection, depth_m);
    let half = Vec2::splat(0.5 * side as f32);
    scene(vec![quad(depth_m as f32, -half, half, 0)], vec![unlit(Vec3::ONE)])
}

#[test]
fn a_patch_off_focus_becomes_a_disc_of_the_right_size_and_energy() {
    let projection = frame(41, 41);
    for (focus_m, depth_m) in [(2.0, 5.0), (4.0, 1.6), (f64::INFINITY, 1.5)] {
        let strength = if focus_m.is_finite() { 30.0 } else { 30.0 * depth_m };
        let lens = lens(strength, focus_m);
        let c = lens.coc_diameter_px(depth_m).abs();
        assert!(c > 10.0 && c < 60.0, "c = {c}");
        let projection = if c > 36.0 { frame(81, 81) } else { projection };
        let image = trace(one_pixel_patch(&projection, depth_m), &projection, &lens, &points(1024));
        let middle = projection.size.as_dvec2() * 0.5;
        let mut energy = 0.0;
        let mut moment = DVec2::ZERO;
        let mut farthest: f64 = 0.0;
        for y in 0..projection.size.y {
            for x in 0..projection.size.x {
                let offset = dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5) - middle;
                let value = f64::from(image.color.at(x, y).x);
                energy += value;
                moment += offset * offset * value;
                if value > 0.0 {
                    farthest = farthest.max(offset.length());
                }
            }
        }
        // From each lens point the patch covers exactly one pixel centre; a tie at its edge,
        // one point in a million or so, is the only way to miss.
        assert!((energy - 1.0).abs() < 2.5 / 1024.0, "energy {energy}");
        // Standard deviation C/4 of the disc, and of the pixel grid 1/12. The second moment of
        // 1024 low-discrepancy points is good to half a percent.
        let variance = moment / energy;
        let expected = (c / 4.0).powi(2) + 1.0 / 12.0;
        assert!((variance / expected - 1.0).abs().max_element() < 0.01, "variance {variance}, not {expected}");
        // The disc ends at C/2, seen through a pixel's half diagonal; points reach its last 5 %.
        assert!(farthest < c / 2.0 + 0.71 && farthest > 0.95 * c / 2.0 - 0.71, "radius {farthest} of {}", c / 2.0);
    }
}

#[test]
fn each_lens_point_shifts_what_it_sees_as_the_rasteriser_does() {
    let projection = frame(41, 41);
    for (focus_m, depth_m) in [(2.0, 5.0), (4.0, 2.0)] {
        let lens = lens(16.0, focus_m);
        for i in 0..16 {
            let v = lens.aperture.lens_point(i);
            let one = RayOptions { lens_points: i..i + 1, ..RayOptions::default() };
            let image = trace(one_pixel_patch(&projection, depth_m), &projection, &lens, &one);
            let lit: Vec<usize> = (0..41 * 41).filter(|&k| image.color.pixels[k].x > 0.5).collect();
            let clip = projection.clip_from_view(&lens, v) * vec3(0.0, 0.0, -depth_m as f32).extend(1.0);
            let pixel = vec2(1.0 + clip.x / clip.w, 1.0 - clip.y / clip.w) * 20.5;
            let expected = pixel.y as usize * 41 + pixel.x as usize;
            assert_eq!(lit, [expected], "lens point {v}, {pixel}");
        }
    }
}

#[test]
fn an_edge_blurs_to_the_integral_of_the_disc() {
    let projection = frame(64, 3);
    for (focus_m, depth_m) in [(2.0, 5.0), (4.0, 2.0)] {
        let lens = lens(24.0, focus_m);
        let radius = 0.5 * lens.coc_diameter_px(depth_m).abs();
        let far = 40.0 * depth_m as f32;
        let half_plane = quad(depth_m as f32, Vec2::splat(-far), vec2(0.0, far), 0);
        let image = trace(scene(vec![half_plane], vec![unlit(Vec3::ONE)]), &projection, &lens, &points(4096));
        for x in 0..64 {
            let u = (32.0 - (f64::from(x) + 0.5)) / radius;
            let inside = u.clamp(-1.0, 1.0);
            let expected = 0.5 + (inside * (1.0 - inside * inside).sqrt() + inside.asin()) / std::f64::consts::PI;
            let value = f64::from(image.color.at(x, 1).x);
            // Half-plane discrepancy of N low-discrepancy points, about N^(-3/4) = 0.002.
            assert!((value - expected).abs() < 0.006, "x = {x}: {value}, not {expected}");
        }
    }
}

/// A plane `n . p = offset` with a colour, for the brute force below.
struct Plane {
    normal: DVec3,
    offset: f64,
    color: Vec3,
}

#[test]
fn crossing_quads_show_the_nearer_one_along_every_ray() {
    // Two squares through the axis at 3 m, turned by +-40 degrees about the vertical.
    let colors = [vec3(1.0, 0.2, 0.1), vec3(0.1, 0.3, 1.0)];
    let turned = |sign: f64| {
        DAffine3::from_translation(dvec3(0.0, 0.0, -3.0)) * DAffine3::from_rotation_y(sign * 40f64.to_radians())
    };
    let square = quad(0.0, Vec2::splat(-20.0), Vec2::splat(20.0), 0);
    let mut crossing =
        scene(vec![square.clone(), defocus::scene::Mesh { material: 1, ..square }], colors.map(unlit).to_vec());
    crossing.instances[0].world_from_object = turned(1.0);
    crossing.instances[1].world_from_object = turned(-1.0);
    let planes: Vec<Plane> = [1.0, -1.0]
        .into_iter()
        .zip(colors)
        .map(|(sign, color)| {
            let normal = turned(sign).transform_vector3(DVec3::Z);
            Plane { normal, offset: normal.dot(dvec3(0.0, 0.0, -3.0)), color }
        })
        .collect();
    let projection = frame(32, 24);
    let lens = lens(12.0, 3.0);
    let image = trace(crossing, &projection, &lens, &points(128));
    for y in 0..24 {
        for x in 0..32 {
            let toward = projection.view_direction(dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let mut sum = Vec3::ZERO;
            for i in 0..128 {
                let eye = projection.eye_on_lens_m(&lens, lens.aperture.lens_point(i)).extend(0.0);
                let direction = toward * 3.0 - eye;
                let depth = |p: &&Plane| {
                    let t = (p.offset - p.normal.dot(eye)) / p.normal.dot(direction);
                    if t > 0.0 { t } else { f64::INFINITY }
                };
                let nearest = planes.iter().min_by(|a, b| depth(a).total_cmp(&depth(b))).expect("two planes");
                sum += nearest.color;
            }
            let difference = (image.color.at(x, y) - sum / 128.0).abs().max_element();
            // A ray that meets both in one point may take either: at most one of 128.
            assert!(difference < 1.0 / 127.0, "({x}, {y}): off by {difference}");
        }
    }
}

#[test]
fn back_faces_are_culled_also_in_mirrored_instances() {
    let projection = frame(8, 8);
    let hits = |world_from_object: DAffine3, double_sided: bool| {
        let material = Material { double_sided, ..unlit(Vec3::ONE) };
        let mut one = scene(vec![quad(0.0, Vec2::splat(-5.0), Vec2::splat(5.0), 0)], vec![material]);
        let away = DAffine3::from_translation(dvec3(0.0, 0.0, -2.0));
        one.instances[0].world_from_object = away * world_from_object;
        let image = trace(one, &projection, &lens(4.0, 3.0), &points(4));
        let seen = image.depth.pixels.iter().filter(|d| d.is_finite()).count();
        assert!(seen == 0 || seen == 64, "{seen}");
        assert_eq!(seen > 0, image.color.at(4, 4).x > 0.5);
        seen > 0
    };
    let about = DAffine3::from_rotation_y(std::f64::consts::PI);
    let mirror_x = DAffine3::from_scale(dvec3(-1.0, 1.0, 1.0));
    let mirror_z = DAffine3::from_scale(dvec3(1.0, 1.0, -1.0));
    assert!(hits(DAffine3::IDENTITY, false));
    assert!(!hits(about, false));
    assert!(hits(about, true));
    // Mirrored across its own plane's x the front stays in front; across z it turns away.
    assert!(hits(mirror_x, false));
    assert!(!hits(mirror_z, false));
    assert!(hits(mirror_z * about, false));
}

#[test]
fn what_alpha_cuts_away_lets_rays_pass() {
    let projection = frame(32, 8);
    let half = |alpha_cutoff| {
        let front = Material { base_color: vec3(1.0, 0.0, 0.0).extend(0.4), alpha_cutoff, ..unlit(Vec3::ONE) };
        let back = unlit(vec3(0.0, 1.0, 0.0));
        let mut near = quad(1.0, Vec2::splat(-5.0), Vec2::splat(5.0), 0);
        // Vertex alpha from 0 at the left to 2 at the right: the cut at 0.5 is where it is 1.25.
        for vertex in &mut near.vertices {
            vertex.color.w = if vertex.position.x < 0.0 { 0.0 } else { 2.0 };
        }
        let far = quad(2.0, Vec2::splat(-50.0), Vec2::splat(50.0), 1);
        trace(scene(vec![near, far], vec![front, back]), &projection, &lens(6.0, 1.0), &points(16))
    };
    let cut = half(Some(0.5));
    // alpha = 0.4 * (1 + x/5) >= 0.5 where x >= 1.25 m, at 1 m depth.
    let first_px = 16.0 + 1.25 * projection.focal_px;
    assert!(first_px > 20.0 && projection.focal_px < 10.0, "in view: {first_px}");
    for x in 0..32 {
        let opaque = f64::from(x) + 0.5 > first_px;
        let expected = if opaque { (vec3(1.0, 0.0, 0.0), 1.0) } else { (vec3(0.0, 1.0, 0.0), 2.0) };
        assert_eq!((cut.color.at(x, 4), cut.depth.at(x, 4)), expected, "column {x}");
    }
    assert!(half(None).color.pixels.iter().all(|p| p.x > 0.999), "without a cut-off nothing is cut");
}

#[test]
fn a_sphere_lies_where_it_should() {
    let (radius, distance) = (1.0, 3.0);
    let rings = 64;
    let mut ball = scene(vec![sphere(radius as f32, rings, 0)], vec![unlit(Vec3::ONE)]);
    ball.instances[0].world_from_object = DAffine3::from_translation(dvec3(0.2, -0.1, -distance));
    let projection = frame(48, 48);
    let depth: DepthImage = trace(ball, &projection, &lens(0.0, 3.0), &points(1)).depth;
    let centre = dvec3(0.2, -0.1, -distance);
    let (mut inside, mut outside) = (0, 0);
    for y in 0..48 {
        for x in 0..48 {
            let direction = projection.view_direction(dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let (a, b) = (direction.length_squared(), direction.dot(centre));
            let discriminant = b * b - a * (centre.length_squared() - radius * radius);
            let closest = (centre - direction * (b / a)).length();
            // The mesh lies within the sagitta r (1 - cos^2(half a cell)) of the sphere; along
            // a ray at the incidence cos i that is sagitta / cos i.
            let half_cell = 0.5 * std::f64::consts::PI / f64::from(rings);
            let sagitta = radius * (1.0 - half_cell.cos().powi(2));
            if closest < radius * 0.98 {
                let exact = (b - discriminant.sqrt()) / a;
                let cos_incidence = (1.0 - (closest / radius).powi(2)).sqrt();
                let error = f64::from(depth.at(x, y)) - exact;
                assert!(error > -1e-6 && error < 1.5 * sagitta / cos_incidence, "({x}, {y}): {error}");
                inside += 1;
            } else if closest > radius {
                assert!(depth.at(x, y).is_infinite());
                outside += 1;
            }
        }
    }
    assert!(inside > 300 && outside > 300, "{inside}, {outside}");
}

/// A ball and a floor under a sun, a lamp, a spot and a studio, all moved by `placed`.
fn lit_scene(placed: DAffine3) -> Scene {
    let glossy = Material { metallic: 0.3, roughness: 0.3, base_color: vec3(0.8, 0.5, 0.2).extend(1.0), ..textured() };
    let glossy = Material { unlit: false, ..glossy };
    let floor = Material { unlit: false, metallic: 0.0, roughness: 0.7, ..textured() };
    let mut lit =
        scene(vec![sphere(1.0, 24, 0), quad(0.0, Vec2::splat(-6.0), Vec2::splat(6.0), 1)], vec![glossy, floor]);
    lit.instances[0].world_from_object = placed * DAffine3::from_translation(dvec3(0.0, 0.0, -4.0));
    lit.instances[1].world_from_object =
        placed * DAffine3::from_translation(dvec3(0.0, -1.0, -4.0)) * DAffine3::from_rotation_x(-1.5);
    let along = |direction: DVec3| placed.transform_vector3(direction.normalize());
    let direction = along(dvec3(0.3, -1.0, -0.4));
    let lamp = placed.transform_point3(dvec3(-1.5, 1.5, -2.5));
    lit.lights = vec![
        Light { intensity: Vec3::splat(2.0), kind: LightKind::Directional { direction } },
        Light { intensity: vec3(3.0, 2.0, 1.0), kind: LightKind::Point { position: lamp, range_m: 8.0 } },
        Light {
            intensity: vec3(1.0, 4.0, 9.0),
            kind: LightKind::Spot {
                position: placed.transform_point3(dvec3(2.0, 2.0, -3.0)),
                range_m: f64::INFINITY,
                direction: along(dvec3(-0.5, -1.0, -0.3)),
                cos_inner: 0.95,
                cos_outer: 0.8,
            },
        },
    ];
    lit.environment = Environment::Studio {
        zenith: vec3(0.5, 0.6, 0.9),
        horizon: vec3(0.8, 0.8, 0.8),
        ground: vec3(0.2, 0.15, 0.1),
        softbox: 3.0,
    };
    lit
}

#[test]
fn far_from_the_origin_and_looking_back_is_the_same() {
    let projection = frame(48, 36);
    let at = |position: DVec3, orientation: DQuat| {
        let camera = Camera { position, orientation, ..front_camera() };
        let placed = DAffine3::from_rotation_translation(orientation, position);
        start(lit_scene(placed), &camera, &projection, &lens(8.0, 4.0), &points(16))
            .run(|_, _| ControlFlow::Continue(()))
    };
    // The studio is the same after half a turn about the vertical, and after no less.
    let half_turn = DQuat::from_rotation_y(std::f64::consts::PI);
    let here = at(DVec3::ZERO, DQuat::IDENTITY);
    let there = at(dvec3(1.0e6, -2.0e5, 1.0e6), half_turn);
    // f64 places a point 1.4e6 m away to 2.3e-10 m, a hundredth of f32 at 4 m: an edge pixel
    // may change hands for one lens point, all others agree to shading's f32 rounding.
    let differing =
        here.color.pixels.iter().zip(&there.color.pixels).filter(|(a, b)| (**a - **b).abs().max_element() > 1e-4);
    assert!(differing.count() <= 2);
    let depths = here.depth.pixels.iter().zip(&there.depth.pixels);
    assert!(depths.filter(|(a, b)| !(a == b || (**a - **b).abs() < 1e-5)).count() <= 2);
}

#[test]
fn a_diffuse_surface_under_one_lux() {
    // A rough dielectric facing a light of pi lux: Schlick's F at normal incidence is 0.04,
    // D = 1/pi and V = 1/4 at roughness 1, so the radiance is albedo * 0.96 + 0.04 / 4.
    let white = Material { metallic: 0.0, roughness: 1.0, ..Material::default() };
    let mut one = scene(vec![quad(2.0, Vec2::splat(-9.0), Vec2::splat(9.0), 0)], vec![white]);
    let kind = LightKind::Directional { direction: DVec3::NEG_Z };
    one.lights = vec![Light { intensity: Vec3::splat(std::f32::consts::PI), kind }];
    let image = trace(one.clone(), &frame(3, 3), &lens(0.0, 3.0), &points(1));
    assert!((image.pinhole.at(1, 1) - Vec3::splat(0.97)).abs().max_element() < 1e-5, "{}", image.pinhole.at(1, 1));
    let plain = trace(one, &frame(3, 3), &lens(0.0, 3.0), &RayOptions { shading: Shading::Unlit, ..points(1) });
    assert_eq!(plain.pinhole.at(1, 1), Vec3::ONE);
}

/// A rough white quad of the given vertex normal under a slanting light, as one pixel.
fn slanted(normal: Vec3, normal_map: Option<[u8; 4]>, world_from_object: DAffine3) -> Vec3 {
    let mut material = Material { metallic: 0.0, roughness: 0.6, double_sided: true, ..Material::default() };
    let mut mesh = quad(0.0, Vec2::splat(-9.0), Vec2::splat(9.0), 0);
    for vertex in &mut mesh.vertices {
        vertex.normal = normal.normalize();
    }
    if normal_map.is_some() {
        material.normal_texture = textured().base_color_texture;
    }
    let mut one = scene(vec![mesh], vec![material]);
    if let Some(texel) = normal_map {
        let flat = TextureImage { srgb: false, rgba8: vec![texel; 64], ..uv_grid_texture(uvec2(8, 8)) };
        one.textures = vec![Arc::new(flat)];
    }
    one.instances[0].world_from_object = DAffine3::from_translation(dvec3(0.0, 0.0, -2.0)) * world_from_object;
    let kind = LightKind::Directional { direction: dvec3(-0.6, -0.3, -0.7).normalize() };
    one.lights = vec![Light { intensity: Vec3::splat(3.0), kind }];
    trace(one, &frame(1, 1), &lens(0.0, 3.0), &points(1)).pinhole.at(0, 0)
}

#[test]
fn normals_come_from_maps_and_turn_over_on_back_faces() {
    let straight = slanted(Vec3::Z, None, DAffine3::IDENTITY);
    let texel = [200u8, 90, 220, 255];
    let stored = vec3(200.0, 90.0, 220.0) / 127.5 - Vec3::ONE;
    let mapped = slanted(Vec3::Z, Some(texel), DAffine3::IDENTITY);
    // Tangent +x and normal +z give the bitangent +y: the texel's own axes.
    let expected = slanted(stored, None, DAffine3::IDENTITY);
    assert!((mapped - expected).abs().max_element() < 1e-5, "{mapped}, not {expected}");
    assert!((mapped - straight).abs().max_element() > 0.01);
    // Half a turn shows the back: the normal that pointed away is turned over.
    let behind = slanted(Vec3::Z, None, DAffine3::from_rotation_y(std::f64::consts::PI));
    assert!((behind - straight).abs().max_element() < 1e-5, "{behind}, not {straight}");
    // Squeezed tenfold along z a normal leans towards z: inverse transpose, not the matrix.
    let squeezed = slanted(vec3(1.0, 0.0, 1.0), None, DAffine3::from_scale(dvec3(1.0, 1.0, 0.1)));
    let leaning = slanted(vec3(0.1, 0.0, 1.0), None, DAffine3::IDENTITY);
    assert!((squeezed - leaning).abs().max_element() < 1e-5, "{squeezed}, not {leaning}");
}

#[test]
fn the_background_is_seen_along_the_rays_own_direction() {
    let mut empty = Scene::default();
    let (zenith, horizon) = (vec3(4.0, 2.0, 1.0), vec3(0.0, 0.5, 1.0));
    empty.environment = Environment::Studio { zenith, horizon, ground: Vec3::ZERO, softbox: 0.0 };
    let projection = frame(9, 9);
    let lens = lens(6.0, 2.0);
    let image = trace(empty, &projection, &lens, &points(64));
    // What lies at infinity moves by +K v / 2 pixels as the eye moves to v (Projection::
    // clip_from_view), so a pixel shows what the pinhole sees at -K v / 2. Upper rows only.
    let sky = |p: DVec2| {
        let y = projection.view_direction(p).normalize().y;
        horizon.as_dvec3().lerp(zenith.as_dvec3(), y)
    };
    let centre = dvec2(4.5, 0.5);
    let sum: DVec3 = (0..64).map(|i| sky(centre - lens.aperture.lens_point(i) * lens.k_px() / 2.0)).sum();
    let difference = (image.color.at(4, 0).as_dvec3() - sum / 64.0).abs().max_element();
    assert!(difference < 1e-6, "off by {difference}");
    assert!(image.depth.pixels.iter().all(|d| d.is_infinite()));
}

#[test]
fn highlights_follow_the_lens_point_only_when_asked() {
    let camera = front_camera();
    let render = |view_dependent, shading| {
        let options = RayOptions { view_dependent, shading, lens_points: 0..64 };
        start(lit_scene(DAffine3::IDENTITY), &camera, &frame(48, 36), &lens(60.0, 3.2), &options)
            .run(|_, _| ControlFlow::Continue(()))
            .color
    };
    let lit = greatest_difference(&render(false, Shading::Scene), &render(true, Shading::Scene));
    let unlit = greatest_difference(&render(false, Shading::Unlit), &render(true, Shading::Unlit));
    assert!(lit > 0.02, "glossy surfaces depend on the view: {lit}");
    assert_eq!(unlit, 0.0);
}

#[test]
fn stopping_and_going_on_loses_nothing() {
    let camera = front_camera();
    let begin = || start(lit_scene(DAffine3::IDENTITY), &camera, &frame(24, 18), &lens(8.0, 3.0), &points(48));
    let whole = begin().run(|_, _| ControlFlow::Continue(()));
    let mut parts = begin();
    assert_eq!(parts.image().color, parts.image().pinhole, "no lens point yet");
    let cancel = AtomicBool::new(true);
    parts.advance(7, &cancel);
    assert_eq!(parts.points_done(), 0);
    cancel.store(false, Ordering::Relaxed);
    for step in [7, 20, 1000] {
        parts.advance(step, &cancel);
    }
    assert!(parts.is_complete());
    assert_eq!(parts.image(), whole);
    let stopped = begin().run(|_, _| ControlFlow::Break(()));
    assert!(stopped.lens_points > 0 && stopped.lens_points <= 48);
}

#[test]
fn impossible_lenses_and_near_planes_are_named() {
    let scene = Arc::new(wide_quad(2.0));
    let camera = front_camera();
    let flat = Camera { near_m: 0.0, ..camera };
    assert!(matches!(RayScene::new(scene.clone(), &flat), Err(RayError::Near { .. })));
    let rays = Arc::new(RayScene::new(scene, &camera).expect("a scene that can be traced"));
    let close = Lens { focus_distance_m: 0.001, ..lens(4.0, 3.0) };
    let error = RayRender::new(rays, &frame(4, 4), &close, &points(4)).err().expect("df < F");
    assert!(matches!(error, RayError::Lens(_)), "{error}");
}

#[test]
fn nothing_before_the_near_plane_is_seen() {
    let projection = frame(8, 8);
    let quads = |near_depth| {
        vec![
            quad(near_depth, Vec2::splat(-5.0), Vec2::splat(5.0), 0),
            quad(2.0, Vec2::splat(-50.0), Vec2::splat(50.0), 0),
        ]
    };
    let depth_with = |near_depth| {
        let image = trace(scene(quads(near_depth), vec![unlit(Vec3::ONE)]), &projection, &lens(6.0, 2.0), &points(4));
        image.depth.at(4, 4)
    };
    assert_eq!(depth_with(0.099), 2.0);
    assert!((depth_with(0.101) - 0.101).abs() < 1e-6);
}
