//! The sections of the model `vertex_pair`: those of `edge_collapse`, but that a page tells of a split what becomes of
//! a star of any size. `docs/format.md` has them byte by byte.
//!
//! Triangles are not stored by their leaves. Reading replays the splits, and each says of each triangle around s whether
//! it goes to u or to v, and what comes in between.

use meshfront_hierarchies::vertex_pair::Columns;
#[cfg(feature = "write")]
use meshfront_hierarchies::vertex_pair::{Forest, InvalidColumns};
use meshfront_mesh::VertexId;

use crate::container::{Section, u32_at};
use crate::edge_collapse::page::{
    PageTarget, check_length, decode_errors, decode_positions, decode_vertex, ended, split,
};
#[cfg(feature = "write")]
use crate::edge_collapse::page::{encode_errors, encode_positions, encode_vertex, join};
use crate::edge_collapse::{self as shared, Meta, Opened, Unpacked};
use crate::error::{Fault, ReadError};
use crate::info::Info;
use crate::rans::{Decoder, IntModel, Model, decode_int, int_models};
#[cfg(feature = "write")]
use crate::rans::{Encoder, encode_int};

/// The model's name in the header.
pub const MODEL: &str = "vertex_pair";

/// Columns of a page, in the order of their streams.
const COLUMNS: [&str; 4] = ["vertex", "stars", "errors", "positions"];

/// What a neighbour of s has been seen as: after or before s in a triangle that went to u or to v.
const AFTER_U: u8 = 1;
const BEFORE_U: u8 = 2;
const AFTER_V: u8 = 4;
const BEFORE_V: u8 = 8;

/// 0 unseen, 1 with u, 2 with v, 3 with both.
fn seen_with(mark: u8) -> usize {
    usize::from(mark & (AFTER_U | BEFORE_U) != 0) + 2 * usize::from(mark & (AFTER_V | BEFORE_V) != 0)
}

/// One model for each kind of symbol.
struct Models {
    /// By what the triangle's other corners were seen with, and which child is nearer.
    side: Vec<Model<2>>,
    /// By how many neighbours were seen with both, up to 3.
    added: [IntModel; 4],
    /// Which neighbour: of the first added triangle, of the rest.
    other: [IntModel; 2],
    far: IntModel,
    /// Where in the triangle: by what the neighbour was seen as.
    place: Vec<Model<PLACES>>,
}

impl Models {
    fn new() -> Models {
        Models {
            side: vec![Model::new(); 32],
            added: int_models(),
            other: int_models(),
            far: IntModel::new(),
            place: vec![Model::new(); 16],
        }
    }
}

/// The live mesh of the replay: as simple as can be.
struct Replay {
    /// Corners of all triangles so far, nodes.
    triangles: Vec<[VertexId; 3]>,
    /// Per node: its triangles, ascending.
    stars: Vec<Vec<u32>>,
    /// Per node: what it was seen as around the s at hand.
    marks: Vec<u8>,
    /// The neighbours of s; after its triangles were told apart, those first that were seen with u and with v.
    ring: Vec<VertexId>,
    indices: Vec<[u32; 3]>,
}

impl Replay {
    /// At the base mesh. `indices`: the integers of all nodes.
    fn new(base: &[[VertexId; 3]], indices: Vec<[u32; 3]>) -> Replay {
        let nodes = indices.len();
        let mut replay =
            Replay { triangles: vec![], stars: vec![vec![]; nodes], marks: vec![0; nodes], ring: vec![], indices };
        base.iter().for_each(|&t| replay.add(t));
        replay
    }

    fn add(&mut self, t: [VertexId; 3]) {
        for corner in t {
            self.stars[corner.ix()].push(self.triangles.len() as u32);
        }
        self.triangles.push(t);
    }

