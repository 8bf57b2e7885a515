//! `defocus bench`: that it goes on where it stopped, that parts make the whole, that it
//! keeps to its time, and that reads are counted rightly.

mod common;

use common::gpu;
use defocus::methods::{self, Method, Mipmap};
use defocus::view::View;
use defocus_study::bench::plan::{Trade, variants};
use defocus_study::bench::tables;
use defocus_study::bench::{BenchRun, Blur, Plan, Shard, Store, StoreError, Variant};
use glam::{UVec2, Vec3, uvec2};
use std::ops::ControlFlow;
use std::time::Instant;

fn small_plan() -> Plan {
    Plan {
        scenes: vec!["mirrors".into(), "forest".into()],
        sizes: vec![[48, 36]],
        blurs: vec![Blur::MeanCocPx(2.0), Blur::MeanCocPx(4.0)],
        variants: vec![
            Variant::of("mipmap"),
            Variant::of("multiview").with("samples", 8),
            Variant::of("accumulation").with("samples", 16),
        ],
        reference_samples: Some(8),
        reference_only_at: None,
        warmup: 0,
        runs: 1,
        redraw: false,
        count_reads: true,
        overscan_px: None,
        view_dependent: false,
        input: defocus::view::Input::Hdr,
        error_maps: true,
    }
}

fn run(plan: &Plan, folder: &std::path::Path, shard: Shard, deadline: Option<Instant>) -> (usize, usize, usize) {
    let store = Store::open(folder, plan).expect("a folder of its own");
    let bench = BenchRun { plan, shard, store: &store, cache: None, deadline };
    let outcome = bench.run(gpu(), &mut |_| ControlFlow::Continue(())).expect("it measures");
    (outcome.measured, outcome.found, outcome.left)
}

#[test]
fn shards_make_the_whole_and_nothing_is_measured_twice() {
    let plan = small_plan();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let parts = [1, 2].map(|number| (folder.path().join(number.to_string()), Shard { number, of: 2 }));
    for (part, shard) in &parts {
        assert_eq!(run(&plan, part, *shard, None), (2, 0, 0));
        assert_eq!(run(&plan, part, *shard, None), (0, 2, 0), "the second time everything is there");
    }
    let parts: Vec<_> = parts.iter().map(|(part, _)| part.clone()).collect();
    let (merged, of_plan) = Store::merge(&parts, &folder.path().join("whole")).expect("they fit");
    assert_eq!(of_plan, plan);
    let results = merged.results(&plan).expect("it reads");
    assert_eq!((results.cells.len(), results.cells_wanted), (4, 4));

    let scene = results.cell("mirrors", plan.blurs[1]).expect("the cell is there");
    assert!((scene.mean_coc_px - 4.0).abs() < 1e-6, "{}", scene.mean_coc_px);
    let [mipmap, multiview, accumulation] = ["mipmap", "multiview samples=8", "accumulation samples=16"]
        .map(|label| scene.variant(label).unwrap_or_else(|| panic!("{label} is there")));
    // The reference itself has half of these lens points.
    assert!(
        accumulation.defocused_db() > mipmap.defocused_db(),
        "{:?} {:?}",
        accumulation.defocused_db(),
        mipmap.defocused_db()
    );
    assert!(multiview.reads_per_px > mipmap.reads_per_px);
    let map = mipmap.flip_map.as_ref().expect("a scene has a reference to err from");
    assert!(merged.folder().join(map).is_file());

    let image = results.cell("forest", plan.blurs[0]).expect("the cell is there");
    assert_eq!(image.not_run.len(), 1, "an image has no other viewpoints for accumulation");
    assert_eq!(image.variants[0].defocused_db(), None, "nor a reference");

    let csv = String::from_utf8(results.csv().expect("CSV")).expect("UTF-8");
    assert_eq!(csv.lines().count(), 1 + 2 * 3 + 2 * 2);
}

