//! What it takes to say which triangulation of its polygon an update's M⁻ is: the four ways of the tutorial, and ours.
//!
//! The mesh is refined by finding M⁻ from the reference edge on, and coarsened by triangulating the ring of the vertex from
//! the same edge: both follow from the code alone. Each code says the number of corners too, and where it ends. Not in it are
//! the reference edge, and whether the vertex lies on a boundary.
//!
//! Except for [`Connectivity::Sides`] and [`Connectivity::Table`] the number of corners is a prefix code made for decimated
//! surfaces, where most removed vertices have five or six neighbours: one bit for 5, two for 6, three for 4, and so on.

use super::VertexRemoval;
use super::polygon::{MOST_CORNERS, Triangles, Triangulation, turned_numbers};
use std::collections::HashMap;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

/// A way to encode triangulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Connectivity {
    /// Klein & Gumhold (`klein1998`): a number in a table of all patterns of all polygons, always 13 bits.
    Table,
    /// Andújar & De Floriani (`andujar2001`): the number among the triangulations of the polygon, from which an algorithm
    /// makes the triangles without a table; in as few bits as there are such numbers.
    Index,
    /// De Floriani et al. (`defloriani2000`): ear cuts. Around and around the polygon, for each corner that is left a bit: whether
    /// it is cut off now.
    Ears,
    /// Taubin et al. (`taubin1998`): two bits a triangle, from the reference edge on: whether there are others to its left, and to its
    /// right.
    Sides,
    /// As `Index`; but where every edge of the polygon may be the reference edge, it is the one that gives the least number: only
    /// those numbers count that no turn makes less.
    #[default]
    Turned,
}

/// Patterns of a table: all triangulations of all polygons.
const PATTERNS: u32 = 6917;
const TABLE_BITS: u32 = PATTERNS.next_power_of_two().trailing_zeros();

/// Bits, the first one lowest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Code {
    bits: u64,
    len: u32,
}

impl Code {
    /// How many bits.
    #[allow(clippy::len_without_is_empty)] // none is
    pub fn len(self) -> usize {
        self.len as usize
    }
    /// The bits, in the order in which decoding asks for them.
    pub fn bits(self) -> impl Iterator<Item = bool> {
        (0..self.len).map(move |i| self.bits >> i & 1 == 1)
    }
    fn push(&mut self, bit: bool) {
        self.bits |= u64::from(bit) << self.len;
        self.len += 1;
    }
    /// The highest bit first.
    fn push_number(&mut self, number: u32, bits: u32) {
        (0..bits).rev().for_each(|i| self.push(number >> i & 1 == 1));
    }
    /// A number below `count` in log₂ of it bits, rounded down for the lesser ones and up for the others.
    fn push_below(&mut self, number: u32, count: u32) {
        let bits = count.ilog2();
        let short = (2 << bits) - count;
        if number < short { self.push_number(number, bits) } else { self.push_number(number + short, bits + 1) }
    }
    fn push_corners(&mut self, corners: u8) {
        let rank = CORNERS.iter().position(|&c| c == corners).expect("a valid polygon");
        (0..rank).for_each(|_| self.push(true));
        if rank + 1 < CORNERS.len() {
            self.push(false);
        }
    }
}

/// Numbers of corners, the most frequent first.
const CORNERS: [u8; MOST_CORNERS - 2] = [5, 6, 4, 7, 3, 8, 9, 10, 11];

fn number(bits: &mut impl Iterator<Item = bool>, count: u32) -> Option<u32> {
    (0..count).try_fold(0, |n, _| Some(n << 1 | u32::from(bits.next()?)))
}

fn number_below(bits: &mut impl Iterator<Item = bool>, count: u32) -> Option<u32> {
    let fewest = count.ilog2();
    let short = (2 << fewest) - count;
    let n = number(bits, fewest)?;
    if n < short { Some(n) } else { Some((n << 1 | u32::from(bits.next()?)) - short) }
}

fn corners(bits: &mut impl Iterator<Item = bool>) -> Option<usize> {
    let mut rank = 0;
    while rank + 1 < CORNERS.len() && bits.next()? {
        rank += 1;
    }
    Some(CORNERS[rank] as usize)
}

impl Connectivity {
    /// All of them, in the order of the tutorial.
    pub const ALL: [Connectivity; 5] =
        [Connectivity::Table, Connectivity::Index, Connectivity::Ears, Connectivity::Sides, Connectivity::Turned];

