//! One long rail with balusters through all depths.

use super::column::baluster;
use super::prelude::*;
use std::f32::consts::TAU;

const END: f32 = -15.0;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.30, 0.30, 0.32),
            horizon: vec3(0.30, 0.29, 0.29),
            ground: vec3(0.17, 0.13, 0.10),
            softbox: 0.8,
        },
        focus_m: 2.0,
        occlusion_m: 0.7,
        ..Stage::default()
    };
    stage.sun(vec3(3.4, 2.8, 2.0), vec3(-0.72, -0.56, -0.36), 0.012);
    rail(&mut stage);
    corridor(&mut stage);
    stage.camera("along", vec3(0.05, 1.24, 0.0), vec3(-0.10, 0.92, -3.0), 46.0, 0.05);
    stage.camera("beside", vec3(0.75, 1.0, -1.2), vec3(-0.9, 0.75, -4.5), 48.0, 0.1);
    stage
}

fn rail(stage: &mut Stage) {
    let wood = stage.jpeg(patterns::wood(768, 3, rgb(0x9a5a30), rgb(0x4a2412), 4), 82);
    let wood = stage.matte("rail", wood, 0.3);
    // A moulded section swept along the corridor.
    let section = |u: f32| {
        let (sin, cos) = (u * TAU).sin_cos();
        let lip = 1.0 + 0.16 * (3.0 * u * TAU).cos();
        vec2(0.036 * cos * lip, 0.030 * sin + 0.008 * (2.0 * u * TAU).cos())
    };
    let handle = Shape::surface(30, 150, |u, v| {
        let z = 0.4 + (END - 0.4) * (0.15 * v + 0.85 * v * v);
        (section(u) + vec2(-0.30, 0.985)).extend(z)
    });
    let handle = handle
        .flipped_if(|c| (c.position.x + 0.30) * c.normal.x + (c.position.y - 0.985) * c.normal.y < 0.0)
        .mapped(|c| vec2(c.position.z * 1.1, c.uv.x * 0.33));
    stage.place(handle, wood);
    let base = Shape::cuboid(vec3(-0.30, 0.13, (0.4 + END) * 0.5), vec3(0.11, 0.06, 0.4 - END), 0.12);
    stage.place(base, wood);
    let paint = stage.material(Material {
        name: "paint",
        color: vec3(0.72, 0.70, 0.64),
        roughness: 0.35,
        ..Material::default()
    });
    let post = stage.mesh(baluster(24), paint);
    let far = stage.mesh(baluster(16), paint);
    let scale = Mat4::from_scale(vec3(0.72, 1.19, 0.72));
    stage.node(far, at(-0.30, 0.155, -6.02) * scale);
    for k in 0..104 {
        let z = 0.05 - 0.145 * k as f32;
        if k % 12 != 6 && z > END {
            stage.node(if z > -5.0 { post } else { far }, at(-0.30, 0.155, z) * scale);
        }
    }
    // Newels with finials.
    let newel = Shape::cuboid(vec3(0.0, 0.5, 0.0), vec3(0.10, 1.0, 0.10), 0.1).mapped(|c| vec2(c.uv.y, c.uv.x));
    let newel = stage.mesh(newel, wood);
    let finial = stage.mesh(Shape::sphere(0.058, 24).mapped(|c| c.uv * 0.4), wood);
    let mut z = -0.9;
    while z > END {
        stage.node(newel, at(-0.30, 0.0, z));
        stage.node(finial, at(-0.30, 1.085, z));
        z -= 0.145 * 12.0;
    }
}

