//! Procedural meshes of any size, for trying things out, tests and benches: no file needed.
//!
//! Each function takes the wanted number of triangles and gives the nearest mesh its pattern allows (within one row of
//! the grid, so within `4·√triangles`; never fewer than a handful). The same number gives the same mesh: noise comes
//! from integer hashes, not from a random generator. Meshes fit a box of a few units about the origin.
//!
//! | name      | what                                  | boundary | for                                              |
//! | --------- | ------------------------------------- | -------- | ------------------------------------------------ |
//! | `sphere`  | equal-area octahedral sphere          | none     | exact distances                                  |
//! | `knot`    | tube around a (2, 3) torus knot       | none     | genus 1, self-occlusion, parts near each other   |
//! | `terrain` | fractal height field, y up            | square   | boundaries, view-dependence                      |
//! | `scan`    | bumpy closed shape, range noise, holes| 5 holes  | what a range scanner gives                       |
//! | `assembly`| 200 machine parts that do not touch   | none     | many objects, holes through plates, slivers      |
//!
//! [`terrain_heights`] gives the heights of a terrain as surveyors store them. [`defects`] has small meshes with one thing wrong (or unusual) each.

mod assembly;

pub use assembly::assembly;

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::{HeightField, TriangleMesh, Unit, VertexColumns, VertexId};

/// The procedural meshes by name, for command lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sample {
    /// [`sphere`]
    Sphere,
    /// [`knot`]
    Knot,
    /// [`terrain`]
    Terrain,
    /// [`scan`]
    Scan,
    /// [`assembly`]
    Assembly,
}

impl Sample {
    /// All of them, in the order of the module's table.
    pub const ALL: [Sample; 5] = [Sample::Sphere, Sample::Knot, Sample::Terrain, Sample::Scan, Sample::Assembly];

    /// The name that [`FromStr`] reads.
    pub fn name(self) -> &'static str {
        match self {
            Sample::Sphere => "sphere",
            Sample::Knot => "knot",
            Sample::Terrain => "terrain",
            Sample::Scan => "scan",
            Sample::Assembly => "assembly",
        }
    }

    /// Makes the mesh with about so many triangles.
    pub fn make(self, triangles: usize) -> TriangleMesh {
        match self {
            Sample::Sphere => sphere(triangles),
            Sample::Knot => knot(triangles),
            Sample::Terrain => terrain(triangles),
            Sample::Scan => scan(triangles),
            Sample::Assembly => assembly(triangles),
        }
    }
}

impl fmt::Display for Sample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// No sample has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no sample mesh is called {0:?}: there are sphere, knot, terrain, scan and assembly")]
pub struct UnknownSample(pub String);

impl FromStr for Sample {
    type Err = UnknownSample;
    fn from_str(name: &str) -> Result<Sample, UnknownSample> {
        Sample::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| UnknownSample(name.to_owned()))
    }
}

/// A unit sphere about the origin: 8n² triangles over 4n² + 2 vertices, closed, genus 0.
///
/// Vertices lie on the sphere up to rounding; their density is even (equal-area octahedral map: Clarberg 2008, "Fast
/// equal-area mapping of the (hemi)sphere using SIMD").
pub fn sphere(triangles: usize) -> TriangleMesh {
    octahedral(frequency(triangles), |direction, _| direction)
}

