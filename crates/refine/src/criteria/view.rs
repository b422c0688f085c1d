//! A camera, and what is worth refining for it.

use super::combine::{max_score, min_score};
use super::{Frustum, Orientation, Scale, ScreenSpace};
use crate::{Criterion, Fingerprint, Footprint, Pose};
use glam::Vec3;

/// A perspective camera, in mesh space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is.
    pub eye: Vec3,
    /// What it looks at.
    pub target: Vec3,
    /// Roughly upwards; need not be unit or perpendicular.
    pub up: Vec3,
    /// Vertical field of view, radians.
    pub fov_y: f32,
    /// Width of the picture, pixels.
    pub width_px: f32,
    /// Height of the picture, pixels.
    pub height_px: f32,
    /// Distance of the near plane, mesh units.
    pub near: f32,
}

impl Camera {
    /// Unit vectors: right, up, forward. A camera that looks nowhere, or along `up`, gets some axes all the same.
    pub fn axes(&self) -> (Vec3, Vec3, Vec3) {
        let forward = (self.target - self.eye).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(self.up).normalize_or(forward.any_orthonormal_vector());
        (right, right.cross(forward), forward)
    }
}

/// What [`view()`] looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewOptions {
    /// Whether what lies outside the picture stays coarse.
    pub frustum: bool,
    /// Whether what faces away stays coarse. Only right for surfaces seen from one side.
    pub orientation: bool,
    /// How many times coarser the tolerance is outside the picture; `None`: nothing is refined there.
    pub outside: Option<f32>,
}

impl Default for ViewOptions {
    fn default() -> ViewOptions {
        ViewOptions { frustum: true, orientation: true, outside: None }
    }
}

/// The usual composition: screen-space error where something can be seen, 0 (or less of it) elsewhere.
///
/// min(orientation, min(frustum, screen space)), or with `outside`
/// min(orientation, max(min(frustum, screen space), screen space / outside)).
pub fn view(camera: &Camera, options: ViewOptions) -> View {
    View {
        screen: ScreenSpace::new(camera.eye, camera.fov_y, camera.height_px, camera.near),
        frustum: options.frustum.then(|| Frustum::new(camera)),
        orientation: options.orientation.then_some(Orientation { eye: camera.eye }),
        outside: options.outside,
    }
}

/// See [`view()`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    screen: ScreenSpace,
    frustum: Option<Frustum>,
    orientation: Option<Orientation>,
    outside: Option<f32>,
}

impl Criterion for View {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        let screen = self.screen.pixels(f);
        let mut pixels = screen;
        if let Some(frustum) = &self.frustum {
            pixels = pixels.min(frustum.pixels(f));
            if let Some(factor) = self.outside {
                pixels = pixels.max(screen * (1.0 / factor.max(1.0)));
            }
        }
        if let Some(orientation) = &self.orientation {
            pixels = pixels.min(orientation.pixels(f));
        }
        pixels
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        let mut score = self.screen.score(f, tolerance);
        if let Some(frustum) = &self.frustum {
            score = min_score(score, frustum.score(f, tolerance), tolerance);
            if let Some(factor) = self.outside {
                let coarse = Scale { inner: &self.screen, factor: 1.0 / factor.max(1.0) };
                score = max_score(score, coarse.score(f, tolerance), tolerance);
            }
        }
        if let Some(orientation) = &self.orientation {
            score = min_score(score, orientation.score(f, tolerance), tolerance);
        }
        score
    }
    fn pose(&self) -> Pose {
        let mut pose = Pose::new(Fingerprint::of("view").f32(self.outside.unwrap_or(0.0))).and(self.screen.pose());
        if let Some(frustum) = &self.frustum {
            pose = pose.and(frustum.pose());
        }
        if let Some(orientation) = &self.orientation {
            pose = pose.and(orientation.pose());
        }
        pose
    }
}
