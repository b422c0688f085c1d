//! The live mesh of one front: triangle buffers, and for each active node the list of its triangles, of any length.

use super::{Key, Origin, VertexPair};
use crate::corner_lists::{Corner, CornerLists, NONE};
use crate::live::{TriangleBuffers, VertexLook};
use crate::model::LiveMesh;
use crate::slot_table::SlotTable;
use meshfront_refine::UpdateId;

/// A front's live mesh: some 130 bytes per active node with the engine's state, where capacity follows size.
#[derive(Clone, Debug)]
pub struct FrontMesh {
    /// What is drawn.
    pub buffers: TriangleBuffers,
    lists: CornerLists<Node>,
    /// Slot of an active node, by its key.
    slots: SlotTable,
    scratch: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// Who lives there.
    key: Key,
    /// One more than the update that makes it; 0 for nodes of the base mesh.
    born: u32,
    /// The places of the leaves below it: from, and up to.
    leaves: [u32; 2],
}

impl Node {
    const FREE: Node = Node { key: NONE, born: 0, leaves: [0; 2] };

    fn holds(&self, place: u32) -> bool {
        self.leaves[0] <= place && place < self.leaves[1]
    }
}

/// A triangle of a star.
#[derive(Clone, Copy)]
pub(super) struct StarCorner {
    pub corner: Corner,
    /// Vertex slot: the one after the centre in the triangle's orientation.
    pub after: u32,
    /// And the one before.
    pub before: u32,
}

impl FrontMesh {
    pub(super) fn base(h: &VertexPair) -> FrontMesh {
        let mut front = FrontMesh {
            buffers: TriangleBuffers::for_at_most(h.most()),
            lists: CornerLists::new(),
            slots: SlotTable::new(h.base.positions.len() + 2 * h.splits.len()),
            scratch: vec![],
        };
        let ends = h.roots.iter().skip(1).map(|root| root.first_leaf).chain([h.most().vertices as u32]);
        for (v, (root, end)) in h.roots.iter().zip(ends).enumerate() {
            let node = Node { key: root.key, leaves: [root.first_leaf, end], ..Node::FREE };
            front.new_node(node, &h.look(Origin::Base(v as u32), 0));
        }
        for (number, t) in h.base.triangles.iter().enumerate() {
            front.new_triangle(number as u32, t.map(|v| v.0));
        }
        front
    }

    /// Number and corners of each live triangle, in slot order. A triangle has the same number in all fronts, and so has
    /// a node.
    pub fn numbered_triangles(&self) -> impl Iterator<Item = (u32, [u32; 3])> {
        let live = self.buffers.triangles.iter().enumerate().filter(|(_, t)| t[0] != t[1]);
        live.map(|(slot, t)| (self.lists.number(slot as u32), t.map(|slot| self.key(slot))))
    }

    /// The slot of an active node.
    #[inline]
    pub(super) fn slot(&self, key: Key) -> Option<u32> {
        self.slots.get(key as usize)
    }
    #[inline]
    pub(super) fn key(&self, slot: u32) -> Key {
        self.lists.who(slot).key
    }
    /// The update that made the node in a slot; `None` for nodes of the base mesh.
    #[inline]
    pub(super) fn maker(&self, slot: u32) -> Option<UpdateId> {
        self.lists.who(slot).born.checked_sub(1).map(UpdateId)
    }

    /// The place of the first leaf below the node in a slot.
    pub(super) fn first_leaf(&self, slot: u32) -> u32 {
        self.lists.who(slot).leaves[0]
    }

    /// The triangles around a slot, the highest number first.
    #[inline]
    pub(super) fn star(&self, slot: u32) -> impl Iterator<Item = StarCorner> {
        self.lists.around(slot).map(|corner| {
            let (triangle, k) = (&self.buffers.triangles[corner as usize >> 2], corner as usize & 3);
            let (after, before) = (triangle[if k == 2 { 0 } else { k + 1 }], triangle[if k == 0 { 2 } else { k - 1 }]);
            StarCorner { corner, after, before }
        })
    }
    /// The number of the triangle of a corner.
    pub(super) fn number(&self, corner: Corner) -> u32 {
        self.lists.number_of(corner)
    }

