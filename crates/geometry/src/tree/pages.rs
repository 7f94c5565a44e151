//! Large arrays in large pages: a search jumps about in them, and with pages of 4 KiB most jumps would miss the processor's
//! table of pages as well as its caches.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, zeroed_vec};
use memmap2::MmapMut;

/// Arrays of fewer bytes are plain vectors. A scene may have many trees, and a process only so many maps.
const LARGE: usize = 1 << 21;

/// An array of fixed length, zero at first. Where the system has large pages, long ones are put in them.
pub(crate) struct Pages<T>(Memory<T>);

enum Memory<T> {
    Small(Vec<T>),
    Large { map: MmapMut, bytes: usize, of: PhantomData<T> },
}

impl<T: Pod> Pages<T> {
    /// `len` zeros.
    pub(crate) fn zeroed(len: usize) -> Self {
        let bytes = len * size_of::<T>();
        let map = if bytes < LARGE { None } else { MmapMut::map_anon(bytes).ok() };
        let Some(map) = map else { return Self(Memory::Small(zeroed_vec(len))) };
        #[cfg(target_os = "linux")]
        {
            // Only a wish: a system without large pages refuses it and works all the same.
            let _ = map.advise(memmap2::Advice::HugePage);
        }
        Self(Memory::Large { map, bytes, of: PhantomData })
    }

    /// A copy of a slice.
    pub(crate) fn copy_of(items: &[T]) -> Self {
        let mut pages = Self::zeroed(items.len());
        pages.copy_from_slice(items);
        pages
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Memory::Small(items) => items,
            Memory::Large { map, bytes, .. } => bytemuck::cast_slice(&map[..*bytes]),
        }
    }
}

impl<T: Pod> DerefMut for Pages<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Memory::Small(items) => items,
            Memory::Large { map, bytes, .. } => bytemuck::cast_slice_mut(&mut map[..*bytes]),
        }
    }
}

impl<T: Pod> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pages").field("len", &self.len()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_arrays_hold_what_is_written() {
        for len in [0, 1, 1000, LARGE / size_of::<u64>() + 3] {
            let items: Vec<u64> = (0..len as u64).collect();
            let mut pages = Pages::copy_of(&items);
            assert_eq!(*pages, *items);
            if let Some(last) = pages.last_mut() {
                *last = 7;
                assert_eq!(pages[len - 1], 7);
            }
            assert!(Pages::<u64>::zeroed(len).iter().all(|&x| x == 0));
        }
    }
}
