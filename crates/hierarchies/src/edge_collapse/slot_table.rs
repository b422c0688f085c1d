//! Where each live vertex is: a table over all vertex ids, of which only the pages in use exist.

use meshfront_mesh::VertexId;

const NONE: u32 = u32::MAX;
/// Ids on a page: one cache line. Neighbours on a page split at the same scale and in the same place, so most
/// pages in use are well filled.
const PER_PAGE: usize = 16;

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Page([u32; PER_PAGE]);

/// A map from vertex id to slot. A look, a change and a removal cost one cache line, and a second one in a directory of
/// four bytes per page of ids.
#[derive(Clone, Debug)]
pub(super) struct SlotTable {
    /// Per page of ids: where it is in `pages`.
    directory: Vec<u32>,
    pages: Vec<Page>,
    /// The first free page; each names the next one in its first entry.
    free: u32,
}

impl SlotTable {
    pub fn new(ids: usize) -> SlotTable {
        SlotTable { directory: vec![NONE; ids.div_ceil(PER_PAGE)], pages: vec![], free: NONE }
    }

    #[inline]
    fn split(v: VertexId) -> (usize, usize) {
        (v.ix() / PER_PAGE, v.ix() % PER_PAGE)
    }

    #[inline]
    pub fn get(&self, v: VertexId) -> Option<u32> {
        let (page, at) = SlotTable::split(v);
        let page = self.pages.get(*self.directory.get(page)? as usize)?;
        Some(page.0[at]).filter(|&slot| slot != NONE)
    }

    #[inline]
    pub fn set(&mut self, v: VertexId, slot: u32) {
        let (page, at) = SlotTable::split(v);
        let mut index = self.directory[page];
        if index == NONE {
            index = self.new_page();
            self.directory[page] = index;
        }
        self.pages[index as usize].0[at] = slot;
    }

    /// Forgets a vertex that is in the table.
    #[inline]
    pub fn clear(&mut self, v: VertexId) {
        let (page, at) = SlotTable::split(v);
        let index = self.directory[page];
        let entries = &mut self.pages[index as usize].0;
        entries[at] = NONE;
        if *entries == [NONE; PER_PAGE] {
            entries[0] = self.free;
            self.free = index;
            self.directory[page] = NONE;
        }
    }

    fn new_page(&mut self) -> u32 {
        let empty = Page([NONE; PER_PAGE]);
        match self.free {
            NONE => {
                super::front_mesh::grow(&mut self.pages, empty);
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
            let v = VertexId(random(1000));
            if map.remove(&v).is_some() {
                table.clear(v);
            } else if map.len() < 100 || round % 4000 > 2000 {
                table.set(v, round);
                map.insert(v, round);
            }
            let probe = VertexId(random(1010));
            assert_eq!(table.get(probe), map.get(&probe).copied());
        }
        for v in map.into_keys() {
            table.clear(v);
        }
        assert!(table.directory.iter().all(|&page| page == NONE));
        let pages = table.pages.len();
        for v in 0..1000 {
            table.set(VertexId(v), v);
        }
        assert!(pages > 60 && table.pages.len() == 1000usize.div_ceil(PER_PAGE));
        assert!((0..1000).all(|v| table.get(VertexId(v)) == Some(v)));
    }
}
