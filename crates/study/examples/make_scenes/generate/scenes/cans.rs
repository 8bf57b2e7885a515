//! Rows of labelled cans on a wooden counter before a brick wall: near focus.

use super::labels;
use super::prelude::*;

const RADIUS: f32 = 0.037;
const HEIGHT: f32 = 0.112;

/// The scene.
pub fn stage() -> Stage {
    let mut stage = Stage {
        sky: Sky {
            zenith: vec3(0.15, 0.16, 0.18),
            horizon: vec3(0.16, 0.16, 0.17),
            ground: vec3(0.10, 0.07, 0.05),
            softbox: 2.0,
        },
        focus_m: 0.46,
        occlusion_m: 0.22,
        ..Stage::default()
    };
    stage.sun(vec3(3.1, 2.6, 2.0), vec3(0.72, -0.62, -0.42), 0.07);
    room(&mut stage);
    lamps(&mut stage);
    cans(&mut stage);
    fruit(&mut stage);
    stage.camera("counter", vec3(0.0, 0.185, 0.45), vec3(0.03, 0.088, -0.25), 41.0, 0.05);
    stage.camera("low", vec3(0.32, 0.075, 0.35), vec3(-0.22, 0.09, -1.4), 44.0, 0.05);
    stage.camera("above", vec3(-0.45, 0.62, 0.30), vec3(0.1, 0.0, -0.75), 42.0, 0.1);
    stage
}

fn room(stage: &mut Stage) {
    let planks = patterns::wood(1536, 8, rgb(0xcda070), rgb(0x96633a), 11);
    let wood = stage.jpeg(planks, 82);
    let wood = stage.matte("counter", wood, 0.55);
    // Fine cells near the camera, where contact shadows are seen closely.
    let top = Shape::surface(88, 110, |u, v| {
        let s = 2.0 * u - 1.0;
        vec3(1.4 * (0.45 * s + 0.55 * s * s * s), 0.0, 0.55 - 3.45 * (0.35 * v + 0.65 * v * v))
    })
    .flipped_if(|c| c.normal.y < 0.0)
    .mapped(|c| vec2(c.position.z, c.position.x) / 0.95);
    stage.place(top, wood);
    let front = Shape::cuboid(vec3(0.0, -0.041, -1.175), vec3(2.8, 0.08, 3.45), 0.5);
    stage.place(front, wood);

    let bricks = patterns::brick(1024, ivec2(6, 18), rgb(0xa4553a), rgb(0xb3aa9c), 3);
    let bricks = stage.jpeg(bricks, 80);
    let bricks = stage.matte("wall", bricks, 0.9);
    let wall = Shape::surface(72, 44, |u, v| vec3((u - 0.5) * 9.0, 2.4 - 3.3 * v, -3.35))
        .flipped_if(|c| c.normal.z < 0.0)
        .mapped(|c| vec2(c.position.x, -c.position.y) / 1.35);
    stage.place(wall, bricks);
    let floor = Shape::surface(20, 20, |u, v| vec3((u - 0.5) * 8.0, -0.9, 1.0 - 5.0 * v))
        .flipped_if(|c| c.normal.y < 0.0)
        .mapped(|c| vec2(c.position.x, c.position.z) / 1.6);
    stage.place(floor, wood);

    // Shelves with their own jars, and a poster.
    for y in [0.36, 0.70] {
        let board = Shape::cuboid(vec3(0.62, y, -3.24), vec3(1.5, 0.028, 0.2), 0.06);
        stage.place(board, wood);
    }
    let poster = stage.jpeg(labels::poster(), 84);
    let poster = stage.matte("poster", poster, 0.7);
    let sheet =
        Shape::surface(10, 14, |u, v| vec3(-1.02 + 0.62 * u, 0.98 - 0.82 * v, -3.335)).flipped_if(|c| c.normal.z < 0.0);
    stage.place(sheet, poster);
}