fn corridor(stage: &mut Stage) {
    let parquet = stage.jpeg(patterns::parquet(1024, 8, 6), 78);
    let parquet = stage.matte("parquet", parquet, 0.4);
    let floor =
        Shape::surface(56, 170, |u, v| vec3(-1.7 + 4.2 * u, 0.0, 0.8 + (END - 0.8) * (0.45 * v + 0.55 * v * v)));
    let floor = floor.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z) / 1.3);
    stage.place(floor, parquet);
    let carpet = stage.jpeg(patterns::kilim(768, 12), 80);
    let carpet = stage.matte("carpet", carpet, 0.95);
    let runner =
        Shape::surface(20, 130, |u, v| vec3(0.05 + 1.05 * u, 0.012, 0.8 + (END + 0.6) * (0.45 * v + 0.55 * v * v)));
    stage.place(runner.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.uv.x, c.position.z / 1.05)), carpet);
    let paper = stage.jpeg(patterns::damask(768, 4, rgb(0x2f4a44), rgb(0xb9a06a), rgb(0xe2d6b4)), 80);
    let paper = stage.matte("wallpaper", paper, 0.85);
    let brick = stage.jpeg(patterns::brick(640, ivec2(5, 14), rgb(0xa4604a), rgb(0xb8b0a2), 23), 78);
    let brick = stage.matte("brick", brick, 0.9);
    let left = Shape::surface(120, 22, |u, v| vec3(-1.7, 3.0 - 3.0 * v, 0.8 + (END - 0.8) * u))
        .flipped_if(|c| c.normal.x < 0.0)
        .mapped(|c| vec2(-c.position.z, -c.position.y) / 1.25);
    stage.place(left, paper);
    let panels: Vec<Shape> = (0..18)
        .map(|k| Shape::cuboid(vec3(-1.685, 0.45, 0.3 - 0.86 * k as f32), vec3(0.05, 0.62, 0.66), 0.2))
        .collect();
    let wood = stage.matte("wainscot", 0, 0.45);
    for panel in &panels {
        stage.place(panel.clone(), wood);
    }
    stage.place(Shape::cuboid(vec3(-1.67, 0.86, -7.1), vec3(0.07, 0.05, 15.8), 0.2), wood);
    let end = Shape::surface(44, 32, |u, v| vec3(-1.7 + 4.2 * u, 3.0 - 3.0 * v, END))
        .flipped_if(|c| c.normal.z < 0.0)
        .mapped(|c| vec2(c.position.x, -c.position.y) / 1.1);
    stage.place(end, brick);
    // The window wall: piers and mullions that cut the sun into panes.
    for k in 0..9 {
        let z = 0.6 - 1.95 * k as f32;
        stage.place(Shape::cuboid(vec3(2.5, 1.5, z), vec3(0.25, 3.0, 0.75), 0.3).mapped(|c| c.uv / 1.1), brick);
        for bar in 1..3 {
            let centre = vec3(2.5, 1.5, z - 0.375 - 0.4 * bar as f32);
            stage.place(Shape::cuboid(centre, vec3(0.05, 3.0, 0.05), 0.5), wood);
        }
    }
    for y in [0.2, 1.1, 1.8, 2.95] {
        stage.place(Shape::cuboid(vec3(2.5, y, -7.0), vec3(0.08, if y < 0.5 { 0.4 } else { 0.06 }, 16.0), 0.5), wood);
    }
    let ceiling = Shape::cuboid(vec3(0.4, 3.05, -7.0), vec3(4.6, 0.1, 16.4), 0.4);
    stage.place(ceiling.mapped(|c| vec2(c.uv.y, c.uv.x) / 1.3), parquet);
    for k in 0..12 {
        stage.place(Shape::cuboid(vec3(0.4, 2.93, -0.4 - 1.3 * k as f32), vec3(4.3, 0.16, 0.14), 0.2), wood);
    }
    let pictures = stage.jpeg(super::labels::poster(), 82);
    let ceiling = Shape::cuboid(vec3(0.4, 3.05, -7.0), vec3(4.6, 0.1, 16.4), 0.4);
    stage.place(ceiling.mapped(|c| vec2(c.uv.y, c.uv.x) / 1.3), parquet);
    for k in 0..12 {
        stage.place(Shape::cuboid(vec3(0.4, 2.93, -0.4 - 1.3 * k as f32), vec3(4.3, 0.16, 0.14), 0.2), wood);
    }
    let pictures = stage.matte("picture", pictures, 0.6);
    for (k, z) in [-2.2f32, -4.1, -6.2, -8.6, -11.2].into_iter().enumerate() {
        let height = 0.78 + 0.1 * (k % 2) as f32;
        let sheet = Shape::surface(6, 8, |u, v| vec3(-1.66, 1.95 - height * v, z - 0.3 + 0.6 * (1.0 - u)));
        stage.place(sheet.flipped_if(|c| c.normal.x < 0.0), pictures);
        for (dy, dz, sy, sz) in [
            (0.03, 0.0, 0.06, 0.72),
            (-height - 0.03, 0.0, 0.06, 0.72),
            (-height * 0.5, 0.33, height, 0.06),
            (-height * 0.5, -0.33, height, 0.06),
        ] {
            stage.place(Shape::cuboid(vec3(-1.67, 1.95 + dy, z + dz), vec3(0.06, sy, sz), 0.5), wood);
        }
    }
    let door = Shape::surface(10, 20, |u, v| vec3(0.1 + 0.95 * u, 2.15 - 2.15 * v, END + 0.03));
    stage.place(door.flipped_if(|c| c.normal.z < 0.0).mapped(|c| vec2(c.uv.y * 2.0, c.uv.x)), wood);
    let crest = Shape::surface(10, 12, |u, v| vec3(-1.25 + 0.9 * u, 2.2 - 1.2 * v, END + 0.03));
    stage.place(crest.flipped_if(|c| c.normal.z < 0.0), pictures);
}
