//! Typed numbers out of buffers, every extent checked with arithmetic that cannot wrap.

use super::super::error::SceneProblem;
use super::container::Buffers;
use ::gltf::Accessor;
use ::gltf::accessor::{DataType, sparse::IndexType};

/// Elements that an accessor may have without bytes behind them: a sparse accessor alone
/// could otherwise ask for any amount of zeros. 4 million, a quarter of a gigabyte of matrices.
const MAX_UNBACKED_COUNT: usize = 1 << 22;

/// `accessors[3] "name"`.
pub(super) fn label(accessor: &Accessor) -> String {
    match accessor.name() {
        Some(name) => format!("accessors[{}] {name:?}", accessor.index()),
        None => format!("accessors[{}]", accessor.index()),
    }
}

/// A run of equally spaced elements.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    /// Element `i`, from its first byte on. `i` must be below `count`.
    fn at(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..]
    }

    /// `count` elements of `size` bytes, one behind the other.
    fn packed(bytes: &'a [u8], (count, size): (usize, usize), item: &str) -> Result<Self, SceneProblem> {
        let needed = count.saturating_mul(size);
        if needed > bytes.len() {
            return Err(SceneProblem::OutOfBytes {
                item: item.to_owned(),
                holder: "its compressed stream".to_owned(),
                needed: needed as u64,
                available: bytes.len() as u64,
            });
        }
        Ok(Self { bytes, stride: size, count })
    }

    /// `count` elements of `size` bytes in a view, or why they do not lie in it.
    fn in_view(
        view: &gltf::buffer::View,
        (offset, count, size): (usize, usize, usize),
        buffers: &'a Buffers,
        item: &str,
    ) -> Result<Self, SceneProblem> {
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            let detail = format!("has elements of {size} bytes, more than the byteStride {stride} of its buffer view");
            return Err(SceneProblem::invalid(item, detail));
        }
        let bytes = buffers.view(view)?;
        let end = count
            .checked_sub(1)
            .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size))
            .and_then(|extent| extent.checked_add(offset))
            .ok_or_else(|| SceneProblem::Oversize {
                item: item.to_owned(),
                detail: format!("{count} elements of {stride} bytes from byte {offset}"),
            })?;
        if end > bytes.len() {
            return Err(SceneProblem::OutOfBytes {
                item: item.to_owned(),
                holder: format!("bufferViews[{}]", view.index()),
                needed: end as u64,
                available: bytes.len() as u64,
            });
        }
        Ok(Self { bytes: &bytes[offset.min(bytes.len())..], stride, count })
    }
}

/// An accessor's parts, all of which lie within their buffers.
struct Parts<'a> {
    base: Option<Elements<'a>>,
    sparse: Option<Sparse<'a>>,
}

struct Sparse<'a> {
    targets: Vec<usize>,
    values: Elements<'a>,
}

/// Checks that an accessor lies within its buffer views and these within their buffers.
pub(super) fn check(accessor: &Accessor, buffers: &Buffers) -> Result<(), SceneProblem> {
    parts(accessor, buffers).map(|_| ())
}

fn parts<'a>(accessor: &Accessor, buffers: &'a Buffers) -> Result<Parts<'a>, SceneProblem> {
    let item = label(accessor);
    let count = accessor.count();
    let base = match (buffers.accessor(accessor.index()), accessor.view()) {
        (Some(bytes), _) => Some(Elements::packed(bytes, (count, accessor.size()), &item)?),
        (None, Some(view)) => {
            Some(Elements::in_view(&view, (accessor.offset(), count, accessor.size()), buffers, &item)?)
        }
        (None, None) => None,
    };
    if base.is_none() && count > MAX_UNBACKED_COUNT {
        let detail = format!("{count} elements without data; at most {MAX_UNBACKED_COUNT} are accepted");
        return Err(SceneProblem::Oversize { item, detail });
    }
    let sparse = accessor.sparse().map(|sparse| sparse_part(&sparse, accessor, buffers)).transpose()?;
    Ok(Parts { base, sparse })
}

