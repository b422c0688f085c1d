//! Errors, spheres and cones of all updates from the heights alone, fine to coarse.

use super::base::{Base, Missing};
use super::lattice::{APEXES, Lattice, NOWHERE, Site, Spot};
use super::record::{self, Record};
use super::{Columns, Corner, InvalidHeights, RightTriangles};
use crate::model::Progress;
use crate::parallel::for_chunks;
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
            let across = (self.at(x + 1, y) - self.at(x - 1, y)) / (2.0 * self.spacing.x);
            let up = (self.at(x, y + 1) - self.at(x, y - 1)) / (2.0 * self.spacing.y);
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

    /// The greatest vertical distance of samples of a row, from column `x`, from a line that starts at `start` there.
    #[inline]
    fn row(&self, y: i32, x: i32, count: i32, start: f32, slope: f32) -> f32 {
        let first = (y * self.columns + x) as usize;
        let row = &self.heights[first..first + count as usize];
        let away = |k: usize, h: f32| (h - (start + slope * k as f32)).abs();
        let (groups, rest) = row.as_chunks::<8>();
        let mut worst = rest.iter().enumerate().fold(0.0, |w, (k, &h)| greater(w, away(8 * groups.len() + k, h)));
        if !groups.is_empty() {
            let mut lanes = [0f32; 8];
            for (g, group) in groups.iter().enumerate() {
                for k in 0..8 {
                    lanes[k] = greater(lanes[k], away(8 * g + k, group[k]));
                }
            }
            worst = lanes.into_iter().fold(worst, greater);
        }
        worst
    }

    /// The greatest vertical distance of the samples in a triangle of M⁻ from it. The surface between samples is no
    /// farther: finer triangles lie inside of coarser ones, and both are flat.
    #[inline(always)]
    fn error(&self, site: &Site, way: [i32; 2]) -> f32 {
        let &Site { x, y, h, diagonal } = site;
        let [dx, dy] = way.map(|step| step * h);
        if h == 1 {
            // The middles of the legs of a diagonal one are for the updates there, whose errors are handed up.
            return (self.at(x, y) - 0.5 * (self.at(x - dy, y + dx) + self.at(x + dy, y - dx))).abs();
        }
        if diagonal {
            let (cx, cy) = (x + dx, y + dy);
            let corner = self.at(cx, cy);
            let slope_x = (self.at(cx - 2 * dx, cy) - corner) / (2 * h) as f32;
            let slope_y = (self.at(cx, cy - 2 * dy) - corner) / (2 * h) as f32;
            let mut worst = 0f32;
            for t in 0..2 * h {
                let (count, start) = (2 * h - t + 1, corner + slope_y * t as f32);
                let row = cy - way[1] * t;
                let error = if way[0] > 0 {
                    self.row(row, cx - (count - 1), count, start + slope_x * (count - 1) as f32, -slope_x)
                } else {
                    self.row(row, cx, count, start, slope_x)
                };
                worst = greater(worst, error);
            }
            worst
        } else if way[0] == 0 {
            let (a, b, apex) = (self.at(x - h, y), self.at(x + h, y), self.at(x, y + dy));
            let (middle, slope) = (0.5 * (a + b), (b - a) / (2 * h) as f32);
            let up = (apex - middle) / h as f32;
            let row = |t: i32| {
                let start = middle + up * t as f32 - slope * (h - t) as f32;
                self.row(y + way[1] * t, x - (h - t), 2 * (h - t) + 1, start, slope)
            };
            (0..h).map(row).fold(0.0, greater)
        } else {
            let (a, b, apex) = (self.at(x, y - h), self.at(x, y + h), self.at(x + dx, y));
            let (middle, slope) = (0.5 * (a + b), (b - a) / (2 * h) as f32);
            let across = (apex - middle) / h as f32;
            let row = |t: i32| {
                let (count, start) = (h - t.abs() + 1, middle + slope * t as f32);
                if way[0] > 0 {
                    self.row(y + t, x, count, start, across)
                } else {
                    self.row(y + t, x - (count - 1), count, start + across * (count - 1) as f32, -across)
                }
            };
            (-h..=h).map(row).fold(0.0, greater)
        }
    }

    /// Normals of the finest triangles around a sample, of any length, on the sides that are there.
    #[inline(always)]
    fn finest_normals(&self, [x, y]: [i32; 2], ways: [[i32; 2]; 2], sides: [bool; 2], mut visit: impl FnMut(Vec3)) {
        let here = self.at(x, y);
        for ([dx, dy], there) in ways.into_iter().zip(sides) {
            if !there {
                continue;
            }
            let slope = |[dx, dy]: [i32; 2]| (self.at(x + dx, y + dy) - here) * (dx + dy) as f32;
            let to_apex = slope([dx, dy]);
            // Each half has one leg towards the apex, one along the hypotenuse.
            for leg in [[dy, dx], [-dy, -dx]] {
                let (sx, sy) = if dx != 0 { (to_apex, slope(leg)) } else { (slope(leg), to_apex) };
                visit(Vec3::new(-sx / self.spacing.x, -sy / self.spacing.y, 1.0));
            }
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
    let field = Field { heights, columns: w as i32, rows: r as i32, spacing: spacing.as_vec2() };
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

    let mut records = vec![Record::default(); lattice.len()];
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
                *record = match spot.turn() {
                    0 => measure::<0>(&field, &lattice, &spot, sides, below),
                    1 => measure::<1>(&field, &lattice, &spot, sides, below),
                    2 => measure::<2>(&field, &lattice, &spot, sides, below),
                    _ => measure::<3>(&field, &lattice, &spot, sides, below),
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

/// Everything about one update but its neighbours' needs: its own triangles, and what finer ones hand up. Of a turn, so that
/// steps are known when it is compiled.
fn measure<'a, const TURN: usize>(
    field: &Field,
    lattice: &Lattice,
    spot: &Spot,
    sides: [bool; 2],
    finer: impl Fn(u32) -> &'a Record,
) -> Record {
    let site = &Site { diagonal: TURN < 2, ..spot.site() };
    let &Site { x, y, h, .. } = site;
    let height = field.at(x, y);
    if height.is_nan() {
        return Record::missing();
    }
    let record = Record::new(height, field.normal(x, y), sides);
    if !record.is_update() {
        return record;
    }
    let axis = record.normal();
    // Squared distance of a sample: one root is enough for the farthest one.
    let squared = |dx: i32, dy: i32, there: f32| {
        (Vec2::new(dx as f32, dy as f32) * field.spacing).extend(there - height).length_squared()
    };
    let (mut error, mut reach) = (0f32, 0f32);
    for (way, there) in APEXES[TURN].into_iter().zip(sides) {
        if !there {
            continue;
        }
        let [dx, dy] = way.map(|step| step * h);
        error = greater(error, field.error(site, way));
        for [dx, dy] in [[dx, dy], [dy, -dx], [-dy, dx]] {
            reach = greater(reach, squared(dx, dy, field.at(x + dx, y + dy)));
        }
    }
    let mut spread = Spread { axis, least: 1.0 };
    if h == 1 && !site.diagonal {
        field.finest_normals([x, y], APEXES[TURN], sides, |normal| spread.add(normal));
        return record.measured(error, reach.sqrt(), spread.angle());
    }
    let (mut child_reach, mut child_radius, mut child_angle) = (0f32, 0f32, 0f32);
    for ([dx, dy], id) in site.middles_doubled().into_iter().zip(lattice.middles(spot)) {
        if id == NOWHERE {
            continue;
        }
        let child = finer(id);
        let (dx, dy) = (dx / 2, dy / 2);
        if child.is_update() {
            error = greater(error, child.error());
            child_reach = greater(child_reach, squared(dx, dy, child.height));
            child_radius = greater(child_radius, child.radius());
            child_angle = greater(child_angle, child.half_angle().unwrap_or(PI));
            spread.add(child.direction());
        }
    }
    record.measured(error, reach.sqrt().max(child_reach.sqrt() + child_radius), spread.angle() + child_angle)
}
