//! Children of nodes that a search has still to look into.

use super::node::Child;

/// Entries without an allocation: more than a well-made tree needs, and few enough to be cleared in a few stores.
const USUAL: usize = 32;

/// A child with the ray's parameter where it enters its box, as one number, so that the order of numbers is that of the
/// parameters: they are not negative, and the bits of such floats are ordered as they are.
pub(crate) type Entry = u64;

#[inline(always)]
pub(crate) fn entry(t: f32, child: Child) -> Entry {
    u64::from(t.to_bits()) << 32 | u64::from(child.0)
}

#[inline(always)]
pub(crate) fn enters_at(entry: Entry) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

#[inline(always)]
pub(crate) fn child_of(entry: Entry) -> Child {
    Child(entry as u32)
}

/// A stack of entries. A tree may be as deep as it has triangles, so what does not fit spills over.
pub(crate) struct Stack {
    entries: [Entry; USUAL],
    len: usize,
    spilled: Vec<Entry>,
}

impl Stack {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { entries: [0; USUAL], len: 0, spilled: Vec::new() }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, entry: Entry) {
        if let Some(slot) = self.entries.get_mut(self.len) {
            *slot = entry;
            self.len += 1;
        } else {
            self.spill(entry);
        }
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<Entry> {
        if self.len == USUAL && !self.spilled.is_empty() {
            return self.unspill();
        }
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len % USUAL])
    }

    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Puts an entry in its place among those from `base` on, the least on top.
    #[inline(always)]
    pub(crate) fn insert(&mut self, base: usize, entry: Entry) {
        let mut at = self.len;
        self.push(entry);
        while at > base && at < USUAL && self.entries[at - 1] < entry {
            self.entries[at] = self.entries[at - 1];
            self.entries[at - 1] = entry;
            at -= 1;
        }
    }

    #[cold]
    fn spill(&mut self, entry: Entry) {
        self.spilled.push(entry);
    }

    #[cold]
    fn unspill(&mut self) -> Option<Entry> {
        self.spilled.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_spills_over_comes_back_in_order() {
        let mut stack = Stack::new();
        for i in 0..3 * USUAL as u64 {
            stack.push(i);
        }
        for i in (USUAL as u64..3 * USUAL as u64).rev() {
            assert_eq!(stack.pop(), Some(i));
        }
        stack.push(7);
        for i in [7].into_iter().chain((0..USUAL as u64).rev()) {
            assert_eq!(stack.pop(), Some(i));
        }
        assert_eq!(stack.pop(), None);
    }

    #[test]
    fn entries_are_ordered_by_parameter() {
        let ts = [0.0, f32::MIN_POSITIVE, 1e-3, 1.0, 1e30, f32::INFINITY];
        for pair in ts.windows(2) {
            assert!(entry(pair[0], Child::NONE) < entry(pair[1], Child::node(0)));
        }
        assert_eq!(
            (enters_at(entry(0.5, Child::node(3))), child_of(entry(0.5, Child::node(3)))),
            (0.5, Child::node(3))
        );
    }
}
