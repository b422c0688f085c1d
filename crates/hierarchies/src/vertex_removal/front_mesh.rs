//! The live mesh of one front: triangle buffers, and where each live cell is in them.
//!
//! A cell is found by its number, and its corners lead to the ring: no lists of triangles around vertices, and no adjacency.

use super::polygon::MOST_CORNERS;
use super::{CellCorner, VertexRemoval};
use crate::live::{TriangleBuffers, put};
use crate::model::LiveMesh;
use crate::slot_table::SlotTable;
use arrayvec::ArrayVec;
use meshfront_mesh::VertexId;
use meshfront_refine::UpdateId;

/// A front's live mesh: some 110 bytes per active vertex, where capacity follows size.
#[derive(Clone, Debug)]
pub struct FrontMesh {
    /// What is drawn.
    pub buffers: TriangleBuffers,
    /// Who lives in a vertex slot.
    ids: Vec<VertexId>,
    /// Triangle slot of a live cell, by its number.
    cells: SlotTable,
}

impl FrontMesh {
    pub(super) fn base(h: &VertexRemoval) -> FrontMesh {
        let mut front = FrontMesh {
            buffers: TriangleBuffers::for_at_most(h.most),
            ids: vec![],
            cells: SlotTable::new(h.first_cell(UpdateId(h.insertions.len() as u32)) as usize),
        };
        for v in 0..h.base.positions.len() as u32 {
            front.new_vertex(h, VertexId(v));
        }
        for (number, t) in h.base.triangles.iter().enumerate() {
            let slot = front.buffers.add_triangle(t.map(|v| v.0));
            front.cells.set(number, slot);
        }
        front
    }

    /// Corners of each live triangle, in slot order.
    pub fn corners(&self) -> impl Iterator<Item = [VertexId; 3]> {
        let live = self.buffers.triangles.iter().filter(|t| t[0] != t[1]);
        live.map(|t| t.map(|slot| self.ids[slot as usize]))
    }

    /// Triangle slot of a cell, where it is live.
    #[inline]
    pub(super) fn slot(&self, cell: u32) -> Option<u32> {
        self.cells.get(cell as usize)
    }

    /// The number of the cell in a triangle slot; `None` for a free one. A cell was made with the last of its vertices; in the base
    /// mesh this looks at all triangles.
    pub(super) fn cell(&self, h: &VertexRemoval, triangle: u32) -> Option<u32> {
        let corners = self.buffers.live_triangle(triangle)?;
        let last = corners.into_iter().map(|slot| self.ids[slot as usize].ix()).max()?;
        let mut cells = match last.checked_sub(h.base.positions.len()) {
            None => 0..h.base.triangles.len() as u32,
            Some(m) => h.first_cell(UpdateId(m as u32))..h.first_cell(UpdateId(m as u32 + 1)),
        };
        cells.find(|&cell| self.slot(cell) == Some(triangle))
    }

    #[inline]
    pub(super) fn refine(&mut self, h: &VertexRemoval, m: UpdateId) {
        let insertion = &h.insertions[m.ix()];
        let corners = insertion.triangulation.corners as usize;
        let mut ring = [0; MOST_CORNERS];
        let mut slots = ArrayVec::<u32, MOST_CORNERS>::new();
        for (&cell, corner) in h.minus_of(m).iter().zip(insertion.triangulation.triangles()) {
            let slot = self.slot(cell.number()).expect("the engine refines only what is legal");
            let triangle = self.buffers.triangles[slot as usize];
            for k in 0..3 {
                ring[corner[k] as usize] = triangle[cell.corner(k)];
            }
            self.cells.clear(cell.number() as usize);
            slots.push(slot);
        }
        let v = self.new_vertex(h, h.vertex(m));
        // The fan takes the places of M⁻, and one or two more.
        let first = h.first_cell(m) as usize;
        for j in 0..insertion.fan() {
            let triangle = [v, ring[j], ring[if j + 1 == corners { 0 } else { j + 1 }]];
            let slot = match slots.get(j) {
                Some(&slot) => {
                    self.buffers.set_triangle(slot, triangle);
                    slot
                }
                None => self.buffers.add_triangle(triangle),
            };
            self.cells.set(first + j, slot);
        }
    }

    pub(super) fn coarsen(&mut self, h: &VertexRemoval, m: UpdateId) {
        let insertion = &h.insertions[m.ix()];
        let corners = insertion.triangulation.corners as usize;
        let mut ring = [0; MOST_CORNERS];
        let mut slots = ArrayVec::<u32, MOST_CORNERS>::new();
        let first = h.first_cell(m) as usize;
        let mut v = 0;
        for j in 0..insertion.fan() {
            let slot = self.cells.get(first + j).expect("the engine coarsens only what is legal");
            [v, ring[j], ring[if j + 1 == corners { 0 } else { j + 1 }]] = self.buffers.triangles[slot as usize];
            self.cells.clear(first + j);
            slots.push(slot);
        }
        let minus = h.minus_of(m);
        for &slot in slots[minus.len()..].iter().rev() {
            self.buffers.remove_triangle(slot);
        }
        for ((&cell, corner), &slot) in minus.iter().zip(insertion.triangulation.triangles()).zip(&slots) {
            let mut triangle = [0; 3];
            for k in 0..3 {
                triangle[cell.corner(k)] = ring[corner[k] as usize];
            }
            self.buffers.set_triangle(slot, triangle);
            self.cells.set(cell.number() as usize, slot);
        }
        self.ids[v as usize] = VertexId(0);
        self.buffers.remove_vertex(v);
    }

    fn new_vertex(&mut self, h: &VertexRemoval, id: VertexId) -> u32 {
        let slot = self.buffers.add_vertex(&h.vertex_look(id));
        put(&mut self.ids, slot, id, self.buffers.most().vertices);
        slot
    }
}

impl CellCorner {
    /// Which corner of the cell is the k-th of its triangle in the triangulation.
    #[inline]
    fn corner(self, k: usize) -> usize {
        let corner = self.first() + k;
        if corner >= 3 { corner - 3 } else { corner }
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
        self.buffers.memory_bytes() + self.ids.capacity() * size_of::<VertexId>() + self.cells.memory_bytes()
    }
}
