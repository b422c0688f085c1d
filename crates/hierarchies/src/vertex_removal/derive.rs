//! From stored columns to a hierarchy: one replay of all insertions checks them and yields what is not stored.

use super::columns::{Columns, Patch};
use super::front_mesh::FrontMesh;
use super::polygon::{MOST_CORNERS, Triangles, Triangulation, turned_numbers};
use super::{CellCorner, Insertion, Node, VertexRemoval};
use crate::columns::{InvalidColumns, check_base, check_lengths, check_update};
use crate::footprint::{Cells, Frame, PackedFootprint};
use crate::lists::UpdateLists;
use crate::live::Most;
use crate::model::{Progress, replayed};
use crate::next::Next;
use crate::quantize::{Oct, Places};
use arrayvec::ArrayVec;
use glam::Vec3;
use meshfront_mesh::{Bounds, TriangleMesh, VertexId};
use meshfront_refine::{MultiTessellation, UpdateId};
use std::collections::HashMap;

/// Cell numbers go with two bits more into 32.
const MOST_CELLS: usize = 1 << 30;

pub(super) fn derive(columns: Columns, progress: Progress) -> Result<VertexRemoval, InvalidColumns> {
    check_shape(&columns)?;
    let updates = columns.patches.len();
    let mut twins = Twins::of(&columns.base)?;
    let patches = columns.patches.clone();
    let mut h = undecorated(columns);
    let mut front = FrontMesh::base(&h);
    let mut cells = Vec::with_capacity(updates);
    let mut needs = UpdateLists::with_capacity(updates);
    let mut direct = vec![];
    for m in 0..updates {
        replayed(progress, m, updates);
        let id = UpdateId(m as u32);
        let invalid = |reason| InvalidColumns::Update { update: m as u32, reason };
        let place = Place::find(&front, &twins, &patches[m]).map_err(invalid)?;
        h.minus.extend(
            place
                .slots
                .iter()
                .zip(&place.firsts)
                .map(|(&slot, &first)| CellCorner::new(twins.triangles[slot as usize].cell, first)),
        );

        direct.clear();
        direct.extend(h.minus_of(id).iter().filter_map(|&cell| h.maker(cell)));
        direct.sort_unstable();
        direct.dedup();
        if direct.iter().any(|&n| h.error(n) < h.error(id)) {
            return Err(invalid("its error is larger than that of an update that it needs"));
        }
        needs.push_reduced(&direct);
        let level = direct.iter().map(|n| h.insertions[n.ix()].level).max().unwrap_or(0);
        h.insertions[m].level = level.saturating_add(1);

        let v = h.place(id);
        let points = &front.buffers.positions;
        let at = |corner: usize| points[place.ring[corner] as usize];
        let corners = place.ring.len();
        let minus = place.triangles.iter().map(|t| t.map(|c| at(c as usize)));
        let plus = (0..h.insertions[m].fan()).map(|j| [v, at(j), at((j + 1) % corners)]);
        h.costs[m] = step_cost(v, minus.clone(), h.error(id));
        cells.push(Cells::of(minus.chain(plus)));
        front.buffers.clear_changes();
        front.refine(&h, id);
        twins.insert(&h, id, &front, &place);
    }
    h.most = Most { vertices: front.buffers.live_vertices(), triangles: front.buffers.live_triangles() };
    let children = needs.reversed();
    h.roots = (0..updates as u32).map(UpdateId).filter(|m| needs.of(m.ix()).is_empty()).collect();
    for (node, &first) in h.nodes.iter_mut().zip(&children.offsets) {
        node.children = first;
    }
    h.children = children.items;
    if !h.source_normals {
        derive_normals(&mut h, &front);
    }
    for m in (0..updates).rev() {
        let children = h.children_of(UpdateId(m as u32)).iter().map(|&c| h.footprint(c));
        h.nodes[m].footprint = h.frame.nest(h.nodes[m].footprint.error, &cells[m], children);
        h.costs[m] = h.children_of(UpdateId(m as u32)).iter().map(|c| h.costs[c.ix()]).fold(h.costs[m], f32::max);
    }
    Ok(h)
}

