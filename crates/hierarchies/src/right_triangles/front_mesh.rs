//! The live mesh of one front. A cut leaves one half of a triangle in its slot, so that the update which made the
//! triangle knows where it is for as long as it is applied.

use super::lattice::{Site, quarter};
use super::record::Record;
use super::{Corner, RightTriangles};
use crate::live::{TriangleBuffers, VertexLook, put, snorm16};
use crate::model::LiveMesh;
use crate::slot_table::SlotTable;
use meshfront_refine::UpdateId;

/// A front's live mesh.
#[derive(Clone, Debug)]
pub struct FrontMesh {
    /// What is drawn.
    pub buffers: TriangleBuffers,
    /// Per vertex slot: its sample, `row · columns + column` from the south-west.
    samples: Vec<u32>,
    /// Slots of the triangles around an applied update, by `4 · id + quarter`.
    slots: SlotTable,
}

impl FrontMesh {
    pub(super) fn base(h: &RightTriangles) -> FrontMesh {
        let mut front = FrontMesh {
            buffers: TriangleBuffers::for_at_most(h.most()),
            samples: vec![],
            slots: SlotTable::new(4 * h.records.len()),
        };
        for &Corner { sample: [x, y], ref record } in &h.corners {
            front.new_vertex(h, x as i32, y as i32, record, 0);
        }
        for &corners in &h.base {
            front.buffers.add_triangle(corners);
        }
        front
    }

    /// The sample of each vertex slot: `row · columns + column` from the south-west. Free slots keep an old one.
    pub fn samples(&self) -> &[u32] {
        &self.samples
    }

    fn new_vertex(&mut self, h: &RightTriangles, x: i32, y: i32, record: &Record, level: u8) -> u32 {
        let look = VertexLook {
            position: h.position(x, y, record.height),
            normal: snorm16(record.normal()),
            color: None,
            level,
        };
        let slot = self.buffers.add_vertex(&look);
        let sample = y as u32 * h.lattice.columns as u32 + x as u32;
        put(&mut self.samples, slot, sample, self.buffers.most().vertices);
        slot
    }

    /// The slot of the triangle with its right angle at a step from v and its hypotenuse through v; `None`: not there.
    #[inline]
    fn slot(&self, h: &RightTriangles, site: &Site, [dx, dy]: [i32; 2]) -> Option<u32> {
        let apex = [site.x + dx, site.y + dy];
        let quarter = quarter([-dx, -dy]);
        match h.lattice.id(apex[0], apex[1]) {
            Some(id) if h.is_update(id) => self.slots.get(4 * id as usize + quarter),
            _ => h.base_slots.get(&(apex, quarter)).copied(),
        }
    }

    #[inline]
    pub(super) fn refine(&mut self, h: &RightTriangles, m: UpdateId) {
        let site = h.lattice.site(m.0);
        let level = (h.lattice.level_of(m.0) + 1).min(255) as u8;
        let v = self.new_vertex(h, site.x, site.y, &h.records[m.ix()], level);
        for way in site.apexes() {
            let Some(slot) = self.slot(h, &site, way) else { continue };
            let [a, b, c] = self.buffers.triangles[slot as usize];
            self.buffers.set_triangle(slot, [c, a, v]);
            let other = self.buffers.add_triangle([b, c, v]);
            let [first, second] = halves(m, way);
            self.slots.set(first, slot);
            self.slots.set(second, other);
        }
    }

    #[inline]
    pub(super) fn coarsen(&mut self, h: &RightTriangles, m: UpdateId) {
        let site = h.lattice.site(m.0);
        let mut v = 0;
        for way in site.apexes().into_iter().rev() {
            let [first, second] = halves(m, way);
            let Some(slot) = self.slots.get(first) else { continue };
            let other = self.slots.get(second).expect("both halves are there");
            self.slots.clear(first);
            self.slots.clear(second);
            let [c, a, middle] = self.buffers.triangles[slot as usize];
            let [b, ..] = self.buffers.triangles[other as usize];
            self.buffers.remove_triangle(other);
            self.buffers.set_triangle(slot, [a, b, c]);
            v = middle;
        }
        self.buffers.remove_vertex(v);
    }
}

/// Keys of the two halves of a triangle whose right angle is a step away: the first has its hypotenuse from there to
/// where the hypotenuse began.
#[inline]
fn halves(m: UpdateId, [dx, dy]: [i32; 2]) -> [usize; 2] {
    // Ends of the hypotenuse are at a right angle to the step: a = v + (−dy, dx), b = v + (dy, −dx).
    [[dx - dy, dy + dx], [dx + dy, dy - dx]].map(|way| 4 * m.ix() + quarter(way))
}

impl LiveMesh for FrontMesh {
    fn buffers(&self) -> &TriangleBuffers {
        &self.buffers
    }
    fn buffers_mut(&mut self) -> &mut TriangleBuffers {
        &mut self.buffers
    }
    fn memory_bytes(&self) -> usize {
        self.buffers.memory_bytes() + self.samples.capacity() * 4 + self.slots.memory_bytes()
    }
}
