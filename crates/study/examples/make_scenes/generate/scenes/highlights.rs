//! A wet street at night with small, very bright lights at all depths.

use super::prelude::*;
use std::f32::consts::TAU;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.004, 0.006, 0.014),
            horizon: vec3(0.030, 0.022, 0.030),
            ground: vec3(0.010, 0.009, 0.010),
            softbox: 0.0,
        },
        focus_m: 1.2,
        occlusion_m: 0.8,
        ..Stage::default()
    };
    stage.sun(vec3(0.10, 0.13, 0.22), vec3(0.3, -0.8, -0.5), 0.05);
    stage.lamp(vec3(0.55, 0.36, 0.18), vec3(-0.55, 1.75, -0.55), 0.05);
    stage.lamp(vec3(0.10, 0.16, 0.34), vec3(0.9, 1.5, -1.6), 0.05);
    stage.lamp(vec3(9.0, 6.2, 3.2), vec3(-3.0, 4.2, -7.0), 0.15);
    stage.lamp(vec3(9.0, 6.2, 3.2), vec3(3.0, 4.2, -13.0), 0.15);
    let lamps = street_lamps();
    street(&mut stage, &lamps);
    houses(&mut stage);
    strings(&mut stage);
    table(&mut stage);
    stage.camera("street", vec3(0.0, 1.32, 0.0), vec3(0.08, 1.30, -3.0), 40.0, 0.05);
    stage.camera("table", vec3(-0.5, 1.45, -0.15), vec3(0.25, 1.12, -1.7), 44.0, 0.05);
    stage
}

fn glow(stage: &mut Stage, name: &'static str, radiance: Vec3) -> usize {
    stage.material(Material { name, color: Vec3::ZERO, emissive: radiance, ..Material::default() })
}

/// Positions of the street lamps' bulbs.
fn street_lamps() -> Vec<Vec3> {
    (0..14)
        .map(|k| {
            let side = if k % 2 == 0 { -1.0 } else { 1.0 };
            vec3(side * 2.9, 4.3, -7.0 - 6.0 * (k / 2) as f32 * (1.0 + 0.1 * k as f32) - 6.0 * (k % 2) as f32)
        })
        .collect()
}

