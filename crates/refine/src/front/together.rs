//! Several fronts under one budget and one deadline: what is worst in any of them comes first.
//!
//! CONTRACTION and EXPANSION of the tutorial (`defloriani2002`), with queues that run over all fronts. A single front is the
//! case of one.

use super::{Front, Ranked, Run, UPDATE};
use crate::{Criterion, MultiTessellation, Outcome, Request, UpdateId};
use std::cmp::Reverse;

/// A front, and what it is to be adapted to: one of those that share a budget.
pub struct Viewed<'a, H: MultiTessellation, C: ?Sized> {
    front: &'a mut Front<H>,
    hierarchy: &'a H,
    criterion: &'a C,
    tolerance: f32,
    evaluations: u32,
}

impl<'a, H: MultiTessellation, C: Criterion + ?Sized> Viewed<'a, H, C> {
    /// Of a front of this hierarchy.
    pub fn new(front: &'a mut Front<H>, hierarchy: &'a H, criterion: &'a C) -> Viewed<'a, H, C> {
        Viewed { front, hierarchy, criterion, tolerance: 0.0, evaluations: 0 }
    }
    /// What the call did to this front.
    pub fn outcome(&self) -> Outcome {
        self.front.report(self.hierarchy, self.tolerance, self.evaluations)
    }
    /// What is left of the budget for this one.
    fn limit(&self, run: &Run, others: usize) -> usize {
        run.max_cells.saturating_sub(others)
    }
}

/// A [`Viewed`] of any hierarchy and criterion.
pub trait Member: Steps {
    /// See [`Viewed::outcome`].
    fn outcome(&self) -> Outcome;
}

/// What the common loop asks of one front.
pub trait Steps {
    /// Takes note of the view. Whether everything is as in the last call, and nothing was left over then.
    fn arrive(&mut self, r: &Request, run: &Run, others: usize) -> bool;
    fn cells(&self) -> usize;
    fn is_bound(&self) -> bool;
    /// From now on every open decision has a rank.
    fn bind(&mut self);
    /// The budget is no longer in the way.
    fn release(&mut self);
    fn contract(&mut self, run: &mut Run);
    /// Pixels of what is wanted most, as last known; 0 where nothing is.
    fn most_wanted(&self) -> f32;
    /// `false` where the budget is in the way.
    fn expand(&mut self, run: &mut Run, others: usize, down_to: f32) -> bool;
    /// The worst decision, and how many cells applying it adds.
    fn worst(&mut self, run: &mut Run) -> Option<(Ranked, usize)>;
    /// The least wrong leaf, and how many cells undoing it frees.
    fn cheapest(&mut self, run: &mut Run) -> Option<(Ranked, usize)>;
    /// Takes what `cheapest` has just said.
    fn take_cheapest(&mut self);
    fn put_back(&mut self, leaf: Ranked);
    /// Undoes what was taken, if it is a leaf still.
    fn give_up(&mut self, leaf: Ranked);
    /// Applies what `worst` has just said.
    fn apply_worst(&mut self, run: &mut Run, others: usize);
    /// Looks at the decisions that have just opened.
    fn look_around(&mut self, run: &mut Run);
    fn no_decisions(&self) -> bool;
    fn is_idle(&self) -> bool;
    fn depart(&mut self, settled: bool, others: usize);
}

impl<H: MultiTessellation, C: Criterion + ?Sized> Member for Viewed<'_, H, C> {
    fn outcome(&self) -> Outcome {
        self.outcome()
    }
}

/// Runs a step that asks the criterion, and counts how often.
macro_rules! counted {
    ($self:ident, $run:ident, $front:ident => $step:expr) => {{
        let before = $run.evaluations;
        let $front = &mut *$self.front;
        let result = $step;
        $self.evaluations += $run.evaluations - before;
        result
    }};
}

