//! A comparison as one HTML file that needs nothing but itself.

use super::compare::GoodEnough;
use super::results::{CompareJson, ResultJson};
use super::{Comparison, MethodResult, StudyError, Truth};
use super::{curves, table};
use crate::metrics::{self, Visibility};
use askama::Template;
use base64::Engine;
use defocus::colormap::ColorMap;
use defocus::display::Display;
use defocus::eye::Eye;
use defocus::image::{ColorImage, Image};
use defocus::viewing::Viewing;
use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder};

/// The absolute error, in display values of [0, 1], that gets the last colour of the map:
/// fixed, so that maps of different methods and reports can be compared.
pub const ABS_ERROR_WHITE: f32 = 0.25;

/// The loss by pixel, as a share of the scale of JOD, that gets the last colour of the map: 4
/// JOD, twice what is obvious.
pub const JOD_MAP_WHITE: f32 = 0.4;

/// The images of one method, as a display shows them.
#[derive(Clone, Debug)]
pub struct MethodImages {
    /// The method's id.
    pub method: &'static str,
    /// The image.
    pub image: Image<[u8; 3]>,
    /// The FLIP map in magma, 0 to 1; where there is a truth.
    pub flip: Option<Image<[u8; 3]>>,
    /// What is lost by pixel in magma, 0 to [`JOD_MAP_WHITE`]; where there is a truth.
    pub jod: Option<Image<[u8; 3]>>,
    /// The greatest absolute difference of R, G and B in viridis, 0 to [`ABS_ERROR_WHITE`].
    pub abs_error: Option<Image<[u8; 3]>>,
}

/// A colour image as 8-bit sRGB display values.
pub fn shown(image: &ColorImage, display: Display) -> Image<[u8; 3]> {
    let quantised = |v: Vec3| (v * 255.0).round().to_array().map(|c| c as u8);
    display.encoded_image(image).map(quantised)
}

/// A method's image and error maps.
///
/// # Errors
///
/// An image with NaN or infinity.
pub fn method_images(
    result: &MethodResult,
    truth: Option<&Truth>,
    display: Display,
    viewing: &Viewing,
) -> Result<MethodImages, StudyError> {
    let image = shown(&result.color, display);
    let method = result.method;
    let Some(truth) = truth else {
        return Ok(MethodImages { method, image, flip: None, jod: None, abs_error: None });
    };
    let failed = |source| StudyError::Metrics { method, source };
    let jod = metrics::jod_map(&result.color, &truth.color, display, viewing).map_err(failed)?;
    let errors = metrics::abs_error_map(&result.color, &truth.color, display).map_err(failed)?;
    let abs_error = ColorMap::Viridis.apply(&errors.map(Vec3::max_element), ABS_ERROR_WHITE);
    let jod = jod.map(|found| ColorMap::Magma.apply(&found.map, JOD_MAP_WHITE));
    let flip = flip_image(result, Some(truth), display, viewing)?;
    Ok(MethodImages { method, image, flip, jod, abs_error: Some(abs_error) })
}

/// A method's FLIP map in magma, 0 to 1; `None` without a truth.
///
/// # Errors
///
/// An image with NaN or infinity.
pub fn flip_image(
    result: &MethodResult,
    truth: Option<&Truth>,
    display: Display,
    viewing: &Viewing,
) -> Result<Option<Image<[u8; 3]>>, StudyError> {
    let Some(truth) = truth else { return Ok(None) };
    let failed = |source| StudyError::Metrics { method: result.method, source };
    let ppd = viewing.px_per_degree as f32;
    let flip = metrics::flip_map(&result.color, &truth.color, display, ppd).map_err(failed)?;
    Ok(Some(ColorMap::Magma.apply(&flip, 1.0)))
}

/// What a report shows.
pub struct ReportInput<'a> {
    /// The numbers.
    pub json: &'a CompareJson,
    /// The images' titles and more.
    pub comparison: &'a Comparison,
    /// The truth, where there is one.
    pub truth: Option<&'a Truth>,
    /// The methods' images, in the same order.
    pub images: &'a [MethodImages],
    /// How images are shown.
    pub display: Display,
    /// The command that made it, for repeating it.
    pub command: &'a str,
    /// What was approximated while loading, one sentence each.
    pub notes: &'a [String],
}

