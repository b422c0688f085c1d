//! What every reader of heights promises for any bytes: an error that names the file, or a valid field that can be
//! written and read.

use std::sync::LazyLock;

use meshfront_mesh::io::height::{self, HeightFormat};

#[path = "../crates/mesh/tests/common/heights.rs"]
mod heights;

/// Made once: making takes longer than reading.
static SOUND: LazyLock<Vec<(&str, HeightFormat, Vec<u8>)>> = LazyLock::new(heights::small_files);

/// Bytes as they come, or else edits of a sound file: the first byte picks the file, then three bytes are an edit, a
/// place and a value.
pub fn check(bytes: &[u8], format: HeightFormat) {
    check_file(bytes, format);
    let sound: Vec<_> = SOUND.iter().filter(|f| f.1 == format).collect();
    if let Some((&which, edits)) = bytes.split_first() {
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
}

fn check_file(bytes: &[u8], format: HeightFormat) {
    match height::read_bytes(bytes, format, "fuzz") {
        Ok(source) => {
            heights::assert_valid(&source.field);
            let mut written = Vec::new();
            height::write_to(&mut written, &source.field, HeightFormat::GeoTiff).expect("a valid field can be written");
            let again = height::read_bytes(&written, HeightFormat::GeoTiff, "written").expect("and read again").field;
            assert_eq!(heights::bits(&again), heights::bits(&source.field));
            assert_eq!((again.origin, again.spacing), (source.field.origin, source.field.spacing));
        }
        Err(error) => assert!(error.to_string().starts_with("fuzz")),
    }
}
