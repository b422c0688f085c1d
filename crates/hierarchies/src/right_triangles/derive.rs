//! Errors, spheres and cones of all updates from the heights alone, fine to coarse.

use super::base::{Base, Missing};
use super::lattice::{APEXES, Lattice, NOWHERE, Site, Spot};
use super::record::{self, Record};
use super::{Columns, Corner, InvalidHeights, RightTriangles};
use crate::model::Progress;
use crate::parallel::{filled, for_chunks};
use glam::{DVec2, Vec2, Vec3};
use meshfront_mesh::Bounds;
use std::f32::consts::PI;

/// Updates of a level that are done at a time.
const CHUNK: usize = 4096;

/// Heights with what is needed to look at them.
struct Field<'a> {
    heights: &'a [f32],
    columns: i32,
    rows: i32,
    spacing: Vec2,
    /// One over twice the spacing.
    per_two: Vec2,
}

impl Field<'_> {
    #[inline]
    fn at(&self, x: i32, y: i32) -> f32 {
        self.heights[(y * self.columns + x) as usize]
    }
    fn there(&self, x: i32, y: i32) -> Option<f32> {
        let inside = (0..self.columns).contains(&x) && (0..self.rows).contains(&y);
        inside.then(|| self.at(x, y)).filter(|h| !h.is_nan())
    }
    /// From central differences; at borders and beside missing samples from what there is.
    fn normal(&self, x: i32, y: i32) -> Vec3 {
        if (1..self.columns - 1).contains(&x) && (1..self.rows - 1).contains(&y) {
            let across = (self.at(x + 1, y) - self.at(x - 1, y)) * self.per_two.x;
            let up = (self.at(x, y + 1) - self.at(x, y - 1)) * self.per_two.y;
            if !(across + up).is_nan() {
                return Vec3::new(-across, -up, 1.0).normalize_or(Vec3::Z);
            }
        }
        let here = self.at(x, y);
        let slope = |before: Option<f32>, after: Option<f32>, step: f32| match (before, after) {
            (Some(a), Some(b)) => (b - a) / (2.0 * step),
            (Some(a), None) => (here - a) / step,
            (None, Some(b)) => (b - here) / step,
            (None, None) => 0.0,
        };
        let dx = slope(self.there(x - 1, y), self.there(x + 1, y), self.spacing.x);
        let dy = slope(self.there(x, y - 1), self.there(x, y + 1), self.spacing.y);
        Vec3::new(-dx, -dy, 1.0).normalize_or(Vec3::Z)
    }

    /// Notes the vertical distances of samples of a row, from column `x`, from a line that starts at `start` there.
    #[inline(always)]
    fn row(&self, worst: &mut Worst, [x, y]: [i32; 2], count: i32, start: f32, slope: f32) {
        let first = (y * self.columns + x) as usize;
        let row = &self.heights[first..first + count as usize];
        // The last window reaches back over what was looked at before.
        if let Some(last) = row.last_chunk::<8>() {
            for (g, group) in row.as_chunks::<8>().0.iter().enumerate() {
                worst.note(group, 8 * g, start, slope);
            }
            worst.note(last, row.len() - 8, start, slope);
        } else if let (Some(first), Some(last)) = (row.first_chunk::<4>(), row.last_chunk::<4>()) {
            worst.note(first, 0, start, slope);
            worst.note(last, row.len() - 4, start, slope);
        } else {
            for (k, &height) in row.iter().enumerate() {
                worst.note(&[height], k, start, slope);
            }
        }
    }

    /// The greatest vertical distance of the samples in a triangle of M⁻ from it. The surface between samples is no
    /// farther: finer triangles lie inside of coarser ones, and both are flat.
    #[inline(always)]
    fn error(&self, site: &Site, way: [i32; 2]) -> f32 {
        let &Site { x, y, h, diagonal } = site;
        let [dx, dy] = way.map(|step| step * h);
        let mut worst = Worst([0.0; 8]);
        if diagonal {
            let (cx, cy) = (x + dx, y + dy);
            let corner = self.at(cx, cy);
            let slope_x = (self.at(cx - 2 * dx, cy) - corner) / (2 * h) as f32;
            let slope_y = (self.at(cx, cy - 2 * dy) - corner) / (2 * h) as f32;
            for t in 0..2 * h {
                let (more, start) = (2 * h - t, corner + slope_y * t as f32);
                let row = cy - way[1] * t;
                if way[0] > 0 {
                    self.row(&mut worst, [cx - more, row], more + 1, start + slope_x * more as f32, -slope_x);
                } else {
                    self.row(&mut worst, [cx, row], more + 1, start, slope_x);
                }
            }
        } else if way[0] == 0 {
            let (a, b, apex) = (self.at(x - h, y), self.at(x + h, y), self.at(x, y + dy));
            let (middle, slope) = (0.5 * (a + b), (b - a) / (2 * h) as f32);
            let up = (apex - middle) / h as f32;
            for t in 0..h {
                let start = middle + up * t as f32 - slope * (h - t) as f32;
                self.row(&mut worst, [x - (h - t), y + way[1] * t], 2 * (h - t) + 1, start, slope);
            }
        } else {
            let (a, b, apex) = (self.at(x, y - h), self.at(x, y + h), self.at(x + dx, y));
            let (middle, slope) = (0.5 * (a + b), (b - a) / (2 * h) as f32);
            let across = (apex - middle) / h as f32;
            for t in -h..=h {
                let (more, start) = (h - t.abs(), middle + slope * t as f32);
                if way[0] > 0 {
                    self.row(&mut worst, [x, y + t], more + 1, start, across);
                } else {
                    self.row(&mut worst, [x - more, y + t], more + 1, start + across * more as f32, -across);
                }
            }
        }
        worst.0.into_iter().fold(0.0, greater)
    }
}

