//! The sections of the model `right_triangles`: heights to bytes and back. `docs/format.md` has them byte by byte.
//!
//! ```text
//! META │ MASK │ BASE │ HTAB │ HGTS: page page page …
//!        if samples are missing   coarse ────▶ fine
//! ```
//!
//! Heights come level by level, each as its difference from the mean of the corners around it, which are known by then:
//! what smooth ground leaves of that is small.

use std::ops::{Range, RangeInclusive};

use glam::{DVec2, Vec2};
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::right_triangles::{Columns, Lattice, Place, Spot, Steps};
use meshfront_mesh::{TriangleMesh, Unit, VertexId};

use crate::container::{self, Section, checksum, u32_at, u64_at};
#[cfg(feature = "write")]
use crate::container::{Codec, Part, assemble};
use crate::edge_collapse::of_ordered_bits;
#[cfg(feature = "write")]
use crate::edge_collapse::ordered_bits;
use crate::error::{Fault, ReadError};
use crate::info::{ColumnInfo, Info, PageInfo};
use crate::parallel::map_all;
use crate::rans::{Decoder, IntModel, decode_int, int_models};
#[cfg(feature = "write")]
use crate::rans::{Encoder, encode_int};

/// The model's name in the header.
pub const MODEL: &str = "right_triangles";

/// Samples in a page that is not the last.
pub const PAGE_SAMPLES: usize = 16_384;

const SECTIONS: [&str; 5] = ["META", "MASK", "BASE", "HTAB", "HGTS"];
const META_LENGTH: usize = 112;
const ROW: usize = 8;
/// A byte of a page stands for at most so many samples: what a file can make its reader allocate is bounded by its
/// length.
const MOST_PER_BYTE: usize = 32;
/// More runs than these are not walked through for a first picture.
const MOST_RUNS: u32 = 1 << 22;
/// Heights are below it.
const MOST_HEIGHT: f32 = 1e9;
/// Bits of the first number of META.
const HAS_STEPS: u32 = 1;
const HAS_MISSING: u32 = 2;

/// What META holds.
struct Meta {
    flags: u32,
    columns: u32,
    rows: u32,
    source: SourceCounts,
    floor_error: f32,
    spacing: DVec2,
    steps: Option<Steps>,
    place: Place,
}

const SIGN: u32 = 1 << 31;

/// Heights as whole numbers of either sign.
#[cfg(feature = "write")]
fn number(steps: Option<Steps>, height: f32) -> u32 {
    match steps {
        Some(steps) => steps.nearest(height) as u32,
        // Turned so that numbers of both signs grow with heights.
        None => ordered_bits(height) ^ SIGN,
    }
}
fn height(steps: Option<Steps>, number: u32) -> f32 {
    match steps {
        Some(steps) => steps.height(number as i32 as i64),
        None => of_ordered_bits(number ^ SIGN),
    }
}

/// What a sample is expected to be: the mean of the corners around it that are there.
#[inline]
fn expected(lattice: &Lattice, spot: &Spot, at: impl Fn(i32, i32) -> Option<u32>) -> u32 {
    let (site, mut sum, mut count) = (spot.site(), 0i64, 0i64);
    for [dx, dy] in site.corners() {
        let (x, y) = (site.x + dx, site.y + dy);
        if (spot.is_inner() || lattice.contains(x, y))
            && let Some(number) = at(x, y)
        {
            (sum, count) = (sum + number as i32 as i64, count + 1);
        }
    }
    match count {
        0 => 0,
        // Nearly always, and quicker than a division.
        4 => (sum >> 2) as u32,
        _ => sum.div_euclid(count) as u32,
    }
}

/// Models for magnitudes after a magnitude: rough ground stays rough.
const CONTEXTS: usize = 6;
fn context(class: usize) -> usize {
    (class / 3).min(CONTEXTS - 1)
}

/// Triangles of the full mesh, and samples that are there.
#[cfg(feature = "write")]
fn counts(columns: &Columns) -> SourceCounts {
    let w = columns.columns as usize;
    let there = |x: usize, y: usize| !columns.heights[y * w + x].is_nan();
    let mut triangles = 0;
    for y in 0..columns.rows as usize - 1 {
        for x in 0..w - 1 {
            let [sw, se, nw, ne] = [there(x, y), there(x + 1, y), there(x, y + 1), there(x + 1, y + 1)];
            // Cells are cut through the corners whose coordinates add up to even numbers.
            let cut =
                if (x + y) % 2 == 0 { [sw && se && ne, sw && ne && nw] } else { [sw && se && nw, se && ne && nw] };
            triangles += u32::from(cut[0]) + u32::from(cut[1]);
        }
    }
    let vertices = columns.heights.iter().filter(|h| !h.is_nan()).count() as u32;
    SourceCounts { vertices, triangles }
}

