//! Lists of updates, one per update: what each needs, and what needs it.

use meshfront_refine::UpdateId;

/// Lists of updates, one per update, end to end: list m is `items[offsets[m]..offsets[m + 1]]`.
#[derive(Clone, Debug)]
pub(crate) struct UpdateLists {
    pub offsets: Vec<u32>,
    pub items: Vec<UpdateId>,
}

impl UpdateLists {
    /// No list yet, and room for those of so many updates.
    pub fn with_capacity(updates: usize) -> UpdateLists {
        let mut offsets = Vec::with_capacity(updates + 1);
        offsets.push(0);
        UpdateLists { offsets, items: Vec::with_capacity(3 * updates) }
    }

    pub fn of(&self, m: usize) -> &[UpdateId] {
        &self.items[self.offsets[m] as usize..self.offsets[m + 1] as usize]
    }

    /// How long each list is.
    pub fn lengths(&self) -> impl Iterator<Item = usize> {
        self.offsets.windows(2).map(|ends| (ends[1] - ends[0]) as usize)
    }

    /// Appends the needs of the next update, given ascending, without those that another of them needs anyway; all, where
    /// they are more than 128.
    pub fn push_reduced(&mut self, direct: &[UpdateId]) {
        if direct.len() > u128::BITS as usize {
            self.items.extend_from_slice(direct);
            return self.offsets.push(self.items.len() as u32);
        }
        // A bounded search finds nearly all that is implied; the rest costs four bytes and changes nothing.
        const MOST_VISITS: usize = 12;
        let least = direct.first().copied().unwrap_or(UpdateId(0));
        let mut implied = 0u128;
        let mut stack = [UpdateId(0); MOST_VISITS];
        for (i, &from) in direct.iter().enumerate().rev() {
            if implied >> i & 1 == 1 {
                continue; // what it needs was seen below the one that implies it
            }
            let (mut len, mut visits) = (1, 0);
            stack[0] = from;
            while len > 0 && visits < MOST_VISITS {
                len -= 1;
                visits += 1;
                for &n in self.of(stack[len].ix()) {
                    if n < least {
                        continue;
                    }
                    if let Ok(k) = direct.binary_search(&n) {
                        implied |= 1 << k;
                    }
                    if len < MOST_VISITS {
                        stack[len] = n;
                        len += 1;
                    }
                }
            }
        }
        let stay = direct.iter().enumerate().filter(|(i, _)| implied >> i & 1 == 0);
        self.items.extend(stay.map(|(_, &n)| n));
        self.offsets.push(self.items.len() as u32);
    }

    /// Who is in whose list, the other way round; lists are ascending.
    pub fn reversed(&self) -> UpdateLists {
        let updates = self.offsets.len() - 1;
        let mut offsets = vec![0u32; updates + 1];
        for n in &self.items {
            offsets[n.ix() + 1] += 1;
        }
        for m in 0..updates {
            offsets[m + 1] += offsets[m];
        }
        let mut at = offsets.clone();
        let mut items = vec![UpdateId(0); self.items.len()];
        for m in 0..updates {
            for n in self.of(m) {
                items[at[n.ix()] as usize] = UpdateId(m as u32);
                at[n.ix()] += 1;
            }
        }
        UpdateLists { offsets, items }
    }
}
