//! The live mesh of one front. A cut leaves one half of a triangle in its slot, so that the update which made the
//! triangle knows where it is for as long as it is applied.

use super::lattice::{APEXES, NOWHERE, Site, Spot, quarter};
use super::record::Record;
use super::{Corner, RightTriangles};
use crate::live::{TriangleBuffers, VertexLook, put, snorm16};
use crate::model::LiveMesh;
use crate::slot_table::{NONE, SlotTable};
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
        front.add_base(h);
        front
    }
    pub(super) fn reset(&mut self, h: &RightTriangles) {
        self.buffers.clear();
        self.samples.clear();
        self.slots.reset();
        self.add_base(h);
    }
    fn add_base(&mut self, h: &RightTriangles) {
        for &Corner { sample: [x, y], ref record } in &h.corners {
            self.new_vertex(h, x as i32, y as i32, record, 0);
        }
        for &corners in &h.base {
            self.buffers.add_triangle(corners);
        }
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

    /// The slot of the triangle with its right angle at a step from v, where `apex` is, and its hypotenuse through v; `None`: not
    /// there.
    #[inline]
    fn slot(&self, h: &RightTriangles, site: &Site, side: &Side, apex: u32) -> Option<u32> {
        if apex != NOWHERE && h.is_update(apex) {
            return self.slots.get(4 * apex as usize + side.quarter);
        }
        let [dx, dy] = side.way.map(|step| step * site.h);
        h.base_slots.get(&([site.x + dx, site.y + dy], side.quarter)).copied()
    }

    #[inline]
    pub(super) fn refine(&mut self, h: &RightTriangles, m: UpdateId, spot: &Spot, apexes: [u32; 2]) {
        let site = spot.site();
        let level = (spot.level + 1).min(255) as u8;
        let v = self.new_vertex(h, site.x, site.y, &h.records[m.ix()], level);
        let mut around = [NONE; 4];
        for (side, apex) in SIDES[spot.turn()].iter().zip(apexes) {
            let Some(slot) = self.slot(h, &site, side, apex) else { continue };
            let [a, b, c] = self.buffers.triangles[slot as usize];
            self.buffers.set_triangle(slot, [c, a, v]);
            let other = self.buffers.add_triangle([b, c, v]);
            let [first, second] = side.halves;
            (around[first], around[second]) = (slot, other);
        }
        self.slots.set_four(4 * m.ix(), around);
    }

    #[inline]
    pub(super) fn coarsen(&mut self, h: &RightTriangles, m: UpdateId) {
        let around = self.slots.four(4 * m.ix()).expect("the engine coarsens only what is applied");
        let mut v = 0;
        for side in SIDES[h.lattice.spot(m.0).turn()].iter().rev() {
            let [slot, other] = side.halves.map(|quarter| around[quarter]);
            if slot == NONE {
                continue;
            }
            let [c, a, middle] = self.buffers.triangles[slot as usize];
            let [b, ..] = self.buffers.triangles[other as usize];
            self.buffers.remove_triangle(other);
            self.buffers.set_triangle(slot, [a, b, c]);
            v = middle;
        }
        self.slots.clear_four(4 * m.ix());
        self.buffers.remove_vertex(v);
    }
}

/// One of the two triangles of M⁻, as it lies about v.
struct Side {
    /// From v to its right angle, in units of h.
    way: [i32; 2],
    /// Its place among the triangles around its right angle.
    quarter: usize,
    /// Places of its two halves among those around v: the first has its hypotenuse from the right angle to where the hypotenuse
    /// began.
    halves: [usize; 2],
}

/// Per [`Spot::turn`], in the order of [`Site::apexes`].
const SIDES: [[Side; 2]; 4] = {
    const fn sides([first, second]: [[i32; 2]; 2]) -> [Side; 2] {
        [side(first), side(second)]
    }
    const fn side(way: [i32; 2]) -> Side {
        let [dx, dy] = way;
        // Ends of the hypotenuse are at a right angle to the step: a = v + (−dy, dx), b = v + (dy, −dx).
        let halves = [quarter([dx - dy, dy + dx]), quarter([dx + dy, dy - dx])];
        Side { way, quarter: quarter([-dx, -dy]), halves }
    }
    [sides(APEXES[0]), sides(APEXES[1]), sides(APEXES[2]), sides(APEXES[3])]
};

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
