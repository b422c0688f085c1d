//! A file that is not as it was written gives an error: never a panic, never another hierarchy, never much memory.

mod common;

use common::checksums::repair;
use common::{Random, Shape, plausible};
use meshfront_format::ReadError;
use meshfront_format::edge_collapse::{decode, encode, inspect};
use peak_alloc::PeakAlloc;
use std::sync::Mutex;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Tests that measure memory, or use much, do so one after the other.
static ALONE: Mutex<()> = Mutex::new(());

fn small_file() -> Vec<u8> {
    encode(&plausible(Shape { updates: 40, bits: Some(12), normals: true, colors: true, explicit: true }, 11)).unwrap()
}

#[test]
fn every_shorter_length_is_an_error() {
    let _alone = ALONE.lock();
    let file = small_file();
    for length in 0..file.len() {
        let error = decode(&file[..length], "cut.front").unwrap_err();
        assert!(error.to_string().contains("cut.front"), "{error}");
        assert!(inspect(&file[..length], "cut.front").is_err());
    }
    let mut longer = file.clone();
    longer.push(0);
    assert!(matches!(decode(&longer, "long.front"), Err(ReadError::Length { .. })));
}

#[test]
fn every_changed_byte_is_an_error() {
    let _alone = ALONE.lock();
    let file = small_file();
    for at in 0..file.len() {
        for change in (0..8).map(|bit| 1 << bit).chain([0xff]) {
            let mut changed = file.clone();
            changed[at] ^= change;
            assert!(decode(&changed, "changed.front").is_err(), "byte {at} ^ {change:#x}");
            assert!(inspect(&changed, "changed.front").is_err(), "byte {at} ^ {change:#x}");
        }
    }
}

/// As hard as a fuzzer's input: the checksums agree with the damage.
#[test]
fn damage_behind_right_checksums_never_panics_nor_takes_memory() {
    let _alone = ALONE.lock();
    let file = small_file();
    assert_eq!(
        {
            let mut same = file.clone();
            repair(&mut same);
            same
        },
        file,
        "repair knows the format"
    );
    let mut random = Random(5);
    let mut errors = 0;
    for _ in 0..6000 {
        let mut changed = file.clone();
        for _ in 0..1 + random.below(3) {
            let at = random.below(changed.len() as u64) as usize;
            match random.below(4) {
                0 => changed[at] = random.bits() as u8,
                1 => changed[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5) as usize],
                2 => changed[at] ^= 1 << random.below(8),
                _ => {
                    let number = [0, 1, 0xffff, 0x7fff_ffff, u32::MAX][random.below(5) as usize];
                    let at = at.min(changed.len() - 4) & !3;
                    changed[at..at + 4].copy_from_slice(&number.to_le_bytes());
                }
            }
        }
        repair(&mut changed);
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let result = decode(&changed, "x");
        let most = MEMORY.peak_usage() - before;
        assert!(most < 128 * file.len() + 100_000, "{most} bytes for a file of {}", file.len());
        match result {
            Err(_) => errors += 1,
            // Some damage only says something else: then it is what is written again.
            Ok(columns) => assert_eq!(decode(&encode(&columns).unwrap(), "again").unwrap(), columns),
        }
    }
    assert!(errors > 3000, "{errors} of 6000");
}

#[test]
fn counts_that_promise_too_much_take_no_memory() {
    let _alone = ALONE.lock();
    let file = small_file();
    let meta = 56 + 32 * 10;
    for (at, what) in [(40, "base vertices"), (44, "base triangles"), (48, "updates")] {
        for count in [1_000_000u32, 0x3fff_ffff, u32::MAX] {
            let mut changed = file.clone();
            changed[meta + at..meta + at + 4].copy_from_slice(&count.to_le_bytes());
            repair(&mut changed);
            MEMORY.reset_peak_usage();
            let before = MEMORY.current_usage();
            let error = decode(&changed, "x").unwrap_err();
            assert!(matches!(error, ReadError::Damaged { .. }), "{what}: {error}");
            assert!(MEMORY.peak_usage() - before < 100_000, "{what} {count}");
        }
    }
}