impl<H: MultiTessellation, C: Criterion + ?Sized> Steps for Viewed<'_, H, C> {
    fn arrive(&mut self, r: &Request, run: &Run, others: usize) -> bool {
        self.tolerance = run.tolerance;
        let front = &mut *self.front;
        front.trim();
        front.steps.clear();
        let moved = front.enter(self.criterion.pose(), run.tolerance);
        let limits_changed = std::mem::replace(&mut front.max_cells, r.max_cells) != r.max_cells
            || (r.max_cells.is_some() && front.others != others);
        let quiet = front.settled && moved == Some(false) && !limits_changed;
        if front.stale || moved.is_none() || (front.budget_bound && (moved != Some(false) || limits_changed)) {
            front.budget_bound &= r.max_cells.is_some();
            front.look_at_all();
        }
        quiet
    }
    fn cells(&self) -> usize {
        self.hierarchy.cells(&self.front.mesh)
    }
    fn is_bound(&self) -> bool {
        self.front.budget_bound
    }
    fn bind(&mut self) {
        if !self.front.budget_bound {
            self.front.bind();
        }
    }
    fn release(&mut self) {
        self.front.budget_bound = false;
        self.front.stale = true;
    }
    fn contract(&mut self, run: &mut Run) {
        counted!(self, run, front => front.contract(self.hierarchy, self.criterion, run))
    }
    fn most_wanted(&self) -> f32 {
        self.front.wanted.peek().map_or(0.0, |top| top.pixels)
    }
    fn expand(&mut self, run: &mut Run, others: usize, down_to: f32) -> bool {
        let limit = self.limit(run, others);
        counted!(self, run, front => front.expand(self.hierarchy, self.criterion, limit, down_to, run))
    }
    fn worst(&mut self, run: &mut Run) -> Option<(Ranked, usize)> {
        let top = counted!(self, run, front => front.worst(self.hierarchy, self.criterion, run))?;
        Some((top, self.hierarchy.cells_added(UpdateId(top.m))))
    }
    fn cheapest(&mut self, run: &mut Run) -> Option<(Ranked, usize)> {
        let leaf = counted!(self, run, front => front.cheapest(self.hierarchy, self.criterion, run))?;
        Some((leaf, self.hierarchy.cells_added(UpdateId(leaf.m))))
    }
    fn take_cheapest(&mut self) {
        self.front.leaves.pop();
    }
    fn put_back(&mut self, leaf: Ranked) {
        self.front.leaves.push(Reverse(leaf));
    }
    fn give_up(&mut self, leaf: Ranked) {
        if self.front.is_leaf(self.hierarchy, leaf.m) {
            self.front.undo(self.hierarchy, leaf.m);
            self.front.wanted.push(leaf);
        } else {
            self.put_back(leaf);
        }
    }
    fn apply_worst(&mut self, run: &mut Run, others: usize) {
        let Some(top) = self.front.wanted.pop() else { return };
        let limit = self.limit(run, others);
        if self.front.open.has(top.m) && self.front.apply(self.hierarchy, top.m, limit) {
            self.put_back(top);
        }
        self.look_around(run);
    }
    fn look_around(&mut self, run: &mut Run) {
        counted!(self, run, front => front.drain_work(self.hierarchy, self.criterion, run))
    }
    fn no_decisions(&self) -> bool {
        self.front.no_decisions()
    }
    fn is_idle(&self) -> bool {
        self.front.is_idle()
    }
    fn depart(&mut self, settled: bool, others: usize) {
        self.front.settled = settled;
        self.front.others = others;
    }
}

/// Moves several fronts to their views, as [`Front::adapt`] does with one: `max_cells` is for all of them together, the
/// deadline for the whole call, and the tolerance for each. Criteria must speak of one unit, such as pixels.
///
/// While the budget binds, the least wrong leaves of all fronts make room for the worst decisions of all. Ask each member
/// for its [`outcome`](Member::outcome) afterwards. Costs what each front alone would, and a look at each per update while the budget
/// binds.
pub fn adapt_together(members: &mut [&mut dyn Member], r: &Request) {
    let mut run = Run::new(r);
    let total = cells(members);
    let mut quiet = true;
    for member in members.iter_mut() {
        let others = total - member.cells();
        quiet &= member.arrive(r, &run, others);
    }
    if quiet {
        return;
    }
    let mut bound = total > run.max_cells || members.iter().any(|m| m.is_bound());
    if bound {
        members.iter_mut().for_each(|m| m.bind());
    }
    let mut settled;
    loop {
        let limit = run.timer.begin_phase(0.5);
        for i in 0..members.len() {
            // To each of those that are left the same share; the last one's is all that is left.
            let left = members.len() - i;
            let limit = (left > 1).then(|| run.timer.begin_phase(1.0 / left as f32));
            members[i].contract(&mut run);
            if let Some(limit) = limit {
                run.timer.end_phase(limit);
            }
        }
        run.timer.end_phase(limit);
        // Also when time is up: a call applies at least one update, however short its time.
        let exhausted = if bound { balance(members, &mut run) } else { expand(members, &mut run) };
        if !exhausted && !bound && members.iter().all(|m| m.no_decisions()) {
            bound = true;
            members.iter_mut().for_each(|m| m.bind());
        }
        settled = exhausted && members.iter().all(|m| m.is_idle());
        if settled || run.timer.out() {
            break;
        }
    }
    let total = cells(members);
    // Some room is asked for before the calendar takes over again: filling it costs a look at everything.
    let room = settled && bound && total <= run.max_cells - run.max_cells / 10;
    if room && members.iter().all(|m| m.most_wanted() == 0.0) {
        members.iter_mut().for_each(|m| m.release());
    }
    for member in members.iter_mut() {
        let others = total - member.cells();
        member.depart(settled, others);
    }
}

