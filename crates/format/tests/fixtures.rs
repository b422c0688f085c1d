//! Files of every released version stay readable, and mean what they meant.

use std::path::{Path, PathBuf};

use meshfront_format::{encode, inspect, read};
use meshfront_hierarchies::edge_collapse::Grid;
use meshfront_hierarchies::{Stored, edge_collapse, vertex_pair};
use meshfront_mesh::TriangleMesh;
use meshfront_mesh::sample::{self, defects};
use meshfront_simplify::{EdgeCollapseOptions, VertexPairOptions, vertex_pair_columns};

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
        other => panic!("no fixtures of model {:?}", other.model()),
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
    assert!(seen >= 3);
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
}