/// The greatest distances so far, in lanes that are looked at side by side.
struct Worst([f32; 8]);

impl Worst {
    /// Heights next to each other, from the one with number `k`, and a line.
    #[inline(always)]
    fn note<const N: usize>(&mut self, heights: &[f32; N], k: usize, start: f32, slope: f32) {
        let k = k as f32;
        for i in 0..N {
            self.0[i] = greater((heights[i] - (start + slope * (k + i as f32))).abs(), self.0[i]);
        }
    }
}

/// `f32::max` without its care for NaN, which costs more than all the rest of a row.
#[inline]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// How far directions are from an axis at most, without a root for each.
struct Spread {
    axis: Vec3,
    /// The least cosine, squared, with its sign.
    least: f32,
}

impl Spread {
    #[inline]
    fn add(&mut self, direction: Vec3) {
        let along = self.axis.dot(direction);
        self.least = self.least.min(along * along.abs() / direction.length_squared());
    }
    /// An upper bound of the angle, at most one part in twenty too large: arcsin x ≤ x + (π/2 − 1) x³.
    fn angle(&self) -> f32 {
        let cos = self.least.signum() * self.least.abs().sqrt();
        let x = ((1.0 - cos) * 0.5).max(0.0).sqrt();
        2.0 * (x + 0.570_797 * x * x * x) + 1e-3
    }
}

pub(super) fn derive(columns: Columns, progress: Progress) -> Result<RightTriangles, InvalidHeights> {
    columns.check()?;
    let Columns { columns: w, rows: r, spacing, ref heights, .. } = columns;
    let lattice = Lattice::new(w, r);
    let spacing_f32 = spacing.as_vec2();
    let field = Field { heights, columns: w as i32, rows: r as i32, spacing: spacing_f32, per_two: 0.5 / spacing_f32 };
    let missing = Missing::of(&lattice, heights);
    let base = Base::new(&lattice, &missing);
    if base.triangles.is_empty() {
        return Err(InvalidHeights::Empty);
    }
    // Where the field fills its square, what is there is a matter of borders.
    let regular = !missing.any() && lattice.columns == lattice.side + 1 && lattice.rows == lattice.side + 1;
    let sides = |spot: &Spot| {
        let site = &spot.site();
        if regular {
            if spot.is_inner() {
                return [true; 2];
            }
            site.apexes().map(|[dx, dy]| lattice.contains(site.x + dx, site.y + dy))
        } else if base.cut.contains(&[site.x, site.y]) {
            [false; 2]
        } else {
            missing.sides(site)
        }
    };

    let mut records = filled(Record::default(), lattice.len());
    let levels = lattice.levels().count();
    for (done, level) in lattice.levels().rev().enumerate() {
        progress(done as f32 / levels as f32);
        let (coarser, finer) = records.split_at_mut(level.end);
        let end = level.end as u32;
        for_chunks(&mut coarser[level.start..], CHUNK, |chunk, records| {
            let first = (level.start + chunk * CHUNK) as u32;
            let below = |id| &finer[(id - end) as usize];
            for (spot, record) in lattice.spots(first..first + records.len() as u32).zip(records) {
                let sides = sides(&spot);
                let (field, lattice, spot) = (&field, &lattice, &spot);
                *record = match (spot.turn(), spot.h()) {
                    (0, 1) => measure::<0, 1>(field, lattice, spot, sides, below),
                    (1, 1) => measure::<1, 1>(field, lattice, spot, sides, below),
                    (2, 1) => measure::<2, 1>(field, lattice, spot, sides, below),
                    (3, 1) => measure::<3, 1>(field, lattice, spot, sides, below),
                    (0, _) => measure::<0, 0>(field, lattice, spot, sides, below),
                    (1, _) => measure::<1, 0>(field, lattice, spot, sides, below),
                    (2, _) => measure::<2, 0>(field, lattice, spot, sides, below),
                    _ => measure::<3, 0>(field, lattice, spot, sides, below),
                };
            }
        });
    }
    let corner = |&[x, y]: &[i32; 2]| {
        let record = match lattice.id(x, y) {
            Some(id) => records[id as usize],
            None => Record::new(field.at(x, y), field.normal(x, y), [false; 2]),
        };
        Corner { sample: [x as u32, y as u32], record }
    };
    let corners = base.vertices.iter().map(corner).collect();

    let there = heights.iter().filter(|h| !h.is_nan());
    let (low, high) = there.clone().fold((f32::MAX, f32::MIN), |(a, b), &h| (a.min(h), b.max(h)));
    let extent = (DVec2::new((w - 1) as f64, (r - 1) as f64) * spacing).as_vec2();
    let updates = records.iter().filter(|r| r.is_update());
    let triangles = base.triangles.len() + updates.map(|r| r.sides().into_iter().filter(|&s| s).count()).sum::<usize>();
    Ok(RightTriangles {
        vertices: there.count() as u32,
        triangles: triangles as u32,
        bounds: Bounds { min: Vec2::ZERO.extend(low), max: extent.extend(high) },
        regular,
        corners,
        base: base.triangles,
        base_slots: base.at,
        records,
        lattice,
        mesh_spacing: spacing,
        spacing: spacing.as_vec2(),
        cones: record::cones(),
        steps: columns.steps,
        floor_error: columns.floor_error,
        place: columns.place,
    })
}

