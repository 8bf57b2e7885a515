//! A two-storey colonnade around a court, one column very near: far focus.

use super::column::{arch, baluster, column, drape, railing};
use super::prelude::*;
use std::f32::consts::PI;

const BAY: f32 = 2.3;

const SIDE: f32 = 2.6;
const FIRST: f32 = -0.85;
const SPRING: f32 = 2.9;
const UPPER: f32 = 4.35;
const UPPER_SCALE: f32 = 0.8;
const ROOF: f32 = UPPER + SPRING * UPPER_SCALE + 1.45;
const FAR: f32 = -14.0;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.20, 0.34, 0.62),
            horizon: vec3(0.50, 0.52, 0.55),
            ground: vec3(0.20, 0.16, 0.12),
            softbox: 0.0,
        },
        focus_m: 13.9,
        occlusion_m: 1.6,
        ..Stage::default()
    };
    stage.sun(vec3(3.6, 3.05, 2.3), vec3(-0.31, -0.88, -0.34), 0.02);
    let stone = stage.jpeg(patterns::ashlar(1024, ivec2(4, 8), rgb(0xe2cda6), 21), 78);
    let stone = stage.matte("stone", stone, 0.85);
    let marble = stage.jpeg(patterns::marble(768, rgb(0xe8e2d6), rgb(0x8f8474), 5), 80);
    // The capitals' leaves are seen from behind too.
    let marble = stage.material(Material {
        name: "marble",
        texture: Some(marble),
        roughness: 0.4,
        double_sided: true,
        ..Material::default()
    });
    floors(&mut stage, stone);
    arcades(&mut stage, marble, stone);
    galleries(&mut stage, stone, marble);
    far_wall(&mut stage, stone);
    hangings(&mut stage);
    stage.camera("colonnade", vec3(-2.13, 1.55, 0.0), vec3(-0.95, 2.25, -12.0), 50.0, 0.1);
    stage.camera("court", vec3(1.1, 1.3, -0.4), vec3(-1.7, 2.5, -9.0), 48.0, 0.1);
    stage.camera("gallery", vec3(2.75, 5.75, -2.0), vec3(-1.6, 3.0, -10.5), 45.0, 0.1);
    stage
}

fn floors(stage: &mut Stage, stone: usize) {
    let tiles = stage.jpeg(patterns::mosaic(1152, 96, 8), 74);
    let tiles = stage.matte("mosaic", tiles, 0.45);
    let plane = |x0: f32, x1: f32, nu: usize, nv: usize| {
        Shape::surface(nu, nv, |u, v| vec3(x0 + (x1 - x0) * u, 0.0, 1.2 + (FAR - 1.2) * v))
            .flipped_if(|c| c.normal.y < 0.0)
    };
    stage.place(plane(-2.4, 2.4, 48, 140).mapped(|c| vec2(c.position.x, c.position.z) / 2.4), tiles);
    for side in [-1.0, 1.0] {
        let strip = plane(side * 2.4, side * 4.7, 10, 70);
        let strip = strip.mapped(|c| vec2(c.position.x, c.position.z) / 3.0);
        stage.place(strip.flipped_if(|c| c.normal.y < 0.0), stone);
    }
    for step in 0..3 {
        let (y, z) = (0.08 + 0.16 * step as f32, -12.6 - 0.32 * step as f32);
        stage.place(Shape::cuboid(vec3(0.0, y, (z + FAR) * 0.5), vec3(4.4, 0.16, z - FAR), 0.16), stone);
    }
}

fn bay_z(k: usize) -> f32 {
    FIRST - BAY * k as f32
}

fn arcades(stage: &mut Stage, marble: usize, stone: usize) {
    let pillar = column();
    let bow = arch(BAY, 0.86, 1.2, 0.42).mapped(|c| c.uv / 2.6);
    let post = baluster(32);
    for side in [-1.0f32, 1.0] {
        // The sunlit side and the shaded one have light of their own.
        let pillar = stage.mesh(pillar.clone(), marble);
        let bow = stage.mesh(bow.clone(), stone);
        let post = stage.mesh(post.clone(), marble);
        let turned = turn(-side * PI * 0.5);
        // A shared mesh is lit where its first node stands: begin in the middle.
        for k in [2, 0, 1, 3, 4, 5] {
            let z = bay_z(k);
            stage.node(pillar, at(side * SIDE, 0.0, z) * turned);
            let upper = Mat4::from_scale(vec3(UPPER_SCALE, UPPER_SCALE, UPPER_SCALE));
            stage.node(pillar, at(side * SIDE, UPPER, z) * turned * upper);
            for y in [SPRING, UPPER + SPRING * UPPER_SCALE] {
                stage.node(bow, at(side * SIDE, y, z - BAY * 0.5) * turned);
            }
            for j in 0..11 {
                let along = z - 0.28 - 0.174 * j as f32;
                stage.node(post, at(side * SIDE, UPPER + 0.08, along));
                stage.node(post, at(side * SIDE, ROOF, along));
            }
        }
        for y in [SPRING, UPPER + SPRING * UPPER_SCALE] {
            stage.node(bow, at(side * SIDE, y, FIRST + BAY * 0.5) * turned);
        }
    }
}

