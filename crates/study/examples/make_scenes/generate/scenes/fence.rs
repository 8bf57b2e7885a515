//! A yard at dusk with what is hard for a blur: a wire fence cut out by opacity that runs
//! through the focus, wires a millimetre thick at all depths, lamps half behind a near post.

use super::prelude::*;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.10, 0.13, 0.22),
            horizon: vec3(0.30, 0.22, 0.20),
            ground: vec3(0.10, 0.08, 0.07),
            softbox: 0.0,
        },
        focus_m: 1.6,
        occlusion_m: 0.6,
        ..Stage::default()
    };
    stage.sun(vec3(1.5, 1.1, 0.8), vec3(0.45, -0.5, -0.74), 0.03);
    yard(&mut stage);
    fence(&mut stage);
    wires(&mut stage);
    lamps(&mut stage);
    stage.camera("gate", vec3(0.0, 1.25, 0.0), vec3(0.03, 1.18, -3.0), 44.0, 0.05);
    stage.camera("wires", vec3(0.35, 1.45, -0.1), vec3(0.1, 1.55, -3.0), 40.0, 0.05);
    stage
}

fn yard(stage: &mut Stage) {
    let cobbles = stage.jpeg(patterns::cobbles(768, ivec2(10, 14), 9), 78);
    let cobbles = stage.matte("cobbles", cobbles, 0.7);
    let floor = Shape::surface(60, 80, |u, v| vec3(-5.0 + 10.0 * u, 0.0, 1.0 - 9.0 * v));
    stage.place(floor.flipped_if(|c| c.normal.y < 0.0).mapped(|c| vec2(c.position.x, c.position.z) / 1.6), cobbles);
    let brick = stage.jpeg(patterns::brick(640, ivec2(5, 14), rgb(0xa4604a), rgb(0xb8b0a2), 41), 78);
    let brick = stage.matte("brick", brick, 0.9);
    let wall = Shape::surface(70, 40, |u, v| vec3(-5.0 + 10.0 * u, 4.0 - 4.0 * v, -6.5));
    stage.place(wall.flipped_if(|c| c.normal.z < 0.0).mapped(|c| vec2(c.position.x, -c.position.y) / 1.2), brick);
    let wood = stage.jpeg(patterns::wood(512, 3, rgb(0xa87a48), rgb(0x55351c), 6), 82);
    let wood = stage.matte("crate", wood, 0.7);
    for (x, y, z, size) in [
        (-1.25, 0.4, -4.6, 0.8),
        (-0.62, 0.3, -3.6, 0.6),
        (-1.15, 1.1, -4.7, 0.6),
        (1.35, 0.45, -5.2, 0.9),
        (0.75, 0.275, -3.2, 0.55),
    ] {
        let shape = Shape::cuboid(vec3(0.0, 0.0, 0.0), Vec3::splat(size), 0.1);
        stage.place(shape.mapped(|c| c.uv / 0.9).moved(at(x, y, z) * turn(2.0 * x + z)), wood);
    }
    let paint = stage.jpeg(patterns::star_tiles(512, 6, 3), 84);
    let paint = stage.matte("ball", paint, 0.4);
    for (x, y, z, radius) in [(0.02, 1.02, -1.62, 0.13), (0.72, 0.72, -3.2, 0.17), (-0.6, 0.78, -3.6, 0.18)] {
        stage.place(Shape::sphere(radius, 28).mapped(|c| c.uv * vec2(4.0, 2.0)).moved(at(x, y, z)), paint);
    }
    let post = stage.matte("pedestal", 0, 0.8);
    stage.place(Shape::cuboid(vec3(0.02, 0.44, -1.62), vec3(0.2, 0.88, 0.2), 0.08), post);
}

