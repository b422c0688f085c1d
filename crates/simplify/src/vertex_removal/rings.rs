//! A 2-manifold as rings: each vertex with its neighbours in the order around it.

use crate::BuildError;
use meshfront_mesh::TriangleMesh;
use rayon::prelude::*;

/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// A neighbour x of a vertex v, and the cell (v, x, the next neighbour).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spoke {
    pub vertex: u32,
    /// `NONE` for the last spoke of an open ring.
    pub cell: u32,
}

/// Where a ring is in `Rings::spokes`.
#[derive(Clone, Copy, Default)]
struct Span {
    start: u32,
    len: u32,
    room: u32,
}

/// The neighbours of each vertex, counter-clockwise seen from outside; from boundary to boundary where it lies on one.
pub(super) struct Rings {
    spokes: Vec<Spoke>,
    spans: Vec<Span>,
}

/// How many spokes more than it has a ring gets room for when it moves.
const SPARE: u32 = 2;

impl Rings {
    /// The rings of a mesh.
    ///
    /// # Errors
    /// A vertex whose triangles do not form one fan in which all are turned the same way.
    pub fn of(mesh: &TriangleMesh) -> Result<Rings, BuildError> {
        let mut spans = vec![Span::default(); mesh.positions.len()];
        for v in mesh.triangles.iter().flatten() {
            spans[v.ix()].room += 1;
        }
        let mut end = 0;
        for s in &mut spans {
            // One more where the ring is open.
            s.room += u32::from(s.room > 0);
            s.start = end;
            end += s.room;
        }
        // First the edges opposite to each vertex: (after, before, cell).
        let mut opposite = vec![(0, 0, NONE); end as usize];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                let span = &mut spans[corners[k].ix()];
                opposite[(span.start + span.len) as usize] = (corners[(k + 1) % 3].0, corners[(k + 2) % 3].0, t as u32);
                span.len += 1;
            }
        }
        let mut spokes = vec![Spoke { vertex: NONE, cell: NONE }; end as usize];
        let mut parts = vec![];
        let (mut rest, mut others) = (&mut spokes[..], &mut opposite[..]);
        for (v, span) in spans.iter_mut().enumerate().filter(|(_, s)| s.room > 0) {
            let (ring, tail) = rest.split_at_mut(span.room as usize);
            let (edges, other_tail) = others.split_at_mut(span.room as usize);
            (rest, others) = (tail, other_tail);
            parts.push((v as u32, span, ring, edges));
        }
        let bad = parts.into_par_iter().filter_map(|(v, span, ring, edges)| {
            let len = chain(&mut edges[..span.len as usize], ring);
            span.len = len.unwrap_or(0);
            len.is_none().then_some(v)
        });
        if let Some(v) = bad.min() {
            return Err(BuildError::NonManifold(v));
        }
        Ok(Rings { spokes, spans })
    }

    pub fn of_vertex(&self, v: u32) -> &[Spoke] {
        let s = self.spans[v as usize];
        &self.spokes[s.start as usize..(s.start + s.len) as usize]
    }

    /// Whether a vertex lies on a boundary.
    pub fn is_open(&self, v: u32) -> bool {
        self.of_vertex(v).last().is_some_and(|s| s.cell == NONE)
    }

    /// Gives a vertex another ring.
    pub fn set(&mut self, v: u32, ring: &[Spoke]) {
        let span = &mut self.spans[v as usize];
        span.len = ring.len() as u32;
        if span.len > span.room {
            *span = Span { start: self.spokes.len() as u32, len: span.len, room: span.len + SPARE };
            self.spokes.resize(self.spokes.len() + span.room as usize, Spoke { vertex: NONE, cell: NONE });
        }
        self.spokes[span.start as usize..][..ring.len()].copy_from_slice(ring);
    }
}

/// Writes the edges opposite to a vertex as a ring, and says how long that is; `None` where they do not form one chain.
fn chain(edges: &mut [(u32, u32, u32)], ring: &mut [Spoke]) -> Option<u32> {
    edges.sort_unstable();
    if edges.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        return None;
    }
    let find = |x: u32| edges.binary_search_by_key(&x, |e| e.0).ok();
    // A chain that is open begins where no edge ends.
    let mut ends: Vec<u32> = edges.iter().map(|e| e.1).collect();
    ends.sort_unstable();
    let first = edges.iter().position(|e| ends.binary_search(&e.0).is_err()).unwrap_or(0);
    let mut at = first;
    for i in 0..edges.len() {
        let (after, before, cell) = edges[at];
        ring[i] = Spoke { vertex: after, cell };
        match find(before) {
            Some(next) if i + 1 < edges.len() && next != first => at = next,
            Some(next) if i + 1 == edges.len() && next == first => return Some(edges.len() as u32),
            None if i + 1 == edges.len() => {
                ring[i + 1] = Spoke { vertex: before, cell: NONE };
                return Some(edges.len() as u32 + 1);
            }
            _ => return None,
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use meshfront_mesh::sample::{self, defects};

    #[test]
    fn rings_hold_all_triangles() {
        for mesh in [sample::sphere(200), sample::scan(400), defects::tetrahedron(), sample::terrain(100)] {
            let rings = Rings::of(&mesh).unwrap();
            let mut seen = vec![0; mesh.triangles.len()];
            for v in 0..mesh.positions.len() as u32 {
                let ring = rings.of_vertex(v);
                for (i, s) in ring.iter().enumerate().filter(|(_, s)| s.cell != NONE) {
                    seen[s.cell as usize] += 1;
                    let mut expected = mesh.triangles[s.cell as usize].map(|v| v.0);
                    while expected[0] != v {
                        expected.rotate_left(1);
                    }
                    assert_eq!(expected, [v, s.vertex, ring[(i + 1) % ring.len()].vertex]);
                }
            }
            assert!(seen.iter().all(|&n| n == 3));
        }
    }

    #[test]
    fn what_is_no_manifold_is_refused() {
        let mut turned = sample::sphere(100);
        turned.triangles[7].swap(0, 1);
        for mesh in [defects::non_manifold_edge(100), defects::bow_tie(100), turned] {
            assert!(matches!(Rings::of(&mesh), Err(BuildError::NonManifold(_))));
        }
    }
}
