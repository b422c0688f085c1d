//! Each criterion against points, normals and matrices that know nothing of its formula; and slack against motion.

use glam::camera::rh::{proj::directx::perspective_infinite_reverse, view::look_at_mat4};
use glam::{Quat, Vec3, vec3};
use meshfront_refine::criteria::{
    Frustum, Max, Min, Orientation, OutsideCoarse, Region, Scale, ScreenSpace, Shape, Uniform,
};
use meshfront_refine::{Camera, Criterion, Footprint, NormalCone, ViewOptions, view};
use proptest::prelude::*;

fn unit() -> impl Strategy<Value = Vec3> {
    (-1f32..1.0, 0f32..std::f32::consts::TAU).prop_map(|(z, a)| {
        let s = (1.0 - z * z).sqrt();
        vec3(s * a.cos(), s * a.sin(), z)
    })
}
fn place(span: f32) -> impl Strategy<Value = Vec3> {
    (-span..span, -span..span, -span..span).prop_map(Vec3::from)
}
/// Sizes from a speck to everything.
fn size() -> impl Strategy<Value = f32> {
    (-5f32..1.5).prop_map(|e| 10f32.powf(e))
}
fn footprint() -> impl Strategy<Value = Footprint> {
    (place(10.0), size(), size(), unit(), 0f32..2.0).prop_map(|(center, radius, error, axis, angle)| Footprint {
        center,
        radius,
        error: error * 0.01,
        cone: NormalCone { axis, sin: angle.sin(), cos: angle.cos() },
    })
}
fn camera() -> impl Strategy<Value = Camera> {
    (place(15.0), place(10.0), unit(), 0.2f32..2.0, 0.5f32..2.0).prop_map(|(eye, target, up, fov_y, aspect)| Camera {
        eye,
        target,
        up,
        fov_y,
        width_px: 800.0 * aspect,
        height_px: 800.0,
        near: 0.05,
    })
}
/// Places of a ball and its rim.
fn in_ball(c: Vec3, r: f32) -> impl Iterator<Item = Vec3> {
    (0..400).map(move |i| {
        let (z, a) = (1.0 - 2.0 * (i as f32 + 0.5) / 400.0, i as f32 * 2.399_963_2);
        let s = (1.0 - z * z).sqrt();
        c + r * [1.0, 0.999, 0.6][i % 3] * vec3(s * a.cos(), s * a.sin(), z)
    })
}

