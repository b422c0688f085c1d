//! Which decisions are open, by counting: a look at a count costs less than one at the lists of every neighbour.

use crate::lists::UpdateLists;
use meshfront_refine::UpdateId;

/// Per update: how many others it needs, as far as they are listed. What a front counts down from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Needed(Vec<u8>);

impl Needed {
    /// # Errors
    /// The first update whose lists are longer than what is counted.
    pub fn of(needs: &UpdateLists, children: &UpdateLists) -> Result<Needed, UpdateId> {
        let updates = needs.offsets.len() - 1;
        let too_many = |m: &usize| children.of(*m).len() > u16::MAX as usize || needs.of(*m).len() > u8::MAX as usize;
        match (0..updates).find(too_many) {
            Some(m) => Err(UpdateId(m as u32)),
            None => Ok(Needed((0..updates).map(|m| needs.of(m).len() as u8).collect())),
        }
    }
    /// Bytes.
    pub fn memory_bytes(&self) -> usize {
        self.0.len()
    }
}

/// A front's counts: three bytes per update.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counts {
    /// Per update: how many of its needs are not applied.
    missing: Vec<u8>,
    /// Per update: how many of those that need it are applied.
    holding: Vec<u16>,
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
        3 * self.missing.len()
    }
}
