//! Writes the folder.

use super::caption::{caption, readme};
use crate::window::compared::{Compared, Order, compare_document, said};
use crate::window::model::{PaperChoice, state};
use defocus::colormap::ColorMap;
use defocus::image::Image;
use defocus::image_io::{write_atomically, write_png_rgb};
use defocus_study::curves::{CocCurve, error_plot};
use defocus_study::metrics::BLOCK_SIDE_PX;
use defocus_study::report::{ABS_ERROR_WHITE, JOD_MAP_WHITE, MethodImages, shown};
use defocus_study::{Progress, table};
use glam::{UVec2, uvec2};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// How much larger a detail is shown: every pixel is this many wide.
const DETAIL_SCALE: u32 = 3;

/// Side of a detail around the worst place, as a part of the picture's shorter side.
const DETAIL_PART: u32 = 4;

/// A part of the picture: its first pixel and its size, px.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Upper left corner, px.
    pub min: UVec2,
    /// Size, px.
    pub size: UVec2,
}

impl Part {
    /// The part of a picture of `size` px between two corners, each from (0, 0) to (1, 1).
    fn between(size: UVec2, [from, to]: [[f32; 2]; 2]) -> Self {
        let px = |share: [f32; 2]| {
            let share = share.map(|v| f64::from(if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) }));
            uvec2((share[0] * f64::from(size.x)).round() as u32, (share[1] * f64::from(size.y)).round() as u32)
        };
        let (a, b) = (px(from).min(size - 1), px(to));
        Self { min: a, size: b.max(a + 1) - a }
    }

    /// A square around a block of the picture.
    fn around(size: UVec2, block: UVec2) -> Self {
        let side = (size.min_element() / DETAIL_PART).max(BLOCK_SIDE_PX).min(size.min_element());
        let middle = block + BLOCK_SIDE_PX / 2;
        let min = middle.saturating_sub(UVec2::splat(side / 2)).min(size - side);
        Self { min, size: UVec2::splat(side) }
    }

    /// It, magnified.
    fn of(self, image: &Image<[u8; 3]>) -> Image<[u8; 3]> {
        Image::from_fn(self.size * DETAIL_SCALE, |x, y| {
            image.at(self.min.x + x / DETAIL_SCALE, self.min.y + y / DETAIL_SCALE)
        })
    }
}

/// Compares what `order` names and writes the folder. `visible`: corners of the part that the
/// panes show, where they are magnified.
///
/// # Errors
///
/// In a sentence: a method that cannot render it, a folder that cannot be written, or that
/// `progress` asked to stop.
pub fn write(
    order: &Order,
    choice: &PaperChoice,
    visible: Option<[[f32; 2]; 2]>,
    progress: &mut Progress<'_>,
) -> Result<(), String> {
    let compared = compare_document(order, progress)?;
    let folder = Path::new(choice.folder.trim());
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let cannot = |e: std::io::Error| {
        format!("{}: cannot write it: {e}; check that its folder may be written and has space", folder.display())
    };
    std::fs::create_dir_all(parent).map_err(cannot)?;
    let temporary = tempfile::Builder::new().prefix(".defocus-").tempdir_in(parent).map_err(cannot)?;
    let files = write_files(temporary.path(), order, choice, &compared, detail(&compared, visible))?;
    std::fs::create_dir_all(folder).map_err(cannot)?;
    for file in files {
        std::fs::rename(temporary.path().join(&file), folder.join(&file)).map_err(cannot)?;
    }
    Ok(())
}

/// What is shown magnified, or what lies around the worst block of the first method.
fn detail(compared: &Compared, visible: Option<[[f32; 2]; 2]>) -> Option<Part> {
    let size = compared.comparison.pinhole.size;
    let worst = || compared.json.results.iter().find_map(|r| r.metrics.worst_block);
    match visible {
        Some(corners) => Some(Part::between(size, corners)),
        None => worst().map(|[x, y]| Part::around(size, uvec2(x, y))),
    }
}