fn cells(members: &[&mut dyn Member]) -> usize {
    members.iter().map(|m| m.cells()).sum()
}

/// Applies what is wanted, worst first. `false` where the budget is in the way.
fn expand(members: &mut [&mut dyn Member], run: &mut Run) -> bool {
    loop {
        let wanted = |i: &usize| members[*i].most_wanted();
        let Some(i) = (0..members.len()).max_by(|a, b| wanted(a).total_cmp(&wanted(b)).then(b.cmp(a))) else {
            return true;
        };
        if wanted(&i) <= 0.0 {
            return true;
        }
        // As long as it is the worst of all.
        let second = (0..members.len()).filter(|&j| j != i).map(|j| wanted(&j)).fold(0.0, f32::max);
        let down_to = second.min(wanted(&i).next_down());
        let others = cells(members) - members[i].cells();
        if !members[i].expand(run, others, down_to) {
            return false;
        }
        if run.timer.out() {
            return true;
        }
    }
}

/// Brings the fronts within the budget, and spends it on the worst decisions.
fn balance(members: &mut [&mut dyn Member], run: &mut Run) -> bool {
    let mut gathered = vec![];
    while cells(members) > run.max_cells {
        let Some((i, leaf, _)) = cheapest(members, run) else { break };
        members[i].take_cheapest();
        members[i].give_up(leaf);
        members[i].look_around(run);
        if run.timer.spend(UPDATE) {
            return false;
        }
    }
    while let Some((i, top, added)) = worst(members, run) {
        let cells_after = cells(members) + added;
        if cells_after > run.max_cells {
            let mut freed = 0;
            while cells_after - freed > run.max_cells {
                let Some((j, leaf, frees)) = cheapest(members, run).filter(|l| l.1.pixels < top.pixels) else { break };
                members[j].take_cheapest();
                freed += frees.min(cells_after - freed);
                gathered.push((j, leaf));
            }
            let enough = cells_after - freed <= run.max_cells;
            for (j, leaf) in gathered.drain(..) {
                if enough {
                    members[j].give_up(leaf);
                } else {
                    members[j].put_back(leaf);
                }
            }
            if !enough {
                return true;
            }
        }
        let others = cells(members) - members[i].cells();
        members[i].apply_worst(run, others);
        members.iter_mut().for_each(|m| m.look_around(run));
        if run.timer.spend(2 * UPDATE) {
            return false;
        }
    }
    true
}

/// The least wrong leaf of all fronts, whose it is, and how many cells undoing it frees.
fn cheapest(members: &mut [&mut dyn Member], run: &mut Run) -> Option<(usize, Ranked, usize)> {
    let each = members.iter_mut().enumerate().filter_map(|(i, m)| m.cheapest(run).map(|(leaf, n)| (i, leaf, n)));
    each.min_by(|a, b| a.1.pixels.total_cmp(&b.1.pixels))
}

/// The worst decision of all fronts, whose it is, and how many cells applying it adds.
fn worst(members: &mut [&mut dyn Member], run: &mut Run) -> Option<(usize, Ranked, usize)> {
    let each = members.iter_mut().enumerate().filter_map(|(i, m)| m.worst(run).map(|(top, n)| (i, top, n)));
    each.max_by(|a, b| a.1.pixels.total_cmp(&b.1.pixels).then(b.0.cmp(&a.0)))
}
