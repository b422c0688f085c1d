//! Rules of dependency over one forest: which updates must come before which. The literature has five for edge collapses, and
//! each is right by its own standard.
//!
//! | rule | an update may be applied when | a front's cells |
//! | --- | --- | --- |
//! | [`Stars`] | those that made its star are (`defloriani2002`) | those of the sequence of merges |
//! | [`Neighbours`] | those who were neighbours at the merge are there (`xia1997`) | the same |
//! | [`Implicit`] | all neighbours split later (`elsana1999`) | the same |
//! | [`Faces`] | the faces beside its new faces are there (`hoppe1997`) | some of its own |
//! | [`Free`] | its node is there (`kim2001`) | any that the forest has |
//!
//! The first three let the same fronts through, and differ in memory and time. Kim and Lee find the ends of an edge that comes back, whatever was
//! split around it, in the dual of the mesh: each vertex of the source has a piece of the dual, a node the union of those below
//! it, and two nodes are neighbours where their pieces touch. Names of triangles by leaves say the same: a corner is the active
//! node that has the leaf.

use super::{Key, VertexPair};
use crate::footprint::{Cells, PackedFootprint};
use crate::lists::UpdateLists;
use crate::vertex_pair::FrontMesh;
use meshfront_refine::{Footprint, MultiTessellation, UpdateId};
use std::collections::HashSet;

/// Which updates must come before which. See [`MultiTessellation`] for what the methods do.
pub trait Rule {
    /// See [`MultiTessellation::READS_MESH`].
    const READS_MESH: bool;
    /// Whether an update replaces the same cells in all fronts: those of the sequence of merges.
    const KEEPS_CELLS: bool;

    /// Memory beyond the forest's, bytes.
    fn bytes(&self) -> usize;
    /// See [`MultiTessellation::roots`].
    fn roots(&self, h: &VertexPair, visit: impl FnMut(UpdateId)) {
        MultiTessellation::roots(h, visit)
    }
    /// See [`MultiTessellation::children`].
    fn children(&self, h: &VertexPair, m: UpdateId, visit: impl FnMut(UpdateId)) {
        MultiTessellation::children(h, m, visit)
    }
    /// See [`MultiTessellation::needs`].
    fn needs(&self, h: &VertexPair, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId));
    /// See [`MultiTessellation::needed_by`].
    fn needed_by(&self, h: &VertexPair, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId));
}

/// The model's own.
#[derive(Clone, Copy, Debug)]
pub struct Implicit {
    hidden: usize,
}

impl Implicit {
    /// Nothing but what the hierarchy has.
    pub fn new(h: &VertexPair) -> Implicit {
        Implicit { hidden: h.hidden.len() }
    }
}

impl Rule for Implicit {
    const READS_MESH: bool = true;
    const KEEPS_CELLS: bool = true;

    fn bytes(&self) -> usize {
        self.hidden * size_of::<[UpdateId; 2]>()
    }
    #[inline]
    fn needs(&self, h: &VertexPair, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        h.needs(mesh, m, visit)
    }
    #[inline]
    fn needed_by(&self, h: &VertexPair, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        h.needed_by(mesh, m, visit)
    }
}

/// Who was a neighbour at the merge, listed as nodes; whether they are there is read off the mesh.
#[derive(Clone, Debug)]
pub struct Neighbours {
    /// One more than there are updates: lists end where the next one's begin.
    offsets: Vec<u32>,
    /// Numbered as in [`Columns`](super::Columns): those of the base mesh, then two for each update.
    nodes: Vec<u32>,
}

impl Rule for Neighbours {
    const READS_MESH: bool = true;
    const KEEPS_CELLS: bool = true;

    fn bytes(&self) -> usize {
        size_of_val(&self.offsets[..]) + size_of_val(&self.nodes[..])
    }
    #[inline]
    fn needs(&self, h: &VertexPair, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        if mesh.slot(m.0).is_none() {
            return h.parent(m).into_iter().for_each(visit);
        }
        let ring = &self.nodes[self.offsets[m.ix()] as usize..self.offsets[m.ix() + 1] as usize];
        // Nodes of the base mesh are there, or would have needed this update.
        let made = ring.iter().filter_map(|node| node.checked_sub(h.roots.len() as u32));
        let absent = made.filter(|k| mesh.slot(h.splits[*k as usize / 2].children[*k as usize % 2]).is_none());
        absent.map(|k| UpdateId(k / 2)).for_each(visit);
    }
    #[inline]
    fn needed_by(&self, h: &VertexPair, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        h.needed_by(mesh, m, visit)
    }
}

/// An explicit order that needs all that made the star.
pub type Stars = Listed<true>;
/// An explicit order that needs the faces beside the new ones.
pub type Faces = Listed<false>;

/// An explicit order: lists of needs, and the same the other way round.
#[derive(Clone, Debug)]
pub struct Listed<const KEEPS_CELLS: bool> {
    needs: UpdateLists,
    children: UpdateLists,
    roots: Vec<UpdateId>,
}