/// Writes everything into an empty folder; the names of the files.
fn write_files(
    folder: &Path,
    order: &Order,
    choice: &PaperChoice,
    compared: &Compared,
    detail: Option<Part>,
) -> Result<Vec<String>, String> {
    let mut files: Vec<String> = Vec::new();
    let text = |name: &str, content: &str, files: &mut Vec<String>| {
        files.push(name.to_owned());
        write_atomically(&folder.join(name), |out| out.write_all(content.as_bytes())).map_err(|e| said(&e))
    };
    let detail = detail.filter(|_| choice.details);
    let picture = |name: &str, image: &Image<[u8; 3]>, files: &mut Vec<String>| {
        let mut png = |name: String, image: &Image<[u8; 3]>| {
            let written = write_png_rgb(&folder.join(&name), image).map_err(|e| said(&e));
            files.push(name);
            written
        };
        png(format!("{name}.png"), image)?;
        detail.map_or(Ok(()), |part| png(format!("{name}-detail.png"), &part.of(image)))
    };
    picture("pinhole", &shown(&compared.comparison.pinhole, compared.display), &mut files)?;
    if let Some(truth) = &compared.truth {
        picture("reference", &shown(&truth.color, compared.display), &mut files)?;
    }
    for (number, images) in (1..).zip(&compared.images) {
        let MethodImages { method, image, flip, jod, abs_error } = images;
        let name = format!("{number}-{method}");
        picture(&name, image, &mut files)?;
        let maps = [("flip", flip), ("visible", jod), ("error", abs_error)];
        for (kind, map) in maps.into_iter().filter(|_| choice.maps) {
            map.as_ref().map_or(Ok(()), |map| picture(&format!("{name}-{kind}"), map, &mut files))?;
        }
    }
    if choice.maps && compared.truth.is_some() {
        text("scales.svg", &scales(), &mut files)?;
    }
    if choice.plots {
        if let Some(range_m) = CocCurve::range_m(compared.depth_m.pixels.iter().copied()) {
            let curve = CocCurve::of(&order.document.lens, range_m);
            text("coc.svg", &curve.plot().svg_file(), &mut files)?;
            text("coc.csv", &curve.csv(), &mut files)?;
        }
        if let Some(plot) = error_plot(&compared.json) {
            text("quality-time.svg", &plot.svg_file(), &mut files)?;
        }
    }
    if choice.table {
        text("table.csv", &table::csv([&compared.json]).map_err(|e| said(&e))?, &mut files)?;
        let json = serde_json::to_string_pretty(&compared.json).map_err(|e| said(&e))?;
        text("table.json", &(json + "\n"), &mut files)?;
    }
    let name = format!("state.{}", state::EXTENSION);
    state::write(&folder.join(&name), &order.document).map_err(|e| said(&e))?;
    files.push(name);
    text("caption.txt", &caption(compared, detail.is_some()), &mut files)?;
    let listed = files.clone();
    text("README.md", &readme(compared, &order.document, &listed), &mut files)?;
    Ok(files)
}

/// The colours of the maps with their ends.
fn scales() -> String {
    let maps = [
        ("FLIP", ColorMap::Magma, "0", "1".to_owned()),
        ("visible difference", ColorMap::Magma, "0 JOD", format!("{} JOD and more", 10.0 * JOD_MAP_WHITE)),
        ("absolute error", ColorMap::Viridis, "0", format!("{ABS_ERROR_WHITE} and more")),
    ];
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 460 132\" font-family=\"sans-serif\" font-size=\"12\">\n",
    );
    for (row, (title, map, low, high)) in maps.into_iter().enumerate() {
        let top = 44 * row;
        for step in 0..64_u16 {
            let [r, g, b] = map.srgb8(f32::from(step) / 63.0);
            let x = 10.0 + 5.0 * f64::from(step);
            // Writing into a String cannot fail.
            let _ = writeln!(
                svg,
                "<rect x=\"{x}\" y=\"{}\" width=\"5.5\" height=\"10\" fill=\"rgb({r},{g},{b})\"/>",
                top + 18
            );
        }
        let _ = writeln!(svg, "<text x=\"10\" y=\"{}\">{title}</text>", top + 13);
        let _ = writeln!(
            svg,
            "<text x=\"10\" y=\"{}\">{low}</text><text x=\"330\" y=\"{}\" text-anchor=\"end\">{high}</text>",
            top + 41,
            top + 41
        );
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_in_the_picture_wherever_they_are_asked_for() {
        let size = uvec2(64, 48);
        for corners in
            [[[0.0, 0.0], [1.0, 1.0]], [[0.9, 0.9], [0.9, 0.9]], [[f32::NAN, -1.0], [2.0, 0.5]], [[1.0; 2]; 2]]
        {
            let part = Part::between(size, corners);
            assert!(part.size.min_element() >= 1 && (part.min + part.size).cmple(size).all(), "{corners:?}: {part:?}");
        }
        for block in [UVec2::ZERO, uvec2(56, 40), uvec2(24, 16)] {
            let part = Part::around(size, block);
            assert_eq!(part.size, uvec2(12, 12));
            assert!((part.min + part.size).cmple(size).all(), "{block}: {part:?}");
        }
        let image = Image::from_fn(size, |x, y| [x as u8, y as u8, 0]);
        let part = Part { min: uvec2(3, 5), size: uvec2(2, 1) };
        let magnified = part.of(&image);
        assert_eq!((magnified.size, magnified.at(5, 2)), (uvec2(6, 3), [4, 5, 0]));
    }
}
