//! Which update replaces a vertex or a cell: hierarchies store it the other way round.

use meshfront_refine::UpdateId;
use std::sync::OnceLock;

/// An inverse of what is stored, worked out when someone asks first: four bytes per vertex or cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Next(OnceLock<Box<[u32]>>);

const NONE: u32 = u32::MAX;

impl Next {
    /// The update that replaces one of `count` things. `say_all` says of each update what it replaces.
    pub fn of(&self, thing: usize, count: usize, say_all: impl FnOnce(&mut dyn FnMut(usize, u32))) -> Option<UpdateId> {
        let next = self.0.get_or_init(|| {
            let mut next = vec![NONE; count];
            say_all(&mut |thing, m| next[thing] = m);
            next.into()
        });
        next.get(thing).copied().filter(|&m| m != NONE).map(UpdateId)
    }
}
