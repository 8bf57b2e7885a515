//! `defocus gauntlet`: scenes, what is measured on them, and how they are made smaller.

#[path = "../../../tests/common/mod.rs"]
mod common;

use defocus::gpu::Gpu;
use defocus::image::{ColorImage, Image};
use defocus::methods::{Accumulation, Method, Pinhole};
use defocus::view::{GpuScene, SurfaceOptions, View};
use defocus_study::gauntlet::{
    Bounds, DEFAULT_SIZE, FAMILIES, Figures, MethodFigures, Pattern, QuadSpec, Rules, SAME_SCENES_DB, SceneResult,
    SceneSpec, Which, counted_db, examine, family, family_of, figures, generate, known, known_bounds, named, ranking,
    scene_seed, shrink, size_of, statistics, truth,
};
use defocus_study::{DepthArgs, Source};
use glam::{UVec2, Vec3, uvec2};
use std::collections::BTreeMap;

/// Seeds tried of each family.
const SEEDS: u64 = 60;

fn every_scene() -> impl Iterator<Item = SceneSpec> {
    FAMILIES.iter().flat_map(|family| (0..SEEDS).map(|seed| generate(family, seed, DEFAULT_SIZE)))
}

/// A wall in focus, 2 m away, and a light before it.
fn wall_and_light() -> SceneSpec {
    let square = |half_m: f64, depth_m: f64, radiance: f32, light| QuadSpec {
        corners_m: [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, y]| [x * half_m, y * half_m, depth_m]),
        radiance: [radiance; 3],
        pattern: Pattern::Plain,
        light,
    };
    SceneSpec {
        name: "a wall and a light".into(),
        size_px: [64, 48],
        overscan_px: 4,
        fov_y_deg: 50.0,
        focus_m: 2.0,
        k_px: 8.0,
        sky: [0.0; 3],
        as_image: false,
        quads: vec![square(3.0, 2.0, 0.2, false), square(0.1, 1.0, 30.0, true)],
    }
}

#[test]
fn a_scene_is_the_same_whenever_it_is_made() {
    for family in FAMILIES {
        let [first, again, other] = [7, 7, 8].map(|seed| generate(family, seed, DEFAULT_SIZE));
        assert_eq!(first, again, "{}", family.name);
        assert_ne!(first.quads, other.quads, "{}", family.name);
    }
    let [one, two] = ["cards", "mixed"].map(|name| generate(family(name).expect("a family"), 7, DEFAULT_SIZE));
    assert_ne!(one.k_px, two.k_px, "families draw different numbers");
}

#[test]
fn names_lead_back_to_their_scenes() {
    for index in 0..FAMILIES.len() as u64 {
        let seed = scene_seed(3, index);
        let by_number = named(&format!("gauntlet:{seed}")).expect("a name").expect("a scene");
        assert_eq!(by_number, generate(family_of(seed), seed, DEFAULT_SIZE));
        assert_eq!(named(&by_number.name), Some(Ok(by_number)));
    }
    let run: Vec<_> = (0..FAMILIES.len() as u64).map(|i| family_of(scene_seed(9, i)).name).collect();
    assert!(FAMILIES.iter().all(|f| run.contains(&f.name)), "every family has its turn");
    assert_eq!(named("cans"), None);
    for wrong in ["gauntlet:", "gauntlet:x", "gauntlet:-1", "gauntlet:cards:", "gauntlet:1:cards", "gauntlet:fish:1"] {
        let error = named(wrong).expect("a name").expect_err(wrong).to_string();
        assert!(error.contains("give gauntlet:SEED") || error.contains("there are: specks_near"), "{error}");
    }
}

