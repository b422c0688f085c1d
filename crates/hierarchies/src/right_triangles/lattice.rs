//! Where updates are: ids, samples and neighbours are arithmetic.
//!
//! The samples lie in the lower left of a square whose side n is a power of two. An update stands for a sample v that is
//! the middle of a hypotenuse; with h the greatest power of two that divides both of its coordinates:
//!
//! ```text
//!   diagonal: both coordinates are odd multiples of h     straight: one of them is
//!
//!     e-----p          p, p: the right angles of the            p
//!     | \   |          two triangles of M⁻, and at the        / | \
//!     |   v |          same time the updates that made       e--v--e
//!     |     \|         them: what v needs                     \ | /
//!     p-----e          e, e: ends of the hypotenuse             p
//! ```
//!
//! Ids go level by level, coarse to fine (diagonal before straight for the same h), in each by rows from the south.

use std::array::from_fn;

/// A sample that an update stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Column.
    pub x: i32,
    /// Row, from the south.
    pub y: i32,
    /// Half the hypotenuse's extent along an axis, in samples.
    pub h: i32,
    /// Whether the hypotenuse is diagonal to rows and columns.
    pub diagonal: bool,
}

/// In place of an id: a corner of the square, or outside of the field.
pub(super) const NOWHERE: u32 = u32::MAX;

/// A step between samples.
type Way = [i32; 2];

impl Site {
    /// Steps from v to the right angles of its two triangles.
    #[inline]
    pub fn apexes(&self) -> [Way; 2] {
        let bits = self.h.trailing_zeros();
        APEXES[turn(self.diagonal, self.x >> bits, self.y >> bits)].map(|way| way.map(|step| step * self.h))
    }
    /// Steps from v to all four corners of its two triangles.
    #[inline]
    pub fn corners(&self) -> [Way; 4] {
        let h = self.h;
        if self.diagonal { [[-h, -h], [h, -h], [-h, h], [h, h]] } else { [[-h, 0], [h, 0], [0, -h], [0, h]] }
    }
    /// Steps from v to the middles of the hypotenuses of the triangles around it once it is applied; doubled, since those
    /// of the finest triangles lie between samples.
    #[inline]
    pub fn middles_doubled(&self) -> [Way; 4] {
        let h = self.h;
        if self.diagonal {
            [[-2 * h, 0], [2 * h, 0], [0, -2 * h], [0, 2 * h]]
        } else {
            [[-h, -h], [h, -h], [-h, h], [h, h]]
        }
    }
}

/// Which of the four triangles around an apex has its hypotenuse in a direction.
#[inline]
pub(super) const fn quarter(way: Way) -> usize {
    match way {
        [0, dy] => 2 + (dy > 0) as usize,
        [dx, 0] => (dx > 0) as usize,
        [dx, dy] => (dx > 0) as usize + 2 * (dy > 0) as usize,
    }
}

/// How the two triangles of an update lie: a number below four.
#[inline]
fn turn(diagonal: bool, x: i32, y: i32) -> usize {
    // Corners of diagonal ones are in units of 2h; their coordinates add up to even numbers at the ends of the hypotenuse.
    let odd = if diagonal { (x >> 1) + (y >> 1) } else { x } & 1;
    2 * usize::from(!diagonal) + odd as usize
}

/// Per turn: steps from v to the right angles of its triangles, in units of h.
pub(super) const APEXES: [[Way; 2]; 4] = [[[1, -1], [-1, 1]], [[-1, -1], [1, 1]], [[-1, 0], [1, 0]], [[0, -1], [0, 1]]];

/// The four diagonal neighbours of a place.
#[inline]
fn around(x: i32, y: i32) -> [Way; 4] {
    [[x - 1, y - 1], [x + 1, y - 1], [x - 1, y + 1], [x + 1, y + 1]]
}

/// Samples of one level: a row of `odd` ones (x an odd multiple of h), then for straight levels one of `even` ones.
#[derive(Clone, Copy, Debug)]
struct Level {
    first: u32,
    h: u32,
    odd: u32,
    even: u32,
    diagonal: bool,
    /// The last column and the last row of the field, in units of h.
    most: [u32; 2],
}