fn unit_number(unit: Unit) -> u32 {
    match unit {
        Unit::Unknown => 0,
        Unit::Metre => 1,
        Unit::Foot => 2,
        Unit::UsSurveyFoot => 3,
        Unit::Degree => 4,
        Unit::ArcSecond => 5,
    }
}
fn unit_of(number: u32) -> Option<Unit> {
    let all = [Unit::Unknown, Unit::Metre, Unit::Foot, Unit::UsSurveyFoot, Unit::Degree, Unit::ArcSecond];
    all.into_iter().find(|&unit| unit_number(unit) == number)
}

/// Columns as the bytes of a file, whole. The same columns give the same bytes, on any number of threads, and come back
/// from [`decode`] bit for bit.
///
/// # Errors
/// Columns that are no terrain, or heights that are not whole steps where there are steps.
#[cfg(feature = "write")]
pub fn encode(columns: &Columns) -> Result<Vec<u8>, crate::EncodeError> {
    use meshfront_hierarchies::right_triangles::InvalidHeights;
    columns.check()?;
    let steps = columns.steps;
    let off_step = |h: f32| steps.is_some_and(|s| i32::try_from(s.nearest(h)).is_err() || s.height(s.nearest(h)) != h);
    let chunks: Vec<_> = columns.heights.chunks(PAGE_SAMPLES).collect();
    // Each is asked for by its neighbours as well.
    let numbers = map_all(chunks.into_iter().enumerate().collect(), |(chunk, heights): (usize, &[f32])| {
        let numbers = heights.iter().enumerate().map(|(i, &height)| match height {
            height if height.is_nan() => Ok(0),
            height if off_step(height) => Err(InvalidHeights::OffStep(chunk * PAGE_SAMPLES + i)),
            height => Ok(number(steps, height)),
        });
        numbers.collect::<Result<Vec<u32>, _>>()
    });
    let numbers = numbers.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
    let lattice = Lattice::new(columns.columns, columns.rows);
    let has_missing = columns.heights.iter().any(|h| h.is_nan());
    let at = |x: i32, y: i32| {
        let i = y as usize * lattice.columns as usize + x as usize;
        (!has_missing || !columns.heights[i].is_nan()).then(|| numbers[i])
    };

    let ids: Vec<_> = (0..lattice.len()).step_by(PAGE_SAMPLES).collect();
    let pages = map_all(ids, |first| {
        let last = lattice.len().min(first + PAGE_SAMPLES);
        let mut encoder = Encoder::default();
        let (mut models, mut class): ([IntModel; CONTEXTS], usize) = (int_models(), 0);
        for spot in lattice.spots(first as u32..last as u32) {
            let site = spot.site();
            if let Some(number) = at(site.x, site.y) {
                let residual = number.wrapping_sub(expected(&lattice, &spot, at)) as i32;
                class = encode_int(&mut encoder, &mut models[context(class)], residual);
            }
        }
        let stream = encoder.finish();
        let mut page = (stream.len() as u32).to_le_bytes().to_vec();
        page.extend_from_slice(&stream);
        page.resize(page.len().max((last - first).div_ceil(MOST_PER_BYTE)), 0);
        page
    });
    let mut table = Vec::with_capacity(ROW * pages.len());
    for page in &pages {
        table.extend_from_slice(&(page.len() as u32).to_le_bytes());
        table.extend_from_slice(&checksum(page).to_le_bytes());
    }
    let corners = lattice.corners().map(|[x, y]| at(x, y).unwrap_or(0).to_le_bytes());
    let base = corners.collect::<Vec<_>>().concat();

    let stored = |name, bytes| Part { name, codec: Codec::Stored, bytes };
    let coded = |name, bytes| Part { name, codec: Codec::Rans, bytes };
    let mut parts = vec![stored("META", encode_meta(columns, has_missing))];
    if has_missing {
        parts.push(coded("MASK", encode_mask(&columns.heights)));
    }
    parts.extend([stored("BASE", base), stored("HTAB", table), coded("HGTS", pages.concat())]);
    Ok(assemble(MODEL, &parts))
}