#[test]
fn scenes_are_within_their_ranges_and_read_back_as_they_are_written() {
    for spec in every_scene() {
        assert_eq!(spec.check(), Ok(()), "{}", spec.name);
        assert_eq!(SceneSpec::from_text(&spec.to_text()), Ok(spec.clone()), "{}", spec.name);
        let widest_px = spec.quads.iter().flat_map(|q| q.coc_px(&spec.lens())).fold(0.0, |m: f64, c| m.max(c.abs()));
        assert!(widest_px <= 160.0, "{}: a CoC of {widest_px} px", spec.name);
        assert!(!spec.quads.is_empty() && spec.quads.len() <= 400, "{}: {} quads", spec.name, spec.quads.len());
    }
}

/// The share of a family's scenes that have a property.
fn share(name: &str, has: impl Fn(&SceneSpec) -> bool) -> f64 {
    let family = family(name).expect("a family");
    (0..SEEDS).filter(|seed| has(&generate(family, *seed, DEFAULT_SIZE))).count() as f64 / SEEDS as f64
}

/// Least and greatest CoC of the quads that `which` picks, px.
fn coc_range_px(spec: &SceneSpec, which: impl Fn(&QuadSpec) -> bool) -> (f64, f64) {
    let all = spec.quads.iter().filter(|q| which(q)).flat_map(|q| q.coc_px(&spec.lens()));
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)))
}

#[test]
fn families_hold_what_they_say() {
    let lights = |q: &QuadSpec| q.light;
    let any = |_: &QuadSpec| true;
    let before = |spec: &SceneSpec| coc_range_px(spec, lights).1 < 0.0;
    let behind = |spec: &SceneSpec| coc_range_px(spec, lights).0 > 0.0;
    assert_eq!(share("specks_near", before), 1.0);
    assert_eq!(share("specks_far", behind), 1.0);
    let brightest = |spec: &SceneSpec| spec.quads.iter().map(|q| q.radiance[0]).fold(0.0, f32::max);
    assert!(share("specks_near", |spec| brightest(spec) > 1000.0) > 0.1);
    assert!(share("specks_near", |spec| brightest(spec) < 1.0) > 0.01);
    let across = |spec: &SceneSpec| {
        spec.quads.iter().any(|q| {
            let coc = q.coc_px(&spec.lens());
            coc.iter().any(|c| *c < -1.0) && coc.iter().any(|c| *c > 0.3)
        })
    };
    assert!(share("planes", across) > 0.9);
    assert_eq!(share("image_planes", across), 1.0);
    assert_eq!(share("near_before_sharp", |spec| spec.quads[0].coc_px(&spec.lens())[0].abs() < 0.05), 1.0);
    assert_eq!(share("stacks", |spec| coc_range_px(spec, any).0 < -1.9), 1.0);
    let steps = |spec: &SceneSpec| {
        let (low, high) = coc_range_px(spec, any);
        high - low
    };
    assert!(share("steps", |spec| steps(spec) > 40.0) > 0.2);
    for name in ["image_specks", "image_cards", "image_bands", "image_steps", "image_planes"] {
        assert_eq!(share(name, |spec| spec.as_image && spec.overscan_px == 0), 1.0, "{name}");
    }
    // In the margin and not in the frame: where the frame's own picture does not change.
    let outside = |spec: &SceneSpec| spec.quads.iter().skip(1).any(|q| !meets_frame(spec, q));
    assert!(share("margin", outside) > 0.2);
    assert_eq!(share("borders", |spec| spec.quads.iter().any(|q| q.light && crosses_border(spec, q))), 1.0);
}

/// Pixel coordinates of a quad's corners.
fn corners_px(spec: &SceneSpec, quad: &QuadSpec) -> [[f64; 2]; 4] {
    let focal_px = spec.camera().projection(spec.size(), 0).focal_px;
    let [width, height] = spec.size_px.map(f64::from);
    quad.corners_m.map(|[x, y, d]| [0.5 * width + focal_px * x / d, 0.5 * height - focal_px * y / d])
}