fn street(stage: &mut Stage, lamps: &[Vec3]) {
    let cobbles = patterns::cobbles(1024, ivec2(12, 16), 4);
    let cobbles = stage.jpeg(cobbles, 78);
    // Light lies on the wet stones as streaks towards the eye, painted as emission.
    let (near, far) = (1.0, -70.0);
    let place = move |uv: Vec2| vec2((uv.x - 0.5) * 9.0, near + (far - near) * uv.y * uv.y);
    let mirror: Vec<(Vec2, Vec3, f32)> = lamps
        .iter()
        .map(|l| (vec2(l.x, l.z), vec3(1.0, 0.72, 0.4), 1.0))
        .chain([
            (vec2(-3.6, -9.0), vec3(1.0, 0.15, 0.25), 0.9),
            (vec2(3.6, -16.0), vec3(0.2, 0.6, 1.0), 0.9),
            (vec2(3.4, -6.0), vec3(0.3, 1.0, 0.5), 0.5),
        ])
        .collect();
    let streaks = Canvas::paint(512, 1024, move |uv| {
        let p = place(uv);
        let stones = smoothstep(0.08, 0.3, {
            let (a, b, _) = cells(vec2(p.x / 3.6, p.y / 3.6), ivec2(24, 24), 5);
            b - a
        });
        let ripple = 0.25 + 0.75 * smoothstep(0.35, 0.6, fbm(vec2(p.x / 9.0, p.y / 24.0), ivec2(30, 24), 3, 8));
        let mut sum = Vec3::ZERO;
        for &(lamp, colour, strength) in &mirror {
            // The streak runs from below the lamp along the line to the eye.
            let t = (p.y / lamp.y).clamp(0.0, 1.2);
            let off = (p.x - lamp.x * t) / (0.10 + 0.16 * t);
            let along = smoothstep(0.12, 0.5, t) * smoothstep(1.15, 0.8, t);
            sum += colour * strength * (-off * off).exp() * along;
        }
        (sum * ripple * (0.25 + 0.75 * stones)).map(|v| v.clamp(0.0, 1.0).powf(1.0 / 2.2))
    });
    let streaks = stage.jpeg(streaks, 82);
    let wet = stage.material(Material {
        name: "wet cobbles",
        roughness: 0.25,
        texture: Some(cobbles),
        ..Material::default()
    });
    let lit = stage.material(Material {
        name: "reflections",
        color: vec3(0.02, 0.02, 0.022),
        roughness: 0.3,
        emissive: vec3(1.1, 1.1, 1.1),
        emissive_texture: Some(streaks),
        ..Material::default()
    });
    let road = |y: f32, half: f32| {
        Shape::surface(40, 110, move |u, v| {
            let p = place(vec2(u, v));
            vec3(p.x / 4.5 * half, y, p.y)
        })
        .flipped_if(|c| c.normal.y < 0.0)
    };
    stage.place(road(0.0, 2.4).mapped(|c| vec2((c.position.x / 9.0) + 0.5, c.uv.y)), lit);
    for side in [-1.0f32, 1.0] {
        let kerb = Shape::cuboid(vec3(side * 4.0, 0.05, -34.5), vec3(3.2, 0.1, 71.0), 0.8);
        stage.place(kerb.mapped(|c| vec2(c.position.x, c.position.z) / 1.8), wet);
    }
    let iron = stage.material(Material {
        name: "iron",
        color: vec3(0.05, 0.05, 0.055),
        roughness: 0.4,
        double_sided: true,
        ..Material::default()
    });
    let profile =
        [(0.12, 0.1), (0.12, 0.3), (0.07, 0.4), (0.05, 1.0), (0.045, 3.9), (0.09, 3.95), (0.09, 4.05), (0.03, 4.08)]
            .map(|(r, y)| vec2(r, y));
    let post = stage.mesh(Shape::lathe(&profile, 20), iron);
    let hat = stage.mesh(Shape::lathe(&[vec2(0.2, 4.42), vec2(0.12, 4.56), vec2(0.02, 4.66)], 20), iron);
    let bulb = glow(stage, "street lamp", vec3(120.0, 84.0, 44.0));
    let bulb = stage.mesh(Shape::sphere(0.085, 12), bulb);
    for lamp in lamps {
        stage.node(post, at(lamp.x, 0.0, lamp.z));
        stage.node(hat, at(lamp.x, 0.0, lamp.z));
        stage.node(bulb, at(lamp.x, lamp.y, lamp.z));
    }
    for (colour, x, y, z) in [
        (vec3(160.0, 10.0, 8.0), -0.35, 0.85, -30.0),
        (vec3(160.0, 10.0, 8.0), 0.5, 0.85, -30.0),
        (vec3(180.0, 170.0, 150.0), 1.1, 0.8, -44.0),
        (vec3(180.0, 170.0, 150.0), 1.7, 0.8, -44.0),
        (vec3(10.0, 150.0, 70.0), 2.6, 3.2, -26.0),
    ] {
        let light = glow(stage, "car and signal", colour);
        stage.place(Shape::sphere(0.09, 10).moved(at(x, y, z)), light);
    }
}

