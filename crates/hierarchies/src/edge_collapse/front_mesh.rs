//! The live mesh of one front: triangle buffers, and for each vertex the list of its triangles.
//!
//! The order of a list by triangle number is what `Columns::sides` speaks of, and it makes `coarsen` the exact inverse of
//! `refine`.

use super::{AddedTriangle, Columns, EdgeCollapse};
use crate::corner_lists::{Corner, CornerLists};
use crate::counts::Counts;
use crate::live::{TriangleBuffers, VertexLook};
use crate::model::LiveMesh;
use crate::slot_table::SlotTable;
use arrayvec::ArrayVec;
use meshfront_mesh::VertexId;
use meshfront_refine::{Around, UpdateId};

/// A front's live mesh: at most 120 bytes per active vertex with the engine's state, where capacity
/// follows size.
#[derive(Clone, Debug)]
pub struct FrontMesh {
    /// What is drawn.
    pub buffers: TriangleBuffers,
    lists: CornerLists<VertexId>,
    /// Slot of a live vertex, by its id.
    slots: SlotTable,
    counts: Counts,
}

/// The star of a vertex, sorted by triangle number.
pub(super) type Star = ArrayVec<StarCorner, { Columns::MAX_STAR }>;

/// A triangle of a star.
#[derive(Clone, Copy)]
pub(super) struct StarCorner {
    /// Vertex slot: the one after the centre in the triangle's orientation.
    pub after: u32,
    /// And the one before.
    pub before: u32,
}

/// A triangle that a split adds: (u, w, v), or (v, w, u) where `flipped`; `w` is a vertex slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Added {
    pub w: u32,
    pub flipped: bool,
}

/// The most triangles that one split may add.
pub(super) const MAX_ADDED: usize = Columns::MAX_STAR;

pub(super) type AddedList = ArrayVec<Added, MAX_ADDED>;

/// Gaps that the sides of a star leave: where the triangle that ends at a ring vertex and the one that starts there
/// go to different children, the gap between them is a triangle. Indices in the star of the triangles that end
/// at a gap; `None` where there are more than two: then the split has to list what it adds.
pub(super) fn gaps(star: &Star, sides: u32) -> Option<ArrayVec<u8, 2>> {
    let mut gaps = ArrayVec::new();
    let all = ((1u64 << star.len()) - 1) as u32;
    for (i, t) in star.iter().enumerate() {
        let w = t.before;
        // Only triangles that go to the other child.
        let mut others = if sides >> i & 1 == 1 { !sides & all } else { sides & all };
        while others != 0 {
            let j = others.trailing_zeros() as usize;
            others &= others - 1;
            if star[j].after == w {
                gaps.try_push(i as u8).ok()?;
            }
        }
    }
    Some(gaps)
}

/// The triangle that closes a gap.
#[inline]
pub(super) fn gap_triangle(star: &Star, sides: u32, gap: u8) -> Added {
    Added { w: star[gap as usize].before, flipped: sides >> gap & 1 == 1 }
}

impl FrontMesh {
    pub(super) fn base(h: &EdgeCollapse) -> FrontMesh {
        let mut front = FrontMesh {
            buffers: TriangleBuffers::for_at_most(h.most),
            lists: CornerLists::new(),
            slots: SlotTable::new(h.base_vertices() as usize + 2 * h.splits.len()),
            counts: Counts::new(&h.needed),
        };
        front.add_base(h);
        front
    }
    pub(super) fn reset(&mut self, h: &EdgeCollapse) {
        self.buffers.clear();
        self.lists.clear();
        self.slots.reset();
        self.counts.reset(&h.needed);
        self.add_base(h);
    }
    fn add_base(&mut self, h: &EdgeCollapse) {
        for v in 0..h.base_vertices() {
            self.new_vertex(VertexId(v), &h.vertex_look(VertexId(v), 0));
        }
        for t in &h.base.triangles {
            let slot = self.new_triangle(self.lists.triangle_slots() as u32, t.map(|v| v.0));
            for k in 0..3 {
                self.lists.insert(t[k].0, slot << 2 | k as u32);
            }
        }
    }