#[derive(Template)]
#[template(path = "compare.html")]
struct Page<'a> {
    json: &'a CompareJson,
    command: &'a str,
    notes: &'a [String],
    display: String,
    version: &'static str,
    lens_facts: Vec<Fact>,
    columns: Vec<Column>,
    rows: Vec<Row>,
    reference_image: Option<String>,
    pinhole_image: String,
    reference_caption: String,
    cards: Vec<Card>,
    magma: String,
    viridis: String,
    abs_error_white: f32,
    jod_white: f32,
    good_enough: Option<String>,
    plot: Option<String>,
    csv: String,
    numbers: String,
    bounds: [&'static str; 4],
}

struct Fact {
    name: &'static str,
    value: String,
}

struct Column {
    name: &'static str,
    unit: &'static str,
    help: &'static str,
}

struct Row {
    title: &'static str,
    id: &'static str,
    /// Whether it is by the method that the reference is by.
    is_reference: bool,
    verdict: Option<Verdict>,
    cells: Vec<Cell>,
}

struct Cell {
    text: String,
    /// The number by which rows are sorted; empty without.
    value: String,
    best: bool,
}

struct Card {
    title: &'static str,
    id: &'static str,
    params: String,
    image: String,
    flip: Option<String>,
    jod: Option<String>,
    abs_error: Option<String>,
    summary: String,
    verdict: Option<Verdict>,
}

/// How visible a difference is, in a word and its colour.
struct Verdict {
    word: &'static str,
    why: &'static str,
    color: String,
}

impl Verdict {
    fn of(json: &ResultJson) -> Option<Self> {
        let visibility = json.metrics.visibility?;
        let [r, g, b] = visibility.srgb8();
        Some(Self { word: visibility.word(), why: visibility.why(), color: format!("rgb({r} {g} {b})") })
    }
}

/// A column of the table: how to read it and which way is better.
struct Measure {
    column: Column,
    value: fn(&ResultJson) -> Option<f64>,
    decimals: usize,
    more_is_better: bool,
}

fn measures() -> Vec<Measure> {
    let measure = |name, unit, help, value, decimals, more_is_better| Measure {
        column: Column { name, unit, help },
        value,
        decimals,
        more_is_better,
    };
    vec![
        measure("PSNR", "dB", "Over all display values.", |r| r.metrics.psnr_db, 2, true),
        measure(
            "PSNR, defocused",
            "dB",
            "Only pixels that are blurred or changed by blur: pixels in focus inflate the figure beside this one.",
            |r| r.metrics.psnr_defocused_db,
            2,
            true,
        ),
        measure("worst block", "dB", "PSNR of the worst block.", |r| r.metrics.worst_block_psnr_db, 2, true),
        measure("SSIM", "", "Mean structural similarity, 1 for equal images.", |r| r.metrics.ssim, 4, true),
        measure(
            "JOD",
            "",
            "Quality as seen on this display, 10 for equal images; 1 less is seen by 75 % of observers. ColorVideoVDP.",
            |r| r.metrics.jod,
            2,
            true,
        ),
        measure(
            "FLIP",
            "",
            "Mean perceived difference at the display's pixels per degree, 0 for equal images.",
            |r| r.metrics.flip,
            4,
            false,
        ),
        measure("relMSE", "", "Relative squared error of linear values.", |r| r.metrics.rel_mse, 5, false),
        measure("GPU time", "ms", "Median over the runs.", |r| r.gpu_ms.map(|t| t.median), 3, false),
        measure(
            "copies",
            "",
            "GPU time over that of a copy of the image in the same runs.",
            |r| r.copy_ratio.map(|t| t.median),
            2,
            false,
        ),
    ]
}