/// The update's own share of [`TriangleModel::cost`](crate::TriangleModel::cost): squared distance of v from the cells of M⁻, times their area. Where an
/// edge of v crosses M⁻ the distance may be greater, which shows in the error; it counts a tenth, so little does it say of
/// the mean.
fn step_cost(v: Vec3, coarse: impl Iterator<Item = [Vec3; 3]>, error: f32) -> f32 {
    let (mut squared, mut area) = (f32::INFINITY, 0.0);
    for [a, b, c] in coarse {
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        let sides = [[a, b], [b, c], [c, a]];
        if length > 0.0 && sides.iter().all(|&[a, b]| (b - a).cross(v - a).dot(normal) >= 0.0) {
            squared = squared.min((normal.dot(v - a) / length).powi(2));
        }
        for [a, b] in sides {
            let along = ((v - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            squared = squared.min(v.distance_squared(a + (b - a) * along));
        }
        area += length;
    }
    squared.max(0.1 * error * error) * area
}

/// Lengths, ranges and finite numbers: all that needs no replay.
pub(super) fn check_shape(c: &Columns) -> Result<(), InvalidColumns> {
    let updates = c.patches.len();
    let base = &c.base;
    check_lengths(&[
        ("positions", c.positions.len(), updates, false),
        ("errors", c.errors.len(), updates, false),
        ("normals", c.normals.len(), updates, base.vertex.normals.is_empty()),
        ("colors", c.colors.len(), updates, base.vertex.colors.is_empty()),
        ("base normals", base.vertex.normals.len(), base.positions.len(), c.normals.is_empty()),
        ("base colors", base.vertex.colors.len(), base.positions.len(), c.colors.is_empty()),
    ])?;
    let cells = base.triangles.len().saturating_add(updates.saturating_add(1).saturating_mul(Columns::CELLS as usize));
    if cells >= MOST_CELLS || base.positions.len() >= MOST_CELLS {
        return Err(InvalidColumns::TooMany(updates.max(base.positions.len()).max(base.triangles.len())));
    }
    check_base(base, c.grid, c.floor_error)?;
    for m in 0..updates {
        let invalid = |reason| Err(InvalidColumns::Update { update: m as u32, reason });
        check_update(m, &c.positions[m..=m], c.errors[m], c.grid)?;
        if !c.patches[m].triangulation.is_valid() {
            return invalid("its polygon has no such triangulation");
        }
        let Patch { triangulation: Triangulation { corners, index }, boundary, .. } = c.patches[m];
        if !boundary && turned_numbers(corners as usize).binary_search(&index).is_err() {
            return invalid("another reference edge gives its triangulation a lesser number");
        }
        if c.patches[m].edge > 2 {
            return invalid("its reference edge is none of a triangle");
        }
    }
    Ok(())
}

/// The hierarchy with the stored columns only.
fn undecorated(c: Columns) -> VertexRemoval {
    let updates = c.patches.len();
    let points = c.base.positions.iter().chain(&c.positions);
    let bounds = Bounds::over(points.copied());
    let frame = Frame::new(bounds.unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO }));
    let source_normals = !c.base.vertex.normals.is_empty() || !c.normals.is_empty();
    let places = Places::on(c.grid);
    let mut minus = 0;
    let mut nodes: Vec<Node> = Vec::with_capacity(updates + 1);
    for (patch, &error) in c.patches.iter().zip(&c.errors) {
        nodes.push(Node { footprint: PackedFootprint::of_error(error), minus, children: 0 });
        minus += patch.triangulation.corners as u32 - 2;
    }
    nodes.push(Node { footprint: PackedFootprint::of_error(0.0), minus, children: 0 });
    VertexRemoval {
        base_normals: if source_normals {
            c.base.vertex.normals.iter().map(|&n| Oct::encode(n)).collect()
        } else {
            vec![Oct::default(); c.base.positions.len()]
        },
        base: c.base,
        insertions: (0..updates)
            .map(|m| {
                let normal = c.normals.get(m).copied().unwrap_or_default();
                let Patch { triangulation, boundary, .. } = c.patches[m];
                Insertion { normal, place: places.split(c.positions[m]).0, triangulation, boundary, level: 0 }
            })
            .collect(),
        minus: Vec::with_capacity(minus as usize),
        fine_places: match places {
            Places::Grid16(_) => vec![],
            Places::Points => c.positions.iter().map(|&p| places.split(p).1).collect(),
        },
        places,
        grid: c.grid,
        connectivity: c.connectivity,
        source_normals,
        colors: c.colors,
        costs: vec![0.0; updates],
        nodes,
        frame,
        children: vec![],
        roots: vec![],
        floor_error: c.floor_error,
        source: c.source,
        most: Most { vertices: usize::MAX, triangles: usize::MAX },
        next: Next::default(),
    }
}

/// Half of an edge: `4 * triangle slot + the corner that it begins at`.
type Half = u32;
/// Beyond a boundary edge.
const NONE: Half = u32::MAX;

/// What lies across each edge of the live mesh: only a replay needs it.
struct Twins {
    triangles: Vec<Linked>,
}

/// A live triangle.
#[derive(Clone, Copy)]
struct Linked {
    cell: u32,
    /// Per edge, from corner k to the next one: the half that runs the other way.
    twins: [Half; 3],
}

impl Twins {
    fn of(base: &TriangleMesh) -> Result<Twins, InvalidColumns> {
        let mut halves = HashMap::with_capacity(3 * base.triangles.len());
        for (t, corners) in base.triangles.iter().enumerate() {
            for k in 0..3 {
                if halves.insert([corners[k], corners[(k + 1) % 3]], 4 * t as u32 + k as u32).is_some() {
                    return Err(InvalidColumns::Base(
                        "an edge has three triangles, or two that are turned against each other",
                    ));
                }
            }
        }
        let twin = |a, b| halves.get(&[b, a]).copied().unwrap_or(NONE);
        let link = |(t, &[a, b, c]): (usize, &[VertexId; 3])| Linked {
            cell: t as u32,
            twins: [twin(a, b), twin(b, c), twin(c, a)],
        };
        Ok(Twins { triangles: base.triangles.iter().enumerate().map(link).collect() })
    }