    /// The name that [`FromStr`] reads.
    pub fn name(self) -> &'static str {
        match self {
            Connectivity::Table => "table",
            Connectivity::Index => "index",
            Connectivity::Ears => "ears",
            Connectivity::Sides => "sides",
            Connectivity::Turned => "turned",
        }
    }

    /// Bits per update that the tutorial (`defloriani2002`) gives; `None` for what it does not have.
    pub fn published_bits(self) -> Option<u32> {
        match self {
            Connectivity::Table => Some(13),
            Connectivity::Index => Some(7),
            Connectivity::Ears => Some(10),
            Connectivity::Sides => Some(8),
            Connectivity::Turned => None,
        }
    }

    /// Encodes. `fixed`: the reference edge is what it is, as at a boundary; else the triangulation was turned so that it has
    /// the least number, as [`Columns`](super::Columns) have it.
    ///
    /// # Panics
    /// Where the triangulation is not valid, or should be turned and is not.
    pub fn encode(self, t: Triangulation, fixed: bool) -> Code {
        let mut code = Code::default();
        match self {
            Connectivity::Table => {
                let before: u32 = (3..t.corners as usize).map(|c| Triangulation::count(c) as u32).sum();
                code.push_number(before + t.index as u32, TABLE_BITS);
            }
            Connectivity::Index => {
                code.push_corners(t.corners);
                code.push_below(t.index as u32, Triangulation::count(t.corners as usize) as u32);
            }
            Connectivity::Ears => {
                code.push_corners(t.corners);
                let triangles = t.triangles();
                let is_ear = |ear: [u8; 3]| {
                    let mut sorted = ear;
                    sorted.sort_unstable();
                    triangles.contains(&sorted)
                };
                let cut = |ear| {
                    code.push(is_ear(ear));
                    Some(is_ear(ear))
                };
                cut_ears(t.corners as usize, cut).expect("a triangulation has ears");
            }
            Connectivity::Sides => {
                for [i, a, j] in t.triangles() {
                    code.push(a - i > 1);
                    code.push(j - a > 1);
                }
            }
            Connectivity::Turned if fixed => return Connectivity::Index.encode(t, fixed),
            Connectivity::Turned => {
                code.push_corners(t.corners);
                let turned = turned_numbers(t.corners as usize);
                let rank = turned.binary_search(&t.index).expect("a triangulation turned to its least number");
                code.push_below(rank as u32, turned.len() as u32);
            }
        }
        code
    }

    /// Decodes what [`encode`](Connectivity::encode) made; takes no bit more. `None` where the bits end before, or are no code.
    pub fn decode(self, bits: &mut impl Iterator<Item = bool>, fixed: bool) -> Option<Triangulation> {
        match self {
            Connectivity::Table => TABLE.get(number(bits, TABLE_BITS)? as usize).copied(),
            Connectivity::Index => {
                let corners = corners(bits)?;
                let index = number_below(bits, Triangulation::count(corners) as u32)?;
                Some(Triangulation { corners: corners as u8, index: index as u16 })
            }
            Connectivity::Ears => {
                let corners = corners(bits)?;
                Triangulation::of(corners, &cut_ears(corners, |_| bits.next())?)
            }
            Connectivity::Sides => sides(bits),
            Connectivity::Turned if fixed => Connectivity::Index.decode(bits, fixed),
            Connectivity::Turned => {
                let corners = corners(bits)?;
                let turned = turned_numbers(corners);
                let rank = number_below(bits, turned.len() as u32)?;
                Some(Triangulation { corners: corners as u8, index: turned[rank as usize] })
            }
        }
    }

    /// Mean length of the codes of a hierarchy's updates, bits; 0 where there is none.
    pub fn mean_bits(self, h: &VertexRemoval) -> f64 {
        let lengths = h.triangulations().map(|(t, boundary)| self.encode(t, boundary).len());
        lengths.sum::<usize>() as f64 / (h.insertions.len().max(1)) as f64
    }
}

/// The least mean length, bits, of any code that looks at one update at a time and knows how often each triangulation occurs:
/// the entropy of the triangulations.
pub fn entropy(h: &VertexRemoval) -> f64 {
    let mut counts = HashMap::<_, u32>::new();
    for (t, _) in h.triangulations() {
        *counts.entry(t).or_default() += 1;
    }
    let mut counts: Vec<u32> = counts.into_values().collect();
    counts.sort_unstable();
    let all: f64 = counts.iter().map(|&n| n as f64).sum();
    counts.iter().map(|&n| n as f64 / all * (all / n as f64).log2()).sum()
}

/// What `Table` looks up, 28 kB: space that its figure leaves out.
static TABLE: LazyLock<Vec<Triangulation>> = LazyLock::new(|| {
    let of =
        |corners| (0..Triangulation::count(corners)).map(move |index| Triangulation { corners: corners as u8, index });
    (3..=MOST_CORNERS).flat_map(of).collect()
});

