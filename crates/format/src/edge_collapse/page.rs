//! A page of updates: one stream a column, each understood without any other page.

use meshfront_hierarchies::edge_collapse::{AddedTriangle, Columns, ExplicitSplit};
use meshfront_mesh::VertexId;
use meshfront_refine::UpdateId;

use crate::container::{Section, u32_at};
use crate::error::Fault;
use crate::rans::{Decoder, IntModel, Model, decode_int, int_models};
#[cfg(feature = "write")]
use crate::rans::{Encoder, encode_int};

/// Columns of a page, in the order of their streams.
pub(super) const COLUMNS: [&str; 5] = ["vertex", "sides", "explicit", "errors", "positions"];

/// Low bits of an error that are always zero: what is left is 1/16 of an octave.
pub(super) const ERROR_SHIFT: u32 = 19;

/// Contexts by octave of an integer's class.
const OCTAVES: usize = 32;

/// Differences of both new points from s, per update: edge, then middle.
pub(crate) type Residuals = [[i32; 3]; 2];

/// The models of the position column: all but the first by the octave of the longest part of the edge so far.
struct PositionModels {
    first: IntModel,
    edge: [IntModel; OCTAVES],
    along: [IntModel; OCTAVES],
    across: [IntModel; OCTAVES],
}

impl PositionModels {
    fn new() -> Self {
        PositionModels { first: IntModel::new(), edge: int_models(), along: int_models(), across: int_models() }
    }
}

/// The models of the sides column: two nibbles and what is above them, each by the one before.
struct SidesModels {
    low: Model<16>,
    mid: Vec<Model<16>>,
    high: Vec<Model<16>>,
}

impl SidesModels {
    fn new() -> Self {
        SidesModels { low: Model::new(), mid: vec![Model::new(); 16], high: vec![Model::new(); 16] }
    }
}

/// The columns of some updates that go into one page.
#[cfg(feature = "write")]
pub(super) struct PageSource<'a> {
    pub(super) vertex: &'a [VertexId],
    pub(super) sides: &'a [u32],
    /// The explicit splits among the page's updates.
    pub(super) explicit: &'a [ExplicitSplit],
    /// Rounded up.
    pub(super) errors: &'a [f32],
    pub(super) residuals: &'a [Residuals],
}

#[cfg(feature = "write")]
pub(super) fn encode_page(page: &PageSource) -> Vec<u8> {
    let streams = [
        encode_vertex(page.vertex),
        encode_sides(page.sides),
        encode_explicit(page.explicit),
        encode_errors(page.errors),
        encode_positions(page.residuals),
    ];
    join(&streams, page.vertex.len())
}

/// Streams as a page: their lengths, the streams, zeros up to `least` bytes, so that a reader can bound its memory by the
/// file's size.
#[cfg(feature = "write")]
pub(crate) fn join<const N: usize>(streams: &[Vec<u8>; N], least: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(4 * N + streams.iter().map(Vec::len).sum::<usize>());
    for stream in streams {
        bytes.extend_from_slice(&(stream.len() as u32).to_le_bytes());
    }
    for stream in streams {
        bytes.extend_from_slice(stream);
    }
    bytes.resize(bytes.len().max(least), 0);
    bytes
}

/// Where the columns go that all models of splits have.
pub(crate) struct PageTarget<'a> {
    /// The page's first update.
    pub(crate) first: usize,
    pub(crate) vertex: &'a mut [VertexId],
    pub(crate) errors: &'a mut [f32],
    pub(crate) residuals: &'a mut [Residuals],
}

/// Byte lengths of a page's streams, checked against the page.
pub(crate) fn stream_lengths<const N: usize>(page: Section) -> Result<[usize; N], Fault> {
    if page.bytes.len() < 4 * N {
        return Err(page.fault(0, "page is shorter than its header"));
    }
    let lengths = std::array::from_fn(|i| u32_at(page.bytes, 4 * i) as usize);
    let total = lengths.iter().map(|&l| l as u64).sum::<u64>();
    if total > (page.bytes.len() - 4 * N) as u64 {
        return Err(page.fault(0, "columns are longer than their page"));
    }
    Ok(lengths)
}

