//! A hard cap on the memory of fronts: what the engine holds of them, and the buffers that a page draws them from.
//!
//! The engine knows a budget of triangles. How many of them fit into so many bytes depends on the mesh, and on what
//! allocators round up; so the number is a guess that is corrected by what there is, and nothing is handed to the page before
//! it fits.

use meshfront_hierarchies::AnySurface;

/// A page has its buffers twice: in its own memory and on the graphics card.
const COPIES: usize = 2;
/// Position, and normal with level.
const VERTEX_BYTES: usize = 12 + 8;
/// What to colour by.
const SHADE_BYTES: usize = 4;
/// As a page has colours: linear, 16 bits.
const COLOR_BYTES: usize = 8;
const TRIANGLE_BYTES: usize = 12;
/// Of a closed mesh, all copies together: where the guess begins.
const BYTES_PER_TRIANGLE: f64 = 120.0;

/// How long a page's buffers are, in slots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capacity {
    /// Of vertices.
    pub vertices: usize,
    /// Of triangles.
    pub triangles: usize,
}

impl Capacity {
    /// Long enough for a front, with a quarter to spare, but not longer than any front of the hierarchy: every growth
    /// uploads everything.
    pub fn reserve(self, front: &dyn AnySurface) -> Capacity {
        let buffers = front.buffers();
        let [most_vertices, most_triangles] = buffers.most_live();
        let grown = |now: usize, used: usize, most: usize| {
            if used <= now { now } else { (used + used / 4).min(most.max(used)) }
        };
        Capacity {
            vertices: grown(self.vertices, buffers.positions.len(), most_vertices),
            triangles: grown(self.triangles, buffers.triangles.len(), most_triangles),
        }
    }
    /// What such buffers take on the page.
    pub fn bytes(self, colors: bool, shade: bool) -> usize {
        let vertex = VERTEX_BYTES + if colors { COLOR_BYTES } else { 0 } + if shade { SHADE_BYTES } else { 0 };
        COPIES * (self.vertices * vertex + self.triangles * TRIANGLE_BYTES)
    }
}

/// How many triangles a cap of bytes allows, as far as is known.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    bytes: f64,
    triangles: f64,
    /// Where it was too much.
    ceiling: f64,
}

impl Cap {
    /// Nothing is known yet.
    pub fn new(bytes: f64) -> Cap {
        Cap { bytes, triangles: bytes / BYTES_PER_TRIANGLE, ceiling: f64::INFINITY }
    }
    /// The cap, bytes.
    pub fn bytes(&self) -> f64 {
        self.bytes
    }
    /// The most triangles.
    pub fn triangles(&self) -> usize {
        self.triangles as usize
    }
    /// So many triangles took so many bytes, which is too much.
    pub fn lower(&mut self, triangles: usize, bytes: f64) {
        let fitting = triangles as f64 * (0.94 * self.bytes / bytes).min(0.97);
        self.ceiling = self.triangles.min(triangles as f64);
        self.triangles = fitting.min(self.triangles);
    }
    /// So many triangles took so many bytes, and more are wanted. Whether there is room for enough of them to be worth it: what was
    /// too much once is not tried again, so that fronts do not swing.
    pub fn raise(&mut self, triangles: usize, bytes: f64) -> bool {
        let fitting = (triangles as f64 * 0.97 * self.bytes / bytes.max(1.0)).min(0.97 * self.ceiling);
        let worth = fitting > 1.04 * self.triangles;
        if worth {
            self.triangles = fitting;
        }
        worth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Memory that goes in steps, as allocators give it.
    fn bytes_of(triangles: f64) -> f64 {
        1000.0 + STEP * (triangles / 512.0).ceil()
    }
    const STEP: f64 = 137.0 * 512.0;

    #[test]
    fn a_cap_finds_what_fits_and_stays_there() {
        for bytes in [2e5, 1e6, 7.7e6, 1e8] {
            let mut cap = Cap::new(bytes);
            let mut changes = 0;
            for _ in 0..200 {
                let (triangles, used) = (cap.triangles(), bytes_of(cap.triangles));
                if used > bytes {
                    cap.lower(triangles, used);
                    changes += 1;
                } else if cap.raise(triangles, used) {
                    changes += 1;
                }
            }
            let used = bytes_of(cap.triangles);
            assert!(used <= bytes && used > 0.85 * bytes - STEP, "{used} of {bytes}");
            assert!(changes < 12, "{changes} changes");
        }
    }
}
