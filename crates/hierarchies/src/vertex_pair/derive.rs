//! From stored columns to a hierarchy. The forest and its triangles are checked by arithmetic on the order of leaves;
//! undoing all splits, last to first, then yields what follows from the stars.

use super::columns::Columns;
use super::forest::Forest;
use super::front_mesh::FrontMesh;
use super::{Origin, Root, Split, VertexPair};
use crate::columns::InvalidColumns;
use crate::footprint::{Cells, Frame, PackedFootprint, step_cost};
use crate::model::{Progress, replayed};
use crate::quantize::{Oct, Places};
use glam::Vec3;
use meshfront_mesh::Bounds;
use meshfront_refine::{Footprint, MultiTessellation, UpdateId};

/// How many direct needs an update or a triangle may have on the average of the whole. Surfaces have three or four per update;
/// what has more would take memory out of proportion.
const MOST_NEEDS: usize = 64;

const NONE: u32 = u32::MAX;

pub(super) fn derive(columns: Columns, progress: Progress) -> Result<VertexPair, InvalidColumns> {
    let mut h = undecorated(columns)?;
    if !h.source_normals {
        derive_normals(&mut h);
    }
    let mut front = FrontMesh::base(&h);
    for m in (0..h.splits.len() as u32).map(UpdateId) {
        replayed(progress, m.ix(), h.splits.len());
        let s = front.slot(m.0).expect("a forest");
        if front.star(s).take(Columns::MAX_STAR + 1).count() > Columns::MAX_STAR {
            return Err(InvalidColumns::Update { update: m.0, reason: "its star has too many triangles" });
        }
        front.refine(&h, m);
        front.buffers.clear_changes();
        for slot in h.splits[m.ix()].children.iter().filter_map(|&key| front.slot(key)) {
            let mut own = front.star(slot).take_while(|t| front.number(t.corner) >= h.added(m).start);
            if own.any(|t| t.after == t.before) {
                return Err(InvalidColumns::Update { update: m.0, reason: "adds a triangle that has a corner twice" });
            }
        }
    }
    undo_all(&mut h, front)?;
    Ok(h)
}

/// The hierarchy with the stored columns only.
fn undecorated(c: Columns) -> Result<VertexPair, InvalidColumns> {
    let (updates, roots) = (c.vertex.len(), c.base.positions.len());
    let Forest { keys, first_leaves, middles, firsts, triangles } = Forest::of(&c)?;
    let points = c.base.positions.iter().chain(c.positions.iter().flatten());
    let bounds = Bounds::over(points.copied());
    let frame = Frame::new(bounds.unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO }));
    let source_normals = !c.base.vertex.normals.is_empty();
    let places = Places::on(c.grid);
    let splits = (0..updates).map(|m| Split {
        parent: match c.vertex[m].ix().checked_sub(roots) {
            None => Split::ROOT | c.vertex[m].0,
            Some(child) => child as u32 / 2,
        },
        children: [keys[roots + 2 * m], keys[roots + 2 * m + 1]],
        middle: middles[m],
        first: firsts[m],
        normals: c.normals.get(m).copied().unwrap_or_default(),
        place: c.positions[m].map(|p| places.split(p).0),
    });
    Ok(VertexPair {
        splits: splits.collect(),
        roots: (0..roots).map(|v| Root { key: keys[v], first_leaf: first_leaves[v] }).collect(),
        triangles,
        base_normals: if source_normals {
            c.base.vertex.normals.iter().map(|&n| Oct::encode(n)).collect()
        } else {
            vec![Oct::default(); roots]
        },
        base: c.base,
        fine_places: match places {
            Places::Grid16(_) => vec![],
            Places::Points => c.positions.iter().map(|pair| pair.map(|p| places.split(p).1)).collect(),
        },
        places,
        grid: c.grid,
        source_normals,
        colors: c.colors,
        costs: vec![0.0; updates],
        footprints: c.errors.iter().map(|&error| PackedFootprint::of_error(error)).collect(),
        frame,
        hidden: vec![],
        floor_error: c.floor_error,
        source: c.source,
    })
}

