//! Point spread functions as CSV, as one picture and as an HTML file.

use super::{Psf, lens_mtf};
use crate::bench::plot::{Axis, Plot, Point, Series};
use askama::Template;
use base64::Engine;
use defocus::colormap::ColorMap;
use defocus::image::{ColorImage, Image};
use defocus::methods;
use glam::{UVec2, Vec3, uvec2};
use image::{ExtendedColorType, ImageEncoder};

/// Room between the pictures of a sheet, px.
const GAP_PX: u32 = 2;

/// A line of CSV.
#[derive(serde::Serialize)]
struct Line<'a> {
    method: &'a str,
    coc_px: f64,
    side: super::Side,
    energy: f64,
    sigma_px: f64,
    lens_sigma_px: f64,
    centroid_x_px: f64,
    centroid_y_px: f64,
    symmetry: f64,
    mtf_error: f64,
}

/// As CSV, a line for each method and CoC.
///
/// # Errors
///
/// None in practice: memory takes everything.
pub fn csv(found: &[Psf]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for psf in found {
        writer.serialize(Line {
            method: psf.method,
            coc_px: psf.coc_px,
            side: psf.side,
            energy: psf.energy,
            sigma_px: psf.sigma_px,
            lens_sigma_px: psf.lens_sigma_px,
            centroid_x_px: psf.centroid_px[0],
            centroid_y_px: psf.centroid_px[1],
            symmetry: psf.symmetry,
            mtf_error: psf.mtf_error,
        })?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// All functions on one sheet, linear, their light 1 each: a row for a method, a column for a
/// CoC.
pub fn sheet(found: &[Psf]) -> ColorImage {
    let (methods, cocs) = (methods_of(found), cocs_of(found));
    let cell = found.iter().map(|psf| psf.image.size).fold(UVec2::ZERO, UVec2::max) + GAP_PX;
    let count = uvec2(cocs.len() as u32, methods.len() as u32);
    let mut sheet = ColorImage::filled(cell * count, Vec3::ZERO);
    for psf in found {
        let column = cocs.iter().position(|coc| *coc == psf.coc_px).unwrap_or(0) as u32;
        let row = methods.iter().position(|id| *id == psf.method).unwrap_or(0) as u32;
        let corner = cell * uvec2(column, row) + (cell - psf.image.size) / 2;
        for y in 0..psf.image.size.y {
            for x in 0..psf.image.size.x {
                let to = corner + uvec2(x, y);
                sheet.pixels[(to.y * sheet.size.x + to.x) as usize] = psf.image.at(x, y);
            }
        }
    }
    sheet
}

/// The sheet in magma, each function on a scale of its own that ends at one and a half times
/// the mean of a disc of that CoC.
pub fn picture(found: &[Psf]) -> Image<[u8; 3]> {
    let scaled = |psf: &Psf| {
        let of_disc = 4.0 / (std::f64::consts::PI * psf.coc_px.max(1.0).powi(2));
        let scale = (1.0 / (1.5 * of_disc)) as f32;
        Psf { image: psf.image.map(|p| p * scale), ..psf.clone() }
    };
    let scaled: Vec<Psf> = found.iter().map(scaled).collect();
    ColorMap::Magma.apply(&sheet(&scaled).map(|p| p.y), 1.0)
}

fn methods_of(found: &[Psf]) -> Vec<&'static str> {
    let mut ids: Vec<&'static str> = Vec::new();
    for psf in found {
        if !ids.contains(&psf.method) {
            ids.push(psf.method);
        }
    }
    ids
}

fn cocs_of(found: &[Psf]) -> Vec<f64> {
    let mut cocs: Vec<f64> = Vec::new();
    for psf in found {
        if !cocs.contains(&psf.coc_px) {
            cocs.push(psf.coc_px);
        }
    }
    cocs
}

#[derive(Template)]
#[template(path = "psf.html")]
struct Page<'a> {
    adapter: &'a str,
    aperture: &'a str,
    command: &'a str,
    picture: String,
    methods: String,
    cocs: String,
    plots: Vec<TitledPlot>,
    rows: Vec<[String; 8]>,
    version: &'static str,
}

struct TitledPlot {
    title: String,
    svg: String,
}

/// What a page shows.
pub struct PsfPage<'a> {
    /// The functions.
    pub found: &'a [Psf],
    /// The adapter's name.
    pub adapter: &'a str,
    /// The aperture that they are of.
    pub aperture: &'a defocus::aperture::Aperture,
    /// The command that made it.
    pub command: &'a str,
}

/// Renders the page.
///
/// # Errors
///
/// A picture that cannot be encoded.
pub fn html(page: &PsfPage<'_>) -> std::io::Result<String> {
    let found = page.found;
    let mut png = Vec::new();
    let picture = picture(found);
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(picture.pixels.as_flattened(), picture.size.x, picture.size.y, ExtendedColorType::Rgb8)
        .map_err(std::io::Error::other)?;
    let cocs = cocs_of(found);
    let row = |psf: &Psf| {
        [
            psf.method.to_owned(),
            format!("{}", psf.coc_px),
            format!("{:.4}", psf.energy),
            format!("{:.3}", psf.sigma_px),
            format!("{:.3}", psf.lens_sigma_px),
            format!("{:+.3}, {:+.3}", psf.centroid_px[0], psf.centroid_px[1]),
            format!("{:.3}", psf.symmetry),
            format!("{:.3}", psf.mtf_error),
        ]
    };
    let page = Page {
        adapter: page.adapter,
        aperture: &page.aperture.to_string(),
        command: page.command,
        picture: format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png)),
        methods: methods_of(found).join(", "),
        cocs: cocs.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
        plots: cocs.iter().map(|coc| mtf_plot(found, *coc, page.aperture)).collect(),
        rows: found.iter().map(row).collect(),
        version: env!("CARGO_PKG_VERSION"),
    };
    page.render().map_err(std::io::Error::other)
}

/// The MTF of all methods at one CoC, with the lens's.
fn mtf_plot(found: &[Psf], coc_px: f64, aperture: &defocus::aperture::Aperture) -> TitledPlot {
    let at = |x: f64, y: f64, name: &str| Point { x, y, interval: None, label: format!("{name}: {y:.3} at {x:.3}") };
    let all = methods::all();
    let mut series: Vec<Series> = Vec::new();
    for psf in found.iter().filter(|psf| psf.coc_px == coc_px) {
        let style = all.iter().position(|m| m.about().id == psf.method).unwrap_or(0);
        let points = psf.frequencies.iter().zip(&psf.mtf).map(|(f, m)| at(*f, *m, psf.method)).collect();
        series.push(Series { name: psf.method.into(), style, points, markers: true });
    }
    if let Some(psf) = found.iter().find(|psf| psf.coc_px == coc_px) {
        let points = psf.frequencies.iter().map(|f| at(*f, lens_mtf(aperture, coc_px, *f), "lens")).collect();
        series.push(Series { name: "lens, closed form".into(), style: 7, points, markers: true });
    }
    let x = Axis { title: "cycles per px", logarithmic: false };
    let y = Axis { title: "modulation", logarithmic: false };
    TitledPlot { title: format!("C = {coc_px} px"), svg: Plot { x, y, series, front: false }.svg() }
}
