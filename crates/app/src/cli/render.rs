//! `defocus render`: one image by one method.

use super::args::RenderArgs;
use super::inside;
use super::output::{ImageKind, check_folder_of, check_json, check_target, is_stdout, print, print_notes, write_json};
use super::progress::{Bar, catch_interrupts, check_interrupt};
use super::select;
use super::setup::{Setup, SetupOptions};
use super::stereo::{self, Picture};
use anyhow::ensure;
use defocus::image_io::{write_exr, write_png_rgb};
use defocus::methods::{self, Method, set_param};
use defocus_study::Rendered;
use defocus_study::compare::params_json;
use defocus_study::reference::{Reference, ReferenceRequest, accumulate, render_reference};
use defocus_study::results::{RenderJson, Setting};
use std::path::Path;

/// Lens points of a traced image where nothing is said.
const DEFAULT_TRACED_SAMPLES: u32 = 1024;

/// Runs the command.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    catch_interrupts()?;
    let kind = args.output.as_deref().map(ImageKind::of).transpose()?;
    let stereo = args.stereo.stereo();
    if let Some(ImageKind::Exr) = kind {
        stereo::check_linear(stereo)?;
    }
    args.output.as_deref().map_or(Ok(()), check_folder_of)?;
    args.inside.as_deref().map_or(Ok(()), check_target)?;
    check_json(args.run.json.json.as_ref())?;
    let method = if args.method == "raytrace" { None } else { Some(chosen(args)?) };
    ensure!(
        method.is_some() || args.view.settings.is_empty(),
        "raytrace has no parameters to --set; it takes --samples and --view-dependent"
    );
    ensure!(method.is_some() || args.inside.is_none(), "raytrace has nothing --inside: it makes no textures");

    let mut setup = Setup::new(&SetupOptions {
        scene: &args.scene,
        lens: &args.lens,
        view: &args.view,
        display: &args.display,
        adapter: args.run.adapter.as_deref(),
        schedule: args.run.schedule,
        mipmaps: true,
        stereo: stereo.map(|stereo| stereo.layout),
    })?;
    if args.view.as_image {
        ensure!(stereo.is_none(), "a picture has one eye: leave out --stereo or --as-image");
        setup.show_as_image()?;
    }
    setup.give(args.input)?;
    print_notes(&setup.notes(), args.run.quiet);
    let bar = Bar::new(args.run.quiet);
    let mut draw = |setup: &mut Setup| match &method {
        Some(method) => Ok((params_json(method.as_ref()), by_method(setup, method.as_ref(), &bar)?)),
        None => traced(args, setup, &bar),
    };
    let display = setup.display;
    let picture = match stereo {
        Some(stereo) => Picture::of_two(&mut setup, stereo, display, &mut draw)?,
        None => Picture::of_one(&mut setup, display, &mut draw)?,
    };
    let images = match (&method, &args.inside) {
        (Some(method), Some(_)) => {
            let gpu = setup.gpu();
            defocus_study::look_inside(&gpu, &mut setup.view, &setup.lens, method.as_ref(), &display)?
        }
        _ => Vec::new(),
    };
    drop(bar);

    let setting = Setting { size: picture.rendered.color.size.to_array(), ..setup.setting() };
    let json = RenderJson::new(setting, stereo, &args.method, picture.params.clone(), &picture.rendered);
    check_interrupt()?;
    if let (Some(kind), Some(file)) = (kind, &args.output) {
        write(kind, file, &picture, &setup)?;
    }
    write_json(args.run.json.json.as_ref(), &json)?;
    let quiet = args.run.quiet || is_stdout(args.run.json.json.as_ref());
    if let Some(folder) = &args.inside {
        inside::write(folder, &images, quiet)?;
    }
    if !quiet {
        print(&summary(&json))?;
    }
    Ok(())
}

/// The method with its parameters set.
fn chosen(args: &RenderArgs) -> anyhow::Result<Box<dyn Method>> {
    let mut chosen = [methods::by_id(&args.method)?];
    select::as_published(args.view.as_published, &mut chosen);
    select::shade_by_view(args.view.view_dependent, &mut chosen)?;
    select::apply(&args.view.settings, &mut chosen)?;
    let [mut method] = chosen;
    if let Some(samples) = args.samples {
        ensure!(
            select::has_param(method.as_ref(), "samples"),
            "{} has no lens points to count; leave out --samples",
            args.method
        );
        set_param(method.as_mut(), "samples", &samples.to_string())?;
    }
    Ok(method)
}

fn by_method(setup: &mut Setup, method: &dyn Method, bar: &Bar) -> anyhow::Result<Rendered> {
    let gpu = setup.gpu();
    if method.about().id != "accumulation" || !setup.view.is_scene() || setup.lens.aperture_diameter_mm == 0.0 {
        return Ok(defocus_study::render(&gpu, &mut setup.view, &setup.lens, method)?);
    }
    // Step by step, since it may take minutes and must be possible to interrupt.
    let params = params_json(method);
    let samples = params.get("samples").and_then(|v| v.as_u64()).unwrap_or_default() as u32;
    let view_dependent = params.get("view_dependent").and_then(|v| v.as_bool()).unwrap_or_default();
    let display = setup.display;
    let request = ReferenceRequest { reference: Reference::Accumulation, samples, view_dependent, display };
    Ok(accumulate(&gpu, &mut setup.view, &setup.lens, &request, &mut |step| bar.step(step))?.rendered)
}

type Traced = (serde_json::Map<String, serde_json::Value>, Rendered);

fn traced(args: &RenderArgs, setup: &mut Setup, bar: &Bar) -> anyhow::Result<Traced> {
    let samples = args.samples.unwrap_or(DEFAULT_TRACED_SAMPLES);
    let view_dependent = args.view.view_dependent;
    let display = setup.display;
    let request = ReferenceRequest { reference: Reference::RayTrace, samples, view_dependent, display };
    let (source, view) = (&setup.source, &mut setup.view);
    let truth = render_reference(source, view, &setup.lens, &request, &mut |step| bar.step(step))?;
    let params = [("samples".to_owned(), samples.into()), ("view_dependent".to_owned(), view_dependent.into())];
    let rendered = Rendered { color: truth.color, passes: Vec::new(), stats: Default::default() };
    Ok((params.into_iter().collect(), rendered))
}

fn write(kind: ImageKind, file: &Path, picture: &Picture, setup: &Setup) -> anyhow::Result<()> {
    let color = &picture.rendered.color;
    match kind {
        ImageKind::Png => write_png_rgb(file, &defocus_study::report::shown(color, picture.display))?,
        ImageKind::Exr => {
            let coc = setup.lens.coc();
            let coc_px = picture.depth_m.map(|d| coc.at_depth(f64::from(d)) as f32);
            write_exr(file, color, Some(&picture.depth_m), Some(&coc_px))?;
        }
    }
    Ok(())
}

fn summary(json: &RenderJson) -> String {
    let setting = &json.setting;
    let [width, height] = setting.size;
    let coc = setting.coc.map_or(String::new(), |coc| format!(", mean CoC {:.2} px", coc.mean_px));
    let time = json.gpu_ms.map_or(String::new(), |ms| format!(", {ms:.2} ms on {}", setting.adapter));
    let focus = setting.lens.focus_m.map_or("infinity".into(), |m| format!("{m:.3} m"));
    format!("{}: {}, {width}x{height} px, focus {focus}{coc}{time}", setting.scene, json.method)
}
