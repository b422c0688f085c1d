//! Range asymmetric numeral systems with adaptive models: the entropy coder of every coded column.
//!
//! Based on: Duda, *Asymmetric numeral systems* (2013), in the 64-bit state and 32-bit word form that Giesen
//! describes (*Interleaved entropy coders*, 2014); the models mix whole cumulative distributions towards the symbol
//! just seen, as in Giesen's notes on adaptive multi-symbol models. Integers are split into a half-octave class, which
//! is modelled, and the bits below it, which are not.
//!
//! A stream is the number of words (u32), the decoder's first state (u64), the words (u32) in the order that it takes
//! them in, and the raw bits, everything little endian. Decoding ends in the state that encoding began with, which is
//! checked. Raw bits lie apart, because then the next symbol need not wait for them.

use crate::container::{u32_at, u64_at};

/// Probabilities are multiples of 2⁻¹⁵, so that a cumulative distribution fits `u16` lanes.
const PRECISION: u32 = 15;
/// The whole of a distribution.
const WHOLE: u32 = 1 << PRECISION;
/// The state never falls below this; the encoder starts here and the decoder must end here.
const FLOOR: u64 = 1 << 31;
/// Bytes of a stream before its words: their number, and the first state.
const STREAM_HEAD: usize = 12;
/// What a symbol that is never seen keeps of the whole: about 13 bits to come back from.
const LEAST: u16 = 4;
/// How slowly a settled model moves: each symbol weighs 2⁻⁷.
const SLOWEST: u32 = 7;

/// An adaptive distribution over `N` symbols. Aligned so that no lane load crosses a cache line.
#[derive(Clone)]
#[repr(align(64))]
pub(crate) struct Model<const N: usize> {
    /// Symbol `i` owns `below[i]..below[i + 1]` of `0..WHOLE`. Strictly increasing, `below[0] == 0`.
    below: [u16; N],
    /// Symbols seen, as far as it still matters for the rate.
    seen: u16,
}

/// One coding step, kept until the page's symbols are known, because the encoder runs backwards.
#[cfg(feature = "write")]
#[derive(Clone, Copy)]
struct Pending {
    start: u16,
    frequency: u16,
}

impl<const N: usize> Model<N> {
    /// All symbols alike.
    pub(crate) fn new() -> Self {
        let mut below = [0; N];
        for (i, b) in below.iter_mut().enumerate() {
            *b = (i * WHOLE as usize / N) as u16;
        }
        Model { below, seen: 0 }
    }

    /// Share of the whole that a symbol owns.
    #[inline(always)]
    fn frequency(&self, symbol: usize) -> u32 {
        let end = if symbol + 1 < N { self.below[symbol + 1] as u32 } else { WHOLE };
        end - self.below[symbol] as u32
    }

    /// The symbol that owns a point of the whole.
    #[inline(always)]
    fn symbol_at(&self, point: u16) -> usize {
        // Counts instead of searching: no branch to guess, and all lanes at once.
        let owned: u16 = self.below.iter().map(|&b| (b <= point) as u16).sum();
        owned as usize - 1
    }

    /// Moves the distribution towards `symbol`: fast at first, then by 2^-`SLOWEST`.
    ///
    /// `below` stays strictly increasing: each entry becomes ⌊((2ʳ − 1)·below + target)/2ʳ⌋, and both rise by at least
    /// one from entry to entry.
    #[inline(always)]
    fn adapt(&mut self, symbol: usize) {
        let rate = (2 + (self.seen | 1).ilog2()).min(SLOWEST);
        self.seen = (self.seen + 1).min(1 << SLOWEST);
        let above = WHOLE as u16 - N as u16 * LEAST;
        for i in 0..N {
            let target = i as u16 * LEAST + if i > symbol { above } else { 0 };
            let b = self.below[i];
            self.below[i] = b.wrapping_add(((target.wrapping_sub(b) as i16) >> rate) as u16);
        }
    }
}

/// Collects symbols and raw bits, then writes them.
#[cfg(feature = "write")]
#[derive(Default)]
pub(crate) struct Encoder {
    pending: Vec<Pending>,
    bits: Vec<u8>,
    /// Raw bits that do not fill a byte yet, and how many.
    open: (u64, u32),
}

#[cfg(feature = "write")]
impl Encoder {
    /// Codes a symbol under a model, which learns from it.
    #[inline]
    pub(crate) fn symbol<const N: usize>(&mut self, model: &mut Model<N>, symbol: usize) {
        let (start, frequency) = (model.below[symbol], model.frequency(symbol) as u16);
        self.pending.push(Pending { start, frequency });
        model.adapt(symbol);
    }

    /// Codes the low `count` bits of `value` as they are; `count` up to 32.
    #[inline]
    pub(crate) fn raw(&mut self, value: u32, count: u32) {
        let (mut bits, mut filled) = self.open;
        bits |= (value as u64 & ((1 << count) - 1)) << filled;
        filled += count;
        while filled >= 8 {
            self.bits.push(bits as u8);
            bits >>= 8;
            filled -= 8;
        }
        self.open = (bits, filled);
    }

