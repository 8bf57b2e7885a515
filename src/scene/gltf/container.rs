//! From a path to JSON and bytes: the binary container, external files and data URIs.

use super::super::error::SceneProblem;
use super::exact::{Exact, Meshopt};
use super::{meshopt, reduce};
use ::gltf::json;
use base64::Engine;
use serde::Deserialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Size of the binary container's header, bytes.
const HEADER_BYTES: usize = 12;

/// Size of a chunk's header in the binary container, bytes.
const CHUNK_HEADER_BYTES: usize = 8;

/// A parsed file.
pub(super) struct GltfFile {
    /// What is read of the JSON, as the `gltf` crate understands it.
    pub root: json::Root,
    /// The parts of the same JSON that the crate rounds to f32 or leaves out.
    pub exact: Exact,
    /// The binary chunk of a `.glb`.
    pub blob: Option<Vec<u8>>,
}

/// Reads and parses the file, without following its references.
pub(super) fn read(path: &Path) -> Result<GltfFile, SceneProblem> {
    parse(&read_file(path, "it")?)
}

/// Parses the bytes of a file, without following its references.
pub(super) fn parse(bytes: &[u8]) -> Result<GltfFile, SceneProblem> {
    let (text, blob) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let not_gltf = |detail: String| SceneProblem::NotGltf { detail };
    let text = without_padding(text);
    if text.is_empty() {
        return Err(not_gltf("the file is empty".to_owned()));
    }
    let mut value: serde_json::Value =
        serde_json::from_slice(text).map_err(|e| not_gltf(format!("no valid JSON: {e}")))?;
    check_version(&value)?;
    let schema =
        |e: serde_json::Error| SceneProblem::invalid("its JSON", format!("does not follow the glTF schema ({e})"));
    reduce::integers(&mut value);
    reduce::cameras(&mut value);
    let exact = Exact::deserialize(&value).map_err(schema)?;
    reduce::to_what_is_read(&mut value);
    let root = json::Root::deserialize(value).map_err(schema)?;
    Ok(GltfFile { root, exact, blob: blob.map(<[u8]>::to_vec) })
}

/// The text without a byte order mark before it, and without the zeros and blanks with
/// which exporters fill up a chunk or a file.
fn without_padding(text: &[u8]) -> &[u8] {
    let mut text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    while let [rest @ .., last] = text
        && (*last == 0 || last.is_ascii_whitespace())
    {
        text = rest;
    }
    text
}

fn check_version(value: &serde_json::Value) -> Result<(), SceneProblem> {
    let version = value.get("asset").and_then(|asset| asset.get("version")).and_then(|v| v.as_str());
    match version {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => Err(SceneProblem::NotGltf { detail: format!("its asset version is {version:?}") }),
        None => Err(SceneProblem::NotGltf { detail: "it has no asset.version".to_owned() }),
    }
}

/// The JSON and binary chunks (glTF 2.0, section 4.4). Chunks of other kinds and bytes
/// behind the declared length are ignored, as the specification asks for.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), SceneProblem> {
    let damaged = |detail: String| SceneProblem::Container { detail };
    let word = |bytes: &[u8], at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(damaged(format!("only {} bytes", bytes.len())));
    };
    let length = length as usize;
    if version != 2 {
        return Err(damaged(format!("unsupported version {version} of the container")));
    }
    if length < HEADER_BYTES {
        return Err(damaged(format!("declared length {length}")));
    }
    let whole = bytes.get(..length).ok_or_else(|| damaged(format!("truncated: {} of {length} bytes", bytes.len())))?;

    let mut rest = &whole[HEADER_BYTES..];
    let (mut text, mut blob) = (None, None);
    while let (Some(size), Some(kind)) = (word(rest, 0), rest.get(4..CHUNK_HEADER_BYTES)) {
        let size = size as usize;
        let shown = String::from_utf8_lossy(kind.strip_suffix(b"\0").unwrap_or(kind)).escape_default().to_string();
        let content = &rest[CHUNK_HEADER_BYTES..];
        let chunk = content
            .get(..size)
            .ok_or_else(|| damaged(format!("{shown} chunk length {size}, where {} bytes follow", content.len())))?;
        match kind {
            b"JSON" if text.is_none() => text = Some(chunk),
            b"BIN\0" if text.is_some() && blob.is_none() => blob = Some(chunk),
            _ if text.is_none() => {
                return Err(damaged(format!("its first chunk is of the unknown chunk type {shown}")));
            }
            _ => {}
        }
        // Chunks are filled up to whole words; a last one may lack its filling.
        rest = content.get(size.next_multiple_of(4)..).unwrap_or_default();
    }
    text.map(|text| (text, blob)).ok_or_else(|| damaged("it has no JSON chunk".to_owned()))
}

/// The bytes of all buffers, each at least as long as it is declared, and of the buffer
/// views that are stored compressed.
pub(super) struct Buffers {
    bytes: Vec<Vec<u8>>,
    decoded: HashMap<usize, Vec<u8>>,
    /// By accessor, the elements of those that are stored in a stream of another kind.
    accessors: HashMap<usize, Vec<u8>>,
}

