//! Footprints in 16 bytes: what a criterion reads is one quarter of a cache line.

use super::Oct;
use glam::Vec3;
use meshfront_mesh::Bounds;
use meshfront_refine::{Footprint, NormalCone};
use std::f32::consts::{FRAC_PI_2, PI};

/// Everything rounds to the safe side: spheres and cones only grow by packing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PackedFootprint {
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
pub(super) struct Frame {
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
        let radius = radius_at(self.point(center)) * (1.0 + 1e-6);
        let bits = radius.to_bits();
        let radius = ((bits >> 16) + u32::from(bits & 0xffff != 0)) as u16;
        let axis = Oct::encode(axis).0.map(|c| ((c as f32) * (127.0 / 32767.0)).round() as i8);
        PackedFootprint { error, center, radius, axis, cos: pack_angle(angle_at(unpack_axis(axis))) }
    }

    #[inline]
    pub fn unpack(&self, f: &PackedFootprint) -> Footprint {
        let cos = f.cos as f32 / 32767.0;
        Footprint {
            center: self.point(f.center),
            radius: f32::from_bits((f.radius as u32) << 16),
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
pub(super) fn half_angle(cone: &NormalCone) -> f32 {
    if cone.cos <= 0.0 { PI } else { cone.cos.min(1.0).acos() }
}

/// The angle between two unit vectors, accurate for small angles too.
pub(super) fn angle_between(a: Vec3, b: Vec3) -> f32 {
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
