//! Vertices that are the same become one; what draws nothing goes.

use std::fmt;
use std::hash::BuildHasher;

use glam::Vec3;
use hashbrown::{DefaultHashBuilder, HashTable};

use crate::{TriangleMesh, VertexId};

/// What [`clean`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CleanReport {
    /// Vertices that were exact duplicates of an earlier one.
    pub vertices_welded: u64,
    /// Vertices that no triangle used, after the triangles below were dropped.
    pub vertices_unreferenced: u64,
    /// Triangles with two corners at the same place.
    pub triangles_degenerate: u64,
    /// Triangles with the same corners in the same turn as an earlier one.
    pub triangles_duplicate: u64,
}

impl CleanReport {
    /// Whether nothing was changed.
    pub fn is_nothing(&self) -> bool {
        *self == CleanReport::default()
    }
}

impl fmt::Display for CleanReport {
    /// `welded 98 duplicate vertices, dropped 3 degenerate triangles`, or `nothing to clean`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            ("welded", self.vertices_welded, "duplicate vert", "ex", "ices"),
            ("dropped", self.vertices_unreferenced, "unreferenced vert", "ex", "ices"),
            ("dropped", self.triangles_degenerate, "degenerate triangle", "", "s"),
            ("dropped", self.triangles_duplicate, "duplicate triangle", "", "s"),
        ];
        let mut verb_before = "";
        for (verb, count, noun, one, many) in parts {
            if count > 0 {
                let comma = if verb_before.is_empty() { "" } else { ", " };
                let verb = if verb == verb_before { String::new() } else { format!("{verb} ") };
                let ending = if count == 1 { one } else { many };
                write!(f, "{comma}{verb}{} {noun}{ending}", super::Thousands(count))?;
                verb_before = parts.iter().find(|p| p.2 == noun).map_or("", |p| p.0);
            }
        }
        if verb_before.is_empty() { f.write_str("nothing to clean") } else { Ok(()) }
    }
}

/// Welds exact duplicates, drops degenerate and duplicate triangles, then vertices that no triangle uses.
///
/// * Two vertices are the same when their positions and all their attributes are equal (0.0 equals -0.0; nothing else
///   is rounded). So an attribute seam, two normals or colours at one place, stays a seam.
/// * A triangle is degenerate when two of its corners have the same position. Slivers of no area over three different
///   points stay: they hold their neighbours together.
/// * Triangles are duplicates when they have the same corners in the same cyclic order. The two sides of a two-sided
///   sheet are not.
///
/// What stays keeps its order, and of duplicates the first stays, so a clean mesh is unchanged. Ids must be in range.
/// Takes linear time and about 16 bytes of scratch per vertex and 12 per triangle.
pub fn clean(mesh: &mut TriangleMesh) -> CleanReport {
    let mut report = CleanReport::default();
    weld(mesh, &mut report);
    drop_degenerate(mesh, &mut report);
    drop_duplicates(mesh, &mut report);
    drop_unreferenced(mesh, &mut report);
    report
}

/// Joins vertices at the same position whatever their attributes, then cleans. Returns how many were
/// joined, and what cleaning did besides.
///
/// Closes the surface of a mesh that shows hard edges by normals (or colours) of its own on either side: the joined
/// vertex gets the mean normal and the mean colour of its vertices, so such edges are shaded smoothly from then on.
pub fn weld_seams(mesh: &mut TriangleMesh) -> (u64, CleanReport) {
    let TriangleMesh { positions, triangles, vertex } = mesh;
    let first_equal = first_equals(positions.len(), positions, |i, j| positions[i as usize] == positions[j as usize]);
    let joined = first_equal.iter().enumerate().filter(|&(i, &first)| i != first as usize).count() as u64;
    let mut sums = vec![(Vec3::ZERO, [0u32; 4], 0u32); positions.len()];
    for (i, &first) in first_equal.iter().enumerate() {
        let (normal, color, count) = &mut sums[first as usize];
        *normal += vertex.normals.get(i).copied().unwrap_or(Vec3::ZERO);
        let rgba = vertex.colors.get(i).copied().unwrap_or([0; 4]);
        (0..4).for_each(|c| color[c] += u32::from(rgba[c]));
        *count += 1;
    }
    for (i, &(normal, color, count)) in sums.iter().enumerate().filter(|(_, s)| s.2 > 1) {
        if let Some(slot) = vertex.normals.get_mut(i) {
            // Opposite normals cancel: then the first one stays.
            *slot = normal.try_normalize().unwrap_or(*slot);
        }
        if let Some(slot) = vertex.colors.get_mut(i) {
            *slot = color.map(|sum| ((sum + count / 2) / count) as u8);
        }
    }
    triangles.iter_mut().flatten().for_each(|v| *v = VertexId(first_equal[v.ix()]));
    let mut report = clean(mesh);
    report.vertices_unreferenced -= joined;
    (joined, report)
}

