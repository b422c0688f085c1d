//! The base mesh: the two halves of the square, cut for as long as a triangle is partly outside of the field or over
//! missing samples. What is left of them is whole or not there at all, so borders and holes are exact in every front.

use super::lattice::{Lattice, Site, quarter};
use std::collections::{HashMap, HashSet};

/// A triangle of the square by its corners: the ends of the hypotenuse and then the right angle, counter-clockwise.
type Corners = [[i32; 2]; 3];

/// Which samples are missing.
pub(super) struct Missing {
    lattice: Lattice,
    /// How many are missing to the south-west of a sample, itself included; `None` where none is.
    sums: Option<Vec<u32>>,
}

impl Missing {
    /// `heights` are row by row from the south; NaN is missing.
    pub fn of(lattice: &Lattice, heights: &[f32]) -> Missing {
        let columns = lattice.columns as usize;
        let sums = heights.iter().any(|h| h.is_nan()).then(|| {
            let mut sums = vec![0u32; heights.len()];
            for (i, h) in heights.iter().enumerate() {
                let (x, y) = (i % columns, i / columns);
                let west = if x > 0 { sums[i - 1] } else { 0 };
                let south = if y > 0 { sums[i - columns] } else { 0 };
                let both = if x > 0 && y > 0 { sums[i - columns - 1] } else { 0 };
                sums[i] = west + south - both + u32::from(h.is_nan());
            }
            sums
        });
        Missing { lattice: lattice.clone(), sums }
    }
    pub fn any(&self) -> bool {
        self.sums.is_some()
    }
    /// How many samples of a box are missing, of those inside of the field.
    fn inside(&self, [x0, y0]: [i32; 2], [x1, y1]: [i32; 2]) -> u32 {
        let Some(sums) = &self.sums else { return 0 };
        let at = |x: i32, y: i32| if x < 0 || y < 0 { 0 } else { sums[(y * self.lattice.columns + x) as usize] };
        at(x1, y1) + at(x0 - 1, y0 - 1) - at(x0 - 1, y1) - at(x1, y0 - 1)
    }
    fn is_missing(&self, [x, y]: [i32; 2]) -> bool {
        !self.lattice.contains(x, y) || self.inside([x, y], [x, y]) == 1
    }
    /// Whether a triangle is there, where it is known to be so as a whole.
    fn whole_is_there(&self, mut t: Corners) -> bool {
        if self.sums.is_none() {
            return t.iter().all(|&p| !self.is_missing(p));
        }
        while !is_finest(&t) {
            t = halves(&t)[0];
        }
        t.iter().all(|&p| !self.is_missing(p))
    }
    /// Which of the two triangles of an update are there. Both are there as a whole or not at all.
    pub fn sides(&self, site: &Site) -> [bool; 2] {
        site.apexes().map(|way| self.whole_is_there(triangle(site, way)))
    }
}

fn is_finest([a, b, _]: &Corners) -> bool {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) == 1
}

/// The triangle of an update with the right angle at a step from it.
pub(super) fn triangle(site: &Site, [dx, dy]: [i32; 2]) -> Corners {
    let &Site { x, y, .. } = site;
    // The apex lies to the left of the way from one end of the hypotenuse to the other.
    [[x - dy, y + dx], [x + dy, y - dx], [x + dx, y + dy]]
}

fn middle([a, b, _]: &Corners) -> [i32; 2] {
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]
}

/// The two triangles that a cut at the middle of the hypotenuse makes.
fn halves(t: &Corners) -> [Corners; 2] {
    let (m, [a, b, c]) = (middle(t), *t);
    [[c, a, m], [b, c, m]]
}

/// What base meshes are made of.
pub(super) struct Base {
    /// Samples.
    pub vertices: Vec<[i32; 2]>,
    /// Indices of vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Which triangle has its right angle at a sample (maybe outside of the field) and its hypotenuse in a direction.
    pub at: HashMap<([i32; 2], usize), u32>,
    /// Samples where the base mesh is cut already: they are no updates.
    pub cut: HashSet<[i32; 2]>,
}

enum There {
    Whole,
    Not,
    Partly,
}

impl Base {
    pub fn new(lattice: &Lattice, missing: &Missing) -> Base {
        let n = lattice.side;
        let roots = [[[n, n], [0, 0], [n, 0]], [[0, 0], [n, n], [0, n]]];
        let mut cut = HashSet::new();
        for root in &roots {
            look(root, lattice, missing, &mut cut);
        }
        // A cut needs the cuts that made the two triangles that it goes through, where they are there.
        let mut stack: Vec<[i32; 2]> = cut.iter().copied().collect();
        while let Some([x, y]) = stack.pop() {
            let site = lattice.site_at(x, y).expect("corners of the square are in the middle of nothing");
            for [dx, dy] in site.apexes() {
                let apex = [x + dx, y + dy];
                if lattice.site_at(apex[0], apex[1]).is_some() && !missing.is_missing(apex) && cut.insert(apex) {
                    stack.push(apex);
                }
            }
        }
        let mut base = Base { vertices: vec![], triangles: vec![], at: HashMap::new(), cut };
        let mut index = HashMap::new();
        let mut stack = roots.to_vec();
        stack.reverse();
        while let Some(t) = stack.pop() {
            if !is_finest(&t) && base.cut.contains(&middle(&t)) {
                let [first, second] = halves(&t);
                stack.extend([second, first]);
            } else if missing.whole_is_there(t) {
                let Base { vertices, triangles, at, .. } = &mut base;
                at.insert((t[2], direction(&t)), triangles.len() as u32);
                triangles.push(t.map(|p| {
                    *index.entry(p).or_insert_with(|| {
                        vertices.push(p);
                        vertices.len() as u32 - 1
                    })
                }));
            }
        }
        base
    }
}

/// The direction from a triangle's right angle to the middle of its hypotenuse.
fn direction([a, b, c]: &Corners) -> usize {
    quarter([a[0] + b[0] - 2 * c[0], a[1] + b[1] - 2 * c[1]])
}

/// Whether a triangle is there; notes where it has to be cut.
fn look(t: &Corners, lattice: &Lattice, missing: &Missing, cut: &mut HashSet<[i32; 2]>) -> There {
    let [a, b, c] = *t;
    let low = [0, 1].map(|k| a[k].min(b[k]).min(c[k]));
    let high = [0, 1].map(|k| a[k].max(b[k]).max(c[k]));
    if low[0] >= lattice.columns - 1 || low[1] >= lattice.rows - 1 {
        return There::Not;
    }
    let inside = high[0] < lattice.columns && high[1] < lattice.rows;
    let last = [high[0].min(lattice.columns - 1), high[1].min(lattice.rows - 1)];
    let holes = missing.inside(low, last);
    if holes == 0 && inside {
        return There::Whole;
    }
    if holes as i64 == (last[0] - low[0] + 1) as i64 * (last[1] - low[1] + 1) as i64 {
        return There::Not;
    }
    if is_finest(t) {
        return if t.iter().any(|&p| missing.is_missing(p)) { There::Not } else { There::Whole };
    }
    let [first, second] = halves(t).map(|half| look(&half, lattice, missing, cut));
    match (first, second) {
        (There::Whole, There::Whole) => There::Whole,
        (There::Not, There::Not) => There::Not,
        _ => {
            cut.insert(middle(t));
            There::Partly
        }
    }
}
