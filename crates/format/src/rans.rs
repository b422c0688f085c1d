//! Range asymmetric numeral systems with adaptive models: the entropy coder of every coded column.
//!
//! Based on: Duda, *Asymmetric numeral systems* (2013), in the 64-bit state and 32-bit word form that Giesen
//! describes (*Interleaved entropy coders*, 2014); the models mix whole cumulative distributions towards the symbol
//! just seen, as in Giesen's notes on adaptive multi-symbol models. Integers are split into a half-octave class, which
//! is modelled, and the bits below it, which are not.
//!
//! A stream is the decoder's first state (u64) and then the words (u32) in the order that it takes them in,
//! everything little endian. Decoding ends in the state that encoding began with, which is checked.

/// Probabilities are multiples of 2⁻¹⁵, so that a cumulative distribution fits `u16` lanes.
const PRECISION: u32 = 15;
/// The whole of a distribution.
const WHOLE: u32 = 1 << PRECISION;
/// The state never falls below this; the encoder starts here and the decoder must end here.
const FLOOR: u64 = 1 << 31;
/// Bits taken in one step where they are not modelled.
const RAW_STEP: u32 = 16;
/// What a symbol that is never seen keeps of the whole: about 13 bits to come back from.
const LEAST: u16 = 4;

/// An adaptive distribution over `N` symbols.
#[derive(Clone)]
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
    precision: u8,
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

    /// Moves the distribution towards `symbol`: fast at first, then by 2^-`slowest`.
    ///
    /// `below` stays strictly increasing: each entry becomes ⌊((2ʳ − 1)·below + target)/2ʳ⌋, and both rise by at least
    /// one from entry to entry.
    #[inline(always)]
    fn adapt(&mut self, symbol: usize, slowest: u32) {
        let rate = (2 + self.seen.ilog2_or_zero()).min(slowest);
        self.seen = (self.seen + 1).min(1 << 12);
        let above = WHOLE as u16 - N as u16 * LEAST;
        for i in 0..N {
            let target = i as u16 * LEAST + if i > symbol { above } else { 0 };
            let b = self.below[i];
            self.below[i] = b.wrapping_add(((target.wrapping_sub(b) as i16) >> rate) as u16);
        }
    }
}

/// Logarithm of a count that may be zero.
trait Ilog2OrZero {
    fn ilog2_or_zero(self) -> u32;
}

impl Ilog2OrZero for u16 {
    #[inline(always)]
    fn ilog2_or_zero(self) -> u32 {
        (self | 1).ilog2()
    }
}

/// Collects symbols and raw bits, then writes them.
#[cfg(feature = "write")]
#[derive(Default)]
pub(crate) struct Encoder {
    pending: Vec<Pending>,
}

#[cfg(feature = "write")]
impl Encoder {
    /// Codes a symbol under a model, which learns from it.
    #[inline]
    pub(crate) fn symbol<const N: usize>(&mut self, model: &mut Model<N>, symbol: usize) {
        let (start, frequency) = (model.below[symbol], model.frequency(symbol) as u16);
        self.pending.push(Pending { start, frequency, precision: PRECISION as u8 });
        model.adapt(symbol, RATE);
    }

    /// Codes the low `count` bits of `value` as they are; `count` up to 32.
    #[inline]
    pub(crate) fn raw(&mut self, mut value: u32, mut count: u32) {
        while count > 0 {
            let step = count.min(RAW_STEP);
            let part = (value & ((1 << step) - 1)) as u16;
            self.pending.push(Pending { start: part, frequency: 1, precision: step as u8 });
            value = value.wrapping_shr(step);
            count -= step;
        }
    }

    /// The stream of everything coded.
    pub(crate) fn finish(self) -> Vec<u8> {
        let mut words = Vec::with_capacity(self.pending.len() / 2);
        let mut state = FLOOR;
        for p in self.pending.iter().rev() {
            let (frequency, precision) = (p.frequency as u64, p.precision as u32);
            if state >= ((FLOOR >> precision) << 32) * frequency {
                words.push(state as u32);
                state >>= 32;
            }
            state = if frequency == 1 {
                (state << precision) + p.start as u64
            } else {
                ((state / frequency) << precision) + state % frequency + p.start as u64
            };
        }
        let mut stream = Vec::with_capacity(8 + 4 * words.len());
        stream.extend_from_slice(&state.to_le_bytes());
        for word in words.iter().rev() {
            stream.extend_from_slice(&word.to_le_bytes());
        }
        stream
    }
}

/// Reads a stream. It never fails on the way: past the end it reads zeros, and `finish` tells.
pub(crate) struct Decoder<'a> {
    state: u64,
    words: std::slice::ChunksExact<'a, u8>,
    sound: bool,
}

impl<'a> Decoder<'a> {
    /// Starts at the first state.
    pub(crate) fn new(stream: &'a [u8]) -> Self {
        let whole = stream.len() >= 8 && stream.len() % 4 == 0;
        let (first, rest) = if whole { stream.split_at(8) } else { (&[0; 8][..], &[][..]) };
        let state = u64::from_le_bytes(first.try_into().expect("eight bytes"));
        Decoder { state, words: rest.chunks_exact(4), sound: whole && state >= FLOOR && state < FLOOR << 32 }
    }

    #[inline(always)]
    fn refill(&mut self) {
        if self.state < FLOOR {
            match self.words.next() {
                Some(word) => {
                    let word = u32::from_le_bytes(word.try_into().expect("four bytes"));
                    self.state = self.state << 32 | word as u64;
                }
                None => {
                    self.sound = false;
                    self.state = FLOOR;
                }
            }
        }
    }

    /// The next symbol of a model, which learns from it.
    #[inline(always)]
    pub(crate) fn symbol<const N: usize>(&mut self, model: &mut Model<N>) -> usize {
        let point = (self.state & (WHOLE as u64 - 1)) as u16;
        let symbol = model.symbol_at(point);
        let (start, frequency) = (model.below[symbol], model.frequency(symbol));
        self.state = frequency as u64 * (self.state >> PRECISION) + (point - start) as u64;
        model.adapt(symbol, RATE);
        self.refill();
        symbol
    }

    /// The next `count` raw bits, up to 32.
    #[inline(always)]
    pub(crate) fn raw(&mut self, count: u32) -> u32 {
        if count <= RAW_STEP {
            return self.raw_step(count);
        }
        let low = self.raw_step(RAW_STEP);
        low | self.raw_step(count - RAW_STEP) << RAW_STEP
    }

    #[inline(always)]
    fn raw_step(&mut self, count: u32) -> u32 {
        let bits = (self.state & ((1 << count) - 1)) as u32;
        self.state >>= count;
        self.refill();
        bits
    }

    /// Whether the stream was whole and held exactly what was taken from it.
    pub(crate) fn finish(self) -> bool {
        self.sound && self.state == FLOOR && self.words.len() == 0
    }
}

/// How slowly a settled model moves: each symbol weighs 2⁻⁶.
const RATE: u32 = 6;

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
    if class == 0 {
        return (0, 0);
    }
    let low_bits = (class as u32 / 2).saturating_sub(1);
    let bits = decoder.raw(1 + low_bits);
    let top = if class == 1 { 1 } else { 2 | class as u32 & 1 };
    let magnitude = top << low_bits | bits >> 1;
    let value = if bits & 1 == 1 { magnitude.wrapping_neg() } else { magnitude };
    (value as i32, class)
}
