//! The triangulations of a convex polygon, and their numbers.
//!
//! Corners are numbered 0, 1, … counter-clockwise. A triangulation is a binary tree that hangs from the edge between the last
//! corner and the first, the *reference edge*: a node (i, a, j), i < a < j, is the triangle on the edge (i, j), what is left
//! of it triangulates i … a, what is right of it a … j. A polygon of n corners has Catalan(n − 2) triangulations; they are
//! numbered in the order of a, then of the left part, then of the right one.

use arrayvec::ArrayVec;
use std::sync::OnceLock;

/// The most corners that a polygon may have: thirteen bits number the triangulations of all polygons up to it.
pub const MOST_CORNERS: usize = 11;

const CATALAN: [u16; MOST_CORNERS - 1] = [1, 1, 2, 5, 14, 42, 132, 429, 1430, 4862];

/// Triangles (i, a, j), i < a < j, each after the one on whose edge it hangs, the left part before the right one.
pub type Triangles = ArrayVec<[u8; 3], { MOST_CORNERS - 2 }>;

/// One of the triangulations of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Triangulation {
    /// Of the polygon, 3 to 11.
    pub corners: u8,
    /// Below [`Triangulation::count`] of the corners.
    pub index: u16,
}

impl Triangulation {
    /// How many triangulations a polygon of 2 to 11 corners has; one of 2 is an edge, and has one.
    pub fn count(corners: usize) -> u16 {
        CATALAN[corners - 2]
    }

    /// Whether corners and index are in range.
    pub fn is_valid(self) -> bool {
        let corners = self.corners as usize;
        (3..=MOST_CORNERS).contains(&corners) && self.index < Triangulation::count(corners)
    }

    /// The triangles; a few steps for each.
    ///
    /// # Panics
    /// Where it is not valid.
    #[inline]
    pub fn triangles(self) -> Triangles {
        let mut triangles = Triangles::new();
        let mut parts = ArrayVec::<(u8, u8, u16), MOST_CORNERS>::new();
        parts.push((0, self.corners - 1, self.index));
        while let Some((i, j, mut index)) = parts.pop() {
            let size = (j - i) as usize;
            if size == 1 {
                continue;
            }
            let mut left = 1;
            let rights = loop {
                let rights = CATALAN[size - left - 1];
                let both = CATALAN[left - 1] * rights;
                if index < both {
                    break rights;
                }
                index -= both;
                left += 1;
            };
            let a = i + left as u8;
            triangles.push([i, a, j]);
            parts.push((a, j, index % rights));
            parts.push((i, a, index / rights));
        }
        triangles
    }

    /// The triangulation that consists of these triangles, in any order and with their corners in any order; `None` where
    /// they are none.
    pub fn of(corners: usize, triangles: &[[u8; 3]]) -> Option<Triangulation> {
        if !(3..=MOST_CORNERS).contains(&corners) || triangles.len() != corners - 2 {
            return None;
        }
        let mut sorted = Triangles::new();
        for t in triangles {
            let mut t = *t;
            t.sort_unstable();
            sorted.push(t);
        }
        let index = part_index(&sorted, 0, corners as u8 - 1)?;
        Some(Triangulation { corners: corners as u8, index })
    }

    /// The same triangles, with corner `by` called 0.
    pub fn turned(self, by: usize) -> Triangulation {
        let n = self.corners;
        let turned: Triangles = self.triangles().iter().map(|t| t.map(|c| (c + n - by as u8) % n)).collect();
        Triangulation::of(n as usize, &turned).expect("a turned triangulation is one")
    }
}

/// Per number of corners: see [`turned_numbers`].
static TURNED: [OnceLock<Vec<u16>>; MOST_CORNERS + 1] = [const { OnceLock::new() }; MOST_CORNERS + 1];

/// The numbers of triangulations that no turn of the polygon makes less, ascending: where every edge of a polygon may be the
/// reference edge, these are enough.
pub(super) fn turned_numbers(corners: usize) -> &'static [u16] {
    TURNED[corners].get_or_init(|| {
        let least = |&index: &u16| {
            let t = Triangulation { corners: corners as u8, index };
            (1..corners).all(|by| t.turned(by).index >= index)
        };
        (0..Triangulation::count(corners)).filter(least).collect()
    })
}

/// The number of a part among those of i … j.
fn part_index(triangles: &[[u8; 3]], i: u8, j: u8) -> Option<u16> {
    let size = (j - i) as usize;
    if size == 1 {
        return Some(0);
    }
    let &[_, a, _] = triangles.iter().find(|t| t[0] == i && t[2] == j)?;
    let left = (a - i) as usize;
    let before: u16 = (1..left).map(|l| CATALAN[l - 1] * CATALAN[size - l - 1]).sum();
    Some(before + part_index(triangles, i, a)? * CATALAN[size - left - 1] + part_index(triangles, a, j)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Every index gives another set of triangles that cover each edge of the polygon once and each chord twice.
    #[test]
    fn indices_number_all_triangulations() {
        for corners in 3..=MOST_CORNERS {
            let mut seen = HashSet::new();
            for index in 0..Triangulation::count(corners) {
                let t = Triangulation { corners: corners as u8, index };
                let triangles = t.triangles();
                assert_eq!(triangles.len(), corners - 2);
                let mut edges = std::collections::BTreeMap::new();
                for &[i, a, j] in &triangles {
                    assert!(i < a && a < j);
                    for e in [[i, a], [a, j], [i, j]] {
                        *edges.entry(e).or_insert(0) += 1;
                    }
                }
                for (&[i, j], &uses) in &edges {
                    let on_rim = j - i == 1 || (i == 0 && j as usize == corners - 1);
                    assert_eq!(uses, if on_rim { 1 } else { 2 }, "{t:?}");
                    let crossed =
                        |&[k, l]: &[u8; 2]| i < k && k < j && (l < i || j < l) || i < l && l < j && (k < i || j < k);
                    assert!(!edges.keys().any(crossed), "{t:?}: chords cross");
                }
                let mut shuffled: Vec<_> = triangles.iter().map(|&[i, a, j]| [j, i, a]).collect();
                shuffled.reverse();
                assert_eq!(Triangulation::of(corners, &shuffled), Some(t));
                let mut sorted = triangles;
                sorted.sort_unstable();
                assert!(seen.insert(sorted), "{t:?} is there twice");
            }
        }
        // Euler's count: 2·6·10·…·(4n − 10) / (n − 1)!
        assert_eq!([5, 6, 11].map(Triangulation::count), [5, 14, 4862]);
    }

    #[test]
    fn turning_all_the_way_changes_nothing() {
        for index in 0..Triangulation::count(7) {
            let t = Triangulation { corners: 7, index };
            assert_eq!((0..7).fold(t, |t, _| t.turned(1)), t);
            assert_eq!(t.turned(3), t.turned(1).turned(2));
        }
        assert_eq!(Triangulation::of(4, &[[0, 1, 2], [0, 1, 3]]), None);
        // Triangulations of a polygon up to turning it (Moon & Moser 1963).
        assert_eq!([3, 4, 5, 6, 7, 8, 9, 10, 11].map(|n| turned_numbers(n).len()), [1, 1, 1, 4, 6, 19, 49, 150, 442]);
    }
}