    /// Number and corners of each live triangle, in slot order: the same triangle has the same number in all fronts.
    pub fn numbered_triangles(&self) -> impl Iterator<Item = (u32, [VertexId; 3])> {
        let live = self.buffers.triangles.iter().enumerate().filter(|(_, t)| t[0] != t[1]);
        live.map(|(slot, t)| (self.lists.number(slot as u32), t.map(|slot| self.id(slot))))
    }

    #[inline]
    pub(super) fn slot(&self, v: VertexId) -> Option<u32> {
        self.slots.get(v.ix())
    }
    pub(super) fn id(&self, slot: u32) -> VertexId {
        self.lists.who(slot)
    }

    /// The star of a vertex slot; `None` where it is larger than a split may have.
    pub(super) fn star(&self, slot: u32) -> Option<Star> {
        let mut star = Star::new();
        for corner in self.lists.around(slot) {
            let [after, before] = [false, true].map(|before| self.neighbour(corner, before));
            star.try_push(StarCorner { after, before }).ok()?;
        }
        star.reverse();
        Some(star)
    }

    /// The corners of a star, in order, whose triangles nobody has looked at yet.
    #[inline]
    fn star_corners(&self, slot: u32, corners: &mut ArrayVec<Corner, { Columns::MAX_STAR }>) {
        corners.extend(self.lists.around(slot));
        corners.reverse();
    }
    /// The vertex slot before a corner in its triangle's orientation, or after it.
    #[inline]
    fn neighbour(&self, corner: Corner, before: bool) -> u32 {
        let k = corner as usize & 3;
        let other = if before { [2, 0, 1][k] } else { [1, 2, 0][k] };
        self.buffers.triangles[corner as usize >> 2][other]
    }

    #[inline]
    pub(super) fn refine(&mut self, h: &EdgeCollapse, m: UpdateId, mut around: impl FnMut(Around)) {
        let split = &h.splits[m.ix()];
        let slot_u = self.slot(split.vertex).expect("the engine refines only what is legal");
        let mut star = ArrayVec::new();
        self.star_corners(slot_u, &mut star);
        // Half of the star keeps its triangles as they are: only those at a gap and those that go to v are read.
        let explicit = if split.sides & Columns::EXPLICIT != 0 { h.explicit_index(m) } else { None };
        let gap_triangle =
            |&gap: &u8| Added { w: self.neighbour(star[gap as usize], true), flipped: split.sides >> gap & 1 == 1 };
        let listed =
            |a: &AddedTriangle| Added { w: self.neighbour(star[a.star as usize], a.before), flipped: a.flipped };
        let added: AddedList = match explicit {
            None => split.gaps[..split.added as usize].iter().map(gap_triangle).collect(),
            Some(e) => h.explicit[e].added.iter().map(listed).collect(),
        };

        let (u, v) = (h.child(m, 0), h.child(m, 1));
        let level = split.level.saturating_add(1);
        self.slots.clear(split.vertex.ix());
        self.settle(slot_u, u);
        self.buffers.set_vertex(slot_u, &h.vertex_look(u, level));
        let slot_v = self.new_vertex(v, &h.vertex_look(v, level));

        // The star's list becomes two; both stay in order.
        let (mut end_u, mut end_v) = (self.lists.restart(slot_u), self.lists.restart(slot_v));
        for (i, &corner) in star.iter().enumerate().rev() {
            if split.sides >> i & 1 == 0 {
                self.lists.link(slot_u, &mut end_u, corner);
            } else {
                self.buffers.set_corner(corner >> 2, corner as usize & 3, slot_v);
                self.lists.link(slot_v, &mut end_v, corner);
            }
        }
        self.lists.terminate(end_u);
        self.lists.terminate(end_v);

        for (j, a) in added.iter().enumerate() {
            let corners = if a.flipped { [slot_v, a.w, slot_u] } else { [slot_u, a.w, slot_v] };
            let slot = self.new_triangle(h.added_number(m, explicit, j), corners);
            for k in 0..3 {
                self.lists.insert(corners[k], slot << 2 | k as u32);
            }
        }

        let (needs, children) = h.neighbours_of(m);
        for &n in needs {
            self.counts.hold(n);
            around(Around::Closed(n));
        }
        for &child in children {
            if self.counts.meet(child) {
                around(Around::Opened(child));
            }
        }
    }

