//! Small data of a frame (uniforms, instances) in few large buffers, written at once before
//! the frame's commands run.

use std::sync::{Arc, Mutex};

/// Bytes of a chunk, unless one piece of data needs more.
const CHUNK_BYTES: usize = 128 * 1024;

/// How many of the last pieces are searched for one of the same content: passes of a method share
/// uniforms.
const REMEMBERED: usize = 12;

/// What pieces of data are used as; also to be copied from.
const USAGE: wgpu::BufferUsages = wgpu::BufferUsages::UNIFORM
    .union(wgpu::BufferUsages::VERTEX)
    .union(wgpu::BufferUsages::COPY_DST)
    .union(wgpu::BufferUsages::COPY_SRC);

/// A buffer that is filled from its start.
pub(super) struct Chunk {
    buffer: wgpu::Buffer,
    capacity: usize,
    data: Vec<u8>,
    /// Bytes of `data` that the buffer holds already.
    written: usize,
}

/// Chunks that no frame uses.
#[derive(Clone, Default)]
pub(super) struct Chunks(Arc<Mutex<Vec<Chunk>>>);

/// Most free chunks in the cache: only bursts of frames need more.
const KEPT_CHUNKS: usize = 16;

impl Chunks {
    fn take(&self, device: &wgpu::Device, bytes: usize) -> Chunk {
        if bytes <= CHUNK_BYTES
            && let Some(chunk) = self.lock().pop()
        {
            return chunk;
        }
        let capacity = bytes.max(CHUNK_BYTES);
        let (size, label) = (capacity as u64, Some("frame data"));
        let descriptor = wgpu::BufferDescriptor { label, size, usage: USAGE, mapped_at_creation: false };
        Chunk { buffer: device.create_buffer(&descriptor), capacity, data: Vec::with_capacity(capacity), written: 0 }
    }

    /// Takes back chunks whose commands are submitted: what is written to them from now on
    /// comes after those on the queue.
    pub(super) fn give_back(&self, chunks: Vec<Chunk>) {
        let mut free = self.lock();
        for mut chunk in chunks {
            if chunk.capacity == CHUNK_BYTES && free.len() < KEPT_CHUNKS {
                chunk.data.clear();
                chunk.written = 0;
                free.push(chunk);
            }
        }
    }

    /// `chunks` as what gives them back when it goes: when the commands that read them are
    /// done, or were given up with the encoder that was to hold them.
    pub(super) fn lend(&self, chunks: Vec<Chunk>) -> Lent {
        Lent { chunks, free: self.clone() }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Chunk>> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Chunks that are given back on drop.
pub(super) struct Lent {
    chunks: Vec<Chunk>,
    free: Chunks,
}

impl Drop for Lent {
    fn drop(&mut self) {
        self.free.give_back(std::mem::take(&mut self.chunks));
    }
}

/// The data of one frame.
pub(super) struct Arena {
    device: wgpu::Device,
    /// Multiple of bytes at which uniforms may begin.
    alignment: usize,
    free: Chunks,
    chunks: Vec<Chunk>,
    /// Offset and length of the last pieces in the last chunk.
    last: [(u32, u32); REMEMBERED],
    next: usize,
}

/// A piece of a frame's data.
#[derive(Clone)]
pub(crate) struct Piece {
    pub buffer: wgpu::Buffer,
    /// Where it begins, bytes.
    pub offset: u32,
}

impl Arena {
    pub(super) fn new(device: &wgpu::Device, alignment: u32, free: &Chunks) -> Self {
        let alignment = alignment.max(16) as usize;
        let (free, last) = (free.clone(), [(0, 0); REMEMBERED]);
        Self { device: device.clone(), alignment, free, chunks: Vec::new(), last, next: 0 }
    }

    /// Puts `bytes` where a uniform or a vertex may begin, followed by zeros up to a multiple
    /// of 16 bytes.
    pub(super) fn push(&mut self, bytes: &[u8]) -> Piece {
        if let Some(chunk) = self.chunks.last() {
            let same = |(offset, length): &&(u32, u32)| {
                let (offset, length) = (*offset as usize, *length as usize);
                length == bytes.len() && length > 0 && chunk.data[offset..offset + length] == *bytes
            };
            // What is on the queue already stays as it is, and may be used again.
            if let Some((offset, _)) = self.last.iter().find(same) {
                return Piece { buffer: chunk.buffer.clone(), offset: *offset };
            }
        }
        // At least one: an empty slice of a buffer is an error.
        let padded = bytes.len().max(1).next_multiple_of(16);
        let room = |chunk: &Chunk| chunk.data.len().next_multiple_of(self.alignment) + padded <= chunk.capacity;
        if !self.chunks.last().is_some_and(room) {
            self.chunks.push(self.free.take(&self.device, padded));
            self.last = [(0, 0); REMEMBERED];
        }
        let chunk = self.chunks.last_mut().expect("one was just added if there was none");
        let offset = chunk.data.len().next_multiple_of(self.alignment);
        chunk.data.resize(offset, 0);
        chunk.data.extend_from_slice(bytes);
        chunk.data.resize(offset + padded, 0);
        self.last[self.next] = (offset as u32, bytes.len() as u32);
        self.next = (self.next + 1) % REMEMBERED;
        Piece { buffer: chunk.buffer.clone(), offset: offset as u32 }
    }

    /// Has everything pushed so far written before the next submission.
    pub(super) fn write(&mut self, queue: &wgpu::Queue) {
        for chunk in self.chunks.iter_mut().filter(|chunk| chunk.written < chunk.data.len()) {
            // Offsets are multiples of the alignment or of 16: what the queue asks for.
            queue.write_buffer(&chunk.buffer, chunk.written as u64, &chunk.data[chunk.written..]);
            chunk.written = chunk.data.len();
        }
    }

    /// The chunks; the caller gives them back once the commands that read them are submitted.
    pub(super) fn into_chunks(self) -> Vec<Chunk> {
        self.chunks
    }

    /// Bytes of the buffers in use.
    pub(super) fn bytes(&self) -> u64 {
        self.chunks.iter().map(|chunk| chunk.capacity as u64).sum()
    }
}
