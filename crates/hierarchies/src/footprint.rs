//! Footprints in 16 bytes: what a criterion reads is one quarter of a cache line.

use crate::quantize::{Oct, of_upper_half, upper_half};
use arrayvec::ArrayVec;
use glam::Vec3;
use meshfront_mesh::Bounds;
use meshfront_refine::{Footprint, NormalCone};
use std::f32::consts::{FRAC_PI_2, PI};

/// Everything rounds to the safe side: spheres and cones only grow by packing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PackedFootprint {
    pub error: f32,
    /// Position in the frame.
    center: [u16; 3],
    /// The upper half of an `f32`, rounded up.
    radius: u16,
    /// Octahedral axis, 8 bits a coordinate.
    axis: [i8; 2],
    /// Cosine of the half angle times 32767, rounded down.
    cos: i16,
}

impl PackedFootprint {
    /// An error whose place is not known yet.
    pub fn of_error(error: f32) -> PackedFootprint {
        PackedFootprint { error, ..Default::default() }
    }
}

/// The box in which centres are quantized.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    min: Vec3,
    step: f32,
    max: Vec3,
}

impl Frame {
    pub fn new(bounds: Bounds) -> Frame {
        let extent = (bounds.max - bounds.min).max_element();
        Frame { min: bounds.min, step: if extent > 0.0 { extent / 65535.0 } else { 1.0 }, max: bounds.max }
    }
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.min, max: self.max }
    }
    fn point(&self, q: [u16; 3]) -> Vec3 {
        self.min + Vec3::new(q[0] as f32, q[1] as f32, q[2] as f32) * self.step
    }

    /// Packs; `radius_at` and `angle_at` give the radius and the half angle needed around the centre and the axis
    /// that packing rounds to.
    pub fn pack(
        &self,
        error: f32,
        center: Vec3,
        axis: Vec3,
        radius_at: impl FnOnce(Vec3) -> f32,
        angle_at: impl FnOnce(Vec3) -> f32,
    ) -> PackedFootprint {
        let q = ((center - self.min) / self.step).round().clamp(Vec3::ZERO, Vec3::splat(65535.0));
        let center = [q.x as u16, q.y as u16, q.z as u16];
        // A relative 1e-6 covers the rounding of the additions that checked containment.
        let radius = upper_half(radius_at(self.point(center)) * (1.0 + 1e-6));
        let axis = Oct::encode(axis).0.map(|c| ((c as f32) * (127.0 / 32767.0)).round() as i8);
        PackedFootprint { error, center, radius, axis, cos: pack_angle(angle_at(unpack_axis(axis))) }
    }

    #[inline]
    pub fn unpack(&self, f: &PackedFootprint) -> Footprint {
        let cos = f.cos as f32 / 32767.0;
        Footprint {
            center: self.point(f.center),
            radius: of_upper_half(f.radius),
            error: f.error,
            cone: NormalCone { axis: unpack_axis(f.axis), sin: (1.0 - cos * cos).max(0.0).sqrt(), cos },
        }
    }
}

#[inline]
fn unpack_axis(axis: [i8; 2]) -> Vec3 {
    let (x, y) = (axis[0] as f32 / 127.0, axis[1] as f32 / 127.0);
    let z = 1.0 - x.abs() - y.abs();
    let t = (-z).max(0.0);
    Vec3::new(x - t.copysign(x), y - t.copysign(y), z).normalize()
}

/// The half angle of a cone, radians; π where it culls nothing.
fn half_angle(cone: &NormalCone) -> f32 {
    if cone.cos <= 0.0 { PI } else { cone.cos.min(1.0).acos() }
}

