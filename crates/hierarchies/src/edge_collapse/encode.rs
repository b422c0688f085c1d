//! The inverse of a split's replay: from what a collapse did to `sides` and, where needed, an explicit list.

use super::columns::{AddedTriangle, Columns};
use super::front_mesh::{Star, StarCorner, gap_triangle, gaps};

/// A triangle (s, after, before) of the star of s; `after` and `before` are any numbers that tell vertices apart.
#[derive(Clone, Copy, Debug)]
pub struct StarTriangle {
    /// The triangle's number.
    pub number: u32,
    /// The corner after s.
    pub after: u32,
    /// The corner before s.
    pub before: u32,
    /// Whether its corner s was v, not u.
    pub on_v: bool,
}

/// A split as [`Columns`] holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedSplit {
    /// Goes to [`Columns::sides`].
    pub sides: u32,
    /// Whether u and v change names: the first triangle of the sorted star is always on u.
    pub swapped: bool,
    /// Which of the removed triangles is the j-th that the split adds.
    pub order: Vec<usize>,
    /// The list for [`Columns::explicit`], where `sides` does not say it all.
    pub explicit: Option<Vec<AddedTriangle>>,
}

/// Encodes the collapse of u and v into s: its star (it is sorted here; at most [`Columns::MAX_STAR`] triangles), and the removed triangles
/// (u, w, v), or (v, w, u) where the second field is true.
///
/// # Panics
/// Where the star is too large, or a `w` is not a corner of the star.
pub fn encode_split(star: &mut [StarTriangle], removed: &[(u32, bool)]) -> EncodedSplit {
    assert!(star.len() <= Columns::MAX_STAR, "the simplifier keeps stars small");
    star.sort_unstable_by_key(|t| t.number);
    let swapped = star.first().is_some_and(|t| t.on_v);
    let mut sides = 0;
    let mut decoded = Star::new();
    for (i, t) in star.iter().enumerate() {
        sides |= u32::from(t.on_v != swapped) << i;
        decoded.push(StarCorner { after: t.after, before: t.before });
    }
    let find = |w: u32, flipped: bool| removed.iter().position(|&(rw, rf)| rw == w && (rf != swapped) == flipped);
    if let Some(gaps) = gaps(&decoded, sides) {
        let added = gaps.iter().map(|&g| gap_triangle(&decoded, sides, g));
        let order: Option<Vec<usize>> = added.map(|a| find(a.w, a.flipped)).collect();
        if let Some(order) = order.filter(|o| o.len() == removed.len() && (o.len() < 2 || o[0] != o[1])) {
            return EncodedSplit { sides, swapped, order, explicit: None };
        }
    }
    let listed = removed.iter().map(|&(w, flipped)| {
        let star = star.iter().position(|t| t.after == w || t.before == w).expect("w is a neighbour of s");
        AddedTriangle { star: star as u8, before: decoded[star].before == w, flipped: flipped != swapped }
    });
    EncodedSplit {
        sides: sides | Columns::EXPLICIT,
        swapped,
        explicit: Some(listed.collect()),
        order: (0..removed.len()).collect(),
    }
}
