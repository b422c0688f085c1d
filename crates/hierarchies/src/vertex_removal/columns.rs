//! The stored columns: what the simplifier makes and a file holds.

use super::encode::Connectivity;
use super::polygon::Triangulation;
use crate::columns::{InvalidColumns, SourceCounts};
use crate::quantize::{Grid, Oct};
use glam::Vec3;
use meshfront_mesh::TriangleMesh;

/// What is stored of a vertex-removal hierarchy.
///
/// Vertices are numbered: base vertices `0..B`, then update `m` inserts vertex `B + m`. Cells are numbered by sixteens: the base
/// triangles begin at 0, and the cells of update m's fan at [`Columns::first_cell`]. A cell has the same number and the same
/// three corners, in the same order, in all fronts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// How positions are quantized; `None`: lossless `f32`.
    pub grid: Option<Grid>,
    /// The base mesh Γ₀, with its attributes.
    pub base: TriangleMesh,
    /// Per update: the polygon and its triangulation M⁻.
    pub patches: Vec<Patch>,
    /// Per update: where its vertex is. On the grid, where there is one.
    pub positions: Vec<Vec3>,
    /// Per update: normal of its vertex; empty where the source had none.
    pub normals: Vec<Oct>,
    /// Per update: colour of its vertex; empty where the source had none.
    pub colors: Vec<[u8; 4]>,
    /// Per update: distance of the original surface from the cells of M⁻, mesh units; never smaller than that of
    /// an update that needs it.
    pub errors: Vec<f32>,
    /// The error of the front with all updates applied (quantization alone).
    pub floor_error: f32,
    /// Sizes of the mesh that the hierarchy was built from.
    pub source: SourceCounts,
    /// How a file says which triangulations they are.
    pub connectivity: Connectivity,
}

impl Columns {
    /// How many cell numbers an update has.
    pub const CELLS: u32 = 16;

    /// The number of the first cell of an update's fan, in a hierarchy with so many base triangles. Cell j of the fan is
    /// (v, corner j, corner j + 1 of the polygon).
    pub fn first_cell(base_triangles: usize, update: u32) -> u32 {
        base_triangles.next_multiple_of(Columns::CELLS as usize) as u32 + Columns::CELLS * update
    }

    /// Lengths, ranges and numbers: all that can be checked without applying updates.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), InvalidColumns> {
        super::derive::check_shape(self)
    }

    /// What made a cell: an update and the place in its fan, or `Err` with a base triangle.
    pub fn cell_maker(base_triangles: usize, cell: u32) -> Result<(u32, u32), u32> {
        match cell.checked_sub(Columns::first_cell(base_triangles, 0)) {
            Some(above) => Ok((above / Columns::CELLS, above % Columns::CELLS)),
            None => Err(cell),
        }
    }
}

/// The polygon that an update's vertex is inserted into, in the live mesh: it is found from one of its edges, the reference
/// edge, and the triangulation. That edge goes from the polygon's last corner to its corner 0. At a boundary it is the boundary
/// edge; else it is one that gives the triangulation the least number, so that few numbers are in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Number of the cell of M⁻ on the reference edge.
    pub cell: u32,
    /// Which corner of that cell the edge begins at, 0 to 2.
    pub edge: u8,
    /// Whether the reference edge is a boundary edge and the vertex comes to lie on it: then the fan is open there, and has a
    /// cell less.
    pub boundary: bool,
    /// M⁻.
    pub triangulation: Triangulation,
}

impl Patch {
    /// Number of cells of M⁺.
    pub fn fan(&self) -> usize {
        self.triangulation.corners as usize - usize::from(self.boundary)
    }
}
