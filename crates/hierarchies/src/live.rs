//! The buffers of a live triangle mesh, as a renderer and an exporter want them, and the slots in them. Every surface
//! model's front mesh holds one, so that nothing downstream knows the model.

use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexColumns, VertexId};

/// What a renderer sees of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexLook {
    /// Mesh space.
    pub position: Vec3,
    /// Unit vector times 32767, and 0.
    pub normal: [i16; 4],
    /// `Some` for all vertices of a mesh, or for none.
    pub color: Option<[u8; 4]>,
    /// How many updates lie between it and the base mesh, up to 255.
    pub level: u8,
}

/// Vertex and index arrays with slots that are reused: after a change only the touched slots need uploading.
///
/// Slots are given out as a stack gives them: removing in the reverse order of adding leaves everything as it was.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleBuffers {
    /// A point per vertex slot, mesh space. Free slots hold the origin.
    pub positions: Vec<Vec3>,
    /// Unit normal per vertex slot, each component times 32767; the fourth is 0.
    pub normals: Vec<[i16; 4]>,
    /// Colour per vertex slot; empty where the source had none.
    pub colors: Vec<[u8; 4]>,
    /// How many updates lie between a vertex and the base mesh, up to 255.
    pub levels: Vec<u8>,
    /// Vertex slots per triangle slot. Free slots hold `[0, 0, 0]`: a renderer may draw the whole array.
    pub triangles: Vec<[u32; 3]>,
    /// Slots written since the last `clear_changes`, with repetitions.
    pub changes: Changes,
    free_vertices: Vec<u32>,
    free_triangles: Vec<u32>,
    most: Most,
}

/// The most vertices and triangles that a front of a hierarchy can have: columns need never be longer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Most {
    pub vertices: usize,
    pub triangles: usize,
}

/// Slots whose content changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Vertex slots.
    pub vertices: Vec<u32>,
    /// Triangle slots.
    pub triangles: Vec<u32>,
}

/// Pushes; capacity grows by a quarter, not by doubling, and not beyond what is ever needed, so that memory stays close
/// to size. Smaller steps would make copying what costs most in a front that grows fast.
#[inline]
pub(crate) fn grow<T>(column: &mut Vec<T>, value: T, most: usize) {
    if column.len() == column.capacity() {
        let enough = most.saturating_sub(column.len()).max(1);
        column.reserve_exact((column.len() / 4).max(64).min(enough));
    }
    column.push(value);
}

/// Sets the value of a slot, which may be the first one beyond the end.
#[inline]
pub(crate) fn put<T>(column: &mut Vec<T>, slot: u32, value: T, most: usize) {
    match column.get_mut(slot as usize) {
        Some(place) => *place = value,
        None => grow(column, value, most),
    }
}

/// A unit vector as renderers want it.
#[inline]
pub(crate) fn snorm16(normal: Vec3) -> [i16; 4] {
    // Rounds to nearest without a call, as `round` is one on the oldest x86-64.
    let [x, y, z] = (normal * 32767.0).to_array().map(|c| (c + 0.5f32.copysign(c)) as i16);
    [x, y, z, 0]
}

impl TriangleBuffers {
    /// Empty ones, for a hierarchy of this size.
    pub(crate) fn for_at_most(most: Most) -> TriangleBuffers {
        TriangleBuffers { most, ..TriangleBuffers::default() }
    }
    /// Empty again, in the same memory.
    pub(crate) fn clear(&mut self) {
        self.positions.clear();
        self.normals.clear();
        self.colors.clear();
        self.levels.clear();
        self.triangles.clear();
        self.free_vertices.clear();
        self.free_triangles.clear();
        self.clear_changes();
    }
    pub(crate) fn most(&self) -> Most {
        self.most
    }
    /// The corners of the triangle in a slot; `None` where the slot is free, or there is none.
    #[inline]
    pub fn live_triangle(&self, slot: u32) -> Option<[u32; 3]> {
        self.triangles.get(slot as usize).copied().filter(|t| t[0] != t[1])
    }
    /// Number of live triangles.
    pub fn live_triangles(&self) -> usize {
        self.triangles.len() - self.free_triangles.len()
    }
    /// The most vertices and triangles that a front of the hierarchy can have, as far as it knows.
    pub fn most_live(&self) -> [usize; 2] {
        [self.most.vertices, self.most.triangles]
    }
    /// Number of live vertices.
    pub fn live_vertices(&self) -> usize {
        self.positions.len() - self.free_vertices.len()
    }

    /// Gives a vertex a slot.
    #[inline]
    pub(crate) fn add_vertex(&mut self, look: &VertexLook) -> u32 {
        if let Some(slot) = self.free_vertices.pop() {
            self.set_vertex(slot, look);
            return slot;
        }
        let (slot, most) = (self.positions.len() as u32, self.most.vertices);
        grow(&mut self.positions, look.position, most);
        grow(&mut self.normals, look.normal, most);
        if let Some(color) = look.color {
            grow(&mut self.colors, color, most);
        }
        grow(&mut self.levels, look.level, most);
        self.changes.vertices.push(slot);
        slot
    }
    /// Changes what is in a vertex slot.
    #[inline]
    pub(crate) fn set_vertex(&mut self, slot: u32, look: &VertexLook) {
        let s = slot as usize;
        (self.positions[s], self.normals[s], self.levels[s]) = (look.position, look.normal, look.level);
        if let Some(color) = look.color {
            self.colors[s] = color;
        }
        self.changes.vertices.push(slot);
    }
    /// Takes a vertex slot back.
    #[inline]
    pub(crate) fn remove_vertex(&mut self, slot: u32) {
        let s = slot as usize;
        (self.positions[s], self.normals[s], self.levels[s]) = (Vec3::ZERO, [0; 4], 0);
        if let Some(color) = self.colors.get_mut(s) {
            *color = [0; 4];
        }
        grow(&mut self.free_vertices, slot, self.most.vertices);
    }
    /// Gives a triangle a slot.
    #[inline]
    pub(crate) fn add_triangle(&mut self, corners: [u32; 3]) -> u32 {
        if let Some(slot) = self.free_triangles.pop() {
            self.set_triangle(slot, corners);
            return slot;
        }
        let slot = self.triangles.len() as u32;
        grow(&mut self.triangles, corners, self.most.triangles);
        self.changes.triangles.push(slot);
        slot
    }
    /// Changes the corners of a triangle.
    #[inline]
    pub(crate) fn set_triangle(&mut self, slot: u32, corners: [u32; 3]) {
        self.triangles[slot as usize] = corners;
        self.changes.triangles.push(slot);
    }
    /// Changes one corner of a triangle.
    #[inline]
    pub(crate) fn set_corner(&mut self, slot: u32, corner: usize, vertex: u32) {
        self.triangles[slot as usize][corner] = vertex;
        self.changes.triangles.push(slot);
    }
    /// Takes a triangle slot back.
    #[inline]
    pub(crate) fn remove_triangle(&mut self, slot: u32) {
        self.set_triangle(slot, [0; 3]);
        grow(&mut self.free_triangles, slot, self.most.triangles);
    }

    /// Memory held, bytes: capacities, not sizes; without the list of changes, which lives for one frame.
    pub fn memory_bytes(&self) -> usize {
        fn of<T>(v: &Vec<T>) -> usize {
            v.capacity() * size_of::<T>()
        }
        of(&self.positions)
            + of(&self.normals)
            + of(&self.colors)
            + of(&self.levels)
            + of(&self.triangles)
            + of(&self.free_vertices)
            + of(&self.free_triangles)
    }

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
