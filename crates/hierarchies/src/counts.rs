//! Which decisions are open, by counting: a look at a count costs less than one at the lists of every neighbour.

use crate::lists::UpdateLists;
use meshfront_refine::UpdateId;

/// Per update: how many others it needs, as far as they are listed. What a front counts down from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Needed(Vec<u8>);

impl Needed {
    /// Of lists of what updates with limited stars need: some dozens at most.
    pub fn of(needs: &UpdateLists) -> Needed {
        Needed(needs.lengths().map(|length| u8::try_from(length).expect("stars are limited")).collect())
    }
    /// Bytes.
    pub fn memory_bytes(&self) -> usize {
        self.0.len()
    }
}

/// A front's counts: five bytes per update. Of a vertex with very many neighbours the one update that made it may be needed by
/// more than sixteen bits can count.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counts {
    /// Per update: how many of its needs are not applied.
    missing: Vec<u8>,
    /// Per update: how many of those that need it are applied.
    holding: Vec<u32>,
}

impl Counts {
    /// Of the base mesh.
    pub fn new(needed: &Needed) -> Counts {
        Counts { missing: needed.0.clone(), holding: vec![0; needed.0.len()] }
    }
    /// Of the base mesh again.
    pub fn reset(&mut self, needed: &Needed) {
        self.missing.copy_from_slice(&needed.0);
        self.holding.fill(0);
    }
    /// One of the needs of `m` is applied: whether it was the last one.
    #[inline]
    pub fn meet(&mut self, m: UpdateId) -> bool {
        let missing = &mut self.missing[m.ix()];
        *missing -= 1;
        *missing == 0
    }
    /// One of the needs of `m` is undone.
    #[inline]
    pub fn miss(&mut self, m: UpdateId) {
        self.missing[m.ix()] += 1;
    }
    /// One that needs `m` is applied.
    #[inline]
    pub fn hold(&mut self, m: UpdateId) {
        self.holding[m.ix()] += 1;
    }
    /// One that needs `m` is undone: whether it was the last one.
    #[inline]
    pub fn free(&mut self, m: UpdateId) -> bool {
        let holding = &mut self.holding[m.ix()];
        *holding -= 1;
        *holding == 0
    }
    /// Bytes.
    pub fn memory_bytes(&self) -> usize {
        5 * self.missing.len()
    }
}
