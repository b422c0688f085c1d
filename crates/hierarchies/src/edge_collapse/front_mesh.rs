//! The live mesh of one front: triangle buffers, and for each vertex the list of its triangles.
//!
//! A vertex's list is sorted by triangle number, whatever the order of updates that led here. The order is
//! what `Columns::sides` speaks of, and it makes `coarsen` the exact inverse of `refine`. Highest numbers come first:
//! they are the latest, so that what comes and goes does so near the head.

use super::{AddedTriangle, Columns, EdgeCollapse};
use crate::live::{TriangleBuffers, VertexLook, put};
use crate::model::LiveMesh;
use crate::slot_table::SlotTable;
use arrayvec::ArrayVec;
use meshfront_mesh::VertexId;
use meshfront_refine::UpdateId;

/// End of a list.
const NONE: u32 = u32::MAX;

/// One corner of a live triangle: `4 * triangle slot + corner 0..3`.
type Corner = u32;

/// A front's live mesh: at most 120 bytes per active vertex with the engine's state, where capacity
/// follows size.
#[derive(Clone, Debug)]
pub struct FrontMesh {
    /// What is drawn.
    pub buffers: TriangleBuffers,
    /// Per vertex slot.
    vertices: Vec<VertexNode>,
    /// Per triangle slot.
    links: Vec<Links>,
    /// Slot of a live vertex, by its id.
    slots: SlotTable,
}

#[derive(Clone, Copy, Debug)]
struct VertexNode {
    /// Who lives there.
    id: VertexId,
    /// Head of its list of corners.
    first: Corner,
}

