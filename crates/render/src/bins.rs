//! A buffer of entries that is sorted by bands of the picture, in two passes over it and in place.

use std::ops::Range;

/// Entries that a buffer has room for: what several chains leave in a round, and little enough that splats are still in the
/// caches when they are merged.
pub(crate) const CAPACITY: usize = 1 << 11;

/// Entries in the order in which they came and, once sorted, a list for each band in the same order.
#[derive(Clone, Debug)]
pub(crate) struct Bins<T> {
    entries: Vec<T>,
    /// Indices of entries, band by band. An entry that belongs to two bands is listed twice.
    order: Vec<u32>,
    /// Where the list of each band ends in `order`.
    ends: Vec<u32>,
}

impl<T> Bins<T> {
    pub(crate) fn new() -> Self {
        Self { entries: Vec::with_capacity(CAPACITY), order: Vec::new(), ends: Vec::new() }
    }

    /// How many entries still fit. More are taken, but the buffer has to grow for them.
    #[inline]
    pub(crate) fn room(&self) -> usize {
        CAPACITY.saturating_sub(self.entries.len())
    }

    #[inline]
    pub(crate) fn push(&mut self, entry: T) {
        self.entries.push(entry);
    }

    #[inline]
    pub(crate) fn last_mut(&mut self) -> Option<&mut T> {
        self.entries.last_mut()
    }

    /// Lists the entries of every band, by counting.
    pub(crate) fn sort(&mut self, bands: usize, bands_of: impl Fn(&T) -> Range<usize>) {
        self.ends.clear();
        self.ends.resize(bands, 0);
        for entry in &self.entries {
            bands_of(entry).for_each(|band| self.ends[band] += 1);
        }
        let mut listed = 0;
        for end in &mut self.ends {
            listed += std::mem::replace(end, listed);
        }
        self.order.clear();
        self.order.resize(listed as usize, 0);
        // Every end is at the start of its list now, and moves on as the list fills.
        for (index, entry) in self.entries.iter().enumerate() {
            for band in bands_of(entry) {
                let end = &mut self.ends[band];
                self.order[*end as usize] = index as u32;
                *end += 1;
            }
        }
    }

    /// The entries of one band in the order in which they came, as last sorted.
    #[inline]
    pub(crate) fn of_band(&self, band: usize) -> impl Iterator<Item = &T> {
        let start = if band == 0 { 0 } else { self.ends[band - 1] as usize };
        self.order[start..self.ends[band] as usize].iter().map(|&index| &self.entries[index as usize])
    }

    /// All entries in the order in which they came.
    pub(crate) fn entries(&self) -> &[T] {
        &self.entries
    }

    /// Forgets all entries.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Bytes that a buffer takes which holds `entries` entries at most, each in two bands at most.
    pub(crate) const fn bytes(entries: usize, bands: usize) -> usize {
        entries * (size_of::<T>() + 2 * size_of::<u32>()) + bands * size_of::<u32>()
    }

    #[cfg(test)]
    pub(crate) fn allocated(&self) -> usize {
        self.entries.capacity() * size_of::<T>() + (self.order.capacity() + self.ends.capacity()) * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_band_lists_its_entries_in_order() {
        let bands_of = |&entry: &usize| {
            let band = entry * 7 % 5;
            // Some in two bands, some in none.
            if entry % 11 == 0 { 0..0 } else { band..(band + 1 + entry % 2).min(5) }
        };
        let mut bins = Bins::new();
        for round in 0..3 {
            (0..100 + round).for_each(|entry| bins.push(entry));
            bins.sort(5, bands_of);
            for band in 0..5 {
                let expected: Vec<usize> = (0..100 + round).filter(|entry| bands_of(entry).contains(&band)).collect();
                assert!(expected.len() > 10);
                assert_eq!(bins.of_band(band).copied().collect::<Vec<_>>(), expected);
            }
            bins.clear();
        }
    }

    #[test]
    fn a_full_buffer_takes_what_is_counted() {
        let mut bins = Bins::new();
        while bins.room() > 0 {
            bins.push([0.0; 5]);
        }
        bins.sort(256, |_| 3..5);
        assert_eq!(bins.allocated(), Bins::<[f64; 5]>::bytes(CAPACITY, 256));
        // One more and it has to grow.
        bins.push([0.0; 5]);
        assert!(bins.allocated() > Bins::<[f64; 5]>::bytes(CAPACITY, 256));
    }
}