#[test]
fn variants_in_turn_are_timed_with_what_they_keep() {
    let slabs = |count: u32| Variant::of("multiview").with("slabs", count);
    let plan = Plan {
        scenes: vec!["mirrors".into()],
        blurs: vec![Blur::MeanCocPx(8.0)],
        variants: vec![slabs(1), slabs(2)],
        reference_samples: None,
        overscan_px: None,
        view_dependent: false,
        input: defocus::view::Input::Hdr,
        error_maps: false,
        ..small_plan()
    };
    let of_runs = |plan: &Plan| -> Vec<(u64, Option<u64>)> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        run(plan, folder.path(), Shard::WHOLE, None);
        let results = Store::open(folder.path(), plan).and_then(|s| s.results(plan)).expect("it reads");
        let works = results.cells[0].variants.iter().map(|v| &v.work);
        works.map(|w| (w.drawn.views, w.skipped.get("slabs unchanged").copied())).collect()
    };
    assert_eq!(of_runs(&plan), [(0, Some(1)); 2], "each has its own slabs, from the run before");
    // The pinhole image and the slabs.
    assert_eq!(of_runs(&Plan { redraw: true, ..plan }), [(2, None), (3, None)]);
}

#[test]
fn the_deadline_is_kept_and_other_plans_are_refused() {
    let plan = small_plan();
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert_eq!(run(&plan, folder.path(), Shard::WHOLE, Some(Instant::now())), (0, 0, 4));
    let other = Plan { runs: 3, ..plan };
    assert!(matches!(Store::open(folder.path(), &other), Err(StoreError::OtherPlan { .. })));
}

#[test]
fn copies_read_one_texel_a_pixel() {
    let (size, depth) = (uvec2(20, 12), 3.0);
    let mut view = image_view(size, depth);
    let mut frame = gpu().frame();
    let reads = frame.count_texture_reads();
    methods::copy_inner(&mut frame, &mut view);
    let counted: Vec<u64> = frame.read_buffer(&reads);
    // 8x8 groups also run beyond the image, where they read as well: 3 x 2 groups.
    assert_eq!(counted, [3 * 2 * 64]);
}

#[test]
fn more_reads_than_a_u32_holds_are_counted() {
    let mut view = image_view(uvec2(20, 12), 3.0);
    let mut frame = gpu().frame();
    let reads = frame.count_texture_reads();
    // A thread's first buffer is new and not cleared: it begins with what is written here.
    let before = u64::from(u32::MAX) - 100;
    gpu().queue().write_buffer(reads.raw(), 0, &before.to_le_bytes());
    methods::copy_inner(&mut frame, &mut view);
    assert_eq!(frame.read_buffer::<u64>(&reads), [before + 3 * 2 * 64]);
}

#[test]
fn counting_changes_no_image() {
    let lens = common::lens(8.0, 1.0);
    for method in methods::all() {
        let mut view = image_view(uvec2(24, 16), 2.0);
        if method.about().needs_scene {
            continue;
        }
        let [plain, counted] = [false, true].map(|counts| {
            let mut frame = gpu().frame();
            let reads = counts.then(|| frame.count_texture_reads());
            let image = methods::record(method.as_ref(), &mut frame, &mut view, &lens).expect("it renders");
            let count = reads.map(|reads| frame.read_buffer::<u64>(&reads));
            frame.finish();
            (defocus::gpu::download(gpu(), &image), count)
        });
        let id = method.about().id;
        // Atomic additions of floats, which scatter methods use, depend on their order.
        let greatest = plain.0.pixels.iter().zip(&counted.0.pixels).map(|(a, b)| (*a - *b).abs().max_element());
        let greatest = greatest.fold(0.0, f32::max);
        assert!(greatest <= 1e-3, "{id}: {greatest}");
        let reads = counted.1.expect("they were counted")[0];
        assert_eq!(reads == 0, id == "pinhole", "{id}: {reads} reads");
    }
}

fn image_view(size: UVec2, depth_m: f32) -> View {
    let color = defocus::image::Image::from_fn(size, |x, y| Vec3::new(x as f32, y as f32, 3.0) / size.x as f32);
    let depth = defocus::image::Image::filled(size, depth_m);
    View::of_image(gpu(), &color, &depth, 1.0).expect("a small image")
}