/// Goes around a polygon and cuts the corners off that `cut` says, until a triangle is left: the triangles. `None` where
/// `cut` gives none, or does not cut in a whole round.
fn cut_ears(corners: usize, mut cut: impl FnMut([u8; 3]) -> Option<bool>) -> Option<Triangles> {
    let mut left: arrayvec::ArrayVec<u8, MOST_CORNERS> = (0..corners as u8).collect();
    let mut triangles = Triangles::new();
    let (mut at, mut idle) = (0, 0);
    while left.len() > 3 {
        let n = left.len();
        let ear = [left[(at + n - 1) % n], left[at], left[(at + 1) % n]];
        if cut(ear)? {
            triangles.push(ear);
            left.remove(at);
            idle = 0;
        } else {
            at += 1;
            idle += 1;
            if idle == n {
                return None;
            }
        }
        at %= left.len();
    }
    triangles.push([left[0], left[1], left[2]]);
    Some(triangles)
}

/// Reads two bits a triangle, each after the one on whose edge it hangs, the left part before the right one.
fn sides(bits: &mut impl Iterator<Item = bool>) -> Option<Triangulation> {
    // The tree in the order of reading; how many triangles are still to come.
    let mut nodes = arrayvec::ArrayVec::<[bool; 2], { MOST_CORNERS - 2 }>::new();
    let mut open = 1;
    while open > 0 {
        let node = [bits.next()?, bits.next()?];
        nodes.try_push(node).ok()?;
        open = open - 1 + usize::from(node[0]) + usize::from(node[1]);
    }
    let mut triangles = Triangles::new();
    let mut at = 0;
    fn part(nodes: &[[bool; 2]], at: &mut usize, from: u8, triangles: &mut Triangles) -> u8 {
        let [left, right] = nodes[*at];
        *at += 1;
        let apex = if left { part(nodes, at, from, triangles) } else { from + 1 };
        let end = if right { part(nodes, at, apex, triangles) } else { apex + 1 };
        triangles.push([from, apex, end]);
        end
    }
    let last = part(&nodes, &mut at, 0, &mut triangles);
    Triangulation::of(last as usize + 1, &triangles)
}

impl fmt::Display for Connectivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// No connectivity has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no connectivity is called {0:?}: there are table, index, ears, sides and turned")]
pub struct UnknownConnectivity(pub String);

impl FromStr for Connectivity {
    type Err = UnknownConnectivity;
    fn from_str(name: &str) -> Result<Connectivity, UnknownConnectivity> {
        Connectivity::ALL.into_iter().find(|c| c.name() == name).ok_or_else(|| UnknownConnectivity(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> impl Iterator<Item = Triangulation> {
        let of = |corners| (0..Triangulation::count(corners)).map(move |index| (corners as u8, index));
        (3..=MOST_CORNERS).flat_map(of).map(|(corners, index)| Triangulation { corners, index })
    }
    fn least(t: Triangulation) -> Triangulation {
        (0..t.corners as usize).map(|by| t.turned(by)).min().unwrap()
    }

    #[test]
    fn decoding_is_the_inverse_and_takes_no_bit_more() {
        for connectivity in Connectivity::ALL {
            for (t, fixed) in all().map(|t| (t, true)).chain(all().map(|t| (least(t), false))) {
                let code = connectivity.encode(t, fixed);
                // Other codes follow in a stream.
                let mut bits = code.bits().chain([true, false, true]);
                assert_eq!(connectivity.decode(&mut bits, fixed), Some(t), "{connectivity}");
                assert_eq!(bits.count(), 3, "{connectivity} {t:?}");
                let cut: Vec<bool> = code.bits().take(code.len().saturating_sub(1)).collect();
                assert_eq!(connectivity.decode(&mut cut.into_iter(), fixed), None, "{connectivity} {t:?}, cut off");
            }
        }
    }

    #[test]
    fn any_bits_are_a_triangulation_or_none() {
        for connectivity in Connectivity::ALL {
            for bits in 0..1u32 << 16 {
                let mut bits = (0..40).map(|i| bits.rotate_left(i) & 1 == 1);
                if let Some(t) = connectivity.decode(&mut bits, true) {
                    assert!(t.is_valid());
                }
            }
        }
    }

    #[test]
    fn lengths_are_those_of_the_papers() {
        let mean = |c: Connectivity| {
            let hexagons = all().filter(|t| t.corners == 6);
            hexagons.map(|t| c.encode(t, true).len()).sum::<usize>() as f64 / 14.0
        };
        assert_eq!(mean(Connectivity::Table), 13.0);
        assert_eq!(mean(Connectivity::Sides), 8.0);
        assert!(mean(Connectivity::Index) < 7.0 && mean(Connectivity::Ears) < 10.0);
        assert_eq!(all().count(), PATTERNS as usize);
        assert_eq!("ears".parse(), Ok(Connectivity::Ears));
        assert!("klein".parse::<Connectivity>().is_err());
    }
}