/// The angle between two unit vectors, accurate for small angles too.
fn angle_between(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The greatest packed cosine whose half angle is no smaller. An angle that was unpacked packs to itself: cones
/// do not widen by being handed up through many updates.
fn pack_angle(angle: f32) -> i16 {
    if angle >= FRAC_PI_2 {
        return -32767;
    }
    let mut cos = ((angle.cos() * 32767.0).ceil() as i16).min(32766) + 1;
    while cos > 0 && (cos as f32 / 32767.0).acos() < angle {
        cos -= 1;
    }
    if cos > 0 { cos } else { -32767 }
}

/// Cells of one update: a box around them and a cone around their normals.
#[derive(Clone, Copy)]
pub(crate) struct Cells {
    min: Vec3,
    max: Vec3,
    axis: Vec3,
    half_angle: f32,
}

impl Cells {
    /// As many triangles as most updates replace and make.
    const MANY: usize = 96;

    /// Of the corners of M⁻ and M⁺.
    #[inline]
    pub fn of(triangles: impl Iterator<Item = [Vec3; 3]>) -> Cells {
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        // Without a call for memory, unless there are many.
        let (mut normals, mut more) = (ArrayVec::<Vec3, { Cells::MANY }>::new(), vec![]);
        for [a, b, c] in triangles {
            (min, max) = (min.min(a).min(b).min(c), max.max(a).max(b).max(c));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            if normal != Vec3::ZERO
                && let Err(rest) = normals.try_push(normal)
            {
                more.push(rest.element());
            }
        }
        let all = normals.iter().chain(&more);
        let axis = all.clone().sum::<Vec3>().normalize_or(Vec3::Z);
        let cos = all.map(|n| n.dot(axis)).fold(1.0, f32::min);
        Cells { min, max, axis, half_angle: if cos <= 0.0 { PI } else { cos.acos() } }
    }
}

/// An update's own share of [`TriangleModel::cost`](crate::TriangleModel::cost), where M⁻ is the star of a vertex s: squared
/// distance of s from the planes of M⁺, times their areas.
pub(crate) fn step_cost(s: Vec3, fine: impl Iterator<Item = [Vec3; 3]>) -> f32 {
    fine.map(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        let along = normal.dot(s - a);
        let length = normal.length();
        if length > 0.0 { along * along / length } else { 0.0 }
    })
    .sum()
}

impl Frame {
    /// The footprint that holds an update's own cells and the footprints of its children, as they are after packing, so
    /// that what criteria see nests.
    pub fn nest(&self, error: f32, own: &Cells, children: impl Iterator<Item = Footprint> + Clone) -> PackedFootprint {
        let (mut min, mut max) = (own.min, own.max);
        let mut axis = own.axis;
        let mut culls = own.half_angle < FRAC_PI_2;
        for f in children.clone() {
            (min, max) = (min.min(f.center - f.radius), max.max(f.center + f.radius));
            axis += f.cone.axis;
            culls &= f.cone.cos > 0.0;
        }
        let radius_at = |center: Vec3| {
            let corner = (own.min - center).abs().max((own.max - center).abs()).length();
            children.clone().fold(corner, |radius, f| radius.max(center.distance(f.center) + f.radius))
        };
        let angle_at = |axis: Vec3| {
            if !culls {
                return PI;
            }
            let own = angle_between(axis, own.axis) + own.half_angle;
            children.clone().fold(own, |angle, f| angle.max(angle_between(axis, f.cone.axis) + half_angle(&f.cone)))
        };
        self.pack(error, (min + max) * 0.5, axis.normalize_or(Vec3::Z), radius_at, angle_at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_only_grows() {
        let frame = Frame::new(Bounds { min: Vec3::splat(-3.0), max: Vec3::new(5.0, 1.0, 2.0) });
        let mut seed = 1u64;
        let mut random = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed % 20001) as f32 / 10000.0 - 1.0
        };
        for _ in 0..1000 {
            let center =
                Vec3::new(random() * 4.0 + 1.0, random() * 2.0 - 1.0, random() * 2.0).clamp(frame.min, frame.max);
            let radius = random().abs() * 2.0;
            let axis = Vec3::new(random(), random(), random() + 1e-3).normalize();
            let half = random().abs() * 1.2;
            let packed =
                frame.pack(1.0, center, axis, |c| c.distance(center) + radius, |a| angle_between(a, axis) + half);
            let f = frame.unpack(&packed);
            assert!(f.center.distance(center) + radius <= f.radius);
            if f.cone.cos > 0.0 {
                assert!(angle_between(f.cone.axis, axis) + half <= half_angle(&f.cone));
                assert_eq!(pack_angle(half_angle(&f.cone)), packed.cos);
                assert!((f.cone.sin * f.cone.sin + f.cone.cos * f.cone.cos - 1.0).abs() < 1e-5);
            }
            // Loose by no more than the packing: half a grid step and one part in 128.
            assert!(f.radius <= (radius + frame.step) * 1.01 + 1e-6);
        }
    }
}