/// Renders the report.
///
/// # Errors
///
/// An image that cannot be encoded.
pub fn html(input: &ReportInput<'_>) -> std::io::Result<String> {
    let measures = measures();
    let cards = input.comparison.results.iter().zip(input.images).zip(&input.json.results);
    let cards = cards.map(|((result, images), json)| card(result, images, json)).collect::<Result<_, _>>()?;
    let reference_image = input.truth.map(|t| data_uri(&shown(&t.color, input.display))).transpose()?;
    let page = Page {
        json: input.json,
        command: input.command,
        notes: input.notes,
        display: format!("exposure {} EV, tone map {}", input.display.exposure_ev, input.display.tone_map),
        version: env!("CARGO_PKG_VERSION"),
        lens_facts: lens_facts(input.json),
        rows: rows(input, &measures),
        columns: measures.into_iter().map(|m| m.column).collect(),
        reference_image,
        pinhole_image: data_uri(&shown(&input.comparison.pinhole, input.display))?,
        reference_caption: reference_caption(input.json),
        cards,
        magma: gradient(ColorMap::Magma),
        viridis: gradient(ColorMap::Viridis),
        abs_error_white: ABS_ERROR_WHITE,
        jod_white: 10.0 * JOD_MAP_WHITE,
        plot: curves::error_plot(input.json).map(|plot| plot.svg()),
        csv: download("text/csv", table::csv([input.json]).map_err(std::io::Error::other)?.as_bytes()),
        numbers: download("application/json", &serde_json::to_vec_pretty(input.json)?),
        good_enough: input.json.good_enough.as_ref().map(|found| good_enough_in_words(found, input.json)),
        bounds: Visibility::ALL.map(Visibility::why),
    };
    page.render().map_err(std::io::Error::other)
}

fn lens_facts(json: &CompareJson) -> Vec<Fact> {
    let lens = &json.setting.lens;
    let fact = |name, value| Fact { name, value };
    let mut facts = vec![
        fact("E", format!("{:.4} mm", lens.aperture_diameter_mm)),
        fact("F", format!("{:.4} mm", lens.focal_length_mm)),
        fact("dr", format!("{} mm", lens.image_distance_mm)),
        fact("ds", format!("{} mm", lens.screen_distance_mm)),
        fact("DPI", format!("{} px/mm", lens.density_px_per_mm)),
        fact("focus", lens.focus_m.map_or("infinity".into(), |m| format!("{m:.4} m"))),
        fact("K", format!("{:.3} px", lens.k_px)),
        fact("aperture", lens.aperture.clone()),
    ];
    if !lens.eye.is_plain() {
        facts.push(fact("eye", eye_in_words(&lens.eye)));
    }
    let viewing = &json.viewing;
    let screen = &viewing.screen;
    facts.push(fact("pixels per degree", format!("{:.2}", viewing.px_per_degree)));
    let range = if screen.hdr { ", high dynamic range" } else { "" };
    let light = format!("{} to {} cd/m² in {} lux{range}", screen.black_cd_m2, screen.peak_cd_m2, screen.ambient_lux);
    facts.push(fact("display", light));
    if let Some(coc) = &json.setting.coc {
        facts.push(fact("mean CoC", format!("{:.2} px", coc.mean_px)));
        facts.push(fact("CoC range", format!("{:.2} to {:.2} px", coc.min_signed_px, coc.max_signed_px)));
    }
    facts
}