/// Two quads in one plane that overlap would be seen in no certain order.
#[test]
fn nothing_overlaps_in_one_plane() {
    for spec in every_scene() {
        let facing = |quad: &QuadSpec| {
            let depths = quad.corners_m.map(|c| c[2]);
            (depths.iter().all(|d| *d == depths[0])).then_some((depths[0], corners_px(&spec, quad)))
        };
        let all: Vec<_> = spec.quads.iter().filter_map(facing).collect();
        for (i, (depth, one)) in all.iter().enumerate() {
            let others = all[..i].iter().filter(|(other, _)| (other / depth - 1.0).abs() < 1e-4);
            for (_, other) in others {
                assert!(apart(one, other), "{}: {one:?} and {other:?} at {depth} m", spec.name);
            }
        }
    }
}

/// Whether two convex quads meet nowhere, or in an edge: a side of one divides them.
fn apart(one: &[[f64; 2]; 4], other: &[[f64; 2]; 4]) -> bool {
    let divided_by = |from: &[[f64; 2]; 4]| {
        (0..4).any(|i| {
            let (a, b) = (from[i], from[(i + 1) % 4]);
            let across = [b[1] - a[1], a[0] - b[0]];
            let length = across[0].hypot(across[1]);
            let along = |p: &[f64; 2]| (p[0] * across[0] + p[1] * across[1]) / length;
            let ends = |quad: &[[f64; 2]; 4]| {
                quad.iter().map(along).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
            };
            let ((low, high), (other_low, other_high)) = (ends(one), ends(other));
            // A tenth of a pixel is what rounded coordinates make of a common edge.
            high - other_low < 0.1 || other_high - low < 0.1
        })
    };
    divided_by(one) || divided_by(other)
}

fn meets_frame(spec: &SceneSpec, quad: &QuadSpec) -> bool {
    let corners = corners_px(spec, quad);
    [0, 1].iter().all(|&axis| {
        let side = f64::from(spec.size_px[axis]);
        corners.iter().any(|c| c[axis] < side) && corners.iter().any(|c| c[axis] > 0.0)
    })
}

fn crosses_border(spec: &SceneSpec, quad: &QuadSpec) -> bool {
    let inside = |c: &[f64; 2]| (0..2).all(|axis| c[axis] > 0.0 && c[axis] < f64::from(spec.size_px[axis]));
    let corners = corners_px(spec, quad);
    meets_frame(spec, quad) && corners.iter().any(|c| !inside(c))
}

#[test]
fn a_file_with_something_wrong_is_refused_with_its_reason() {
    let good = wall_and_light();
    let changed = |change: fn(&mut SceneSpec)| {
        let mut spec = good.clone();
        change(&mut spec);
        SceneSpec::from_text(&spec.to_text()).expect_err("refused").to_string()
    };
    assert!(changed(|s| s.size_px = [0, 48]).contains("size_px is 0x48: give 1 to 8192"));
    assert!(changed(|s| s.quads[1].corners_m[0][2] = 0.0).contains("a corner of quad 1"));
    assert!(changed(|s| s.quads[0].corners_m[3][0] = f64::NAN).contains("a corner of quad 0"));
    assert!(changed(|s| s.quads[0].radiance = [-1.0; 3]).contains("the radiance of quad 0"));
    assert!(changed(|s| s.k_px = f64::INFINITY).contains("k_px"));
    assert!(changed(|s| s.focus_m = 0.0).contains("focus_m"));
    assert!(changed(|s| s.fov_y_deg = 180.0).contains("fov_y_deg"));
    let cells = |s: &mut SceneSpec| s.quads[0].pattern = Pattern::Checker { cells: [0, 1], other: [0.0; 3] };
    assert!(changed(cells).contains("cells of quad 0"));
    assert!(SceneSpec::from_text("(name: 3)").expect_err("refused").to_string().contains("it is no scene"));

    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.ron");
    std::fs::write(&file, good.to_text()).expect("writes");
    let opened = Source::open(file.to_str().expect("UTF-8"), &DepthArgs::default()).expect("opens");
    assert_eq!(opened.made_for().map(|m| (m.lens.clone(), m.size)), Some((good.lens(), good.size())));
    std::fs::write(&file, "nonsense").expect("writes");
    let error = Source::open(file.to_str().expect("UTF-8"), &DepthArgs::default()).expect_err("refused").to_string();
    assert!(error.contains("scene.ron: it is no scene"), "{error}");
}

