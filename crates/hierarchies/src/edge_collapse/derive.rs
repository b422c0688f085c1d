//! From stored columns to a hierarchy: one replay of all splits checks them and yields what is not stored.

use super::columns::Columns;
use super::front_mesh::{Added, AddedList, FrontMesh, MAX_ADDED, Star, StarCorner, gap_triangle, gaps};
use super::{EdgeCollapse, Node, Split};
use crate::columns::{InvalidColumns, check_base, check_lengths, check_update};
use crate::counts::Needed;
use crate::footprint::{Cells, Frame, PackedFootprint, step_cost};
use crate::lists::UpdateLists;
use crate::live::Most;
use crate::model::{Progress, replayed};
use crate::next::Next;
use crate::quantize::{Oct, Places};
use glam::Vec3;
use meshfront_mesh::Bounds;
use meshfront_refine::{MultiTessellation, UpdateId};

/// Ids must leave room for triangle numbers and for corners, which are four times a slot.
const MAX_UPDATES: usize = 1 << 28;

pub(super) fn derive(columns: Columns, progress: Progress) -> Result<EdgeCollapse, InvalidColumns> {
    check_shape(&columns)?;
    let updates = columns.vertex.len();
    let mut h = undecorated(columns)?;
    let mut front = FrontMesh::base(&h);
    let mut cells = Vec::with_capacity(updates);
    let mut needs = UpdateLists::with_capacity(updates);
    let mut ring = vec![];
    for m in 0..updates {
        replayed(progress, m, updates);
        let invalid = |reason| InvalidColumns::Update { update: m as u32, reason };
        let id = UpdateId(m as u32);
        let split = h.splits[m];
        let slot = front.slot(split.vertex).ok_or(invalid("splits a vertex that is not live"))?;
        let star = front.star(slot).ok_or(invalid("its star has too many triangles"))?;
        let (added, gaps) = check_split(&h, id, &star).map_err(invalid)?;

        // The direct needs are the makers of s and of its ring.
        ring.clear();
        ring.extend(h.maker(split.vertex));
        for t in &star {
            ring.extend(h.maker(front.id(t.after)));
            ring.extend(h.maker(front.id(t.before)));
        }
        ring.sort_unstable();
        ring.dedup();
        if ring.iter().any(|&n| h.error(n) < h.error(id)) {
            return Err(invalid("its error is larger than that of an update that it needs"));
        }
        needs.push_reduced(&ring);

        h.splits[m].level = front.buffers.levels[slot as usize];
        h.splits[m].added = added.len() as u8;
        h.splits[m].gaps = gaps;
        let points = &front.buffers.positions;
        let children = h.places(id);
        let fine = |(i, t): (usize, &StarCorner)| {
            [children[(split.sides >> i & 1) as usize], points[t.after as usize], points[t.before as usize]]
        };
        let gone = |a: &Added| [children[0], points[a.w as usize], children[1]];
        let fine = star.iter().enumerate().map(fine).chain(added.iter().map(gone));
        h.costs[m] = step_cost(points[slot as usize], fine);
        cells.push(cells_of(&h, id, points, slot, &star, &added));
        front.buffers.clear_changes();
        front.refine(&h, id, |_| ());
    }
    h.most = Most { vertices: front.buffers.live_vertices(), triangles: front.buffers.live_triangles() };
    let children = needs.reversed();
    h.roots = (0..updates as u32).map(UpdateId).filter(|m| needs.of(m.ix()).is_empty()).collect();
    h.needed = Needed::of(&needs);
    h.neighbours.reserve_exact(needs.items.len() + children.items.len());
    for m in 0..updates {
        let needs = needs.of(m);
        (h.nodes[m].first, h.nodes[m].needs) = (h.neighbours.len() as u32, needs.len() as u8);
        h.neighbours.extend_from_slice(needs);
        h.neighbours.extend_from_slice(children.of(m));
    }
    h.nodes[updates].first = h.neighbours.len() as u32;
    drop((needs, children));
    if !h.source_normals {
        derive_normals(&mut h, &front);
    }
    for m in (0..updates).rev() {
        let children = h.neighbours_of(UpdateId(m as u32)).1.iter().map(|&c| h.footprint(c));
        h.nodes[m].footprint = h.frame.nest(h.nodes[m].footprint.error, &cells[m], children);
    }
    for m in (0..updates).rev() {
        h.costs[m] = h.neighbours_of(UpdateId(m as u32)).1.iter().map(|c| h.costs[c.ix()]).fold(h.costs[m], f32::max);
    }
    Ok(h)
}