fn eye_in_words(eye: &Eye) -> String {
    let accommodation = eye.accommodation_d.map(|d| format!("accommodates {d:.2} D"));
    let chromatic = eye.chromatic.map(|[r, g, b]| format!("chromatic aberration at {r}, {g} and {b} nm"));
    let refraction = (eye.refraction != Default::default()).then(|| format!("needs {}", eye.refraction));
    [refraction, accommodation, chromatic].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn rows(input: &ReportInput<'_>, measures: &[Measure]) -> Vec<Row> {
    let results = &input.json.results;
    // Neither the picture without blur nor the reference itself is the best of anything.
    let is_judged = |r: &ResultJson| r.method != "pinhole" && !curves::is_reference(input.json, r);
    let best = |measure: &Measure| {
        let values = results.iter().filter(|r| is_judged(r)).filter_map(measure.value);
        if measure.more_is_better { values.reduce(f64::max) } else { values.reduce(f64::min) }
    };
    let best: Vec<Option<f64>> = measures.iter().map(best).collect();
    let row = |(json, result): (&ResultJson, &MethodResult)| {
        let cell = |(measure, best): (&Measure, &Option<f64>)| {
            let value = (measure.value)(json);
            let identical = json.metrics.identical == Some(true) && measure.column.unit == "dB";
            let text = match value {
                Some(value) => format!("{value:.*}", measure.decimals),
                None if identical => "identical".into(),
                None => "–".into(),
            };
            let best = value.is_some() && value == *best && is_judged(json);
            Cell { text, value: value.map_or_else(String::new, |v| v.to_string()), best }
        };
        Row {
            title: result.title,
            id: result.method,
            is_reference: curves::is_reference(input.json, json),
            verdict: Verdict::of(json),
            cells: measures.iter().zip(&best).map(cell).collect(),
        }
    };
    let mut rows: Vec<Row> = results.iter().zip(&input.comparison.results).map(row).collect();
    rows.sort_by_key(|row| row.is_reference);
    rows
}

/// Which method is good enough, in a sentence.
pub fn good_enough_in_words(found: &GoodEnough, json: &CompareJson) -> String {
    let least = found.jod;
    let Some(id) = found.method else { return format!("No method reaches {least} JOD here.") };
    let result = json.results.iter().find(|r| r.method == id);
    let cost = result.and_then(|r| r.gpu_ms).map_or(String::new(), |ms| format!(" in {:.3} ms", ms.median));
    let has = result.and_then(|r| r.metrics.jod).map_or(String::new(), |jod| format!(" with {jod:.2} JOD"));
    format!("The cheapest method that reaches {least} JOD on {} is {id}{has}{cost}.", json.setting.adapter)
}

fn reference_caption(json: &CompareJson) -> String {
    let Some(reference) = &json.reference else { return String::new() };
    let mut caption = reference.method.to_owned();
    if let Some(samples) = reference.samples {
        caption += &format!(", {samples} lens points");
    }
    if let Some(db) = reference.self_psnr_db {
        caption += &format!(", converged to about {db:.1} dB");
    }
    caption
}

fn card(result: &MethodResult, images: &MethodImages, json: &ResultJson) -> std::io::Result<Card> {
    let params: Vec<String> = result.params.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let times = json.gpu_ms.map(|t| format!("{:.3} ms ({:.3} to {:.3}, {} runs)", t.median, t.min, t.max, t.runs));
    let errors = json.metrics.psnr_db.map(|db| format!("{db:.2} dB"));
    let identical = (json.metrics.identical == Some(true)).then(|| "identical to the reference".to_owned());
    let summary: Vec<String> = [errors, identical, times].into_iter().flatten().collect();
    Ok(Card {
        title: result.title,
        id: result.method,
        params: params.join(", ").replace('"', ""),
        image: data_uri(&images.image)?,
        flip: images.flip.as_ref().map(data_uri).transpose()?,
        jod: images.jod.as_ref().map(data_uri).transpose()?,
        abs_error: images.abs_error.as_ref().map(data_uri).transpose()?,
        summary: summary.join(" · "),
        verdict: Verdict::of(json),
    })
}

/// A file within the page.
fn download(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

fn data_uri(image: &Image<[u8; 3]>) -> std::io::Result<String> {
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(image.pixels.as_flattened(), image.size.x, image.size.y, ExtendedColorType::Rgb8)
        .map_err(std::io::Error::other)?;
    Ok(download("image/png", &png))
}

/// A colour map as stops of a CSS gradient.
pub(super) fn gradient(map: ColorMap) -> String {
    let stop = |i: u8| {
        let [r, g, b] = map.srgb8(f32::from(i) / 16.0);
        format!("rgb({r} {g} {b})")
    };
    (0..=16).map(stop).collect::<Vec<_>>().join(", ")
}
