//! Vertex-removal hierarchies to bytes and back, whole and damaged.

mod common;

use common::damage::{is_checked, unnoticed};
use common::{Random, painted};
use meshfront_format::vertex_removal::{decode, encode, inspect};
use meshfront_format::{EncodeError, round_error_up};
use meshfront_hierarchies::VertexRemoval;
use meshfront_hierarchies::vertex_removal::{Columns, Connectivity};
use meshfront_mesh::{TriangleMesh, sample};
use meshfront_simplify::{VertexRemovalOptions, vertex_removal_columns};

fn columns(mesh: &TriangleMesh, bits: Option<u32>) -> Columns {
    let options = VertexRemovalOptions { bits, base_triangles: 40, connectivity: Connectivity::default() };
    vertex_removal_columns(mesh, &options, &()).unwrap()
}

#[test]
fn what_is_written_is_what_is_read() {
    for (mesh, bits) in [
        (sample::sphere(3_000), Some(16)),
        (sample::terrain(12_000), Some(12)),
        (sample::scan(4_000), None),
        (painted(2_000), Some(14)),
        (painted(2_000), None),
    ] {
        let columns = columns(&mesh, bits);
        let bytes = encode(&columns).unwrap();
        let read = decode(&bytes, "test").unwrap();
        let errors = columns.errors.iter().map(|&e| round_error_up(e)).collect();
        assert_eq!(read, Columns { errors, ..columns.clone() });
        assert_eq!(encode(&read).unwrap(), bytes);
        VertexRemoval::new(read).unwrap();
        let info = inspect(&bytes, "test").unwrap();
        assert_eq!((info.model, info.updates as usize), ("vertex_removal", columns.patches.len()));
        assert_eq!(info.pages.iter().map(|p| p.updates).sum::<u32>(), info.updates);
        let per_vertex = bytes.len() as f64 / mesh.positions.len() as f64;
        assert!(per_vertex < if mesh.vertex.colors.is_empty() { 14.0 } else { 24.0 }, "{per_vertex} bytes per vertex");
    }
}

#[test]
fn triangulations_are_coded_as_asked() {
    let columns = columns(&sample::scan(20_000), Some(16));
    let h = VertexRemoval::new(columns.clone()).unwrap();
    let length = |connectivity| {
        let asked = Columns { connectivity, ..columns.clone() };
        let bytes = encode(&asked).unwrap();
        let read = decode(&bytes, "test").unwrap();
        assert_eq!((read.connectivity, &read.patches), (connectivity, &columns.patches));
        assert_eq!(VertexRemoval::new(read).unwrap().columns().connectivity, connectivity);
        bytes.len() as f64
    };
    let sizes = Connectivity::ALL.map(|code| (length(code), code.mean_bits(&h)));
    for (bytes, bits) in sizes {
        // All else is the same, but for the ends of streams.
        let expected = sizes[0].0 + (bits - sizes[0].1) * columns.patches.len() as f64 / 8.0;
        assert!((bytes - expected).abs() < 4.0 * (columns.patches.len() / 4096 + 1) as f64, "{bytes}, not {expected}");
    }
}

#[test]
fn every_shorter_length_and_every_changed_byte_is_an_error() {
    let columns = columns(&painted(300), Some(12));
    for connectivity in [Connectivity::Turned, Connectivity::Ears] {
        let file = encode(&Columns { connectivity, ..columns.clone() }).unwrap();
        is_checked(&file, |bytes, name| decode(bytes, name).is_ok(), |bytes, name| inspect(bytes, name).is_ok());
    }
}

/// Damage that checksums do not see: an error, or columns that may or may not be a hierarchy; never a panic.
#[test]
fn no_damage_panics() {
    let columns = columns(&painted(300), None);
    let files = Connectivity::ALL.map(|connectivity| encode(&Columns { connectivity, ..columns.clone() }).unwrap());
    let mut random = Random(9);
    let mut read = 0;
    for i in 0..24_000 {
        let file = &files[i % files.len()];
        let changed = unnoticed(file, &mut random);
        let _ = inspect(&changed, "x");
        if let Ok(columns) = decode(&changed, "x") {
            read += 1;
            let _ = encode(&columns);
            let _ = VertexRemoval::new(columns);
        }
    }
    assert!(read > 0);
}

#[test]
fn cells_that_do_not_exist_are_refused() {
    let mut columns = columns(&sample::sphere(500), Some(16));
    columns.patches[3].cell = u32::MAX / 2;
    assert!(matches!(encode(&columns), Err(EncodeError::Columns(_))));
}