#[test]
fn methods_say_how_they_trade_time_for_quality() {
    let chosen: Vec<Box<dyn Method>> =
        vec![Box::new(Mipmap { k: 0.5, ..Mipmap::default() }), methods::by_id("multiview").unwrap()];
    let labels = |trades: &[Trade]| -> Vec<String> {
        variants(&chosen, trades).expect("they exist").iter().map(Variant::label).collect()
    };
    let own = labels(&[]);
    assert_eq!(own[..2], ["mipmap k=0.5", "multiview"]);
    assert!(own.contains(&"multiview samples=16".into()) && !own.contains(&"multiview samples=64".into()), "{own:?}");
    let samples = Trade { method: None, key: "samples".into(), values: vec!["9".into()] };
    assert_eq!(labels(&[samples]), ["mipmap k=0.5", "multiview", "multiview samples=9"]);
    let unknown = Trade { method: None, key: "nothing".into(), values: vec!["9".into()] };
    let wrong = Trade { method: None, key: "samples".into(), values: vec!["many".into()] };
    assert!(variants(&chosen, &[unknown]).unwrap_err().to_string().contains("nothing"));
    assert!(variants(&chosen, &[wrong]).unwrap_err().to_string().contains("many"));
}

#[test]
fn every_table_can_be_measured_and_shown_before_it_is() {
    for (name, table) in tables::ALL {
        for quick in [false, true] {
            let plan = table.plan(quick);
            assert!(plan.variants.iter().all(|v| v.method().is_ok()), "{name}");
            let results =
                defocus_study::bench::BenchResults { cells_wanted: plan.cells().len(), plan, cells: Vec::new() };
            let shown = table.compared(&results);
            assert!(shown.rows.iter().all(|row| row.len() == shown.columns.len()), "{name}");
            assert!(shown.claims.iter().all(|claim| claim.holds.is_none()), "{name}: nothing is measured yet");
        }
    }
}

fn defocus(folder: &std::path::Path, args: &str) -> (Option<i32>, String, String) {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_defocus"));
    let command = command.current_dir(folder).args(args.split_whitespace()).env("XDG_CACHE_HOME", folder);
    let output = command.output().expect("the program starts");
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_command_says_what_is_wrong_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (args, code, said) in [
        ("bench --table fig14", 2, "tvcg-fig14, tvcg-table1, pg-table1, siga-table1, grapp"),
        ("bench --shard 3/2", 2, "counted from 1 to 2"),
        ("bench --coc 0 -o out", 1, "above 0"),
        ("bench --budget 0 -o out", 1, "--budget is 0 minutes"),
        ("bench --sweep multiview.samples -o out", 1, "multiview.samples=16,64"),
        ("bench --methods nothing -o out", 1, "there are: pinhole"),
        ("bench --table grapp --methods opaque", 2, "cannot be used with"),
        ("bench merge nowhere -o out", 1, "nowhere"),
    ] {
        let (status, _, stderr) = defocus(folder.path(), args);
        assert_eq!(status, Some(code), "{args}: {stderr}");
        assert!(stderr.contains(said), "{args}: {stderr}");
        assert!(!folder.path().join("out").exists(), "{args}");
    }
}

#[test]
fn the_command_writes_a_report_and_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let args = "bench --methods mipmap --scenes mirrors --sizes 32x24,48x36 --coc 2 --samples 4 --runs 1 -o out";
    let (status, stdout, stderr) = defocus(folder.path(), args);
    assert_eq!(status, Some(0), "{stderr}");
    assert!(stdout.contains("2 cells measured"), "{stdout}");
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a report");
    assert!(
        report.contains("<svg")
            && report.contains("Time against resolution")
            && report.contains("maps/0000-mipmap.png")
    );
    let csv = std::fs::read_to_string(folder.path().join("out/results.csv")).expect("CSV");
    assert!(csv.starts_with("adapter,version,scene,") && csv.lines().count() == 3, "{csv}");
    let (_, stdout, _) = defocus(folder.path(), args);
    assert!(stdout.contains("0 cells measured, 2 found from before"), "{stdout}");
    let (_, stdout, _) = defocus(folder.path(), "bench merge out -o whole");
    assert!(stdout.contains("2 of 2 cells"), "{stdout}");
    assert!(folder.path().join("whole/report.html").is_file());
}
