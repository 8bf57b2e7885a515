//! Two methods on one file, without a window, with figures against the truth.
//!
//! cargo run --example headless [SCENE]    a built-in name or a .glb/.gltf file

use defocus::gpu::Gpu;
use defocus::methods;
use defocus::view::SurfaceOptions;
use defocus_study::metrics::{self, CompareOptions};
use defocus_study::{DepthArgs, Source};
use glam::uvec2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = std::env::args().nth(1).unwrap_or("cans".into());
    let source = Source::open(&scene, &DepthArgs::default())?;
    let gpu = Gpu::open(None)?;

    let surfaces = source.upload(&gpu, SurfaceOptions::default());
    let mut view = surfaces.view(0, uvec2(256, 192), 0, None)?;
    let depth_m = view.depth_m(&gpu);
    let lens = source.default_lens(&depth_m);

    let mut truth = methods::by_id("accumulation")?;
    methods::set_param(&mut *truth, "samples", "64")?;
    let truth = defocus_study::render(&gpu, &mut view, &lens, &*truth)?;
    for id in ["pinhole", "mipmap"] {
        let rendered = defocus_study::render(&gpu, &mut view, &lens, &*methods::by_id(id)?)?;
        let figures = metrics::compare(&rendered.color, &truth.color, &CompareOptions::default())?;
        println!("{id}: PSNR {:.2?} dB, FLIP {:.4}", figures.psnr_db, figures.flip);
    }
    Ok(())
}
