//! The suite on terrain: all sorts of sizes, borders and holes.

use glam::DVec2;
use meshfront_conformance::{Source, check};
use meshfront_hierarchies::{RightTriangles, TriangleModel};
use meshfront_mesh::{HeightField, Unit};
use meshfront_refine::MultiTessellation;
use meshfront_simplify::{RightTrianglesOptions, right_triangles};

/// Hills and a ridge, with a little noise.
fn field(columns: u32, rows: u32, missing: impl Fn(u32, u32) -> bool) -> HeightField {
    let heights = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| {
        if missing(x, y) {
            return f32::NAN;
        }
        let (u, v) = (x as f32 / columns.max(rows) as f32, y as f32 / columns.max(rows) as f32);
        let noise = (x * 7919 + y * 104_729) % 97;
        40.0 * (7.0 * u).sin() * (5.0 * v).cos() + 60.0 * (0.1 - (u - v).abs()).max(0.0) + noise as f32 * 0.01
    });
    HeightField {
        columns,
        rows,
        heights: heights.collect(),
        origin: DVec2::new(500_000.0, 4_000_000.0),
        spacing: DVec2::new(10.0, 12.0),
        horizontal: Unit::Metre,
        vertical: Unit::Metre,
        step: None,
    }
}

fn build(field: &HeightField, bits: Option<u32>) -> RightTriangles {
    right_triangles(field, &RightTrianglesOptions { bits, ..RightTrianglesOptions::default() }, &()).expect("terrain")
}

fn passes(field: HeightField, bits: Option<u32>) {
    let h = build(&field, bits);
    check(&h, &Source::new(field.to_mesh(1.0)), h.floor_error(), 11);
}

#[test]
fn a_square_of_a_power_of_two() {
    passes(field(17, 17, |_, _| false), None);
}

#[test]
fn quantized() {
    passes(field(17, 17, |_, _| false), Some(10));
}

#[test]
fn any_size() {
    for (columns, rows) in [(2, 2), (3, 2), (4, 4), (2, 9), (13, 6), (6, 21), (18, 11)] {
        passes(field(columns, rows, |_, _| false), None);
    }
}

#[test]
fn holes_and_ragged_borders() {
    passes(field(17, 17, |x, y| (5..8).contains(&x) && (9..12).contains(&y)), None);
    passes(field(17, 17, |x, y| x + y < 9), None);
    passes(field(20, 14, |x, y| (x, y) == (7, 7) || x > 15 && y < 4 || x * x + y * y < 20), None);
}

#[test]
fn flat_ground_is_two_triangles() {
    let mut field = field(33, 33, |_, _| false);
    field.heights.fill(250.0);
    let h = build(&field, Some(16));
    assert!(h.updates().all(|m| h.footprint(m).error == h.floor_error()));
    assert_eq!((h.base_triangles(), h.source().triangles), (2, 2048));
}

/// A slope has one normal: cones are as narrow as packing allows, in every direction that triangles lie in.
#[test]
fn cones_of_a_slope_are_narrow() {
    let mut slope = field(17, 17, |_, _| false);
    for (i, height) in slope.heights.iter_mut().enumerate() {
        *height = 6.0 * (i % 17) as f32 - 3.0 * (i / 17) as f32;
    }
    let h = build(&slope, None);
    for m in h.updates() {
        let footprint = h.footprint(m);
        assert!(footprint.error <= 1e-3, "{m:?}: {}", footprint.error);
        // A level adds a step of the packed angle, and what packing did to the normal.
        assert!(footprint.cone.cos > 0.1f32.cos(), "{m:?}: {}", footprint.cone.cos.acos());
    }
}
