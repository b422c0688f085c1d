//! Quadric error metric (`garland1997`): the weighted sum of squared distances to a set of planes, as a symmetric
//! 4 × 4 form. Its square root is a priority, never an error that is shown: errors are measured.

use super::{End, Metric};
use glam::{DMat3, DVec3, Vec3};
use std::ops::{Add, AddAssign, Mul};

/// xᵀAx + 2bᵀx + c, in units of weight times length squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quadric {
    /// A, upper triangle: xx, xy, xz, yy, yz, zz.
    pub a: [f64; 6],
    /// b.
    pub b: DVec3,
    /// c.
    pub c: f64,
}

impl Quadric {
    /// `weight` times the squared distance to the plane n·x + d = 0; `n` is a unit vector.
    pub fn plane(n: DVec3, d: f64, weight: f64) -> Quadric {
        let w = n * weight;
        Quadric { a: [w.x * n.x, w.x * n.y, w.x * n.z, w.y * n.y, w.y * n.z, w.z * n.z], b: w * d, c: weight * d * d }
    }

    /// The form at a point. Rounding may leave it a little below zero.
    #[inline]
    pub fn at(&self, x: DVec3) -> f64 {
        let ax = self.times(x);
        x.dot(ax) + 2.0 * self.b.dot(x) + self.c
    }

    #[inline]
    fn times(&self, x: DVec3) -> DVec3 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        DVec3::new(xx * x.x + xy * x.y + xz * x.z, xy * x.x + yy * x.y + yz * x.z, xz * x.x + yz * x.y + zz * x.z)
    }

    /// The point of least cost, pulled towards `anchor` with the strength `pull` times the mean eigenvalue of A: flat
    /// and creased regions, where A has no inverse, need no case of their own.
    #[inline]
    pub fn minimum(&self, anchor: DVec3, pull: f64) -> Option<DVec3> {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let p = pull * (xx + yy + zz) / 3.0;
        if p <= 0.0 {
            return None;
        }
        // Relative to the anchor: (A + pI) y = -(A anchor + b).
        let g = -(self.times(anchor) + self.b);
        let m = DMat3::from_cols(DVec3::new(xx + p, xy, xz), DVec3::new(xy, yy + p, yz), DVec3::new(xz, yz, zz + p));
        let (c0, c1, c2) = (m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let det = m.x_axis.dot(c0);
        let y = DVec3::new(c0.dot(g), c1.dot(g), c2.dot(g)) / det;
        y.is_finite().then_some(anchor + y)
    }
}

/// How strongly a position is held where the planes leave it free: see [`Quadric::minimum`].
const PULL: f64 = 1e-6;

impl Quadric {
    /// Where a vertex goes that two others merge into, the sum of whose forms this is: to the minimum if that is near them,
    /// else to the best of their middle and themselves.
    #[inline]
    pub fn between(&self, pu: DVec3, pv: DVec3) -> DVec3 {
        let middle = (pu + pv) * 0.5;
        let near = |x: &DVec3| x.distance_squared(middle) <= 4.0 * pu.distance_squared(pv);
        if let Some(x) = self.minimum(middle, PULL).filter(near) {
            return x;
        }
        let [cm, cu, cv] = [middle, pu, pv].map(|x| self.at(x));
        if cm <= cu && cm <= cv {
            middle
        } else if cu <= cv {
            pu
        } else {
            pv
        }
    }
}

impl Add for Quadric {
    type Output = Quadric;
    #[inline]
    fn add(self, o: Quadric) -> Quadric {
        Quadric { a: std::array::from_fn(|i| self.a[i] + o.a[i]), b: self.b + o.b, c: self.c + o.c }
    }
}

impl Mul<f64> for Quadric {
    type Output = Quadric;
    #[inline]
    fn mul(self, k: f64) -> Quadric {
        Quadric { a: self.a.map(|x| x * k), b: self.b * k, c: self.c * k }
    }
}

impl AddAssign for Quadric {
    #[inline]
    fn add_assign(&mut self, o: Quadric) {
        *self = *self + o;
    }
}

