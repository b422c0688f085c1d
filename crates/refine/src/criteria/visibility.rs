//! Switches: infinite where something of the footprint may be seen, 0 where nothing can be.

use super::{Camera, safe_slack};
use crate::{Criterion, Fingerprint, Footprint, Plane, Pose};
use glam::{Vec3, Vec4};

const SEEN: f32 = f32::INFINITY;

/// Whether the footprint's sphere reaches into the view frustum: outside where, for one plane,
/// a·x + b·y + c·z + d < −r (`hoppe1997`; the lecture's view-frustum criterion).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    eye: Vec3,
    /// The inward normals of left, right, bottom and top: their x, their y and their z, so that four distances are
    /// computed as one.
    sides: [Vec4; 3],
    /// The inward normal of the near plane, and how far from the eye that is.
    forward: Vec3,
    near: f32,
}

impl Frustum {
    /// The frustum of a camera. There is no far plane.
    pub fn new(camera: &Camera) -> Frustum {
        let (right, up, forward) = camera.axes();
        let tan_y = (camera.fov_y / 2.0).tan();
        let tan_x = tan_y * camera.width_px / camera.height_px;
        let side = |inward: Vec3, tan: f32| (inward + forward * tan).normalize_or(forward);
        let sides = [side(right, tan_x), side(-right, tan_x), side(up, tan_y), side(-up, tan_y)];
        let sides = [0, 1, 2].map(|axis| Vec4::from_array(sides.map(|normal| normal[axis])));
        Frustum { eye: camera.eye, sides, forward, near: camera.near }
    }

    /// Left, right, bottom, top and near plane, normals inwards.
    pub fn planes(&self) -> [Plane; 5] {
        let [x, y, z] = self.sides;
        let side = |i: usize| Plane { point: self.eye, normal: Vec3::new(x[i], y[i], z[i]) };
        let near = Plane { point: self.eye + self.forward * self.near, normal: self.forward };
        [side(0), side(1), side(2), side(3), near]
    }

    /// Signed distance of a point from the plane that it is farthest outside of, and the magnitude of what that is
    /// computed from.
    #[inline]
    fn inside(&self, p: Vec3) -> (f32, f32) {
        let v = p - self.eye;
        let [x, y, z] = self.sides;
        let sides = x * v.x + y * v.y + z * v.z;
        (sides.min_element().min(self.forward.dot(v) - self.near), v.abs().max_element() + self.near)
    }
}

impl Criterion for Frustum {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        self.score(f, 0.0).0
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, _: f32) -> (f32, f32) {
        let (inside, scale) = self.inside(f.center);
        let reach = inside + f.radius;
        (if reach < 0.0 { 0.0 } else { SEEN }, safe_slack(reach, 3.0 * scale + f.radius))
    }
    fn pose(&self) -> Pose {
        self.planes().iter().fold(Pose::new(Fingerprint::of("frustum")), |pose, &p| pose.with_plane(p))
    }
}

/// Whether something of the footprint may face the eye.
///
/// The lecture culls a vertex v with normal cone (n, α) where (v − e)·n > 0 and ((v − e)·n)² > |v − e|² sin²α.
/// Here that holds for every place in the sphere and every normal in the cone: with v = c − e, and v split along
/// the axis and across it, the least of (v + s)·n over |s| ≤ r and n in the cone is
/// (v·axis) cos α − |v across| sin α − r; where that is positive, everything faces away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    /// The eye.
    pub eye: Vec3,
}

impl Orientation {
    /// How far behind its own horizon the eye is, and the magnitude of what that is computed from.
    #[inline]
    fn behind(&self, f: &Footprint) -> (f32, f32) {
        let v = f.center - self.eye;
        let along = v.dot(f.cone.axis);
        let across = v.cross(f.cone.axis).length();
        (along * f.cone.cos - across * f.cone.sin - f.radius, along.abs() + across + f.radius)
    }
}

impl Criterion for Orientation {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        self.score(f, 0.0).0
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, _: f32) -> (f32, f32) {
        if f.cone.cos <= 0.0 {
            return (SEEN, f32::INFINITY);
        }
        let (behind, scale) = self.behind(f);
        // Moving past the footprint turns it as much as moving away from it would.
        (if behind > 0.0 { 0.0 } else { SEEN }, safe_slack(behind, scale) / Pose::SIDEWAYS)
    }
    fn pose(&self) -> Pose {
        Pose::new(Fingerprint::of("orientation")).with_point(self.eye)
    }
}