#[derive(Clone, Copy, Debug)]
struct Links {
    /// Per corner: next in that corner's vertex's list.
    next: [Corner; 3],
    /// The triangle's number.
    number: u32,
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
            vertices: vec![],
            links: vec![],
            slots: SlotTable::new(h.base_vertices() as usize + 2 * h.splits.len()),
        };
        front.add_base(h);
        front
    }
    pub(super) fn reset(&mut self, h: &EdgeCollapse) {
        self.buffers.clear();
        self.vertices.clear();
        self.links.clear();
        self.slots.reset();
        self.add_base(h);
    }
    fn add_base(&mut self, h: &EdgeCollapse) {
        for v in 0..h.base_vertices() {
            self.new_vertex(VertexId(v), &h.vertex_look(VertexId(v), 0));
        }
        for t in &h.base.triangles {
            let slot = self.new_triangle(self.links.len() as u32, t.map(|v| v.0));
            for k in 0..3 {
                self.insert_sorted(t[k].0, slot << 2 | k as u32);
            }
        }
    }

    /// Number and corners of each live triangle, in slot order: the same triangle has the same number in all fronts.
    pub fn numbered_triangles(&self) -> impl Iterator<Item = (u32, [VertexId; 3])> {
        let live = self.buffers.triangles.iter().zip(&self.links).filter(|(t, _)| t[0] != t[1]);
        live.map(|(t, links)| (links.number, t.map(|slot| self.id(slot))))
    }

    #[inline]
    pub(super) fn slot(&self, v: VertexId) -> Option<u32> {
        self.slots.get(v.ix())
    }
    pub(super) fn id(&self, slot: u32) -> VertexId {
        self.vertices[slot as usize].id
    }

    /// The star of a vertex slot; `None` where it is larger than a split may have.
    pub(super) fn star(&self, slot: u32) -> Option<Star> {
        let mut star = Star::new();
        let mut corner = self.vertices[slot as usize].first;
        while corner != NONE {
            let (t, k) = (corner as usize >> 2, corner as usize & 3);
            let triangle = &self.buffers.triangles[t];
            let after = triangle[if k == 2 { 0 } else { k + 1 }];
            let before = triangle[if k == 0 { 2 } else { k - 1 }];
            star.try_push(StarCorner { after, before }).ok()?;
            corner = self.links[t].next[k];
        }
        star.reverse();
        Some(star)
    }

    /// The corners of a star, in order, whose triangles nobody has looked at yet.
    #[inline]
    fn star_corners(&self, slot: u32, corners: &mut ArrayVec<Corner, { Columns::MAX_STAR }>) {
        let mut corner = self.vertices[slot as usize].first;
        while corner != NONE {
            corners.push(corner);
            corner = self.links[corner as usize >> 2].next[corner as usize & 3];
        }
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
    pub(super) fn refine(&mut self, h: &EdgeCollapse, m: UpdateId) {
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
        let (mut end_u, mut end_v) = (NONE, NONE);
        self.vertices[slot_u as usize].first = NONE;
        for (i, &corner) in star.iter().enumerate().rev() {
            if split.sides >> i & 1 == 0 {
                self.link(slot_u, &mut end_u, corner);
            } else {
                self.set_corner(corner, slot_v);
                self.link(slot_v, &mut end_v, corner);
            }
        }
        self.terminate(end_u);
        self.terminate(end_v);

        for (j, a) in added.iter().enumerate() {
            let corners = if a.flipped { [slot_v, a.w, slot_u] } else { [slot_u, a.w, slot_v] };
            let slot = self.new_triangle(h.added_number(m, explicit, j), corners);
            for k in 0..3 {
                self.insert_sorted(corners[k], slot << 2 | k as u32);
            }
        }
    }

    pub(super) fn coarsen(&mut self, h: &EdgeCollapse, m: UpdateId) {
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
        let mut corner = self.vertices[slot_u as usize].first;
        while gone.len() < split.added as usize {
            let links = &self.links[corner as usize >> 2];
            if is_added(links.number) {
                gone.push(corner >> 2);
            }
            corner = links.next[corner as usize & 3];
        }
        for &t in gone.iter().rev() {
            for k in 0..3u32 {
                self.unlink(self.buffers.triangles[t as usize][k as usize], t << 2 | k);
            }
            self.links[t as usize] = Links { next: [NONE; 3], number: 0 };
            self.buffers.remove_triangle(t);
        }

        // Two lists become one.
        let (mut a, mut b) = (self.vertices[slot_u as usize].first, self.vertices[slot_v as usize].first);
        let mut end = NONE;
        self.vertices[slot_u as usize].first = NONE;
        while a != NONE || b != NONE {
            let from_v = a == NONE || (b != NONE && self.number_of(b) > self.number_of(a));
            let from = if from_v { &mut b } else { &mut a };
            let corner = *from;
            *from = self.links[corner as usize >> 2].next[corner as usize & 3];
            if from_v {
                self.set_corner(corner, slot_u);
            }
            self.link(slot_u, &mut end, corner);
        }
        self.terminate(end);

        self.slots.clear(h.child(m, 1).ix());
        self.vertices[slot_v as usize] = VertexNode { id: VertexId(0), first: NONE };
        self.buffers.remove_vertex(slot_v);
        self.slots.clear(h.child(m, 0).ix());
        self.settle(slot_u, split.vertex);
        self.buffers.set_vertex(slot_u, &h.vertex_look(split.vertex, split.level));
    }

    fn number_of(&self, corner: Corner) -> u32 {
        self.links[corner as usize >> 2].number
    }

    // Lists. `link` appends after `end` without writing the terminator; `terminate` writes it.

    #[inline]
    fn link(&mut self, slot: u32, end: &mut Corner, corner: Corner) {
        if *end == NONE {
            self.vertices[slot as usize].first = corner;
        } else {
            self.links[*end as usize >> 2].next[*end as usize & 3] = corner;
        }
        *end = corner;
    }
    #[inline]
    fn terminate(&mut self, end: Corner) {
        if end != NONE {
            self.links[end as usize >> 2].next[end as usize & 3] = NONE;
        }
    }
    fn insert_sorted(&mut self, slot: u32, corner: Corner) {
        let number = self.number_of(corner);
        let mut previous = NONE;
        let mut at = self.vertices[slot as usize].first;
        while at != NONE && self.number_of(at) > number {
            previous = at;
            at = self.links[at as usize >> 2].next[at as usize & 3];
        }
        self.links[corner as usize >> 2].next[corner as usize & 3] = at;
        if previous == NONE {
            self.vertices[slot as usize].first = corner;
        } else {
            self.links[previous as usize >> 2].next[previous as usize & 3] = corner;
        }
    }
    fn unlink(&mut self, slot: u32, corner: Corner) {
        let after = self.links[corner as usize >> 2].next[corner as usize & 3];
        let mut at = self.vertices[slot as usize].first;
        if at == corner {
            self.vertices[slot as usize].first = after;
            return;
        }
        loop {
            let next = &mut self.links[at as usize >> 2].next[at as usize & 3];
            if *next == corner {
                *next = after;
                return;
            }
            at = *next;
        }
    }

    // Slots.

    fn new_vertex(&mut self, id: VertexId, look: &VertexLook) -> u32 {
        let slot = self.buffers.add_vertex(look);
        put(&mut self.vertices, slot, VertexNode { id, first: NONE }, self.buffers.most().vertices);
        self.slots.set(id.ix(), slot);
        slot
    }
    /// From here on a vertex lives in a slot, whose list of corners stays.
    #[inline]
    fn settle(&mut self, slot: u32, id: VertexId) {
        self.slots.set(id.ix(), slot);
        self.vertices[slot as usize].id = id;
    }
    #[inline]
    fn set_corner(&mut self, corner: Corner, vertex: u32) {
        self.buffers.triangles[corner as usize >> 2][corner as usize & 3] = vertex;
        self.buffers.changes.triangles.push(corner >> 2);
    }
    fn new_triangle(&mut self, number: u32, corners: [u32; 3]) -> u32 {
        let slot = self.buffers.add_triangle(corners);
        put(&mut self.links, slot, Links { next: [NONE; 3], number }, self.buffers.most().triangles);
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
        fn of<T>(v: &Vec<T>) -> usize {
            v.capacity() * size_of::<T>()
        }
        self.buffers.memory_bytes() + of(&self.vertices) + of(&self.links) + self.slots.memory_bytes()
    }
}
