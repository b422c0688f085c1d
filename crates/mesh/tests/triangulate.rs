//! Triangulations looked at as plane geometry.

use std::collections::HashMap;

use glam::{DVec2, Quat, Vec2, Vec3};
use meshfront_mesh::triangulate::Triangulator;
use proptest::prelude::*;

fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a) / 2.0
}

/// Triangulates a polygon laid into space and checks the result in its plane: as many triangles as there must be, none
/// turned over, sides covered once, inner edges twice in opposite directions, areas that add up.
fn check(outline: &[Vec2], rotation: Quat, allow_flat: bool) {
    let points: Vec<Vec3> = outline.iter().map(|p| rotation * p.extend(0.25)).collect();
    let triangles = Triangulator::default().triangulate(&points).to_vec();
    let n = outline.len();
    assert_eq!(triangles.len(), n - 2);
    let p = |i: u32| outline[i as usize].as_dvec2();
    let whole: f64 = (0..n as u32).map(|i| p(i).perp_dot(p((i + 1) % n as u32)) / 2.0).sum();
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut sum = 0.0;
    for &[a, b, c] in &triangles {
        let part = area(p(a), p(b), p(c)) * whole.signum();
        if !allow_flat {
            assert!(part > 0.0, "{triangles:?} of {outline:?}: {part}");
        }
        sum += part.abs();
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    assert!((sum - whole.abs()).abs() < 1e-5 * whole.abs(), "areas {sum} of {}", whole.abs());
    for i in 0..n as u32 {
        assert_eq!(edges.remove(&(i, (i + 1) % n as u32)), Some(1), "side {i} of {triangles:?}");
    }
    for (&(a, b), &count) in &edges {
        assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b} of {triangles:?}");
    }
}

fn outline(points: &[[i32; 2]]) -> Vec<Vec2> {
    points.iter().map(|&[x, y]| Vec2::new(x as f32, y as f32)).collect()
}

#[test]
fn concave_quads_are_cut_at_their_dent() {
    for turn in 0..4 {
        let mut dart = outline(&[[0, 0], [4, 0], [1, 1], [0, 4]]);
        dart.rotate_left(turn);
        check(&dart, Quat::IDENTITY, false);
        dart.reverse();
        check(&dart, Quat::from_rotation_x(1.0), false);
    }
}

#[test]
fn combs_spirals_slits_and_straight_sides() {
    let flat = Quat::IDENTITY;
    check(
        &outline(&[[0, 0], [9, 0], [9, 5], [7, 1], [6, 5], [5, 1], [4, 5], [3, 1], [2, 5], [1, 1], [0, 5]]),
        flat,
        false,
    );
    check(
        &outline(&[
            [0, 0],
            [9, 0],
            [9, 9],
            [1, 9],
            [1, 3],
            [6, 3],
            [6, 6],
            [3, 6],
            [3, 5],
            [5, 5],
            [5, 4],
            [2, 4],
            [2, 8],
            [8, 8],
            [8, 1],
            [0, 1],
        ]),
        flat,
        false,
    );
    // A square with corners in the middle of its sides: all eight are kept, no triangle is flat.
    check(&outline(&[[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]), flat, false);
    // A triangle with many corners on one side.
    check(&outline(&[[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [0, 4]]), flat, false);
    // A square ring, joined to its hole by a bridge that is walked twice.
    let ring = outline(&[[0, 0], [6, 0], [6, 6], [0, 6], [0, 0], [2, 2], [2, 4], [4, 4], [4, 2], [2, 2]]);
    let points: Vec<Vec3> = ring.iter().map(|p| p.extend(0.0)).collect();
    let triangles = Triangulator::default().triangulate(&points).to_vec();
    let parts = triangles.iter().map(|t| {
        let [a, b, c] = t.map(|i| ring[i as usize].as_dvec2());
        area(a, b, c)
    });
    assert!(parts.clone().all(|a| a > 0.0));
    assert_eq!(parts.sum::<f64>(), 36.0 - 4.0);
}

#[test]
fn hopeless_polygons_give_the_right_number_of_triangles() {
    let mut triangulator = Triangulator::default();
    assert!(triangulator.triangulate(&[]).is_empty());
    assert!(triangulator.triangulate(&[Vec3::X; 2]).is_empty());
    assert_eq!(triangulator.triangulate(&[Vec3::X; 7]).len(), 5);
    let line: Vec<Vec3> = (0..9).map(|i| Vec3::splat(i as f32)).collect();
    assert_eq!(triangulator.triangulate(&line).len(), 7);
    // A star that crosses itself.
    let star: Vec<Vec3> = (0..5).map(|i| Quat::from_rotation_z(i as f32 * 2.513_274) * Vec3::X).collect();
    assert_eq!(triangulator.triangulate(&star).len(), 3);
}

/// Thousands of corners that cross each other everywhere end in bounded time: this test would hang otherwise.
#[test]
fn a_huge_tangle_ends() {
    let tangle: Vec<Vec3> = (0..30_000u64)
        .map(|i| {
            let h = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            Vec3::new((h >> 40) as f32, (h >> 20 & 0xfffff) as f32, 0.0)
        })
        .collect();
    assert_eq!(Triangulator::default().triangulate(&tangle).len(), tangle.len() - 2);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Star-shaped outlines of any raggedness, anywhere in space, turning either way.
    #[test]
    fn star_shaped_polygons(
        radii in prop::collection::vec(0.2f32..3.0, 5..90),
        axis in (-1f32..1.0, -1f32..1.0, 0.1f32..1.0),
        angle in 0f32..6.0,
        reverse in any::<bool>(),
    ) {
        let n = radii.len() as f32;
        let mut outline: Vec<Vec2> =
            radii.iter().enumerate().map(|(i, &r)| r * Vec2::from_angle(i as f32 / n * std::f32::consts::TAU)).collect();
        if reverse {
            outline.reverse();
        }
        let axis = Vec3::new(axis.0, axis.1, axis.2).normalize();
        check(&outline, Quat::from_axis_angle(axis, angle), false);
    }
}
