//! Numbers as files hold them: positions on a grid, unit vectors, errors.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use std::array::from_fn;

/// A uniform grid of positions: the same step on all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Bits per coordinate, 10 to 24.
    pub bits: u32,
    /// Mesh-space point of grid index (0, 0, 0).
    pub origin: DVec3,
    /// Mesh units between neighbouring grid points.
    pub step: f64,
}

impl Grid {
    /// The grid that holds a box with `bits` bits on its longest side.
    pub fn fit(bounds: meshfront_mesh::Bounds, bits: u32) -> Grid {
        let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
        let top = ((1u64 << bits) - 1) as f64;
        let step = if extent > 0.0 { extent / top } else { 1.0 };
        Grid { bits, origin: bounds.min.as_dvec3(), step }
    }
    /// Index of the nearest grid point, clamped to the grid.
    #[inline]
    pub fn index(&self, p: Vec3) -> [u32; 3] {
        let top = ((1u64 << self.bits) - 1) as f64;
        let q = ((p.as_dvec3() - self.origin) / self.step).round().clamp(DVec3::ZERO, DVec3::splat(top));
        [q.x as u32, q.y as u32, q.z as u32]
    }
    /// The mesh-space point of an index: the same bits on every machine.
    #[inline]
    pub fn point(&self, index: [u32; 3]) -> Vec3 {
        (self.origin + DVec3::new(index[0] as f64, index[1] as f64, index[2] as f64) * self.step).as_vec3()
    }
    /// The nearest grid point, in mesh space. `snap(snap(p)) == snap(p)`.
    #[inline]
    pub fn snap(&self, p: Vec3) -> Vec3 {
        self.point(self.index(p))
    }
}

/// A unit vector in octahedral encoding, two signed 16-bit numbers (Cigolle et al. 2014).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Oct(pub [i16; 2]);

impl Oct {
    /// Encodes a vector of any length but zero.
    pub fn encode(v: Vec3) -> Oct {
        let s = v.x.abs() + v.y.abs() + v.z.abs();
        if s.is_nan() || s <= 0.0 {
            return Oct([0, 0]);
        }
        let (mut x, mut y) = (v.x / s, v.y / s);
        if v.z < 0.0 {
            (x, y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
        }
        Oct([(x * 32767.0).round() as i16, (y * 32767.0).round() as i16])
    }
    /// The unit vector.
    #[inline]
    pub fn decode(self) -> Vec3 {
        let (x, y) = (self.0[0] as f32 / 32767.0, self.0[1] as f32 / 32767.0);
        let z = 1.0 - x.abs() - y.abs();
        let t = (-z).max(0.0);
        Vec3::new(x - t.copysign(x), y - t.copysign(y), z).normalize_or(Vec3::Z)
    }
}

/// How positions are kept: the upper 16 bits of a coordinate with the split, the lower ones in a column of their
/// own where there are any.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Places {
    /// Indices on a grid of up to 16 bits.
    Grid16(Grid),
    /// The bits of `f32` coordinates.
    Points,
}

impl Places {
    /// How positions are kept best where they lie on this grid.
    pub fn on(grid: Option<Grid>) -> Places {
        match grid {
            Some(grid) if grid.bits <= 16 => Places::Grid16(grid),
            _ => Places::Points,
        }
    }
    #[inline]
    pub fn join(&self, upper: [u16; 3], lower: impl FnOnce() -> [u16; 3]) -> Vec3 {
        match self {
            Places::Grid16(grid) => grid.point(upper.map(u32::from)),
            Places::Points => {
                let lower = lower();
                Vec3::from_array(from_fn(|k| f32::from_bits((upper[k] as u32) << 16 | lower[k] as u32)))
            }
        }
    }
    /// Upper and lower halves.
    pub fn split(&self, p: Vec3) -> ([u16; 3], [u16; 3]) {
        match self {
            Places::Grid16(grid) => (grid.index(p).map(|i| i as u16), [0; 3]),
            Places::Points => {
                let bits = p.to_array().map(f32::to_bits);
                (bits.map(|b| (b >> 16) as u16), bits.map(|b| b as u16))
            }
        }
    }
}

/// Rounds an error up to the numbers that a file holds: sixteen to an octave. Idempotent and monotone.
pub fn round_error_up(error: f32) -> f32 {
    // An f32 with 4 bits of mantissa. The carry into the exponent is what rounding up across an octave means.
    let bits = error.to_bits();
    f32::from_bits((bits + ((1 << 19) - 1)) & !((1 << 19) - 1))
}

/// The upper half of the bits of a number that is not negative, rounded up.
#[inline]
pub(crate) fn upper_half(x: f32) -> u16 {
    let bits = x.to_bits();
    ((bits >> 16) + u32::from(bits & 0xffff != 0)) as u16
}
/// The number of such a half.
#[inline]
pub(crate) fn of_upper_half(half: u16) -> f32 {
    f32::from_bits((half as u32) << 16)
}