/// One of many criteria, as a function of where the camera is.
fn criterion(kind: usize, camera: &Camera) -> Box<dyn Criterion> {
    let screen = ScreenSpace::new(camera.eye, camera.fov_y, camera.height_px, camera.near);
    let frustum = Frustum::new(camera);
    let orientation = Orientation { eye: camera.eye };
    let shape = if kind.is_multiple_of(2) {
        Shape::Sphere { center: Vec3::ONE, radius: 3.0 }
    } else {
        Shape::Box { min: Vec3::splat(-4.0), max: vec3(1.0, 2.0, 6.0) }
    };
    match kind {
        0 => Box::new(screen),
        1 => Box::new(frustum),
        2 => Box::new(orientation),
        3 => Box::new(Min(screen, frustum)),
        4 => Box::new(Max(Min(screen, orientation), Scale { inner: screen, factor: 0.1 })),
        5 => Box::new(OutsideCoarse { inner: screen, switch: frustum, factor: 6.0 }),
        6 => Box::new(view(camera, ViewOptions::default())),
        7 => Box::new(view(camera, ViewOptions { outside: Some(4.0), ..ViewOptions::default() })),
        8 | 9 => Box::new(Region { shape, inside: screen, outside: Scale { inner: screen, factor: 0.1 } }),
        10 => Box::new(Region { shape, inside: Scale { inner: screen, factor: 0.1 }, outside: screen }),
        _ => Box::new(Max(Scale { inner: Uniform, factor: 100.0 }, Scale { inner: screen, factor: 0.0 })),
    }
}
const KINDS: usize = 12;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn truth_holds_while_the_travel_is_less_than_the_slack(
        f in footprint(), start in camera(), kind in 0..KINDS, tolerance in size(),
        moves in prop::collection::vec((unit(), unit(), 0f32..1.0, 0u8..4), 1..8)
    ) {
        let first = criterion(kind, &start);
        let wanted = first.pixels(&f) > tolerance;
        let slack = first.slack(&f, tolerance);
        prop_assert_eq!(first.score(&f, tolerance).1, slack);
        prop_assert_eq!(first.score(&f, tolerance).0, first.pixels(&f));
        prop_assert!(slack >= 0.0);
        let (mut camera, mut travelled, mut pose) = (start, 0f64, first.pose());
        for (direction, axis, amount, way) in moves {
            let mut next = camera;
            let left = slack.min(30.0) - travelled as f32;
            // Straight to where the answer changes, or anywhere; with or without a turn.
            let away = (camera.eye - f.center).normalize_or(Vec3::X);
            next.eye += left * amount * match way { 0 => away, 1 => -away, _ => direction };
            let turn = Quat::from_axis_angle(axis, if way == 3 { left * amount * 0.1 } else { 0.0 });
            next.target = next.eye + turn * (camera.target - camera.eye);
            next.up = turn * camera.up;
            let there = criterion(kind, &next);
            let step = there.pose().travel(&pose, f.center, 0.0).expect("only moved");
            if travelled + step >= slack as f64 {
                break;
            }
            prop_assert_eq!(there.pixels(&f) > tolerance, wanted, "after {} of {}", travelled + step, slack);
            (camera, travelled, pose) = (next, travelled + step, there.pose());
        }
    }

    #[test]
    fn travel_is_no_less_than_what_any_place_of_the_ball_sees(
        a in camera(), b in camera(), small in any::<bool>(), c in place(10.0), r in size()
    ) {
        let b = if small { Camera { eye: a.eye + b.eye * 0.01, target: a.target + b.target * 0.01, fov_y: a.fov_y, up: a.up, ..a } } else { b };
        let (f, g) = (Frustum::new(&a), Frustum::new(&b));
        let pose = |camera: &Camera| Min(ScreenSpace::new(camera.eye, 1.0, 1.0, 0.1), Frustum::new(camera)).pose();
        let travel = pose(&b).travel(&pose(&a), c, r).expect("only moved") as f32;
        let mut seen = a.eye.distance(b.eye) / 4.0;
        for p in in_ball(c, r).chain([c, c + (b.eye - a.eye).normalize_or(Vec3::X) * r, c + (a.eye - c).normalize() * r]) {
            seen = seen.max((p.distance(a.eye) - p.distance(b.eye)).abs());
            for (f, g) in f.planes().iter().zip(&g.planes()) {
                seen = seen.max((f.distance(p) - g.distance(p)).abs());
            }
        }
        prop_assert!(travel >= seen - 1e-4, "{travel} {seen}");
        prop_assert!(!small || travel <= seen * 3.0 + 0.1, "idly far: {travel} {seen}");
    }

    #[test]
    fn a_footprint_within_another_has_no_more_pixels(
        outer in footprint(), camera in camera(), kind in 0..KINDS, at in unit(), tilt in unit(), k in prop::array::uniform4(0f32..1.0)
    ) {
        let inner_radius = outer.radius * k[0];
        let half = outer.cone.sin.atan2(outer.cone.cos);
        let angle = half * k[1];
        let axis = Quat::from_axis_angle(outer.cone.axis.cross(tilt).normalize_or(outer.cone.axis.any_orthonormal_vector()), (half - angle) * 0.999) * outer.cone.axis;
        let inner = Footprint {
            center: outer.center + at * (outer.radius - inner_radius) * k[2] * 0.9999,
            radius: inner_radius,
            error: outer.error * k[3],
            cone: NormalCone { axis: axis.normalize(), sin: (angle * 0.999).sin(), cos: (angle * 0.999).cos() },
        };
        let c = criterion(kind, &camera);
        prop_assert!(c.pixels(&inner) <= c.pixels(&outer) * 1.00001);
    }

    #[test]
    fn the_frustum_keeps_what_a_matrix_puts_into_the_picture(f in footprint(), camera in camera()) {
        let aspect = camera.width_px / camera.height_px;
        let project = perspective_infinite_reverse(camera.fov_y, aspect, camera.near)
            * look_at_mat4(camera.eye, camera.target, camera.up);
        let seen = Frustum::new(&camera).pixels(&f) > 0.0;
        let clips: Vec<_> = in_ball(f.center, f.radius).map(|p| project * p.extend(1.0)).collect();
        let in_picture = clips.iter().any(|c| c.x.abs() <= c.w && c.y.abs() <= c.w && c.w >= camera.near);
        prop_assert!(seen || !in_picture);
        // All on the outer side of one plane, with a margin for the samples' gaps.
        let margin = 0.15 * f.radius + 1e-3;
        let scale = (camera.fov_y / 2.0).tan();
        let beyond = |g: &dyn Fn(&glam::Vec4) -> f32| clips.iter().all(|c| g(c) < -margin);
        let outside = beyond(&|c| (c.w + c.x) * scale * aspect / (1.0 + (scale * aspect).powi(2)).sqrt())
            || beyond(&|c| (c.w - c.x) * scale * aspect / (1.0 + (scale * aspect).powi(2)).sqrt())
            || beyond(&|c| (c.w + c.y) * scale / (1.0 + scale * scale).sqrt())
            || beyond(&|c| (c.w - c.y) * scale / (1.0 + scale * scale).sqrt())
            || beyond(&|c| c.w - camera.near);
        prop_assert!(!(seen && outside));
    }

    #[test]
    fn orientation_culls_where_every_normal_of_the_cone_faces_away(f in footprint(), eye in place(15.0)) {
        let seen = Orientation { eye }.pixels(&f) > 0.0;
        let half = f.cone.sin.atan2(f.cone.cos);
        if half >= std::f32::consts::FRAC_PI_2 {
            prop_assert!(seen);
            return Ok(());
        }
        // Normals on the cone's rim and within it, seen at the place of the ball that is most in their favour.
        let across = f.cone.axis.any_orthonormal_vector();
        let least = (0..720).map(|i| {
            let tilted = Quat::from_axis_angle(across, half * [1.0, 0.5][i % 2]) * f.cone.axis;
            let n = Quat::from_axis_angle(f.cone.axis, i as f32 * 0.008_726_646) * tilted;
            (f.center - n * f.radius - eye).dot(n)
        }).fold(f32::INFINITY, f32::min);
        let margin = 1e-3 * (f.center.distance(eye) + f.radius);
        prop_assert!(seen || least > -margin, "culled, but {least}");
        prop_assert!(!seen || least < margin, "kept, but {least}");
    }

    #[test]
    fn a_pixel_is_what_a_matrix_makes_of_a_length(camera in camera(), depth in 0.1f32..20.0, error in 1e-4f32..0.05) {
        let project = perspective_infinite_reverse(camera.fov_y, camera.width_px / camera.height_px, camera.near)
            * look_at_mat4(camera.eye, camera.target, camera.up);
        let (_, up, forward) = camera.axes();
        let middle = camera.eye + forward * depth;
        let y = |p: Vec3| project.project_point3(p).y * camera.height_px / 2.0;
        let length = y(middle + up * error) - y(middle);
        let f = Footprint { center: middle + forward * 0.01, radius: 0.01, error, cone: NormalCone::ALL };
        let pixels = ScreenSpace::new(camera.eye, camera.fov_y, camera.height_px, camera.near).pixels(&f);
        prop_assert!((pixels - length).abs() <= 0.01 * length + 1e-2, "{pixels} {length}");
    }

    #[test]
    fn a_region_asks_inside_for_what_is_inside(f in footprint(), kind in 0..2usize) {
        let shape = if kind == 0 {
            Shape::Sphere { center: vec3(1.0, -2.0, 0.5), radius: 4.0 }
        } else {
            Shape::Box { min: vec3(-3.0, -1.0, -6.0), max: vec3(4.0, 5.0, 2.0) }
        };
        let holds = |p: Vec3| match shape {
            Shape::Sphere { center, radius } => (p - center).length_squared() <= radius * radius,
            Shape::Box { min, max } => p.cmpge(min).all() && p.cmple(max).all(),
        };
        let (some_in, some_out) = in_ball(f.center, f.radius).fold((false, false), |(i, o), p| (i | holds(p), o | !holds(p)));
        let value = |inside: f32, outside: f32| Region {
            shape,
            inside: Scale { inner: Uniform, factor: inside },
            outside: Scale { inner: Uniform, factor: outside },
        }.pixels(&f) / f.error;
        // Who is asked: with a share on either side both are, and the larger answer counts.
        if some_in {
            prop_assert!(value(7.0, 1.0) > 6.9);
        }
        if some_out {
            prop_assert!(value(1.0, 7.0) > 6.9);
        }
        let near = match shape {
            Shape::Sphere { center, radius } => (f.center.distance(center) - radius).abs(),
            Shape::Box { min, max } => {
                let out = (f.center - f.center.clamp(min, max)).length();
                if out > 0.0 { out } else { (f.center - min).min(max - f.center).min_element() }
            }
        };
        if near > f.radius * 1.001 {
            prop_assert!(value(7.0, 1.0) < 1.1 || value(1.0, 7.0) < 1.1, "a footprint on one side asks only that side");
        }
    }
}