/// Lengths, ranges and finite numbers: all that needs no replay.
fn check_shape(c: &Columns) -> Result<(), InvalidColumns> {
    let updates = c.vertex.len();
    let base = &c.base;
    check_lengths(&[
        ("sides", c.sides.len(), updates, false),
        ("positions", c.positions.len(), updates, false),
        ("errors", c.errors.len(), updates, false),
        ("normals", c.normals.len(), updates, base.vertex.normals.is_empty()),
        ("colors", c.colors.len(), updates, base.vertex.colors.is_empty()),
        ("base normals", base.vertex.normals.len(), base.positions.len(), c.normals.is_empty()),
        ("base colors", base.vertex.colors.len(), base.positions.len(), c.colors.is_empty()),
    ])?;
    if updates > MAX_UPDATES || base.positions.len() > MAX_UPDATES || base.triangles.len() > MAX_UPDATES {
        return Err(InvalidColumns::TooMany(updates.max(base.positions.len()).max(base.triangles.len())));
    }
    check_base(base, c.grid, c.floor_error)?;
    let invalid = |update: usize, reason| Err(InvalidColumns::Update { update: update as u32, reason });
    for m in 0..updates {
        check_update(m, &c.positions[m], c.errors[m], c.grid)?;
    }
    for pair in c.explicit.windows(2) {
        if pair[0].update >= pair[1].update {
            return invalid(pair[1].update.ix(), "explicit splits are not in ascending order");
        }
    }
    if let Some(e) = c.explicit.iter().find(|e| c.sides.get(e.update.ix()).is_none_or(|s| s & Columns::EXPLICIT == 0)) {
        return invalid(e.update.ix(), "an explicit split that its sides do not announce");
    }
    if c.sides.iter().filter(|&&s| s & Columns::EXPLICIT != 0).count() != c.explicit.len() {
        return Err(InvalidColumns::Length {
            column: "explicit",
            found: c.explicit.len(),
            expected: c.sides.iter().filter(|&&s| s & Columns::EXPLICIT != 0).count(),
        });
    }
    Ok(())
}

/// The hierarchy with the stored columns only.
fn undecorated(c: Columns) -> Result<EdgeCollapse, InvalidColumns> {
    let updates = c.vertex.len();
    let mut extra = (c.base.triangles.len() + 2 * updates) as u64;
    let mut explicit_extra = vec![];
    for e in &c.explicit {
        explicit_extra.push(extra as u32);
        extra += e.added.len().saturating_sub(2) as u64;
    }
    if extra > u32::MAX as u64 / 4 {
        return Err(InvalidColumns::TooMany(extra as usize));
    }
    let points = c.base.positions.iter().chain(c.positions.iter().flatten());
    let bounds = Bounds::over(points.copied());
    let frame = Frame::new(bounds.unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO }));
    let source_normals = !c.base.vertex.normals.is_empty();
    let places = Places::on(c.grid);
    Ok(EdgeCollapse {
        base_normals: if source_normals {
            c.base.vertex.normals.iter().map(|&n| Oct::encode(n)).collect()
        } else {
            vec![Oct::default(); c.base.positions.len()]
        },
        base: c.base,
        splits: (0..updates)
            .map(|m| {
                let normals = c.normals.get(m).copied().unwrap_or_default();
                let place = c.positions[m].map(|p| places.split(p).0);
                Split { vertex: c.vertex[m], sides: c.sides[m], normals, place, level: 0, added: 0, gaps: [0; 2] }
            })
            .collect(),
        explicit: c.explicit,
        explicit_extra,
        fine_places: match places {
            Places::Grid16(_) => vec![],
            Places::Points => c.positions.iter().map(|pair| pair.map(|p| places.split(p).1)).collect(),
        },
        places,
        grid: c.grid,
        source_normals,
        colors: c.colors,
        costs: vec![0.0; updates],
        nodes: c
            .errors
            .iter()
            .chain(&[0.0])
            .map(|&error| Node { footprint: PackedFootprint::of_error(error), first: 0, needs: 0 })
            .collect(),
        frame,
        neighbours: vec![],
        needed: Needed::default(),
        roots: vec![],
        floor_error: c.floor_error,
        source: c.source,
        // Known when all are applied.
        most: Most { vertices: usize::MAX, triangles: usize::MAX },
        next: Next::default(),
    })
}