/// Vertex normals where the source had none: each node gets the area-weighted mean normal of the full-resolution surface
/// below it.
fn derive_normals(h: &mut VertexPair) {
    let updates = h.splits.len();
    let mut sums = vec![Vec3::ZERO; updates + h.most().vertices];
    let mut points = vec![Vec3::ZERO; h.most().vertices];
    let mut settle = |key: u32, point| {
        if let Some(place) = key.checked_sub(updates as u32) {
            points[place as usize] = point;
        }
    };
    h.roots.iter().zip(&h.base.positions).for_each(|(root, &p)| settle(root.key, p));
    for (m, split) in h.splits.iter().enumerate() {
        (0..2).for_each(|which| settle(split.children[which], h.place(UpdateId(m as u32), which)));
    }
    for t in &h.triangles {
        let [a, b, c] = t.map(|place| points[place as usize]);
        let normal = (b - a).cross(c - a);
        t.iter().for_each(|&place| sums[updates + place as usize] += normal);
    }
    for (m, split) in h.splits.iter_mut().enumerate().rev() {
        let [u, v] = split.children.map(|key| sums[key as usize]);
        sums[m] = u + v;
        split.normals = [Oct::encode(u), Oct::encode(v)];
    }
    h.base_normals = h.roots.iter().map(|root| Oct::encode(sums[root.key as usize])).collect();
}

/// Lists of updates that need an update, each gone once it is taken.
struct Dependents {
    heads: Vec<u32>,
    /// The next of the list, and an update.
    entries: Vec<(u32, u32)>,
    free: u32,
    /// All that there ever were.
    count: usize,
}

impl Dependents {
    fn push(&mut self, of: UpdateId, m: u32) {
        let entry = (self.heads[of.ix()], m);
        self.heads[of.ix()] = match self.free {
            NONE => {
                self.entries.push(entry);
                self.entries.len() as u32 - 1
            }
            at => {
                self.free = std::mem::replace(&mut self.entries[at as usize], entry).0;
                at
            }
        };
        self.count += 1;
    }
    fn take(&mut self, of: u32, mut visit: impl FnMut(UpdateId)) {
        let mut at = std::mem::replace(&mut self.heads[of as usize], NONE);
        while at != NONE {
            let (next, m) = std::mem::replace(&mut self.entries[at as usize], (self.free, 0));
            self.free = at;
            visit(UpdateId(m));
            at = next;
        }
    }
}

