//! Random actions: nothing breaks, and the GPU's memory comes back. As many as
//! `DEFOCUS_SOAK_ACTIONS` says; the issue's figure is 2000:
//!
//! ```sh
//! DEFOCUS_SOAK_ACTIONS=2000 cargo test --test soak -- --nocapture
//! ```

#![cfg(feature = "window")]

mod common;
#[path = "../../../tests/tiny_files/mod.rs"]
mod tiny_files;

use common::window::{Window, settle, window_in};
use defocus_app::window::{Action, Document, MethodChoice, PictureSize};
use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, pos2, vec2,
};
use egui_kittest::kittest::Queryable;
use std::collections::BTreeMap;

/// Actions of a run among all other tests.
const ACTIONS: u32 = 150;

/// Bytes that the device may hold beyond what it held in the same state before: its
/// allocator keeps a block or two of each kind of memory that was once needed.
const ALLOCATOR_SLACK: u64 = 64 << 20;

/// Small: what is tested is the order of things, not their size.
const SIZE: [f32; 2] = [460.0, 170.0];

/// xorshift64*: the same numbers in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn unit(&mut self) -> f32 {
        self.below(10_000) as f32 / 9_999.0
    }

    fn of<T: Clone>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())].clone()
    }

    fn point(&mut self, window: &Window) -> Pos2 {
        let size = window.ctx.content_rect().size();
        pos2(self.unit() * size.x, self.unit() * size.y)
    }
}

/// What leaves the window or holds it up for seconds is tried elsewhere.
fn is_for_here(action: &Action) -> bool {
    match action {
        Action::OpenNamed(name) => name == "forest" || name.ends_with("squares.glb") || name.ends_with(".ron"),
        Action::SaveReport | Action::FiguresForPaper => false,
        // Scenes and pictures of other sizes.
        Action::Lesson(_) | Action::StepLesson(_) | Action::ScaleScene(_) => false,
        Action::SetSize(size) => *size == PictureSize::Window,
        _ => true,
    }
}

fn act(window: &mut Window, random: &mut Random) -> String {
    match random.below(100) {
        0..30 => {
            let commands: Vec<_> = window.state().commands().into_iter().filter(|c| is_for_here(&c.action)).collect();
            // Loading takes most of the time: one in ten of those that would.
            let command = &commands[random.below(commands.len())];
            if matches!(command.action, Action::OpenNamed(_)) && random.below(10) > 0 {
                return "nothing".into();
            }
            let ctx = window.ctx.clone();
            window.state_mut().perform(&ctx, command.action.clone());
            command.name.clone()
        }
        30..60 => {
            let (from, to) = (random.point(window), random.point(window));
            let button = random.of(&[PointerButton::Primary, PointerButton::Primary, PointerButton::Secondary]);
            let event = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE };
            window.event(Event::PointerMoved(from));
            window.step();
            window.event(event(from, true));
            window.step();
            let end = if random.below(2) == 0 { from } else { to };
            window.event(Event::PointerMoved(end));
            window.event(event(end, false));
            format!("{button:?} from {from:?} to {end:?}")
        }
        60..72 => {
            let modifiers = random.of(&[Modifiers::NONE, Modifiers::COMMAND]);
            let delta = vec2(0.0, random.unit() * 200.0 - 100.0);
            let at = random.point(window);
            window.event(Event::PointerMoved(at));
            window.event(Event::MouseWheel {
                unit: MouseWheelUnit::Point,
                delta,
                phase: TouchPhase::Move,
                modifiers,
                source: MouseWheelSource::Wheel,
            });
            format!("scroll {delta:?} with {modifiers:?} at {at:?}")
        }
        72..92 => {
            const KEYS: [Key; 24] = [
                Key::C,
                Key::X,
                Key::V,
                Key::N,
                Key::T,
                Key::Z,
                Key::R,
                Key::M,
                Key::B,
                Key::Delete,
                Key::Num1,
                Key::Num2,
                Key::Num3,
                Key::Num6,
                Key::Escape,
                Key::Tab,
                Key::ArrowUp,
                Key::ArrowDown,
                Key::Enter,
                Key::Space,
                Key::W,
                Key::A,
                Key::D,
                Key::Escape,
            ];
            let modifiers = random.of(&[Modifiers::NONE, Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND]);
            let key = random.of(&KEYS);
            window.key_combination_modifiers(modifiers, &[key]);
            format!("{modifiers:?} {key:?}")
        }
        92..96 => {
            let text = random.of(&["3", "0", "-1", "1e9", "nan", "inf", "0.001", "x"]);
            window.event(Event::Text(text.into()));
            format!("type {text}")
        }
        _ => {
            let size = random.of(&[SIZE, [1.0, 1.0], [90.0, 300.0], [640.0, 90.0], [380.0, 200.0], SIZE]);
            window.set_size(vec2(size[0], size[1]));
            format!("resize to {size:?}")
        }
    }
}

