//! Positions as integers, so that one coder serves both quantized and lossless files.

use glam::Vec3;
use meshfront_hierarchies::edge_collapse::Grid;

/// How a point becomes three integers and back, exactly.
#[derive(Clone, Copy)]
pub(crate) enum Lattice {
    /// Index of a grid point.
    Grid(Grid),
    /// The bits of each `f32`, turned so that integers are in the order of the numbers.
    Float,
}

impl Lattice {
    pub(crate) fn new(grid: Option<Grid>) -> Lattice {
        grid.map_or(Lattice::Float, Lattice::Grid)
    }

    /// The integers of a point that lies on the lattice.
    #[cfg(feature = "write")]
    pub(crate) fn index(&self, p: Vec3) -> [u32; 3] {
        match self {
            Lattice::Grid(grid) => grid.index(p),
            Lattice::Float => p.to_array().map(ordered_bits),
        }
    }

    /// The point of an index; `None` where no finite point has it.
    #[inline]
    pub(crate) fn point(&self, index: [u32; 3]) -> Option<Vec3> {
        match self {
            Lattice::Grid(grid) => {
                let inside = (index[0] | index[1] | index[2]) >> grid.bits == 0;
                inside.then(|| grid.point(index))
            }
            Lattice::Float => {
                let p = Vec3::from_array(index.map(of_ordered_bits));
                p.is_finite().then_some(p)
            }
        }
    }
}

/// Bits of a float, as an integer that grows with it.
#[cfg(feature = "write")]
pub(crate) fn ordered_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The float with such an integer.
pub(crate) fn of_ordered_bits(bits: u32) -> f32 {
    f32::from_bits(if bits >> 31 == 1 { bits & !(1 << 31) } else { !bits })
}

/// u and v of a split as differences from s: across the edge, and from s to its middle. Modulo 2³², so that any
/// integers come back: the half of the edge is the same on both sides.
#[cfg(feature = "write")]
pub(super) fn split_residual(s: [u32; 3], u: [u32; 3], v: [u32; 3]) -> [[i32; 3]; 2] {
    let edge = [0, 1, 2].map(|i| v[i].wrapping_sub(u[i]) as i32);
    let middle = [0, 1, 2].map(|i| u[i].wrapping_add((edge[i] >> 1) as u32).wrapping_sub(s[i]) as i32);
    [edge, middle]
}

/// The inverse of `split_residual`: u and v.
#[inline]
pub(super) fn split_from_residual(s: [u32; 3], [edge, middle]: [[i32; 3]; 2]) -> [[u32; 3]; 2] {
    let u = [0, 1, 2].map(|i| s[i].wrapping_add(middle[i] as u32).wrapping_sub((edge[i] >> 1) as u32));
    let v = [0, 1, 2].map(|i| u[i].wrapping_add(edge[i] as u32));
    [u, v]
}
