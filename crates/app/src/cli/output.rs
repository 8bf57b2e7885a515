//! What goes to files and to standard output, whole or not at all.

use super::progress::check_interrupt;
use anyhow::{Context, bail, ensure};
use defocus::image_io::write_atomically;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Kind of an image file to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageKind {
    /// Display-referred, 8 bits.
    Png,
    /// Linear, 32-bit float.
    Exr,
}

impl ImageKind {
    /// The kind that a file's name asks for.
    pub fn of(file: &Path) -> anyhow::Result<Self> {
        match file.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => bail!("{}: cannot write this kind of image; give a name that ends in .png or .exr", file.display()),
        }
    }
}

/// An error unless a file can be put where `file` says: found out before the work, not
/// after it.
pub fn check_folder_of(file: &Path) -> anyhow::Result<()> {
    let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        bail!("{}: there is no folder {}; make it first", file.display(), folder.display());
    }
    if file.is_dir() {
        bail!("{}: is a folder; give the name of a file", file.display());
    }
    Ok(())
}

/// Whether results go to standard output, which then holds nothing else.
pub fn is_stdout(json: Option<&PathBuf>) -> bool {
    json.is_some_and(|file| file.as_os_str() == "-")
}

/// The checks of [`check_folder_of`] for a `--json` option.
pub fn check_json(json: Option<&PathBuf>) -> anyhow::Result<()> {
    json.filter(|_| !is_stdout(json)).map_or(Ok(()), |file| check_folder_of(file))
}

/// Writes JSON where `--json` says, if it was given.
pub fn write_json(json: Option<&PathBuf>, value: &impl Serialize) -> anyhow::Result<()> {
    let Some(file) = json else { return Ok(()) };
    if is_stdout(Some(file)) {
        return print_json(value);
    }
    check_interrupt()?;
    let text = serde_json::to_string_pretty(value)?;
    write_atomically(file, |out| writeln!(out, "{text}"))?;
    Ok(())
}

/// Prints JSON on standard output.
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}

/// Prints text and a line's end on standard output; that nobody reads it any more
/// (`defocus methods | head`) is no error.
pub fn print(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// Says on standard error what is approximated or left out of a scene, a line each.
pub fn print_notes(notes: &[String], quiet: bool) {
    for note in notes.iter().filter(|_| !quiet) {
        // A note may quote names and messages of a file.
        eprintln!("defocus: note: {}", note.split_whitespace().collect::<Vec<_>>().join(" "));
    }
}

/// An error unless a folder is there, or can be made, under that name.
pub fn check_target(folder: &Path) -> anyhow::Result<()> {
    let parent = parent_of(folder);
    ensure!(parent.is_dir(), "{}: there is no folder {}; make it first", folder.display(), parent.display());
    ensure!(
        folder.is_dir() || !folder.exists(),
        "{}: is a file; give the name of a folder, or of one to make",
        folder.display()
    );
    Ok(())
}

/// The folder that something lies in.
pub fn parent_of(folder: &Path) -> &Path {
    folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The command as it was given, quoted where a shell needs it.
pub fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
    let quoted = |arg: String| {
        let is_plain = !arg.is_empty() && arg.chars().all(plain);
        if is_plain { arg } else { format!("'{}'", arg.replace('\'', r"'\''")) }
    };
    let args = std::env::args_os().skip(1).map(|arg| quoted(arg.to_string_lossy().into_owned()));
    std::iter::once("defocus".to_owned()).chain(args).collect::<Vec<_>>().join(" ")
}
