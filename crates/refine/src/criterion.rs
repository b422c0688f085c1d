//! The criterion: how wrong an update's coarse side looks, and for how long that answer holds.

use crate::Footprint;
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};

/// How many pixels wrong the front looks while an update is not applied. Object-safe.
///
/// *Monotone*: a footprint that lies within another (sphere, cone, error) has no more pixels. Then the updates
/// above a tolerance are a closed set, and all strategies reach the same front. A criterion that is not monotone
/// gives legal fronts, but which one depends on the path.
pub trait Criterion {
    /// How many pixels (or units of error) wrong M⁻ looks.
    fn pixels(&self, f: &Footprint) -> f32;

    /// How far the pose must travel, as seen from the footprint's centre ([`Pose::travel`]), before the truth of
    /// `pixels(f) > tolerance` can change. 0 where unknown: the update is then looked at whenever the pose changes at
    /// all.
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        let _ = (f, tolerance);
        0.0
    }

    /// `pixels` and `slack` at once; the engine's inner loop calls this.
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        (self.pixels(f), self.slack(f, tolerance))
    }

    /// Where the criterion stands, so that a front can tell how far it travelled. Two criteria with equal poses
    /// must give equal pixels.
    fn pose(&self) -> Pose;
}

impl<C: Criterion + ?Sized> Criterion for &C {
    fn pixels(&self, f: &Footprint) -> f32 {
        (**self).pixels(f)
    }
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        (**self).slack(f, tolerance)
    }
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        (**self).score(f, tolerance)
    }
    fn pose(&self) -> Pose {
        (**self).pose()
    }
}

impl<C: Criterion + ?Sized> Criterion for Box<C> {
    fn pixels(&self, f: &Footprint) -> f32 {
        (**self).pixels(f)
    }
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        (**self).slack(f, tolerance)
    }
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        (**self).score(f, tolerance)
    }
    fn pose(&self) -> Pose {
        (**self).pose()
    }
}

/// An oriented plane in mesh space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point on it.
    pub point: Vec3,
    /// Unit normal, towards the inner side.
    pub normal: Vec3,
}

impl Plane {
    /// Signed distance, positive on the inner side.
    #[inline]
    pub fn distance(&self, p: Vec3) -> f32 {
        self.normal.dot(p - self.point)
    }
}

/// Where a criterion stands: what of it moves (points and planes), and a fingerprint of all that does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    points: [Vec3; Pose::POINTS],
    planes: [Plane; Pose::PLANES],
    point_count: u8,
    plane_count: u8,
    fingerprint: Fingerprint,
}

impl Pose {
    /// As many eyes as a composed criterion may have before a move of the others counts as a new setting.
    const POINTS: usize = 4;
    /// Two frusta with near planes, and two planes more.
    const PLANES: usize = 12;
    /// How many times farther than its travel a pose's point may move sideways.
    pub const SIDEWAYS: f32 = 4.0;

    /// A pose in which nothing moves.
    pub fn new(fingerprint: Fingerprint) -> Pose {
        let plane = Plane { point: Vec3::ZERO, normal: Vec3::ZERO };
        Pose {
            points: [Vec3::ZERO; Pose::POINTS],
            planes: [plane; Pose::PLANES],
            point_count: 0,
            plane_count: 0,
            fingerprint,
        }
    }

    /// Adds a point that moves, such as an eye. A point that is there already is not added again.
    pub fn with_point(mut self, p: Vec3) -> Pose {
        let n = self.point_count as usize;
        if self.points[..n].contains(&p) {
        } else if n < Pose::POINTS {
            self.points[n] = p;
            self.point_count += 1;
        } else {
            self.fingerprint = self.fingerprint.vec3(p);
        }
        self
    }

    /// Adds a plane that moves.
    pub fn with_plane(mut self, p: Plane) -> Pose {
        let n = self.plane_count as usize;
        if n < Pose::PLANES {
            self.planes[n] = p;
            self.plane_count += 1;
        } else {
            self.fingerprint = self.fingerprint.vec3(p.point).vec3(p.normal);
        }
        self
    }

    /// The pose of a criterion made of two.
    pub fn and(mut self, other: Pose) -> Pose {
        self.fingerprint = self.fingerprint.word(other.fingerprint.0);
        let points = other.points[..other.point_count as usize].iter();
        let planes = other.planes[..other.plane_count as usize].iter();
        planes.fold(points.fold(self, |pose, &p| pose.with_point(p)), |pose, &p| pose.with_plane(p))
    }

    /// Adds a setting to the fingerprint.
    pub fn with_setting(mut self, value: f32) -> Pose {
        self.fingerprint = self.fingerprint.f32(value);
        self
    }

