//! Mode 0, attributes: differences between the bytes of consecutive elements, byte position by byte position.

use super::Broken;
use super::cursor::{Cursor, ENDS_EARLY};

/// Elements in a group, which has one width of bits.
const GROUP: usize = 16;
/// Most elements in a block.
const BLOCK: usize = 256;

/// How one byte position of a block is stored.
enum Column {
    /// The widths in bits that the two header bits of a group choose from.
    Widths([u32; 4]),
    Zeros,
    Literal,
}

impl Column {
    /// By the two control bits of version 1.
    fn controlled(bits: u8) -> Self {
        match bits & 3 {
            0 => Self::Widths([0, 1, 2, 4]),
            1 => Self::Widths([1, 2, 4, 8]),
            2 => Self::Zeros,
            _ => Self::Literal,
        }
    }
}

/// How the differences of four neighbouring byte positions are taken.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Shorts,
    /// By exclusive or, and rotated left by so many bits.
    Xor(u32),
}

impl Channel {
    fn from_byte(byte: u8) -> Result<Self, Broken> {
        match (byte & 15, byte >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Shorts),
            (2, rotation) => Ok(Self::Xor(u32::from(rotation))),
            _ => Err("has a channel mode that there is not"),
        }
    }

    /// The element's four bytes after `last`.
    fn next(self, last: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => std::array::from_fn(|i| last[i].wrapping_add(unzigzag8(delta[i]))),
            Self::Shorts => {
                let short = |b: [u8; 4], i: usize| u16::from_le_bytes([b[i], b[i + 1]]);
                let [a, b] = [0, 2].map(|i| short(last, i).wrapping_add(unzigzag16(short(delta, i))).to_le_bytes());
                [a[0], a[1], b[0], b[1]]
            }
            Self::Xor(rotation) => {
                (u32::from_le_bytes(last) ^ u32::from_le_bytes(delta).rotate_right(rotation)).to_le_bytes()
            }
        }
    }
}

fn unzigzag8(v: u8) -> u8 {
    if v & 1 == 0 { v >> 1 } else { !(v >> 1) }
}

fn unzigzag16(v: u16) -> u16 {
    if v & 1 == 0 { v >> 1 } else { !(v >> 1) }
}

/// Decodes `count` elements of `stride` bytes; `stride` is a multiple of 4 from 4 to 256.
pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Broken> {
    let (&header, rest) = bytes.split_first().ok_or(ENDS_EARLY)?;
    let channels_stored = match header {
        0xa0 => 0,
        0xa1 => stride / 4,
        _ => return Err("is of no known version"),
    };
    let tail = stride + channels_stored;
    let padded = tail.max(if channels_stored == 0 { 32 } else { 24 });
    let (body, end) = rest.split_at_checked(rest.len().checked_sub(padded).ok_or(ENDS_EARLY)?).ok_or(ENDS_EARLY)?;
    let (baseline, modes) = end[padded - tail..].split_at(stride);
    let mut channels = vec![Channel::Bytes; stride / 4];
    for (channel, &mode) in channels.iter_mut().zip(modes) {
        *channel = Channel::from_byte(mode)?;
    }

    let mut cursor = Cursor::new(body);
    let mut last: Vec<[u8; 4]> = baseline.as_chunks::<4>().0.to_vec();
    let mut decoded = Vec::new();
    let most = ((8192 / stride) & !(GROUP - 1)).min(BLOCK);
    let mut columns = vec![0; stride * BLOCK];
    let mut left = count;
    while left > 0 {
        let elements = left.min(most);
        let control = cursor.take(channels_stored)?;
        for (position, column) in columns.chunks_exact_mut(BLOCK).enumerate() {
            let kind = match control.get(position / 4) {
                Some(&bits) => Column::controlled(bits >> (2 * (position % 4))),
                None => Column::Widths([0, 2, 4, 8]),
            };
            match kind {
                Column::Widths(widths) => groups(&mut cursor, widths, &mut column[..elements.next_multiple_of(GROUP)])?,
                Column::Zeros => column.fill(0),
                Column::Literal => column[..elements].copy_from_slice(cursor.take(elements)?),
            }
        }
        for element in 0..elements {
            for (c, (last, channel)) in last.iter_mut().zip(&channels).enumerate() {
                *last = channel.next(*last, std::array::from_fn(|i| columns[(4 * c + i) * BLOCK + element]));
                decoded.extend_from_slice(last);
            }
        }
        left -= elements;
    }
    cursor.end()?;
    Ok(decoded)
}

/// Decodes the groups of one byte position.
fn groups(cursor: &mut Cursor<'_>, widths: [u32; 4], column: &mut [u8]) -> Result<(), Broken> {
    let header = cursor.take((column.len() / GROUP).div_ceil(4))?;
    for (i, group) in column.as_chunks_mut::<GROUP>().0.iter_mut().enumerate() {
        let choice = header[i / 4] >> (2 * (i % 4)) & 3;
        match widths[usize::from(choice)] {
            0 => group.fill(0),
            8 => group.copy_from_slice(cursor.take(GROUP)?),
            width => sentinels(cursor, width, group)?,
        }
    }
    Ok(())
}

/// A group of 1, 2 or 4 bits an element; one with all bits set stands for a byte that follows.
fn sentinels(cursor: &mut Cursor<'_>, width: u32, group: &mut [u8; GROUP]) -> Result<(), Broken> {
    let packed = cursor.take(GROUP * width as usize / 8)?;
    let per_byte = 8 / width as usize;
    let sentinel = (1 << width) - 1;
    for (i, value) in group.iter_mut().enumerate() {
        let slot = (i % per_byte) as u32;
        // Single bits are packed from the lowest, wider ones from the highest.
        let shift = if width == 1 { slot } else { 8 - width * (slot + 1) };
        *value = packed[i / per_byte] >> shift & sentinel;
    }
    for value in group.iter_mut().filter(|value| **value == sentinel) {
        *value = cursor.byte()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_of_four_bits_is_the_one_that_the_specification_shows() {
        let bytes = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut cursor = Cursor::new(&bytes);
        let mut group = [0; GROUP];
        sentinels(&mut cursor, 4, &mut group).unwrap();
        cursor.end().unwrap();
        let expected = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0];
        assert_eq!(group.map(|v| unzigzag8(v) as i8), expected);
    }

    #[test]
    fn single_bits_are_packed_from_the_lowest() {
        let mut cursor = Cursor::new(&[0b0000_0101, 0b1000_0000, 9, 8, 7]);
        let mut group = [0; GROUP];
        sentinels(&mut cursor, 1, &mut group).unwrap();
        cursor.end().unwrap();
        assert_eq!(group, [9, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7]);
    }

    #[test]
    fn channels_wrap_around() {
        assert_eq!(Channel::Bytes.next([0, 255, 0, 7], [1, 2, 0, 0]), [255, 0, 0, 7]);
        // 0x00ff + 1 and 0 - 1.
        assert_eq!(Channel::Shorts.next([0xff, 0, 0, 0], [2, 0, 1, 0]), [0, 1, 0xff, 0xff]);
        assert_eq!(Channel::Xor(4).next([0xff, 0, 0, 0], [0xf0, 0, 0, 0]), [0xf0, 0, 0, 0]);
    }
}