impl<const KEEPS_CELLS: bool> Listed<KEEPS_CELLS> {
    fn new(needs: UpdateLists) -> Self {
        let updates = (0..needs.offsets.len() as u32 - 1).map(UpdateId);
        let roots = updates.filter(|m| needs.of(m.ix()).is_empty()).collect();
        Listed { children: needs.reversed(), needs, roots }
    }
}

impl<const KEEPS_CELLS: bool> Rule for Listed<KEEPS_CELLS> {
    const READS_MESH: bool = false;
    const KEEPS_CELLS: bool = KEEPS_CELLS;

    fn bytes(&self) -> usize {
        let of = |lists: &UpdateLists| size_of_val(&lists.offsets[..]) + size_of_val(&lists.items[..]);
        of(&self.needs) + of(&self.children)
    }
    fn roots(&self, _: &VertexPair, visit: impl FnMut(UpdateId)) {
        self.roots.iter().copied().for_each(visit)
    }
    #[inline]
    fn children(&self, _: &VertexPair, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.children.of(m.ix()).iter().copied().for_each(visit)
    }
    #[inline]
    fn needs(&self, _: &VertexPair, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.needs.of(m.ix()).iter().copied().for_each(visit)
    }
    #[inline]
    fn needed_by(&self, h: &VertexPair, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.children(h, m, visit)
    }
}

/// None at all: any cut of the forest.
#[derive(Clone, Copy, Debug)]
pub struct Free;

impl Rule for Free {
    const READS_MESH: bool = false;
    const KEEPS_CELLS: bool = false;

    fn bytes(&self) -> usize {
        0
    }
    #[inline]
    fn needs(&self, h: &VertexPair, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        h.parent(m).into_iter().for_each(visit)
    }
    #[inline]
    fn needed_by(&self, h: &VertexPair, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.children(h, m, visit)
    }
}

/// What was there as the source was merged: the rules are made of it. Some 200 bytes per update.
pub struct Sequence {
    /// What made the star of each update, and the corners of the triangles that it adds: the whole of M⁻.
    stars: UpdateLists,
    /// What made the node, and the faces beside the new ones.
    faces: UpdateLists,
    neighbours: Neighbours,
    /// M⁻ and M⁺ of each update.
    own: Vec<Cells>,
    /// All cells that there ever were, by the keys of their corners, the least first.
    cells: HashSet<[Key; 3]>,
}