fn lamps(stage: &mut Stage) {
    let shade = stage.material(Material {
        name: "enamel",
        color: vec3(0.03, 0.10, 0.09),
        roughness: 0.25,
        double_sided: true,
        ..Material::default()
    });
    let bulb = stage.material(Material {
        name: "bulb",
        color: Vec3::ZERO,
        emissive: vec3(30.0, 19.0, 9.0),
        ..Material::default()
    });
    let profile =
        [vec2(0.16, 0.0), vec2(0.15, 0.02), vec2(0.06, 0.10), vec2(0.03, 0.16), vec2(0.006, 0.17), vec2(0.004, 1.6)];
    let shade = stage.mesh(Shape::lathe(&profile, 64), shade);
    let bulb = stage.mesh(Shape::sphere(0.032, 12), bulb);
    for (x, z) in [(-0.70, -1.9), (0.20, -2.6), (0.92, -2.1)] {
        stage.node(shade, at(x, 0.56, z));
        stage.node(bulb, at(x, 0.585, z));
        stage.lamp(vec3(0.20, 0.125, 0.065), vec3(x, 0.52, z), 0.03);
    }
}

/// The body that a label wraps, and its seams.
fn body(height: f32, radius: f32, turns: usize, rows: usize) -> Shape {
    let (lo, hi) = (0.0065, height - 0.0065);
    let profile: Vec<_> = (0..=rows).map(|k| vec2(radius, lo + (hi - lo) * k as f32 / rows as f32)).collect();
    Shape::lathe(&profile, turns)
}

fn lid(height: f32, r: f32, turns: usize, beads: usize) -> Shape {
    let seam = |y: f32, up: f32| {
        [(0.0, 0.0), (0.0016, 0.0004), (0.0019, 0.0014), (0.0019, 0.0034), (0.0012, 0.0044), (-0.0002, 0.0047)]
            .map(|(dr, dy)| vec2(r + dr, y + up * dy))
    };
    let mut profile = vec![vec2(r, height - 0.0068)];
    profile.extend(seam(height - 0.0058, 1.0));
    profile.extend([vec2(r - 0.0012, height - 0.0012), vec2(r - 0.0016, height - 0.005)]);
    // Beads pressed into the panel.
    for k in 0..beads {
        let t = k as f32 / (beads - 1) as f32;
        let bead = 0.0009 * (t * 26.0).sin().max(-0.4) * f32::from(t < 0.62);
        profile.push(vec2((r - 0.003) * (1.0 - t) + 1e-4, height - 0.0048 + bead));
    }
    let mut shape = Shape::lathe(&profile, turns);
    // The score line's tab: a ring and a tongue.
    let ring = Shape::torus(0.0075, 0.0013, turns / 2, 6).moved(at(0.0, height - 0.0022, 0.013));
    let tongue = Shape::cuboid(vec3(0.0, height - 0.0025, 0.0), vec3(0.008, 0.0016, 0.016), 1.0);
    let rivet = Shape::sphere(0.0026, 5).moved(at(0.0, height - 0.0022, -0.005));
    for part in [ring, tongue, rivet] {
        shape.append(&part);
    }
    let mut foot: Vec<_> = seam(0.0064, -1.0).into_iter().rev().collect();
    foot.insert(0, vec2(0.001, 0.0025));
    foot.push(vec2(r, 0.0066));
    shape.append(&Shape::lathe(&foot, turns));
    shape
}

fn cans(stage: &mut Stage) {
    let tin = stage.material(Material {
        name: "tin",
        color: vec3(0.80, 0.79, 0.76),
        metallic: 1.0,
        roughness: 0.24,
        ..Material::default()
    });
    let labels: Vec<usize> = labels::all()
        .into_iter()
        .map(|canvas| {
            let texture = stage.png(canvas);
            stage.matte("label", texture, 0.33)
        })
        .collect();
    // Near cans have finer meshes, and labels lit where they stand.
    let sizes = [(HEIGHT, RADIUS), (0.046, 0.043)];
    let near = sizes.map(|(h, r)| (body(h, r, 48, 6), stage.mesh(lid(h, r, 56, 22), tin)));
    let far_lids = sizes.map(|(h, r)| stage.mesh(lid(h, r, 32, 12), tin));
    let far_bodies: Vec<[usize; 2]> =
        labels.iter().map(|&label| sizes.map(|(h, r)| stage.mesh(body(h, r, 40, 3), label))).collect();
    let mut rng = Rng::new(5);
    for (x, y, z, kind, label) in arrangement(&mut rng) {
        let wanted = if z > -0.2 { 0.12 } else { rng.range(-0.55, 0.55) - 0.25 * x };
        let placement = at(x, y, z) * turn(std::f32::consts::PI + wanted);
        let (body, lid) = if z > -1.3 {
            (stage.mesh(near[kind].0.clone(), labels[label]), near[kind].1)
        } else {
            (far_bodies[label][kind], far_lids[kind])
        };
        stage.node(body, placement);
        stage.node(lid, placement * turn(rng.range(0.0, 6.0)));
    }
}