/// Lengths of runs of samples in turn there and missing, from the south-west, row by row.
#[cfg(feature = "write")]
fn encode_mask(heights: &[f32]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    let mut models: [IntModel; 2] = int_models();
    let mut runs: Vec<u32> = vec![];
    for chunk in heights.chunk_by(|a, b| a.is_nan() == b.is_nan()) {
        if runs.is_empty() && chunk[0].is_nan() {
            runs.push(0);
        }
        runs.push(chunk.len() as u32);
    }
    for (i, &run) in runs.iter().enumerate() {
        encode_int(&mut encoder, &mut models[i % 2], run as i32);
    }
    let mut bytes = (runs.len() as u32).to_le_bytes().to_vec();
    bytes.extend_from_slice(&encoder.finish());
    bytes
}

/// Calls `run` with samples that follow each other, and whether they are missing.
fn decode_runs(section: Section, samples: usize, mut run: impl FnMut(Range<usize>, bool)) -> Result<(), Fault> {
    if section.bytes.len() < 4 {
        return Err(section.fault(0, "length"));
    }
    let runs = u32_at(section.bytes, 0) as usize;
    if runs > samples + 1 {
        return Err(section.fault(0, "more runs than samples"));
    }
    let mut decoder = Decoder::new(&section.bytes[4..]);
    let mut models: [IntModel; 2] = int_models();
    let mut at = 0;
    for i in 0..runs {
        let (length, _) = decode_int(&mut decoder, &mut models[i % 2]);
        if length < 0 || length as usize > samples - at || (length == 0 && i > 0) {
            return Err(section.fault(4, "a run of samples is too long or empty"));
        }
        run(at..at + length as usize, i % 2 == 1);
        at += length as usize;
    }
    if at != samples || !decoder.finish() {
        return Err(section.fault(4, "runs do not add up to all samples"));
    }
    Ok(())
}

fn decode_mask(section: Section, samples: usize) -> Result<Vec<bool>, Fault> {
    let mut missing = vec![];
    missing.try_reserve_exact(samples).map_err(|_| section.fault(0, "too many samples for this machine's memory"))?;
    decode_runs(section, samples, |run, is_missing| missing.resize(run.end, is_missing))?;
    Ok(missing)
}

#[cfg(feature = "write")]
fn encode_meta(columns: &Columns, has_missing: bool) -> Vec<u8> {
    let Columns { columns: w, rows, spacing, steps, floor_error, place, .. } = columns;
    let flags = if steps.is_some() { HAS_STEPS } else { 0 } | if has_missing { HAS_MISSING } else { 0 };
    let source = counts(columns);
    let mut bytes = Vec::with_capacity(META_LENGTH);
    for count in [flags, *w, *rows, source.vertices, source.triangles, floor_error.to_bits()] {
        bytes.extend_from_slice(&count.to_le_bytes());
    }
    let Steps { zero, step } = steps.unwrap_or(Steps { zero: 0.0, step: 0.0 });
    let Place { origin, horizontal, spacing: source_spacing, vertical, exaggeration } = place;
    for x in [spacing.x, spacing.y, zero, step, origin.x, origin.y, source_spacing.x, source_spacing.y] {
        bytes.extend_from_slice(&x.to_le_bytes());
    }
    for x in [unit_number(*horizontal), unit_number(*vertical), exaggeration.to_bits(), 0, 0, 0] {
        bytes.extend_from_slice(&x.to_le_bytes());
    }
    bytes
}

