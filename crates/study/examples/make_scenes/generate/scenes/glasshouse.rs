//! A glasshouse at noon with all that covers a part of what lies behind it: panes of clear and
//! tinted glass, bottles, smoke, and leaves with soft edges, from half a metre to seven.
//!
//! Few meshes stand often: the file is small.

use super::prelude::*;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.45, 0.60, 0.85),
            horizon: vec3(0.75, 0.75, 0.70),
            ground: vec3(0.22, 0.20, 0.16),
            softbox: 1.5,
        },
        focus_m: 1.9,
        occlusion_m: 0.5,
        ..Stage::default()
    };
    stage.sun(vec3(2.2, 2.0, 1.7), vec3(-0.5, -0.8, -0.35), 0.02);
    house(&mut stage);
    panes(&mut stage);
    bottles(&mut stage);
    leaves(&mut stage);
    smoke(&mut stage);
    stage.camera("bench", vec3(0.0, 1.30, 0.0), vec3(0.05, 1.18, -3.0), 44.0, 0.05);
    stage.camera("through", vec3(-0.45, 1.45, 0.35), vec3(0.15, 1.15, -3.0), 40.0, 0.05);
    stage
}

fn house(stage: &mut Stage) {
    let tiles = stage.jpeg(patterns::star_tiles(192, 4, 3), 70);
    let tiles = stage.matte("floor", tiles, 0.6);
    let floor = Shape::surface(12, 16, |u, v| vec3(-4.0 + 8.0 * u, 0.0, 1.0 - 9.0 * v));
    stage.place(floor.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z)), tiles);
    let brick = stage.jpeg(patterns::brick(192, ivec2(4, 12), rgb(0xb06a50), rgb(0xc8c0b0), 41), 70);
    let brick = stage.matte("wall", brick, 0.9);
    let wall = Shape::surface(12, 8, |u, v| vec3(-4.0 + 8.0 * u, 4.0 - 4.0 * v, -7.0));
    stage.place(wall.flipped_if(|c| c.normal.z < 0.0).mapped(|c| vec2(c.position.x, -c.position.y)), brick);
    let wood = stage.material(Material { name: "bench", color: vec3(0.45, 0.30, 0.17), ..Material::default() });
    stage.place(Shape::cuboid(vec3(0.0, 0.86, -2.1), vec3(2.2, 0.05, 1.5), 0.25), wood);
    for x in [-1.0, 1.0] {
        stage.place(Shape::cuboid(vec3(x, 0.42, -2.1), vec3(0.08, 0.83, 1.3), 0.2), wood);
    }
}

/// Panes in white bars: one before the focus, some behind it, two of them behind one another.
fn panes(stage: &mut Stage) {
    let pane = |stage: &mut Stage, name, color, opacity| {
        stage.material(Material {
            name,
            color,
            roughness: 0.1,
            blended: Some(opacity),
            double_sided: true,
            ..Material::default()
        })
    };
    let clear = pane(stage, "clear pane", vec3(0.75, 0.85, 0.80), 0.18);
    let green = pane(stage, "green pane", vec3(0.10, 0.45, 0.25), 0.45);
    let amber = pane(stage, "amber pane", vec3(0.75, 0.40, 0.06), 0.55);
    let bar = stage.material(Material { name: "bar", color: Vec3::splat(0.75), ..Material::default() });
    let bars = {
        let mut bars = Shape::default();
        for x in [-0.5, 0.5] {
            bars.append(&Shape::cuboid(vec3(x, 0.0, 0.0), vec3(0.03, 1.03, 0.03), 1.1));
            bars.append(&Shape::cuboid(vec3(0.0, x, 0.0), vec3(1.03, 0.03, 0.03), 1.1));
        }
        bars
    };
    let bars = stage.mesh(bars, bar);
    let sheet = || Shape::surface(1, 1, |u, v| vec3(u - 0.5, 0.5 - v, 0.0)).flipped_if(|c| c.normal.z < 0.0);
    let sheets = [clear, green, amber].map(|material| stage.mesh(sheet(), material));
    for (kind, x, y, z, angle, size) in [
        (0, -0.42, 1.42, -0.75, 0.25, 0.42),
        (1, 0.95, 1.35, -3.1, -0.3, 0.9),
        (0, -0.15, 1.5, -3.6, 0.1, 1.0),
        (2, -1.15, 1.4, -3.2, 0.4, 0.8),
        (0, 0.55, 1.5, -4.8, 0.0, 1.5),
        (1, -1.3, 1.6, -5.6, 0.2, 1.3),
        (2, 2.1, 1.7, -5.8, -0.2, 1.3),
    ] {
        let placed = at(x, y, z) * turn(angle) * Mat4::from_scale(Vec3::splat(size));
        stage.node(sheets[kind], placed);
        stage.node(bars, placed);
    }
}

