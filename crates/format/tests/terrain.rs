//! Terrain to bytes and back, whole and damaged.

mod common;

use common::Random;
use common::checksums::repair;
use common::damage::{is_checked, unnoticed};
use glam::{DVec2, Vec3};
use meshfront_format::right_triangles::{decode, encode, inspect};
use meshfront_format::{EncodeError, ReadError};
use meshfront_hierarchies::right_triangles::{Columns, InvalidHeights, Place, Steps};
use meshfront_mesh::Unit;
use proptest::prelude::*;

fn columns(columns: u32, rows: u32, steps: Option<Steps>, missing: u64, seed: u64) -> Columns {
    let mut random = Random(seed);
    let heights = (0..columns * rows).map(|i| {
        if random.below(100) < missing {
            return f32::NAN;
        }
        let smooth = ((i % columns) as f32 * 0.1).sin() * 50.0 + ((i / columns) as f32 * 0.07).cos() * 80.0;
        let height = smooth + random.unit();
        steps.map_or(height, |s| s.height(s.nearest(height)))
    });
    Columns {
        columns,
        rows,
        spacing: DVec2::new(30.0, 28.5),
        heights: heights.collect(),
        steps,
        floor_error: 0.25,
        place: Place {
            origin: DVec2::new(557_945.0, 5_107_991.0),
            horizontal: Unit::Metre,
            spacing: DVec2::new(30.0, 28.5),
            vertical: Unit::UsSurveyFoot,
            exaggeration: 2.0,
        },
    }
}

const STEPS: Option<Steps> = Some(Steps { zero: -10.0, step: 0.5 });

/// NaN is equal to NaN here.
fn same(a: &Columns, b: &Columns) -> bool {
    let bits =
        |c: &Columns| c.heights.iter().map(|h| if h.is_nan() { None } else { Some(h.to_bits()) }).collect::<Vec<_>>();
    let rest = |c: &Columns| Columns { heights: vec![], ..c.clone() };
    bits(a) == bits(b) && rest(a) == rest(b)
}

proptest! {
    #[test]
    fn what_is_written_is_what_is_read(
        w in 2u32..40, h in 2u32..40, quantized: bool, missing in 0u64..30, seed: u64,
    ) {
        let columns = columns(w, h, STEPS.filter(|_| quantized), missing, seed);
        let bytes = encode(&columns).unwrap();
        prop_assert!(same(&decode(&bytes, "test").unwrap(), &columns));
        let info = inspect(&bytes, "test").unwrap();
        prop_assert_eq!(info.source_vertices as usize, columns.heights.iter().filter(|h| !h.is_nan()).count());
    }
}

#[test]
fn smooth_ground_is_small_and_pages_are_many() {
    let columns = columns(300, 250, STEPS, 0, 5);
    let bytes = encode(&columns).unwrap();
    assert!(same(&decode(&bytes, "test").unwrap(), &columns));
    assert!(bytes.len() < 75_000, "{} bytes for 75,000 samples with two steps of noise", bytes.len());
    let info = inspect(&bytes, "test").unwrap();
    assert_eq!((info.pages.len(), info.model), (5, "right_triangles"));
    assert_eq!(info.pages.iter().map(|p| p.bytes).sum::<u64>(), info.columns[0].bytes);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| encode(&columns).unwrap()), bytes);
}

#[test]
fn every_shorter_length_and_every_changed_byte_is_an_error() {
    let file = encode(&columns(9, 7, STEPS, 20, 3)).unwrap();
    is_checked(&file, |bytes, name| decode(bytes, name).is_ok(), |bytes, name| inspect(bytes, name).is_ok());
}

/// Damage that checksums do not see: an error or columns that can be written again, never a panic.
#[test]
fn no_damage_panics() {
    let file = encode(&columns(9, 7, None, 20, 3)).unwrap();
    let mut random = Random(9);
    for _ in 0..20_000 {
        let changed = unnoticed(&file, &mut random);
        let _ = inspect(&changed, "x");
        if let Ok(columns) = decode(&changed, "x") {
            assert!(same(&decode(&encode(&columns).unwrap(), "again").unwrap(), &columns));
        }
    }
}

/// A file of a few hundred bytes cannot ask for gigabytes.
#[test]
fn sizes_are_believed_only_as_far_as_the_file_is_long() {
    let mut file = encode(&columns(9, 7, STEPS, 0, 3)).unwrap();
    let meta = 56 + 32 * 4;
    file[meta + 4..meta + 12].copy_from_slice(&[0xff, 0x7f, 0, 0, 0xff, 0x3f, 0, 0]);
    repair(&mut file);
    assert!(matches!(decode(&file, "x"), Err(ReadError::Damaged { section: "HTAB", .. })));
}

#[test]
fn heights_between_steps_are_refused() {
    let mut columns = columns(9, 7, STEPS, 0, 3);
    columns.heights[5] += 0.1;
    assert_eq!(encode(&columns), Err(EncodeError::Heights(InvalidHeights::OffStep(5))));
}

/// A surface for the time until the rest is there, from as much of the file as holds the coarsest heights.
#[test]
fn a_coarse_surface_is_read_from_the_start_of_a_file() {
    for (w, h, missing, step) in [
        (300, 250, 0, 4),
        (300, 250, 20, 4),
        (257, 257, 0, 4),
        (1025, 400, 1, 8),
        (100, 90, 0, 1),
        (3, 2, 0, 1),
        (2, 2, 0, 1),
    ] {
        let columns = columns(w, h, STEPS, missing, 11);
        let bytes = encode(&columns).unwrap();
        let read = |n: usize| meshfront_format::base(&bytes[..n]);
        let reaches = (0..=bytes.len()).find(|&n| read(n).is_some()).expect("a surface");
        assert!(w < 1000 || reaches < bytes.len() / 7, "{reaches} of {}", bytes.len());
        let surface = read(reaches).unwrap();
        assert_eq!(read(bytes.len()).unwrap(), surface);
        // All samples of a grid, and no others, as high as they are.
        let heights = columns.heights.chunks_exact(w as usize).step_by(step).enumerate().flat_map(|(y, row)| {
            let row = row.iter().step_by(step).enumerate().map(move |(x, &height)| (x, y, height));
            row.filter(|(.., height)| !height.is_nan())
        });
        let place = |n: usize, spacing: f64| (n * step) as f32 * spacing as f32;
        let expected: Vec<_> =
            heights.map(|(x, y, height)| Vec3::new(place(x, 30.0), place(y, 28.5), height)).collect();
        assert_eq!(surface.positions, expected, "{w} × {h}");
        let [across, along] = [w, h].map(|samples| (samples as usize - 1) / step);
        if missing == 0 {
            assert_eq!(surface.triangles.len(), 2 * across * along);
        }
        for t in &surface.triangles {
            let [a, b, c] = t.map(|v| surface.positions[v.0 as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "seen from above");
        }
        // Nothing else is ever taken for it.
        for at in (0..reaches).step_by(1 + reaches / 500) {
            let mut altered = bytes[..reaches].to_vec();
            altered[at] ^= 0x10;
            if let Some(other) = meshfront_format::base(&altered) {
                assert_eq!(other, surface, "byte {at}");
            }
        }
    }
}