fn decode_meta(section: Section) -> Result<Meta, Fault> {
    let bytes = section.bytes;
    if bytes.len() != META_LENGTH {
        return Err(section.fault(0, "length is not 112"));
    }
    let word = |i: usize| u32_at(bytes, 4 * i);
    let real = |i: usize| f64::from_bits(u64_at(bytes, 24 + 8 * i));
    let unit = |at: usize| unit_of(u32_at(bytes, at)).ok_or(section.fault(at, "unknown unit"));
    let flags = word(0);
    if flags > HAS_STEPS | HAS_MISSING {
        return Err(section.fault(0, "unknown flags"));
    }
    if bytes[100..].iter().any(|&b| b != 0) {
        return Err(section.fault(100, "what is reserved is not zero"));
    }
    let finite = (0..8).all(|i| real(i).is_finite()) && f32::from_bits(u32_at(bytes, 96)).is_finite();
    if !finite {
        return Err(section.fault(24, "a number is not finite"));
    }
    let meta = Meta {
        flags,
        columns: word(1),
        rows: word(2),
        source: SourceCounts { vertices: word(3), triangles: word(4) },
        floor_error: f32::from_bits(word(5)),
        spacing: DVec2::new(real(0), real(1)),
        steps: (flags & HAS_STEPS != 0).then(|| Steps { zero: real(2), step: real(3) }),
        place: Place {
            origin: DVec2::new(real(4), real(5)),
            spacing: DVec2::new(real(6), real(7)),
            horizontal: unit(88)?,
            vertical: unit(92)?,
            exaggeration: f32::from_bits(u32_at(bytes, 96)),
        },
    };
    // The rest is checked on columns without heights, before anything is allocated for them.
    let shell = Columns { heights: vec![], ..meta.columns_of(vec![]) };
    shell.check_shape().map_err(|_| section.fault(4, "sizes or spacing are out of range"))?;
    Ok(meta)
}

impl Meta {
    fn columns_of(&self, heights: Vec<f32>) -> Columns {
        Columns {
            columns: self.columns,
            rows: self.rows,
            spacing: self.spacing,
            heights,
            steps: self.steps,
            floor_error: self.floor_error,
            place: self.place,
        }
    }
}

/// A file whose sections are known to be there.
struct Opened<'a> {
    meta: Meta,
    sections: Vec<Section<'a>>,
}

impl<'a> Opened<'a> {
    fn new(bytes: &'a [u8], file: &str) -> Result<Opened<'a>, ReadError> {
        let sections = container::open(bytes, file, &SECTIONS)?;
        let missing = |name| Fault { section: name, offset: 0, reason: "is missing" }.in_file(file);
        let get = |name: &str| sections.iter().find(|s| s.name == name).copied();
        let meta = decode_meta(get("META").ok_or_else(|| missing("META"))?).map_err(|f| f.in_file(file))?;
        for name in SECTIONS {
            let expected = name != "MASK" || meta.flags & HAS_MISSING != 0;
            match get(name) {
                None if expected => return Err(missing(name)),
                Some(section) if !expected => {
                    return Err(section.fault(0, "is there, but META says that it is not").in_file(file));
                }
                _ => {}
            }
        }
        Ok(Opened { meta, sections })
    }
    fn section(&self, name: &str) -> Section<'a> {
        *self.sections.iter().find(|s| s.name == name).expect("compared with META")
    }
    /// The pages, each with the id of its first sample.
    fn pages(&self, lattice: &Lattice) -> Result<Vec<(usize, Section<'a>)>, Fault> {
        let (table, body) = (self.section("HTAB"), self.section("HGTS"));
        let count = lattice.len().div_ceil(PAGE_SAMPLES);
        if table.bytes.len() != ROW * count {
            return Err(table.fault(0, "has not one row per page"));
        }
        let mut at = 0;
        let mut pages = Vec::with_capacity(count);
        for page in 0..count {
            let first = page * PAGE_SAMPLES;
            let samples = PAGE_SAMPLES.min(lattice.len() - first);
            let length = u32_at(table.bytes, ROW * page) as usize;
            if length > body.bytes.len() - at || length < samples.div_ceil(MOST_PER_BYTE).max(4) {
                return Err(table.fault(ROW * page, "length of a page is out of range"));
            }
            let bytes = &body.bytes[at..at + length];
            let section = Section { bytes, offset: body.offset + at, ..body };
            if checksum(bytes) != u32_at(table.bytes, ROW * page + 4) {
                return Err(section.fault(0, "checksum of a page is wrong"));
            }
            pages.push((first, section));
            at += length;
        }
        if at != body.bytes.len() {
            return Err(body.fault(at, "is longer than its pages"));
        }
        Ok(pages)
    }
}

/// The columns of a file that lies in memory. `file` is what errors call it.
///
/// Every byte is covered by a checksum, and every number is checked before it is used or allocated for: memory stays
/// below 600 bytes for each byte of the file, whatever the file says.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn decode(bytes: &[u8], file: &str) -> Result<Columns, ReadError> {
    let opened = Opened::new(bytes, file)?;
    decode_opened(&opened).map_err(|fault| fault.in_file(file))
}