/// For each of `n` vertices the first one that is `same`, which must have an equal position.
fn first_equals(n: usize, positions: &[Vec3], same: impl Fn(u32, u32) -> bool) -> Vec<u32> {
    // Seeded per process: a file cannot be made so that all its vertices collide. The result does not depend on it.
    let hasher = DefaultHashBuilder::default();
    // Attributes almost always agree where positions do, so the position alone is hashed. -0.0 + 0.0 is 0.0, and every
    // other number stays what it is.
    let hash = |i: u32| {
        let [x, y, z] = (positions[i as usize] + Vec3::ZERO).to_array().map(|c| u64::from(c.to_bits()));
        hasher.hash_one((x << 32 | y, z))
    };
    let mut table: HashTable<u32> = HashTable::with_capacity(n);
    (0..n as u32).map(|i| *table.entry(hash(i), |&j| same(i, j), |&j| hash(j)).or_insert(i).get()).collect()
}

/// Points the triangles to the first of equal vertices; the others stay, unreferenced.
fn weld(mesh: &mut TriangleMesh, report: &mut CleanReport) {
    let TriangleMesh { positions, triangles, vertex } = mesh;
    let same = |i: u32, j: u32| {
        let (i, j) = (i as usize, j as usize);
        positions[i] == positions[j]
            && vertex.normals.get(i) == vertex.normals.get(j)
            && vertex.colors.get(i) == vertex.colors.get(j)
    };
    let first_equal = first_equals(positions.len(), positions, same);
    report.vertices_welded = first_equal.iter().enumerate().filter(|&(i, &first)| i != first as usize).count() as u64;
    if report.vertices_welded > 0 {
        triangles.iter_mut().flatten().for_each(|v| *v = VertexId(first_equal[v.ix()]));
    }
}

fn drop_degenerate(mesh: &mut TriangleMesh, report: &mut CleanReport) {
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|&[a, b, c]| {
        let (pa, pb, pc) = (positions[a.ix()], positions[b.ix()], positions[c.ix()]);
        pa != pb && pb != pc && pc != pa
    });
    report.triangles_degenerate = (before - mesh.triangles.len()) as u64;
}

/// Sorts the triangles into buckets by their least corner, and each bucket by its other two.
fn drop_duplicates(mesh: &mut TriangleMesh, report: &mut CleanReport) {
    let turned = |[a, b, c]: [VertexId; 3]| {
        if a < b && a < c {
            (a, b, c)
        } else if b < c {
            (b, c, a)
        } else {
            (c, a, b)
        }
    };
    let mut ends = vec![0u32; mesh.positions.len() + 1];
    for &t in &mesh.triangles {
        ends[turned(t).0.ix() + 1] += 1;
    }
    for i in 1..ends.len() {
        ends[i] += ends[i - 1];
    }
    // Filling moves the start of each bucket to its end.
    let mut buckets = vec![(0u64, 0u32); mesh.triangles.len()];
    for (i, &t) in mesh.triangles.iter().enumerate() {
        let (least, b, c) = turned(t);
        let slot = &mut ends[least.ix()];
        buckets[*slot as usize] = (u64::from(b.0) << 32 | u64::from(c.0), i as u32);
        *slot += 1;
    }
    let mut doomed = Vec::new();
    let mut start = 0;
    for &end in &ends[..mesh.positions.len()] {
        let bucket = &mut buckets[start..end as usize];
        bucket.sort_unstable();
        doomed.extend(bucket.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| w[1].1));
        start = end as usize;
    }
    if doomed.is_empty() {
        return;
    }
    doomed.sort_unstable();
    let mut next = doomed.iter().copied().peekable();
    let mut i = 0;
    mesh.triangles.retain(|_| {
        i += 1;
        next.next_if_eq(&(i - 1)).is_none()
    });
    report.triangles_duplicate = doomed.len() as u64;
}

fn drop_unreferenced(mesh: &mut TriangleMesh, report: &mut CleanReport) {
    let mut new_id = vec![u32::MAX; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| new_id[v.ix()] = 0);
    let mut kept = 0u32;
    for old in 0..new_id.len() {
        if new_id[old] == 0 {
            new_id[old] = kept;
            let new = kept as usize;
            mesh.positions[new] = mesh.positions[old];
            if let Some(&normal) = mesh.vertex.normals.get(old) {
                mesh.vertex.normals[new] = normal;
            }
            if let Some(&color) = mesh.vertex.colors.get(old) {
                mesh.vertex.colors[new] = color;
            }
            kept += 1;
        }
    }
    let before = mesh.positions.len();
    if kept as usize == before {
        return;
    }
    mesh.positions.truncate(kept as usize);
    mesh.vertex.normals.truncate(kept as usize);
    mesh.vertex.colors.truncate(kept as usize);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = VertexId(new_id[v.ix()]));
    report.vertices_unreferenced = (before - kept as usize) as u64 - report.vertices_welded;
}
