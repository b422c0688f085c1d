//! What one call of the engine is asked for, and what it reports.

/// What a call of [`Front::adapt`](crate::Front::adapt) is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// Updates whose `pixels` exceed this are to be applied. In the units of the criterion: pixels or mesh
    /// units; negative or not a number counts as 0.
    pub tolerance: f32,
    /// The most cells that the front may hold; the base mesh is kept even where it has more.
    pub max_cells: Option<usize>,
    /// Time for the call, in microseconds. What is left over goes on in the next call.
    pub deadline_us: Option<u32>,
    /// A monotone clock in microseconds. Only read where there is a deadline.
    pub clock: fn() -> u64,
}

impl Default for Request {
    /// One pixel, no limits.
    fn default() -> Request {
        Request { tolerance: 1.0, max_cells: None, deadline_us: None, clock: monotonic_us }
    }
}

impl Request {
    /// A tolerance without limits.
    pub fn tolerance(tolerance: f32) -> Request {
        Request { tolerance, ..Request::default() }
    }
}

/// The system's monotone clock. WebAssembly has none without its host, so there a deadline needs
/// [`Request::clock`] (`performance.now()`): this one stands still.
fn monotonic_us() -> u64 {
    #[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
    {
        use std::sync::OnceLock;
        use std::time::Instant;
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed().as_micros() as u64
    }
    #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
    {
        0
    }
}

/// What a call did. The counters show that the cost of a frame follows what changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Updates applied.
    pub refined: u32,
    /// Updates undone.
    pub coarsened: u32,
    /// How often the criterion was asked.
    pub evaluations: u32,
    /// Open decisions: updates that could be applied or undone next. The strictest measure of a visit to the whole
    /// front; a visit to every active vertex would ask the criterion some eight times as often.
    pub open: u32,
    /// Cells of the front.
    pub cells: usize,
    /// Whether there is nothing left to do for this view and these limits.
    pub settled: bool,
    /// Whether the cell budget keeps the front from the tolerance.
    pub budget_bound: bool,
    /// A bound on `pixels` of every update that is not applied, as far as known: the tolerance where it is met
    /// (0 where the front is complete), else the worst update that waits.
    /// [`Front::measure`](crate::Front::measure) gives the exact value.
    pub error_px: f32,
}

/// Watches the deadline of one call.
pub(crate) struct Timer {
    clock: fn() -> u64,
    start: u64,
    limit: u64,
    /// The last reading.
    used: u64,
    ops: u32,
    out: bool,
}

impl Timer {
    /// Operations of weight 1 (a look at one decision, some 30 ns) between two looks at the clock.
    const STRIDE: u32 = 64;

    pub fn start(request: &Request) -> Timer {
        let (start, limit) = match request.deadline_us {
            Some(us) => ((request.clock)(), us as u64),
            None => (0, u64::MAX),
        };
        Timer { clock: request.clock, start, limit, used: 0, ops: 0, out: false }
    }
    /// Counts an operation and says whether time is up.
    #[inline]
    pub fn spend(&mut self, weight: u32) -> bool {
        self.ops += weight;
        if self.ops >= Timer::STRIDE {
            self.ops = 0;
            if self.limit != u64::MAX {
                self.look();
                self.out = self.used >= self.limit;
            }
        }
        self.out
    }
    pub fn out(&self) -> bool {
        self.out
    }
    fn look(&mut self) {
        self.used = (self.clock)().saturating_sub(self.start);
    }
    /// Until `end_phase`, only a share of the remaining time is there to spend. Gives the whole limit.
    pub fn begin_phase(&mut self, share: f32) -> u64 {
        let limit = self.limit;
        if limit != u64::MAX {
            self.look();
            self.limit = self.used + (limit.saturating_sub(self.used) as f32 * share) as u64;
        }
        limit
    }
    /// The whole of the remaining time is there again.
    pub fn end_phase(&mut self, limit: u64) {
        self.limit = limit;
        self.out = self.used >= limit;
    }
}
