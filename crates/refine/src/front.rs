//! One viewer's front, and the three strategies that move it.
//!
//! Based on the selective refinement of the Multi-Tessellation (`defloriani1998`; the tutorial `defloriani2002`: "Top-down approach", "Incremental approach", CONTRACTION and EXPANSION).
//!
//! Where we differ: the tutorial puts every leaf of S and every update below the front into two queues, every
//! frame. Footprints nest, so only *open decisions* can change first: updates not applied whose needs all are, and
//! applied ones that nothing applied needs. Each of them is filed in a calendar under the distance that the view
//! must travel before its answer can change, so a frame looks at the few that are due.
//!
//! ```text
//!          applied, needed by others          never looked at
//!   ───────────────────────────────────────
//!      applied, needed by none (a leaf)       open: below tolerance → coarsen
//!   ═════════════════ the front ═══════════
//!      all needs applied (ready)              open: above tolerance → refine
//!   ───────────────────────────────────────
//!          some need not applied              never looked at
//! ```

mod together;

pub use together::{Member, Viewed, adapt_together};

use crate::bits::Bits;
use crate::calendar::Calendar;
use crate::request::Timer;
use crate::{Around, Criterion, MultiTessellation, Outcome, Pose, Request, Step, UpdateId};
use glam::Vec3;
use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashMap};

/// One viewer's state: the closed set S, the live mesh Γ_S, and scratch.
///
/// Apart from the mesh it holds three bits per update of the hierarchy, some 130 kB of wheels, and a calendar entry of
/// 4 bytes (some 8 as they are packed) for each open decision: one for every eight active vertices of a scan.
pub struct Front<H: MultiTessellation> {
    mesh: H::Mesh,
    applied: Bits,
    applied_count: usize,
    /// Open decisions. Exact where dependencies are explicit. Where they are read off the mesh an update may be
    /// open that turns out to wait for another one when it is looked at.
    open: Bits,
    open_count: usize,
    /// Updates that some queue knows of: the calendar, or `wanted`. While the budget binds: looked at in this view.
    filed: Bits,
    calendar: Calendar,
    /// Open decisions to refine, worst first.
    wanted: BinaryHeap<Ranked>,
    /// While the budget binds: applied updates that nothing needs, cheapest first.
    leaves: BinaryHeap<Reverse<Ranked>>,
    /// Decisions that have just opened.
    work: Vec<u32>,
    /// Updates that have just been applied. Most are soon needed by others; the calendar hears of the rest.
    fresh: Vec<Ranked>,
    /// Where dependencies are read off the mesh: who waits for the undoing of whom.
    waiting: HashMap<u32, Vec<u32>>,
    scratch: Vec<UpdateId>,
    steps: Vec<Step>,
    sweep: Sweep,
    pose: Option<Pose>,
    tolerance: f32,
    max_cells: Option<usize>,
    /// Cells of the fronts that shared the budget in the last call.
    others: usize,
    /// Counts views, so that a rank knows whether it is of today.
    view: u32,
    /// Where decisions are: each cell has a wheel of the calendar.
    grid: Grid,
    /// Ticks of the calendar per mesh unit.
    ticks_per_unit: f64,
    budget_bound: bool,
    /// The calendar is not up to date: look at everything when the view changes.
    stale: bool,
    settled: bool,
}

/// A look at every open decision that is not filed, in parts.
#[derive(Clone, Copy, Default)]
struct Sweep {
    word: usize,
    words_left: usize,
}

/// A decision with what the criterion said.
#[derive(Clone, Copy, Debug)]
pub struct Ranked {
    pixels: f32,
    slack: f32,
    m: u32,
    view: u32,
    cell: u16,
}
impl PartialEq for Ranked {
    fn eq(&self, other: &Ranked) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Ranked {}
impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Ranked) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ranked {
    /// By pixels; among equals the coarser update is the greater one.
    fn cmp(&self, other: &Ranked) -> Ordering {
        self.pixels.total_cmp(&other.pixels).then(other.m.cmp(&self.m))
    }
}

/// What one call carries about.
pub struct Run {
    tolerance: f32,
    max_cells: usize,
    evaluations: u32,
    timer: Timer,
}

impl Run {
    fn new(r: &Request) -> Run {
        Run {
            tolerance: if r.tolerance > 0.0 { r.tolerance } else { 0.0 },
            max_cells: r.max_cells.unwrap_or(usize::MAX),
            evaluations: 0,
            timer: Timer::start(r),
        }
    }
}

