//! Vertices of all levels, those of the source and those that merges make, with what they carry.

use crate::order::morton;
use glam::Vec3;
use meshfront_hierarchies::edge_collapse::Oct;
use meshfront_mesh::{Bounds, TriangleMesh, VertexColumns, VertexId};

/// `0..n` are the source's vertices, `n + i` is what merge `i` makes.
pub(crate) struct Nodes {
    /// On the grid, where there is one.
    pub positions: Vec<Vec3>,
    /// Empty where the source has none.
    pub normals: Vec<Oct>,
    /// Empty where the source has none.
    pub colors: Vec<[u8; 4]>,
}

impl Nodes {
    /// Those of the source, at these points.
    pub fn of(source: &TriangleMesh, points: &[Vec3]) -> Nodes {
        let mut positions = Vec::with_capacity(2 * points.len());
        positions.extend_from_slice(points);
        Nodes {
            positions,
            normals: source.vertex.normals.iter().map(|&v| Oct::encode(v)).collect(),
            colors: source.vertex.colors.clone(),
        }
    }

    /// Adds what two become: attributes as at the nearest point of the way between them.
    pub fn merge(&mut self, [u, v]: [u32; 2], point: Vec3) {
        let (pu, pv) = (self.positions[u as usize], self.positions[v as usize]);
        let edge = pv - pu;
        let t = ((point - pu).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        self.positions.push(point);
        if !self.normals.is_empty() {
            let (nu, nv) = (self.normals[u as usize].decode(), self.normals[v as usize].decode());
            self.normals.push(Oct::encode(nu.lerp(nv, t).normalize_or(nu)));
        }
        if !self.colors.is_empty() {
            let (cu, cv) = (self.colors[u as usize], self.colors[v as usize]);
            let mix = |k: usize| (cu[k] as f32 + (cv[k] as f32 - cu[k] as f32) * t).round() as u8;
            self.colors.push(std::array::from_fn(mix));
        }
    }

    /// The mesh of triangles, given with their corners, along a space-filling curve, so that neighbours have near numbers; and
    /// its triangles in this order. Numbers its vertices.
    pub fn base_mesh(
        &self,
        triangles: &[(u32, [u32; 3])],
        bounds: &Bounds,
        number: &mut [u32],
    ) -> (TriangleMesh, Vec<u32>) {
        let at = |v: u32| self.positions[v as usize];
        let mut vertices: Vec<u32> = triangles.iter().flat_map(|(_, corners)| *corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.sort_by_key(|&v| morton(bounds, at(v)));
        for (n, &v) in vertices.iter().enumerate() {
            number[v as usize] = n as u32;
        }
        let mut cells: Vec<(u32, [u32; 3])> =
            triangles.iter().map(|(t, c)| (*t, c.map(|v| number[v as usize]))).collect();
        cells.sort_by_key(|(t, c)| (c.iter().min().copied(), *t));
        let mesh = TriangleMesh {
            positions: vertices.iter().map(|&v| at(v)).collect(),
            triangles: cells.iter().map(|(_, c)| c.map(VertexId)).collect(),
            vertex: VertexColumns {
                normals: vertices.iter().filter_map(|&v| self.normals.get(v as usize)).map(|n| n.decode()).collect(),
                colors: vertices.iter().filter_map(|&v| self.colors.get(v as usize)).copied().collect(),
            },
        };
        (mesh, cells.into_iter().map(|(t, _)| t).collect())
    }
}
