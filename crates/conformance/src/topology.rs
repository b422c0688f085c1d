//! What no update may change. A crack is a new rim, a lost triangle is a new hole, a pinch is a new fan: none of them
//! leaves these numbers as they were.

use crate::Cell;
use std::collections::{BTreeMap, HashSet};

/// Counts that two meshes of the same shape share, however fine they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Parts that are connected by common vertices.
    pub parts: usize,
    /// Vertices − edges + triangles.
    pub euler: isize,
    /// For each number of triangles on an edge other than two (one: boundary): how many connected curves such edges
    /// form, and their vertices − edges (0 for a loop).
    pub seams: BTreeMap<usize, (usize, isize)>,
    /// For each number of fans around a vertex other than one: how many such vertices (bow ties).
    pub bow_ties: BTreeMap<usize, usize>,
    /// Whether no directed edge occurs twice: neighbours are oriented alike.
    pub oriented: bool,
}

/// How many triangles each undirected edge has, the lesser name first.
pub fn edges(cells: &[Cell]) -> BTreeMap<[u32; 2], usize> {
    let mut count = BTreeMap::new();
    for &[a, b, c] in cells {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            *count.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        }
    }
    count
}

impl Topology {
    /// Whether `self` is what a front of a source may have: the same, or turned the same way where the source is not.
    pub fn is_that_of(&self, source: &Topology) -> bool {
        let turned = Topology { oriented: source.oriented, ..self.clone() };
        turned == *source && (self.oriented || !source.oriented)
    }
    /// Looks at all cells.
    ///
    /// # Panics
    /// Where a cell has a corner twice, or two cells have the same corners.
    pub fn of(cells: &[Cell]) -> Topology {
        let mut seen = HashSet::new();
        let mut directed = HashSet::new();
        let mut oriented = true;
        let mut fans = BTreeMap::<u32, Vec<[u32; 2]>>::new();
        for &[a, b, c] in cells {
            assert!(a != b && b != c && c != a, "triangle {a} {b} {c} has a corner twice");
            let mut corners = [a, b, c];
            corners.sort_unstable();
            assert!(seen.insert(corners), "two triangles {a} {b} {c}");
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                oriented &= directed.insert([a, b]);
                fans.entry(a).or_default().push([b, c]);
            }
        }
        let edges = edges(cells);
        let mut by_count = BTreeMap::<usize, Vec<[u32; 2]>>::new();
        for (&edge, &count) in &edges {
            if count != 2 {
                by_count.entry(count).or_default().push(edge);
            }
        }
        let curves = |edges: &Vec<[u32; 2]>| {
            let (curves, vertices) = connected(edges);
            (curves, vertices as isize - edges.len() as isize)
        };
        let mut bow_ties = BTreeMap::new();
        for opposite in fans.values() {
            let (count, _) = connected(opposite);
            if count != 1 {
                *bow_ties.entry(count).or_insert(0) += 1;
            }
        }
        Topology {
            parts: connected(&edges.keys().copied().collect::<Vec<_>>()).0,
            euler: fans.len() as isize - edges.len() as isize + cells.len() as isize,
            seams: by_count.iter().map(|(&count, edges)| (count, curves(edges))).collect(),
            bow_ties,
            oriented,
        }
    }
}

/// The number of connected parts of a graph, and of its vertices.
fn connected(edges: &[[u32; 2]]) -> (usize, usize) {
    let mut names: Vec<u32> = edges.iter().flatten().copied().collect();
    names.sort_unstable();
    names.dedup();
    let index = |name: u32| names.binary_search(&name).expect("collected above");
    let mut above: Vec<usize> = (0..names.len()).collect();
    fn root(above: &mut [usize], mut i: usize) -> usize {
        while above[i] != i {
            above[i] = above[above[i]];
            i = above[i];
        }
        i
    }
    let mut parts = names.len();
    for &[a, b] in edges {
        let (a, b) = (root(&mut above, index(a)), root(&mut above, index(b)));
        if a != b {
            above[a] = b;
            parts -= 1;
        }
    }
    (parts, names.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of triangles around, closed or not: 0 1 2, 1 2 3, ...
    fn strip(n: u32, closed: bool) -> Vec<Cell> {
        let cells = if closed { n } else { n - 2 };
        (0..cells).map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] }.map(|v| v % n)).collect()
    }

    #[test]
    fn sees_what_differs() {
        let disc = Topology::of(&strip(12, false));
        assert_eq!((disc.parts, disc.euler, disc.oriented), (1, 1, true));
        assert_eq!(disc.seams, [(1, (1, 0))].into());
        let ring = Topology::of(&strip(12, true));
        assert_eq!((ring.parts, ring.euler, ring.oriented), (1, 0, true));
        assert_eq!(ring.seams, [(1, (2, 0))].into());
        assert!(!Topology::of(&strip(13, true)).oriented, "a Möbius strip");
        let mut hole = strip(12, true);
        hole.remove(4);
        assert!(!Topology::of(&hole).is_that_of(&ring) && ring.is_that_of(&ring));
        let bow_tie = Topology::of(&[[0, 1, 2], [0, 3, 4]]);
        assert_eq!((bow_tie.parts, bow_tie.bow_ties), (1, [(2, 1)].into()));
        let book = Topology::of(&[[0, 1, 2], [0, 1, 3], [0, 1, 4]]);
        assert_eq!(book.seams[&3], (1, 1));
    }
}