impl Level {
    /// The id of a sample of this level, by its column and row in units of h; [`NOWHERE`] outside of the field.
    #[inline]
    fn id(&self, x: i32, y: i32) -> u32 {
        let (x, y) = (x as u32, y as u32);
        if x > self.most[0] || y > self.most[1] { NOWHERE } else { self.inside(x, y) }
    }
    /// The same, for a sample of the field. A diagonal level has no odd rows of its own: y >> 1 is its line.
    #[inline]
    fn inside(&self, x: u32, y: u32) -> u32 {
        let skipped = if self.diagonal { 0 } else { (y & 1) * self.odd };
        self.first + (y >> 1) * self.line() + skipped + (x >> 1)
    }
    /// What is at a place in a line.
    #[inline]
    fn spot(&self, level: usize, line: u32, column: u32) -> Spot {
        let &Level { first, h, odd, diagonal, most, .. } = self;
        let (x, y) = match (diagonal, column < odd) {
            (true, _) => (2 * column + 1, 2 * line + 1),
            (false, true) => (2 * column + 1, 2 * line),
            (false, false) => (2 * (column - odd), 2 * line + 1),
        };
        let within = |c: u32, most: u32| most >= 4 && c.wrapping_sub(2) <= most - 4;
        let inner = within(x, most[0]) && within(y, most[1]);
        let id = first + line * self.line() + column;
        Spot { level, id, diagonal, inner, h: h as i32, x: x as i32, y: y as i32 }
    }
    /// Ids from one line (for straight levels: two rows) to the next.
    #[inline]
    fn line(&self) -> u32 {
        self.odd + self.even
    }
}

/// A sample that an update stands for, as its neighbours are found from it.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Number of its level, from 0.
    pub level: usize,
    id: u32,
    diagonal: bool,
    /// All neighbours are of the field, and none of them is a corner of the square.
    inner: bool,
    h: i32,
    /// Column and row in units of h.
    x: i32,
    y: i32,
}

impl Spot {
    /// Half the hypotenuse's extent along an axis, in samples.
    #[inline]
    pub(super) fn h(&self) -> i32 {
        self.h
    }
    /// Whether all of its neighbours are there: that is so away from borders, and where a level has more than four columns and rows.
    #[inline]
    pub fn is_inner(&self) -> bool {
        self.inner
    }
    /// How its triangles lie.
    #[inline]
    pub(super) fn turn(&self) -> usize {
        turn(self.diagonal, self.x, self.y)
    }
    /// Where it is.
    #[inline]
    pub fn site(&self) -> Site {
        Site { x: self.x * self.h, y: self.y * self.h, h: self.h, diagonal: self.diagonal }
    }
}

/// Ids of samples: all of a field but those in corners of the square.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Samples from west to east.
    pub columns: i32,
    /// Samples from south to north.
    pub rows: i32,
    /// Side of the square that all of them lie in: a power of two.
    pub side: i32,
    levels: Vec<Level>,
    /// Per number of leading zeros of an id: the first level that such an id can be in.
    hints: [u8; 33],
    len: u32,
}

impl Lattice {
    /// Of a field of at least 2 × 2 samples, and at most 65537 × 65537.
    pub fn new(columns: u32, rows: u32) -> Lattice {
        let (w, r) = (columns - 1, rows - 1);
        let side = w.max(r).next_power_of_two();
        let (mut levels, mut len) = (vec![], 0);
        let mut h = side / 2;
        while h > 0 {
            let odd = |most: u32| (most / h).div_ceil(2);
            let even = w / (2 * h) + 1;
            let most = [w / h, r / h];
            levels.push(Level { first: len, h, odd: odd(w), even: 0, diagonal: true, most });
            len += odd(w) * odd(r);
            levels.push(Level { first: len, h, odd: odd(w), even, diagonal: false, most });
            let lines = r / h + 1;
            len += lines / 2 * (odd(w) + even) + lines % 2 * odd(w);
            h /= 2;
        }
        let hints = from_fn(|zeros| {
            let least = if zeros == 32 { 0 } else { (1u64 << (31 - zeros)) as u32 };
            levels.partition_point(|level: &Level| level.first <= least).saturating_sub(1) as u8
        });
        Lattice { columns: columns as i32, rows: rows as i32, side: side as i32, levels, hints, len }
    }

