//! What a mesh is like: sizes, boundaries, pieces, and the places where it is not a surface.

use meshfront_mesh::{Bounds, TriangleMesh};

/// Counts over a mesh. Vertices that no triangle uses count in `vertices` and `bounds` alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Edges: pairs of vertices that follow each other in some triangle.
    pub edges: usize,
    /// The box of all vertices; `None` where there are none.
    pub bounds: Option<Bounds>,
    /// Sum of the triangles' areas, square mesh units.
    pub area: f64,
    /// Pieces that hang together by vertices.
    pub components: usize,
    /// Edges with one triangle.
    pub boundary_edges: usize,
    /// Edges with three triangles or more.
    pub non_manifold_edges: usize,
    /// Vertices where several fans of triangles meet that share no edge there (bow ties).
    pub non_manifold_vertices: usize,
    /// Edges of two triangles that run through it the same way: their orientations contradict each other.
    pub inconsistent_edges: usize,
}

/// Looks at every edge of a mesh. Takes O(n log n) time and 40 bytes per triangle.
pub fn survey(mesh: &TriangleMesh) -> Survey {
    let n = mesh.triangles.len();
    // An edge's two vertices, the lower first; then the corner it starts from, whose low bit pair says which way.
    let mut half_edges = Vec::with_capacity(3 * n);
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (corners[i].0, corners[(i + 1) % 3].0);
            half_edges.push((a.min(b), a.max(b), (3 * t + i) as u32));
        }
    }
    half_edges.sort_unstable();

    let mut survey = Survey {
        vertices: mesh.positions.len(),
        triangles: n,
        edges: 0,
        bounds: mesh.bounds(),
        area: mesh.triangles.iter().map(|t| area(t.map(|v| mesh.positions[v.ix()].as_dvec3()))).sum(),
        components: 0,
        boundary_edges: 0,
        non_manifold_edges: 0,
        non_manifold_vertices: 0,
        inconsistent_edges: 0,
    };

    // Corners of one vertex that an edge links are of one fan; vertices of one triangle are of one piece.
    let mut fans = Partition::new(3 * n);
    let mut pieces = Partition::new(mesh.positions.len());
    let vertex = |corner: u32| mesh.triangles[corner as usize / 3][corner as usize % 3].0;
    let next = |corner: u32| corner - corner % 3 + (corner + 1) % 3;
    for edge in half_edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        survey.edges += 1;
        match edge.len() {
            1 => survey.boundary_edges += 1,
            2 => survey.inconsistent_edges += usize::from(vertex(edge[0].2) == vertex(edge[1].2)),
            _ => survey.non_manifold_edges += 1,
        }
        pieces.join(edge[0].0, edge[0].1);
        let ends =
            |corner: u32| if vertex(corner) == edge[0].0 { (corner, next(corner)) } else { (next(corner), corner) };
        let (low, high) = ends(edge[0].2);
        for &(_, _, corner) in &edge[1..] {
            let (other_low, other_high) = ends(corner);
            fans.join(low, other_low);
            fans.join(high, other_high);
        }
    }

    let mut fans_at = vec![0u8; mesh.positions.len()];
    for corner in 0..3 * n as u32 {
        if fans.find(corner) == corner {
            let count = &mut fans_at[vertex(corner) as usize];
            *count = count.saturating_add(1);
        }
    }
    for v in 0..mesh.positions.len() as u32 {
        survey.non_manifold_vertices += usize::from(fans_at[v as usize] > 1);
        survey.components += usize::from(fans_at[v as usize] > 0 && pieces.find(v) == v);
    }
    survey
}

fn area([a, b, c]: [glam::DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// Disjoint sets with path halving. The least member stands for its set.
struct Partition(Vec<u32>);

impl Partition {
    fn new(n: usize) -> Partition {
        Partition((0..n as u32).collect())
    }
    fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }
    fn join(&mut self, x: u32, y: u32) {
        let (x, y) = (self.find(x), self.find(y));
        self.0[x.max(y) as usize] = x.min(y);
    }
}