#[test]
fn a_scene_is_opened_with_its_lens_and_an_image_as_one() {
    let scene = Source::open("gauntlet:cards:5", &DepthArgs::default()).expect("opens");
    let spec = generate(family("cards").expect("a family"), 5, DEFAULT_SIZE);
    assert!(scene.is_scene());
    assert_eq!(scene.default_size(0), DEFAULT_SIZE);
    let depth = |size: UVec2| Image::filled(size, 3.0_f32);
    assert_eq!(scene.default_lens(&depth(DEFAULT_SIZE)), spec.lens());
    // The same picture in a larger frame: the CoC grows with it.
    let larger = scene.default_lens(&depth(DEFAULT_SIZE * 4));
    assert!((larger.k_px() / spec.k_px - 4.0).abs() < 1e-9);
    let image = Source::open("gauntlet:image_steps:5", &DepthArgs::default()).expect("opens");
    assert!(!image.is_scene());
    assert_eq!(image.default_size(0), DEFAULT_SIZE);
}

#[test]
fn the_image_is_what_the_rasteriser_draws() {
    let gpu = common::gpu();
    for name in ["image_specks", "image_cards", "image_steps"] {
        let spec = generate(family(name).expect("a family"), 11, DEFAULT_SIZE);
        let image = spec.image();
        let mut view = view_of(gpu, &spec);
        let drawn = defocus_study::render(gpu, &mut view, &spec.lens(), &Pinhole).expect("renders").color;
        let depth = view.depth_m(gpu);
        let same = |i: usize| {
            let (a, b) = (image.color.pixels[i], drawn.pixels[i]);
            (a - b).abs().max_element() <= 2e-3 * b.max_element()
                && (image.depth.pixels[i] / depth.pixels[i] - 1.0).abs() < 1e-3
        };
        let wrong = (0..drawn.pixels.len()).filter(|i| !same(*i)).count();
        // An edge through the centre of a pixel belongs to either side.
        assert!(wrong <= 130, "{name}: {wrong} pixels differ");
    }
}

fn view_of(gpu: &Gpu, spec: &SceneSpec) -> View {
    let scene = GpuScene::new(gpu, &spec.scene(), SurfaceOptions::default());
    View::of_scene(scene, spec.camera(), spec.size(), spec.overscan_px).expect("a view")
}

#[test]
fn a_reference_gets_points_until_its_halves_agree() {
    let gpu = common::gpu();
    let spec = wall_and_light();
    let lens = spec.lens();
    let agreed = truth(gpu, &mut view_of(gpu, &spec), &lens, 8, 4096).expect("a truth");
    assert!(agreed.agrees() && agreed.points > 8 && agreed.points < 4096, "{} points", agreed.points);
    let few = truth(gpu, &mut view_of(gpu, &spec), &lens, 8, 8).expect("a truth");
    assert!(!few.agrees() && few.points == 8);
    // Nothing is blurred: the halves are equal at once.
    let wall = truth(gpu, &mut view_of(gpu, &spec.without_lights()), &lens, 8, 4096).expect("a truth");
    assert_eq!((wall.points, wall.halves_db), (8, None));
}