/// A tube of radius 0.35 around the (2, 3) torus knot with radii 2 and 1: closed, genus 1.
pub fn knot(triangles: usize) -> TriangleMesh {
    const RADIUS: f64 = 0.35;
    // The knot is about 30 units long, the tube 2.2 around: 14 rings for each segment around give square cells.
    let around = ((triangles as f64 / 28.0).sqrt().round() as usize).max(3);
    let rings = (triangles / (2 * around)).max(12);
    let center = |t: f64| {
        let r = 2.0 + (3.0 * t).cos();
        DVec3::new(r * (2.0 * t).cos(), r * (2.0 * t).sin(), (3.0 * t).sin())
    };
    let mut positions = Vec::with_capacity(rings * around);
    for i in 0..rings {
        let t = i as f64 / rings as f64 * TAU;
        let (before, here, after) = (center(t - 1e-3), center(t), center(t + 1e-3));
        let tangent = (after - before).normalize();
        // The knot winds about the z axis and never runs along it for long, so this frame closes up without a twist.
        let out = DVec3::new(here.x, here.y, 0.0);
        let side = tangent.cross(out).normalize();
        let up = side.cross(tangent);
        for j in 0..around {
            let (sin, cos) = (j as f64 / around as f64 * TAU).sin_cos();
            positions.push((here + RADIUS * (cos * side + sin * up)).as_vec3());
        }
    }
    let at = |i: usize, j: usize| VertexId(((i % rings) * around + j % around) as u32);
    let mut cells = Vec::with_capacity(2 * rings * around);
    for i in 0..rings {
        for j in 0..around {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            cells.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh { positions, triangles: cells, vertex: VertexColumns::default() }
}

/// A fractal height field over the square [-1, 1]² of x and z, y up: 2n² triangles, one boundary loop.
///
/// Six octaves of gradient noise with a gain of one half and a ridge in the first: about the roughness of mountains.
pub fn terrain(triangles: usize) -> TriangleMesh {
    let n = ((triangles as f64 / 2.0).sqrt().round() as usize).max(1);
    grid(n, n, |u, v| {
        let (x, z) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let p = DVec3::new(1.7 * x, 0.37, 1.7 * z);
        let ridge = 0.25 - noise(p).abs();
        DVec3::new(x, 0.5 * ridge + 0.35 * fractal(2.0 * p, 6), z)
    })
}

/// A fractal terrain of `columns` × `rows` samples (at least 2 each), 30 m apart: hills of some hundreds of metres.
///
/// Eight octaves of gradient noise from 7.7 km to 60 m with a gain of one half, and a ridge in the first, as in
/// [`terrain`]. All fields are windows of one terrain with the same north-western corner: a larger one shows more
/// hills, not larger ones. Same size, same heights, on any machine; all between 0 and 2400 m. Some 30 ns per sample.
///
/// # Panics
/// With fewer than two columns or rows.
pub fn terrain_heights(columns: u32, rows: u32) -> HeightField {
    assert!(columns >= 2 && rows >= 2, "{columns} × {rows} samples are no surface");
    const OCTAVES: u32 = 8;
    /// Samples along an edge of the coarsest lattice; of the finest, two.
    const COARSEST: u32 = 1 << OCTAVES;
    /// Metres. Noise is within ±1, so ridge and octaves together are from −3.5 to 2.5 times the amplitude.
    const MIDDLE: f32 = 1400.0;
    const AMPLITUDE: f32 = 400.0;
    let mut heights = vec![0.0; columns as usize * rows as usize];
    for (row, line) in heights.chunks_exact_mut(columns as usize).enumerate() {
        let row = row as u32;
        add_noise_line(line, row, COARSEST, 0, |noise| 2.0 * (0.25 - noise.abs()));
        for octave in 0..OCTAVES {
            let gain = 1.0 / (1 << octave) as f32;
            add_noise_line(line, row, COARSEST >> octave, u64::from(octave) + 1, |noise| gain * noise);
        }
        line.iter_mut().for_each(|height| *height = MIDDLE + AMPLITUDE * *height);
    }
    HeightField {
        columns,
        rows,
        heights,
        origin: DVec2::ZERO,
        spacing: DVec2::splat(30.0),
        horizontal: Unit::Metre,
        vertical: Unit::Metre,
        step: None,
    }
}

/// Adds `height(noise)` to the samples of a row, for gradient noise within ±1 on a lattice of `edge` samples.
///
/// Along a row the slopes of a cell's corners do not change, so each cell is one cubic blend of two lines:
/// a few multiplications per sample, where [`noise`] hashes eight gradients.
fn add_noise_line(line: &mut [f32], row: u32, edge: u32, seed: u64, height: impl Fn(f32) -> f32) {
    let (lattice_row, y) = (row / edge, (row % edge) as f32 / edge as f32);
    let v = fade(y);
    // The blend of the two corners of a lattice column, as (slope along x, value at the column).
    let column = |column: u32| {
        let gradient = |row: u32| {
            let key = mix(mix(seed ^ u64::from(column) << 32) ^ u64::from(row));
            Vec2::new(hash_unit(key) as f32, hash_unit(!key) as f32)
        };
        let (north, south) = (gradient(lattice_row), gradient(lattice_row + 1));
        let slope = north.x + v * (south.x - north.x);
        (slope, (1.0 - v) * (north.y * y) + v * (south.y * (y - 1.0)))
    };
    let (mut west, step) = (column(0), 1.0 / edge as f32);
    for (cell, samples) in line.chunks_mut(edge as usize).enumerate() {
        let east = column(cell as u32 + 1);
        for (i, sample) in samples.iter_mut().enumerate() {
            let x = i as f32 * step;
            let (left, right) = (west.0 * x + west.1, east.0 * (x - 1.0) + east.1);
            *sample += height(left + fade(x) * (right - left));
        }
        west = east;
    }
}

/// From 0 to 1, flat at both ends to the second derivative.
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// A bumpy closed shape as a range scanner gives it: noise along the viewing axis of the nearest of six stations, about
/// a tenth of the sampling distance, and five holes where no station saw. Genus 0 but for the holes.
///
/// The holes together take about one percent of the surface. Meshes below 500 triangles are mostly holes.
pub fn scan(triangles: usize) -> TriangleMesh {
    const HOLES: [[f64; 3]; 5] =
        [[0.3, -0.9, 0.2], [-0.7, -0.4, 0.6], [0.8, 0.5, 0.33], [-0.1, 0.2, -1.0], [-0.6, 0.75, -0.25]];
    let n = frequency(triangles);
    // Edge length of the even sampling: 4π spread over 4n² vertices.
    let spacing = PI.sqrt() / n as f64;
    let mut mesh = octahedral(n, |direction, i| {
        let radius = 1.0 + 0.5 * fractal(1.3 * direction + 5.0, 3) + 0.05 * fractal(9.0 * direction, 3);
        let axis = direction.abs();
        let station = if axis.x >= axis.y && axis.x >= axis.z {
            DVec3::X
        } else if axis.y >= axis.z {
            DVec3::Y
        } else {
            DVec3::Z
        };
        radius * direction + 0.2 * spacing * hash_unit(i as u64) * station
    });
    // Radii of the caps as angles; the floor keeps a hole of at least one vertex's star in a coarse mesh.
    let holes = HOLES.map(|h| DVec3::from(h).normalize());
    let sharp = (0.07f64).max(0.6 * spacing);
    mesh.triangles.retain(|&corners| {
        corners.iter().all(|v| {
            let direction = mesh.positions[v.ix()].as_dvec3().normalize();
            let ragged = sharp * (1.0 + 0.4 * noise(20.0 * direction));
            holes.iter().all(|&hole| direction.angle_between(hole) > ragged)
        })
    });
    drop_unreferenced(&mut mesh);
    mesh
}

/// Gives a mesh both attribute columns: angle-weighted unit normals, and opaque colours that vary smoothly over space.
pub fn paint(mesh: &mut TriangleMesh) {
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let p = corners.map(|v| mesh.positions[v.ix()]);
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
        for i in 0..3 {
            let (to, from) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            let weight = to.angle_between(from);
            if weight.is_finite() {
                normals[corners[i].ix()] += weight * normal;
            }
        }
    }
    mesh.vertex.normals = normals.into_iter().map(|n| n.try_normalize().unwrap_or(Vec3::Y)).collect();
    mesh.vertex.colors = (mesh.positions.iter())
        .map(|p| {
            let p = p.as_dvec3();
            let channel = |phase: f64| (127.5 + 127.5 * (2.0 * p.dot(DVec3::ONE) + phase + p.y).sin()) as u8;
            [channel(0.0), channel(TAU / 3.0), channel(2.0 * TAU / 3.0), 255]
        })
        .collect();
}

/// Meshes with one unusual thing each, large enough to be simplified: for tests of what must survive.
///
/// All are consistently oriented except where a non-manifold edge makes that impossible.
pub mod defects {
    use super::*;

    /// Four closed components that do not touch: three spheres of different sizes and one tetrahedron.
    pub fn several_components(triangles: usize) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for (share, scale, center) in [(0.6, 1.0, Vec3::ZERO), (0.3, 0.5, Vec3::X * 2.0), (0.1, 0.2, Vec3::Y * 1.5)] {
            append(&mut mesh, sphere((share * triangles as f64) as usize), scale, center);
        }
        append(&mut mesh, tetrahedron(), 0.1, Vec3::Z * 2.0);
        mesh
    }

    /// Three wavy sheets that share one straight edge line: every inner edge of the line has three triangles.
    pub fn non_manifold_edge(triangles: usize) -> TriangleMesh {
        let n = ((triangles as f64 / 6.0).sqrt().round() as usize).max(2);
        let mut mesh = TriangleMesh::default();
        let row = n + 1;
        for sheet in 0..3 {
            let (sin, cos) = (sheet as f64 * TAU / 3.0).sin_cos();
            let first = mesh.positions.len();
            let page = grid(n, n, |u, v| {
                let bend = 0.1 * u * (6.0 * v + 4.0 * u).sin();
                DVec3::new(u * cos - bend * sin, u * sin + bend * cos, 2.0 * v - 1.0)
            });
            // Vertex (i, j) of the grid is `j * row + i`; i = 0 is the line, which the first sheet owns.
            let skipped = |ix: usize| ix / row + 1;
            mesh.positions.extend(
                (page.positions.iter().enumerate())
                    .filter(|&(ix, _)| sheet == 0 || !ix.is_multiple_of(row))
                    .map(|(_, &p)| p),
            );
            mesh.triangles.extend(page.triangles.iter().map(|corners| {
                corners.map(|v| match v.ix() {
                    ix if sheet == 0 || ix.is_multiple_of(row) => v,
                    ix => VertexId((first + ix - skipped(ix)) as u32),
                })
            }));
        }
        mesh
    }

    /// Two spheres that share one vertex (a bow tie): two fans of triangles, no common edge.
    pub fn bow_tie(triangles: usize) -> TriangleMesh {
        let mut mesh = sphere(triangles / 2);
        let first = mesh.positions.len() as u32;
        let top = VertexId(0);
        append(&mut mesh, sphere(triangles / 2), 1.0, Vec3::ZERO);
        // The second sphere is turned upside down (a rotation, so outside stays outside) and set on the first one's top.
        for p in &mut mesh.positions[first as usize..] {
            *p = Vec3::new(p.x, -p.y, -p.z) + 2.0 * Vec3::Z;
        }
        for v in mesh.triangles.iter_mut().flatten() {
            if v.0 == first {
                *v = top;
            }
        }
        drop_unreferenced(&mut mesh);
        mesh
    }

    /// A wavy square sheet: one component, one boundary loop, no other feature.
    pub fn open_sheet(triangles: usize) -> TriangleMesh {
        let n = ((triangles as f64 / 2.0).sqrt().round() as usize).max(1);
        grid(n, n, |u, v| DVec3::new(u, 0.1 * (5.0 * u).sin() * (4.0 * v).cos(), v))
    }

    /// The smallest closed mesh: four vertices, four triangles.
    pub fn tetrahedron() -> TriangleMesh {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|t| t.map(VertexId)).to_vec();
        TriangleMesh { positions, triangles, vertex: VertexColumns::default() }
    }

    fn append(mesh: &mut TriangleMesh, part: TriangleMesh, scale: f32, center: Vec3) {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(part.positions.iter().map(|&p| scale * p + center));
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| VertexId(first + v.0))));
    }
}

