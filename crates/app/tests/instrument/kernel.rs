//! The point spread function of pane A's method, beside the lens's own.

use crate::common::window::{Tiny, settle, tiny};
use crate::{says, tiny_files};
use defocus::aperture::Aperture;
use defocus_app::window::{Action, Document, KernelChoice, PaneId, read_state, write_state};
use defocus_study::psf::Side;

#[test]
fn the_panel_measures_the_method_of_pane_a_with_the_lens_aperture() {
    let Tiny { mut window, folder: _folder } = tiny(&tiny_files::squares().glb(), &["splat"]);
    assert!(window.state().engine().kernel().is_none(), "nothing is measured while nobody looks");
    let ctx = window.ctx.clone();
    window.state_mut().perform(&ctx, Action::Kernel);
    settle(&mut window);
    let measured = |window: &crate::common::window::Window| {
        let kernel = window.state().engine().kernel().expect("it was asked for");
        (kernel.of.clone(), kernel.psf.clone().expect("it is there").expect("it can be measured"))
    };
    let (of, found) = measured(&window);
    assert_eq!((of.method.id.as_str(), of.choice), ("splat", KernelChoice::default()));
    assert_eq!((found.psf.method, found.psf.coc_px, found.psf.side), ("splat", 16.0, Side::Behind));
    assert!((found.psf.energy - 1.0).abs() < 0.02 && found.psf.mtf_error < 0.05, "{:?}", found.psf.mtf_error);
    // Both pictures have all of the point's light, and the same shape.
    let light = |image: &defocus::image::ColorImage| image.pixels.iter().map(|p| p.y).sum::<f32>();
    assert_eq!(found.lens.size, found.psf.image.size);
    assert!((light(&found.lens) - 1.0).abs() < 1e-3 && (light(&found.psf.image) - 1.0).abs() < 1e-3);
    let apart: f32 = found.lens.pixels.iter().zip(&found.psf.image.pixels).map(|(a, b)| (a.y - b.y).abs()).sum();
    assert!(apart < 0.05, "splat's is the lens's: {apart}");
    for text in ["Point spread function", "Energy", "Width", "MTF error"] {
        assert!(says(&window, text), "{text}");
    }
    // Another method, and then a state with another aperture, is measured anew.
    window.state_mut().perform(&ctx, Action::SetMethod(PaneId(1), "separable".into()));
    settle(&mut window);
    assert_eq!(measured(&window).1.psf.method, "separable");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("triangle.ron");
    let mut document: Document = window.state().document().clone();
    document.lens.aperture = Aperture::polygon(3);
    document.kernel = KernelChoice { coc_px: 6.0, in_front: true };
    write_state(&file, &document).expect("it is written");
    assert_eq!(read_state(&file).expect("it is read").kernel, document.kernel);
    window.state_mut().perform(&ctx, Action::OpenNamed(file.to_string_lossy().into_owned()));
    settle(&mut window);
    let (of, found) = measured(&window);
    assert_eq!((of.aperture, found.psf.coc_px, found.psf.side), (Aperture::polygon(3), 6.0, Side::Front));
    let frames = window.state().engine().rendered_frames();
    for _ in 0..4 {
        window.step();
    }
    assert_eq!(window.state().engine().rendered_frames(), frames, "what is measured is not measured again");
}
