//! What every reader promises for any bytes: an error that names the file, or a valid mesh that can be written and read.

use meshfront_mesh::io::{self, Format};

#[path = "../crates/mesh/tests/common/mod.rs"]
mod common;

/// Bytes as they come, or else edits of a sound file: the first byte picks the file, then three bytes are an edit, a
/// place and a value.
pub fn check(bytes: &[u8], format: Format) {
    let sound: Vec<_> = common::small_files().into_iter().filter(|f| f.1 == format).collect();
    match bytes.split_first() {
        Some((&which, edits)) if (128..192).contains(&which) && !sound.is_empty() => {
            let mut file = sound[which as usize % sound.len()].2.clone();
            for edit in edits.chunks_exact(3) {
                let at = u16::from_le_bytes([edit[0], edit[1]]) as usize % (file.len() + 1);
                match file.get_mut(at) {
                    Some(byte) => *byte = edit[2],
                    None => file.truncate(edit[2] as usize),
                }
            }
            check_file(&file, format);
        }
        _ => check_file(bytes, format),
    }
}

/// Reads bytes as `format`.
pub fn check_file(bytes: &[u8], format: Format) {
    match io::read_bytes(bytes, format, "fuzz") {
        Ok(source) => {
            common::assert_valid(&source.mesh);
            assert!(!source.mesh.triangles.is_empty());
            let mut written = Vec::new();
            io::write_to(&mut written, &source.mesh, Format::Ply).expect("a valid mesh can be written");
            let again = io::read_bytes(&written, Format::Ply, "written").expect("what was written can be read").mesh;
            assert_eq!(again, source.mesh);
        }
        Err(error) => assert!(error.to_string().starts_with("fuzz")),
    }
}
