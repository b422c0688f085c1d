//! Vertex-pair hierarchies to bytes and back, whole and damaged.

mod common;

use common::Random;
use common::checksums::repair;
use meshfront_conformance::merger::{Merging, merge};
use meshfront_format::vertex_pair::{decode, encode, inspect};
use meshfront_format::{EncodeError, round_error_up};
use meshfront_hierarchies::VertexPair;
use meshfront_hierarchies::vertex_pair::Columns;
use meshfront_mesh::sample::{self, defects};
use meshfront_mesh::{TriangleMesh, VertexId};

fn columns(mesh: &TriangleMesh, bits: Option<u32>, far: usize) -> Columns {
    merge(mesh, &Merging { bits, base_triangles: 4, far, seed: 3 })
}

/// With normals and colours that differ from vertex to vertex.
fn painted(triangles: usize) -> TriangleMesh {
    let mut mesh = sample::knot(triangles);
    mesh.vertex.normals = mesh.positions.iter().map(|p| p.normalize_or(glam::Vec3::X)).collect();
    mesh.vertex.colors =
        (0..mesh.positions.len() as u32).map(|v| v.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
    mesh
}

#[test]
fn what_is_written_is_what_is_read() {
    for (mesh, bits, far) in [
        (sample::sphere(1_000), Some(16), 1000),
        (sample::scan(1_000), None, 5),
        (defects::several_components(1_000), Some(12), 3),
        (defects::non_manifold_edge(1_000), None, 10),
        (painted(1_000), Some(14), 10),
        (painted(1_000), None, 2),
        (defects::tetrahedron(), None, 2),
    ] {
        let columns = columns(&mesh, bits, far);
        let bytes = encode(&columns).unwrap();
        let read = decode(&bytes, "test").unwrap();
        let errors = columns.errors.iter().map(|&e| round_error_up(e)).collect();
        assert_eq!(read, Columns { errors, ..columns.clone() });
        assert_eq!(encode(&read).unwrap(), bytes);
        VertexPair::new(read).unwrap();
        let info = inspect(&bytes, "test").unwrap();
        assert_eq!((info.model, info.updates as usize), ("vertex_pair", columns.vertex.len()));
        assert_eq!(info.pages.iter().map(|p| p.updates).sum::<u32>(), info.updates);
        assert!(info.columns.iter().map(|c| c.bytes).sum::<u64>() <= bytes.len() as u64);
    }
}

#[test]
fn every_shorter_length_and_every_changed_byte_is_an_error() {
    let file = encode(&columns(&painted(200), Some(12), 5)).unwrap();
    for length in 0..file.len() {
        assert!(decode(&file[..length], "cut.front").is_err() && inspect(&file[..length], "cut.front").is_err());
    }
    for at in 0..file.len() {
        let mut changed = file.clone();
        changed[at] ^= 0x41;
        assert!(decode(&changed, "changed.front").is_err(), "byte {at}");
    }
}

/// Damage that checksums do not see: an error, or columns that may or may not be a hierarchy; never a panic.
#[test]
fn no_damage_panics() {
    let file = encode(&columns(&painted(200), None, 5)).unwrap();
    let mut random = Random(9);
    let (mut read, mut sound) = (0, 0);
    for _ in 0..6_000 {
        let mut changed = file.clone();
        for _ in 0..1 + random.below(3) {
            let at = random.below(file.len() as u64) as usize;
            changed[at] = random.bits() as u8;
        }
        repair(&mut changed);
        let _ = inspect(&changed, "x");
        if let Ok(columns) = decode(&changed, "x") {
            read += 1;
            // What is read is a forest; only errors may grow downwards.
            assert_eq!(decode(&encode(&columns).expect("a forest"), "again").expect("just written"), columns);
            sound += usize::from(VertexPair::new(columns).is_ok());
        }
    }
    assert!(read > 0 && sound > 0, "{read} read, {sound} sound");
}

#[test]
fn what_is_no_forest_is_refused() {
    let mut columns = columns(&sample::sphere(300), Some(16), 100);
    columns.vertex[3] = VertexId(u32::MAX);
    assert!(matches!(encode(&columns), Err(EncodeError::Columns(_))));
}
