//! From slots that changed to ranges that are uploaded.

/// Slots as ascending, disjoint pairs (first slot, number of slots), flat: `[first, count, first, count, …]`.
///
/// One upload call costs as much as some kilobytes, so ranges are joined over unchanged slots, smallest gaps first, as long as those
/// are at most `spare` times the changed ones; and beyond that until there are at most `most` ranges. Sorts `slots`, which
/// may repeat. `O(n log n)`.
pub fn coalesce(slots: &mut Vec<u32>, spare: usize, most: usize) -> Vec<u32> {
    slots.sort_unstable();
    slots.dedup();
    let mut gaps: Vec<u32> = slots.windows(2).map(|pair| pair[1] - pair[0] - 1).filter(|&gap| gap > 0).collect();
    gaps.sort_unstable();
    let mut room = spare * slots.len();
    let mut joined = 0;
    while joined < gaps.len() && (gaps[joined] as usize <= room || gaps.len() + 1 - joined > most.max(1)) {
        room = room.saturating_sub(gaps[joined] as usize);
        joined += 1;
    }
    // Of gaps that are equally large, the first are joined.
    let widest = joined.checked_sub(1).map_or(0, |last| gaps[last]);
    let mut as_wide = gaps[..joined].iter().rev().take_while(|&&gap| gap == widest).count();
    let mut ranges: Vec<u32> = Vec::with_capacity(2 * (gaps.len() + 1 - joined));
    for &slot in slots.iter() {
        if let Some([first, count]) = ranges.last_chunk_mut::<2>() {
            let gap = slot - (*first + *count);
            if gap < widest || gap == 0 || (gap == widest && as_wide > 0) {
                as_wide -= usize::from(gap > 0 && gap == widest);
                *count = slot - *first + 1;
                continue;
            }
        }
        ranges.extend([slot, 1]);
    }
    ranges
}

/// How many slots ranges hold.
pub fn slots(ranges: &[u32]) -> usize {
    ranges.chunks_exact(2).map(|range| range[1] as usize).sum()
}

/// The contents of the ranged slots, one range after the other, flattened to numbers.
pub fn gather<T: Copy, const N: usize>(column: &[[T; N]], ranges: &[u32]) -> Vec<T> {
    let mut packed = Vec::with_capacity(slots(ranges) * N);
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
        assert_eq!(coalesce(&mut vec![5], 2, 1), [5, 1]);
        assert_eq!(coalesce(&mut vec![u32::MAX - 1, 0], 8, 100), [0, 1, u32::MAX - 1, 1]);
    }

    #[test]
    fn small_gaps_are_filled_first_as_long_as_there_is_room() {
        assert_eq!(coalesce(&mut vec![0, 3, 10], 2, 100), [0, 4, 10, 1]);
        assert_eq!(coalesce(&mut vec![0, 3, 10], 3, 100), [0, 11]);
        // Room for two of three gaps of one.
        assert_eq!(coalesce(&mut vec![0, 2, 4, 6, 90], 0, 100), [0, 1, 2, 1, 4, 1, 6, 1, 90, 1]);
        assert_eq!(coalesce(&mut vec![0, 2, 4, 6], 1, 100), [0, 7]);
    }

    #[test]
    fn what_is_filled_in_keeps_to_its_share_where_there_are_few_ranges() {
        let slots: Vec<u32> = (0..400).map(|i| (i * i * 7919) % 40_000).collect();
        let mut unique = slots.clone();
        unique.sort_unstable();
        unique.dedup();
        let ranges = coalesce(&mut slots.clone(), 2, 1000);
        let written: usize = ranges.chunks_exact(2).map(|r| r[1] as usize).sum();
        assert!(written <= 3 * unique.len() && written > 2 * unique.len(), "{written} for {}", unique.len());
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