    fn twin(&self, half: Half) -> Half {
        self.triangles[half as usize >> 2].twins[half as usize & 3]
    }
    fn tie(&mut self, half: Half, twin: Half) {
        if half != NONE {
            self.triangles[half as usize >> 2].twins[half as usize & 3] = twin;
        }
    }

    /// Follows an insertion that has been applied.
    fn insert(&mut self, h: &VertexRemoval, m: UpdateId, front: &FrontMesh, place: &Place) {
        let fan = h.insertions[m.ix()].fan();
        let first = h.first_cell(m);
        let slot = |j: usize| front.slot(first + j as u32).expect("its fan is live");
        let closed = !h.insertions[m.ix()].boundary;
        for j in 0..fan {
            let before = if j > 0 {
                slot(j - 1) << 2 | 2
            } else if closed {
                slot(fan - 1) << 2 | 2
            } else {
                NONE
            };
            let after = if j + 1 < fan {
                slot(j + 1) << 2
            } else if closed {
                slot(0) << 2
            } else {
                NONE
            };
            let linked = Linked { cell: first + j as u32, twins: [before, place.outer[j], after] };
            crate::live::put(&mut self.triangles, slot(j), linked, usize::MAX);
            self.tie(place.outer[j], slot(j) << 2 | 1);
        }
    }
}

/// Where an update's polygon is in the live mesh.
struct Place {
    triangles: Triangles,
    /// Per triangle of M⁻: its slot, and which of its corners is its first in the triangulation.
    slots: ArrayVec<u32, MOST_CORNERS>,
    firsts: ArrayVec<u32, MOST_CORNERS>,
    /// Per corner: its vertex slot, and what lies across the edge from it to the next.
    ring: ArrayVec<u32, MOST_CORNERS>,
    outer: [Half; MOST_CORNERS],
}

impl Place {
    /// Walks from the reference edge through the triangles that are there, as the triangulation says.
    fn find(front: &FrontMesh, twins: &Twins, patch: &Patch) -> Result<Place, &'static str> {
        let corners = patch.triangulation.corners as usize;
        let root = front.slot(patch.cell).ok_or("the cell on its reference edge is not live")?;
        let mut place = Place {
            triangles: patch.triangulation.triangles(),
            slots: ArrayVec::new(),
            firsts: ArrayVec::new(),
            ring: std::iter::repeat_n(0, corners).collect(),
            outer: [NONE; MOST_CORNERS],
        };
        let reference = root << 2 | patch.edge as u32;
        place.outer[corners - 1] = twins.twin(reference);
        // Halves from a triangle's last corner to its first; the left part is on top.
        let mut halves = ArrayVec::<Half, MOST_CORNERS>::new();
        halves.push(reference);
        for &[i, a, j] in &place.triangles {
            let half = halves.pop().expect("a triangulation hangs together");
            if half == NONE {
                return Err("its polygon reaches beyond a boundary");
            }
            let (slot, first) = (half >> 2, ((half & 3) + 1) % 3);
            let triangle = front.buffers.triangles[slot as usize];
            for (k, corner) in [i, a, j].into_iter().enumerate() {
                place.ring[corner as usize] = triangle[(first as usize + k) % 3];
            }
            for (from, to, edge) in [(a, j, (first + 1) % 3), (i, a, first)] {
                let across = twins.twin(slot << 2 | edge);
                if to - from == 1 {
                    place.outer[from as usize] = across;
                } else {
                    halves.push(across);
                }
            }
            place.slots.push(slot);
            place.firsts.push(first);
        }
        if (1..corners).any(|c| place.ring[..c].contains(&place.ring[c])) {
            return Err("its polygon meets a vertex twice");
        }
        if patch.boundary && place.outer[corners - 1] != NONE {
            return Err("its vertex lies on a boundary, its reference edge does not");
        }
        Ok(place)
    }
}

/// Vertex normals where the source had none: the area-weighted mean normal of the full-resolution surface around each
/// vertex.
fn derive_normals(h: &mut VertexRemoval, full: &FrontMesh) {
    let base = h.base.positions.len();
    let mut sums = vec![Vec3::ZERO; base + h.insertions.len()];
    let points = &full.buffers.positions;
    for (t, ids) in full.buffers.triangles.iter().filter(|t| t[0] != t[1]).zip(full.corners()) {
        let [a, b, c] = t.map(|slot| points[slot as usize]);
        let normal = (b - a).cross(c - a);
        for id in ids {
            sums[id.ix()] += normal;
        }
    }
    h.base_normals = sums[..base].iter().map(|&n| Oct::encode(n)).collect();
    for (insertion, &n) in h.insertions.iter_mut().zip(&sums[base..]) {
        insertion.normal = Oct::encode(n);
    }
}
