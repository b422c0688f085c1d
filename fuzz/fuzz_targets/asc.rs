//! The reader of ESRI ASCII grids, also behind gzip.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meshfront_mesh::io::height::HeightFormat;

#[path = "../height.rs"]
mod height;

fuzz_target!(|bytes: &[u8]| height::check(bytes, HeightFormat::EsriAscii));
