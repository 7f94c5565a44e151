//! Modes 1 and 2, triangles and indices.

use super::Broken;
use super::cursor::{Cursor, ENDS_EARLY};

/// The last 16 values, the newest first.
struct Fifo<T> {
    entries: [Option<T>; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new() -> Self {
        Self { entries: [None; 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.entries[self.next] = Some(value);
        self.next = (self.next + 1) % 16;
    }

    /// The value pushed after which `age` others were pushed; `age` is below 16.
    fn get(&self, age: u8) -> Result<T, Broken> {
        self.entries[(self.next + 15 - usize::from(age)) % 16].ok_or("refers to what was never there")
    }
}

struct Triangles<'a> {
    data: Cursor<'a>,
    /// The next index that has not occurred.
    next: u32,
    /// The last index that was written out.
    last: u32,
    edges: Fifo<[u32; 2]>,
    vertices: Fifo<u32>,
}

impl Triangles<'_> {
    fn new_index(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn written_index(&mut self) -> Result<u32, Broken> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Ok(self.last)
    }

    /// A vertex by four bits: a new one, one of the last, or one that is written out. Says whether it is to be kept.
    fn vertex(&mut self, bits: u8) -> Result<(u32, bool), Broken> {
        Ok(match bits {
            0 => (self.new_index(), true),
            15 => (self.written_index()?, true),
            age => (self.vertices.get(age - 1)?, false),
        })
    }

    /// The triangle that `code` stands for, with the table of the common pairs of second and third vertices.
    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], Broken> {
        let (edge, kind) = (code >> 4, code & 15);
        if edge < 15 {
            let [a, b] = self.edges.get(edge)?;
            let (c, keep) = match kind {
                0 => (self.new_index(), true),
                13 | 14 => {
                    self.last = if kind == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                    (self.last, true)
                }
                15 => (self.written_index()?, true),
                age => (self.vertices.get(age)?, false),
            };
            self.edges.push([c, b]);
            self.edges.push([a, c]);
            if keep {
                self.vertices.push(c);
            }
            return Ok([a, b, c]);
        }
        let (a, pair) = if kind < 14 {
            (self.new_index(), table[usize::from(kind)])
        } else {
            let pair = self.data.byte()?;
            if pair == 0 {
                self.next = 0;
            }
            (if kind == 14 { self.new_index() } else { self.written_index()? }, pair)
        };
        let (b, keep_b) = self.vertex(pair >> 4)?;
        let (c, keep_c) = self.vertex(pair & 15)?;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        if keep_b {
            self.vertices.push(b);
        }
        if keep_c {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }
}

fn unzigzag(v: u32) -> u32 {
    if v & 1 == 0 { v >> 1 } else { !(v >> 1) }
}

/// Mode 1: a list of `count / 3` triangles.
pub(super) fn triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, Broken> {
    let mut cursor = Cursor::new(bytes);
    if cursor.byte()? != 0xe1 {
        return Err("is of no known version");
    }
    let codes = cursor.take(count / 3)?;
    let data = bytes.len().checked_sub(1 + codes.len() + 16).ok_or(ENDS_EARLY)?;
    let mut state = Triangles {
        data: Cursor::new(cursor.take(data)?),
        next: 0,
        last: 0,
        edges: Fifo::new(),
        vertices: Fifo::new(),
    };
    let table = cursor.take(16)?;
    if table[14..] != [0, 0] || table.iter().any(|pair| pair >> 4 == 15 || pair & 15 == 15) {
        return Err("has a table that is not allowed");
    }
    let mut list = Vec::with_capacity(count);
    for &code in codes {
        list.extend(state.triangle(code, table)?);
    }
    state.data.end()?;
    Ok(list)
}

/// Mode 2: `count` indices as differences from one of two that came before.
pub(super) fn sequence(bytes: &[u8], count: usize) -> Result<Vec<u32>, Broken> {
    let body = bytes.len().checked_sub(4).ok_or(ENDS_EARLY)?;
    let mut cursor = Cursor::new(&bytes[..body]);
    if cursor.byte()? != 0xd1 {
        return Err("is of no known version");
    }
    let mut last = [0u32; 2];
    let mut list = Vec::new();
    for _ in 0..count {
        let value = cursor.varint()?;
        let last = &mut last[value as usize & 1];
        *last = last.wrapping_add(unzigzag(value >> 1));
        list.push(*last);
    }
    cursor.end()?;
    Ok(list)
}

/// Indices as the bytes of unsigned integers of `stride` bytes, 2 or 4.
pub(super) fn store(list: &[u32], stride: usize) -> Vec<u8> {
    list.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: [u8; 16] = [0; 16];

    fn stream(codes: &[u8], data: &[u8], table: &[u8; 16]) -> Vec<u8> {
        [&[0xe1], codes, data, table].concat()
    }

    #[test]
    fn triangles_come_from_every_kind_of_code() {
        let mut table = TABLE;
        // The second vertex is the newest of the last, the third is new.
        table[1] = 0x10;
        let codes = [
            0xf0, // 0 1 2, all new
            0x00, // the last edge, 0 2, with a new vertex
            0xf1, // a new one, 4, the newest of the last, 3, and a new one, 5
            0xfe, // by a byte of its own: a new one, 6, one written out and the newest of the last
            0x0d, // the last edge and the one before the last that was written out
            0x0e, // the last edge and the one after it
            0x0f, // the last edge and one written out
            0x12, // the last edge but one, and the third of the last vertices
            0xff, // all written out
            0xfe, // new ones, starting again from 0
        ];
        // +8 from 0; -5 from 8; then 3 + 1, 1 - 3, 2 - 1.
        let data = [0xf1, 16, 9, 0xff, 2, 5, 1, 0];
        let list = triangles(&stream(&codes, &data, &table), 30).unwrap();
        let (rows, _) = list.as_chunks::<3>();
        let expected = [
            [0, 1, 2],
            [0, 2, 3],
            [4, 3, 5],
            [6, 8, 5],
            [6, 5, 7],
            [6, 7, 8],
            [6, 8, 3],
            [3, 8, 7],
            [4, 1, 0],
            [0, 1, 2],
        ];
        assert_eq!(rows, expected);
        // One byte less, one more, and a table that is not allowed.
        assert_eq!(triangles(&stream(&codes, &data[..7], &table), 30), Err(ENDS_EARLY));
        assert!(triangles(&stream(&codes, &[&data[..], &[0]].concat(), &table), 30).is_err());
        table[0] = 0xf0;
        assert!(triangles(&stream(&codes, &data, &table), 30).is_err());
    }

    #[test]
    fn what_was_never_there_cannot_be_referred_to() {
        assert!(triangles(&stream(&[0x00], &[], &TABLE), 3).unwrap_err().contains("never there"));
        assert!(triangles(&stream(&[0xfe], &[0x10], &TABLE), 3).unwrap_err().contains("never there"));
    }

    #[test]
    fn a_sequence_has_two_baselines() {
        // 5 and 6 from the first, 100 and 99 from the second, then 4.
        let bytes = [0xd1, 20, 0x91, 0x03, 4, 3, 6, 0, 0, 0, 0];
        assert_eq!(sequence(&bytes, 5).unwrap(), [5, 100, 6, 99, 4]);
        assert_eq!(sequence(&bytes, 6), Err(ENDS_EARLY));
        assert!(sequence(&bytes, 4).is_err());
        assert!(sequence(&[0xd1, 255, 255, 255, 255, 255, 0, 0, 0, 0, 0], 1).is_err());
    }

    #[test]
    fn indices_wrap_into_two_bytes() {
        assert_eq!(store(&[1, 65_537], 2), [1, 0, 1, 0]);
        assert_eq!(store(&[65_537], 4), [1, 0, 1, 0]);
    }
}