    /// How far the pose moved since `before`, as seen by what lies in a ball. `None` where the two differ in more
    /// than motion.
    ///
    /// For every place in the ball neither its distance to any of the points nor its signed distance to any of the
    /// planes changed by more than the travel, and no point moved by more than [`Pose::SIDEWAYS`] times the
    /// travel. Along a path travels add up, so a function of the distance to a point, or to a plane, with Lipschitz
    /// constant 1 has a slack of its distance from zero; a function of where the point is, a quarter of that.
    pub fn travel(&self, before: &Pose, center: Vec3, radius: f32) -> Option<f64> {
        self.travels(before).map(|travels| travels.seen_from(center, radius))
    }

    /// The same for many places.
    pub(crate) fn travels(&self, before: &Pose) -> Option<Travels> {
        if (self.fingerprint, self.point_count, self.plane_count)
            != (before.fingerprint, before.point_count, before.plane_count)
        {
            return None;
        }
        let mut travels = Travels { points: ArrayVec::new(), planes: ArrayVec::new() };
        for (now, then) in self.points.iter().zip(&before.points).take(self.point_count as usize) {
            let (now, then) = (now.as_dvec3(), then.as_dvec3());
            travels.points.push([then, now - then]);
        }
        for (now, then) in self.planes.iter().zip(&before.planes).take(self.plane_count as usize) {
            let (n, m) = (now.normal.as_dvec3(), then.normal.as_dvec3());
            let offset = m.dot(then.point.as_dvec3()) - n.dot(now.point.as_dvec3());
            travels.planes.push((n - m, offset, (n - m).length()));
        }
        let numbers = travels.points.iter().flatten().chain(travels.planes.iter().map(|(turn, ..)| turn));
        (numbers.fold(0.0, |sum, v| sum + v.length_squared()).is_finite()
            && travels.planes.iter().all(|(_, offset, _)| offset.is_finite()))
        .then_some(travels)
    }
}

/// From one pose to another.
pub(crate) struct Travels {
    /// Where each point was, and its step.
    points: ArrayVec<[DVec3; 2], { Pose::POINTS }>,
    /// By how much the distance from each plane changes: a part that depends on the place, one that does not, and the length of the
    /// first.
    planes: ArrayVec<(DVec3, f64, f64), { Pose::PLANES }>,
}

impl Travels {
    /// See [`Pose::travel`].
    pub fn seen_from(&self, center: Vec3, radius: f32) -> f64 {
        let (center, radius) = (center.as_dvec3(), radius as f64);
        let mut far = 0f64;
        for &[then, step] in &self.points {
            far = far.max(approach(then, step, center, radius));
        }
        for &(turn, offset, length) in &self.planes {
            far = far.max((turn.dot(center) + offset).abs() + radius * length);
        }
        far * (1.0 + 1e-9)
    }
}

/// By how much the distance between a point that moves by `step` and any place of a ball may change, but no
/// less than a share of the step.
///
/// The distance to a place changes by the part of the step that is along the line to it. All those lines lie in a
/// cone around the line to the centre; its half angle b is that of the ball, widened by the step, as seen from
/// the point. At an angle a between step and axis that is at most |step| cos(a − b).
fn approach(from: DVec3, step: DVec3, center: DVec3, radius: f64) -> f64 {
    let length = step.length();
    let axis = center - from;
    let distance = axis.length();
    let sin_b = (radius + length) / distance;
    if length == 0.0 || sin_b >= 1.0 || sin_b.is_nan() {
        return length;
    }
    let cos_a = (axis.dot(step).abs() / (distance * length)).min(1.0);
    let sin_a = (1.0 - cos_a * cos_a).sqrt();
    let cos_b = (1.0 - sin_b * sin_b).sqrt();
    let along = if sin_a <= sin_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b };
    length * along.max(1.0 / Pose::SIDEWAYS as f64)
}

/// A hash of the settings that a criterion does not count as motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(u64);

impl Fingerprint {
    /// Starts with the kind of criterion.
    pub fn of(kind: &str) -> Fingerprint {
        kind.bytes().fold(Fingerprint(0xcbf2_9ce4_8422_2325), |f, b| f.word(b as u64))
    }
    /// Adds a number.
    pub fn f32(self, value: f32) -> Fingerprint {
        self.word(value.to_bits() as u64)
    }
    /// Adds a vector.
    pub fn vec3(self, v: Vec3) -> Fingerprint {
        self.f32(v.x).f32(v.y).f32(v.z)
    }
    /// Adds 64 bits.
    pub fn word(self, bits: u64) -> Fingerprint {
        // Murmur's finalizer: every bit of the word reaches every bit of the hash.
        let mut x = self.0.rotate_left(27) ^ bits.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        Fingerprint(x ^ (x >> 33))
    }
}
