//! Normals and colours of updates: differences along the split, from s to u and from u to v.

use meshfront_hierarchies::edge_collapse::Oct;

use crate::container::Section;
use crate::error::Fault;
use crate::rans::{Decoder, IntModel, decode_int};
#[cfg(feature = "write")]
use crate::rans::{Encoder, encode_int};

/// Contexts by octave of the class before.
const OCTAVES: usize = 17;

/// An attribute of a vertex as small integers whose differences wrap around.
pub(crate) trait Attribute: Copy + Default + Send + Sync {
    /// Number of integers.
    const PARTS: usize;
    /// Sum, modulo the width of the integers, with a difference.
    fn plus(self, difference: [i32; 4]) -> Self;
    /// Difference that `plus` undoes: the shortest one.
    fn minus(self, other: Self) -> [i32; 4];
}

impl Attribute for Oct {
    const PARTS: usize = 2;
    fn plus(self, d: [i32; 4]) -> Self {
        Oct([self.0[0].wrapping_add(d[0] as i16), self.0[1].wrapping_add(d[1] as i16)])
    }
    fn minus(self, other: Self) -> [i32; 4] {
        let d = |i: usize| self.0[i].wrapping_sub(other.0[i]) as i32;
        [d(0), d(1), 0, 0]
    }
}

impl Attribute for [u8; 4] {
    const PARTS: usize = 4;
    fn plus(self, d: [i32; 4]) -> Self {
        [0, 1, 2, 3].map(|i| self[i].wrapping_add(d[i] as u8))
    }
    fn minus(self, other: Self) -> [i32; 4] {
        [0, 1, 2, 3].map(|i| self[i].wrapping_sub(other[i]) as i8 as i32)
    }
}

/// One model for each part and each of the two children, by the class of the part before.
fn models() -> [[Vec<IntModel>; 4]; 2] {
    std::array::from_fn(|_| std::array::from_fn(|_| vec![IntModel::new(); OCTAVES]))
}

/// A page of differences: s to u, u to v.
#[cfg(feature = "write")]
pub(super) fn encode_page<A: Attribute>(differences: &[[[i32; 4]; 2]]) -> Vec<u8> {
    let (mut encoder, mut models) = (Encoder::default(), models());
    for pair in differences {
        for (child, difference) in pair.iter().enumerate() {
            let mut class = 0;
            for part in 0..A::PARTS {
                class = encode_int(&mut encoder, &mut models[child][part][class / 2], difference[part]);
            }
        }
    }
    encoder.finish()
}

/// Reads what `encode_page` wrote. The children hold differences from `A::default()` until `resolve`.
pub(super) fn decode_page<A: Attribute>(page: Section, children: &mut [[A; 2]]) -> Result<(), Fault> {
    let (mut decoder, mut models) = (Decoder::new(page.bytes), models());
    for pair in children {
        for child in 0..2 {
            let mut difference = [0; 4];
            let mut class = 0;
            for part in 0..A::PARTS {
                let context = (class / 2).min(OCTAVES - 1);
                (difference[part], class) = decode_int(&mut decoder, &mut models[child][part][context]);
            }
            pair[child] = A::default().plus(difference);
        }
    }
    if decoder.finish() { Ok(()) } else { Err(page.fault(0, "page does not end where its stream does")) }
}

/// Value of a vertex: of the base mesh, or of a child.
pub(super) fn value_of<A: Attribute>(base: &[A], base_count: usize, children: &[[A; 2]], vertex: usize) -> A {
    match vertex.checked_sub(base_count) {
        None => base.get(vertex).copied().unwrap_or_default(),
        Some(child) => children[child / 2][child % 2],
    }
}