/// Weight of applying or undoing an update for the timer, in looks at a decision.
const UPDATE: u32 = 8;

/// How many applied updates wait for being needed.
const FRESH: usize = 512;

/// Ticks of the calendar in the longest side of what changes: slacks are told apart from 1e-4 of it, seen from a
/// thousandth of it away, to 64 times it.
const TICKS_PER_EXTENT: f64 = (1u64 << 17) as f64;

impl<H: MultiTessellation> Front<H> {
    /// A front at the base mesh. Copies that, and looks at every footprint once: 5 ms for half a million updates.
    pub fn new(h: &H) -> Front<H> {
        let grid = Grid::new(h);
        let ticks_per_unit = TICKS_PER_EXTENT / grid.extent as f64;
        let mut front = Front {
            mesh: h.base(),
            applied: Bits::new(h.len()),
            applied_count: 0,
            open: Bits::new(h.len()),
            open_count: 0,
            filed: Bits::new(h.len()),
            calendar: Calendar::new(grid.len()),
            wanted: BinaryHeap::new(),
            leaves: BinaryHeap::new(),
            work: Vec::new(),
            fresh: Vec::new(),
            waiting: HashMap::new(),
            scratch: Vec::new(),
            steps: Vec::new(),
            sweep: Sweep::default(),
            pose: None,
            tolerance: 0.0,
            max_cells: None,
            others: 0,
            view: 0,
            grid,
            ticks_per_unit: if ticks_per_unit.is_normal() { ticks_per_unit } else { 1.0 },
            budget_bound: false,
            stale: false,
            settled: false,
        };
        front.open_roots(h);
        front
    }

    /// Back to the base mesh, in the same memory. The steps of the next call count from there.
    pub fn reset(&mut self, h: &H) {
        h.reset(&mut self.mesh);
        self.steps.clear();
        self.applied.clear();
        self.applied_count = 0;
        self.open.clear();
        self.open_count = 0;
        self.work.clear();
        self.fresh.clear();
        self.waiting.clear();
        self.sweep.word = 0;
        self.pose = None;
        self.budget_bound = false;
        self.open_roots(h);
    }

    fn open_roots(&mut self, h: &H) {
        h.roots(|m| {
            self.open_count += self.open.insert(m.0) as usize;
        });
        self.look_at_all();
    }

