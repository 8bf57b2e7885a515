//! The comparison of all panes as one HTML file.

use super::compared::{Order, compare_document, said};
use defocus::image_io::write_atomically;
use defocus_study::Progress;
use defocus_study::report::{self, ReportInput};
use std::io::Write;
use std::path::Path;

/// Compares what `order` names and writes the file.
///
/// # Errors
///
/// In a sentence: a method that cannot render it, a file that cannot be written, or that
/// `progress` asked to stop.
pub fn write(order: &Order, file: &Path, progress: &mut Progress<'_>) -> Result<(), String> {
    let compared = compare_document(order, progress)?;
    let html = report::html(&ReportInput {
        json: &compared.json,
        comparison: &compared.comparison,
        truth: compared.truth.as_ref(),
        images: &compared.images,
        display: compared.display,
        command: &compared.command,
        notes: &compared.notes,
    })
    .map_err(|e| said(&e))?;
    write_atomically(file, |out| out.write_all(html.as_bytes())).map_err(|e| said(&e))
}