    /// Samples of the field that have no id.
    pub fn corners(&self) -> impl Iterator<Item = [i32; 2]> {
        let all = [[0, 0], [self.side, 0], [0, self.side], [self.side; 2]];
        all.into_iter().filter(|&[x, y]| self.contains(x, y))
    }
    /// Whether there is no id.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
    /// Number of ids.
    pub fn len(&self) -> usize {
        self.len as usize
    }
    /// Ids of each level, coarse to fine.
    pub fn levels(&self) -> impl DoubleEndedIterator<Item = std::ops::Range<usize>> {
        let ends = self.levels.iter().skip(1).map(|l| l.first).chain([self.len]);
        self.levels
            .iter()
            .map(|l| l.first)
            .zip(ends)
            .map(|(a, b)| a as usize..b as usize)
            .collect::<Vec<_>>()
            .into_iter()
    }
    /// Number of an id's level, from 0.
    #[inline]
    pub fn level_of(&self, id: u32) -> usize {
        let mut level = self.hints[id.leading_zeros() as usize] as usize;
        while self.levels.get(level + 1).is_some_and(|next| next.first <= id) {
            level += 1;
        }
        level
    }

    /// The sample of an id, with its level.
    #[inline]
    pub fn spot(&self, id: u32) -> Spot {
        let level = self.level_of(id);
        let at = &self.levels[level];
        let i = id - at.first;
        at.spot(level, i / at.line(), i % at.line())
    }
    /// The samples of ids that follow each other: no search and no division for each.
    pub fn spots(&self, ids: std::ops::Range<u32>) -> impl Iterator<Item = Spot> {
        let mut level = if ids.is_empty() { 0 } else { self.level_of(ids.start) };
        let (mut line, mut column) = self.levels.get(level).map_or((0, 0), |at| {
            let i = ids.start - at.first;
            (i / at.line(), i % at.line())
        });
        ids.map(move |id| {
            let at = &self.levels[level];
            let spot = at.spot(level, line, column);
            column += 1;
            if column == at.line() {
                (line, column) = (line + 1, 0);
            }
            while self.levels.get(level + 1).is_some_and(|next| next.first == id + 1) {
                (level, line, column) = (level + 1, 0, 0);
            }
            spot
        })
    }
    /// The sample of an id.
    #[inline]
    pub fn site(&self, id: u32) -> Site {
        self.spot(id).site()
    }

    // The triangles of a level are made by the updates of the level before: so neighbours are found without a search. All are in
    // the order of the steps of a `Site`; [`NOWHERE`] are corners of the square and what is outside of the field. Away from borders
    // they lie at fixed distances from each other.

    /// Ids at [`Site::apexes`].
    #[inline]
    pub(super) fn apexes(&self, at: &Spot) -> [u32; 2] {
        let Some(level) = at.level.checked_sub(1).map(|level| &self.levels[level]) else { return [NOWHERE; 2] };
        let Spot { x, y, inner, .. } = *at;
        let [a, b] = if at.diagonal {
            let (west, south) = (x >> 1, y >> 1);
            // Ends of the hypotenuse are where coordinates add up to an even number.
            let odd = (west + south) & 1;
            [[west + 1 - odd, south], [west + odd, south + 1]]
        } else if x & 1 == 1 {
            if inner {
                let south = level.inside(x as u32, y as u32 - 1);
                return [south, south + level.odd];
            }
            [[x, y - 1], [x, y + 1]]
        } else {
            if inner {
                let west = level.inside(x as u32 - 1, y as u32);
                return [west, west + 1];
            }
            [[x - 1, y], [x + 1, y]]
        };
        if inner { [a, b].map(|[x, y]| level.inside(x as u32, y as u32)) } else { [a, b].map(|[x, y]| level.id(x, y)) }
    }
    /// Ids at the halves of [`Site::middles_doubled`]; none for the finest.
    #[inline]
    pub(super) fn middles(&self, at: &Spot) -> [u32; 4] {
        let Some(level) = self.levels.get(at.level + 1) else { return [NOWHERE; 4] };
        let Spot { x, y, inner, .. } = *at;
        match (at.diagonal, inner) {
            (true, true) => {
                let south = level.inside(x as u32, y as u32 - 1);
                let west = south + level.odd;
                [west, west + 1, south, south + level.line()]
            }
            (true, false) => [level.id(x - 1, y), level.id(x + 1, y), level.id(x, y - 1), level.id(x, y + 1)],
            (false, true) => {
                let west = level.inside(2 * x as u32 - 1, 2 * y as u32 - 1);
                [west, west + 1, west + level.odd, west + level.odd + 1]
            }
            (false, false) => around(2 * x, 2 * y).map(|[x, y]| level.id(x, y)),
        }
    }
    /// Ids at [`Site::middles_doubled`]: what an update at the middle needs besides.
    #[inline]
    pub(super) fn beyond_middles(&self, at: &Spot) -> [u32; 4] {
        let level = &self.levels[at.level];
        let Spot { x, y, id, inner, .. } = *at;
        match (at.diagonal, inner) {
            (true, true) => [id - 1, id + 1, id - level.odd, id + level.odd],
            (true, false) => [level.id(x - 2, y), level.id(x + 2, y), level.id(x, y - 2), level.id(x, y + 2)],
            (false, true) => {
                // The row of the other kind before its own, from the west, and the one after it.
                let (south, north) = if x & 1 == 1 {
                    (id - level.even, id + level.odd)
                } else {
                    (id - level.odd - 1, id + level.even - 1)
                };
                [south, south + 1, north, north + 1]
            }
            (false, false) => around(x, y).map(|[x, y]| level.id(x, y)),
        }
    }