/// Everything about one update but its neighbours' needs: its own triangles, and what finer ones hand up. Of a turn, and of a
/// h where that is not 0, so that steps are known when it is compiled.
fn measure<'a, const TURN: usize, const H: i32>(
    field: &Field,
    lattice: &Lattice,
    spot: &Spot,
    sides: [bool; 2],
    finer: impl Fn(u32) -> &'a Record,
) -> Record {
    let mut site = spot.site();
    site.diagonal = TURN < 2;
    if H > 0 {
        site.h = H;
    }
    let Site { x, y, h, diagonal } = site;
    let height = field.at(x, y);
    if height.is_nan() {
        return Record::missing();
    }
    let record = Record::new(height, field.normal(x, y), sides);
    if !record.is_update() {
        return record;
    }
    let ways = APEXES[TURN];
    let [dx, dy] = ways[0];
    // Squared distances: one root is enough for the farthest one.
    let planar = |[dx, dy]: [i32; 2]| (Vec2::new(dx as f32, dy as f32) * field.spacing).length_squared();
    let squared = |planar: f32, there: f32| planar + (there - height) * (there - height);
    let at = |[dx, dy]: [i32; 2]| field.at(x + dx * h, y + dy * h);

    let ends = [[-dy, dx], [dy, -dx]].map(at);
    let to_end = planar([-dy * h, dx * h]);
    let mut reach = greater(squared(to_end, ends[0]), squared(to_end, ends[1]));
    // The middles of the legs of a diagonal one are for the updates there, whose errors are handed up.
    let mut error = if h == 1 { (height - 0.5 * (ends[0] + ends[1])).abs() } else { 0.0 };
    let mut spread = Spread { axis: record.normal(), least: 1.0 };
    for (way, there) in ways.into_iter().zip(sides) {
        if !there {
            continue;
        }
        let apex = at(way);
        reach = greater(reach, squared(planar(way.map(|step| step * h)), apex));
        if h > 1 {
            error = greater(error, field.error(&site, way));
        } else if !diagonal {
            // Nothing is finer than its halves: they have one leg towards the apex, one along the hypotenuse.
            let up = (height - apex) * (way[0] + way[1]) as f32;
            for (end, sign) in [(ends[0], dx - dy), (ends[1], dy - dx)] {
                let along = (height - end) * sign as f32;
                let [dip_x, dip_y] = if dx == 0 { [along, up] } else { [up, along] };
                spread.add(Vec3::new(dip_x * 2.0 * field.per_two.x, dip_y * 2.0 * field.per_two.y, 1.0));
            }
        }
    }
    if h == 1 && !diagonal {
        return record.measured(error, reach.sqrt(), spread.angle());
    }
    let (mut child_reach, mut child_radius, mut child_angle) = (0f32, 0f32, 0f32);
    let steps = Site { x: 0, y: 0, h, diagonal }.middles_doubled();
    for (step, id) in steps.into_iter().zip(lattice.middles(spot)) {
        if id == NOWHERE {
            continue;
        }
        let child = finer(id);
        if child.is_update() {
            error = greater(error, child.error());
            child_reach = greater(child_reach, squared(planar(step.map(|c| c / 2)), child.height));
            child_radius = greater(child_radius, child.radius());
            child_angle = greater(child_angle, child.half_angle().unwrap_or(PI));
            spread.add(child.direction());
        }
    }
    record.measured(error, reach.sqrt().max(child_reach.sqrt() + child_radius), spread.angle() + child_angle)
}