/// Here all counts agree with each other, and only the size of the page speaks against them.
#[test]
fn pages_shorter_than_their_updates_take_no_memory() {
    let _alone = ALONE.lock();
    let columns = plausible(Shape { updates: 40, bits: None, normals: false, colors: false, explicit: false }, 2);
    let file = encode(&columns).unwrap();
    let table = inspect(&file, "x").unwrap().sections.iter().find(|s| s.name == "UTAB").unwrap().offset as usize;
    for count in [3_000u32, 1_000_000, 0x3fff_ffff] {
        let mut changed = file.clone();
        for at in [56 + 32 * 4 + 48, table + 4] {
            assert_eq!(changed[at..at + 4], 40u32.to_le_bytes());
            changed[at..at + 4].copy_from_slice(&count.to_le_bytes());
        }
        repair(&mut changed);
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        assert!(matches!(decode(&changed, "x"), Err(ReadError::Damaged { section: "UTAB", .. })));
        assert!(MEMORY.peak_usage() - before < 20_000, "{count}");
    }
}

#[test]
fn other_versions_models_and_parts_are_named() {
    let file = small_file();
    let changed = |at: usize, bytes: &[u8]| {
        let mut changed = file.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        repair(&mut changed);
        meshfront_format::decode(&changed, "other.front").unwrap_err()
    };
    let newer = changed(8, &2u32.to_le_bytes());
    assert!(matches!(newer, ReadError::NewerVersion { found: 2, known: 1, .. }));
    assert!(newer.to_string().contains("update Meshfront"), "{newer}");
    let model = changed(24, b"clockwork\0\0\0\0\0");
    assert!(matches!(&model, ReadError::UnknownModel { model, .. } if model == "clockwork"));
    assert!(model.to_string().contains("update Meshfront"), "{model}");
    assert!(matches!(changed(48, &[4]), ReadError::UnknownPart { section, .. } if section == "header"));
    assert!(matches!(changed(56, b"XXXX"), ReadError::UnknownPart { section, .. } if section == "XXXX"));
    assert!(matches!(changed(56 + 4, &[9]), ReadError::UnknownPart { section, .. } if section == "META"));
    assert!(matches!(decode(b"ply\nformat ascii 1.0\n", "a.ply"), Err(ReadError::NotFront { .. })));
    assert!(matches!(decode(b"", "empty"), Err(ReadError::NotFront { .. })));
}

/// A later version may add sections that this one can do without.
#[test]
fn optional_sections_are_passed_over() {
    let file = small_file();
    let rows = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let (head, rest) = file.split_at(56 + 32 * rows);
    let mut longer = head.to_vec();
    for row in 0..rows {
        let at = 56 + 32 * row + 8;
        let offset = u64::from_le_bytes(longer[at..at + 8].try_into().unwrap()) + 32;
        longer[at..at + 8].copy_from_slice(&offset.to_le_bytes());
    }
    longer[12..16].copy_from_slice(&(rows as u32 + 1).to_le_bytes());
    longer.extend_from_slice(b"NEWS\0\0\0\0");
    longer.extend_from_slice(&(file.len() as u64 + 32).to_le_bytes());
    longer.extend_from_slice(&5u64.to_le_bytes());
    longer.extend_from_slice(&[0, 0, 0, 0, 1, 0, 0, 0]);
    longer.extend_from_slice(rest);
    longer.extend_from_slice(b"hello");
    repair(&mut longer);
    assert_eq!(decode(&longer, "newer").unwrap(), decode(&file, "older").unwrap());
    let flags = 56 + 32 * rows + 28;
    longer[flags] = 0;
    repair(&mut longer);
    assert!(matches!(decode(&longer, "newer"), Err(ReadError::UnknownPart { .. })));
}