/// Cells along an edge of the octahedron for about so many triangles.
fn frequency(triangles: usize) -> usize {
    ((triangles as f64 / 8.0).sqrt().round() as usize).max(1)
}

/// The octahedral sphere of frequency `n`, each vertex moved to `place(direction, vertex index)`.
///
/// Rings of constant z from the north pole (vertex 0) to the south pole (the last); ring r has 4·min(r, 2n - r)
/// vertices, the same number of steps in each quadrant:
///
/// ```text
///      r    .--.--.        m steps in this quadrant
///           |\ |\ |\
///      r+1  .--.--.--.     m + 1 steps
/// ```
fn octahedral(n: usize, place: impl Fn(DVec3, usize) -> DVec3) -> TriangleMesh {
    let steps = |ring: usize| ring.min(2 * n - ring);
    let mut first = Vec::with_capacity(2 * n + 1);
    let mut positions = Vec::with_capacity(4 * n * n + 2);
    for ring in 0..=2 * n {
        first.push(positions.len());
        let m = steps(ring);
        let r = m as f64 / n as f64;
        let z = (1.0 - r * r) * if ring <= n { 1.0 } else { -1.0 };
        let radius = r * (2.0 - r * r).sqrt();
        for i in 0..(4 * m).max(1) {
            let (sin, cos) = (i as f64 / m.max(1) as f64 * FRAC_PI_2).sin_cos();
            let direction = DVec3::new(radius * cos, radius * sin, z);
            positions.push(place(direction, positions.len()).as_vec3());
        }
    }
    let at = |ring: usize, quadrant: usize, step: usize| {
        let around = (4 * steps(ring)).max(1);
        VertexId((first[ring] + (quadrant * steps(ring) + step) % around) as u32)
    };
    let mut triangles = Vec::with_capacity(8 * n * n);
    for ring in 0..2 * n {
        // The ring with fewer vertices is the one nearer to its pole.
        let (near, far) = if ring < n { (ring, ring + 1) } else { (ring + 1, ring) };
        for q in 0..4 {
            for s in 0..steps(far) {
                let mut pair = [
                    Some([at(near, q, s), at(far, q, s), at(far, q, s + 1)]),
                    (s < steps(near)).then(|| [at(near, q, s), at(far, q, s + 1), at(near, q, s + 1)]),
                ];
                if ring >= n {
                    pair.iter_mut().flatten().for_each(|t| t.swap(1, 2));
                }
                triangles.extend(pair.into_iter().flatten());
            }
        }
    }
    TriangleMesh { positions, triangles, vertex: VertexColumns::default() }
}