#[test]
fn methods_are_judged_by_the_truth() {
    let gpu = common::gpu();
    let spec = wall_and_light();
    let methods: [Box<dyn Method>; 2] =
        [Box::new(Pinhole), Box::new(Accumulation { samples: 1024, view_dependent: false })];
    let result = examine(gpu, &spec, "none", &methods, [256, 4096]).expect("a result");
    assert!(result.agrees);
    let of = |id: &str| match &result.methods[id] {
        MethodFigures::Compared(figures) => figures.clone(),
        MethodFigures::Failed { failed } => panic!("{failed}"),
    };
    let (pinhole, accumulation) = (of("pinhole"), of("accumulation"));
    assert!(counted_db(&result.methods["accumulation"]) > 45.0);
    assert!(pinhole.psnr_db.expect("differs") < 25.0);
    let off = |figures: &Figures| (figures.light_kept.expect("a light") - 1.0).abs();
    assert!(off(&accumulation) < 0.005, "{accumulation:?}");
    assert!(accumulation.sharp_error.expect("a sharp wall") < 0.002);
}

/// Also what is left of a scene of nothing but lights.
#[test]
fn a_scene_of_nothing_but_a_sky_is_drawn() {
    let gpu = common::gpu();
    let spec = SceneSpec { quads: Vec::new(), sky: [0.25, 0.5, 0.75], ..wall_and_light() };
    assert_eq!(spec.check(), Ok(()));
    let methods = defocus::methods::all();
    let result = examine(gpu, &spec, "none", &methods, [8, 8]).expect("a result");
    for (id, found) in &result.methods {
        assert!(matches!(found, MethodFigures::Compared(_)), "{id}: {found:?}");
        let exact = ["pinhole", "accumulation", "mipmap", "adaptive"].contains(id);
        assert!(!exact || counted_db(found) == 50.0, "{id}: {found:?}");
    }
    let traced = spec.image().color.pixels;
    assert!(traced.iter().all(|c| (*c - Vec3::new(0.25, 0.5, 0.75)).abs().max_element() < 1e-3));
}

/// A ramp, a step, and an image that differs from them.
#[test]
fn figures_tell_light_sharp_and_smooth_apart() {
    let size = uvec2(32, 16);
    let truth = ColorImage::from_fn(size, |x, _| Vec3::splat(if x < 16 { 0.2 } else { 0.9 }));
    let coc_px = Image::from_fn(size, |_, y| if y < 8 { 0.0 } else { 5.0 });
    let rules = Rules::new(&truth, &truth, &coc_px, Some(0.0)).expect("rules");
    assert_eq!(rules.sharp.pixels.iter().filter(|s| **s).count(), 32 * 8);
    // Two columns on each side of the step are not smooth.
    assert_eq!(rules.smooth.pixels.iter().filter(|s| **s).count(), 28 * 16);
    let half = truth.map(|c| c * 0.5);
    assert!((figures(&half, &rules).expect("figures").light_kept.expect("a light") - 0.5).abs() < 1e-6);
    let wrong_at = |x: u32, y: u32| {
        let image = ColorImage::from_fn(size, |a, b| truth.at(a, b) * if (a, b) == (x, y) { 0.0 } else { 1.0 });
        figures(&image, &rules).expect("figures")
    };
    let at_the_step = wrong_at(16, 3);
    assert!(at_the_step.sharp_error > Some(0.9) && at_the_step.smooth_error == Some(0.0));
    let below = wrong_at(25, 12);
    assert!(below.sharp_error == Some(0.0) && below.smooth_error > Some(0.9));
    assert_eq!(below.worst_block_px, Some([24, 8]));
    let equal = figures(&truth, &rules).expect("figures");
    assert_eq!((equal.psnr_db, equal.sharp_error, equal.smooth_error), (None, Some(0.0), Some(0.0)));
}