    /// Takes the triangles of s to u and v. `side` codes or decodes where each goes, given a model's number; of a triangle it
    /// hears the number and the corner.
    fn part(&mut self, s: VertexId, [u, v]: [VertexId; 2], mut side: impl FnMut(usize, u32, usize) -> bool) {
        let star = std::mem::take(&mut self.stars[s.ix()]);
        let (mut on_u, mut on_v) = (vec![], vec![]);
        let [p, q] = [u, v].map(|child| self.indices[child.ix()].map(i128::from));
        for number in star {
            let t = self.triangles[number as usize];
            let k = t.iter().position(|&x| x == s).expect("a star holds its centre");
            let (after, before) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            let [a, b] = [after, before].map(|x| self.indices[x.ix()].map(i128::from));
            let nearer_v = (0..3).map(|i| (a[i] + b[i] - p[i] - q[i]) * (q[i] - p[i])).sum::<i128>() > 0;
            let [with_a, with_b] = [after, before].map(|x| seen_with(self.marks[x.ix()]));
            let to_v = side(with_a << 3 | with_b << 1 | usize::from(nearer_v), number, k);
            self.triangles[number as usize][k] = if to_v { v } else { u };
            if to_v { &mut on_v } else { &mut on_u }.push(number);
            for (x, mark) in [(after, AFTER_U), (before, BEFORE_U)] {
                if self.marks[x.ix()] == 0 {
                    self.ring.push(x);
                }
                self.marks[x.ix()] |= if to_v { mark << 2 } else { mark };
            }
        }
        (self.stars[u.ix()], self.stars[v.ix()]) = (on_u, on_v);
        let marks = &self.marks;
        self.ring.sort_by_key(|x| seen_with(marks[x.ix()]) != 3);
    }
    /// How many neighbours were seen with both, up to 3.
    fn between(&self) -> usize {
        self.ring.iter().take(3).filter(|x| seen_with(self.marks[x.ix()]) == 3).count()
    }
    /// Codes a corner of the j-th triangle that comes: by its rank among the neighbours of s, else by its number.
    #[cfg(feature = "write")]
    fn encode_other(&self, encoder: &mut Encoder, models: &mut Models, s: VertexId, w: VertexId, j: usize) {
        let which = self.ring.iter().position(|&x| x == w).unwrap_or(self.ring.len());
        encode_int(encoder, &mut models.other[j.min(1)], which as i32);
        if which == self.ring.len() {
            encode_int(encoder, &mut models.far, w.0.wrapping_sub(s.0) as i32);
        }
    }
    /// Reads what `encode_other` coded; `None` where there is no such neighbour.
    fn decode_other(&self, decoder: &mut Decoder, models: &mut Models, s: VertexId, j: usize) -> Option<VertexId> {
        let which = usize::try_from(decode_int(decoder, &mut models.other[j.min(1)]).0).ok()?;
        match self.ring.get(which) {
            Some(&w) => Some(w),
            None if which > self.ring.len() => None,
            None => Some(VertexId(s.0.wrapping_add(decode_int(decoder, &mut models.far).0 as u32))),
        }
    }
    /// Makes ready for the next split.
    fn forget(&mut self) {
        for x in self.ring.drain(..) {
            self.marks[x.ix()] = 0;
        }
    }
}

/// Ways to put nodes at the corners of a triangle that a split adds: w in one of three places, u or v after it; then u
/// or v in one of three places, w after it.
const PLACES: usize = 12;

/// Of them those with both children.
const WITH_BOTH: usize = 6;

/// The corners of a triangle that a split adds. `before`: the node before the child, where there is but one child.
fn corners(children: [VertexId; 2], w: VertexId, before: Option<VertexId>, place: usize) -> [VertexId; 3] {
    let (k, which) = (place % WITH_BOTH / 2, place % 2);
    let mut t = [w; 3];
    match before {
        None => (t[(k + 1) % 3], t[(k + 2) % 3]) = (children[which], children[1 - which]),
        Some(before) => (t[k], t[(k + 2) % 3]) = (children[which], before),
    }
    t
}

