//! A pane's picture with more pixels than it has in the window: for print, drawn beside the
//! interface on a device of its own.

use super::compared::{Bench, Order, said};
use super::model::{GREATEST_SIDE_PX, MethodChoice, PictureKind};
use defocus::image::ColorImage;
use defocus::image_io::{write_exr, write_png_rgb};
use defocus::lens::Lens;
use defocus_study::reference::{Reference, ReferenceRequest, render_reference};
use defocus_study::{Progress, Step, StudyError, render, report};
use std::path::Path;

/// What is offered: times as many pixels in each direction.
pub const ENLARGEMENTS: [u32; 4] = [1, 2, 3, 4];

/// Pixels in a centimetre of print: 300 in an inch.
pub const PRINT_PX_PER_CM: f64 = 300.0 / 2.54;

/// The order for a picture with `times` as many pixels in each direction: lengths in pixels grow
/// with it, so that the same is seen.
pub fn enlarged(mut order: Order, times: u32) -> Order {
    order.size *= times;
    order.document.overscan_px *= times;
    let lens = order.document.lens.clone();
    order.document.lens = Lens { density_px_per_mm: lens.density_px_per_mm * f64::from(times), ..lens };
    order.truth = None;
    order
}

/// Draws the picture of `method` as `order` asks for it and writes it.
///
/// # Errors
///
/// In a sentence: a picture that is too large, a method that cannot render it, a file that cannot
/// be written, or that `progress` asked to stop.
pub fn write(
    order: &Order,
    method: &MethodChoice,
    kind: PictureKind,
    file: &Path,
    progress: &mut Progress<'_>,
) -> Result<(), String> {
    if order.size.max_element() > GREATEST_SIDE_PX {
        let (x, y) = (order.size.x, order.size.y);
        return Err(format!("{x} x {y} px are more than {GREATEST_SIDE_PX} a side: save it smaller"));
    }
    if !order.source.is_scene() {
        return Err("an image with depth has no more pixels than it brings: save it as shown".into());
    }
    let mut bench = Bench::open(order)?;
    let color = draw(order, method, &mut bench, progress)?;
    let document = &order.document;
    match kind {
        PictureKind::Png => write_png_rgb(file, &report::shown(&color, document.display)),
        PictureKind::Exr => {
            let depth_m = bench.view.depth_m(&bench.gpu);
            let coc = document.lens.coc();
            let coc_px = depth_m.map(|d| coc.at_depth(f64::from(d)) as f32);
            write_exr(file, &color, Some(&depth_m), Some(&coc_px))
        }
    }
    .map_err(|e| said(&e))
}

fn draw(
    order: &Order,
    method: &MethodChoice,
    bench: &mut Bench,
    progress: &mut Progress<'_>,
) -> Result<ColorImage, String> {
    let document = &order.document;
    let built = method.build()?;
    if progress(Step { what: "drawing", done: 0, of: 1 }).is_break() {
        return Err(said(&StudyError::Stopped));
    }
    if method.id != "accumulation" {
        let rendered = render(&bench.gpu, &mut bench.view, &document.lens, built.as_ref());
        return rendered.map(|rendered| rendered.color).map_err(|e| said(&e));
    }
    // What takes many views tells how far it is, and can be stopped.
    let request = ReferenceRequest {
        reference: Reference::Accumulation,
        samples: method.count("samples").unwrap_or_else(|| defocus::methods::Accumulation::default().samples),
        view_dependent: method.is_on("view_dependent"),
        display: document.display,
    };
    let truth = render_reference(&bench.source, &mut bench.view, &document.lens, &request, progress);
    truth.map(|truth| truth.color).map_err(|e| said(&e))
}
