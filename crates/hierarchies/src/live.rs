//! The buffers of a live triangle mesh, as a renderer and an exporter want them. Every surface model's
//! front mesh holds one, so that nothing downstream knows the model.

use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexColumns, VertexId};

/// Vertex and index arrays with slots that are reused: after a change only the touched slots need uploading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleBuffers {
    /// A point per vertex slot, mesh space. Free slots hold stale points.
    pub positions: Vec<Vec3>,
    /// Unit normal per vertex slot, each component times 32767; the fourth is 0.
    pub normals: Vec<[i16; 4]>,
    /// Colour per vertex slot; empty where the source had none.
    pub colors: Vec<[u8; 4]>,
    /// How many splits lie between a vertex and the base mesh, up to 255.
    pub levels: Vec<u8>,
    /// Vertex slots per triangle slot. Free slots hold `[0, 0, 0]`: a renderer may draw the whole array.
    pub triangles: Vec<[u32; 3]>,
    /// Slots written since the last `clear_changes`, with repetitions.
    pub changes: Changes,
}

/// Slots whose content changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Vertex slots.
    pub vertices: Vec<u32>,
    /// Triangle slots.
    pub triangles: Vec<u32>,
}

impl TriangleBuffers {
    /// Forgets which slots changed: call it once they are uploaded.
    pub fn clear_changes(&mut self) {
        self.changes.vertices.clear();
        self.changes.triangles.clear();
    }

    /// A compact copy: live triangles in slot order, the vertices they use in order of first use.
    pub fn to_mesh(&self) -> TriangleMesh {
        let mut slot_to_vertex = vec![u32::MAX; self.positions.len()];
        let mut mesh = TriangleMesh::default();
        for t in &self.triangles {
            if t[0] == t[1] {
                continue; // a free slot
            }
            let corners = t.map(|slot| {
                let v = &mut slot_to_vertex[slot as usize];
                if *v == u32::MAX {
                    *v = mesh.positions.len() as u32;
                    mesh.positions.push(self.positions[slot as usize]);
                    let VertexColumns { normals, colors } = &mut mesh.vertex;
                    if let Some(n) = self.normals.get(slot as usize) {
                        normals.push(Vec3::new(n[0] as f32, n[1] as f32, n[2] as f32).normalize_or(Vec3::Z));
                    }
                    if let Some(&c) = self.colors.get(slot as usize) {
                        colors.push(c);
                    }
                }
                VertexId(*v)
            });
            mesh.triangles.push(corners);
        }
        mesh
    }
}
