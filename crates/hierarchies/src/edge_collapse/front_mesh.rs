//! The live mesh of one front: triangle buffers, and for each vertex the list of its triangles.
//!
//! A vertex's list is sorted by triangle number, whatever the order of updates that led here. The order is
//! what `Columns::sides` speaks of, and it makes `coarsen` the exact inverse of `refine`.

use super::{Columns, EdgeCollapse, Oct, VertexLook};
use crate::live::TriangleBuffers;
use hashbrown::HashTable;
use meshfront_mesh::{TriangleMesh, VertexId};
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
    /// Per vertex slot: who lives there.
    ids: Vec<VertexId>,
    /// Per vertex slot: head of its list of corners.
    first: Vec<Corner>,
    /// Per triangle slot and corner: next in that corner's vertex's list.
    next: Vec<[Corner; 3]>,
    /// Per triangle slot: the triangle's number.
    numbers: Vec<u32>,
    /// Slot of a live vertex, by its id.
    slots: HashTable<u32>,
    free_vertices: Vec<u32>,
    free_triangles: Vec<u32>,
}

/// The star of a vertex, sorted by triangle number.
pub(super) struct Star {
    pub len: usize,
    pub corner: [Corner; Columns::MAX_STAR],
    /// Vertex slots: the one after the centre in each triangle's orientation, and the one before.
    pub after: [u32; Columns::MAX_STAR],
    pub before: [u32; Columns::MAX_STAR],
}

/// A triangle that a split adds: (u, w, v), or (v, w, u) where `flipped`; `w` is a vertex slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Added {
    pub w: u32,
    pub flipped: bool,
}

/// The most triangles that one split may add.
pub(super) const MAX_ADDED: usize = Columns::MAX_STAR;

#[derive(Clone, Copy)]
pub(super) struct AddedList {
    pub len: usize,
    pub items: [Added; MAX_ADDED],
}

impl AddedList {
    pub fn as_slice(&self) -> &[Added] {
        &self.items[..self.len]
    }
}

/// The triangles that follow from the sides of a star: where the triangle that ends at a ring vertex and the
/// one that starts there go to different children, the gap between them is a triangle.
/// `None` where more than two follow: then the split has to list them.
pub(super) fn added_by_sides(star: &Star, sides: u32) -> Option<AddedList> {
    let mut added = AddedList { len: 0, items: [Added { w: 0, flipped: false }; MAX_ADDED] };
    let all = ((1u64 << star.len) - 1) as u32;
    for i in 0..star.len {
        let w = star.before[i];
        // Only triangles that go to the other child.
        let mut others = if sides >> i & 1 == 1 { !sides & all } else { sides & all };
        while others != 0 {
            let j = others.trailing_zeros() as usize;
            others &= others - 1;
            if star.after[j] == w {
                if added.len == 2 {
                    return None;
                }
                added.items[added.len] = Added { w, flipped: sides >> i & 1 == 1 };
                added.len += 1;
            }
        }
    }
    Some(added)
}

