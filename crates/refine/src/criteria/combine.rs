//! Criteria made of criteria.

use crate::{Criterion, Fingerprint, Footprint, Pose};

/// The larger of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Max<A, B>(pub A, pub B);

/// The smaller of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Min<A, B>(pub A, pub B);

/// The maximum of scores. Above the tolerance as long as one part is; below it as long as both are.
#[inline]
pub(super) fn max_score(a: (f32, f32), b: (f32, f32), tolerance: f32) -> (f32, f32) {
    let slack = match (a.0 > tolerance, b.0 > tolerance) {
        (true, true) => a.1.max(b.1),
        (true, false) => a.1,
        (false, true) => b.1,
        (false, false) => a.1.min(b.1),
    };
    (a.0.max(b.0), slack)
}

/// The minimum of scores: the dual.
#[inline]
pub(super) fn min_score(a: (f32, f32), b: (f32, f32), tolerance: f32) -> (f32, f32) {
    let slack = match (a.0 > tolerance, b.0 > tolerance) {
        (true, true) => a.1.min(b.1),
        (true, false) => b.1,
        (false, true) => a.1,
        (false, false) => a.1.max(b.1),
    };
    (a.0.min(b.0), slack)
}

impl<A: Criterion, B: Criterion> Criterion for Max<A, B> {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        self.0.pixels(f).max(self.1.pixels(f))
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        max_score(self.0.score(f, tolerance), self.1.score(f, tolerance), tolerance)
    }
    fn pose(&self) -> Pose {
        Pose::new(Fingerprint::of("max")).and(self.0.pose()).and(self.1.pose())
    }
}

impl<A: Criterion, B: Criterion> Criterion for Min<A, B> {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        self.0.pixels(f).min(self.1.pixels(f))
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        min_score(self.0.score(f, tolerance), self.1.score(f, tolerance), tolerance)
    }
    fn pose(&self) -> Pose {
        Pose::new(Fingerprint::of("min")).and(self.0.pose()).and(self.1.pose())
    }
}

/// A criterion times a factor: twice the factor is half the tolerance. With factor 0 nothing is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale<C> {
    /// What is scaled.
    pub inner: C,
    /// By how much; not negative.
    pub factor: f32,
}

impl<C: Criterion> Criterion for Scale<C> {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        if self.factor > 0.0 { self.inner.pixels(f) * self.factor } else { 0.0 }
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        if self.factor > 0.0 {
            let (pixels, slack) = self.inner.score(f, tolerance / self.factor);
            (pixels * self.factor, slack)
        } else {
            (0.0, f32::INFINITY)
        }
    }
    fn pose(&self) -> Pose {
        Pose::new(Fingerprint::of("scale").f32(self.factor)).and(self.inner.pose())
    }
}

/// Where `switch` lets pass, `inner`; elsewhere the tolerance is `factor` times coarser: what comes into view has
/// something to show at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutsideCoarse<C, S> {
    /// The error.
    pub inner: C,
    /// Usually a [`Frustum`](super::Frustum).
    pub switch: S,
    /// How many times coarser, at least 1.
    pub factor: f32,
}

impl<C: Criterion, S: Criterion> OutsideCoarse<C, S> {
    #[inline]
    fn parts(&self) -> Max<Min<&C, &S>, Scale<&C>> {
        Max(Min(&self.inner, &self.switch), Scale { inner: &self.inner, factor: 1.0 / self.factor.max(1.0) })
    }
}

impl<C: Criterion, S: Criterion> Criterion for OutsideCoarse<C, S> {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        self.parts().pixels(f)
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.parts().slack(f, tolerance)
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        self.parts().score(f, tolerance)
    }
    fn pose(&self) -> Pose {
        self.parts().pose()
    }
}
