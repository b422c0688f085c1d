//! Files of every released version stay readable, and mean what they meant.

use std::path::{Path, PathBuf};

use meshfront_format::{encode, inspect, read};
use meshfront_hierarchies::edge_collapse::Grid;
use meshfront_hierarchies::{Stored, edge_collapse, right_triangles, vertex_pair, vertex_removal};
use meshfront_mesh::TriangleMesh;
use meshfront_mesh::sample::{self, defects};
use meshfront_simplify::{
    EdgeCollapseOptions, RightTrianglesOptions, VertexPairOptions, VertexRemovalOptions, right_triangles_columns,
    vertex_pair_columns, vertex_removal_columns,
};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/front")
}

/// One line a column: its name, length and the CRC-32 of its numbers, little endian.
fn lines(columns: &[(&str, &[u8])]) -> String {
    let line =
        |(name, bytes): &(&str, &[u8])| format!("{name}: {} bytes, {:08x}\n", bytes.len(), crc32fast::hash(bytes));
    columns.iter().map(line).collect()
}

fn summary(stored: &Stored) -> String {
    match stored {
        Stored::EdgeCollapse(columns) => edge_collapse_summary(columns),
        Stored::VertexPair(columns) => vertex_pair_summary(columns),
        Stored::VertexRemoval(columns) => vertex_removal_summary(columns),
        Stored::RightTriangles(columns) => right_triangles_summary(columns),
    }
}

fn numbers_of(grid: Option<Grid>) -> Vec<u8> {
    let numbers = |g: Grid| [g.bits as f64, g.origin.x, g.origin.y, g.origin.z, g.step];
    grid.map_or(Vec::new(), |g| numbers(g).iter().flat_map(|n| n.to_le_bytes()).collect())
}

fn base_columns(base: &TriangleMesh) -> [(&'static str, &[u8]); 4] {
    [
        ("base.positions", bytemuck::cast_slice(&base.positions)),
        ("base.triangles", bytemuck::cast_slice(&base.triangles)),
        ("base.normals", bytemuck::cast_slice(&base.vertex.normals)),
        ("base.colors", base.vertex.colors.as_flattened()),
    ]
}

fn edge_collapse_summary(c: &edge_collapse::Columns) -> String {
    let explicit: Vec<u8> = c
        .explicit
        .iter()
        .flat_map(|s| s.update.0.to_le_bytes().into_iter().chain(s.added.iter().map(|t| t.star)))
        .collect();
    let grid = numbers_of(c.grid);
    let rest = [c.floor_error.to_bits(), c.source.vertices, c.source.triangles];
    let columns: [(&str, &[u8]); 8] = [
        ("vertex", bytemuck::cast_slice(&c.vertex)),
        ("sides", bytemuck::cast_slice(&c.sides)),
        ("explicit", &explicit),
        ("positions", bytemuck::cast_slice(&c.positions)),
        ("normals", bytemuck::cast_slice(&c.normals)),
        ("colors", c.colors.as_flattened().as_flattened()),
        ("errors", bytemuck::cast_slice(&c.errors)),
        ("floor_error, source", bytemuck::cast_slice(&rest)),
    ];
    lines(&[("grid", &grid[..])]) + &lines(&base_columns(&c.base)) + &lines(&columns)
}

fn vertex_pair_summary(c: &vertex_pair::Columns) -> String {
    let grid = numbers_of(c.grid);
    let rest = [c.floor_error.to_bits(), c.source.vertices, c.source.triangles];
    let columns: [(&str, &[u8]); 8] = [
        ("triangles", bytemuck::cast_slice(&c.triangles)),
        ("added", bytemuck::cast_slice(&c.added)),
        ("vertex", bytemuck::cast_slice(&c.vertex)),
        ("positions", bytemuck::cast_slice(&c.positions)),
        ("normals", bytemuck::cast_slice(&c.normals)),
        ("colors", c.colors.as_flattened().as_flattened()),
        ("errors", bytemuck::cast_slice(&c.errors)),
        ("floor_error, source", bytemuck::cast_slice(&rest)),
    ];
    lines(&[("grid", &grid[..])]) + &lines(&base_columns(&c.base)) + &lines(&columns)
}

fn vertex_removal_summary(c: &vertex_removal::Columns) -> String {
    let grid = numbers_of(c.grid);
    let rest = [c.floor_error.to_bits(), c.source.vertices, c.source.triangles];
    // Told by name: how triangulations are numbered is the format's business.
    let patches: String = c.patches.iter().map(|patch| format!("{patch:?}\n")).collect();
    let columns: [(&str, &[u8]); 6] = [
        ("patches", patches.as_bytes()),
        ("positions", bytemuck::cast_slice(&c.positions)),
        ("normals", bytemuck::cast_slice(&c.normals)),
        ("colors", c.colors.as_flattened()),
        ("errors", bytemuck::cast_slice(&c.errors)),
        ("floor_error, source", bytemuck::cast_slice(&rest)),
    ];
    lines(&[("grid", &grid[..])]) + &lines(&base_columns(&c.base)) + &lines(&columns)
}

fn right_triangles_summary(c: &right_triangles::Columns) -> String {
    // Missing samples are NaN, and one NaN is as good as another.
    let heights: Vec<u8> =
        c.heights.iter().map(|h| if h.is_nan() { f32::NAN } else { *h }).flat_map(|h| h.to_le_bytes()).collect();
    let rest = format!("{} {} {} {:?} {} {:?}", c.columns, c.rows, c.spacing, c.steps, c.floor_error, c.place);
    lines(&[("heights", &heights[..]), ("size, spacing, steps, floor_error, place", rest.as_bytes())])
}

#[test]
fn every_fixture_is_read_as_it_was_written() {
    let mut seen = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "front") {
            let expected = std::fs::read_to_string(path.with_extension("txt")).unwrap();
            assert_eq!(summary(&read(&path).unwrap().stored()), expected, "{}", path.display());
            seen += 1;
        }
    }
    assert!(seen >= 5);
}

