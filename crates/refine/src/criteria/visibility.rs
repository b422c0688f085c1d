//! Switches: infinite where something of the footprint may be seen, 0 where nothing can be.

use super::{Camera, safe_slack};
use crate::{Criterion, Fingerprint, Footprint, Plane, Pose};
use glam::Vec3;

const SEEN: f32 = f32::INFINITY;

/// Whether the footprint's sphere reaches into the view frustum: outside where, for one plane,
/// a·x + b·y + c·z + d < −r (`hoppe1997`; the lecture's view-frustum criterion).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Left, right, bottom, top and near plane, normals inwards. There is no far plane.
    pub planes: [Plane; 5],
}

impl Frustum {
    /// The frustum of a camera.
    pub fn new(camera: &Camera) -> Frustum {
        let (right, up, forward) = camera.axes();
        let tan_y = (camera.fov_y / 2.0).tan();
        let tan_x = tan_y * camera.width_px / camera.height_px;
        let side = |inward: Vec3, tan: f32| Plane {
            point: camera.eye,
            normal: (inward + forward * tan).normalize_or(forward),
        };
        let near = Plane { point: camera.eye + forward * camera.near, normal: forward };
        Frustum { planes: [side(right, tan_x), side(-right, tan_x), side(up, tan_y), side(-up, tan_y), near] }
    }
}

impl Criterion for Frustum {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        if self.planes.iter().any(|p| p.distance(f.center) < -f.radius) { 0.0 } else { SEEN }
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, _: f32) -> (f32, f32) {
        // The plane that the sphere is farthest outside of decides, both ways.
        let (mut pixels, mut least, mut scale) = (SEEN, f32::INFINITY, 0f32);
        for p in &self.planes {
            let distance = p.distance(f.center);
            if distance < -f.radius {
                pixels = 0.0;
            }
            least = least.min(distance + f.radius);
            scale = scale.max((f.center - p.point).abs().max_element());
        }
        (pixels, safe_slack(least, 3.0 * scale + f.radius))
    }
    fn pose(&self) -> Pose {
        self.planes.iter().fold(Pose::new(Fingerprint::of("frustum")), |pose, &p| pose.with_plane(p))
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