fn result(index: usize, agrees: bool, dbs: &[(&'static str, Option<f64>)]) -> SceneResult {
    let figures = |psnr_db: Option<f64>| {
        MethodFigures::Compared(Figures {
            psnr_db,
            worst_block_db: psnr_db,
            worst_block_px: None,
            light_kept: None,
            sharp_error: None,
            smooth_error: None,
        })
    };
    SceneResult {
        scene: format!("scene {index}"),
        family: FAMILIES[index % 2].name,
        as_image: false,
        quads: 1,
        k_px: 1.0,
        reference_points: 256,
        reference_halves_db: None,
        agrees,
        seconds: BTreeMap::new(),
        methods: dbs.iter().map(|(id, db)| (*id, figures(*db))).collect::<BTreeMap<_, _>>(),
    }
}

#[test]
fn statistics_count_scenes_whose_reference_agrees() {
    let scenes: Vec<_> = (0..101).map(|i| result(i, true, &[("a", Some(i as f64 * 0.4))])).collect();
    let all = statistics("a", &scenes);
    assert_eq!((all.psnr_db.count, all.psnr_db.worst, all.psnr_db.worst_scene.as_str()), (101, 0.0, "scene 0"));
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(near(all.psnr_db.p1, 0.4) && near(all.psnr_db.p10, 4.0) && near(all.psnr_db.p50, 20.0), "{all:?}");
    assert!(near(all.psnr_db.mean, 20.0) && all.worst_family == Some(FAMILIES[0].name));
    let [bad, equal] = [result(0, false, &[("a", Some(1.0))]), result(1, true, &[("a", None)])];
    let both = statistics("a", &[bad, equal]);
    assert_eq!((both.psnr_db.count, both.psnr_db.worst), (1, 50.0), "equal images count as the greatest PSNR");
}

#[test]
fn a_small_difference_is_a_tie_and_great_figures_are_equal() {
    let scenes = [
        result(0, true, &[("a", Some(40.0)), ("b", Some(40.25))]),
        result(1, true, &[("a", Some(40.0)), ("b", Some(45.0))]),
        result(2, true, &[("a", Some(55.0)), ("b", None)]),
        result(3, false, &[("a", Some(10.0)), ("b", Some(45.0))]),
    ];
    let ranking = ranking("a", &["a", "b"], &scenes);
    assert_eq!(ranking.scenes, 3);
    assert!((ranking.best_share - 2.0 / 3.0).abs() < 1e-9);
    assert_eq!(ranking.losses, [("scene 1".to_owned(), "b", 5.0)]);
    assert_eq!(ranking.greatest_loss_db, 5.0);
}

fn shifted(scenes: &[SceneResult], by_db: f64) -> Vec<SceneResult> {
    let mut scenes = scenes.to_vec();
    for found in scenes.iter_mut().flat_map(|scene| scene.methods.values_mut()) {
        if let MethodFigures::Compared(figures) = found {
            figures.psnr_db = figures.psnr_db.map(|db| db + by_db);
        }
    }
    scenes
}

#[test]
fn a_regression_is_found_on_the_same_scenes_and_chance_is_not_one_on_others() {
    // 30 to 40 dB, evenly: a standard deviation of 2.9 dB.
    let of = |from: usize, count: usize| -> Vec<_> {
        (from..from + count).map(|i| result(i, true, &[("a", Some(30.0 + ((i / 2 * 7) % 101) as f64 * 0.1))])).collect()
    };
    let (same, many) = (of(0, 20), of(0, 1000));
    let which = Which { seed: 1, scenes: 20, size: [128, 96] };
    let bounds = Bounds { same: which, on_same: known(&same), on_many: known(&many) };
    let round_trip: Bounds = ron::from_str(&bounds.to_text()).expect("bounds");
    assert_eq!(round_trip, bounds);

    assert_eq!(bounds.regressions(&which, &same), []);
    assert_eq!(bounds.regressions(&which, &shifted(&same, -0.9 * SAME_SCENES_DB)), []);
    let worse = bounds.regressions(&which, &shifted(&same, -1.1 * SAME_SCENES_DB));
    assert_eq!(worse.len(), 2, "both families: {worse:?}");
    assert!(worse[0].to_string().contains("a on specks_"), "{}", worse[0]);

    let others = Which { seed: 2, ..which };
    for from in (0..400).step_by(20) {
        assert_eq!(bounds.regressions(&others, &of(from, 20)), [], "scenes from {from}");
    }
    // Ten scenes a family: four standard errors are 3.7 dB.
    assert_eq!(bounds.regressions(&others, &shifted(&many, -5.0)).len(), 2);
    assert_eq!(bounds.regressions(&others, &shifted(&of(40, 20), -8.0)).len(), 2);
}

#[test]
fn lost_light_is_a_regression_too() {
    let lit = |kept: f64| {
        let mut scene = result(0, true, &[("a", Some(40.0))]);
        if let Some(MethodFigures::Compared(figures)) = scene.methods.get_mut("a") {
            figures.light_kept = Some(kept);
        }
        scene
    };
    let which = Which { seed: 1, scenes: 1, size: [128, 96] };
    let bounds = Bounds { same: which, on_same: known(&[lit(1.0)]), on_many: known(&[lit(1.0)]) };
    assert_eq!(bounds.regressions(&which, &[lit(0.997)]), []);
    for kept in [0.98, 1.02] {
        let worse = bounds.regressions(&which, &[lit(kept)]);
        assert!(worse.len() == 1 && worse[0].figure.contains("light"), "{worse:?}");
    }
}

#[test]
fn the_bounds_of_the_program_can_be_read() {
    let bounds = known_bounds().expect("bounds");
    assert_eq!(bounds.same.size, DEFAULT_SIZE.to_array());
    let families = bounds.on_same.values().chain(bounds.on_many.values()).flat_map(BTreeMap::keys);
    for name in families {
        assert!(family(name).is_some(), "{name}");
    }
}

/// The fault: one quad, among all others, that is nearer than -10 px and bright.
#[test]
fn a_planted_fault_is_all_that_is_left() {
    let bright = |spec: &SceneSpec| {
        let lens = spec.lens();
        spec.quads.iter().any(|q| q.radiance[0] > 3.0 && q.coc_px(&lens).iter().all(|c| *c < -10.0))
    };
    let mut shrunk = 0;
    for seed in 0..30 {
        let mut spec = generate(family("mixed").expect("a family"), seed, DEFAULT_SIZE);
        let mut planted = wall_and_light().quads[1].clone();
        let depth_m = spec.focus_m * spec.k_px / (spec.k_px + 17.3);
        planted.corners_m = planted.corners_m.map(|[x, y, _]| [x, y, depth_m]);
        planted.radiance = [7.129, 3.218, 4.4];
        spec.quads.insert(spec.quads.len() / 2, planted);
        assert!(bright(&spec));
        let smaller = shrink(&spec, 2000, |spec| Ok(bright(spec))).expect("no error");
        assert!(smaller.complete && bright(&smaller.spec));
        assert_eq!(smaller.spec.quads.len(), 1, "seed {seed}");
        assert_eq!(smaller.spec.quads[0].pattern, Pattern::Plain);
        assert!(size_of(&smaller.spec) < size_of(&spec));
        shrunk += 1;
    }
    assert_eq!(shrunk, 30);
}

/// A crop shows what was seen there: the picture of a quarter is a quarter of the picture.
#[test]
fn a_smaller_frame_shows_the_same() {
    let spec = generate(family("cards").expect("a family"), 4, DEFAULT_SIZE);
    let mut tried = Vec::new();
    let keep = |candidate: &SceneSpec| {
        if candidate.size() == DEFAULT_SIZE / 2 {
            tried.push(candidate.clone());
        }
        Ok(false)
    };
    shrink(&spec, 10_000, keep).expect("no error");
    assert_eq!(tried.len(), 5);
    let whole = spec.image().color;
    let half = DEFAULT_SIZE / 2;
    let origins = [half / 2, UVec2::ZERO, uvec2(half.x, 0), uvec2(0, half.y), half];
    for (part, origin) in tried.iter().zip(origins) {
        let (part, expected) = (part.image().color, whole.crop(origin, half));
        let wrong = part.pixels.iter().zip(&expected.pixels).filter(|(a, b)| (**a - **b).abs().max_element() > 0.02);
        assert!(wrong.count() < 60, "the part at {origin}");
    }
}
