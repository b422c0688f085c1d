//! The order of the updates of a hierarchy, coarse to fine.
//!
//! By octave of the error, so that a prefix is a mesh of that error; inside an octave along a space-filling curve,
//! each update right after those of its needs that were still missing. Neighbours in space are neighbours in
//! memory and in the file.

use glam::Vec3;
use meshfront_hierarchies::edge_collapse::round_error_up;
use meshfront_mesh::Bounds;
use rayon::prelude::*;

/// Sorts the steps of a record, given fine to coarse: where each is, and which later ones it needs. Makes errors such that what
/// is needed is at least as wrong, and such as a file holds.
pub(crate) fn order<N: Iterator<Item = u32>>(
    bounds: &Bounds,
    places: &[Vec3],
    needs: impl Fn(usize) -> N,
    error: &mut [f32],
) -> Vec<u32> {
    let updates = error.len();
    error.iter_mut().for_each(|e| *e = round_error_up(*e));
    for i in 0..updates {
        for p in needs(i) {
            error[p as usize] = error[p as usize].max(error[i]);
        }
    }
    let octave: Vec<u32> = error.iter().map(|e| e.to_bits() >> 23).collect();
    let curve: Vec<u64> = places.par_iter().map(|&p| morton(bounds, p)).collect();
    let mut along: Vec<u32> = (0..updates as u32).collect();
    along.par_sort_unstable_by_key(|&i| (std::cmp::Reverse(octave[i as usize]), curve[i as usize], i));
    let mut order: Vec<u32> = Vec::with_capacity(updates);
    let mut placed = vec![false; updates];
    let mut stack = vec![];
    for &seed in &along {
        stack.push(seed);
        while let Some(&i) = stack.last() {
            let open = stack.len();
            if !placed[i as usize] {
                stack.extend(needs(i as usize).filter(|&p| !placed[p as usize]));
            }
            if stack.len() == open {
                stack.pop();
                if !std::mem::replace(&mut placed[i as usize], true) {
                    order.push(i);
                }
            }
        }
    }
    order
}

/// The place of a point on a Z-order curve through a box, 21 bits a side.
pub(crate) fn morton(bounds: &Bounds, p: Vec3) -> u64 {
    let side = (bounds.max - bounds.min).max_element().max(f32::MIN_POSITIVE);
    let cell = ((p - bounds.min) / side * ((1 << 21) - 1) as f32).as_uvec3();
    // Spreads 21 bits to every third place, in halves.
    let spread = |x: u32| {
        let mut x = x as u64 & 0x1f_ffff;
        for (shift, mask) in [
            (32, 0x1f_0000_0000_ffff),
            (16, 0x1f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ] {
            x = (x | x << shift) & mask;
        }
        x
    };
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}
