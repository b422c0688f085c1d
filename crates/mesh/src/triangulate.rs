//! Polygons into triangles.
//!
//! Ear clipping (Meisters 1975, "Polygons have ears") in the plane that the polygon lies in best. Every corner of the
//! polygon is a corner of some triangle, also those in the middle of a straight side: a neighbour meets the polygon
//! there, and a corner left out would open a crack. (Libraries made for drawing, such as `earcut`, leave such corners
//! out.) Of the ears to be had the one with the best shape goes first.

use glam::{DVec2, Vec3};

/// Corners up to which each step looks for the best ear of all; beyond, the first good one is taken.
const CAREFUL: usize = 32;
/// An ear with at least this share of the quality of an equilateral triangle is good.
const GOOD: f64 = 0.3;
/// Looks at a corner or at a point in an ear that a polygon may cost, per corner: plenty for polygons that people draw,
/// and a bound on the time that a hostile one can take.
const EFFORT: usize = 1024;

/// Triangulates polygons one after the other, reusing its scratch memory.
#[derive(Default)]
pub struct Triangulator {
    flat: Vec<DVec2>,
    rest: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Triangulator {
    /// Cuts a polygon of n corners into n - 2 triangles of local corner indices, with the polygon's orientation.
    ///
    /// Concave polygons and corners on straight sides are fine. Of a polygon that crosses itself or has no area the
    /// triangles still cover each side once, but may overlap or have no area. Nearly planar polygons are meant; a quad
    /// in space is cut along the diagonal that gives the better shaped pair. Fewer than three points give nothing.
    ///
    /// Costs O(n²) for ordinary polygons and never more than 1024·n such tests.
    pub fn triangulate(&mut self, points: &[Vec3]) -> &[[u32; 3]] {
        self.triangles.clear();
        let n = points.len();
        match n {
            0..3 => return &self.triangles,
            3 => self.triangles.push([0, 1, 2]),
            _ => {
                flatten(points, &mut self.flat);
                if n == 4 {
                    self.quad();
                } else {
                    self.clip_ears();
                }
            }
        }
        &self.triangles
    }

    /// The better of two diagonals: valid before invalid, then by the worse shape of its two triangles.
    fn quad(&mut self) {
        let p = |i: u32| self.flat[i as usize];
        let worth = |pair: [[u32; 3]; 2]| {
            pair.map(|t| quality(p(t[0]), p(t[1]), p(t[2]))).into_iter().fold(f64::INFINITY, f64::min)
        };
        let across = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]];
        let best = if worth(across[1]) > worth(across[0]) { across[1] } else { across[0] };
        self.triangles.extend(best);
    }

    fn clip_ears(&mut self) {
        let flat = &self.flat;
        let rest = &mut self.rest;
        rest.clear();
        rest.extend(0..flat.len() as u32);
        let mut effort = EFFORT * flat.len() + (1 << 16);
        let mut start = 0;
        while rest.len() > 3 {
            let n = rest.len();
            let mut best = None;
            let mut flattest = None;
            let mut any_convex = false;
            for step in 0..n {
                let i = (start + step) % n;
                let [a, b, c] = [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]];
                let [pa, pb, pc] = [a, b, c].map(|v| flat[v as usize]);
                let quality = quality(pa, pb, pc);
                effort = effort.saturating_sub(1);
                if quality <= 0.0 {
                    // A corner on a straight side, or folded back: the last resort.
                    if quality == 0.0 && flattest.is_none() {
                        flattest = Some(i);
                    }
                    continue;
                }
                any_convex = true;
                if effort == 0 {
                    break;
                }
                if best.is_some_and(|(_, q)| quality <= q) {
                    continue;
                }
                let others = rest.iter().filter(|&&v| v != a && v != b && v != c);
                effort = effort.saturating_sub(n);
                if others.into_iter().any(|&v| blocks(flat[v as usize], pa, pb, pc)) {
                    continue;
                }
                best = Some((i, quality));
                if n > CAREFUL && quality >= GOOD {
                    break;
                }
            }
            // Without a convex corner nothing is left that has an area.
            let Some(ear) = best.map(|(i, _)| i).or(flattest.filter(|_| any_convex)) else {
                break;
            };
            self.triangles.push([rest[(ear + n - 1) % n], rest[ear], rest[(ear + 1) % n]]);
            rest.remove(ear);
            start = if ear >= rest.len() { 0 } else { ear + 1 };
        }
        // Three corners are a triangle; more are left only where the polygon crosses itself, and any cut is as good.
        self.triangles.extend((1..rest.len() - 1).map(|i| [rest[0], rest[i], rest[i + 1]]));
    }
}

/// The points without the coordinate along which their plane's normal (Newell's: Sutherland, Sproull & Schumacker
/// 1974) is longest, turned so that the polygon runs counter-clockwise.
fn flatten(points: &[Vec3], flat: &mut Vec<DVec2>) {
    let origin = points[0].as_dvec3();
    let mut normal = glam::DVec3::ZERO;
    for i in 0..points.len() {
        let a = points[i].as_dvec3() - origin;
        let b = points[(i + 1) % points.len()].as_dvec3() - origin;
        normal += a.cross(b);
    }
    let axis = normal.abs();
    let (u, v, along) = if axis.x >= axis.y && axis.x >= axis.z {
        (1, 2, normal.x)
    } else if axis.y >= axis.z {
        (2, 0, normal.y)
    } else {
        (0, 1, normal.z)
    };
    let (u, v) = if along < 0.0 { (v, u) } else { (u, v) };
    flat.clear();
    flat.extend(points.iter().map(|p| DVec2::new(f64::from(p[u]), f64::from(p[v]))));
}

/// Twice the signed area.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Area over squared sides: 1 for an equilateral triangle, 0 for one without area, negative for one turned over.
fn quality(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    // 2√3: area and squared sides of the equilateral triangle.
    const EQUILATERAL: f64 = 3.464_101_615_137_754_4;
    if sides > 0.0 { EQUILATERAL * area(a, b, c) / sides } else { 0.0 }
}

/// Whether a corner in or on triangle abc keeps b from being an ear. Corners that coincide with those of the triangle
/// do not: a slit or the bridge to a hole passes its corners twice.
fn blocks(p: DVec2, a: DVec2, b: DVec2, c: DVec2) -> bool {
    area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0 && p != a && p != b && p != c
}