fn galleries(stage: &mut Stage, stone: usize, marble: usize) {
    let (length, middle) = (15.2, -6.4);
    let metric = |s: Shape| s.mapped(|c| c.uv / 2.6);
    let mut dentils = Shape::default();
    for k in 0..100 {
        dentils.append(&Shape::cuboid(vec3(0.0, 0.0, 1.0 - 0.15 * k as f32), vec3(0.08, 0.07, 0.075), 1.0));
    }
    let dentils = stage.mesh(metric(dentils), stone);
    for side in [-1.0f32, 1.0] {
        let x = side * SIDE;
        let mut beam = Shape::default();
        for top in [UPPER, ROOF] {
            // Entablature: fascia, dentils, cornice.
            beam.append(&Shape::cuboid(vec3(x, top - 0.13, middle), vec3(0.46, 0.26, length), 0.3));
            beam.append(&Shape::cuboid(vec3(x - side * 0.05, top - 0.03, middle), vec3(0.66, 0.06, length), 0.3));
            stage.node(dentils, at(x - side * 0.26, top - 0.1, 0.0));
            beam.append(&Shape::cuboid(vec3(x + side * 1.25, top - 0.1, middle), vec3(2.1, 0.16, length), 0.5));
        }
        stage.place(metric(beam), stone);
        let mut rail = Shape::cuboid(vec3(x, UPPER + 0.82, middle), vec3(0.2, 0.08, length), 0.2);
        rail.append(&Shape::cuboid(vec3(x, ROOF + 0.74, middle), vec3(0.2, 0.08, length), 0.4));
        stage.place(metric(rail), marble);
        let wall = Shape::cuboid(vec3(side * 4.75, 4.1, middle), vec3(0.2, 8.3, length), 0.4);
        stage.place(metric(wall), stone);
    }
}

fn far_wall(stage: &mut Stage, stone: usize) {
    let wall = Shape::surface(64, 60, |u, v| vec3((u - 0.5) * 9.6, 9.2 * (1.0 - v), FAR))
        .flipped_if(|c| c.normal.z < 0.0)
        .mapped(|c| vec2(c.position.x, -c.position.y) / 2.6);
    stage.place(wall, stone);
    let fresco = stage.jpeg(super::fresco::fresco(), 82);
    let fresco = stage.matte("fresco", fresco, 0.8);
    let picture = Shape::surface(40, 48, |u, v| vec3((u - 0.5) * 3.4, 5.35 - 4.1 * v, FAR + 0.05))
        .flipped_if(|c| c.normal.z < 0.0);
    stage.place(picture, fresco);
    let frame = |centre: Vec3, size: Vec3| Shape::cuboid(centre, size, 0.15).mapped(|c| c.uv / 2.6);
    for (centre, size) in [
        (vec3(0.0, 5.43, FAR + 0.08), vec3(3.8, 0.18, 0.2)),
        (vec3(0.0, 1.2, FAR + 0.08), vec3(3.8, 0.16, 0.2)),
        (vec3(-1.8, 3.3, FAR + 0.08), vec3(0.16, 4.1, 0.16)),
        (vec3(1.8, 3.3, FAR + 0.08), vec3(0.16, 4.1, 0.16)),
    ] {
        stage.place(frame(centre, size), stone);
    }
    let frieze = stage.jpeg(super::fresco::frieze(), 85);
    let frieze = stage.matte("frieze", frieze, 0.8);
    let band = Shape::surface(60, 6, |u, v| vec3((u - 0.5) * 5.1, 6.55 - 0.72 * v, FAR + 0.03))
        .flipped_if(|c| c.normal.z < 0.0);
    stage.place(band, frieze);
}

fn hangings(stage: &mut Stage) {
    let red = patterns::damask(640, 3, rgb(0x7d1420), rgb(0xd9a54a), rgb(0xf2e0b0));
    let blue = patterns::damask(640, 3, rgb(0x1c3566), rgb(0xd8d2c0), rgb(0xc08a3a));
    let (red, blue) = (stage.jpeg(red, 82), stage.jpeg(blue, 82));
    let cloth = |texture, name| Material { name, texture: Some(texture), double_sided: true, ..Material::default() };
    let (red, blue) = (stage.material(cloth(red, "red damask")), stage.material(cloth(blue, "blue damask")));
    let iron = stage.material(Material {
        name: "iron",
        color: vec3(0.05, 0.05, 0.055),
        metallic: 0.7,
        roughness: 0.4,
        ..Material::default()
    });
    let curtain = drape(1.55, 2.5, 120, 40);
    let reds = stage.mesh(curtain.clone(), red);
    let blues = stage.mesh(curtain, blue);
    for (side, k, cloth) in [(-1.0, 2, reds), (-1.0, 4, reds), (1.0, 3, blues), (1.0, 1, blues), (1.0, 4, blues)] {
        let z = bay_z(k) - BAY * 0.5;
        stage.node(cloth, at(side * (SIDE + 0.05), SPRING + 0.15, z) * turn(-side * PI * 0.5));
    }
    // Carpets hung over the balustrade.
    let banner = drape(1.1, 1.9, 80, 36).moved(Mat4::from_scale(vec3(1.0, 1.0, 0.45)));
    let banners = [red, blue].map(|material| stage.mesh(banner.clone(), material));
    for (side, k, colour) in [(-1.0f32, 3, 0), (-1.0, 1, 1), (1.0, 2, 0), (1.0, 4, 1), (-1.0, 5, 1)] {
        let place = at(side * (SIDE - 0.42), UPPER + 0.95, bay_z(k) - BAY * 0.5) * turn(-side * PI * 0.5);
        stage.node(banners[colour], place);
    }
    let panel = stage.mesh(railing(BAY - 0.5), iron);
    for k in [3, 0, 1, 2, 4] {
        stage.node(panel, at(SIDE, 0.0, bay_z(k) - BAY * 0.5) * turn(PI * 0.5));
    }
    for x in [-1.35, 1.35] {
        stage.node(panel, at(x, 0.0, -12.2));
    }
}