/// The streams of a page, and where they end.
pub(crate) fn split<'a, const N: usize>(page: Section<'a>) -> Result<([Section<'a>; N], usize), Fault> {
    let mut at = 4 * N;
    let streams = stream_lengths(page)?.map(|length| {
        let stream = Section { offset: page.offset + at, bytes: &page.bytes[at..at + length], ..page };
        at += length;
        stream
    });
    if page.bytes[at..].iter().any(|&b| b != 0) {
        return Err(page.fault(at, "page holds more than its columns"));
    }
    Ok((streams, at))
}

/// Whether a page whose streams end at `end` is no longer than that, or than `least`.
pub(crate) fn check_length(page: Section, end: usize, least: usize) -> Result<(), Fault> {
    if page.bytes.len() > end.max(least) { Err(page.fault(end, "page holds more than its columns")) } else { Ok(()) }
}

/// Fills the target; returns the page's sides and explicit splits.
pub(super) fn decode_page(page: Section, target: &mut PageTarget) -> Result<(Vec<u32>, Vec<ExplicitSplit>), Fault> {
    let ([vertex, sides, explicit, errors, positions], end) = split(page)?;
    check_length(page, end, target.vertex.len())?;
    decode_vertex(vertex, target.vertex)?;
    let mut masks = vec![0; target.vertex.len()];
    decode_sides(sides, &mut masks)?;
    decode_errors(errors, target.errors)?;
    decode_positions(positions, target.residuals)?;
    let explicit = decode_explicit(explicit, target.first, &masks)?;
    Ok((masks, explicit))
}

pub(crate) fn ended(decoder: Decoder, stream: Section) -> Result<(), Fault> {
    if decoder.finish() { Ok(()) } else { Err(stream.fault(0, "column does not end where its stream does")) }
}

/// How many trails of split vertices are kept: numbers were given in space, octave by octave, so the vertices that
/// split near each other lie in a few stretches of numbers, one an octave.
const TRAILS: usize = 8;
/// A vertex at least so far from every trail begins a new one.
const NEW_TRAIL: u32 = 256;

/// The ends of the trails, the one used last in front.
#[derive(Default)]
struct Trails([u32; TRAILS]);

impl Trails {
    /// The trail whose end is nearest; the first such.
    #[cfg(feature = "write")]
    fn nearest(&self, vertex: u32) -> usize {
        let distance = |&i: &usize| (vertex.wrapping_sub(self.0[i]) as i32).unsigned_abs();
        (0..TRAILS).min_by_key(distance).expect("there are trails")
    }
    /// A trail moves on by `step` to a vertex, which is returned, and comes to the front. A long step leaves the trail
    /// where it is and drops the one that was not used for longest.
    #[inline(always)]
    fn follow(&mut self, trail: usize, step: i32) -> u32 {
        let vertex = self.0[trail].wrapping_add(step as u32);
        let dropped = if step.unsigned_abs() < NEW_TRAIL { trail } else { TRAILS - 1 };
        self.0.copy_within(..dropped, 1);
        self.0[0] = vertex;
        vertex
    }
}

#[cfg(feature = "write")]
pub(crate) fn encode_vertex(vertex: &[VertexId]) -> Vec<u8> {
    let (mut encoder, mut trails) = (Encoder::default(), Trails::default());
    let (mut which, mut steps) = (Model::<TRAILS>::new(), int_models::<TRAILS>());
    for v in vertex {
        let trail = trails.nearest(v.0);
        let step = v.0.wrapping_sub(trails.0[trail]) as i32;
        encoder.symbol(&mut which, trail);
        encode_int(&mut encoder, &mut steps[trail], step);
        trails.follow(trail, step);
    }
    encoder.finish()
}

pub(crate) fn decode_vertex(stream: Section, vertex: &mut [VertexId]) -> Result<(), Fault> {
    let (mut decoder, mut trails) = (Decoder::new(stream.bytes), Trails::default());
    let (mut which, mut steps) = (Model::<TRAILS>::new(), int_models::<TRAILS>());
    for v in vertex {
        let trail = decoder.symbol(&mut which);
        let (step, _) = decode_int(&mut decoder, &mut steps[trail]);
        *v = VertexId(trails.follow(trail, step));
    }
    ended(decoder, stream)
}

/// Of the bits above two nibbles: more than what a symbol can say, so that they follow as they are.
const ESCAPE: usize = 15;

#[cfg(feature = "write")]
fn encode_sides(sides: &[u32]) -> Vec<u8> {
    let (mut encoder, mut models) = (Encoder::default(), SidesModels::new());
    for mask in sides {
        let (low, mid, high) = ((mask & 15) as usize, (mask >> 4 & 15) as usize, (mask >> 8) as usize);
        encoder.symbol(&mut models.low, low);
        encoder.symbol(&mut models.mid[low], mid);
        encoder.symbol(&mut models.high[mid], high.min(ESCAPE));
        if high >= ESCAPE {
            encoder.raw(mask >> 8, 24);
        }
    }
    encoder.finish()
}

fn decode_sides(stream: Section, sides: &mut [u32]) -> Result<(), Fault> {
    let (mut decoder, mut models) = (Decoder::new(stream.bytes), SidesModels::new());
    for mask in sides {
        let low = decoder.symbol(&mut models.low);
        let mid = decoder.symbol(&mut models.mid[low]);
        let mut high = decoder.symbol(&mut models.high[mid]) as u32;
        if high == ESCAPE as u32 {
            high = decoder.raw(24);
        }
        *mask = low as u32 | (mid as u32) << 4 | high << 8;
    }
    ended(decoder, stream)
}

/// Bytes of a run of updates whose errors share an octave: the octave, and how many.
const RUN: usize = 4;
/// Exponent of infinities and NaN.
const NOT_FINITE: u32 = 255;

/// Octave of an error: the exponent bits. What is below are its sixteenths.
#[cfg(feature = "write")]
fn octave_of(error: f32) -> u32 {
    error.to_bits() >> 23
}

/// Runs, the sixteenths.
#[cfg(feature = "write")]
pub(crate) fn encode_errors(errors: &[f32]) -> Vec<u8> {
    let runs: Vec<_> = errors.chunk_by(|&a, &b| octave_of(a) == octave_of(b)).collect();
    let mut bytes = (runs.len() as u32).to_le_bytes().to_vec();
    for run in runs {
        bytes.extend_from_slice(&((run.len() as u32) << 8 | octave_of(run[0])).to_le_bytes());
    }
    let (mut encoder, mut sixteenths) = (Encoder::default(), Model::<16>::new());
    for error in errors {
        encoder.symbol(&mut sixteenths, (error.to_bits() >> ERROR_SHIFT & 15) as usize);
    }
    bytes.extend_from_slice(&encoder.finish());
    bytes
}

pub(crate) fn decode_errors(stream: Section, errors: &mut [f32]) -> Result<(), Fault> {
    let Some((count, rest)) = stream.bytes.split_first_chunk::<4>() else {
        return Err(stream.fault(0, "octaves are missing"));
    };
    let count = u32::from_le_bytes(*count) as usize;
    if count > rest.len() / RUN {
        return Err(stream.fault(0, "octaves are missing"));
    }
    let (runs, sixteenths) = rest.split_at(RUN * count);
    let mut at = 0;
    for run in 0..count {
        let number = u32_at(runs, RUN * run);
        let (octave, length) = (number & 255, number as usize >> 8);
        if octave == NOT_FINITE || length > errors.len() - at {
            return Err(stream.fault(RUN * run, "an error is not finite, or has no update"));
        }
        errors[at..at + length].fill(f32::from_bits(octave << 23));
        at += length;
    }
    if at != errors.len() {
        return Err(stream.fault(0, "an update has no error"));
    }
    let (mut decoder, mut model) = (Decoder::new(sixteenths), Model::<16>::new());
    for error in errors {
        *error = f32::from_bits(error.to_bits() | (decoder.symbol(&mut model) as u32) << ERROR_SHIFT);
    }
    ended(decoder, stream)
}

/// The axis on which an edge is longest; the first such.
#[inline(always)]
fn main_axis(edge: [i32; 3]) -> usize {
    let [x, y, z] = edge.map(i32::unsigned_abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Where the middle lies on another axis if it lies on the line of the edge, as it nearly does: the best place for s is
/// somewhere along the edge. In `f64`, truncated, so that readers in any language agree; 0 for an edge without length.
#[inline(always)]
fn across(along: i32, edge_main: i32, edge_other: i32) -> i32 {
    (along as f64 * edge_other as f64 / edge_main as f64) as i32
}

#[cfg(feature = "write")]
pub(crate) fn encode_positions(residuals: &[Residuals]) -> Vec<u8> {
    let (mut encoder, mut models) = (Encoder::default(), PositionModels::new());
    for [edge, middle] in residuals {
        let mut largest = encode_int(&mut encoder, &mut models.first, edge[0]);
        for axis in 1..3 {
            largest = largest.max(encode_int(&mut encoder, &mut models.edge[largest / 2], edge[axis]));
        }
        let axes = [main_axis(*edge), (main_axis(*edge) + 1) % 3, (main_axis(*edge) + 2) % 3];
        let along = middle[axes[0]];
        encode_int(&mut encoder, &mut models.along[largest / 2], along);
        for axis in [axes[1], axes[2]] {
            let guess = across(along, edge[axes[0]], edge[axis]);
            encode_int(&mut encoder, &mut models.across[largest / 2], middle[axis].wrapping_sub(guess));
        }
    }
    encoder.finish()
}

pub(crate) fn decode_positions(stream: Section, residuals: &mut [Residuals]) -> Result<(), Fault> {
    let (mut decoder, mut models) = (Decoder::new(stream.bytes), PositionModels::new());
    for [edge, middle] in residuals {
        let (x, mut largest) = decode_int(&mut decoder, &mut models.first);
        edge[0] = x;
        for axis in 1..3 {
            let (value, class) = decode_int(&mut decoder, &mut models.edge[largest / 2]);
            edge[axis] = value;
            largest = largest.max(class);
        }
        let axis = main_axis(*edge);
        let (along, _) = decode_int(&mut decoder, &mut models.along[largest / 2]);
        middle[axis] = along;
        for other in [(axis + 1) % 3, (axis + 2) % 3] {
            let guess = across(along, edge[axis], edge[other]);
            middle[other] = guess.wrapping_add(decode_int(&mut decoder, &mut models.across[largest / 2]).0);
        }
    }
    ended(decoder, stream)
}

/// Bits of an added triangle's byte.
const STAR: u8 = 0x1f;
const BEFORE: u8 = 0x20;
const FLIPPED: u8 = 0x40;

#[cfg(feature = "write")]
fn encode_explicit(explicit: &[ExplicitSplit]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for split in explicit {
        bytes.push(split.added.len() as u8);
        bytes.extend(
            split
                .added
                .iter()
                .map(|t| t.star | if t.before { BEFORE } else { 0 } | if t.flipped { FLIPPED } else { 0 }),
        );
    }
    bytes
}

fn decode_explicit(stream: Section, first: usize, sides: &[u32]) -> Result<Vec<ExplicitSplit>, Fault> {
    let mut explicit = Vec::new();
    let mut rest = stream.bytes;
    for (i, mask) in sides.iter().enumerate() {
        if mask & Columns::EXPLICIT == 0 {
            continue;
        }
        let at = stream.bytes.len() - rest.len();
        let (&count, after) = rest.split_first().ok_or(stream.fault(at, "explicit splits are missing"))?;
        let added = after.get(..count as usize).ok_or(stream.fault(at, "an explicit split is cut off"))?;
        if added.iter().any(|&t| t & !(STAR | BEFORE | FLIPPED) != 0 || (t & STAR) as usize >= Columns::MAX_STAR) {
            return Err(stream.fault(at, "an added triangle is outside of the largest star"));
        }
        rest = &after[count as usize..];
        explicit.push(ExplicitSplit {
            update: UpdateId((first + i) as u32),
            added: added
                .iter()
                .map(|&t| AddedTriangle { star: t & STAR, before: t & BEFORE != 0, flipped: t & FLIPPED != 0 })
                .collect(),
        });
    }
    if !rest.is_empty() {
        return Err(stream.fault(stream.bytes.len() - rest.len(), "more explicit splits than updates that have one"));
    }
    Ok(explicit)
}
