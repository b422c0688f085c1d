//! When to look at a decision again: a time wheel whose clock is the distance that the view travels.
//!
//! The idea is ROAM's deferred queues (Duchaineau et al. 1997): a decision that cannot flip before the view has
//! travelled its slack needs no look until then. The wheel is hierarchical (Varghese & Lauck 1987) but never
//! cascades: an entry is filed on the ring whose slots are between 1/16 and 1/64 of its slack wide, and is
//! looked at when the clock enters its slot, at most 1/16 of its slack early. So an entry is an id, four bytes,
//! and the wheel does not care whether the viewer is an orbit or a nostril away from the surface.

use std::collections::VecDeque;

const SLOTS: u64 = 64;
/// Rings; each is four times coarser than the one before.
const RINGS: usize = 16;
/// The longest slack that the wheel tells apart, in ticks; longer ones are looked at then.
const LONGEST: u64 = (SLOTS << (2 * (RINGS - 1))) - 1;
const NONE: u32 = u32::MAX;
/// A block fills one cache line.
const PER_BLOCK: usize = 14;

#[derive(Clone, Copy, Debug)]
struct Block {
    next: u32,
    len: u32,
    ids: [u32; PER_BLOCK],
}

/// Ids of updates, each to be handed out once the clock has advanced by a given number of ticks.
#[derive(Clone, Debug)]
pub(crate) struct Calendar {
    now: u64,
    slots: Vec<u32>,
    occupied: [u64; RINGS],
    blocks: Vec<Block>,
    free: u32,
    /// Chains of blocks that are due, oldest first.
    due: VecDeque<u32>,
}

impl Calendar {
    pub fn new() -> Calendar {
        Calendar {
            now: 0,
            slots: vec![NONE; SLOTS as usize * RINGS],
            occupied: [0; RINGS],
            blocks: Vec::new(),
            free: NONE,
            due: VecDeque::new(),
        }
    }

    /// Forgets every entry; what is due, too.
    pub fn clear(&mut self) {
        self.slots.fill(NONE);
        self.occupied = [0; RINGS];
        self.blocks.clear();
        self.free = NONE;
        self.due.clear();
    }

    /// Files `id` to come due before the clock has advanced by more than `ticks`.
    #[inline]
    pub fn file(&mut self, id: u32, ticks: u64) {
        let ticks = ticks.min(LONGEST);
        // The ring where `ticks` is less than 64 slots, and (but for the finest) at least 16.
        let bits = 64 - ticks.leading_zeros();
        let ring = bits.saturating_sub(6).div_ceil(2) as usize;
        let slot = (self.now + ticks) >> (2 * ring) & (SLOTS - 1);
        self.occupied[ring] |= 1 << slot;
        let at = ring * SLOTS as usize + slot as usize;
        let head = self.slots[at];
        if head != NONE {
            let block = &mut self.blocks[head as usize];
            if (block.len as usize) < PER_BLOCK {
                block.ids[block.len as usize] = id;
                block.len += 1;
                return;
            }
        }
        let mut block = Block { next: head, len: 1, ids: [0; PER_BLOCK] };
        block.ids[0] = id;
        self.slots[at] = if self.free != NONE {
            let b = self.free;
            self.free = std::mem::replace(&mut self.blocks[b as usize], block).next;
            b
        } else {
            self.blocks.push(block);
            (self.blocks.len() - 1) as u32
        };
    }

    /// Moves the clock; what comes due joins the end of the queue. Costs at most one step per occupied slot.
    pub fn advance(&mut self, ticks: u64) {
        if ticks == 0 {
            return;
        }
        let before = self.now;
        self.now += ticks;
        for ring in 0..RINGS {
            let (from, to) = (before >> (2 * ring), self.now >> (2 * ring));
            // Slots entered by the clock. The finest ring may hold entries in the slot where the clock stood.
            let first = if ring == 0 { from } else { from + 1 };
            if to < first {
                continue;
            }
            let passed = to - first + 1;
            let mask = if passed >= SLOTS {
                u64::MAX
            } else {
                (u64::MAX >> (SLOTS - passed)).rotate_left((first & (SLOTS - 1)) as u32)
            };
            let mut hit = self.occupied[ring] & mask;
            self.occupied[ring] &= !mask;
            while hit != 0 {
                let at = ring * SLOTS as usize + hit.trailing_zeros() as usize;
                self.due.push_back(std::mem::replace(&mut self.slots[at], NONE));
                hit &= hit - 1;
            }
        }
    }

    pub fn has_due(&self) -> bool {
        !self.due.is_empty()
    }

    /// The next id that is due.
    #[inline]
    pub fn take_due(&mut self) -> Option<u32> {
        let head = *self.due.front()?;
        let block = &mut self.blocks[head as usize];
        block.len -= 1;
        let id = block.ids[block.len as usize];
        if block.len == 0 {
            let next = std::mem::replace(&mut block.next, self.free);
            self.free = head;
            if next == NONE {
                self.due.pop_front();
            } else {
                self.due[0] = next;
            }
        }
        Some(id)
    }

    /// Heap memory, in bytes.
    pub fn memory(&self) -> usize {
        self.slots.capacity() * 4 + self.blocks.capacity() * size_of::<Block>() + self.due.capacity() * 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn nothing_comes_late_twice_or_much_too_early() {
        let mut seed = 88172645463325252u64;
        let mut random = |below: u64| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed % below
        };
        let mut calendar = Calendar::new();
        let mut filed: HashMap<u32, (u64, u64)> = HashMap::new();
        let (mut now, mut next) = (0u64, 0u32);
        for _ in 0..4000 {
            for _ in 0..random(20) {
                let ticks = { 1u64 << random(40) } + random(100) - 1;
                calendar.file(next, ticks);
                filed.insert(next, (now, ticks));
                next += 1;
            }
            let step = { 1u64 << random(30) } - 1 + random(3);
            calendar.advance(step);
            now += step;
            while let Some(id) = calendar.take_due() {
                let (since, ticks) = filed.remove(&id).expect("handed out once");
                let ticks = ticks.min(LONGEST);
                assert!(now - since >= ticks - ticks / 16 || ticks < 64, "{ticks} looked at after {}", now - since);
                assert!(now > since);
            }
            for &(since, ticks) in filed.values() {
                assert!(now - since < ticks || now == since, "{ticks} missed at {}", now - since);
            }
        }
        assert!(next > 10_000 && !filed.is_empty());
    }
}
