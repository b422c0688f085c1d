//! Vertex-pair hierarchies to bytes and back, whole and damaged.

mod common;

use common::checksums::repair;
use common::damage::{is_checked, unnoticed};
use common::{Random, painted};
use meshfront_conformance::merger::{Merging, merge};
use meshfront_format::vertex_pair::{decode, encode, inspect};
use meshfront_format::{EncodeError, round_error_up};
use meshfront_hierarchies::VertexPair;
use meshfront_hierarchies::vertex_pair::Columns;
use meshfront_mesh::sample::{self, defects};
use meshfront_mesh::{TriangleMesh, VertexId};
use peak_alloc::PeakAlloc;
use std::sync::Mutex;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Tests that look at memory, or use much, do so one after the other.
static ALONE: Mutex<()> = Mutex::new(());

fn columns(mesh: &TriangleMesh, bits: Option<u32>, far: usize) -> Columns {
    merge(mesh, &Merging { bits, base_triangles: 4, far, seed: 3 })
}

#[test]
fn what_is_written_is_what_is_read() {
    let _alone = ALONE.lock();
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
    let _alone = ALONE.lock();
    let file = encode(&columns(&painted(200), Some(12), 5)).unwrap();
    is_checked(&file, |bytes, name| decode(bytes, name).is_ok(), |bytes, name| inspect(bytes, name).is_ok());
}

/// Damage that checksums do not see: an error, or columns that may or may not be a hierarchy; never a panic, nor much
/// memory.
#[test]
fn no_damage_panics_nor_takes_memory() {
    let _alone = ALONE.lock();
    let file = encode(&columns(&painted(200), None, 5)).unwrap();
    let mut random = Random(9);
    let (mut read, mut sound) = (0, 0);
    for _ in 0..6_000 {
        let changed = unnoticed(&file, &mut random);
        let _ = inspect(&changed, "x");
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let result = decode(&changed, "x");
        let most = MEMORY.peak_usage() - before;
        assert!(most < 256 * file.len() + 100_000, "{most} bytes for a file of {}", file.len());
        if let Ok(columns) = result {
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
    let _alone = ALONE.lock();
    let mut columns = columns(&sample::sphere(300), Some(16), 100);
    columns.vertex[3] = VertexId(u32::MAX);
    assert!(matches!(encode(&columns), Err(EncodeError::Columns(_))));
}

/// The densest that a page may be: as many updates, and triangles, as it has bytes.
#[test]
fn counts_take_no_memory_that_the_file_does_not_have() {
    let _alone = ALONE.lock();
    let file = encode(&columns(&sample::sphere(300), None, 100)).unwrap();
    let table = inspect(&file, "x").unwrap().sections.iter().find(|s| s.name == "UTAB").unwrap().offset as usize;
    let page = inspect(&file, "x").unwrap().pages[0];
    let length = page.bytes as u32;
    for (updates, triangles) in [(length, length), (page.updates, length), (page.updates, u32::MAX), (u32::MAX, 9)] {
        let mut changed = file.clone();
        let stars = page.offset as usize
            + 16
            + u32::from_le_bytes(file[page.offset as usize..][..4].try_into().unwrap()) as usize;
        changed[table + 4..table + 8].copy_from_slice(&updates.to_le_bytes());
        changed[56 + 32 * 4 + 48..][..4].copy_from_slice(&updates.to_le_bytes());
        changed[stars..stars + 4].copy_from_slice(&triangles.to_le_bytes());
        repair(&mut changed);
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        assert!(decode(&changed, "x").is_err());
        let most = MEMORY.peak_usage() - before;
        assert!(most < 256 * file.len() + 100_000, "{most} bytes for a file of {}", file.len());
    }
}