/// Position, kind (0 tall, 1 flat) and label of every can.
fn arrangement(rng: &mut Rng) -> Vec<(f32, f32, f32, usize, usize)> {
    let mut cans = vec![(-0.045, 0.0, -0.005, 0, 0), (0.135, 0.0, -0.17, 0, 1), (-0.215, 0.0, -0.22, 0, 5)];
    for k in (0..3).rev() {
        cans.push((0.27, 0.0462 * k as f32, -0.36, 1, [2, 4, 3][k]));
    }
    for row in 0..8 {
        let z = -0.52 - 0.29 * row as f32;
        let reach = 0.30 + 0.10 * row as f32;
        let mut x = -reach + rng.range(0.0, 0.1);
        while x < reach {
            let (label, dz) = (rng.index(6), rng.range(-0.06, 0.06));
            if rng.unit() < 0.80 {
                // From the top, since a shared mesh is lit by its first place.
                if row > 2 && rng.unit() < 0.22 {
                    cans.push((x + 0.004, HEIGHT, z + dz, 0, rng.index(6)));
                }
                cans.push((x, 0.0, z + dz, 0, label));
            } else {
                for level in (0..1 + rng.index(3)).rev() {
                    cans.push((x, 0.0462 * level as f32, z + dz, 1, rng.index(6)));
                }
            }
            x += rng.range(0.12, 0.24);
        }
    }
    for (shelf, y) in [0.374, 0.714].into_iter().enumerate() {
        for k in 0..11 {
            let x = -0.05 + 0.128 * k as f32 + rng.range(-0.01, 0.01);
            cans.push((x, y, -3.24, 0, (k * 5 + 2 * shelf) % 6));
        }
    }
    cans
}

fn fruit(stage: &mut Stage) {
    let peel = |base: u32, blush: u32, seed: u32| {
        let pore = move |uv: Vec2| smoothstep(0.25, 0.05, cells(uv, ivec2(60, 30), seed).0);
        Canvas::paint(512, 256, move |uv| {
            let tone = fbm(uv, ivec2(4, 3), 4, seed);
            rgb(base).lerp(rgb(blush), smoothstep(0.4, 0.75, tone)) * (1.0 - 0.25 * pore(uv))
        })
        .emboss(0.8, move |uv| -pore(uv))
    };
    let (orange, lemon) = (peel(0xe8801c, 0xd8561a, 4), peel(0xf6d434, 0xeebb2c, 9));
    let (orange, lemon) = (stage.jpeg(orange, 85), stage.jpeg(lemon, 85));
    let (orange, lemon) = (stage.matte("orange", orange, 0.45), stage.matte("lemon", lemon, 0.4));
    let round = Shape::sphere(0.036, 22);
    let long = Shape::lathe(
        &(0..=40)
            .map(|k| {
                let t = k as f32 / 40.0 * std::f32::consts::PI;
                let tip = 0.008 * (t.cos().abs()).powi(12) * t.cos().signum();
                vec2(0.026 * t.sin() + 1e-5, -0.034 * t.cos() - tip)
            })
            .collect::<Vec<_>>(),
        32,
    );
    for (x, z) in [(0.02, -0.30), (0.085, -0.335), (-0.42, -0.72), (0.45, -0.62), (0.51, -0.66)] {
        stage.place(round.clone().moved(at(x, 0.0352, z) * turn(z * 9.0)), orange);
    }
    for (x, z, tilt) in [(0.07, -0.05, 0.6), (-0.35, -0.66, 1.1), (-0.10, -0.30, 4.0)] {
        let lying = at(x, 0.0258, z) * turn(tilt) * Mat4::from_rotation_z(1.5);
        stage.place(long.clone().moved(lying), lemon);
    }
}