/// A mesh of 45 mm in wire of 3 mm, from half a metre before the eye to four behind it.
fn fence(stage: &mut Stage) {
    const CELL_M: f32 = 0.045;
    let distance = |uv: Vec2| {
        let from_line = |t: f32| (t - t.round()).abs();
        from_line(uv.x + uv.y).min(from_line(uv.x - uv.y)) * CELL_M * std::f32::consts::FRAC_1_SQRT_2
    };
    let wire = move |uv: Vec2| 1.0 - smoothstep(0.0013, 0.0017, distance(uv));
    // A cell of the mesh, painted with a colour that does not end where the wire does.
    let canvas = Canvas::paint(256, 256, move |uv| {
        let shine = 1.0 - distance(uv) / 0.003;
        rgb(0x5d6a62) * (0.6 + 0.4 * shine.clamp(0.0, 1.0))
    });
    let texture = stage.png(canvas.covered(wire));
    let material = stage.material(Material {
        name: "fence",
        texture: Some(texture),
        roughness: 0.5,
        metallic: 0.2,
        double_sided: true,
        cut: true,
        ..Material::default()
    });
    let from = vec3(-0.62, 0.0, -0.55);
    let along = vec3(1.9, 0.0, -3.6);
    let mesh = Shape::surface(120, 40, |u, v| from + along * u + Vec3::Y * (1.34 * (1.0 - v)));
    let length = along.length();
    stage.place(mesh.mapped(|c| vec2((c.position - from).with_y(0.0).length(), c.position.y) / CELL_M), material);
    let iron =
        stage.material(Material { name: "iron", color: vec3(0.10, 0.11, 0.10), roughness: 0.5, ..Material::default() });
    for k in 0..5 {
        let foot = from + along * (0.04 + 0.23 * k as f32);
        stage.place(Shape::tube(&[(foot, 0.018), (foot + 1.38 * Vec3::Y, 0.018)], 14), iron);
    }
    let rail = |k: usize| (from + along * (k as f32 / 40.0) + 1.345 * Vec3::Y, 0.009);
    stage.place(Shape::tube(&(0..=40).map(rail).collect::<Vec<_>>(), 10), iron);
    assert!(length > 4.0, "the fence reaches past the focus on both sides");
}

/// Wires a millimetre thick from near to far, with sag.
fn wires(stage: &mut Stage) {
    let steel = stage.material(Material {
        name: "steel",
        color: vec3(0.03, 0.03, 0.035),
        roughness: 0.4,
        ..Material::default()
    });
    for k in 0..7 {
        let x = k as f32 / 6.0;
        let (from, to) =
            (vec3(-0.9 + 0.5 * x, 1.50 + 0.05 * x, -0.5 - 0.35 * x), vec3(1.7 - 0.4 * x, 1.95 + 0.3 * x, -5.5));
        let at_step = |i: usize| {
            let t = i as f32 / 48.0;
            (from.lerp(to, t) - Vec3::Y * (0.16 * t * (1.0 - t)), 0.0005 + 0.0003 * (k % 3) as f32)
        };
        stage.place(Shape::tube(&(0..=48).map(at_step).collect::<Vec<_>>(), 6), steel);
    }
}

/// Lamps far behind a post that is blurred before them.
fn lamps(stage: &mut Stage) {
    let post =
        stage.material(Material { name: "post", color: vec3(0.16, 0.20, 0.14), roughness: 0.7, ..Material::default() });
    stage.place(Shape::tube(&[(vec3(0.235, 0.0, -0.52), 0.016), (vec3(0.235, 2.2, -0.52), 0.016)], 20), post);
    for (colour, x, y, z, radius) in [
        (vec3(60.0, 42.0, 20.0), 1.98, 1.72, -4.6, 0.045),
        (vec3(60.0, 42.0, 20.0), 2.55, 1.98, -5.8, 0.045),
        (vec3(24.0, 36.0, 60.0), 1.86, 1.36, -4.2, 0.035),
        (vec3(60.0, 14.0, 10.0), -1.35, 2.05, -6.2, 0.05),
        (vec3(60.0, 42.0, 20.0), -0.30, 2.05, -6.2, 0.05),
    ] {
        let light =
            stage.material(Material { name: "lamp", color: Vec3::ZERO, emissive: colour, ..Material::default() });
        stage.place(Shape::sphere(radius, 12).moved(at(x, y, z)), light);
        stage.lamp(colour * radius * radius * 3.0, vec3(x, y, z), radius);
    }
}
