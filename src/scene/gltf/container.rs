//! From a path to JSON and bytes: the binary container, external files and data URIs.

use super::super::error::SceneProblem;
use ::gltf::json;
use base64::Engine;
use serde::Deserialize;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Size of the binary container's header and of a chunk's header, bytes.
const HEADER_BYTES: usize = 12;

/// A parsed file.
pub(super) struct GltfFile {
    /// The JSON as the `gltf` crate understands it.
    pub root: json::Root,
    /// The parts of the same JSON that the crate rounds to f32 or leaves out.
    pub exact: Exact,
    /// The binary chunk of a `.glb`.
    pub blob: Option<Vec<u8>>,
}

/// What is read from the JSON in double precision: poses and cameras. A scene far from
/// the origin, or a frame's aspect ratio, must not lose digits.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Exact {
    pub nodes: Vec<ExactNode>,
    pub cameras: Vec<ExactCamera>,
    pub scenes: Vec<ExactScene>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactNode {
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactCamera {
    pub perspective: Option<ExactPerspective>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ExactPerspective {
    pub yfov: f64,
    pub znear: f64,
    pub aspect_ratio: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactScene {
    pub extras: Option<serde_json::Value>,
}

/// Reads and parses the file, without following its references.
pub(super) fn read(path: &Path) -> Result<GltfFile, SceneProblem> {
    parse(&read_file(path, "it")?)
}

/// Parses a file's content, without following its references.
pub(super) fn parse(bytes: &[u8]) -> Result<GltfFile, SceneProblem> {
    let (text, blob) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (Cow::Borrowed(bytes), None) };
    let not_gltf = |detail: String| SceneProblem::NotGltf { detail };
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(not_gltf("the file is empty".to_owned()));
    }
    let value: serde_json::Value =
        serde_json::from_slice(&text).map_err(|e| not_gltf(format!("no valid JSON: {e}")))?;
    check_version(&value)?;
    let schema =
        |e: serde_json::Error| SceneProblem::invalid("its JSON", format!("does not follow the glTF schema ({e})"));
    let root = json::Root::from_slice(&text).map_err(schema)?;
    let exact = Exact::deserialize(&value).map_err(schema)?;
    Ok(GltfFile { root, exact, blob })
}

fn check_version(value: &serde_json::Value) -> Result<(), SceneProblem> {
    let version = value.get("asset").and_then(|asset| asset.get("version")).and_then(|v| v.as_str());
    match version {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => Err(SceneProblem::NotGltf { detail: format!("its asset version is {version:?}") }),
        None => Err(SceneProblem::NotGltf { detail: "it has no asset.version".to_owned() }),
    }
}

type Chunks<'a> = (Cow<'a, [u8]>, Option<Vec<u8>>);

/// The JSON and binary chunks. The crate subtracts the header's size from the declared
/// length without looking, so that is checked before.
fn split_glb(bytes: &[u8]) -> Result<Chunks<'_>, SceneProblem> {
    let damaged = |detail: String| SceneProblem::Container { detail };
    let length = bytes.get(8..HEADER_BYTES).and_then(|field| field.try_into().ok()).map(u32::from_le_bytes);
    match length {
        None => return Err(damaged(format!("only {} bytes", bytes.len()))),
        Some(length) if (length as usize) < HEADER_BYTES => return Err(damaged(format!("declared length {length}"))),
        Some(length) if length as usize > bytes.len() => {
            return Err(damaged(format!("truncated: {} of {length} bytes", bytes.len())));
        }
        Some(_) => {}
    }
    let glb = gltf::Glb::from_slice(bytes).map_err(|e| damaged(e.to_string()))?;
    Ok((glb.json, glb.bin.map(Cow::into_owned)))
}

/// The bytes of all buffers, each at least as long as it is declared.
pub(super) struct Buffers {
    bytes: Vec<Vec<u8>>,
}