    /// The live mesh Γ_S.
    pub fn mesh(&self) -> &H::Mesh {
        &self.mesh
    }
    /// The live mesh, to clear its record of changes. What the hierarchy reads must stay as it is.
    pub fn mesh_mut(&mut self) -> &mut H::Mesh {
        &mut self.mesh
    }
    /// Whether an update is in S.
    pub fn is_applied(&self, m: UpdateId) -> bool {
        self.applied.has(m.0)
    }
    /// Number of updates in S.
    pub fn applied_count(&self) -> usize {
        self.applied_count
    }
    /// The updates in S, in order of id; a legal order to apply them in.
    pub fn applied(&self) -> impl Iterator<Item = UpdateId> + '_ {
        self.applied.iter().map(UpdateId)
    }
    /// What the last call of a strategy did, in order. After `top_down` and `interruptible`: from the base mesh.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }
    /// Heap memory of everything but the mesh, in bytes.
    pub fn memory(&self) -> usize {
        (self.applied.words().len() * 3) * 8
            + self.calendar.memory()
            + (self.wanted.capacity() + self.leaves.capacity() + self.fresh.capacity()) * size_of::<Ranked>()
            + (self.work.capacity() + self.scratch.capacity()) * 4
            + self.steps.capacity() * size_of::<Step>()
    }

    /// The greatest `pixels` of an update that is not applied. Asks about every open decision: some milliseconds
    /// for a hundred thousand. Exact where footprints nest.
    pub fn measure<C: Criterion + ?Sized>(&self, h: &H, c: &C) -> f32 {
        let ready = self.open.iter().filter(|&m| !self.applied.has(m));
        ready.map(|m| c.pixels(&h.footprint(UpdateId(m)))).fold(0.0, f32::max)
    }

    /// Incremental: from the front as it is to the front of this view, contraction and then expansion.
    ///
    /// Costs in proportion to the decisions that come due and the updates that change. Nothing, if the view is that
    /// of the last call. A tolerance, or a setting of the criterion, other than in the last call makes every open
    /// decision due.
    ///
    /// *Deadline*: the call returns once its time is up, between two updates, with a legal front; half of the time
    /// at least goes into refinement, worst first. What is left over goes on in the next call.
    ///
    /// *Budget*: no update is applied that would take the front over `max_cells`. While the budget keeps the
    /// front from the tolerance, the least wrong leaves make room for the worst decisions, where that strictly
    /// improves; this needs a rank for every open decision, so each new view then looks at all of them. After the
    /// budget was lowered, a front without a deadline is within it at once; with one, in the course of calls.
    pub fn adapt<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, r: &Request) -> Outcome {
        let mut me = Viewed::new(self, h, c);
        adapt_together(&mut [&mut me], r);
        me.outcome()
    }

    /// Top-down: from the base mesh, depth first. The quickest way to a front that has little in common with the
    /// present one. Stops at a deadline or budget without regard to what is worst; `adapt` goes on from there.
    pub fn top_down<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, r: &Request) -> Outcome {
        self.reset(h);
        let mut run = Run::new(r);
        self.enter(c.pose(), run.tolerance);
        self.max_cells = r.max_cells;
        self.settled = false;
        // Depth first: the live mesh is touched in one place after the other.
        self.sweep.words_left = 0;
        self.work.extend(self.open.iter());
        while let Some(m) = self.work.pop() {
            if !self.open.has(m) {
                continue;
            }
            run.evaluations += 1;
            let pixels = c.pixels(&h.footprint(UpdateId(m)));
            if pixels <= run.tolerance || self.applied.has(m) {
                run.timer.spend(1);
            } else if self.apply(h, m, run.max_cells) {
                run.timer.spend(UPDATE);
            } else {
                self.wanted.push(Ranked { pixels, slack: 0.0, m, view: self.view, cell: 0 });
                break;
            }
            if run.timer.out() {
                break;
            }
        }
        self.settled = self.work.is_empty() && self.wanted.is_empty();
        // Nobody knows for how long these answers hold.
        self.stale = true;
        self.report(h, run.tolerance, run.evaluations)
    }

    /// Interruptible: from the base mesh, worst first, so that whenever a deadline or the budget stops it the front
    /// is the best of its size. `adapt` goes on from there.
    pub fn interruptible<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, r: &Request) -> Outcome {
        self.reset(h);
        self.adapt(h, c, r)
    }

    /// Gives back what a large change needed, bit by bit.
    fn trim(&mut self) {
        fn half(len: usize, capacity: usize) -> Option<usize> {
            (capacity > 1024 && len < capacity / 8).then_some(capacity / 2)
        }
        if let Some(n) = half(self.steps.len(), self.steps.capacity()) {
            self.steps.shrink_to(n);
        }
        if let Some(n) = half(self.wanted.len(), self.wanted.capacity()) {
            self.wanted.shrink_to(n);
        }
        if let Some(n) = half(self.leaves.len(), self.leaves.capacity()) {
            self.leaves.shrink_to(n);
        }
        if let Some(n) = half(self.work.len(), self.work.capacity()) {
            self.work.shrink_to(n);
        }
    }

    /// Takes note of the view, and has the calendar hand out what comes due. Whether it moved; `None` if all
    /// answers are void.
    fn enter(&mut self, pose: Pose, tolerance: f32) -> Option<bool> {
        let before = self.pose.replace(pose);
        let same_tolerance = std::mem::replace(&mut self.tolerance, tolerance) == tolerance;
        if same_tolerance && before == self.pose {
            return Some(false);
        }
        self.view = self.view.wrapping_add(1);
        let before = before.filter(|_| same_tolerance)?;
        let travels = pose.travels(&before)?;
        for cell in 0..self.grid.len() {
            let travel = travels.seen_from(self.grid.center(cell), self.grid.radius);
            self.calendar.advance(cell, (travel * self.ticks_per_unit).ceil().min(1e15) as u64);
        }
        Some(true)
    }

    fn report(&self, h: &H, tolerance: f32, evaluations: u32) -> Outcome {
        let refined = self.steps.iter().filter(|s| matches!(s, Step::Refine(_))).count() as u32;
        let worst = self.wanted.peek().map_or(0.0, |w| w.pixels);
        Outcome {
            refined,
            coarsened: self.steps.len() as u32 - refined,
            evaluations,
            open: self.open_count as u32,
            cells: h.cells(&self.mesh),
            settled: self.settled,
            budget_bound: self.budget_bound,
            error_px: if self.applied_count == h.len() { 0.0 } else { worst.max(tolerance) },
        }
    }

    fn is_idle(&self) -> bool {
        self.no_decisions() && (self.wanted.is_empty() || self.budget_bound)
    }
    fn no_decisions(&self) -> bool {
        self.work.is_empty() && !self.calendar.has_due() && self.sweep.words_left == 0
    }

    /// Makes every open decision due.
    fn look_at_all(&mut self) {
        self.calendar.clear();
        self.filed.clear();
        self.wanted.clear();
        self.leaves.clear();
        // From where the last sweep stopped: no decision starves however often the settings change.
        self.sweep.words_left = self.open.words().len();
        self.stale = false;
        self.settled = false;
    }

    /// From now on every open decision has a rank.
    fn bind(&mut self) {
        self.budget_bound = true;
        self.look_at_all();
    }

    /// The next decision to look at.
    fn next_decision(&mut self) -> Option<u32> {
        while let Some(m) = self.work.pop() {
            if self.open.has(m) && (H::READS_MESH || !self.filed.has(m)) {
                return Some(m);
            }
        }
        while let Some(m) = self.calendar.take_due() {
            self.filed.remove(m);
            if self.open.has(m) {
                return Some(m);
            }
        }
        while self.sweep.words_left > 0 {
            let w = self.sweep.word;
            let bits = self.open.words()[w] & !self.filed.words()[w];
            if bits != 0 {
                return Some(w as u32 * 64 + bits.trailing_zeros());
            }
            self.sweep.word = (w + 1) % self.open.words().len();
            self.sweep.words_left -= 1;
        }
        None
    }

    /// Looks at what is due: undoes the leaves that are not wanted, ranks the decisions that are.
    fn contract<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, run: &mut Run) {
        while let Some(m) = self.next_decision() {
            let steps = self.steps.len();
            self.decide(h, c, m, run);
            if run.timer.spend(if self.steps.len() > steps { UPDATE } else { 1 }) {
                break;
            }
        }
    }

    /// Applies what is wanted, worst first, as long as it is worse than `down_to`. `false` where the budget is in the
    /// way.
    fn expand<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, max_cells: usize, down_to: f32, run: &mut Run) -> bool {
        let mut room = true;
        while let Some(mut top) = self.wanted.pop() {
            if top.pixels <= down_to {
                self.wanted.push(top);
                break;
            }
            self.filed.remove(top.m);
            if !self.open.has(top.m) || self.applied.has(top.m) {
                self.decide(h, c, top.m, run);
                continue;
            }
            if top.view != self.view {
                top = self.rank(h, c, top.m, run);
                if top.pixels <= run.tolerance {
                    self.file(top);
                    run.timer.spend(1);
                    continue;
                }
            }
            room = self.apply(h, top.m, max_cells);
            if !room {
                self.filed.insert(top.m);
                self.wanted.push(top);
                break;
            }
            self.file_later(top);
            self.drain_work(h, c, run);
            if run.timer.spend(UPDATE) {
                break;
            }
        }
        self.file_fresh();
        room
    }

    /// The least wrong leaf, ranked in this view: the first of `leaves`.
    fn cheapest<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, run: &mut Run) -> Option<Ranked> {
        while let Some(&Reverse(leaf)) = self.leaves.peek() {
            if !self.is_leaf(h, leaf.m) {
                self.leaves.pop();
                self.filed.remove(leaf.m);
                if H::READS_MESH {
                    self.work.push(leaf.m);
                }
            } else if leaf.view == self.view {
                return Some(leaf);
            } else {
                self.leaves.pop();
                let leaf = self.rank(h, c, leaf.m, run);
                self.leaves.push(Reverse(leaf));
            }
        }
        None
    }

    /// The worst decision, ranked in this view: the first of `wanted`.
    fn worst<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, run: &mut Run) -> Option<Ranked> {
        while let Some(&top) = self.wanted.peek() {
            if !self.open.has(top.m) || self.applied.has(top.m) {
                self.wanted.pop();
                self.filed.remove(top.m);
            } else if top.view == self.view {
                return Some(top);
            } else {
                self.wanted.pop();
                let top = self.rank(h, c, top.m, run);
                if top.pixels > run.tolerance {
                    self.wanted.push(top);
                }
            }
        }
        None
    }

    fn is_leaf(&self, h: &H, m: u32) -> bool {
        let mut leaf = self.open.has(m) && self.applied.has(m);
        if H::READS_MESH && leaf {
            h.needed_by(&self.mesh, UpdateId(m), |n| leaf &= !self.applied.has(n.0));
        }
        leaf
    }

    fn drain_work<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, run: &mut Run) {
        while let Some(m) = self.work.pop() {
            if H::READS_MESH || !self.filed.has(m) {
                self.decide(h, c, m, run);
            }
        }
    }

    #[inline]
    fn rank<C: Criterion + ?Sized>(&self, h: &H, c: &C, m: u32, run: &mut Run) -> Ranked {
        run.evaluations += 1;
        let f = h.footprint(UpdateId(m));
        let (pixels, slack) = c.score(&f, run.tolerance);
        Ranked { pixels, slack, m, view: self.view, cell: self.grid.cell(f.center) }
    }

    /// The calendar has it from here.
    #[inline]
    fn file(&mut self, rank: Ranked) {
        if self.filed.insert(rank.m) {
            self.calendar.file(rank.cell as usize, rank.m, (rank.slack as f64 * self.ticks_per_unit) as u64);
        }
    }

    /// The calendar has it from here, unless it is soon no decision any more.
    #[inline]
    fn file_later(&mut self, rank: Ranked) {
        self.fresh.push(rank);
        if self.fresh.len() == FRESH {
            self.file_fresh();
        }
    }
    fn file_fresh(&mut self) {
        while let Some(rank) = self.fresh.pop() {
            if self.open.has(rank.m) {
                self.file(rank);
            }
        }
    }

    /// Looks at a decision.
    #[inline]
    fn decide<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, m: u32, run: &mut Run) {
        if !self.open.has(m) {
            return;
        }
        let rank = self.rank(h, c, m, run);
        let (applied, wanted) = (self.applied.has(m), rank.pixels > run.tolerance);
        // An answer that changes nothing needs no look at the mesh.
        if H::READS_MESH && (applied != wanted || self.budget_bound) && self.waits(h, m) {
            return;
        }
        match (applied, wanted) {
            (false, true) => {
                self.filed.insert(m);
                self.wanted.push(rank);
            }
            (true, true) if self.budget_bound => {
                self.filed.insert(m);
                self.leaves.push(Reverse(rank));
            }
            (applied, wanted) => {
                if applied && !wanted {
                    self.undo(h, m);
                }
                if self.budget_bound {
                    self.filed.insert(m);
                } else {
                    self.file(rank);
                }
            }
        }
    }

    /// Where dependencies are read off the mesh: whether another update must come first. Then the decision is not
    /// open, and opens again when that other update is undone or applied.
    fn waits(&mut self, h: &H, m: u32) -> bool {
        let mut blocker = None;
        if self.applied.has(m) {
            h.needed_by(&self.mesh, UpdateId(m), |n| {
                if blocker.is_none() && self.applied.has(n.0) {
                    blocker = Some(n.0);
                }
            });
            if let Some(n) = blocker {
                self.waiting.entry(n).or_default().push(m);
            }
        } else {
            // Only one that announces its children will call again; nesting says that it is wanted if `m` is.
            h.needs(&self.mesh, UpdateId(m), |n| {
                if blocker.is_none() && !self.applied.has(n.0) {
                    h.children(n, |child| {
                        if child.0 == m {
                            blocker = Some(n.0);
                        }
                    });
                }
            });
        }
        if blocker.is_some() {
            self.close(m);
        }
        blocker.is_some()
    }

    /// Applies `m` and all that it needs; `false`, and nothing done, where the budget does not allow it.
    fn apply(&mut self, h: &H, m: u32, max_cells: usize) -> bool {
        let room = |front: &Self, m| h.cells(&front.mesh).saturating_add(h.cells_added(m)) <= max_cells;
        if !H::READS_MESH {
            let m = UpdateId(m);
            if max_cells != usize::MAX && !room(self, m) {
                return false;
            }
            self.refine(h, m);
            return true;
        }
        let first = self.steps.len();
        let mut stack = std::mem::take(&mut self.scratch);
        stack.clear();
        stack.push(UpdateId(m));
        while let Some(&top) = stack.last() {
            if self.applied.has(top.0) {
                stack.pop();
                continue;
            }
            let before = stack.len();
            h.needs(&self.mesh, top, |n| {
                if !self.applied.has(n.0) {
                    stack.push(n);
                }
            });
            if stack.len() == before {
                if !room(self, top) {
                    while self.steps.len() > first {
                        let Some(Step::Refine(last)) = self.steps.pop() else { unreachable!("only refined since") };
                        self.undo(h, last.0);
                        self.steps.pop();
                    }
                    self.scratch = stack;
                    return false;
                }
                self.refine(h, top);
                if top.0 != m {
                    // Nobody asked whether it is wanted for itself.
                    self.work.push(top.0);
                }
                stack.pop();
            }
        }
        self.scratch = stack;
        true
    }

    fn open(&mut self, m: u32) {
        self.open_count += self.open.insert(m) as usize;
    }
    fn close(&mut self, m: u32) {
        self.open_count -= self.open.remove(m) as usize;
    }

    /// Applies a legal update, and opens and closes decisions around it.
    fn refine(&mut self, h: &H, m: UpdateId) {
        self.applied_count += 1;
        self.steps.push(Step::Refine(m));
        self.open(m.0);
        let Front { open, open_count, applied, filed, work, mesh, .. } = self;
        let mut note = |around| take_note(around, open, open_count, filed, work);
        if H::READS_MESH {
            h.refine(mesh, m);
            h.children(m, |child| {
                if !applied.has(child.0) {
                    note(Around::Opened(child));
                }
            });
        } else {
            h.refine_around(mesh, m, |n| applied.has(n.0), note);
        }
        applied.insert(m.0);
    }

    /// Undoes a leaf, and opens and closes decisions around it.
    fn undo(&mut self, h: &H, m: u32) {
        let m = UpdateId(m);
        self.applied.remove(m.0);
        self.applied_count -= 1;
        self.steps.push(Step::Coarsen(m));
        self.open(m.0);
        if H::READS_MESH {
            h.coarsen(&mut self.mesh, m);
            for waiting in self.waiting.remove(&m.0).unwrap_or_default() {
                if self.applied.has(waiting) {
                    self.open(waiting);
                    self.work.push(waiting);
                }
            }
        } else {
            let Front { open, open_count, applied, filed, work, mesh, .. } = self;
            let note = |around| take_note(around, open, open_count, filed, work);
            h.coarsen_around(mesh, m, |n| applied.has(n.0), note);
        }
    }
}