/// Columns as the bytes of a file, whole.
///
/// Errors are rounded with [`round_error_up`](crate::round_error_up); everything else comes back from [`decode`] bit for bit
/// (on a grid, a coordinate of −0 comes back as 0). The same columns give the same bytes, on any number of threads.
///
/// # Errors
/// Columns that are no forest with triangles. Whether errors grow downwards is not checked here.
#[cfg(feature = "write")]
pub fn encode(columns: &Columns) -> Result<Vec<u8>, crate::EncodeError> {
    let Columns { grid, base, vertex, positions, normals, colors, errors, floor_error, source, .. } = columns;
    let (grid, floor_error, source) = (*grid, *floor_error, *source);
    let forest = Forest::of(columns)?;
    if let Some(m) = errors.iter().position(|&e| !crate::round_error_up(e).is_finite()) {
        let reason = "error is not finite";
        return Err(InvalidColumns::Update { update: m as u32, reason }.into());
    }
    if let Some(reason) = grid.and_then(|grid| shared::grid_fault(&grid)) {
        return Err(crate::EncodeError::Grid(reason));
    }
    let splits = shared::Splits { grid, base, vertex, positions, normals, colors, errors, floor_error, source };
    let indices = splits.lattice_indices()?;
    let stars = encode_stars(columns, &forest, indices.clone())?;
    shared::pack_splits(MODEL, &splits, &indices, |range, errors, residuals| {
        let (stars, triangles) = &stars[range.start / shared::PAGE_UPDATES];
        let streams =
            [encode_vertex(&vertex[range.clone()]), stars.clone(), encode_errors(errors), encode_positions(residuals)];
        join(&streams, range.len().max(*triangles))
    })
}

/// The column of stars, page by page, with how many triangles it adds.
#[cfg(feature = "write")]
fn encode_stars(
    columns: &Columns,
    forest: &Forest,
    indices: Vec<[u32; 3]>,
) -> Result<Vec<(Vec<u8>, usize)>, InvalidColumns> {
    let (roots, updates) = (columns.base.positions.len(), columns.vertex.len());
    let mut replay = Replay::new(&columns.base.triangles, indices);
    let first = |m: usize| forest.firsts.get(m).map_or(columns.triangles.len(), |&first| first as usize);
    let mut pages = vec![];
    for range in shared::page_ranges(updates) {
        let triangles = first(range.end) - first(range.start);
        let (mut encoder, mut models) = (Encoder::default(), Models::new());
        for m in range {
            let (s, children) = (columns.vertex[m], [0, 1].map(|k| VertexId((roots + 2 * m + k) as u32)));
            if replay.stars[s.ix()].len() > Columns::MAX_STAR {
                let reason = "its star has too many triangles";
                return Err(InvalidColumns::Update { update: m as u32, reason });
            }
            replay.part(s, children, |context, number, k| {
                let to_v = forest.triangles[number as usize][k] >= forest.middles[m];
                encoder.symbol(&mut models.side[context], usize::from(to_v));
                to_v
            });
            let own = first(m)..first(m + 1);
            encode_int(&mut encoder, &mut models.added[replay.between()], own.len() as i32);
            for (j, number) in own.enumerate() {
                // The active nodes above its leaves: u, v and w in some order.
                let t = columns.triangles[number].map(|leaf| {
                    let mut node = leaf;
                    while let Some(maker) = node.ix().checked_sub(roots).map(|k| k / 2).filter(|&maker| maker > m) {
                        node = columns.vertex[maker];
                    }
                    node
                });
                if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                    let reason = "adds a triangle that has a corner twice";
                    return Err(InvalidColumns::Update { update: m as u32, reason });
                }
                let is_child = |k: usize| children.contains(&t[k % 3]);
                let which = |k: usize| usize::from(t[k % 3] == children[1]);
                let between = (0..3).find(|&k| is_child(k + 1) && is_child(k + 2));
                let (w, place, before) = match between {
                    Some(k) => (t[k], 2 * k + which(k + 1), None),
                    None => {
                        let k = (0..3).find(|&k| is_child(k)).expect("checked");
                        (t[(k + 1) % 3], WITH_BOTH + 2 * k + which(k), Some(t[(k + 2) % 3]))
                    }
                };
                replay.encode_other(&mut encoder, &mut models, s, w, j);
                encoder.symbol(&mut models.place[replay.marks[w.ix()] as usize], place);
                if let Some(before) = before {
                    replay.encode_other(&mut encoder, &mut models, s, before, j);
                }
                replay.add(t);
            }
            replay.forget();
        }
        let mut stream = (triangles as u32).to_le_bytes().to_vec();
        stream.extend_from_slice(&encoder.finish());
        pages.push((stream, triangles));
    }
    Ok(pages)
}

