//! How far vertices travel: the cheapest metric that says something of the surface.

use super::{End, Metric};
use glam::Vec3;

/// Merged vertices go to the middle of the least ball around what both stand for; the cost is the square of its radius, which
/// bounds how far any vertex of the source was moved.
#[derive(Clone, Copy, Debug)]
pub struct Length;

impl Metric for Length {
    /// Radius of a ball around all vertices of the source that it stands for.
    type Memory = f32;

    fn leaf(&self, _: Vec3, _: &[[Vec3; 2]], _: &[[Vec3; 2]]) -> f32 {
        0.0
    }
    fn best(&self, u: End<f32>, v: End<f32>) -> Vec3 {
        let length = u.at.distance(v.at);
        let along = 0.5 + 0.5 * (v.memory - u.memory) / length.max(f32::MIN_POSITIVE);
        u.at.lerp(v.at, along.clamp(0.0, 1.0))
    }
    fn cost(&self, u: End<f32>, v: End<f32>, at: Vec3) -> f32 {
        self.merged(u, v, at).powi(2)
    }
    fn merged(&self, u: End<f32>, v: End<f32>, at: Vec3) -> f32 {
        (u.memory + u.at.distance(at)).max(v.memory + v.at.distance(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_holds_both_and_is_the_least() {
        let (u, v) = (End { at: Vec3::ZERO, memory: 1.0 }, End { at: Vec3::X * 4.0, memory: 2.0 });
        let at = Length.best(u, v);
        assert!(at.distance(Vec3::X * 2.5) < 1e-6);
        assert!((Length.merged(u, v, at) - 3.5).abs() < 1e-6);
        let inside = End { at: Vec3::X * 0.25, memory: 0.5 };
        assert_eq!(Length.best(u, inside), u.at);
        assert_eq!(Length.cost(u, inside, u.at), 1.0);
    }
}
