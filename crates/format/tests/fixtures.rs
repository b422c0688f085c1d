//! Files of every released version stay readable, and mean what they meant.

use std::path::{Path, PathBuf};

use meshfront_format::edge_collapse::{encode, inspect};
use meshfront_format::read;
use meshfront_hierarchies::Stored;
use meshfront_hierarchies::edge_collapse::Columns;
use meshfront_mesh::sample;
use meshfront_simplify::{EdgeCollapseOptions, edge_collapse};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/front")
}

/// One line a column: its name, length and the CRC-32 of its numbers, little endian.
fn summary(columns: &Columns) -> String {
    let c = columns;
    let explicit: Vec<u8> = c
        .explicit
        .iter()
        .flat_map(|s| s.update.0.to_le_bytes().into_iter().chain(s.added.iter().map(|t| t.star)))
        .collect();
    let grid: Vec<u8> = c.grid.map_or(Vec::new(), |g| {
        let numbers = [g.bits as f64, g.origin.x, g.origin.y, g.origin.z, g.step];
        numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
    });
    let rest = [c.floor_error.to_bits(), c.source.vertices, c.source.triangles];
    let columns: [(&str, &[u8]); 13] = [
        ("grid", &grid),
        ("base.positions", bytemuck::cast_slice(&c.base.positions)),
        ("base.triangles", bytemuck::cast_slice(&c.base.triangles)),
        ("base.normals", bytemuck::cast_slice(&c.base.vertex.normals)),
        ("base.colors", c.base.vertex.colors.as_flattened()),
        ("vertex", bytemuck::cast_slice(&c.vertex)),
        ("sides", bytemuck::cast_slice(&c.sides)),
        ("explicit", &explicit),
        ("positions", bytemuck::cast_slice(&c.positions)),
        ("normals", bytemuck::cast_slice(&c.normals)),
        ("colors", c.colors.as_flattened().as_flattened()),
        ("errors", bytemuck::cast_slice(&c.errors)),
        ("floor_error, source", bytemuck::cast_slice(&rest)),
    ];
    columns.map(|(name, bytes)| format!("{name}: {} bytes, {:08x}\n", bytes.len(), crc32fast::hash(bytes))).concat()
}

fn columns_of(path: &Path) -> Columns {
    match read(path).unwrap().stored() {
        Stored::EdgeCollapse(columns) => columns,
        other => panic!("{} is of model {:?}", path.display(), other.model()),
    }
}

#[test]
fn every_fixture_is_read_as_it_was_written() {
    let mut seen = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "front") {
            let expected = std::fs::read_to_string(path.with_extension("txt")).unwrap();
            assert_eq!(summary(&columns_of(&path)), expected, "{}", path.display());
            seen += 1;
        }
    }
    assert!(seen >= 2);
}

/// Makes the fixtures of the present version: `cargo test -p meshfront-format --test fixtures -- --ignored`. Once a
/// version is released its files are never made again.
#[test]
#[ignore = "writes into testdata"]
fn make_fixtures() {
    std::fs::create_dir_all(folder()).unwrap();
    for (name, bits, painted) in [("v1-scan-16-bits", Some(16), false), ("v1-knot-lossless-painted", None, true)] {
        let mut mesh = if painted { sample::knot(400) } else { sample::scan(1200) };
        if painted {
            sample::paint(&mut mesh);
        }
        let options = EdgeCollapseOptions { bits, base_triangles: 60 };
        let columns = edge_collapse(&mesh, &options, &()).unwrap().columns();
        let bytes = encode(&columns).unwrap();
        assert!(inspect(&bytes, name).unwrap().updates > 100);
        std::fs::write(folder().join(name).with_extension("front"), bytes).unwrap();
        std::fs::write(folder().join(name).with_extension("txt"), summary(&columns)).unwrap();
    }
}
