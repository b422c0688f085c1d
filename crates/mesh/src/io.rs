//! Files to meshes and back; [`height`] does the same for height fields.
//!
//! [`read`] tells the format by the name's ending (`.gz` behind it is seen through), checks every count and index,
//! triangulates polygons, cleans the mesh ([`crate::clean`]) and says in a [`ReadReport`] what it did. [`write()`]
//! replaces nothing unless asked, and leaves either the whole new file or what was there before.
//!
//! | format | read                                                      | written                     | columns      |
//! | ------ | --------------------------------------------------------- | --------------------------- | ------------ |
//! | OFF    | `[ST][C][N]OFF` text, polygons, comments                  | OFF, COFF, NOFF, CNOFF      | normals, RGBA|
//! | OBJ    | polygons, negative indices, `v//n`, colours behind `v`    | `v`, `vn`, `f`              | normals, RGB |
//! | PLY    | text, both binaries, polygons, strips, any properties     | binary, little endian       | normals, RGBA|
//! | STL    | text and binary                                           | binary                      | none         |
//! | glTF   | `.glb`, `.gltf`; triangles, strips, fans; node transforms | `.glb`                      | normals, RGBA|
//!
//! `.gz` may follow every ending. Coordinates are stored in 32 bits and never rotated or scaled (glTF: brought to world space by the nodes).
//! Reading holds the file's bytes, the mesh and scratch for cleaning in memory: up to five times the (decompressed)
//! size for ordinary files, less than 24 times for the worst that `tests/memory.rs` could make.

mod error;
mod gltf;
pub mod height;
mod obj;
mod off;
mod ply;
mod soup;
mod stl;
mod text;

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;

pub use error::{Place, ReadError, ReadErrorKind, UnknownFormat, WriteError};

use crate::clean::{CleanReport, clean, weld_seams};
use crate::{Thousands, TriangleMesh};
use error::Fail;
use soup::Soup;

/// How many times its size a `.gz` may inflate to. Deflate itself reaches 1032; meshes stay below 30.
pub const MOST_INFLATION: u64 = 100;
/// A `.gz` may always inflate to this many bytes, however small it is.
const ALWAYS_INFLATES_TO: u64 = 1 << 20;

/// The formats of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Object File Format (Geomview).
    Off,
    /// Wavefront OBJ.
    Obj,
    /// Polygon File Format (Stanford).
    Ply,
    /// Stereolithography.
    Stl,
    /// glTF 2.0 in one binary file.
    Glb,
    /// glTF 2.0 as JSON, with buffers beside or inside it.
    Gltf,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 6] = [Format::Off, Format::Obj, Format::Ply, Format::Stl, Format::Glb, Format::Gltf];
    /// What names may end with, for messages.
    pub const ENDINGS: &str = ".off, .obj, .ply, .stl, .glb and .gltf, each also with .gz behind it";

    /// The ending of names, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Off => "off",
            Format::Obj => "obj",
            Format::Ply => "ply",
            Format::Stl => "stl",
            Format::Glb => "glb",
            Format::Gltf => "gltf",
        }
    }

    /// The format by the ending of a name, upper or lower case, with or without `.gz` behind it.
    pub fn from_path(path: impl AsRef<Path>) -> Result<Format, UnknownFormat> {
        let ending = inner_ending(path.as_ref()).ok_or(UnknownFormat::NoEnding)?;
        Format::ALL.into_iter().find(|f| f.ending() == ending).ok_or(UnknownFormat::Ending { ending })
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Format::Off => "OFF",
            Format::Obj => "OBJ",
            Format::Ply => "PLY",
            Format::Stl => "STL",
            Format::Glb => "GLB",
            Format::Gltf => "glTF",
        })
    }
}

/// The ending of a name in lower case, less a `.gz` behind it.
fn inner_ending(path: &Path) -> Option<String> {
    let inner = path.file_stem().filter(|_| is_gz(path)).map(Path::new).unwrap_or(path);
    Some(inner.extension()?.to_string_lossy().to_lowercase())
}

fn is_gz(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"))
}

/// A mesh from a file, and what happened on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The mesh; clean unless [`ReadOptions::clean`] is false.
    pub mesh: TriangleMesh,
    /// What was in the file and what was changed.
    pub report: ReadReport,
}