#[inline]
fn hash(id: VertexId) -> u64 {
    // Fibonacci hashing; the table looks at the top seven bits and the low ones.
    let h = (id.0 as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h ^ (h >> 32)
}

impl FrontMesh {
    pub(super) fn base(h: &EdgeCollapse) -> FrontMesh {
        let mesh = &h.base;
        let mut front = FrontMesh {
            buffers: TriangleBuffers::default(),
            ids: vec![],
            first: vec![],
            next: vec![],
            numbers: vec![],
            slots: HashTable::new(),
            free_vertices: vec![],
            free_triangles: vec![],
        };
        for v in 0..mesh.positions.len() as u32 {
            front.new_vertex(VertexId(v), &h.vertex_look(VertexId(v)), 0);
        }
        for t in &mesh.triangles {
            let slot = front.new_triangle(front.numbers.len() as u32, t.map(|v| v.0));
            for k in 0..3 {
                // Numbers ascend, so each list is sorted when new ones go to its end.
                front.append(t[k].0, slot << 2 | k as u32);
            }
        }
        front
    }

    /// Number of live triangles.
    pub fn triangles(&self) -> usize {
        self.numbers.len() - self.free_triangles.len()
    }
    /// Number of live vertices.
    pub fn vertices(&self) -> usize {
        self.ids.len() - self.free_vertices.len()
    }
    /// A compact copy of the live mesh.
    pub fn to_mesh(&self) -> TriangleMesh {
        self.buffers.to_mesh()
    }
    /// Memory held, bytes: capacities, not sizes; without the list of changes, which lives for one frame.
    pub fn memory_bytes(&self) -> usize {
        fn of<T>(v: &Vec<T>) -> usize {
            v.capacity() * size_of::<T>()
        }
        let b = &self.buffers;
        of(&b.positions)
            + of(&b.normals)
            + of(&b.colors)
            + of(&b.levels)
            + of(&b.triangles)
            + of(&self.ids)
            + of(&self.first)
            + of(&self.next)
            + of(&self.numbers)
            + self.slots.allocation_size()
            + of(&self.free_vertices)
            + of(&self.free_triangles)
    }
    /// Number and corners of each live triangle, in slot order: the same triangle has the same number in all fronts.
    pub fn numbered_triangles(&self) -> impl Iterator<Item = (u32, [VertexId; 3])> {
        let live = self.buffers.triangles.iter().zip(&self.numbers).filter(|(t, _)| t[0] != t[1]);
        live.map(|(t, &n)| (n, t.map(|slot| self.ids[slot as usize])))
    }

    #[inline]
    pub(super) fn slot(&self, v: VertexId) -> Option<u32> {
        self.slots.find(hash(v), |&slot| self.ids[slot as usize] == v).copied()
    }
    pub(super) fn id(&self, slot: u32) -> VertexId {
        self.ids[slot as usize]
    }

    /// The star of a vertex slot; `None` where it is larger than a split may have.
    #[inline]
    pub(super) fn star(&self, slot: u32) -> Option<Star> {
        let mut star = Star {
            len: 0,
            corner: [0; Columns::MAX_STAR],
            after: [0; Columns::MAX_STAR],
            before: [0; Columns::MAX_STAR],
        };
        let mut corner = self.first[slot as usize];
        while corner != NONE {
            if star.len == Columns::MAX_STAR {
                return None;
            }
            let (t, k) = (corner as usize >> 2, corner as usize & 3);
            let triangle = &self.buffers.triangles[t];
            star.corner[star.len] = corner;
            star.after[star.len] = triangle[if k == 2 { 0 } else { k + 1 }];
            star.before[star.len] = triangle[if k == 0 { 2 } else { k - 1 }];
            star.len += 1;
            corner = self.next[t][k];
        }
        Some(star)
    }

    /// The triangles that a split adds to a star.
    #[inline]
    pub(super) fn added(&self, h: &EdgeCollapse, m: UpdateId, star: &Star) -> AddedList {
        let sides = h.splits[m.ix()].sides;
        match h.explicit_index(m) {
            None => added_by_sides(star, sides).expect("validated when the hierarchy was made"),
            Some(e) => {
                let mut added = AddedList { len: 0, items: [Added { w: 0, flipped: false }; MAX_ADDED] };
                for a in &h.explicit[e].added {
                    let i = a.star as usize;
                    let w = if a.before { star.before[i] } else { star.after[i] };
                    added.items[added.len] = Added { w, flipped: a.flipped };
                    added.len += 1;
                }
                added
            }
        }
    }

    pub(super) fn refine(&mut self, h: &EdgeCollapse, m: UpdateId) {
        let split = h.splits[m.ix()];
        let slot_u = self.slot(split.vertex).expect("the engine refines only what is legal");
        let star = self.star(slot_u).expect("validated when the hierarchy was made");
        let added = self.added(h, m, &star);

        let (u, v) = (h.child(m, 0), h.child(m, 1));
        let level = split.level.saturating_add(1);
        self.rename(slot_u, split.vertex, u);
        self.dress(slot_u, &h.vertex_look(u), level);
        let slot_v = self.new_vertex(v, &h.vertex_look(v), level);

        // The star's list becomes two; both stay sorted.
        let (mut end_u, mut end_v) = (NONE, NONE);
        self.first[slot_u as usize] = NONE;
        for (i, &corner) in star.corner[..star.len].iter().enumerate() {
            if split.sides >> i & 1 == 0 {
                self.link(slot_u, &mut end_u, corner);
            } else {
                self.buffers.triangles[corner as usize >> 2][corner as usize & 3] = slot_v;
                self.buffers.changes.triangles.push(corner >> 2);
                self.link(slot_v, &mut end_v, corner);
            }
        }
        self.terminate(end_u);
        self.terminate(end_v);

        let explicit = if split.sides & Columns::EXPLICIT != 0 { h.explicit_index(m) } else { None };
        for (j, a) in added.as_slice().iter().enumerate() {
            let corners = if a.flipped { [slot_v, a.w, slot_u] } else { [slot_u, a.w, slot_v] };
            let slot = self.new_triangle(h.added_number(m, explicit, j), corners);
            for k in 0..3 {
                self.insert_sorted(corners[k], slot << 2 | k as u32);
            }
        }
    }

    pub(super) fn coarsen(&mut self, h: &EdgeCollapse, m: UpdateId) {
        let split = h.splits[m.ix()];
        let legal = "the engine coarsens only what is legal";
        let slot_u = self.slot(h.child(m, 0)).expect(legal);
        let slot_v = self.slot(h.child(m, 1)).expect(legal);

        // The triangles on the edge go, last added first, so that free slots come back in the order they were taken.
        let mut gone = [0u32; MAX_ADDED];
        let mut gone_len = 0;
        let mut corner = self.first[slot_u as usize];
        while corner != NONE {
            let (t, k) = (corner >> 2, corner as usize & 3);
            if self.buffers.triangles[t as usize].contains(&slot_v) {
                gone[gone_len] = t;
                gone_len += 1;
            }
            corner = self.next[t as usize][k];
        }
        for &t in gone[..gone_len].iter().rev() {
            for k in 0..3u32 {
                self.unlink(self.buffers.triangles[t as usize][k as usize], t << 2 | k);
            }
            self.free_triangle(t);
        }

        // Two sorted lists become one.
        let (mut a, mut b) = (self.first[slot_u as usize], self.first[slot_v as usize]);
        let mut end = NONE;
        self.first[slot_u as usize] = NONE;
        while a != NONE || b != NONE {
            let from_v = a == NONE || (b != NONE && self.number_of(b) < self.number_of(a));
            let from = if from_v { &mut b } else { &mut a };
            let corner = *from;
            *from = self.next[corner as usize >> 2][corner as usize & 3];
            if from_v {
                self.buffers.triangles[corner as usize >> 2][corner as usize & 3] = slot_u;
                self.buffers.changes.triangles.push(corner >> 2);
            }
            self.link(slot_u, &mut end, corner);
        }
        self.terminate(end);

        self.free_vertex(slot_v, h.child(m, 1));
        self.rename(slot_u, h.child(m, 0), split.vertex);
        self.dress(slot_u, &h.vertex_look(split.vertex), split.level);
    }

    fn number_of(&self, corner: Corner) -> u32 {
        self.numbers[corner as usize >> 2]
    }

    // Lists. `link` appends after `end` without writing the terminator; `terminate` writes it.

    #[inline]
    fn link(&mut self, slot: u32, end: &mut Corner, corner: Corner) {
        if *end == NONE {
            self.first[slot as usize] = corner;
        } else {
            self.next[*end as usize >> 2][*end as usize & 3] = corner;
        }
        *end = corner;
    }
    #[inline]
    fn terminate(&mut self, end: Corner) {
        if end != NONE {
            self.next[end as usize >> 2][end as usize & 3] = NONE;
        }
    }
    fn append(&mut self, slot: u32, corner: Corner) {
        let mut at = self.first[slot as usize];
        let mut end = NONE;
        while at != NONE {
            end = at;
            at = self.next[at as usize >> 2][at as usize & 3];
        }
        self.link(slot, &mut end, corner);
        self.terminate(end);
    }
    fn insert_sorted(&mut self, slot: u32, corner: Corner) {
        let number = self.number_of(corner);
        let mut previous = NONE;
        let mut at = self.first[slot as usize];
        while at != NONE && self.number_of(at) < number {
            previous = at;
            at = self.next[at as usize >> 2][at as usize & 3];
        }
        self.next[corner as usize >> 2][corner as usize & 3] = at;
        if previous == NONE {
            self.first[slot as usize] = corner;
        } else {
            self.next[previous as usize >> 2][previous as usize & 3] = corner;
        }
    }
    fn unlink(&mut self, slot: u32, corner: Corner) {
        let after = self.next[corner as usize >> 2][corner as usize & 3];
        let mut at = self.first[slot as usize];
        if at == corner {
            self.first[slot as usize] = after;
            return;
        }
        loop {
            let next = &mut self.next[at as usize >> 2][at as usize & 3];
            if *next == corner {
                *next = after;
                return;
            }
            at = *next;
        }
    }

    // Slots.

    fn new_vertex(&mut self, id: VertexId, look: &VertexLook, level: u8) -> u32 {
        let slot = self.free_vertices.pop().unwrap_or_else(|| {
            let b = &mut self.buffers;
            grow(&mut b.positions, Default::default());
            grow(&mut b.normals, [0; 4]);
            if look.color.is_some() {
                grow(&mut b.colors, [0; 4]);
            }
            grow(&mut b.levels, 0);
            grow(&mut self.first, NONE);
            grow(&mut self.ids, VertexId(0));
            self.ids.len() as u32 - 1
        });
        self.ids[slot as usize] = id;
        self.first[slot as usize] = NONE;
        let ids = &self.ids;
        self.slots.insert_unique(hash(id), slot, |&s| hash(ids[s as usize]));
        self.dress(slot, look, level);
        slot
    }
    fn free_vertex(&mut self, slot: u32, id: VertexId) {
        self.forget(slot, id);
        let b = &mut self.buffers;
        b.positions[slot as usize] = Default::default();
        b.normals[slot as usize] = [0; 4];
        b.levels[slot as usize] = 0;
        if let Some(c) = b.colors.get_mut(slot as usize) {
            *c = [0; 4];
        }
        self.ids[slot as usize] = VertexId(0);
        self.first[slot as usize] = NONE;
        grow(&mut self.free_vertices, slot);
    }
    fn forget(&mut self, slot: u32, id: VertexId) {
        match self.slots.find_entry(hash(id), |&s| s == slot) {
            Ok(entry) => drop(entry.remove()),
            Err(_) => unreachable!("a live vertex is in the table"),
        }
    }
    fn rename(&mut self, slot: u32, from: VertexId, to: VertexId) {
        self.forget(slot, from);
        self.ids[slot as usize] = to;
        let ids = &self.ids;
        self.slots.insert_unique(hash(to), slot, |&s| hash(ids[s as usize]));
    }
    #[inline]
    fn dress(&mut self, slot: u32, look: &VertexLook, level: u8) {
        let b = &mut self.buffers;
        b.positions[slot as usize] = look.position;
        b.normals[slot as usize] = snorm16(look.normal);
        b.levels[slot as usize] = level;
        if let Some(c) = look.color {
            b.colors[slot as usize] = c;
        }
        b.changes.vertices.push(slot);
    }
    fn new_triangle(&mut self, number: u32, corners: [u32; 3]) -> u32 {
        let slot = self.free_triangles.pop().unwrap_or_else(|| {
            grow(&mut self.buffers.triangles, [0; 3]);
            grow(&mut self.next, [NONE; 3]);
            grow(&mut self.numbers, 0);
            self.numbers.len() as u32 - 1
        });
        self.buffers.triangles[slot as usize] = corners;
        self.next[slot as usize] = [NONE; 3];
        self.numbers[slot as usize] = number;
        self.buffers.changes.triangles.push(slot);
        slot
    }
    fn free_triangle(&mut self, slot: u32) {
        self.buffers.triangles[slot as usize] = [0; 3];
        self.buffers.changes.triangles.push(slot);
        self.next[slot as usize] = [NONE; 3];
        self.numbers[slot as usize] = 0;
        grow(&mut self.free_triangles, slot);
    }
}

fn snorm16(normal: Oct) -> [i16; 4] {
    // Rounds to nearest without a call, as `round` is one on the oldest x86-64.
    let [x, y, z] = (normal.decode() * 32767.0).to_array().map(|c| (c + 0.5f32.copysign(c)) as i16);
    [x, y, z, 0]
}

/// Pushes; capacity grows by an eighth, not by doubling, so that memory stays close to size.
#[inline]
fn grow<T>(column: &mut Vec<T>, value: T) {
    if column.len() == column.capacity() {
        column.reserve_exact((column.len() / 8).max(64));
    }
    column.push(value);
}
