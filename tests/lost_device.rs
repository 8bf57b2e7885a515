//! A device that is lost while a frame is recorded: no call panics, whichever pass it is.

mod common;

use defocus::gpu::Gpu;
use defocus::methods::{self, Method};
use defocus::view::{GpuScene, SurfaceOptions, View};
use glam::{UVec2, uvec2, vec2};
use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

const SIZE: UVec2 = uvec2(40, 32);

fn view(gpu: &Gpu) -> View {
    let quads = vec![
        common::quad(3.0, vec2(-4.0, -4.0), vec2(4.0, 4.0), 0),
        common::quad(1.0, vec2(-1.0, -1.0), vec2(0.0, 1.0), 0),
    ];
    let scene = GpuScene::new(gpu, &common::scene(quads, vec![common::textured()]), SurfaceOptions::default());
    View::of_scene(scene, common::front_camera(), SIZE, 4).unwrap()
}

/// Records a frame on a device of its own that is destroyed before its `lost_at`-th pass.
/// Returns how many passes were recorded.
fn record(method: &dyn Method, lost_at: u32) -> u32 {
    let gpu = Gpu::open(None).expect("a graphics adapter");
    // As a program does that goes on without its device: wgpu's own handler ends it.
    gpu.device().on_uncaptured_error(Arc::new(|_| {}));
    let mut view = view(&gpu);
    let passes = Rc::new(Cell::new(0));
    let (count, device) = (passes.clone(), gpu.device().clone());
    let mut frame = gpu.frame();
    frame.before_each_pass(move |_| {
        if count.get() == lost_at {
            device.destroy();
        }
        count.set(count.get() + 1);
    });
    // A picture of a lost device is no picture, but it is no panic either.
    let _ = methods::record(method, &mut frame, &mut view, &common::lens(8.0, 3.0));
    frame.finish().timings.wait();
    passes.get()
}

fn all_passes(id: &str, settings: &[(&str, &str)]) {
    let mut method = methods::by_id(id).unwrap();
    for (key, value) in settings {
        methods::set_param(&mut *method, key, value).unwrap();
    }
    let mut lost_at = 0;
    // As many as there are without a loss, or fewer where what is read back decides.
    while lost_at < record(&*method, lost_at) {
        lost_at += 1;
    }
    assert!(lost_at >= 1, "{id} records passes");
}

macro_rules! methods {
    ($($name:ident: $id:literal $settings:expr;)*) => { $(
        #[test]
        fn $name() {
            all_passes($id, &$settings);
        }
    )* };
}

methods! {
    pinhole: "pinhole" [];
    accumulation: "accumulation" [("samples", "2")];
    mipmap: "mipmap" [];
    mipmap_as_printed: "mipmap" [("filter", "as printed")];
    multiview: "multiview" [("samples", "8"), ("slabs", "2")];
    multiview_together: "multiview" [("samples", "8"), ("slabs", "4")];
    preblur: "preblur" [];
    separable: "separable" [];
    linear: "linear" [];
    pyramid: "pyramid" [];
    opaque: "opaque" [];
    splat: "splat" [];
    splat_by_tiles: "splat" [("by", "tiles")];
    adaptive: "adaptive" [("fineness", "1"), ("draws", "1"), ("layers", "2")];
    adaptive_with_more_samples: "adaptive" [("fineness", "1"), ("draws", "2"), ("layers", "1")];
}

/// `scatter` sorts in 24 passes a digit: lost before a few of them.
#[test]
fn scatter() {
    let mut method = methods::by_id("scatter").unwrap();
    methods::set_param(&mut *method, "symmetric", "off").unwrap();
    for lost_at in [0, 1, 2, 3, 4, 12, 26, 27, 28] {
        record(&*method, lost_at);
    }
}