    /// Whether a sample is one of the field.
    pub fn contains(&self, x: i32, y: i32) -> bool {
        (0..self.columns).contains(&x) && (0..self.rows).contains(&y)
    }

    /// The site of a sample; `None` for the corners of the square. Also for samples outside of the field.
    #[inline]
    pub fn site_at(&self, x: i32, y: i32) -> Option<Site> {
        let h = 1 << (x | y | self.side).trailing_zeros();
        (h < self.side).then_some(Site { x, y, h, diagonal: x & h != 0 && y & h != 0 })
    }

    /// The id of a sample of the field; `None` for the corners of the square and outside of the field.
    #[inline]
    pub fn id(&self, x: i32, y: i32) -> Option<u32> {
        if !self.contains(x, y) {
            return None;
        }
        let h = 1 << (x | y | self.side).trailing_zeros();
        if h == self.side {
            return None;
        }
        let (x, y) = (x / h, y / h);
        let diagonal = x & y & 1 == 1;
        let at = 2 * ((self.side / 2).trailing_zeros() - h.trailing_zeros()) as usize + usize::from(!diagonal);
        Some(self.levels[at].inside(x as u32, y as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_but_corners_has_one_id_after_those_that_it_needs() {
        for (columns, rows) in [(2, 2), (3, 3), (5, 5), (9, 9), (2, 9), (7, 3), (13, 6), (33, 20), (33, 33), (65, 40)] {
            let lattice = Lattice::new(columns, rows);
            let mut seen = vec![false; lattice.len()];
            for y in 0..rows as i32 {
                for x in 0..columns as i32 {
                    let corner = x % lattice.side == 0 && y % lattice.side == 0;
                    let Some(id) = lattice.id(x, y) else {
                        assert!(corner, "{x}, {y} of {columns} × {rows}");
                        continue;
                    };
                    assert!(!corner && !std::mem::replace(&mut seen[id as usize], true));
                    let site = lattice.site(id);
                    assert_eq!((site.x, site.y), (x, y), "{id} of {columns} × {rows}");
                    assert_eq!(lattice.site_at(x, y), Some(site));
                    let spot = lattice.spot(id);
                    let at = |[dx, dy]: [i32; 2]| lattice.id(x + dx, y + dy);
                    let at = |way| at(way).unwrap_or(NOWHERE);
                    assert_eq!(lattice.apexes(&spot), site.apexes().map(at), "{site:?}");
                    let finest = site.h == 1 && !site.diagonal;
                    let middles =
                        site.middles_doubled().map(|way| if finest { NOWHERE } else { at(way.map(|c| c / 2)) });
                    assert_eq!(lattice.middles(&spot), middles, "{site:?}");
                    assert_eq!(lattice.beyond_middles(&spot), site.middles_doubled().map(at), "{site:?}");
                    for [dx, dy] in site.apexes() {
                        if let Some(need) = lattice.id(x + dx, y + dy) {
                            assert!(need < id);
                            let around = lattice.site(need).middles_doubled();
                            assert!(around.contains(&[-2 * dx, -2 * dy]), "{site:?} is not around {dx}, {dy}");
                        }
                    }
                }
            }
            assert!(seen.into_iter().all(|s| s));
            let len = lattice.len() as u32;
            for first in 0..=len.min(9) {
                let sites: Vec<_> = lattice.spots(first..len).map(|spot| spot.site()).collect();
                assert_eq!(sites, (first..len).map(|id| lattice.site(id)).collect::<Vec<_>>());
            }
        }
    }
}
