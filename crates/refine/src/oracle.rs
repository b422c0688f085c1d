//! The engine in its clearest form: what [`Front`](crate::Front) computes fast. Documentation, and the oracle of
//! the tests.
//!
//! Cost: every update of the hierarchy, several times a call.

use crate::{Criterion, MultiTessellation, Step, UpdateId};
use std::collections::HashSet;

/// A front without any bookkeeping.
pub struct Oracle<H: MultiTessellation> {
    /// The live mesh.
    pub mesh: H::Mesh,
    /// The closed set S.
    pub applied: HashSet<UpdateId>,
    /// What the last call did.
    pub steps: Vec<Step>,
}

impl<H: MultiTessellation> Oracle<H> {
    /// At the base mesh.
    pub fn new(h: &H) -> Oracle<H> {
        Oracle { mesh: h.base(), applied: HashSet::new(), steps: Vec::new() }
    }

    /// Applies the updates that look more than `tolerance` wrong, and what they need; undoes what nothing wants
    /// and nothing stands on.
    pub fn adapt<C: Criterion + ?Sized>(&mut self, h: &H, c: &C, tolerance: f32) {
        self.steps.clear();
        let wanted = |m| c.pixels(&h.footprint(m)) > tolerance;
        // Walk down from the roots; footprints nest, so an unwanted update ends its branch.
        let (mut stack, mut seen) = (Vec::new(), HashSet::new());
        h.roots(|m| stack.push(m));
        while let Some(m) = stack.pop() {
            if seen.insert(m) && wanted(m) {
                self.force(h, m);
                h.children(m, |child| stack.push(child));
            }
        }
        loop {
            let mut stands = true;
            for m in (0..h.len() as u32).rev().map(UpdateId) {
                if self.applied.contains(&m) && !wanted(m) && self.is_leaf(h, m) {
                    h.coarsen(&mut self.mesh, m);
                    self.applied.remove(&m);
                    self.steps.push(Step::Coarsen(m));
                    stands = false;
                }
            }
            if stands {
                return;
            }
        }
    }

    /// Applies an update, and before it all that it needs.
    pub fn force(&mut self, h: &H, m: UpdateId) {
        let mut stack = vec![m];
        while let Some(&top) = stack.last() {
            if self.applied.contains(&top) {
                stack.pop();
                continue;
            }
            let before = stack.len();
            h.needs(&self.mesh, top, |n| {
                if !self.applied.contains(&n) {
                    stack.push(n);
                }
            });
            if stack.len() == before {
                h.refine(&mut self.mesh, top);
                self.applied.insert(top);
                self.steps.push(Step::Refine(top));
                stack.pop();
            }
        }
    }

    /// Whether nothing applied needs `m`.
    pub fn is_leaf(&self, h: &H, m: UpdateId) -> bool {
        let mut leaf = true;
        h.needed_by(&self.mesh, m, |n| leaf &= !self.applied.contains(&n));
        leaf
    }
}