fn houses(stage: &mut Stage) {
    let brick = stage.jpeg(patterns::brick(512, ivec2(5, 14), rgb(0x7a4c3c), rgb(0x8a8278), 5), 76);
    let brick = stage.matte("front", brick, 0.8);
    let panes: Vec<usize> = [(14.0, 9.0, 4.0), (8.0, 7.0, 5.0), (3.0, 5.0, 9.0), (22.0, 15.0, 6.0)]
        .map(|(r, g, b)| {
            let texture = stage.png(window(r > 10.0));
            stage.material(Material {
                name: "window",
                color: vec3(0.02, 0.02, 0.02),
                roughness: 0.2,
                emissive: vec3(r, g, b),
                emissive_texture: Some(texture),
                ..Material::default()
            })
        })
        .to_vec();
    let dark = stage.material(Material {
        name: "dark pane",
        color: vec3(0.015, 0.017, 0.02),
        roughness: 0.1,
        ..Material::default()
    });
    let pane = Shape::surface(2, 2, |u, v| vec3(u - 0.5, 0.5 - v, 0.0)).flipped_if(|c| c.normal.z < 0.0);
    let windows: Vec<usize> = panes.iter().chain([&dark]).map(|&m| stage.mesh(pane.clone(), m)).collect();
    let sill = stage.mesh(Shape::cuboid(vec3(0.0, -0.56, 0.05), vec3(1.16, 0.09, 0.1), 1.0), brick);
    let mut rng = Rng::new(29);
    for side in [-1.0f32, 1.0] {
        let mut z = -2.5;
        while z > -72.0 {
            let (width, height) = (rng.range(4.0, 7.0), rng.range(6.5, 13.0));
            let x = side * (5.2 + rng.range(0.0, 0.4));
            let block = Shape::cuboid(vec3(x + side, height * 0.5, z - width * 0.5), vec3(2.0, height, width), 0.7);
            stage.place(block.mapped(|c| c.uv / 1.2), brick);
            let columns = (width / 1.5) as usize;
            for row in 0..(height / 1.9) as usize {
                for column in 0..columns {
                    let spot = vec3(
                        x - side * 0.012,
                        1.5 + 1.9 * row as f32,
                        z - (column as f32 + 0.5) * width / columns as f32,
                    );
                    let place = Mat4::from_translation(spot)
                        * turn(-side * TAU * 0.25)
                        * Mat4::from_scale(vec3(0.78, 1.15, 1.0));
                    let kind = if rng.unit() < 0.42 { rng.index(4) } else { 4 };
                    stage.node(windows[kind], place);
                    stage.node(sill, place);
                }
            }
            z -= width;
        }
    }
    // A skyline that closes the street.
    for k in 0..9 {
        let (x, h) = (-12.0 + 3.0 * k as f32, rng.range(9.0, 20.0));
        stage.place(Shape::cuboid(vec3(x, h * 0.5, -76.0 - 2.0 * (k % 3) as f32), vec3(2.9, h, 2.0), 3.0), brick);
        for _ in 0..26 {
            let spot = at(
                x + (rng.index(4) as f32 - 1.5) * 0.66,
                1.5 + 1.1 * rng.index((h / 1.1) as usize - 2) as f32,
                -74.9 - 2.0 * (k % 3) as f32,
            );
            stage.node(windows[rng.index(4)], spot * Mat4::from_scale(vec3(0.36, 0.5, 1.0)));
        }
    }
    signs(stage);
}

fn window(curtain: bool) -> Canvas {
    let mut c = Canvas::paint(96, 128, |uv| Vec3::splat(0.55 + 0.45 * (1.0 - uv.y)));
    if curtain {
        c.blend(vec2(0.0, 0.0), vec2(96.0, 128.0), rgb(0x6a2a18), |p| {
            f32::from((p.x - 48.0).abs() > 22.0 + 12.0 * (p.y / 128.0)) * 0.85
        });
    }
    for x in [0.0, 45.0, 90.0] {
        c.rect(x, 0.0, 6.0, 128.0, Vec3::ZERO);
    }
    for y in [0.0, 40.0, 122.0] {
        c.rect(0.0, y, 96.0, 6.0, Vec3::ZERO);
    }
    c
}