/// Bottles of clear and of green glass on the bench, each with its back behind its front.
fn bottles(stage: &mut Stage) {
    let profile = [
        (0.0, 0.0),
        (0.036, 0.0),
        (0.040, 0.006),
        (0.040, 0.15),
        (0.034, 0.175),
        (0.016, 0.20),
        (0.0135, 0.215),
        (0.0135, 0.27),
        (0.016, 0.272),
        (0.016, 0.285),
    ];
    let profile: Vec<Vec2> = profile.iter().map(|&(radius, height)| vec2(radius, height)).collect();
    let kinds =
        [("clear bottle", vec3(0.92, 0.97, 0.95)), ("green bottle", vec3(0.25, 0.62, 0.32))].map(|(name, color)| {
            let glass = stage.material(Material {
                name,
                color,
                roughness: 0.12,
                transmission: 0.9,
                double_sided: true,
                ..Material::default()
            });
            stage.mesh(Shape::lathe(&profile, 28), glass)
        });
    for (kind, x, z, size) in [
        (0, 0.08, -1.9, 1.25),
        (1, 0.26, -1.82, 1.1),
        (1, -0.25, -2.3, 1.2),
        (0, -0.12, -1.55, 0.8),
        (0, 0.50, -2.5, 1.3),
        (1, -0.62, -2.1, 1.0),
        (0, -0.48, -1.6, 0.9),
        (1, 0.72, -2.2, 1.2),
        (0, 0.34, -1.5, 0.7),
    ] {
        stage.node(kinds[kind], at(x, 0.886, z) * Mat4::from_scale(Vec3::splat(size)));
    }
}

/// Branches of leaves whose edges fade out.
fn leaves(stage: &mut Stage) {
    let outline = |uv: Vec2| {
        let along = uv.y.clamp(0.0, 1.0);
        let width = 0.44 * (std::f32::consts::PI * along.powf(0.8)).sin().max(0.0);
        1.0 - smoothstep(width - 0.14, width + 0.02, (uv.x - 0.5).abs())
    };
    let paint = |uv: Vec2| {
        let vein = (uv.x - 0.5).abs().min((((uv.x - 0.5).abs() + uv.y) * 7.0).fract() * 0.08 + 0.02);
        rgb(0x3f8a35) * (0.75 + 4.0 * vein.min(0.12))
    };
    let texture = stage.png(Canvas::paint(48, 64, paint).covered(outline));
    let leaf = stage.material(Material {
        name: "leaf",
        texture: Some(texture),
        roughness: 0.6,
        blended: Some(1.0),
        double_sided: true,
        ..Material::default()
    });
    let mut rng = Rng::new(12);
    let mut branch = Shape::default();
    for k in 0..16 {
        let (up, around) = (0.04 * k as f32, 2.4 * k as f32);
        let (length, droop) = (rng.range(0.14, 0.22), rng.range(0.2, 0.7));
        let blade = Shape::surface(2, 6, |u, v| {
            let out = length * v;
            vec3(0.42 * length * (u - 0.5), out * (0.6 - droop * v), out * 0.85)
        });
        branch.append(&blade.moved(at(0.0, up, 0.0) * turn(around)));
    }
    let branch = stage.mesh(branch, leaf);
    for _ in 0..90 {
        let depth = 2.6 + 4.0 * rng.unit();
        let x = rng.range(-0.55, 0.55) * depth;
        let placed = at(x, rng.range(0.0, 1.2), -depth) * turn(rng.range(0.0, 6.3));
        stage.node(branch, placed * Mat4::from_scale(Vec3::splat(rng.range(0.8, 1.5))));
    }
    // One hangs into the picture right before the lens.
    for (x, y, z, size) in [(0.30, 1.10, -0.62, 0.5), (0.36, 1.36, -0.9, 0.6), (-0.36, 0.98, -1.0, 0.6)] {
        stage.node(branch, at(x, y, z) * turn(9.0 * x) * Mat4::from_scale(Vec3::splat(size)));
    }
}

/// Smoke over a small stove: cards behind one another.
fn smoke(stage: &mut Stage) {
    let density = |uv: Vec2| {
        let from_axis = 1.0 - smoothstep(0.05, 0.48, (uv.x - 0.5).abs());
        let ends = smoothstep(0.0, 0.3, uv.y) * (1.0 - smoothstep(0.7, 1.0, uv.y));
        0.75 * from_axis * ends * smoothstep(0.25, 0.8, fbm(uv, ivec2(3, 4), 4, 8))
    };
    let texture = stage.png(Canvas::filled(64, 64, rgb(0xd8d8dc)).covered(density));
    let smoke = stage.material(Material {
        name: "smoke",
        texture: Some(texture),
        roughness: 1.0,
        blended: Some(1.0),
        double_sided: true,
        ..Material::default()
    });
    let card = Shape::surface(1, 1, |u, v| vec3(u - 0.5, 1.0 - v, 0.0)).flipped_if(|c| c.normal.z < 0.0);
    let card = stage.mesh(card, smoke);
    for (x, z, width, height, angle) in [
        (-0.55, -2.75, 0.5, 1.1, 0.2),
        (-0.48, -2.62, 0.4, 0.9, -0.5),
        (-0.62, -2.9, 0.6, 1.3, 0.6),
        (0.1, -1.2, 0.25, 0.5, 0.1),
    ] {
        stage.node(card, at(x, 0.88, z) * turn(angle) * Mat4::from_scale(vec3(width, height, 1.0)));
    }
    let iron =
        stage.material(Material { name: "stove", color: Vec3::splat(0.06), roughness: 0.5, ..Material::default() });
    stage.place(Shape::cuboid(vec3(-0.55, 0.93, -2.75), vec3(0.16, 0.09, 0.16), 0.1), iron);
}