impl Buffers {
    /// Loads every buffer of the document, and decodes the compressed views.
    pub(super) fn load(
        document: &gltf::Document,
        exact: &Exact,
        mut blob: Option<Vec<u8>>,
        scene_path: &Path,
    ) -> Result<Self, SceneProblem> {
        let needed = needed(document, exact);
        let load_one = |buffer: gltf::Buffer| {
            let item = format!("buffers[{}]", buffer.index());
            let bytes = match buffer.source() {
                _ if !needed[buffer.index()] => return Ok(Vec::new()),
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
        let bytes = document.buffers().map(load_one).collect::<Result<_, _>>()?;
        let mut buffers = Self { bytes, decoded: HashMap::new(), accessors: HashMap::new() };
        let mut left = meshopt::most_decoded_bytes(buffers.total_bytes());
        for view in document.views() {
            if let Some(source) = meshopt_of(exact, view.index()) {
                let item = format!("bufferViews[{}]", view.index());
                let encoded = buffers.slice(source.buffer, source.byte_offset, source.byte_length, &item)?;
                left = left.checked_sub(view.length()).ok_or_else(|| SceneProblem::Oversize {
                    item: item.clone(),
                    detail: "it and those before it decode to more than the file can hold".to_owned(),
                })?;
                let decoded = meshopt::decode(source, encoded, view.length(), &item)?;
                buffers.decoded.insert(view.index(), decoded);
            }
        }
        Ok(buffers)
    }

    /// Bytes of all buffers and decoded views together.
    pub(super) fn total_bytes(&self) -> usize {
        self.bytes.iter().chain(self.decoded.values()).chain(self.accessors.values()).map(Vec::len).sum()
    }

    /// The decoded elements of an accessor, one behind the other, where they come from a stream.
    pub(super) fn accessor(&self, index: usize) -> Option<&[u8]> {
        self.accessors.get(&index).map(Vec::as_slice)
    }

    /// Gives an accessor elements that were decoded from a stream.
    #[cfg(feature = "draco")]
    pub(super) fn fill_accessor(&mut self, index: usize, elements: Vec<u8>) {
        self.accessors.insert(index, elements);
    }

    /// The bytes of a buffer view of a document that is being changed.
    #[cfg(feature = "draco")]
    pub(super) fn raw_view(&self, view: &json::buffer::View, index: usize) -> Result<&[u8], SceneProblem> {
        let too_large = || SceneProblem::Oversize {
            item: format!("bufferViews[{index}]"),
            detail: "its length is more than this machine can address".to_owned(),
        };
        let offset = view.byte_offset.map_or(Ok(0), |offset| usize::try_from(offset.0)).map_err(|_| too_large())?;
        let length = usize::try_from(view.byte_length.0).map_err(|_| too_large())?;
        self.slice(view.buffer.value(), offset, length, &format!("bufferViews[{index}]"))
    }

    /// The bytes of the buffer view with that index in the (validated) document.
    pub(super) fn view_at(&self, document: &gltf::Document, index: usize) -> Result<&[u8], SceneProblem> {
        let missing = || SceneProblem::invalid(format!("bufferViews[{index}]"), "is not in the file");
        self.view(&document.views().nth(index).ok_or_else(missing)?)
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, view: &gltf::buffer::View) -> Result<&[u8], SceneProblem> {
        match self.decoded.get(&view.index()) {
            Some(decoded) => Ok(decoded),
            None => {
                let item = format!("bufferViews[{}]", view.index());
                self.slice(view.buffer().index(), view.offset(), view.length(), &item)
            }
        }
    }

    fn slice(&self, buffer: usize, offset: usize, length: usize, item: &str) -> Result<&[u8], SceneProblem> {
        let missing = || SceneProblem::invalid(item, format!("refers to buffers[{buffer}], which is not in the file"));
        let bytes = self.bytes.get(buffer).ok_or_else(missing)?;
        let Some(end) = offset.checked_add(length) else {
            let detail = format!("offset {offset} + length {length}");
            return Err(SceneProblem::Oversize { item: item.to_owned(), detail });
        };
        bytes.get(offset..end).ok_or_else(|| SceneProblem::OutOfBytes {
            item: item.to_owned(),
            holder: format!("buffers[{buffer}]"),
            needed: end as u64,
            available: bytes.len() as u64,
        })
    }
}

/// Per buffer, whether anything refers to it: what stands in for views that are stored
/// compressed elsewhere has no data of its own.
fn needed(document: &gltf::Document, exact: &Exact) -> Vec<bool> {
    let mut is_needed = vec![false; document.buffers().len()];
    let compressed = exact.buffer_views.iter().filter_map(|view| view.extensions.meshopt());
    let plain = document.views().filter(|view| meshopt_of(exact, view.index()).is_none());
    for index in plain.map(|view| view.buffer().index()).chain(compressed.map(|source| source.buffer)) {
        is_needed.get_mut(index).into_iter().for_each(|flag| *flag = true);
    }
    is_needed
}

fn meshopt_of(exact: &Exact, view: usize) -> Option<&Meshopt> {
    exact.buffer_views.get(view)?.extensions.meshopt()
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