fn signs(stage: &mut Stage) {
    for (text, tint, radiance, x, y, z, width) in [
        ("BOKEH BAR", 0xff3050, 26.0, -3.75, 3.0, -9.0, 2.4),
        ("HOTEL IRIS", 0x50a8ff, 22.0, 3.7, 3.6, -16.0, 2.4),
        ("OPEN", 0x60ff90, 18.0, 3.6, 1.9, -6.0, 1.0),
        ("CINEMA", 0xffc040, 30.0, -3.7, 4.6, -22.0, 2.6),
    ] {
        let (w, h) = (text.len() as f32 * 40.0 + 40.0, 96.0);
        let mut c = Canvas::filled(w as usize, h as usize, Vec3::splat(0.01));
        c.text_centred(w * 0.5, 24.0, 48.0, 7.0, rgb(tint), text);
        let (a, b, d, e) = (vec2(6.0, 6.0), vec2(w - 6.0, 6.0), vec2(w - 6.0, h - 6.0), vec2(6.0, h - 6.0));
        c.stroke(&[a, b, d, e, a], 4.0, rgb(tint) * 0.8);
        let texture = stage.png(c);
        let neon = stage.material(Material {
            name: "neon",
            color: vec3(0.02, 0.02, 0.02),
            emissive: Vec3::splat(radiance),
            emissive_texture: Some(texture),
            double_sided: true,
            ..Material::default()
        });
        let board = Shape::surface(8, 2, |u, v| vec3((u - 0.5) * width, (0.5 - v) * width * h / w, 0.0));
        let board = board.flipped_if(|c| c.normal.z < 0.0);
        stage.place(board.moved(at(x, y, z) * turn(if x < 0.0 { 0.35 } else { -0.35 })), neon);
    }
}

/// Strings of fairy lights across the street.
fn strings(stage: &mut Stage) {
    let colours =
        [(90.0, 58.0, 24.0), (200.0, 130.0, 55.0), (90.0, 12.0, 10.0), (12.0, 60.0, 110.0), (14.0, 90.0, 30.0)];
    let near: Vec<usize> = colours
        .iter()
        .map(|&(r, g, b)| {
            let material = glow(stage, "fairy light", vec3(r, g, b));
            stage.mesh(Shape::sphere(0.011, 8), material)
        })
        .collect();
    let cord = stage.material(Material { name: "cord", color: vec3(0.03, 0.035, 0.03), ..Material::default() });
    let mut rng = Rng::new(61);
    for (a, b, sag, count) in [
        (vec3(-0.75, 1.62, -1.0), vec3(0.9, 1.78, -1.9), 0.22, 20),
        (vec3(-1.6, 2.15, -2.2), vec3(1.5, 1.9, -3.0), 0.35, 26),
        (vec3(-2.4, 2.5, -4.6), vec3(2.6, 2.7, -4.2), 0.5, 32),
        (vec3(-5.0, 3.6, -7.5), vec3(5.0, 3.3, -8.5), 0.7, 40),
        (vec3(-5.0, 4.4, -12.0), vec3(5.0, 4.1, -13.5), 0.8, 40),
        (vec3(-5.0, 4.8, -19.0), vec3(5.0, 5.0, -20.0), 0.8, 36),
        (vec3(-5.0, 5.4, -30.0), vec3(5.0, 5.2, -30.0), 0.9, 30),
    ] {
        let hang = |t: f32| a.lerp(b, t) - Vec3::Y * sag * 4.0 * t * (1.0 - t);
        let thickness = 0.0016 * (1.0 + 0.25 * -a.z);
        let path: Vec<_> = (0..=60).map(|k| (hang(k as f32 / 60.0), thickness)).collect();
        stage.place(Shape::tube(&path, 6), cord);
        for k in 0..count {
            let p = hang((k as f32 + 0.5) / count as f32) - Vec3::Y * 0.02;
            let size = 1.0 + 0.13 * -a.z;
            stage.node(
                near[if rng.unit() < 0.6 { k % 2 } else { rng.index(5) }],
                Mat4::from_translation(p) * Mat4::from_scale(vec3(size, size, size)),
            );
        }
    }
}