fn decode_opened(opened: &Opened) -> Result<Columns, Fault> {
    let meta = &opened.meta;
    let lattice = Lattice::new(meta.columns, meta.rows);
    let pages = opened.pages(&lattice)?;
    let samples = meta.columns as usize * meta.rows as usize;
    let missing = match meta.flags & HAS_MISSING {
        0 => None,
        _ => Some(decode_mask(opened.section("MASK"), samples)?),
    };
    let is_missing = |i: usize| missing.as_ref().is_some_and(|m| m[i]);
    let index = |x: i32, y: i32| y as usize * lattice.columns as usize + x as usize;
    let base = opened.section("BASE");
    if base.bytes.len() != 4 * lattice.corners().count() {
        return Err(base.fault(0, "has not one height per corner"));
    }

    let residuals = map_all(pages, |(first, page)| {
        let last = lattice.len().min(first + PAGE_SAMPLES);
        let length = u32_at(page.bytes, 0) as usize;
        let stream = page.bytes.get(4..4 + length).ok_or(page.fault(0, "the stream is longer than its page"))?;
        if page.bytes[4 + length..].iter().any(|&b| b != 0) {
            return Err(page.fault(4 + length, "a page goes on after its end"));
        }
        let mut decoder = Decoder::new(stream);
        let (mut models, mut class): ([IntModel; CONTEXTS], usize) = (int_models(), 0);
        let mut residuals = vec![0i32; last - first];
        for (spot, residual) in lattice.spots(first as u32..last as u32).zip(&mut residuals) {
            if missing.is_some() {
                let site = spot.site();
                if is_missing(index(site.x, site.y)) {
                    continue;
                }
            }
            (*residual, class) = decode_int(&mut decoder, &mut models[context(class)]);
        }
        if decoder.finish() { Ok(residuals) } else { Err(page.fault(4, "the stream is damaged")) }
    });
    let mut numbers = vec![0u32; samples];
    for ([x, y], bytes) in lattice.corners().zip(base.bytes.as_chunks::<4>().0) {
        numbers[index(x, y)] = u32::from_le_bytes(*bytes);
    }
    let mut spots = lattice.spots(0..lattice.len() as u32);
    for page in residuals {
        for (residual, spot) in page?.into_iter().zip(&mut spots) {
            let site = spot.site();
            let i = index(site.x, site.y);
            if !is_missing(i) {
                let expected = expected(&lattice, &spot, |x, y| {
                    let i = index(x, y);
                    (!is_missing(i)).then(|| numbers[i])
                });
                numbers[i] = expected.wrapping_add(residual as u32);
            }
        }
    }
    let heights = numbers.into_iter().enumerate();
    let heights = heights.map(|(i, n)| if is_missing(i) { f32::NAN } else { height(meta.steps, n) }).collect();
    let columns = meta.columns_of(heights);
    columns.check().map_err(|_| opened.section("HGTS").fault(0, "a height is not a number below 1e9"))?;
    Ok(columns)
}