/// The columns of a file that lies in memory. `file` is what errors call it.
///
/// Every byte is covered by a checksum, and every number is checked before it is used or allocated for: memory stays
/// below 256 bytes for each byte of the file. Time follows the sizes of all stars, which have a limit. Whether errors grow downwards is for
/// `VertexPair::new` to check.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn decode(bytes: &[u8], file: &str) -> Result<Columns, ReadError> {
    let opened = Opened::with(bytes, file, &shared::SECTIONS)?;
    decode_opened(&opened).map_err(|fault| fault.in_file(file))
}

/// What of a page can only be read after all pages before it.
struct Stars<'a> {
    stream: Section<'a>,
    updates: usize,
    triangles: usize,
}

fn decode_page<'a>(page: Section<'a>, target: &mut PageTarget) -> Result<Stars<'a>, Fault> {
    let ([vertex, stream, errors, positions], end) = split(page)?;
    if stream.bytes.len() < 4 {
        return Err(stream.fault(0, "the number of triangles is missing"));
    }
    let (updates, triangles) = (target.vertex.len(), u32_at(stream.bytes, 0) as usize);
    if triangles > page.bytes.len() {
        return Err(stream.fault(0, "a page is too short for its triangles"));
    }
    check_length(page, end, updates.max(triangles))?;
    decode_vertex(vertex, target.vertex)?;
    decode_errors(errors, target.errors)?;
    decode_positions(positions, target.residuals)?;
    Ok(Stars { stream, updates, triangles })
}

fn decode_opened(opened: &Opened) -> Result<Columns, Fault> {
    let (unpacked, pages) = shared::unpack_splits(opened, decode_page)?;
    let Unpacked { base, base_indices, vertex, errors, positions, indices, normals, colors } = unpacked;
    let roots = base.positions.len();
    let mut replay = Replay::new(&base.triangles, [base_indices, indices.concat()].concat());
    if base.triangles.iter().any(|t| t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        return Err(opened.section("BASE").fault(0, "a triangle names a vertex twice"));
    }
    let mut split_already = vec![false; replay.stars.len()];
    let mut added = Vec::with_capacity(vertex.len());
    for Stars { stream, updates, triangles } in pages {
        let fault = |reason| stream.fault(4, reason);
        let (mut decoder, mut models) = (Decoder::new(&stream.bytes[4..]), Models::new());
        let mut left = triangles;
        for _ in 0..updates {
            let m = added.len();
            let (s, children) = (vertex[m], [0, 1].map(|k| VertexId((roots + 2 * m + k) as u32)));
            if std::mem::replace(&mut split_already[s.ix()], true) {
                return Err(fault("an update splits a node that is split already"));
            }
            if replay.stars[s.ix()].len() > Columns::MAX_STAR {
                return Err(fault("an update splits a node with too many triangles"));
            }
            replay.part(s, children, |context, _, _| decoder.symbol(&mut models.side[context]) == 1);
            let own = decode_int(&mut decoder, &mut models.added[replay.between()]).0;
            let own = usize::try_from(own).ok().filter(|&own| own <= left);
            let own = own.ok_or(fault("an update adds more triangles than its page has"))?;
            left -= own;
            for j in 0..own {
                let other = |decoder: &mut Decoder, models: &mut Models| {
                    let active = |w: &VertexId| w.ix() < children[0].ix() && !split_already[w.ix()];
                    let w = replay.decode_other(decoder, models, s, j).filter(active);
                    w.ok_or(fault("a triangle ends at a node that is not active"))
                };
                let w = other(&mut decoder, &mut models)?;
                let place = decoder.symbol(&mut models.place[replay.marks[w.ix()] as usize]);
                let before = if place < WITH_BOTH { None } else { Some(other(&mut decoder, &mut models)?) };
                if before == Some(w) {
                    return Err(fault("a triangle has a corner twice"));
                }
                replay.add(corners(children, w, before, place));
            }
            replay.forget();
            added.push(own as u32);
        }
        if left != 0 {
            return Err(fault("a page has more triangles than its updates add"));
        }
        ended(decoder, stream)?;
    }
    let Meta { grid, floor_error, source, .. } = opened.meta;
    let triangles = replay.triangles;
    Ok(Columns { grid, base, triangles, added, vertex, positions, normals, colors, errors, floor_error, source })
}

/// What a file that lies in memory holds. `file` is what errors call it. Pages are not unpacked.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn inspect(bytes: &[u8], file: &str) -> Result<Info, ReadError> {
    shared::inspect_splits(bytes, file, MODEL, COLUMNS)
}
