//! The forest that columns describe, with its leaves in depth-first order: whether a leaf lies below a node is a comparison.

use super::Key;
use super::columns::Columns;
use crate::columns::{InvalidColumns, check_base, check_lengths, check_update};
use meshfront_mesh::VertexId;

/// Ids must leave room for numbers of nodes and for corners, which are four times a slot.
const MAX: usize = 1 << 28;

const NONE: u32 = u32::MAX;

/// A forest, checked. Places are ranks of leaves in depth-first order, u before v.
#[derive(Clone, Debug)]
pub struct Forest {
    /// Per node: the update that splits it; for leaves the number of updates plus the place.
    pub keys: Vec<Key>,
    /// Per root: the place of the first leaf below it.
    pub first_leaves: Vec<u32>,
    /// Per update: the place of the first leaf below v.
    pub middles: Vec<u32>,
    /// Per update: its first triangle.
    pub firsts: Vec<u32>,
    /// [`Columns::triangles`] by places.
    pub triangles: Vec<[u32; 3]>,
}

impl Forest {
    /// Checks everything in columns but two things, which need a replay: that errors do not grow downwards, and that the other
    /// two corners of a triangle that comes with one child are two nodes.
    ///
    /// # Errors
    /// Columns that do not describe a forest with triangles, with the update concerned.
    pub fn of(c: &Columns) -> Result<Forest, InvalidColumns> {
        check_shape(c)?;
        let (updates, roots) = (c.vertex.len(), c.base.positions.len());
        let invalid = |m: usize, reason| InvalidColumns::Update { update: m as u32, reason };

        // Per node: the update that splits it, later its key.
        let mut keys = vec![NONE; roots + 2 * updates];
        for (m, s) in c.vertex.iter().enumerate() {
            if s.ix() >= roots + 2 * m {
                return Err(invalid(m, "splits a node that is not there yet"));
            }
            if std::mem::replace(&mut keys[s.ix()], m as u32) != NONE {
                return Err(invalid(m, "splits a node that is split already"));
            }
        }
        let mut leaves_below = vec![0u32; updates];
        for m in (0..updates).rev() {
            let below = |node: usize| if keys[node] == NONE { 1 } else { leaves_below[keys[node] as usize] };
            leaves_below[m] = below(roots + 2 * m) + below(roots + 2 * m + 1);
        }
        // The places of the leaves below each update: from, and up to.
        let mut spans = vec![[0u32; 2]; updates];
        let mut settle = |spans: &mut [[u32; 2]], node: usize, from: u32| match keys[node] {
            NONE => {
                keys[node] = updates as u32 + from;
                from + 1
            }
            m => {
                let up_to = from + leaves_below[m as usize];
                spans[m as usize] = [from, up_to];
                up_to
            }
        };
        let mut first_leaves = vec![];
        let mut from = 0;
        for root in 0..roots {
            first_leaves.push(from);
            from = settle(&mut spans, root, from);
        }
        let mut middles = vec![0; updates];
        for m in 0..updates {
            let from = spans[m][0];
            middles[m] = settle(&mut spans, roots + 2 * m, from);
            settle(&mut spans, roots + 2 * m + 1, middles[m]);
        }

        let place = |leaf: VertexId| {
            let key = keys.get(leaf.ix())?;
            key.checked_sub(updates as u32)
        };
        let mut triangles = Vec::with_capacity(c.triangles.len());
        let (base_triangles, added_triangles) = c.triangles.split_at(c.base.triangles.len());
        for (t, corners) in base_triangles.iter().zip(&c.base.triangles) {
            let below = |(leaf, root): (VertexId, VertexId)| {
                let place = place(leaf)?;
                let end = first_leaves.get(root.ix() + 1).copied().unwrap_or(NONE);
                (first_leaves[root.ix()] <= place && place < end).then_some(place)
            };
            let [a, b, c] = [0, 1, 2].map(|k| below((t[k], corners[k])));
            let leaves = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
            triangles.push(leaves.ok_or(InvalidColumns::Base("a triangle's leaves are not below its corners"))?);
        }
        let mut firsts = Vec::with_capacity(updates);
        let mut rest = added_triangles;
        for m in 0..updates {
            firsts.push(triangles.len() as u32);
            let (own, others) = rest.split_at(c.added[m] as usize);
            rest = others;
            let ([from, up_to], middle) = (spans[m], middles[m]);
            for t in own {
                let leaves = t.map(place);
                let [Some(x), Some(y), Some(z)] = leaves else {
                    return Err(invalid(m, "a triangle names a node that is no leaf"));
                };
                let count =
                    |from: u32, up_to: u32| [x, y, z].iter().filter(|&&leaf| from <= leaf && leaf < up_to).count();
                let (on_u, on_v) = (count(from, middle), count(middle, up_to));
                if on_u > 1 || on_v > 1 || on_u + on_v == 0 {
                    return Err(invalid(
                        m,
                        "adds a triangle that does not have one or both of its nodes at a corner each",
                    ));
                }
                triangles.push([x, y, z]);
            }
        }
        Ok(Forest { keys, first_leaves, middles, firsts, triangles })
    }
}

/// Lengths, ranges and finite numbers.
fn check_shape(c: &Columns) -> Result<(), InvalidColumns> {
    let updates = c.vertex.len();
    let base = &c.base;
    let added: u64 = c.added.iter().map(|&n| n as u64).sum();
    check_lengths(&[
        ("added", c.added.len(), updates, false),
        ("positions", c.positions.len(), updates, false),
        ("errors", c.errors.len(), updates, false),
        ("normals", c.normals.len(), updates, base.vertex.normals.is_empty()),
        ("colors", c.colors.len(), updates, base.vertex.colors.is_empty()),
        ("base normals", base.vertex.normals.len(), base.positions.len(), c.normals.is_empty()),
        ("base colors", base.vertex.colors.len(), base.positions.len(), c.colors.is_empty()),
        (
            "triangles",
            c.triangles.len(),
            usize::try_from(added + base.triangles.len() as u64).unwrap_or(usize::MAX),
            false,
        ),
    ])?;
    let most = updates.max(base.positions.len()).max(c.triangles.len());
    if most > MAX {
        return Err(InvalidColumns::TooMany(most));
    }
    check_base(base, c.grid, c.floor_error)?;
    for m in 0..updates {
        check_update(m, &c.positions[m], c.errors[m], c.grid)?;
    }
    Ok(())
}
