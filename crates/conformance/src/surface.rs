//! A live mesh as anybody sees it, independent of slots.

use crate::Inspect;
use glam::Vec3;
use meshfront_hierarchies::LiveMesh;
use std::collections::BTreeMap;

/// A triangle by the names of its corners, the least first, in its orientation.
pub type Cell = [u32; 3];

/// What is drawn of a vertex, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    position: [u32; 3],
    /// As in the buffers.
    pub normal: [i16; 4],
    /// As in the buffers.
    pub color: Option<[u8; 4]>,
    /// As in the buffers.
    pub level: u8,
}

impl Look {
    /// Where the vertex is, mesh space.
    pub fn position(&self) -> Vec3 {
        Vec3::from_array(self.position.map(f32::from_bits))
    }
}

/// A live mesh: equal ones look the same and consist of the same vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surface {
    /// Ascending.
    pub cells: Vec<Cell>,
    /// The vertices that cells use.
    pub looks: BTreeMap<u32, Look>,
}

/// The least name first, orientation kept.
pub fn cell([a, b, c]: [u32; 3]) -> Cell {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

impl Surface {
    /// Reads the buffers; costs n log n.
    ///
    /// # Panics
    /// Where buffers contradict themselves: a vertex in two slots, two vertices in one slot, columns of unequal length.
    pub fn of<H: Inspect>(mesh: &H::Mesh) -> Surface {
        let b = mesh.buffers();
        let n = b.positions.len();
        assert_eq!((b.normals.len(), b.levels.len()), (n, n), "vertex columns have the same length");
        assert!(b.colors.is_empty() || b.colors.len() == n, "a colour for each vertex slot or for none");
        let live: Vec<_> = b.triangles.iter().filter(|t| **t != [0; 3]).collect();
        let names = H::names(mesh);
        assert_eq!(live.len(), names.len(), "free triangle slots hold zeros, live ones do not");
        let mut slot_of = BTreeMap::new();
        let mut looks = BTreeMap::new();
        for (t, names) in live.iter().zip(&names) {
            for (&slot, &name) in t.iter().zip(names) {
                let known = *slot_of.entry(name).or_insert(slot);
                assert_eq!(known, slot, "vertex {name} lives in two slots");
                let slot = slot as usize;
                looks.entry(name).or_insert_with(|| Look {
                    position: b.positions[slot].to_array().map(f32::to_bits),
                    normal: b.normals[slot],
                    color: b.colors.get(slot).copied(),
                    level: b.levels[slot],
                });
            }
        }
        let mut slots: Vec<u32> = slot_of.values().copied().collect();
        slots.sort_unstable();
        slots.dedup();
        assert_eq!(slots.len(), slot_of.len(), "two vertices live in one slot");
        let mut cells: Vec<Cell> = names.into_iter().map(cell).collect();
        cells.sort_unstable();
        Surface { cells, looks }
    }

    /// The corners of a cell of this surface.
    pub fn corners(&self, cell: Cell) -> [Vec3; 3] {
        cell.map(|name| self.looks[&name].position())
    }
    /// The corners of all cells.
    pub fn triangles(&self) -> Vec<[Vec3; 3]> {
        self.cells.iter().map(|&c| self.corners(c)).collect()
    }
    /// The cells that only this surface has, and those that only the other one has: as often as it has more of them.
    pub fn difference(&self, other: &Surface) -> (Vec<Cell>, Vec<Cell>) {
        let only = |a: &Surface, b: &Surface| {
            let mut others = b.cells.iter().peekable();
            let alone = |cell: &Cell| {
                while others.next_if(|other| *other < cell).is_some() {}
                others.next_if_eq(&cell).is_none()
            };
            a.cells.iter().copied().filter(alone).collect::<Vec<_>>()
        };
        (only(self, other), only(other, self))
    }
}