    /// The stream of everything coded.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        if self.open.1 > 0 {
            self.bits.push(self.open.0 as u8);
        }
        let mut words = Vec::with_capacity(self.pending.len() / 4);
        let mut state = FLOOR;
        for p in self.pending.iter().rev() {
            let frequency = p.frequency as u64;
            if state >= ((FLOOR >> PRECISION) << 32) * frequency {
                words.push(state as u32);
                state >>= 32;
            }
            state = ((state / frequency) << PRECISION) + state % frequency + p.start as u64;
        }
        let mut stream = Vec::with_capacity(STREAM_HEAD + 4 * words.len() + self.bits.len());
        stream.extend_from_slice(&(words.len() as u32).to_le_bytes());
        stream.extend_from_slice(&state.to_le_bytes());
        for word in words.iter().rev() {
            stream.extend_from_slice(&word.to_le_bytes());
        }
        stream.extend_from_slice(&self.bits);
        stream
    }
}

/// Reads a stream. It never fails on the way: past the end it reads zeros, and `finish` tells.
pub(crate) struct Decoder<'a> {
    state: u64,
    words: &'a [[u8; 4]],
    bits: &'a [u8],
    /// Raw bits taken.
    taken: usize,
    sound: bool,
}

impl<'a> Decoder<'a> {
    /// Starts at the first state.
    pub(crate) fn new(stream: &'a [u8]) -> Self {
        let broken = Decoder { state: FLOOR, words: &[], bits: &[], taken: 0, sound: false };
        let Some((head, rest)) = stream.split_first_chunk::<STREAM_HEAD>() else {
            return broken;
        };
        let words = u32_at(head, 0) as usize;
        let state = u64_at(head, 4);
        if words > rest.len() / 4 || !(FLOOR..FLOOR << 32).contains(&state) {
            return broken;
        }
        let (words, bits) = rest.split_at(4 * words);
        Decoder { state, words: words.as_chunks().0, bits, taken: 0, sound: true }
    }

    /// The next symbol of a model, which learns from it.
    #[inline(always)]
    pub(crate) fn symbol<const N: usize>(&mut self, model: &mut Model<N>) -> usize {
        let point = (self.state & (WHOLE as u64 - 1)) as u16;
        let symbol = model.symbol_at(point);
        let (start, frequency) = (model.below[symbol], model.frequency(symbol));
        self.state = frequency as u64 * (self.state >> PRECISION) + (point - start) as u64;
        model.adapt(symbol);
        if self.state < FLOOR {
            match self.words.split_first() {
                Some((&word, rest)) => {
                    self.state = self.state << 32 | u32::from_le_bytes(word) as u64;
                    self.words = rest;
                }
                None => {
                    self.sound = false;
                    self.state = FLOOR;
                }
            }
        }
        symbol
    }

    /// The next `count` raw bits, up to 32.
    #[inline(always)]
    pub(crate) fn raw(&mut self, count: u32) -> u32 {
        let byte = self.taken / 8;
        let window = match self.bits.get(byte..byte + 8) {
            Some(eight) => u64_at(eight, 0),
            None => self.last_window(byte),
        };
        let bits = (window >> (self.taken % 8)) & ((1 << count) - 1);
        self.taken += count as usize;
        bits as u32
    }

    /// Eight bytes near or past the end, filled up with zeros.
    #[cold]
    fn last_window(&self, byte: usize) -> u64 {
        let left = self.bits.get(byte..).unwrap_or_default();
        left.iter().rev().fold(0, |window, &b| window << 8 | b as u64)
    }

    /// Whether the stream was whole and held exactly what was taken from it.
    pub(crate) fn finish(self) -> bool {
        let bits_end = self.taken.div_ceil(8) == self.bits.len();
        let open = self.taken % 8;
        let unused = open > 0 && self.bits.last().is_some_and(|&b| b >> open != 0);
        self.sound && self.state == FLOOR && self.words.is_empty() && bits_end && !unused
    }
}

/// Symbols of an integer's class: zero, and two for each octave of its magnitude.
const CLASSES: usize = 64;

/// A model of signed integers, best for those that gather around zero.
pub(crate) type IntModel = Model<CLASSES>;

/// Some fresh models.
pub(crate) fn int_models<const K: usize>() -> [IntModel; K] {
    std::array::from_fn(|_| IntModel::new())
}

/// Half-octave class of a magnitude: 0, 1, 2, 3, 4..6, 6..8, 8..12, 12..16, …
#[cfg(feature = "write")]
#[inline(always)]
pub(crate) fn class_of(magnitude: u32) -> usize {
    if magnitude < 2 {
        return magnitude as usize;
    }
    let octave = magnitude.ilog2();
    (2 * octave + (magnitude >> (octave - 1) & 1)) as usize
}

/// Codes any integer; returns its class.
#[cfg(feature = "write")]
#[inline]
pub(crate) fn encode_int(encoder: &mut Encoder, model: &mut IntModel, value: i32) -> usize {
    let magnitude = value.unsigned_abs();
    let class = class_of(magnitude);
    encoder.symbol(model, class);
    if magnitude > 0 {
        let low_bits = (class as u32 / 2).saturating_sub(1);
        encoder.raw(magnitude << 1 | (value < 0) as u32, 1 + low_bits);
    }
    class
}

/// Reads what `encode_int` coded: the integer and its class.
#[inline(always)]
pub(crate) fn decode_int(decoder: &mut Decoder, model: &mut IntModel) -> (i32, usize) {
    let class = decoder.symbol(model);
    // No branch on the class: it is as good as random. Zero takes no bit and has no top.
    let low_bits = (class as u32 / 2).saturating_sub(1);
    let bits = decoder.raw(low_bits + (class != 0) as u32);
    let top = if class < 2 { class as u32 } else { 2 | class as u32 & 1 };
    let magnitude = top << low_bits | bits >> 1;
    let sign = (bits & 1).wrapping_neg();
    let value = (magnitude ^ sign).wrapping_sub(sign);
    (value as i32, class)
}
