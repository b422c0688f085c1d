//! From slots that changed to ranges that are uploaded.

/// Slots as ascending, disjoint pairs (first slot, number of slots), flat: `[first, count, first, count, …]`.
///
/// One upload call costs as much as some kilobytes, so ranges with at most `gap` unchanged slots between them become
/// one; `gap` is doubled until there are at most `most` ranges. Sorts `slots`, which may repeat. `O(n log n)`.
pub fn coalesce(slots: &mut Vec<u32>, mut gap: u32, most: usize) -> Vec<u32> {
    slots.sort_unstable();
    slots.dedup();
    loop {
        let mut ranges: Vec<u32> = Vec::new();
        for &slot in slots.iter() {
            match ranges.last_chunk_mut::<2>() {
                Some([first, count]) if slot - (*first + *count) <= gap => *count = slot - *first + 1,
                _ => ranges.extend([slot, 1]),
            }
        }
        if ranges.len() <= 2 * most.max(1) {
            return ranges;
        }
        gap = gap.saturating_mul(2).max(1);
    }
}

/// The contents of the ranged slots, one range after the other, flattened to numbers.
pub fn gather<T: Copy, const N: usize>(column: &[[T; N]], ranges: &[u32]) -> Vec<T> {
    let slots: usize = ranges.chunks_exact(2).map(|r| r[1] as usize).sum();
    let mut packed = Vec::with_capacity(slots * N);
    for range in ranges.chunks_exact(2) {
        let (first, count) = (range[0] as usize, range[1] as usize);
        packed.extend_from_slice(column[first..first + count].as_flattened());
    }
    packed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_become_one_range_and_repetitions_none() {
        assert_eq!(coalesce(&mut vec![7, 3, 4, 3, 5, 9], 0, 100), [3, 3, 7, 1, 9, 1]);
        assert_eq!(coalesce(&mut vec![], 0, 100), [] as [u32; 0]);
        assert_eq!(coalesce(&mut vec![u32::MAX - 1, 0], 8, 100), [0, 1, u32::MAX - 1, 1]);
    }

    #[test]
    fn small_gaps_are_filled_and_large_ones_kept() {
        assert_eq!(coalesce(&mut vec![0, 3, 10], 2, 100), [0, 4, 10, 1]);
    }

    #[test]
    fn ranges_stay_few_and_still_cover_every_slot() {
        let slots: Vec<u32> = (0..1000).map(|i| i * i).collect();
        let ranges = coalesce(&mut slots.clone(), 1, 64);
        assert!(ranges.len() <= 128);
        for r in ranges.chunks_exact(4) {
            assert!(r[0] + r[1] < r[2], "ascending and apart: {r:?}");
        }
        for s in slots {
            assert!(ranges.chunks_exact(2).any(|r| r[0] <= s && s < r[0] + r[1]), "slot {s} is lost");
        }
    }

    #[test]
    fn gathered_slots_follow_their_ranges() {
        let column = [[0, 1], [10, 11], [20, 21], [30, 31]];
        assert_eq!(gather(&column, &[0, 1, 2, 2]), [0, 1, 20, 21, 30, 31]);
    }
}