/// The least first, orientation kept.
fn turned([a, b, c]: [Key; 3]) -> [Key; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

impl Sequence {
    /// Applies all updates in order, and looks around.
    pub fn of(h: &VertexPair) -> Sequence {
        let updates = h.splits.len();
        let mut stars = UpdateLists::with_capacity(updates);
        let mut faces = UpdateLists::with_capacity(updates);
        let mut neighbours = Neighbours { offsets: vec![0], nodes: vec![] };
        let mut own = Vec::with_capacity(updates);
        let mut front = FrontMesh::base(h);
        let mut cells: HashSet<_> = front.numbered_triangles().map(|(_, t)| turned(t)).collect();
        let maker = |number: u32| {
            let later = h.splits.partition_point(|split| split.first <= number);
            (number as usize >= h.base.triangles.len()).then(|| UpdateId(later as u32 - 1))
        };
        let (mut ring, mut beside, mut around) = (vec![], vec![], vec![]);
        for m in (0..updates as u32).map(UpdateId) {
            let corners = |front: &FrontMesh, corner: u32| {
                let t = front.buffers.triangles[corner as usize >> 2];
                (t.map(|slot| front.buffers.positions[slot as usize]), turned(t.map(|slot| front.key(slot))))
            };
            let s = front.slot(m.0).expect("applied in order");
            ring.clear();
            around.clear();
            let point = front.buffers.positions[s as usize];
            for t in front.star(s) {
                ring.extend([t.after, t.before]);
                around.push(corners(&front, t.corner).0);
            }
            front.refine(h, m);
            front.buffers.clear_changes();
            let [u, v] = h.splits[m.ix()].children.map(|key| front.slot(key).expect("just made"));
            beside.clear();
            beside.extend(h.parent(m));
            for t in front.star(u).chain(front.star(v)) {
                let (points, keys) = corners(&front, t.corner);
                around.push(points);
                cells.insert(keys);
                if !h.added(m).contains(&front.number(t.corner)) {
                    continue;
                }
                let others = [t.after, t.before].into_iter().filter(|&x| x != u && x != v);
                for w in others {
                    ring.push(w);
                    // The faces on the edges from w to u and to v.
                    let on_edge = front.star(w).filter(|f| [u, v].iter().any(|x| f.after == *x || f.before == *x));
                    beside.extend(on_edge.filter_map(|f| maker(front.number(f.corner))).filter(|&n| n != m));
                }
            }
            around.extend([u, v].map(|slot| [point, point, front.buffers.positions[slot as usize]]));
            own.push(Cells::of(around.iter().copied()));
            ring.sort_unstable();
            ring.dedup();
            let mut makers: Vec<UpdateId> = ring.iter().filter_map(|&x| front.maker(x)).chain(h.parent(m)).collect();
            for needs in [&mut makers, &mut beside] {
                needs.sort_unstable();
                needs.dedup();
            }
            stars.push_reduced(&makers);
            faces.push_reduced(&beside);
            neighbours.nodes.extend(ring.iter().map(|&x| match front.maker(x) {
                None => h.roots.partition_point(|root| root.first_leaf <= front.first_leaf(x)) as u32 - 1,
                Some(maker) => {
                    let which = usize::from(h.splits[maker.ix()].children[1] == front.key(x));
                    (h.roots.len() + 2 * maker.ix() + which) as u32
                }
            }));
            neighbours.offsets.push(neighbours.nodes.len() as u32);
        }
        Sequence { stars, faces, neighbours, own, cells }
    }

    /// The explicit order in which an update needs all that made its star.
    pub fn stars(&self) -> Stars {
        Listed::new(self.stars.clone())
    }
    /// The explicit order in which an update needs what made its node, and the faces beside its new ones: four on a
    /// 2-manifold.
    pub fn faces(&self) -> Faces {
        Listed::new(self.faces.clone())
    }
    /// The neighbours at the merge.
    pub fn neighbours(&self) -> Neighbours {
        self.neighbours.clone()
    }
    /// Whether a cell, by its corners as of [`FrontMesh::numbered_triangles`], is one that the sequence had.
    pub fn has(&self, cell: [u32; 3]) -> bool {
        self.cells.contains(&turned(cell))
    }
    /// What an update alone would ask for, with errors of the updates by themselves: nothing is handed up.
    pub fn own_footprint(&self, h: &VertexPair, errors: &[f32], m: UpdateId) -> Footprint {
        h.frame.unpack(&h.frame.nest(errors[m.ix()], &self.own[m.ix()], std::iter::empty()))
    }
}

/// A hierarchy under a rule, with footprints that nest along the rule's own order.
pub struct Ruled<'a, R> {
    hierarchy: &'a VertexPair,
    rule: R,
    footprints: Vec<PackedFootprint>,
}

impl<'a, R: Rule> Ruled<'a, R> {
    /// `errors`: those of the updates by themselves; they, spheres and cones are handed up along `order`, which must be
    /// the order that the rule keeps.
    pub fn new(h: &'a VertexPair, rule: R, order: &impl Rule, sequence: &Sequence, errors: &[f32]) -> Ruled<'a, R> {
        let mut footprints = vec![PackedFootprint::default(); h.splits.len()];
        let mut below: Vec<Footprint> = vec![];
        for m in (0..h.splits.len()).rev() {
            below.clear();
            let mut error = errors[m];
            order.children(h, UpdateId(m as u32), |child| {
                let f = h.frame.unpack(&footprints[child.ix()]);
                error = error.max(f.error);
                below.push(f);
            });
            footprints[m] = h.frame.nest(error, &sequence.own[m], below.iter().copied());
        }
        Ruled { hierarchy: h, rule, footprints }
    }
    /// The rule.
    pub fn rule(&self) -> &R {
        &self.rule
    }
}

impl<R: Rule> MultiTessellation for Ruled<'_, R> {
    type Mesh = FrontMesh;
    const READS_MESH: bool = R::READS_MESH;

    fn len(&self) -> usize {
        self.hierarchy.len()
    }
    fn base(&self) -> FrontMesh {
        self.hierarchy.base()
    }
    #[inline]
    fn footprint(&self, m: UpdateId) -> Footprint {
        self.hierarchy.frame.unpack(&self.footprints[m.ix()])
    }
    fn roots(&self, visit: impl FnMut(UpdateId)) {
        self.rule.roots(self.hierarchy, visit)
    }
    #[inline]
    fn children(&self, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.rule.children(self.hierarchy, m, visit)
    }
    #[inline]
    fn needs(&self, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.rule.needs(self.hierarchy, mesh, m, visit)
    }
    #[inline]
    fn needed_by(&self, mesh: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.rule.needed_by(self.hierarchy, mesh, m, visit)
    }
    #[inline]
    fn refine(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.refine(self.hierarchy, m)
    }
    #[inline]
    fn coarsen(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.coarsen(self.hierarchy, m)
    }
    fn cells(&self, mesh: &FrontMesh) -> usize {
        self.hierarchy.cells(mesh)
    }
    #[inline]
    fn cells_added(&self, m: UpdateId) -> usize {
        self.hierarchy.cells_added(m)
    }
    fn floor_error(&self) -> f32 {
        self.hierarchy.floor_error
    }
}
