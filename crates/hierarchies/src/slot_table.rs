//! Where what is live is: a table over all ids that a hierarchy has, of which only the pages in use exist.

use crate::live::grow;

/// No slot.
pub(super) const NONE: u32 = u32::MAX;
/// Keys on a page: one cache line. What is near in number is near in place and size, so most pages in use are well
/// filled.
const PER_PAGE: usize = 16;

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Page([u32; PER_PAGE]);

/// A map from dense keys to slots. A look, a change and a removal cost one cache line, and a second one in a directory
/// of four bytes per page of keys.
#[derive(Clone, Debug)]
pub(super) struct SlotTable {
    /// Per page of keys: one more than where it is in `pages`, so that a new directory is untouched zeros.
    directory: Vec<u32>,
    pages: Vec<Page>,
    /// The first free page; each names the next one in its first entry.
    free: u32,
}

impl SlotTable {
    /// For keys below `keys`.
    pub fn new(keys: usize) -> SlotTable {
        SlotTable { directory: vec![0; keys.div_ceil(PER_PAGE)], pages: vec![], free: NONE }
    }

    /// Empty again, in the same memory.
    pub fn reset(&mut self) {
        self.directory.fill(0);
        self.pages.clear();
        self.free = NONE;
    }

    #[inline]
    pub fn get(&self, key: usize) -> Option<u32> {
        let index = self.directory.get(key / PER_PAGE)?.wrapping_sub(1);
        let page = self.pages.get(index as usize)?;
        Some(page.0[key % PER_PAGE]).filter(|&slot| slot != NONE)
    }

    #[inline]
    pub fn set(&mut self, key: usize, slot: u32) {
        let mut index = self.directory[key / PER_PAGE];
        if index == 0 {
            index = self.new_page() + 1;
            self.directory[key / PER_PAGE] = index;
        }
        self.pages[index as usize - 1].0[key % PER_PAGE] = slot;
    }

    /// Forgets a key that is in the table.
    #[inline]
    pub fn clear(&mut self, key: usize) {
        self.clear_keys::<1>(key);
    }
    /// Forgets four keys, the first a multiple of four.
    #[inline]
    pub fn clear_four(&mut self, first: usize) {
        self.clear_keys::<4>(first);
    }
    #[inline]
    fn clear_keys<const N: usize>(&mut self, key: usize) {
        let index = self.directory[key / PER_PAGE] - 1;
        let entries = &mut self.pages[index as usize].0;
        entries.as_chunks_mut::<N>().0[key % PER_PAGE / N] = [NONE; N];
        if *entries == [NONE; PER_PAGE] {
            entries[0] = self.free;
            self.free = index;
            self.directory[key / PER_PAGE] = 0;
        }
    }

    /// Four keys at once, the first a multiple of four. `None`: none of them is in the table.
    #[inline]
    pub fn four(&self, first: usize) -> Option<[u32; 4]> {
        let index = self.directory[first / PER_PAGE].wrapping_sub(1);
        let page = self.pages.get(index as usize)?;
        Some(page.0.as_chunks::<4>().0[first % PER_PAGE / 4])
    }
    /// Sets four keys at once, the first a multiple of four; [`NONE`] ones are not in the table then. One at least is.
    #[inline]
    pub fn set_four(&mut self, first: usize, slots: [u32; 4]) {
        let mut index = self.directory[first / PER_PAGE];
        if index == 0 {
            index = self.new_page() + 1;
            self.directory[first / PER_PAGE] = index;
        }
        self.pages[index as usize - 1].0.as_chunks_mut::<4>().0[first % PER_PAGE / 4] = slots;
    }

    fn new_page(&mut self) -> u32 {
        let empty = Page([NONE; PER_PAGE]);
        match self.free {
            NONE => {
                grow(&mut self.pages, empty, self.directory.len());
                self.pages.len() as u32 - 1
            }
            index => {
                self.free = std::mem::replace(&mut self.pages[index as usize], empty).0[0];
                index
            }
        }
    }

    pub fn memory_bytes(&self) -> usize {
        self.directory.capacity() * 4 + self.pages.capacity() * size_of::<Page>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn behaves_as_a_map_and_gives_pages_back() {
        let mut table = SlotTable::new(1000);
        let mut map = HashMap::new();
        let mut seed = 7u64;
        let mut random = |below: u64| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed % below) as u32
        };
        for round in 0..20_000u32 {
            let v = random(1000) as usize;
            if map.remove(&v).is_some() {
                table.clear(v);
            } else if map.len() < 100 || round % 4000 > 2000 {
                table.set(v, round);
                map.insert(v, round);
            }
            let probe = random(1010) as usize;
            assert_eq!(table.get(probe), map.get(&probe).copied());
        }
        for v in map.into_keys() {
            table.clear(v);
        }
        assert!(table.directory.iter().all(|&page| page == 0));
        let pages = table.pages.len();
        for v in 0..1000 {
            table.set(v, v as u32);
        }
        assert!(pages > 60 && table.pages.len() == 1000usize.div_ceil(PER_PAGE));
        assert!((0..1000).all(|v| table.get(v) == Some(v as u32)));
    }
}