/// Makes the fixtures of the present version: `cargo test -p meshfront-format --test fixtures -- --ignored`. Once a
/// version is released its files are never made again.
#[test]
#[ignore = "writes into testdata"]
fn make_fixtures() {
    std::fs::create_dir_all(folder()).unwrap();
    let write = |name: &str, stored: Stored| {
        let bytes = encode(&stored).unwrap();
        assert!(inspect(&bytes, name).unwrap().updates > 100);
        std::fs::write(folder().join(name).with_extension("front"), bytes).unwrap();
        std::fs::write(folder().join(name).with_extension("txt"), summary(&stored)).unwrap();
    };
    for (name, bits, painted) in [("v1-scan-16-bits", Some(16), false), ("v1-knot-lossless-painted", None, true)] {
        let mut mesh = if painted { sample::knot(400) } else { sample::scan(1200) };
        if painted {
            sample::paint(&mut mesh);
        }
        let options = EdgeCollapseOptions { bits, base_triangles: 60 };
        write(name, Stored::EdgeCollapse(meshfront_simplify::edge_collapse(&mesh, &options, &()).unwrap().columns()));
    }
    let mut mesh = defects::several_components(400);
    sample::paint(&mut mesh);
    let options = VertexPairOptions { bits: Some(14), ..VertexPairOptions::default() };
    write("v1-parts-vertex-pair", Stored::VertexPair(vertex_pair_columns(&mesh, &options, &()).unwrap()));

    let options = VertexRemovalOptions::default();
    let stored = vertex_removal_columns(&sample::scan(1200), &options, &()).unwrap();
    write("v1-scan-vertex-removal", Stored::VertexRemoval(stored));
    let mut field = sample::terrain_heights(37, 29);
    for i in
        (0..29).flat_map(|y| (0..37).map(move |x| (x, y))).filter(|(x, y)| (x - 20i32).pow(2) + (y - 9i32).pow(2) < 20)
    {
        field.heights[(37 * i.1 + i.0) as usize] = f32::NAN;
    }
    let stored = right_triangles_columns(&field, &RightTrianglesOptions::default()).unwrap();
    write("v1-terrain-with-a-hole", Stored::RightTriangles(stored));
}
