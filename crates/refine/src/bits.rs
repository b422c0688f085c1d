//! A set of update ids, one bit each.

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bits {
    words: Vec<u64>,
}

impl Bits {
    pub fn new(len: usize) -> Bits {
        Bits { words: vec![0; len.div_ceil(64)] }
    }
    #[inline]
    pub fn has(&self, i: u32) -> bool {
        self.words[i as usize >> 6] >> (i & 63) & 1 != 0
    }
    /// Whether the bit was clear before.
    #[inline]
    pub fn insert(&mut self, i: u32) -> bool {
        let word = &mut self.words[i as usize >> 6];
        let before = *word;
        *word |= 1 << (i & 63);
        before != *word
    }
    /// Whether the bit was set before.
    #[inline]
    pub fn remove(&mut self, i: u32) -> bool {
        let word = &mut self.words[i as usize >> 6];
        let before = *word;
        *word &= !(1 << (i & 63));
        before != *word
    }
    pub fn clear(&mut self) {
        self.words.fill(0);
    }
    pub fn words(&self) -> &[u64] {
        &self.words
    }
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.words.iter().enumerate().flat_map(|(w, &word)| {
            std::iter::successors((word != 0).then_some(word), |&x| Some(x & (x - 1)).filter(|&x| x != 0))
                .map(move |x| w as u32 * 64 + x.trailing_zeros())
        })
    }
}
