//! For each vertex slot of a live mesh the list of the corners of its triangles.
//!
//! A list is sorted by triangle number, whatever the order of updates that led here. Highest numbers come first: they are
//! the latest, so that what comes and goes does so near the head.

use crate::live::put;

/// End of a list.
pub(crate) const NONE: u32 = u32::MAX;

/// One corner of a live triangle: `4 * triangle slot + corner 0..3`.
pub(crate) type Corner = u32;

/// The lists, and beside each head what else there is of a vertex: `V`.
#[derive(Clone, Debug)]
pub(crate) struct CornerLists<V> {
    /// Per vertex slot.
    vertices: Vec<Vertex<V>>,
    /// Per triangle slot.
    links: Vec<Links>,
}

#[derive(Clone, Copy, Debug)]
struct Vertex<V> {
    /// Who lives there.
    who: V,
    /// Head of its list.
    first: Corner,
}

#[derive(Clone, Copy, Debug)]
struct Links {
    /// Per corner: next in that corner's vertex's list.
    next: [Corner; 3],
    /// The triangle's number.
    number: u32,
}

impl<V: Copy> CornerLists<V> {
    pub fn new() -> CornerLists<V> {
        CornerLists { vertices: vec![], links: vec![] }
    }
    /// Empty again, in the same memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.links.clear();
    }
    pub fn memory_bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Vertex<V>>() + self.links.capacity() * size_of::<Links>()
    }
    /// Number of triangle slots.
    pub fn triangle_slots(&self) -> usize {
        self.links.len()
    }

    #[inline]
    pub fn who(&self, slot: u32) -> V {
        self.vertices[slot as usize].who
    }
    #[inline]
    pub fn who_mut(&mut self, slot: u32) -> &mut V {
        &mut self.vertices[slot as usize].who
    }
    /// A slot with an empty list, which may be the first one beyond the end; `most`: there are no more.
    pub fn set_vertex(&mut self, slot: u32, who: V, most: usize) {
        put(&mut self.vertices, slot, Vertex { who, first: NONE }, most);
    }
    /// A triangle whose corners are in no list yet.
    pub fn set_triangle(&mut self, slot: u32, number: u32, most: usize) {
        put(&mut self.links, slot, Links { next: [NONE; 3], number }, most);
    }
    /// What a free slot holds.
    pub fn remove_triangle(&mut self, slot: u32) {
        self.links[slot as usize] = Links { next: [NONE; 3], number: 0 };
    }
    /// The number of the triangle in a slot.
    #[inline]
    pub fn number(&self, triangle: u32) -> u32 {
        self.links[triangle as usize].number
    }
    /// The number of the triangle of a corner.
    #[inline]
    pub fn number_of(&self, corner: Corner) -> u32 {
        self.number(corner >> 2)
    }

    /// The corners around a vertex.
    #[inline]
    pub fn around(&self, slot: u32) -> impl Iterator<Item = Corner> {
        let mut at = self.vertices[slot as usize].first;
        std::iter::from_fn(move || {
            let corner = at;
            (corner != NONE).then(|| {
                at = self.next(corner);
                corner
            })
        })
    }
    #[inline]
    fn next(&self, corner: Corner) -> Corner {
        self.links[corner as usize >> 2].next[corner as usize & 3]
    }
    #[inline]
    fn set_next(&mut self, corner: Corner, next: Corner) {
        self.links[corner as usize >> 2].next[corner as usize & 3] = next;
    }

    /// Starts a list anew, given back as its end.
    #[inline]
    pub fn restart(&mut self, slot: u32) -> Corner {
        self.vertices[slot as usize].first = NONE;
        NONE
    }
    /// Appends after `end`, without saying that the list ends there: that is for `terminate`.
    #[inline]
    pub fn link(&mut self, slot: u32, end: &mut Corner, corner: Corner) {
        if *end == NONE {
            self.vertices[slot as usize].first = corner;
        } else {
            self.set_next(*end, corner);
        }
        *end = corner;
    }
    #[inline]
    pub fn terminate(&mut self, end: Corner) {
        if end != NONE {
            self.set_next(end, NONE);
        }
    }
    /// The list of u becomes those of u and v, in order. `to_v` says of triangle slot, corner and number where a corner goes.
    pub fn divide(&mut self, u: u32, v: u32, mut to_v: impl FnMut(u32, usize, u32) -> bool) {
        let mut corner = self.vertices[u as usize].first;
        let mut ends = [self.restart(u), self.restart(v)];
        while corner != NONE {
            let next = self.next(corner);
            let on_v = to_v(corner >> 2, corner as usize & 3, self.number_of(corner));
            self.link(if on_v { v } else { u }, &mut ends[usize::from(on_v)], corner);
            corner = next;
        }
        ends.into_iter().for_each(|end| self.terminate(end));
    }
    /// The list of v goes into that of u, in order; `moved` hears of each corner of v.
    #[inline]
    pub fn merge(&mut self, u: u32, v: u32, mut moved: impl FnMut(Corner)) {
        let [mut a, mut b] = [u, v].map(|slot| self.vertices[slot as usize].first);
        let mut end = self.restart(u);
        while a != NONE || b != NONE {
            let from_v = a == NONE || (b != NONE && self.number_of(b) > self.number_of(a));
            let from = if from_v { &mut b } else { &mut a };
            let corner = *from;
            *from = self.next(corner);
            if from_v {
                moved(corner);
            }
            self.link(u, &mut end, corner);
        }
        self.terminate(end);
    }
    /// Puts a corner before the first one whose triangle's number is not greater.
    pub fn insert(&mut self, slot: u32, corner: Corner) {
        let number = self.number_of(corner);
        let mut previous = NONE;
        let mut at = self.vertices[slot as usize].first;
        while at != NONE && self.number_of(at) > number {
            previous = at;
            at = self.next(at);
        }
        self.set_next(corner, at);
        if previous == NONE {
            self.vertices[slot as usize].first = corner;
        } else {
            self.set_next(previous, corner);
        }
    }
    /// Takes a corner out of a list that it is in.
    pub fn unlink(&mut self, slot: u32, corner: Corner) {
        let after = self.next(corner);
        let mut at = self.vertices[slot as usize].first;
        if at == corner {
            self.vertices[slot as usize].first = after;
            return;
        }
        loop {
            let next = self.next(at);
            if next == corner {
                self.set_next(at, after);
                return;
            }
            at = next;
        }
    }
}