/// What was in a file and what reading changed. `Display` gives it as one line for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadReport {
    /// The format read.
    pub format: Format,
    /// Size of the file; for a `.gz`, compressed.
    pub bytes: u64,
    /// Vertices in the file. STL: three per triangle. glTF: once per node that shows them.
    pub vertices_in_file: u64,
    /// Faces in the file: triangles and polygons, also those that were dropped.
    pub faces_in_file: u64,
    /// Faces of four or more corners that were cut into triangles.
    pub polygons_triangulated: u64,
    /// Faces of fewer than three corners, which were dropped.
    pub faces_too_small: u64,
    /// Vertex normals that were zero or not finite and were computed from the triangles instead.
    pub normals_repaired: u64,
    /// glTF: primitives that are points or lines, which were left out.
    pub primitives_skipped: u64,
    /// What cleaning did.
    pub cleaned: CleanReport,
    /// Vertices joined across attribute seams, where that was asked for.
    pub seams_welded: u64,
    /// Vertices of the mesh.
    pub vertices: u64,
    /// Triangles of the mesh.
    pub triangles: u64,
}

impl fmt::Display for ReadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let some = |f: &mut fmt::Formatter<'_>, count: u64, one: &str, many: &str| match count {
            0 => Ok(()),
            1 => write!(f, ", {one}"),
            n => write!(f, ", {} {many}", Thousands(n)),
        };
        let (vertices, faces) = (Thousands(self.vertices_in_file), Thousands(self.faces_in_file));
        write!(f, "{} with {vertices} vertices and {faces} faces", self.format)?;
        some(f, self.polygons_triangulated, "1 polygon triangulated", "polygons triangulated")?;
        some(f, self.faces_too_small, "1 face of too few corners dropped", "faces of too few corners dropped")?;
        some(f, self.normals_repaired, "1 bad normal recomputed", "bad normals recomputed")?;
        some(f, self.primitives_skipped, "1 point or line primitive left out", "point and line primitives left out")?;
        if !self.cleaned.is_nothing() {
            write!(f, ", {}", self.cleaned)?;
        }
        some(f, self.seams_welded, "1 vertex joined across a seam", "vertices joined across seams")?;
        write!(f, ": {} vertices, {} triangles", Thousands(self.vertices), Thousands(self.triangles))
    }
}

/// How to read.
pub struct ReadOptions<'a> {
    /// Whether to [`clean`] the mesh. Default: yes.
    pub clean: bool,
    /// Whether to join vertices that differ only in their attributes ([`weld_seams`]): the surface is closed, and hard
    /// edges are lost. Default: no.
    pub weld_seams: bool,
    /// Called about two hundred times while a file is read.
    pub progress: Option<&'a mut dyn FnMut(Progress)>,
}

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        ReadOptions { clean: true, weld_seams: false, progress: None }
    }
}

/// How far reading is. Within a phase `done` only grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub phase: Phase,
    /// Bytes done: compressed ones while decompressing, else of the text or binary itself.
    pub done: u64,
    /// Bytes in all.
    pub total: u64,
}

/// The phases of reading, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Inflating a `.gz`; other files go without.
    Decompress,
    /// Making columns out of bytes.
    Parse,
    /// Welding and dropping.
    Clean,
}

/// Tells the progress callback about every half percent.
struct Ticker<'a> {
    progress: Option<&'a mut dyn FnMut(Progress)>,
    phase: Phase,
    total: u64,
    next: u64,
}

