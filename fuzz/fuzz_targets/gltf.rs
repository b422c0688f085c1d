//! The glTF reader: bytes are a `.gltf` or `.glb` as they come, or else the JSON and the binary chunk of a sound
//! container, since a fuzzer does not guess its lengths.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meshfront_mesh::io::Format;

#[path = "../mesh.rs"]
mod mesh;

fuzz_target!(|bytes: &[u8]| {
    mesh::check(bytes, Format::Glb);
    let cut = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let (json, binary) = bytes.split_at(cut);
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + bytes.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    mesh::check_file(&file, Format::Glb);
    mesh::check(bytes, Format::Gltf);
});