#[test]
fn two_viewers_at_once() {
    let camera = |x: f32| Camera {
        eye: vec3(x, 0.0, 5.0),
        target: vec3(x, 0.0, 0.0),
        up: Vec3::Y,
        fov_y: 0.5,
        width_px: 100.0,
        height_px: 100.0,
        near: 0.1,
    };
    let both = |x: f32| Max(view(&camera(x), ViewOptions::default()), view(&camera(9.0), ViewOptions::default()));
    let travel = both(1.0).pose().travel(&both(0.0).pose(), Vec3::ZERO, 1.0).unwrap();
    assert!((0.9..1.0).contains(&travel), "the one that moved counts: {travel}");
    let other = Max(view(&camera(0.0), ViewOptions::default()), Uniform);
    assert_eq!(other.pose().travel(&both(0.0).pose(), Vec3::ZERO, 1.0), None);
}

#[test]
fn rubbish_cameras_give_numbers() {
    let bad = [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e38)];
    let f = Footprint { center: Vec3::ONE, radius: 1.0, error: 0.1, cone: NormalCone::ALL };
    for eye in bad {
        for up in bad {
            for fov_y in [0.0, f32::NAN, 3.2] {
                let camera = Camera { eye, target: Vec3::ZERO, up, fov_y, width_px: 0.0, height_px: 10.0, near: 0.0 };
                let c = view(&camera, ViewOptions::default());
                let _ = c.score(&f, 1.0);
                let _ = c.pose().travel(&c.pose(), Vec3::ZERO, 1.0);
            }
        }
    }
}
