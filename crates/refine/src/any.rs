//! The object-safe face of a front, for viewers, Python and WebAssembly: one virtual call per frame.

use crate::{Criterion, Front, Member, MultiTessellation, Outcome, Request, Step, Viewed};
use std::sync::Arc;

/// A front whose model is not known at compile time. See [`Front`] for what the methods do.
pub trait AnyFront {
    /// [`Front::adapt`].
    fn adapt(&mut self, c: &dyn Criterion, r: &Request) -> Outcome;
    /// As one of several fronts that share their limits: see [`adapt_together`](crate::adapt_together).
    fn viewed_as<'a>(&'a mut self, c: &'a dyn Criterion) -> Box<dyn Member + 'a>;
    /// [`Front::top_down`].
    fn top_down(&mut self, c: &dyn Criterion, r: &Request) -> Outcome;
    /// [`Front::interruptible`].
    fn interruptible(&mut self, c: &dyn Criterion, r: &Request) -> Outcome;
    /// [`Front::measure`].
    fn measure(&self, c: &dyn Criterion) -> f32;
    /// [`Front::reset`].
    fn reset(&mut self);
    /// [`Front::steps`].
    fn steps(&self) -> &[Step];
    /// Cells of the live mesh.
    fn cells(&self) -> usize;
    /// [`Front::applied_count`].
    fn applied_count(&self) -> usize;
    /// Updates of the hierarchy.
    fn updates(&self) -> usize;
}

/// A front together with the hierarchy that it belongs to, which other fronts may share.
pub struct Owned<H: MultiTessellation> {
    /// The hierarchy.
    pub hierarchy: Arc<H>,
    /// The front.
    pub front: Front<H>,
}

impl<H: MultiTessellation> Owned<H> {
    /// A front at the base mesh.
    pub fn new(hierarchy: Arc<H>) -> Owned<H> {
        let front = Front::new(&*hierarchy);
        Owned { hierarchy, front }
    }
}

impl<H: MultiTessellation> AnyFront for Owned<H> {
    fn adapt(&mut self, c: &dyn Criterion, r: &Request) -> Outcome {
        self.front.adapt(&self.hierarchy, c, r)
    }
    fn viewed_as<'a>(&'a mut self, c: &'a dyn Criterion) -> Box<dyn Member + 'a> {
        Box::new(Viewed::new(&mut self.front, &*self.hierarchy, c))
    }
    fn top_down(&mut self, c: &dyn Criterion, r: &Request) -> Outcome {
        self.front.top_down(&self.hierarchy, c, r)
    }
    fn interruptible(&mut self, c: &dyn Criterion, r: &Request) -> Outcome {
        self.front.interruptible(&self.hierarchy, c, r)
    }
    fn measure(&self, c: &dyn Criterion) -> f32 {
        self.front.measure(&self.hierarchy, c)
    }
    fn reset(&mut self) {
        self.front.reset(&self.hierarchy)
    }
    fn steps(&self) -> &[Step] {
        self.front.steps()
    }
    fn cells(&self) -> usize {
        self.hierarchy.cells(self.front.mesh())
    }
    fn applied_count(&self) -> usize {
        self.front.applied_count()
    }
    fn updates(&self) -> usize {
        self.hierarchy.len()
    }
}
