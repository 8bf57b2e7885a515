//! Modes 1 and 2: indices of triangle lists, and any other indices.

use super::Stream;

/// First byte of a triangle stream, with the version that has explicit edges of `last`.
const TRIANGLES_HEADER: u8 = 0xe1;

/// First byte of an index sequence.
const SEQUENCE_HEADER: u8 = 0xd1;

/// Bytes of the table behind a triangle stream.
const TABLE_BYTES: usize = 16;

/// Reserved bytes behind an index sequence.
const SEQUENCE_TAIL_BYTES: usize = 4;

/// The last sixteen entries, the newest at 0.
struct Fifo<T> {
    entries: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Fifo<T> {
    fn new() -> Self {
        Self { entries: [T::default(); 16], next: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.next] = entry;
        self.next = (self.next + 1) % 16;
    }

    fn at(&self, age: u8) -> T {
        self.entries[(self.next + 31 - usize::from(age)) % 16]
    }
}

/// What the decoder of triangles remembers.
struct Triangles<'a> {
    data: Stream<'a>,
    next: u32,
    last: u32,
    edges: Fifo<(u32, u32)>,
    vertices: Fifo<u32>,
}

/// `count` indices of a triangle list; `None` for a damaged stream.
pub(super) fn triangles(stream: &mut Stream, count: usize) -> Option<Vec<u32>> {
    if stream.byte()? != TRIANGLES_HEADER {
        return None;
    }
    let codes = stream.take(count / 3)?;
    let table_at = stream.rest.len().checked_sub(TABLE_BYTES)?;
    let (data, table) = stream.rest.split_at(table_at);
    let (edges, vertices) = (Fifo::new(), Fifo::new());
    let mut state = Triangles { data: Stream { rest: data }, next: 0, last: 0, edges, vertices };
    let mut all = Vec::with_capacity(count);
    for &code in codes {
        all.extend(state.triangle(code, table)?);
    }
    state.data.rest.is_empty().then_some(all)
}

impl Triangles<'_> {
    fn triangle(&mut self, code: u8, table: &[u8]) -> Option<[u32; 3]> {
        let (high, low) = (code >> 4, code & 15);
        match (high, low) {
            (0..15, _) => {
                let (a, b) = self.edges.at(high);
                let c = match low {
                    0 => self.unseen(),
                    1..13 => self.vertices.at(low),
                    13 | 14 => {
                        self.last = if low == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                        self.last
                    }
                    _ => self.explicit()?,
                };
                self.edges.push((c, b));
                self.edges.push((a, c));
                if !(1..13).contains(&low) {
                    self.vertices.push(c);
                }
                Some([a, b, c])
            }
            (_, 0..14) => {
                let pair = table[usize::from(low)];
                let a = self.unseen();
                let b = self.corner(pair >> 4)?;
                let c = self.corner(pair & 15)?;
                Some(self.remember([a, b, c], pair))
            }
            _ => {
                let pair = self.data.byte()?;
                if pair == 0 {
                    self.next = 0;
                }
                let a = if low == 14 { self.unseen() } else { self.explicit()? };
                let b = self.corner(pair >> 4)?;
                let c = self.corner(pair & 15)?;
                Some(self.remember([a, b, c], pair))
            }
        }
    }

    /// The next index that no triangle had before.
    fn unseen(&mut self) -> u32 {
        self.next = self.next.wrapping_add(1);
        self.next.wrapping_sub(1)
    }

    /// An index given by its difference from the last one that was given so.
    fn explicit(&mut self) -> Option<u32> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Some(self.last)
    }

    fn corner(&mut self, nibble: u8) -> Option<u32> {
        match nibble {
            0 => Some(self.unseen()),
            15 => self.explicit(),
            age => Some(self.vertices.at(age - 1)),
        }
    }

    fn remember(&mut self, [a, b, c]: [u32; 3], pair: u8) -> [u32; 3] {
        [(b, a), (c, b), (a, c)].into_iter().for_each(|edge| self.edges.push(edge));
        self.vertices.push(a);
        for (vertex, nibble) in [(b, pair >> 4), (c, pair & 15)] {
            if nibble == 0 || nibble == 15 {
                self.vertices.push(vertex);
            }
        }
        [a, b, c]
    }
}

/// `count` indices of any kind; `None` for a damaged stream.
pub(super) fn sequence(stream: &mut Stream, count: usize) -> Option<Vec<u32>> {
    if stream.byte()? != SEQUENCE_HEADER || count > stream.rest.len() {
        return None;
    }
    let mut last = [0_u32; 2];
    let mut all = Vec::with_capacity(count);
    for _ in 0..count {
        let code = stream.varint()?;
        let baseline = &mut last[(code & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag(code >> 1));
        all.push(*baseline);
    }
    (stream.rest.len() == SEQUENCE_TAIL_BYTES).then_some(all)
}

fn unzigzag(code: u32) -> u32 {
    if code & 1 == 1 { !(code >> 1) } else { code >> 1 }
}

/// Little-endian indices of 2 or 4 bytes.
pub(super) fn packed(indices: &[u32], stride: usize) -> Vec<u8> {
    if stride == 2 {
        return indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect();
    }
    indices.iter().flat_map(|index| index.to_le_bytes()).collect()
}