/// A café table with a lantern, a cup and a card.
fn table(stage: &mut Stage) {
    let wood = stage.jpeg(patterns::wood(640, 5, rgb(0xa8703c), rgb(0x55301a), 2), 80);
    let wood = stage.matte("table", wood, 0.35);
    let top = Shape::surface(50, 40, |u, v| vec3(-0.75 + 1.6 * u, 1.02, -0.7 - 0.95 * v));
    stage.place(top.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z) / 0.7), wood);
    stage.place(Shape::cuboid(vec3(0.05, 0.994, -1.175), vec3(1.6, 0.05, 0.95), 0.3), wood);
    let brass = stage.material(Material {
        name: "brass",
        color: vec3(0.75, 0.52, 0.22),
        metallic: 1.0,
        roughness: 0.3,
        ..Material::default()
    });
    let flame = glow(stage, "flame", vec3(200.0, 110.0, 34.0));
    let (x, z) = (0.22, -1.2);
    let foot = [(0.001, 0.0), (0.07, 0.0), (0.075, 0.012), (0.06, 0.022), (0.05, 0.03), (0.001, 0.032)]
        .map(|(r, y)| vec2(r, y));
    let roof = [(0.075, 0.19), (0.078, 0.2), (0.045, 0.225), (0.02, 0.235), (0.016, 0.26), (0.001, 0.265)]
        .map(|(r, y)| vec2(r, y));
    let mut lantern = Shape::lathe(&foot, 40);
    lantern.append(&Shape::lathe(&roof, 40));
    for k in 0..8 {
        let (sin, cos) = (k as f32 / 8.0 * TAU).sin_cos();
        let rod = [0.025, 0.11, 0.195].map(|y| (vec3(sin * 0.062, y, cos * 0.062), 0.0035));
        lantern.append(&Shape::tube(&rod, 8));
    }
    lantern.append(&Shape::torus(0.03, 0.003, 32, 8).moved(at(0.0, 0.285, 0.0) * Mat4::from_rotation_x(TAU * 0.25)));
    stage.place(lantern.moved(at(x, 1.02, z)), brass);
    let drop: Vec<Vec2> = (0..=16)
        .map(|k| {
            let t = k as f32 / 16.0;
            vec2(0.0105 * (t * std::f32::consts::PI).sin() * (1.25 - t) + 1e-4, 0.055 + 0.05 * t)
        })
        .collect();
    stage.place(Shape::lathe(&drop, 20).moved(at(x, 1.02, z)), flame);
    let wax =
        stage.material(Material { name: "wax", color: vec3(0.8, 0.72, 0.55), roughness: 0.5, ..Material::default() });
    stage.place(
        Shape::lathe(&[vec2(0.028, 0.03), vec2(0.028, 0.054), vec2(0.001, 0.052)], 32).moved(at(x, 1.02, z)),
        wax,
    );
    stage.lamp(vec3(0.16, 0.095, 0.04), vec3(x, 1.10, z), 0.012);
    let glaze = stage.jpeg(patterns::star_tiles(384, 4, 2), 84);
    let glaze = stage.matte("cup", glaze, 0.2);
    let cup = [
        (0.001, 0.004),
        (0.028, 0.0),
        (0.034, 0.008),
        (0.042, 0.045),
        (0.044, 0.075),
        (0.0415, 0.076),
        (0.038, 0.045),
        (0.001, 0.02),
    ]
    .map(|(r, y)| vec2(r, y));
    let mut mug = Shape::lathe(&cup, 56);
    mug.append(&Shape::torus(0.022, 0.005, 40, 10).moved(at(0.058, 0.04, 0.0) * Mat4::from_rotation_x(TAU * 0.25)));
    let mug = mug.mapped(|c| vec2(c.uv.x * 2.0, c.uv.y));
    stage.place(mug.clone().moved(at(-0.12, 1.02, -1.02) * turn(2.4)), glaze);
    stage.place(mug.moved(at(0.02, 1.02, -1.42) * turn(0.6)), glaze);
    let card = stage.jpeg(super::labels::poster(), 82);
    let card = stage.matte("card", card, 0.6);
    let sheet = Shape::surface(8, 10, |u, v| vec3((u - 0.5) * 0.2, 0.265 * (1.0 - v), -0.05 * (1.0 - v)));
    stage.place(sheet.flipped_if(|c| c.normal.z < 0.0).moved(at(-0.3, 1.022, -1.3) * turn(0.35)), card);
}