/// Whether a split can be applied to the star that it finds; what it adds, and which gaps that closes.
fn check_split(h: &EdgeCollapse, m: UpdateId, star: &Star) -> Result<(AddedList, [u8; 2]), &'static str> {
    let sides = h.splits[m.ix()].sides;
    if star.is_empty() {
        return Err("splits a vertex without triangles");
    }
    let used = sides & !Columns::EXPLICIT;
    if (used as u64) >> star.len() != 0 {
        return Err("its sides speak of more triangles than the star has");
    }
    let mut closed = [0; 2];
    let added: AddedList = match h.explicit_index(m) {
        None => {
            let gaps = gaps(star, used).ok_or("its sides leave more than two gaps")?;
            closed[..gaps.len()].copy_from_slice(&gaps);
            gaps.iter().map(|&g| gap_triangle(star, used, g)).collect()
        }
        Some(e) => {
            let list = &h.explicit[e].added;
            if list.len() > MAX_ADDED {
                return Err("it adds too many triangles");
            }
            if list.iter().any(|a| a.star as usize >= star.len()) {
                return Err("an added triangle names a triangle that the star does not have");
            }
            list.iter().map(|a| a.of(star)).collect()
        }
    };
    let on_v = used.count_ones() as usize;
    if added.is_empty() && (on_v == 0 || on_v == star.len()) {
        return Err("a child would have no triangles");
    }
    Ok((added, closed))
}

/// All cells of an update, M⁻ and M⁺.
fn cells_of(h: &EdgeCollapse, m: UpdateId, points: &[Vec3], slot: u32, star: &Star, added: &AddedList) -> Cells {
    let s = points[slot as usize];
    let [u, v] = h.places(m);
    let sides = h.splits[m.ix()].sides;
    let stay = star.iter().enumerate().flat_map(|(i, t)| {
        let (a, b) = (points[t.after as usize], points[t.before as usize]);
        [[s, a, b], [if sides >> i & 1 == 1 { v } else { u }, a, b]]
    });
    let gone = added.iter().map(|a| {
        let w = points[a.w as usize];
        if a.flipped { [v, w, u] } else { [u, w, v] }
    });
    Cells::of(stay.chain(gone))
}

/// Vertex normals where the source had none: each vertex, of any level, gets the area-weighted mean normal of the
/// full-resolution surface below it.
fn derive_normals(h: &mut EdgeCollapse, full: &FrontMesh) {
    let mut sums = vec![Vec3::ZERO; h.base.positions.len() + 2 * h.splits.len()];
    let points = &full.buffers.positions;
    for (t, (_, ids)) in full.buffers.triangles.iter().filter(|t| t[0] != t[1]).zip(full.numbered_triangles()) {
        let [a, b, c] = t.map(|slot| points[slot as usize]);
        let normal = (b - a).cross(c - a);
        for id in ids {
            sums[id.ix()] += normal;
        }
    }
    for m in (0..h.splits.len()).rev() {
        let [u, v] = [0, 1].map(|k| h.child(UpdateId(m as u32), k));
        sums[h.splits[m].vertex.ix()] = sums[u.ix()] + sums[v.ix()];
        h.splits[m].normals = [Oct::encode(sums[u.ix()]), Oct::encode(sums[v.ix()])];
    }
    h.base_normals = sums[..h.base.positions.len()].iter().map(|&n| Oct::encode(n)).collect();
}