/// A grid of `columns × rows` cells over the unit square; vertex (i, j) is `j * (columns + 1) + i`. Facing +y where
/// `place` maps (u, v) to (x, z).
fn grid(columns: usize, rows: usize, place: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
    let mut positions = Vec::with_capacity((columns + 1) * (rows + 1));
    for j in 0..=rows {
        for i in 0..=columns {
            positions.push(place(i as f64 / columns as f64, j as f64 / rows as f64).as_vec3());
        }
    }
    let at = |i: usize, j: usize| VertexId((j * (columns + 1) + i) as u32);
    let mut triangles = Vec::with_capacity(2 * columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh { positions, triangles, vertex: VertexColumns::default() }
}

/// Sum of `octaves` of [`noise`], each of twice the frequency and half the height of the one before; within about ±1.
fn fractal(p: DVec3, octaves: u32) -> f64 {
    // The shift keeps the lattices of the octaves from lining up at the origin.
    (0..octaves).map(|i| noise(p * f64::from(1 << i) + 11.3 * f64::from(i)) / f64::from(1 << i)).sum()
}

/// Gradient noise on the integer lattice, within about ±1, twice differentiable (Perlin 2002, "Improving noise").
fn noise(p: DVec3) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let mut sum = 0.0;
    for corner in 0..8u32 {
        let offset = DVec3::new((corner & 1) as f64, (corner >> 1 & 1) as f64, (corner >> 2) as f64);
        let lattice = cell + offset;
        let key = [lattice.x, lattice.y, lattice.z].iter().fold(0u64, |h, &c| mix(h ^ (c as i64 as u64)));
        let gradient = DVec3::new(hash_unit(key), hash_unit(mix(key)), hash_unit(mix(mix(key))));
        let weight = DVec3::ONE - offset + fade * (2.0 * offset - DVec3::ONE);
        sum += weight.x * weight.y * weight.z * gradient.dot(f - offset);
    }
    sum
}

/// An even number in [-1, 1) for a key.
fn hash_unit(key: u64) -> f64 {
    (mix(key) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// The finalizer of SplitMix64 (Steele, Lea & Flood 2014): every bit of the key changes half of the bits of the result.
fn mix(key: u64) -> u64 {
    let z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Keeps the vertices that a triangle uses, in their order; attribute columns are absent here.
fn drop_unreferenced(mesh: &mut TriangleMesh) {
    let mut new_id = vec![u32::MAX; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| new_id[v.ix()] = 0);
    let mut kept = 0;
    for old in 0..new_id.len() {
        if new_id[old] == 0 {
            new_id[old] = kept;
            mesh.positions[kept as usize] = mesh.positions[old];
            kept += 1;
        }
    }
    mesh.positions.truncate(kept as usize);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = VertexId(new_id[v.ix()]));
}
