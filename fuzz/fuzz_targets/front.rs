//! `.front` files: whatever the bytes, an error or columns that are written and read again the same; never a panic, never
//! much memory. What is read also becomes a hierarchy.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meshfront_format::{base, decode, encode, inspect};
use meshfront_hierarchies::{Hierarchy, Stored};

#[path = "../../crates/format/tests/common/checksums.rs"]
mod checksums;

const SOUND: [&[u8]; 5] = [
    include_bytes!("../../testdata/front/v1-scan-16-bits.front"),
    include_bytes!("../../testdata/front/v1-knot-lossless-painted.front"),
    include_bytes!("../../testdata/front/v1-parts-vertex-pair.front"),
    include_bytes!("../../testdata/front/v1-scan-vertex-removal.front"),
    include_bytes!("../../testdata/front/v1-terrain-with-a-hole.front"),
];

fuzz_target!(|data: &[u8]| {
    let _ = inspect(data, "fuzz");
    let _ = decode(data, "fuzz");
    let _ = base(data);
    // Checksums keep a fuzzer out: from here on they agree with the damage.
    let mut file = match data.split_first() {
        // A sound file with some bytes changed: three bytes an edit, a place and a value.
        Some((&which, edits)) if which < 128 => {
            let mut file = SOUND[which as usize % SOUND.len()].to_vec();
            for edit in edits.chunks_exact(3) {
                let at = u16::from_le_bytes([edit[0], edit[1]]) as usize % file.len();
                file[at] = edit[2];
            }
            file
        }
        // Any bytes.
        Some((_, bytes)) => bytes.to_vec(),
        None => return,
    };
    checksums::repair(&mut file);
    // Of a file that has not arrived as a whole, and of all of it.
    let _ = base(&file[..file.len() / 2]);
    let _ = base(&file);
    let inspected = inspect(&file, "fuzz");
    let Ok(columns) = decode(&file, "fuzz") else { return };
    let inspected = inspected.expect("decoded");
    match &columns {
        Stored::EdgeCollapse(columns) => assert_eq!(inspected.updates as usize, columns.vertex.len()),
        Stored::VertexPair(columns) => assert_eq!(inspected.updates as usize, columns.vertex.len()),
        _ => {}
    }
    let Ok(again) = encode(&columns) else {
        // Numbers of triangulations are checked where they are used, and where they are written.
        assert!(matches!(columns, Stored::VertexRemoval(_)), "what is read can be written");
        return;
    };
    // Missing heights are NaN, which is equal to nothing: bytes are compared.
    assert!(encode(&decode(&again, "again").expect("just written")).expect("written before") == again);
    let _ = Hierarchy::new(columns);
});