/// A coarse surface from the first bytes of a file: of the samples whose heights come first, those on the finest grid that is there
/// as a whole. `body` is what is there of the pages. It covers holes that are smaller than its cells, and ends where its last cell
/// does.
pub(crate) fn base_of(sections: &[Section], body: &[u8]) -> Option<TriangleMesh> {
    let get = |name: &str| sections.iter().find(|s| s.name == name).copied();
    let meta = decode_meta(get("META")?).ok()?;
    let (lattice, table) = (Lattice::new(meta.columns, meta.rows), get("HTAB")?);
    if table.bytes.len() != ROW * lattice.len().div_ceil(PAGE_SAMPLES) {
        return None;
    }
    let page = match table.bytes {
        [] => &[][..],
        row => body.get(..u32_at(row, 0) as usize).filter(|page| checksum(page) == u32_at(row, 4))?,
    };
    // Every second level completes a grid.
    let whole = lattice.levels().enumerate().filter(|(i, level)| i % 2 == 1 && level.end <= PAGE_SAMPLES).last();
    let (end, step) = whole.map_or((0, lattice.side), |(i, level)| (level.end, lattice.side >> (i / 2 + 1)));
    let [across, along] = [lattice.columns, lattice.rows].map(|samples| (samples - 1) / step + 1);
    let index = |x: i32, y: i32| (y / step) as usize * across as usize + (x / step) as usize;
    let length = across as usize * along as usize;

    let mut missing = vec![false; length];
    if meta.flags & HAS_MISSING != 0 {
        let columns = meta.columns as usize;
        let mask = get("MASK").filter(|mask| mask.bytes.len() >= 4 && u32_at(mask.bytes, 0) <= MOST_RUNS)?;
        let on_grid = |samples: RangeInclusive<usize>| {
            (samples.start().next_multiple_of(step as usize)..=*samples.end()).step_by(step as usize)
        };
        let mark = |run: Range<usize>, is_missing: bool| {
            if !is_missing || run.is_empty() {
                return;
            }
            let [first, last] = [run.start, run.end - 1].map(|i| [i % columns, i / columns]);
            for y in on_grid(first[1]..=last[1]) {
                let from = if y == first[1] { first[0] } else { 0 };
                let to = if y == last[1] { last[0] } else { columns - 1 };
                on_grid(from..=to).for_each(|x| missing[index(x as i32, y as i32)] = true);
            }
        };
        decode_runs(mask, columns * meta.rows as usize, mark).ok()?;
    }
    let mut numbers = vec![0u32; length];
    let corners = get("BASE")?.bytes.as_chunks::<4>().0;
    if corners.len() != lattice.corners().count() {
        return None;
    }
    for ([x, y], bytes) in lattice.corners().zip(corners) {
        numbers[index(x, y)] = u32::from_le_bytes(*bytes);
    }
    if end > 0 {
        let mut decoder = Decoder::new(page.get(4..4usize.checked_add(u32_at(page.get(..4)?, 0) as usize)?)?);
        let (mut models, mut class): ([IntModel; CONTEXTS], usize) = (int_models(), 0);
        for spot in lattice.spots(0..end as u32) {
            let site = spot.site();
            let i = index(site.x, site.y);
            if missing[i] {
                continue;
            }
            let residual;
            (residual, class) = decode_int(&mut decoder, &mut models[context(class)]);
            let at = |x: i32, y: i32| (!missing[index(x, y)]).then(|| numbers[index(x, y)]);
            numbers[i] = expected(&lattice, &spot, at).wrapping_add(residual as u32);
        }
    }

    let mut mesh = TriangleMesh::default();
    let mut vertices = vec![None; length];
    for (i, &number) in numbers.iter().enumerate().filter(|&(i, _)| !missing[i]) {
        let height = height(meta.steps, number);
        if height.is_nan() || height.abs() >= MOST_HEIGHT {
            return None;
        }
        let [x, y] = [i % across as usize, i / across as usize].map(|n| (n * step as usize) as f32);
        vertices[i] = Some(VertexId(mesh.positions.len() as u32));
        mesh.positions.push((Vec2::new(x, y) * meta.spacing.as_vec2()).extend(height));
    }
    for (x, y) in (0..along - 1).flat_map(|y| (0..across - 1).map(move |x| (x, y))) {
        let at = |dx: i32, dy: i32| vertices[((y + dy) * across + x + dx) as usize];
        let [sw, se, nw, ne] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let halves = if (x + y) % 2 == 0 { [[sw, se, ne], [sw, ne, nw]] } else { [[sw, se, nw], [se, ne, nw]] };
        mesh.triangles.extend(halves.into_iter().filter_map(|[a, b, c]| Some([a?, b?, c?])));
    }
    (!mesh.triangles.is_empty()).then_some(mesh)
}

/// What a file that lies in memory holds. `file` is what errors call it. Pages are not unpacked.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn inspect(bytes: &[u8], file: &str) -> Result<Info, ReadError> {
    let opened = Opened::new(bytes, file)?;
    let meta = &opened.meta;
    let lattice = Lattice::new(meta.columns, meta.rows);
    let pages = opened.pages(&lattice).map_err(|f| f.in_file(file))?;
    let body = opened.section("HGTS");
    Ok(Info {
        bits: None,
        grid_step: meta.steps.map(|s| s.step),
        updates: lattice.len() as u32,
        floor_error: meta.floor_error,
        columns: vec![ColumnInfo { name: "heights", bytes: body.bytes.len() as u64 }],
        pages: pages
            .iter()
            .map(|(first, page)| PageInfo {
                offset: page.offset as u64,
                bytes: page.bytes.len() as u64,
                first_update: *first as u32,
                updates: PAGE_SAMPLES.min(lattice.len() - first) as u32,
                max_error: None,
            })
            .collect(),
        ..Info::of_file(MODEL, bytes, body.offset, meta.source, &opened.sections)
    })
}
