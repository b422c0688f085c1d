//! When to look at a decision again: time wheels whose clocks are the distance that the view travels.
//!
//! The idea is ROAM's deferred queues (`duchaineau1997`): a decision that cannot flip before the view has
//! travelled its slack needs no look until then. Each cell of a coarse grid over the hierarchy has a wheel with a
//! clock of its own, since the same step brings the view nearer to one place and takes it past another.
//!
//! A wheel is hierarchical (`varghese1987`) but never cascades: an entry is filed on the ring whose slots
//! are between 1/8 and 1/32 of its slack wide, and is looked at when the clock enters its slot, at most 1/8 of its
//! slack early. So an entry is an id, four bytes, and the wheel does not care whether the viewer is an orbit or
//! a nostril away from the surface.

use std::collections::VecDeque;

const SLOTS: u64 = 32;
/// Rings; each is four times coarser than the one before.
const RINGS: usize = 10;
/// The longest slack that a wheel tells apart, in ticks; longer ones are looked at then.
pub(crate) const LONGEST: u64 = (SLOTS << (2 * (RINGS - 1))) - 1;
const NONE: u32 = u32::MAX;
/// Half a cache line a block: most slots hold few entries.
const PER_BLOCK: usize = 6;

#[derive(Clone, Copy, Debug)]
struct Block {
    next: u32,
    len: u32,
    ids: [u32; PER_BLOCK],
}

#[derive(Clone, Debug)]
struct Wheel {
    now: u64,
    occupied: [u32; RINGS],
    slots: [[u32; SLOTS as usize]; RINGS],
}

/// Ids of updates, each to be handed out once the clock of its wheel has advanced by a given number of ticks.
#[derive(Clone, Debug)]
pub(crate) struct Calendar {
    wheels: Vec<Wheel>,
    blocks: Vec<Block>,
    free: u32,
    /// Chains of blocks that are due, oldest first.
    due: VecDeque<u32>,
}

impl Calendar {
    pub fn new(wheels: usize) -> Calendar {
        let wheel = Wheel { now: 0, occupied: [0; RINGS], slots: [[NONE; SLOTS as usize]; RINGS] };
        Calendar { wheels: vec![wheel; wheels], blocks: Vec::new(), free: NONE, due: VecDeque::new() }
    }

    /// Forgets every entry; what is due, too.
    pub fn clear(&mut self) {
        for wheel in &mut self.wheels {
            wheel.occupied = [0; RINGS];
            wheel.slots = [[NONE; SLOTS as usize]; RINGS];
        }
        self.blocks.clear();
        self.free = NONE;
        self.due.clear();
    }

    /// Files `id` to come due before the clock of `wheel` has advanced by more than `ticks`.
    #[inline]
    pub fn file(&mut self, wheel: usize, id: u32, ticks: u64) {
        let wheel = &mut self.wheels[wheel];
        let ticks = ticks.min(LONGEST);
        // The ring where `ticks` is less than 32 slots, and (but for the finest) at least 8.
        let bits = 64 - ticks.leading_zeros();
        let ring = bits.saturating_sub(5).div_ceil(2) as usize;
        let slot = ((wheel.now + ticks) >> (2 * ring) & (SLOTS - 1)) as usize;
        wheel.occupied[ring] |= 1 << slot;
        let head = &mut wheel.slots[ring][slot];
        if let Some(block) = self.blocks.get_mut(*head as usize)
            && (block.len as usize) < PER_BLOCK
        {
            block.ids[block.len as usize] = id;
            block.len += 1;
            return;
        }
        let mut block = Block { next: *head, len: 1, ids: [0; PER_BLOCK] };
        block.ids[0] = id;
        *head = if self.free != NONE {
            let b = self.free;
            self.free = std::mem::replace(&mut self.blocks[b as usize], block).next;
            b
        } else {
            if self.blocks.len() == self.blocks.capacity() {
                // By an eighth, not by doubling: the calendar is most of the engine's memory.
                self.blocks.reserve_exact(self.blocks.len() / 8 + 64);
            }
            self.blocks.push(block);
            (self.blocks.len() - 1) as u32
        };
    }

    /// Moves the clock of a wheel; what comes due joins the end of the queue. Costs a step per ring and per
    /// occupied slot that was passed.
    pub fn advance(&mut self, wheel: usize, ticks: u64) {
        if ticks == 0 {
            return;
        }
        let wheel = &mut self.wheels[wheel];
        let before = wheel.now;
        wheel.now += ticks;
        for ring in 0..RINGS {
            if wheel.occupied[ring] == 0 {
                continue;
            }
            let (from, to) = (before >> (2 * ring), wheel.now >> (2 * ring));
            // Slots entered by the clock. The finest ring may hold entries in the slot where the clock stood.
            let first = if ring == 0 { from } else { from + 1 };
            if to < first {
                continue;
            }
            let passed = to - first + 1;
            let mask = if passed >= SLOTS {
                u32::MAX
            } else {
                (u32::MAX >> (SLOTS - passed)).rotate_left((first & (SLOTS - 1)) as u32)
            };
            let mut hit = wheel.occupied[ring] & mask;
            wheel.occupied[ring] &= !mask;
            while hit != 0 {
                let slot = &mut wheel.slots[ring][hit.trailing_zeros() as usize];
                self.due.push_back(std::mem::replace(slot, NONE));
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
        self.wheels.capacity() * size_of::<Wheel>()
            + self.blocks.capacity() * size_of::<Block>()
            + self.due.capacity() * size_of::<u32>()
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
        let mut calendar = Calendar::new(2);
        let mut filed: HashMap<u32, (usize, u64, u64)> = HashMap::new();
        let (mut now, mut next) = ([0u64; 2], 0u32);
        for _ in 0..4000 {
            for _ in 0..random(20) {
                let ticks = { 1u64 << random(26) } + random(100) - 1;
                let wheel = random(2) as usize;
                calendar.file(wheel, next, ticks);
                filed.insert(next, (wheel, now[wheel], ticks));
                next += 1;
            }
            let step = { 1u64 << random(22) } - 1 + random(3);
            let wheel = random(2) as usize;
            calendar.advance(wheel, step);
            now[wheel] += step;
            while let Some(id) = calendar.take_due() {
                let (wheel, since, ticks) = filed.remove(&id).expect("handed out once");
                let now = now[wheel];
                let ticks = ticks.min(LONGEST);
                assert!(now - since >= ticks - ticks / 8 || ticks < 32, "{ticks} looked at after {}", now - since);
                assert!(now > since);
            }
            for &(wheel, since, ticks) in filed.values() {
                let now = now[wheel];
                assert!(now - since < ticks || now == since, "{ticks} missed at {}", now - since);
            }
        }
        assert!(next > 10_000 && !filed.is_empty());
    }
}