/// The distance from the planes of the source's triangles, each weighed by its area, and from planes across its rims.
///
/// The cost is the mean over each end's planes, the larger of the two: so small parts are worth as much as large ones.
#[derive(Clone, Copy, Debug)]
pub struct Quadrics;

/// Weight of the planes that hold rims in place, against the weight of the surface.
const RIM_WEIGHT: f64 = 3.0;
/// Cost of length where the planes see none: flat regions merge short edges first.
const LENGTH_COST: f64 = 1e-7;

impl Metric for Quadrics {
    type Memory = Quadric;

    fn leaf(&self, p: Vec3, fan: &[[Vec3; 2]], rims: &[[Vec3; 2]]) -> Quadric {
        let p = p.as_dvec3();
        let mut q = Quadric::default();
        for [a, b] in fan {
            let cross = (a.as_dvec3() - p).cross(b.as_dvec3() - p);
            let area = 0.5 * cross.length();
            if area > 0.0 {
                let n = cross / (2.0 * area);
                q += Quadric::plane(n, -n.dot(p), area / 3.0);
            }
        }
        for [x, normal] in rims {
            let edge = x.as_dvec3() - p;
            let across = edge.cross(normal.as_dvec3());
            if across.length_squared() > 0.0 {
                let n = across.normalize();
                q += Quadric::plane(n, -n.dot(p), RIM_WEIGHT * edge.length_squared());
            }
        }
        q
    }

    fn best(&self, u: End<Quadric>, v: End<Quadric>) -> Vec3 {
        (u.memory + v.memory).between(u.at.as_dvec3(), v.at.as_dvec3()).as_vec3()
    }

    fn cost(&self, u: End<Quadric>, v: End<Quadric>, at: Vec3) -> f32 {
        let x = at.as_dvec3();
        let mean = |q: Quadric| {
            let weight = q.a[0] + q.a[3] + q.a[5];
            if weight > 0.0 { q.at(x).max(0.0) / weight } else { 0.0 }
        };
        (mean(u.memory).max(mean(v.memory)) + LENGTH_COST * u.at.distance_squared(v.at) as f64) as f32
    }

    fn merged(&self, u: End<Quadric>, v: End<Quadric>, _: Vec3) -> Quadric {
        u.memory + v.memory
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_sum_of_squared_distances_and_finds_its_minimum() {
        let planes = [
            (DVec3::new(1.0, 0.2, -0.3).normalize(), 0.7, 2.0),
            (DVec3::new(-0.1, 1.0, 0.4).normalize(), -0.2, 1.0),
            (DVec3::new(0.3, 0.1, 1.0).normalize(), 0.5, 3.0),
            (DVec3::new(0.5, -0.5, 0.2).normalize(), 0.1, 0.5),
        ];
        let q = planes.iter().fold(Quadric::default(), |q, &(n, d, w)| q + Quadric::plane(n, d, w));
        let cost = |x: DVec3| planes.iter().map(|&(n, d, w)| w * (n.dot(x) + d).powi(2)).sum::<f64>();
        let x = DVec3::new(0.3, -2.0, 1.5);
        assert!((q.at(x) - cost(x)).abs() < 1e-12);
        let best = q.minimum(DVec3::ZERO, 1e-12).unwrap();
        for step in [DVec3::X, DVec3::Y, DVec3::Z] {
            for sign in [-1e-3, 1e-3] {
                assert!(cost(best) < cost(best + sign * step));
            }
        }
    }

    #[test]
    fn a_flat_region_keeps_the_anchor() {
        let q = Quadric::plane(DVec3::Z, -1.0, 4.0);
        let x = q.minimum(DVec3::new(3.0, 4.0, 1.5), 1e-6).unwrap();
        assert!(x.distance(DVec3::new(3.0, 4.0, 1.0)) < 1e-5);
        assert_eq!(Quadric::default().minimum(DVec3::ZERO, 1e-6), None);
    }
}