/// A decision opens or closes; one that nobody knows of is work.
#[inline]
fn take_note(around: Around, open: &mut Bits, open_count: &mut usize, filed: &Bits, work: &mut Vec<u32>) {
    match around {
        Around::Closed(m) => *open_count -= open.remove(m.0) as usize,
        Around::Opened(m) => {
            *open_count += open.insert(m.0) as usize;
            if !filed.has(m.0) {
                work.push(m.0);
            }
        }
    }
}

/// A grid of cubes over the centres of all footprints.
struct Grid {
    min: Vec3,
    /// The longest side of the box.
    extent: f32,
    side: f32,
    per_side: f32,
    counts: [u16; 3],
    /// Of a sphere around a cube.
    radius: f32,
}

impl Grid {
    /// More cells tell motion apart better, but each costs a wheel and some 0.05 µs a frame.
    const MOST: usize = 100;

    fn new<H: MultiTessellation>(h: &H) -> Grid {
        let (min, max) = h.centers();
        let size = max - min;
        let extent = size.max_element();
        let cut = |n: f32| {
            let side = extent / n;
            let counts = (size / side).ceil().max(Vec3::ONE).to_array().map(|n| n as u16);
            // A little wider than the cube, for centres that rounding puts next door.
            Grid { min, extent, side, per_side: 1.0 / side, counts, radius: side * 0.8662 }
        };
        let fits = |g: &Grid| g.side > 0.0 && g.side.is_finite() && g.len() <= Grid::MOST;
        // Nothing, or all of it in one place.
        let point = || Grid { min: min.min(max), extent: 0.0, side: 1.0, per_side: 1.0, counts: [1; 3], radius: 0.0 };
        (1..=12).rev().map(|n| cut(n as f32)).find(fits).unwrap_or_else(point)
    }
    fn len(&self) -> usize {
        self.counts.iter().map(|&n| n as usize).product()
    }
    #[inline]
    fn cell(&self, p: Vec3) -> u16 {
        let at = (p - self.min) * self.per_side;
        let [nx, ny, nz] = self.counts;
        let (x, y, z) = ((at.x as u16).min(nx - 1), (at.y as u16).min(ny - 1), (at.z as u16).min(nz - 1));
        (z * ny + y) * nx + x
    }
    fn center(&self, cell: usize) -> Vec3 {
        let [nx, ny, _] = self.counts.map(|n| n as usize);
        if self.extent == 0.0 {
            return self.min;
        }
        let at = Vec3::new((cell % nx) as f32, (cell / nx % ny) as f32, (cell / (nx * ny)) as f32);
        self.min + (at + 0.5) * self.side
    }
}
