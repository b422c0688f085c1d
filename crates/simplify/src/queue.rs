//! What goes next.

/// A priority queue by cost to within 1/256: buckets by the leading bits of the `f32`. Last in, first out inside a
/// bucket. Constant time where a heap of as many millions waits for memory.
pub(crate) struct Queue<T> {
    buckets: Vec<Vec<T>>,
    lowest: usize,
    /// What costs more is not taken in.
    limit: f32,
}

impl<T> Queue<T> {
    /// Sign, exponent and 8 bits of mantissa are kept.
    const SHIFT: u32 = 15;

    pub fn new(limit: f32) -> Queue<T> {
        let buckets = std::iter::repeat_with(Vec::new).take(1 << (32 - 1 - Self::SHIFT)).collect();
        Queue { buckets, lowest: 0, limit }
    }
    #[inline]
    pub fn push(&mut self, cost: f32, item: T) {
        if cost > self.limit {
            return;
        }
        let bucket = (cost.to_bits() >> Self::SHIFT) as usize;
        let bucket = bucket.min(self.buckets.len() - 1);
        self.buckets[bucket].push(item);
        self.lowest = self.lowest.min(bucket);
    }
    pub fn pop(&mut self) -> Option<T> {
        while self.lowest < self.buckets.len() {
            if let Some(item) = self.buckets[self.lowest].pop() {
                return Some(item);
            }
            self.lowest += 1;
        }
        None
    }
}