/// Undoes all splits, last first: at each the star is what it was when the source was merged. Yields footprints, costs
/// and hidden needs.
///
/// An update needs those that made s, the neighbours of s, and the other corners of the triangles that it adds. A neighbour
/// that is older than s was one of the node that s came from, or such a corner, so what made it is needed by what
/// made s: only younger ones need a list.
fn undo_all(h: &mut VertexPair, mut front: FrontMesh) -> Result<(), InvalidColumns> {
    let updates = h.splits.len();
    let most_needs = MOST_NEEDS * (updates + h.triangles.len());
    let mut dependents = Dependents { heads: vec![NONE; updates], entries: vec![], free: NONE, count: 0 };
    let (mut cells, mut ring, mut others, mut makers) = (vec![], vec![], vec![], vec![]);
    let mut below: Vec<Footprint> = vec![];
    for m in (0..updates as u32).rev() {
        let id = UpdateId(m);
        let invalid = |reason| InvalidColumns::Update { update: m, reason };
        let [u, v] = h.splits[id.ix()].children.map(|key| front.slot(key).expect("all later ones are undone"));
        let points = &front.buffers.positions;
        let own = h.added(id);
        let corners = |t: u32| front.buffers.triangles[t as usize].map(|slot| points[slot as usize]);
        let p = points[u as usize];
        let q = points[v as usize];
        cells.clear();
        others.clear();
        for t in front.star(u).chain(front.star(v)) {
            if own.contains(&front.number(t.corner)) {
                others.extend([t.after, t.before].into_iter().filter(|&x| x != u && x != v));
            }
        }
        cells.extend(front.star(u).map(|t| corners(t.corner >> 2)));
        // Those that have both are in both stars.
        cells.extend(front.star(v).filter(|t| t.after != u && t.before != u).map(|t| corners(t.corner >> 2)));
        let s = match h.origin(id) {
            Origin::Base(v) => h.base.positions[v as usize],
            Origin::Child(parent, which) => h.place(parent, which),
        };
        let cost = step_cost(s, cells.iter().copied());

        front.coarsen(h, id);
        front.buffers.clear_changes();
        let points = &front.buffers.positions;
        cells
            .extend(front.star(u).map(|t| front.buffers.triangles[t.corner as usize >> 2].map(|x| points[x as usize])));
        // Nodes without triangles have places too.
        cells.extend([[s, p, p], [s, q, q]]);
        ring.clear();
        ring.extend(front.star(u).flat_map(|t| [t.after, t.before]));
        ring.sort_unstable();
        ring.dedup();

        others.sort_unstable();
        others.dedup();
        others.retain(|x| ring.binary_search(x).is_err());
        for &w in &others {
            h.hidden.extend(front.maker(w).map(|earlier| [id, earlier]));
            h.hidden.extend(h.splitter(front.key(w)).map(|later| [later, id]));
        }
        makers.clear();
        let parent = h.parent(id);
        let younger = ring.iter().filter_map(|&x| front.maker(x)).filter(|&maker| Some(maker) > parent);
        makers.extend(younger.chain(others.iter().filter_map(|&w| front.maker(w))).chain(parent));
        makers.sort_unstable();
        makers.dedup();
        for &n in &makers {
            if h.error(n) < h.error(id) {
                return Err(invalid("its error is larger than that of an update that it needs"));
            }
            dependents.push(n, m);
        }
        if dependents.count + h.hidden.len() > most_needs {
            return Err(invalid("it and later ones need too many others"));
        }

        below.clear();
        let mut worst = cost;
        dependents.take(m, |n| {
            below.push(h.footprint(n));
            worst = worst.max(h.costs[n.ix()]);
        });
        h.costs[id.ix()] = worst;
        h.footprints[id.ix()] = h.frame.nest(h.error(id), &Cells::of(cells.iter().copied()), below.iter().copied());
    }
    h.hidden.sort_unstable();
    h.hidden.dedup();
    h.hidden.shrink_to_fit();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use meshfront_mesh::{TriangleMesh, VertexId};

    /// Three leaves and a triangle; a and b merge first, then c.
    fn one_triangle() -> Columns {
        let p = |x: f32| Vec3::new(x, x * x, 0.0);
        Columns {
            base: TriangleMesh { positions: vec![p(0.5)], ..TriangleMesh::default() },
            triangles: vec![[VertexId(3), VertexId(4), VertexId(2)]],
            added: vec![0, 1],
            vertex: vec![VertexId(0), VertexId(1)],
            positions: vec![[p(0.5), p(2.0)], [p(0.0), p(1.0)]],
            errors: vec![2.0, 1.0],
            ..Columns::default()
        }
    }

    #[test]
    fn columns_come_back() {
        let columns = one_triangle();
        let h = VertexPair::new(columns.clone()).expect("a hierarchy");
        assert_eq!(h.columns(), columns);
        assert_eq!(h.cells_added(UpdateId(1)), 1);
    }

    #[test]
    fn what_is_no_forest_is_refused() {
        let refused = |change: &dyn Fn(&mut Columns)| {
            let mut columns = one_triangle();
            change(&mut columns);
            VertexPair::new(columns).expect_err("damaged").to_string()
        };
        assert!(refused(&|c| c.vertex[1] = VertexId(0)).contains("split already"));
        assert!(refused(&|c| c.vertex[0] = VertexId(1)).contains("not there yet"));
        assert!(refused(&|c| c.triangles[0][0] = VertexId(1)).contains("no leaf"));
        assert!(refused(&|c| c.triangles[0][0] = VertexId(99)).contains("no leaf"));
        assert!(refused(&|c| c.triangles[0][0] = VertexId(4)).contains("a corner each"));
        assert!(refused(&|c| c.added = vec![1, 0]).contains("update 0"));
        assert!(refused(&|c| c.added = vec![u32::MAX, u32::MAX]).contains("triangles"));
        assert!(refused(&|c| c.errors = vec![1.0, 2.0]).contains("larger"));
        assert!(refused(&|c| c.base.triangles.push([0, 0, 0].map(VertexId))).contains("triangles"));
    }

    #[test]
    fn stars_have_a_limit() {
        // Fans that share their hub, which splits; the new vertex has no triangle.
        let fan = |n: u32| {
            let triangles: Vec<_> = (0..n).map(|i| [0, 1 + i, 2 + i].map(VertexId)).collect();
            let positions = (0..n + 2).map(|i| Vec3::new(i as f32, (i % 7) as f32, 0.0)).collect();
            let hub = VertexId(n + 2);
            let leaves = triangles.iter().map(|t: &[VertexId; 3]| [hub, t[1], t[2]]).collect();
            Columns {
                base: TriangleMesh { positions, triangles, ..TriangleMesh::default() },
                triangles: leaves,
                added: vec![0],
                vertex: vec![VertexId(0)],
                positions: vec![[Vec3::ZERO, Vec3::ONE]],
                errors: vec![1.0],
                ..Columns::default()
            }
        };
        assert!(VertexPair::new(fan(Columns::MAX_STAR as u32)).is_ok());
        let error = VertexPair::new(fan(Columns::MAX_STAR as u32 + 1)).expect_err("too large a star");
        assert!(error.to_string().contains("too many triangles"), "{error}");
    }

    /// A square of two triangles a b c and a c d. b and d go into c one after the other, so that nothing is left to
    /// see between a and c.
    #[test]
    fn neighbours_without_triangles_are_remembered() {
        let p = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        // Roots: a (0) and the rest (1). Update 0 takes d (3) out of the rest, update 1 then b (5) out of c (4); update 2
        // splits a into the a of the triangles (6) and a vertex without any.
        let columns = Columns {
            base: TriangleMesh { positions: vec![p(0.0, 0.0), p(1.0, 1.0)], ..TriangleMesh::default() },
            triangles: vec![[6, 4, 3].map(VertexId), [6, 5, 4].map(VertexId)],
            added: vec![1, 1, 0],
            vertex: vec![VertexId(1), VertexId(2), VertexId(0)],
            positions: vec![[p(1.0, 1.0), p(0.0, 1.0)], [p(1.0, 1.0), p(1.0, 0.0)], [p(0.0, 0.0), p(-1.0, -1.0)]],
            errors: vec![3.0, 2.0, 1.0],
            ..Columns::default()
        };
        let h = VertexPair::new(columns).expect("a hierarchy");
        assert_eq!(h.hidden_needs(), [[UpdateId(2), UpdateId(0)]]);
        let mut needs = vec![];
        h.needs(&h.base(), UpdateId(2), |n| needs.push(n));
        assert_eq!(needs, [UpdateId(0)]);
    }

    /// A triangle a b c, and vertices e and f without any. b and c merge, then a and e, then what was b and c with f: from
    /// the first merge on nothing is seen of the triangle.
    #[test]
    fn third_corners_are_there_first() {
        let p = |x: f32| Vec3::new(x, x * x, 0.0);
        let columns = Columns {
            base: TriangleMesh { positions: vec![p(0.0), p(1.0)], ..TriangleMesh::default() },
            triangles: vec![[4, 6, 7].map(VertexId)],
            added: vec![0, 0, 1],
            vertex: vec![VertexId(1), VertexId(0), VertexId(2)],
            positions: vec![[p(1.0), p(2.0)], [p(0.0), p(-1.0)], [p(1.5), p(0.5)]],
            errors: vec![3.0, 2.0, 1.0],
            ..Columns::default()
        };
        let h = VertexPair::new(columns).expect("a hierarchy");
        let [split_f, split_e, split_bc] = [0, 1, 2].map(UpdateId);
        assert_eq!(h.hidden_needs(), [[split_bc, split_e]]);
        let mut mesh = h.base();
        h.refine(&mut mesh, split_f);
        let mut needs = vec![];
        h.needs(&mesh, split_bc, |n| needs.push(n));
        assert_eq!(needs, [split_e]);
        h.refine(&mut mesh, split_e);
        h.refine(&mut mesh, split_bc);
        assert_eq!(h.cells(&mesh), 1);
        let mut needed_by = vec![];
        h.needed_by(&mesh, split_e, |n| needed_by.push(n));
        assert!(!needed_by.is_empty() && needed_by.iter().all(|&m| m == split_bc));
    }
}