/// Folds the inspector if it was left open: while it is, methods keep what it tells.
fn fold_inspector(window: &mut Window) {
    if window.query_all_by_label("Luminance histogram").next().is_some() {
        window.get_by_label("Inspector").click_accesskit();
        window.run_steps(10);
        assert!(window.query_all_by_label("Luminance histogram").next().is_none(), "the inspector is folded");
    }
}

/// Bytes that the pool and the device's allocator hold in the state that the test starts
/// with, at rest, and the picture's pixels.
fn resting_bytes(window: &mut Window, start: &Document, file: &std::path::Path) -> (u64, u64, u64) {
    window.set_size(vec2(SIZE[0], SIZE[1]));
    for key in [Key::Escape, Key::Escape, Key::Escape] {
        window.key_press(key);
        window.run_steps(2);
    }
    fold_inspector(window);
    defocus_app::window::write_state(file, start).expect("a temporary file can be written");
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::OpenNamed(file.to_string_lossy().into_owned()));
    settle(window);
    // Free textures are kept for a few frames: as many are drawn.
    for _ in 0..12 {
        for method in ["pinhole", "mipmap"] {
            let a = window.state().document().a;
            window.state_mut().perform(&ctx, Action::SetMethod(a, method.into()));
            settle(window);
        }
    }
    let gpu = window.state().engine().gpu();
    // Back ends without an allocator of their own tell nothing.
    let allocated = gpu.device().generate_allocator_report().map_or(0, |report| report.total_allocated_bytes);
    let size = window.state().engine().size().expect("there is a picture");
    (gpu.pooled_bytes(), allocated, u64::from(size.x) * u64::from(size.y))
}

#[test]
fn random_actions_leave_the_window_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let scene = tiny_files::write(folder.path(), "squares.glb", &tiny_files::squares().glb());
    let scene = scene.to_string_lossy().into_owned();
    let document = Document { overscan_px: 4, scene, ..Document::of_methods([MethodChoice::new("mipmap")]) };
    let mut window = window_in(SIZE, document, Some(folder.path().into()));
    let file = folder.path().join("start.ron");
    let start = window.state().document().clone();
    let before = resting_bytes(&mut window, &start, &file);
    window.get_by_label("Inspector").click_accesskit();
    window.run_steps(10);
    settle(&mut window);
    assert!(window.query_all_by_label("Luminance histogram").next().is_some(), "the inspector is open");
    eprintln!("pool with the inspector open: {} bytes", window.state().engine().gpu().pooled_bytes());
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let asked = std::env::var("DEFOCUS_SOAK_ACTIONS").ok().map(|text| text.parse().expect("a number of actions"));
    let actions = asked.unwrap_or(ACTIONS);
    let start_time = std::time::Instant::now();
    let mut last: Vec<String> = Vec::new();
    let mut greatest = BTreeMap::new();
    for index in 0..actions {
        last.push(act(&mut window, &mut random));
        if last.len() > 6 {
            last.remove(0);
        }
        if window.state().document().size != PictureSize::Window {
            // Large pictures are tried elsewhere.
            let ctx = window.ctx.clone();
            window.state_mut().perform(&ctx, Action::SetSize(PictureSize::Window));
        }
        window.step();
        let error = window.state().last_error().unwrap_or_default();
        assert!(!error.contains("graphics d"), "after {last:?}: {error}");
        let bytes = window.state().engine().gpu().pooled_bytes();
        let part = greatest.entry(index * 4 / actions).or_insert(0);
        *part = bytes.max(*part);
        if (index + 1) % 100 == 0 {
            eprintln!("{} actions in {:.0} s", index + 1, start_time.elapsed().as_secs_f64());
        }
    }
    let after = resting_bytes(&mut window, &start, &file);
    eprintln!(
        "{actions} actions in {:.0} s; (bytes of the pool, of the device, pixels) at rest: {before:?} before, {after:?} after; most in the pool in each quarter: {greatest:?}",
        start_time.elapsed().as_secs_f64()
    );
    // Panels keep the widths that they were dragged to, which are not of the document: the
    // picture may be larger than it was, and the margin around it is not.
    assert!(
        after.0 * before.2 <= (before.0 + before.0 / 8) * after.2,
        "the pool holds {after:?} bytes where it held {before:?} in the same state"
    );
    assert!(after.1 <= before.1 + ALLOCATOR_SLACK, "the device holds {after:?} bytes where it held {before:?}");
}