    pub(super) fn refine(&mut self, h: &VertexPair, m: UpdateId) {
        let split = &h.splits[m.ix()];
        let u = self.slot(m.0).expect("the engine refines only what is legal");
        let s = self.lists.who(u);
        // Whom the new triangles end at, as long as the star is whole.
        let mut others = std::mem::take(&mut self.scratch);
        let leaves = h.triangles[h.added(m).start as usize..h.added(m).end as usize].iter().flatten();
        others.extend(leaves.filter(|&&leaf| !s.holds(leaf)).map(|&leaf| self.holder(h, u, leaf)));

        let level = self.buffers.levels[u as usize].saturating_add(1);
        self.slots.clear(m.0 as usize);
        self.settle(u, split.children[0], m.0 + 1);
        self.lists.who_mut(u).leaves[1] = split.middle;
        self.buffers.set_vertex(u, &h.look(Origin::Child(m, 0), level));
        let leaves = [split.middle, s.leaves[1]];
        let node = Node { key: split.children[1], born: m.0 + 1, leaves };
        let v = self.new_node(node, &h.look(Origin::Child(m, 1), level));

        // The star's list becomes two; both stay in order.
        let FrontMesh { lists, buffers, .. } = self;
        lists.divide(u, v, |triangle, corner, number| {
            let on_v = h.triangles[number as usize][corner] >= split.middle;
            if on_v {
                buffers.set_corner(triangle, corner, v);
            }
            on_v
        });

        let mut other = others.iter();
        for number in h.added(m) {
            let corners = h.triangles[number as usize].map(|leaf| match leaf {
                leaf if !s.holds(leaf) => *other.next().expect("looked up above"),
                leaf if leaf < split.middle => u,
                _ => v,
            });
            self.new_triangle(number, corners);
        }
        others.clear();
        self.scratch = others;
    }

    pub(super) fn coarsen(&mut self, h: &VertexPair, m: UpdateId) {
        let split = &h.splits[m.ix()];
        let legal = "the engine coarsens only what is legal";
        let [u, v] = split.children.map(|key| self.slot(key).expect(legal));

        // Its own triangles go, last added first, so that free slots come back in the order they were taken.
        let mut gone = std::mem::take(&mut self.scratch);
        let own = h.added(m);
        for slot in [u, v] {
            let star = self.star(slot).map(|t| t.corner).skip_while(|&corner| self.number(corner) >= own.end);
            gone.extend(star.take_while(|&corner| self.number(corner) >= own.start).map(|corner| corner >> 2));
        }
        gone.sort_unstable_by_key(|&t| std::cmp::Reverse(self.lists.number(t)));
        gone.dedup();
        for &t in &gone {
            for k in 0..3u32 {
                self.lists.unlink(self.buffers.triangles[t as usize][k as usize], t << 2 | k);
            }
            self.lists.remove_triangle(t);
            self.buffers.remove_triangle(t);
        }
        gone.clear();
        self.scratch = gone;

        let FrontMesh { lists, buffers, .. } = self;
        lists.merge(u, v, |corner| buffers.set_corner(corner >> 2, corner as usize & 3, u));

        let last = self.lists.who(v).leaves[1];
        self.slots.clear(split.children[1] as usize);
        self.lists.set_vertex(v, Node::FREE, self.buffers.most().vertices);
        self.buffers.remove_vertex(v);
        self.slots.clear(split.children[0] as usize);
        self.settle(u, m.0, h.parent(m).map_or(0, |parent| parent.0 + 1));
        self.lists.who_mut(u).leaves[1] = last;
        let level = match self.buffers.levels[u as usize] {
            u8::MAX => std::iter::successors(h.parent(m), |&p| h.parent(p)).take(u8::MAX as usize).count() as u8,
            level => level - 1,
        };
        self.buffers.set_vertex(u, &h.look(h.origin(m), level));
    }

    /// The slot of the active node above a leaf, which is likely to be a neighbour of a slot.
    fn holder(&self, h: &VertexPair, near: u32, place: u32) -> u32 {
        // A look at a neighbour is cheap, but a star may have thousands.
        const MOST_LOOKS: usize = 24;
        let neighbours = self.star(near).take(MOST_LOOKS).flat_map(|t| [t.after, t.before]);
        if let Some(slot) = { neighbours }.find(|&slot| self.lists.who(slot).holds(place)) {
            return slot;
        }
        let mut key = h.roots[h.roots.partition_point(|root| root.first_leaf <= place) - 1].key;
        loop {
            if let Some(slot) = self.slot(key) {
                return slot;
            }
            let split = &h.splits[key as usize];
            key = split.children[usize::from(place >= split.middle)];
        }
    }

    // Slots.

    fn new_node(&mut self, node: Node, look: &VertexLook) -> u32 {
        let slot = self.buffers.add_vertex(look);
        self.lists.set_vertex(slot, node, self.buffers.most().vertices);
        self.slots.set(node.key as usize, slot);
        slot
    }
    /// From here on a node lives in a slot, whose list of corners stays.
    #[inline]
    fn settle(&mut self, slot: u32, key: Key, born: u32) {
        self.slots.set(key as usize, slot);
        let node = self.lists.who_mut(slot);
        (node.key, node.born) = (key, born);
    }
    fn new_triangle(&mut self, number: u32, corners: [u32; 3]) {
        let slot = self.buffers.add_triangle(corners);
        self.lists.set_triangle(slot, number, self.buffers.most().triangles);
        for k in 0..3 {
            self.lists.insert(corners[k], slot << 2 | k as u32);
        }
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
        let scratch = self.scratch.capacity() * size_of::<u32>();
        self.buffers.memory_bytes() + self.lists.memory_bytes() + scratch + self.slots.memory_bytes()
    }
}