impl<'a> Ticker<'a> {
    fn new(progress: Option<&'a mut dyn FnMut(Progress)>) -> Ticker<'a> {
        Ticker { progress, phase: Phase::Parse, total: 0, next: u64::MAX }
    }

    fn start(&mut self, phase: Phase, total: u64) {
        (self.phase, self.total) = (phase, total);
        self.next = if self.progress.is_some() { 0 } else { u64::MAX };
        self.at(0);
    }

    /// `done` bytes are done.
    #[inline]
    fn at(&mut self, done: usize) {
        if done as u64 >= self.next {
            self.tell(done as u64);
        }
    }

    #[cold]
    fn tell(&mut self, done: u64) {
        if let Some(progress) = &mut self.progress {
            progress(Progress { phase: self.phase, done, total: self.total });
            self.next = (done + self.total / 200 + 1).min(self.total.max(done + 1));
        }
    }
}

/// Reads the mesh in a file and cleans it.
///
/// The format is the one the ending names. Errors: the file cannot be opened, its ending is unknown, or its bytes are
/// not a mesh of that format; the message names the file, the place and the remedy.
pub fn read(path: impl AsRef<Path>) -> Result<Source, ReadError> {
    read_with(path, ReadOptions::default())
}

/// [`read`] with options.
pub fn read_with(path: impl AsRef<Path>, options: ReadOptions<'_>) -> Result<Source, ReadError> {
    let path = path.as_ref();
    let whole = |kind| ReadError { name: path.display().to_string(), place: Place::File, kind };
    let format = Format::from_path(path).map_err(|e| whole(ReadErrorKind::UnknownFormat(e)))?;
    let bytes = fs::read(path).map_err(|e| whole(ReadErrorKind::Io(e)))?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    read_from(&bytes, format, &path.display().to_string(), Some(folder), options)
}

/// Reads the mesh in some bytes, which may be gzip of the format, and cleans it. `name` is for messages.
///
/// A `.gltf` must hold its buffers inside itself.
pub fn read_bytes(bytes: &[u8], format: Format, name: &str) -> Result<Source, ReadError> {
    read_bytes_with(bytes, format, name, ReadOptions::default())
}

/// [`read_bytes`] with options.
pub fn read_bytes_with(
    bytes: &[u8],
    format: Format,
    name: &str,
    options: ReadOptions<'_>,
) -> Result<Source, ReadError> {
    read_from(bytes, format, name, None, options)
}

fn read_from(
    bytes: &[u8],
    format: Format,
    name: &str,
    folder: Option<&Path>,
    options: ReadOptions<'_>,
) -> Result<Source, ReadError> {
    parse(bytes, format, folder, options).map_err(|Fail { place, kind }| ReadError {
        name: name.to_owned(),
        place,
        kind,
    })
}

fn parse(file: &[u8], format: Format, folder: Option<&Path>, options: ReadOptions<'_>) -> Result<Source, Fail> {
    let ticker = &mut Ticker::new(options.progress);
    let bytes: &[u8] = &plain(file, ticker)?;
    ticker.start(Phase::Parse, bytes.len() as u64);
    let mut soup = match format {
        Format::Off => off::read(bytes, ticker),
        Format::Obj => obj::read(bytes, ticker),
        Format::Ply => ply::read(bytes, ticker),
        Format::Stl => stl::read(bytes, ticker),
        Format::Glb | Format::Gltf => gltf::read(bytes, folder, ticker),
    }?;
    ticker.at(bytes.len());
    soup.check_size()?;
    soup.triangulate();
    let normals_repaired = soup.repair_normals();

    ticker.start(Phase::Clean, bytes.len() as u64);
    let left_out = soup.vertices_in_file.saturating_sub(soup.mesh.positions.len() as u64);
    let mut report = ReadReport {
        format,
        bytes: file.len() as u64,
        vertices_in_file: soup.vertices_in_file,
        faces_in_file: soup.faces_in_file,
        polygons_triangulated: soup.polygons(),
        faces_too_small: soup.faces_too_small,
        normals_repaired,
        primitives_skipped: soup.primitives_skipped,
        cleaned: CleanReport::default(),
        seams_welded: 0,
        vertices: 0,
        triangles: 0,
    };
    let Soup { mut mesh, .. } = soup;
    if options.clean {
        report.cleaned = clean(&mut mesh);
        report.cleaned.vertices_unreferenced += left_out;
    }
    if options.weld_seams {
        let (joined, cleaned) = weld_seams(&mut mesh);
        report.seams_welded = joined;
        report.cleaned.vertices_unreferenced += cleaned.vertices_unreferenced;
        report.cleaned.triangles_degenerate += cleaned.triangles_degenerate;
        report.cleaned.triangles_duplicate += cleaned.triangles_duplicate;
    }
    if mesh.triangles.is_empty() {
        return Err(Fail::file(ReadErrorKind::NoTriangles { vertices: report.vertices_in_file }));
    }
    ticker.at(bytes.len());
    (report.vertices, report.triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    Ok(Source { mesh, report })
}

/// The bytes of a file, inflated if they are gzip.
fn plain<'a>(file: &'a [u8], ticker: &mut Ticker<'_>) -> Result<Cow<'a, [u8]>, Fail> {
    Ok(if file.starts_with(&[0x1f, 0x8b]) { inflate(file, ticker)?.into() } else { file.into() })
}

/// Inflates gzip of any number of members, within [`MOST_INFLATION`].
fn inflate(file: &[u8], ticker: &mut Ticker<'_>) -> Result<Vec<u8>, Fail> {
    let limit = (file.len() as u64).saturating_mul(MOST_INFLATION).max(ALWAYS_INFLATES_TO);
    ticker.start(Phase::Decompress, file.len() as u64);
    // The last four bytes give the size modulo 2³², of the last member: a hint that damage must not make expensive.
    let hint = file.last_chunk().map_or(0, |&size| u32::from_le_bytes(size) as usize);
    let mut bytes = Vec::with_capacity(hint.min(16 * file.len()));
    let mut decoder = MultiGzDecoder::new(file);
    loop {
        let chunk = (&mut decoder).take(1 << 18).read_to_end(&mut bytes);
        if chunk.map_err(|e| Fail::file(ReadErrorKind::Gzip(e)))? == 0 {
            return Ok(bytes);
        }
        if bytes.len() as u64 > limit {
            return Err(Fail::file(ReadErrorKind::InflatesTooMuch { limit }));
        }
        ticker.at(file.len() - decoder.get_ref().len());
    }
}

/// How to write.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Whether an existing file may be replaced. Default: no.
    pub overwrite: bool,
}

/// Writes a mesh to a file in the format that its ending names, compressed where that is `.gz`.
///
/// The bytes go to a temporary file in the same folder, which gets the name when all is written: at no time is there
/// half a mesh at `path`, and after an error the folder is as it was.
pub fn write(path: impl AsRef<Path>, mesh: &TriangleMesh, options: WriteOptions) -> Result<(), WriteError> {
    let path = path.as_ref();
    let format = Format::from_path(path).map_err(|cause| WriteError::UnknownFormat { path: path.to_owned(), cause })?;
    if let Some((what, remedy)) = refusal(mesh, format) {
        return Err(WriteError::Unsupported { path: path.to_owned(), what, remedy });
    }
    write_whole(path, options, |out| write_to(out, mesh, format))
}

/// Writes what `body` writes to a temporary file beside `path`, compressed where that ends with `.gz`, and moves it
/// there when complete.
fn write_whole(
    path: &Path,
    options: WriteOptions,
    body: impl FnOnce(&mut &mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    if let Ok(there) = fs::symlink_metadata(path) {
        if !(there.is_file() || there.is_symlink() && path.is_file()) {
            return Err(WriteError::NotAFile { path: path.to_owned() });
        }
        if !options.overwrite {
            return Err(WriteError::Exists { path: path.to_owned() });
        }
    }
    write_atomically(path, options, body).map_err(|cause| match cause.kind() {
        io::ErrorKind::AlreadyExists if !options.overwrite => WriteError::Exists { path: path.to_owned() },
        _ => WriteError::Io { path: path.to_owned(), cause },
    })
}

fn write_atomically(
    path: &Path,
    options: WriteOptions,
    body: impl FnOnce(&mut &mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut prefix = OsStr::new(".").to_owned();
    prefix.push(path.file_name().unwrap_or_default());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    #[cfg(unix)]
    {
        // What a file made with `open` gets, less the umask; temporary files are private by default.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    let out = BufWriter::with_capacity(1 << 18, file.as_file_mut());
    if is_gz(path) {
        let mut out = GzEncoder::new(out, Compression::new(6));
        body(&mut (&mut out as &mut dyn Write))?;
        out.finish()?.flush()?;
    } else {
        let mut out = out;
        body(&mut (&mut out as &mut dyn Write))?;
        out.flush()?;
    }
    if options.overwrite { file.persist(path)?.sync_all() } else { file.persist_noclobber(path)?.sync_all() }
}

/// Writes a mesh to a stream, in many small pieces: give it a buffer.
///
/// Columns that the format has no place for are left out (see the table above). Errors are those of the stream, and
/// `InvalidInput` for glTF as JSON and for meshes beyond the format's counts.
pub fn write_to(out: &mut impl Write, mesh: &TriangleMesh, format: Format) -> io::Result<()> {
    if let Some((what, remedy)) = refusal(mesh, format) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{what}; {remedy}")));
    }
    match format {
        Format::Off => off::write(out, mesh),
        Format::Obj => obj::write(out, mesh),
        Format::Ply => ply::write(out, mesh),
        Format::Stl => stl::write(out, mesh),
        Format::Glb | Format::Gltf => gltf::write(out, mesh),
    }
}

/// What a format cannot hold, and what to do.
fn refusal(mesh: &TriangleMesh, format: Format) -> Option<(&'static str, &'static str)> {
    let vertices = mesh.positions.len() as u64;
    let triangles = mesh.triangles.len() as u64;
    match format {
        Format::Gltf => Some(("glTF is written as one binary file only", "use the ending .glb")),
        // Lengths in the container are 32 bits: positions, normals, colours and indices, and room for the JSON.
        Format::Glb if 28 * vertices + 12 * triangles + (1 << 16) > u64::from(u32::MAX) => {
            Some(("a .glb holds no more than 4 GiB", "use .ply, or write fewer triangles"))
        }
        Format::Glb if triangles == 0 => Some(("a .glb cannot hold a mesh without triangles", "use .ply")),
        _ => None,
    }
}
