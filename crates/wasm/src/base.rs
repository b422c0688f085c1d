//! A surface from the first bytes of a file, for a picture while the rest arrives: the base mesh, or the coarsest heights of a terrain.

use bytemuck::cast_slice;
use glam::Vec3;
use meshfront_hierarchies::Model;
use meshfront_mesh::Bounds;
use wasm_bindgen::prelude::*;

/// A base mesh, or what stands for it, as `Frame` has its columns. There are no gaps in it.
#[wasm_bindgen(getter_with_clone)]
pub struct BaseMesh {
    /// 3 numbers per vertex.
    pub positions: Vec<f32>,
    /// 4 numbers per vertex: a unit vector times 32767, and 0.
    pub normals: Vec<i16>,
    /// 4 numbers per vertex, or none.
    pub colors: Vec<u8>,
    /// 3 vertices per triangle.
    pub triangles: Vec<u32>,
    /// Least and greatest corner of the base mesh: six numbers.
    pub bounds: Vec<f32>,
    /// Which way is up: a unit vector.
    pub up: Vec<f32>,
}

/// The base mesh, once the bytes reach far enough; see `meshfront_format::base`.
#[wasm_bindgen(js_name = baseOf)]
pub fn base_of(start: &[u8]) -> Option<BaseMesh> {
    let (model, mesh) = (meshfront_format::model_of(start)?, meshfront_format::base(start)?);
    let up = match model {
        Model::RightTriangles => Vec3::Z,
        Model::EdgeCollapse | Model::VertexRemoval | Model::VertexPair => Vec3::Y,
    };
    let bounds = Bounds::over(mesh.positions.iter().copied())?;
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|v| v.0)).collect();
    let mut normals = mesh.vertex.normals;
    if normals.is_empty() {
        // Weighted by area.
        normals.resize(mesh.positions.len(), Vec3::ZERO);
        for t in &triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            t.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
        }
    }
    let normal = |n: &Vec3| {
        let [x, y, z] = (n.normalize_or(Vec3::Z) * 32767.0).to_array().map(|c| c.round() as i16);
        [x, y, z, 0]
    };
    Some(BaseMesh {
        positions: cast_slice(&mesh.positions).to_vec(),
        normals: normals.iter().flat_map(normal).collect(),
        colors: mesh.vertex.colors.concat(),
        triangles: triangles.concat(),
        bounds: [bounds.min.to_array(), bounds.max.to_array()].concat(),
        up: up.to_array().to_vec(),
    })
}