    #[inline]
    pub(super) fn coarsen(&mut self, h: &EdgeCollapse, m: UpdateId, mut around: impl FnMut(Around)) {
        let split = &h.splits[m.ix()];
        let legal = "the engine coarsens only what is legal";
        let slot_u = self.slot(h.child(m, 0)).expect(legal);
        let slot_v = self.slot(h.child(m, 1)).expect(legal);

        // The triangles on the edge go, last added first, so that free slots come back in the order they were taken. They
        // are told by their numbers, which are among the highest around u: most lists are left at once.
        let mut gone = ArrayVec::<u32, MAX_ADDED>::new();
        let explicit = if split.sides & Columns::EXPLICIT != 0 { h.explicit_index(m) } else { None };
        let is_added = |number: u32| match explicit {
            None => number.wrapping_sub(h.added_number(m, None, 0)) < 2,
            Some(_) => (0..split.added as usize).any(|j| h.added_number(m, explicit, j) == number),
        };
        for corner in self.lists.around(slot_u) {
            if gone.len() == split.added as usize {
                break;
            }
            if is_added(self.lists.number_of(corner)) {
                gone.push(corner >> 2);
            }
        }
        for &t in gone.iter().rev() {
            for k in 0..3u32 {
                self.lists.unlink(self.buffers.triangles[t as usize][k as usize], t << 2 | k);
            }
            self.lists.remove_triangle(t);
            self.buffers.remove_triangle(t);
        }

        let FrontMesh { lists, buffers, .. } = self;
        lists.merge(slot_u, slot_v, |corner| buffers.set_corner(corner >> 2, corner as usize & 3, slot_u));

        self.slots.clear(h.child(m, 1).ix());
        self.lists.set_vertex(slot_v, VertexId(0), self.buffers.most().vertices);
        self.buffers.remove_vertex(slot_v);
        self.slots.clear(h.child(m, 0).ix());
        self.settle(slot_u, split.vertex);
        self.buffers.set_vertex(slot_u, &h.vertex_look(split.vertex, split.level));

        let (needs, children) = h.neighbours_of(m);
        for &child in children {
            self.counts.miss(child);
            around(Around::Closed(child));
        }
        for &n in needs {
            if self.counts.free(n) {
                around(Around::Opened(n));
            }
        }
    }

    // Slots.

    fn new_vertex(&mut self, id: VertexId, look: &VertexLook) -> u32 {
        let slot = self.buffers.add_vertex(look);
        self.lists.set_vertex(slot, id, self.buffers.most().vertices);
        self.slots.set(id.ix(), slot);
        slot
    }
    /// From here on a vertex lives in a slot, whose list of corners stays.
    #[inline]
    fn settle(&mut self, slot: u32, id: VertexId) {
        self.slots.set(id.ix(), slot);
        *self.lists.who_mut(slot) = id;
    }
    fn new_triangle(&mut self, number: u32, corners: [u32; 3]) -> u32 {
        let slot = self.buffers.add_triangle(corners);
        self.lists.set_triangle(slot, number, self.buffers.most().triangles);
        slot
    }
}

impl LiveMesh for FrontMesh {
    fn buffers(&self) -> &TriangleBuffers {
        &self.buffers
    }
    fn buffers_mut(&mut self) -> &mut TriangleBuffers {
        &mut self.buffers
    }
    fn memory_bytes(&self) -> usize {
        self.buffers.memory_bytes() + self.lists.memory_bytes() + self.slots.memory_bytes() + self.counts.memory_bytes()
    }
}
