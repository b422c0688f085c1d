//! Columns for tests: as a simplifier makes them in shape, order and statistics, whether or not each split could be
//! applied.
#![allow(dead_code)]

pub mod checksums;
pub mod damage;

use glam::Vec3;
use meshfront_format::round_error_up;
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::edge_collapse::{AddedTriangle, Columns, ExplicitSplit, Grid, Oct};
use meshfront_mesh::{Bounds, TriangleMesh, VertexId, sample};
use meshfront_refine::UpdateId;

/// A small generator of its own, so that a test's input never changes.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        // SplitMix64, Steele et al. 2014.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }
    pub fn in_ball(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0;
            if v.length_squared() <= 1.0 {
                return v;
            }
        }
    }
}

/// With normals and colours that differ from vertex to vertex.
pub fn painted(triangles: usize) -> TriangleMesh {
    let mut mesh = sample::knot(triangles);
    mesh.vertex.normals = mesh.positions.iter().map(|p| p.normalize_or(Vec3::X)).collect();
    mesh.vertex.colors =
        (0..mesh.positions.len() as u32).map(|v| v.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
    mesh
}

/// What columns to make.
#[derive(Clone, Copy)]
pub struct Shape {
    pub updates: usize,
    pub bits: Option<u32>,
    pub normals: bool,
    pub colors: bool,
    pub explicit: bool,
}

/// A sphere that gets rounder: generation after generation, every vertex splits along a tangent.
pub fn plausible(shape: Shape, seed: u64) -> Columns {
    let mut random = Random(seed);
    const BASE: usize = 12;
    let mut points: Vec<Vec3> = (0..BASE).map(|_| random.in_ball().normalize_or(Vec3::X)).collect();
    let mut base = TriangleMesh {
        triangles: (0..2 * BASE as u32).map(|i| [i, i + 1, i + 5].map(|v| VertexId(v % BASE as u32))).collect(),
        ..TriangleMesh::default()
    };
    let mut columns = Columns { floor_error: 1e-5, ..Columns::default() };
    let mut generation: Vec<u32> = (0..BASE as u32).collect();
    while columns.vertex.len() < shape.updates {
        let edge = 3.0 / (generation.len() as f32).sqrt();
        let mut next = Vec::new();
        for s in generation {
            if columns.vertex.len() == shape.updates {
                break;
            }
            if random.below(10) == 0 {
                next.push(s);
                continue;
            }
            let p = points[s as usize];
            let tangent = p.cross(random.in_ball()).normalize_or(Vec3::Y) * edge * (0.2 + 0.5 * random.unit());
            let middle = p + random.in_ball() * edge * 0.1;
            columns.vertex.push(VertexId(s));
            let star = 5 + random.below(4);
            columns.sides.push((random.below(1 << star) & !1) as u32);
            let error = (edge * edge).log2().floor().exp2() * (1.0 + 0.9 * random.unit());
            columns.errors.push(round_error_up(error));
            for child in [middle - tangent * 0.5, middle + tangent * 0.5] {
                next.push(points.len() as u32);
                points.push(child);
            }
        }
        next.sort_unstable();
        generation = next;
    }
    if let Some(bits) = shape.bits {
        let grid = Grid::fit(Bounds::of(&points).unwrap(), bits);
        points.iter_mut().for_each(|p| *p = grid.snap(*p));
        columns.grid = Some(grid);
    }
    let normals: Vec<Oct> = points.iter().map(|&p| Oct::encode(p + random.in_ball() * 0.05)).collect();
    let colors: Vec<[u8; 4]> = points
        .iter()
        .map(|p| {
            let [r, g, b] = ((*p * 0.5 + 0.5) * 250.0).to_array().map(|c| c as u8 ^ random.below(3) as u8);
            [r, g, b, 255]
        })
        .collect();
    base.positions = points[..BASE].to_vec();
    columns.positions = points[BASE..].chunks_exact(2).map(|c| [c[0], c[1]]).collect();
    if shape.normals {
        base.vertex.normals = normals[..BASE].iter().map(|n| n.decode()).collect();
        columns.normals = normals[BASE..].chunks_exact(2).map(|c| [c[0], c[1]]).collect();
    }
    if shape.colors {
        base.vertex.colors = colors[..BASE].to_vec();
        columns.colors = colors[BASE..].chunks_exact(2).map(|c| [c[0], c[1]]).collect();
    }
    if shape.explicit {
        for m in (0..shape.updates).filter(|m| m % 7 == 3) {
            columns.sides[m] |= Columns::EXPLICIT;
            let added = (0..random.below(5))
                .map(|_| AddedTriangle {
                    star: random.below(31) as u8,
                    before: random.below(2) == 1,
                    flipped: random.below(2) == 1,
                })
                .collect();
            columns.explicit.push(ExplicitSplit { update: UpdateId(m as u32), added });
        }
    }
    columns.base = base;
    let vertices = (BASE + shape.updates) as u32;
    columns.source = SourceCounts { vertices, triangles: 2 * vertices };
    columns
}
