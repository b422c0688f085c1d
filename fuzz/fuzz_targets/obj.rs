//! The OBJ reader, also behind gzip.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meshfront_mesh::io::Format;

#[path = "../mesh.rs"]
mod mesh;

fuzz_target!(|bytes: &[u8]| mesh::check(bytes, Format::Obj));
