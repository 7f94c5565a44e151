//! Reads a stream from its beginning, never past its end.

use super::Broken;

pub(super) const ENDS_EARLY: Broken = "ends before all elements are decoded";

/// What is left of a stream.
pub(super) struct Cursor<'a> {
    rest: &'a [u8],
}

impl<'a> Cursor<'a> {
    pub(super) fn new(rest: &'a [u8]) -> Self {
        Self { rest }
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Broken> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(ENDS_EARLY)?;
        self.rest = rest;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, Broken> {
        self.take(1).map(|b| b[0])
    }

    /// An unsigned number in groups of seven bits, least first, of at most five bytes (LEB128); bits beyond 32 are ignored.
    pub(super) fn varint(&mut self) -> Result<u32, Broken> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("has a number of more than five bytes")
    }

    /// That nothing is left.
    pub(super) fn end(&self) -> Result<(), Broken> {
        if self.rest.is_empty() { Ok(()) } else { Err("goes on after all elements are decoded") }
    }
}