impl Buffers {
    /// Loads every buffer of the document.
    pub(super) fn load(
        document: &gltf::Document,
        mut blob: Option<Vec<u8>>,
        scene_path: &Path,
    ) -> Result<Self, SceneProblem> {
        let load_one = |buffer: gltf::Buffer| {
            let item = format!("buffers[{}]", buffer.index());
            let bytes = match buffer.source() {
                gltf::buffer::Source::Bin => blob
                    .take()
                    .ok_or_else(|| SceneProblem::invalid(&item, "has no uri, and there is no binary chunk for it"))?,
                gltf::buffer::Source::Uri(uri) => read_uri(uri, &item, scene_path)?,
            };
            if bytes.len() < buffer.length() {
                return Err(SceneProblem::OutOfBytes {
                    item,
                    holder: "its data".to_owned(),
                    needed: buffer.length() as u64,
                    available: bytes.len() as u64,
                });
            }
            Ok(bytes)
        };
        Ok(Self { bytes: document.buffers().map(load_one).collect::<Result<_, _>>()? })
    }

    /// The bytes of the buffer view with that index in the (validated) document.
    pub(super) fn view_at(&self, document: &gltf::Document, index: usize) -> Result<&[u8], SceneProblem> {
        let missing = || SceneProblem::invalid(format!("bufferViews[{index}]"), "is not in the file");
        self.view(&document.views().nth(index).ok_or_else(missing)?)
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, view: &gltf::buffer::View) -> Result<&[u8], SceneProblem> {
        let buffer_index = view.buffer().index();
        let buffer = &self.bytes[buffer_index];
        let item = || format!("bufferViews[{}]", view.index());
        let Some(end) = view.offset().checked_add(view.length()) else {
            let detail = format!("offset {} + length {}", view.offset(), view.length());
            return Err(SceneProblem::Oversize { item: item(), detail });
        };
        buffer.get(view.offset()..end).ok_or_else(|| SceneProblem::OutOfBytes {
            item: item(),
            holder: format!("buffers[{buffer_index}]"),
            needed: end as u64,
            available: buffer.len() as u64,
        })
    }
}

/// The bytes behind a `uri`: a base64 data URI, or a file beside the scene.
pub(super) fn read_uri(uri: &str, item: &str, scene_path: &Path) -> Result<Vec<u8>, SceneProblem> {
    let refused = |detail: String| {
        let shown: String = uri.chars().take(60).collect();
        SceneProblem::Uri { item: item.to_owned(), uri: shown, detail }
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, encoded) = data
            .split_once(";base64,")
            .ok_or_else(|| refused("a data URI that is not base64; export the scene as .glb".to_owned()))?;
        return base64::engine::general_purpose::STANDARD
            .decode(encoded)
            .map_err(|e| refused(format!("damaged base64 ({e}); export the scene again")));
    }
    if uri.contains("://") || uri.starts_with("file:") {
        return Err(refused("only files beside the scene and data URIs are read; export the scene as .glb".to_owned()));
    }
    let relative = percent_decoded(uri)
        .ok_or_else(|| refused("its percent-encoding is damaged; rename the file and export again".to_owned()))?;
    let file: PathBuf = scene_path.parent().unwrap_or(Path::new("")).join(relative);
    read_file(&file, &format!("{item}, the file {}", file.display()))
}

/// Reads a regular file; a device or directory is refused instead of read without end.
fn read_file(path: &Path, what: &str) -> Result<Vec<u8>, SceneProblem> {
    let unreadable = |source| SceneProblem::Unreadable { what: what.to_owned(), source };
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        let source = std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file");
        return Err(unreadable(source));
    }
    std::fs::read(path).map_err(unreadable)
}

/// Undoes `%20` and the like; `None` if what remains is not text.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped = (*first == b'%').then(|| tail.get(..2)).flatten().and_then(|hex| std::str::from_utf8(hex).ok());
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}
