//! glTF stand-in while the first slice compiles.
use super::Ticker;
use super::error::{Fail, ReadErrorKind};
use super::soup::Soup;
use crate::TriangleMesh;
use std::io::{self, Write};
use std::path::Path;
pub(super) fn read(_b: &[u8], _f: Option<&Path>, _t: &mut Ticker<'_>) -> Result<Soup, Fail> {
    Err(Fail::file(ReadErrorKind::Unsupported { what: "glTF".into(), remedy: "convert it to PLY" }))
}
pub(super) fn write(_o: &mut impl Write, _m: &TriangleMesh) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "glTF"))
}