fn sparse_part<'a>(
    sparse: &gltf::accessor::sparse::Sparse,
    accessor: &Accessor,
    buffers: &'a Buffers,
) -> Result<Sparse<'a>, SceneProblem> {
    let count = sparse.count();
    let (indices, values) = (sparse.indices(), sparse.values());
    let item = format!("{}.sparse", label(accessor));
    let index_bytes = match indices.index_type() {
        IndexType::U8 => 1,
        IndexType::U16 => 2,
        IndexType::U32 => 4,
    };
    let index_elements = Elements::in_view(&indices.view(), (indices.offset(), count, index_bytes), buffers, &item)?;
    let values = Elements::in_view(&values.view(), (values.offset(), count, accessor.size()), buffers, &item)?;
    let targets = (0..count).map(|i| little_endian(index_elements.at(i), index_bytes) as usize).collect::<Vec<_>>();
    if let Some(&index) = targets.iter().find(|&&index| index >= accessor.count()) {
        let (index, count) = (index as u64, accessor.count() as u64);
        return Err(SceneProblem::IndexOutOfRange { item, index, count, things: "elements" });
    }
    Ok(Sparse { targets, values })
}

/// The first `size` bytes as an unsigned number.
fn little_endian(bytes: &[u8], size: usize) -> u32 {
    bytes[..size].iter().rev().fold(0, |value, &byte| (value << 8) | u32::from(byte))
}

/// Reads `N` floats an element; integers are converted, and scaled where `normalized`.
pub(super) fn read_vectors<const N: usize>(
    accessor: &Accessor,
    buffers: &Buffers,
) -> Result<Vec<[f32; N]>, SceneProblem> {
    let components = accessor.dimensions().multiplicity();
    if components != N {
        let detail = format!("has {components} components an element where {N} are needed");
        return Err(SceneProblem::invalid(label(accessor), detail));
    }
    let component = |bytes: &[u8]| component_f32(bytes, accessor.data_type(), accessor.normalized());
    let size = accessor.data_type().size();
    read(accessor, buffers, [0.0; N], |bytes| std::array::from_fn(|k| component(&bytes[k * size..])))
}

/// Reads unsigned scalars: vertex indices.
pub(super) fn read_indices(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<u32>, SceneProblem> {
    let data_type = accessor.data_type();
    let unsigned = matches!(data_type, DataType::U8 | DataType::U16 | DataType::U32);
    if !unsigned || accessor.dimensions().multiplicity() != 1 {
        let detail = format!("has {data_type:?} elements where unsigned scalar indices are needed");
        return Err(SceneProblem::invalid(label(accessor), detail));
    }
    read(accessor, buffers, 0, |bytes| little_endian(bytes, data_type.size()))
}

fn read<T: Copy>(
    accessor: &Accessor,
    buffers: &Buffers,
    zero: T,
    element: impl Fn(&[u8]) -> T,
) -> Result<Vec<T>, SceneProblem> {
    let parts = parts(accessor, buffers)?;
    let mut values = match &parts.base {
        Some(base) => (0..base.count).map(|i| element(base.at(i))).collect(),
        None => vec![zero; accessor.count()],
    };
    if let Some(sparse) = parts.sparse {
        for (i, &target) in sparse.targets.iter().enumerate() {
            values[target] = element(sparse.values.at(i));
        }
    }
    Ok(values)
}

/// glTF 2.0, section 3.6.2.2 (and 3.11 for normalised integers): -128 clamps to -1.
fn component_f32(bytes: &[u8], data_type: DataType, normalized: bool) -> f32 {
    let raw = little_endian(bytes, data_type.size());
    let (value, scale) = match data_type {
        DataType::F32 => return f32::from_bits(raw),
        DataType::U32 => (raw as f32, u32::MAX as f32),
        DataType::U8 => (raw as f32, 255.0),
        DataType::U16 => (raw as f32, 65535.0),
        DataType::I8 => (f32::from(raw as u8 as i8), 127.0),
        DataType::I16 => (f32::from(raw as u16 as i16), 32767.0),
    };
    if normalized { (value / scale).max(-1.0) } else { value }
}
