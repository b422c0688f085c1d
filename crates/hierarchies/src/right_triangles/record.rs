//! What is kept of a sample, in twelve bytes.

use crate::quantize::{of_upper_half, upper_half};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;

/// Rounds to the safe side: errors, spheres and cones only grow by packing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Record {
    /// Mesh units.
    pub height: f32,
    /// Upper halves of `f32`, rounded up.
    error: u16,
    radius: u16,
    /// From the low end: the sample's normal (octahedral, 11 bits each), which triangles of M⁻ are there (2), the half
    /// angle of the cone around that normal (8).
    packed: u32,
}

/// Steps of a half angle up to a right angle; one more stands for all directions.
const ANGLES: f32 = 254.0;

impl Record {
    pub fn new(height: f32, normal: Vec3, sides: [bool; 2]) -> Record {
        Record { height, error: 0, radius: 0, packed: pack_normal(normal) | pack_sides(sides) << 22 }
    }
    /// Of a sample that is missing.
    pub fn missing() -> Record {
        Record { height: f32::NAN, ..Record::default() }
    }
    /// What is found out about a sample from those below it.
    pub fn measured(self, error: f32, radius: f32, half_angle: f32) -> Record {
        // Rounded up, and up to the next step where it is one: roots were rounded too.
        let angle = if half_angle >= FRAC_PI_2 { 255 } else { (half_angle * (ANGLES / FRAC_PI_2)) as u32 + 1 };
        Record {
            error: upper_half(error),
            // A relative 1e-6 covers the rounding of the additions that checked containment.
            radius: upper_half(radius * (1.0 + 1e-6)),
            packed: self.packed & 0xff_ffff | angle.min(255) << 24,
            ..self
        }
    }

    #[inline]
    pub fn error(&self) -> f32 {
        of_upper_half(self.error)
    }
    #[inline]
    pub fn radius(&self) -> f32 {
        of_upper_half(self.radius)
    }
    /// The sample's normal, of any length.
    #[inline]
    pub fn direction(&self) -> Vec3 {
        let [x, y] = [self.packed & 0x7ff, self.packed >> 11 & 0x7ff].map(|c| c as f32 * (2.0 / 2046.0) - 1.0);
        // Terrain's normals point up: nothing is ever folded under the octahedron.
        Vec3::new(x, y, (1.0 - x.abs() - y.abs()).max(1e-4))
    }
    /// Unit vector.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.direction().normalize()
    }
    /// Which triangles of M⁻ are there; none: there is no update.
    #[inline]
    pub fn sides(&self) -> [bool; 2] {
        [self.packed >> 22 & 1 == 1, self.packed >> 23 & 1 == 1]
    }
    #[inline]
    pub fn is_update(&self) -> bool {
        self.packed >> 22 & 3 != 0
    }
    /// Radians; `None`: all directions.
    #[inline]
    pub fn half_angle(&self) -> Option<f32> {
        let angle = self.packed >> 24;
        (angle < 255).then(|| angle as f32 * (FRAC_PI_2 / ANGLES))
    }
    /// Where the half angle is in [`cones`].
    #[inline]
    pub fn cone(&self) -> usize {
        self.packed as usize >> 24
    }
}

/// Sine and cosine of each half angle.
pub(super) fn cones() -> Vec<[f32; 2]> {
    let angle = |i: u32| i as f32 * (FRAC_PI_2 / ANGLES);
    (0..255).map(|i| [angle(i).sin(), angle(i).cos()]).chain([[0.0, -1.0]]).collect()
}

fn pack_sides([first, second]: [bool; 2]) -> u32 {
    u32::from(first) | u32::from(second) << 1
}

fn pack_normal(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let [x, y] = [n.x, n.y].map(|c| ((c * 0.5 + 0.5) * 2046.0 + 0.5) as u32);
    x | y << 11
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_only_grows_and_keeps_normals() {
        assert_eq!(size_of::<Record>(), 12);
        for i in 0..500 {
            let (a, slope) = (i as f32 * 0.7, (i % 50) as f32 * 0.1);
            let normal = Vec3::new(a.cos() * slope, a.sin() * slope, 1.0).normalize();
            let record = Record::new(-1.5, normal, [true, i % 2 == 0]);
            assert!(record.normal().distance(normal) < 2.5e-3);
            let (error, radius, angle) = (slope * 1e-3, slope * 37.1, slope * 0.3);
            let packed = record.measured(error, radius, angle);
            assert_eq!((packed.height, packed.sides(), packed.normal()), (-1.5, [true, i % 2 == 0], record.normal()));
            assert!((error..=error * 1.01).contains(&packed.error()));
            assert!((radius..=radius * 1.01).contains(&packed.radius()));
            match packed.half_angle() {
                Some(packed) => assert!((angle - 1e-6..angle + 0.01).contains(&packed)),
                None => assert!(angle >= FRAC_PI_2 - 0.01),
            }
        }
    }
}
