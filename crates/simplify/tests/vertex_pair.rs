//! Columns of vertex pairs, replayed here from what their documentation says, without the hierarchy's own code.

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use meshfront_hierarchies::vertex_pair::Columns;
use meshfront_mesh::sample::{self, defects};
use meshfront_mesh::{TriangleMesh, VertexId};
use meshfront_simplify::{VertexPairOptions, vertex_pair_columns};

/// Nodes of a hierarchy, as its columns name them.
struct Forest {
    parent: Vec<u32>,
    position: Vec<Vec3>,
    /// Per node: the update that splits it.
    split: Vec<Option<usize>>,
}

const NONE: u32 = u32::MAX;

impl Forest {
    fn of(columns: &Columns) -> Forest {
        let roots = columns.base.positions.len();
        let nodes = roots + 2 * columns.vertex.len();
        let mut forest =
            Forest { parent: vec![NONE; nodes], position: columns.base.positions.clone(), split: vec![None; nodes] };
        forest.position.extend(columns.positions.iter().flatten());
        for (m, s) in columns.vertex.iter().enumerate() {
            assert!(s.ix() < roots + 2 * m, "update {m} splits a node that is not there yet");
            assert!(forest.split[s.ix()].replace(m).is_none(), "update {m} splits node {} again", s.0);
            for child in [roots + 2 * m, roots + 2 * m + 1] {
                forest.parent[child] = s.0;
            }
        }
        forest
    }

    /// The ancestor of a leaf that is active once the first `applied` updates are applied.
    fn active(&self, leaf: VertexId, applied: usize) -> u32 {
        let made_later = |v: u32| {
            self.parent[v as usize] != NONE
                && self.split[self.parent[v as usize] as usize].is_some_and(|m| m >= applied)
        };
        let mut v = leaf.0;
        while made_later(v) {
            v = self.parent[v as usize];
        }
        v
    }
}

/// Replays all updates; gives the finest mesh in terms of positions.
fn replay(columns: &Columns) -> Vec<[Vec3; 3]> {
    let forest = Forest::of(columns);
    let roots = columns.base.positions.len();
    let base = columns.base.triangles.len();
    assert_eq!(columns.triangles.len(), base + columns.added.iter().sum::<u32>() as usize);
    assert!(columns.triangles.iter().flatten().all(|v| forest.split[v.ix()].is_none()), "triangles name leaves");
    for (leaves, corners) in columns.triangles.iter().zip(&columns.base.triangles) {
        assert_eq!(leaves.map(|v| forest.active(v, 0)), corners.map(|v| v.0));
    }
    let mut live: Vec<[u32; 3]> = columns.base.triangles.iter().map(|t| t.map(|v| v.0)).collect();
    let mut next = base;
    // Per node: how many live triangles it has.
    let mut uses: HashMap<u32, usize> = HashMap::new();
    live.iter().flatten().for_each(|&v| *uses.entry(v).or_default() += 1);
    for m in 0..columns.vertex.len() {
        let s = columns.vertex[m].0;
        let (u, v) = ((roots + 2 * m) as u32, (roots + 2 * m + 1) as u32);
        assert!(uses.remove(&s).is_some(), "update {m}: the star of what splits is empty");
        let mut moved = HashSet::new();
        for (t, corners) in live.iter_mut().enumerate().filter(|(_, c)| c.contains(&s)) {
            let corner = corners.iter().position(|&c| c == s).unwrap();
            corners[corner] = forest.active(columns.triangles[t][corner], m + 1);
            assert!([u, v].contains(&corners[corner]));
            *uses.entry(corners[corner]).or_default() += 1;
            assert!(moved.insert(*corners), "update {m}: two triangles lie on each other after it");
        }
        for _ in 0..columns.added[m] {
            let corners = columns.triangles[next].map(|v| forest.active(v, m + 1));
            assert!(corners.contains(&u) || corners.contains(&v), "update {m} adds a triangle elsewhere");
            assert!(corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]);
            corners.iter().for_each(|&v| *uses.entry(v).or_default() += 1);
            live.push(corners);
            next += 1;
        }
    }
    live.iter().map(|t| t.map(|v| forest.position[v as usize])).collect()
}

/// Triangles as sets of corners, turned so that the least is the first.
fn sorted(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Vec<[[u32; 3]; 3]> {
    let key = |t: [Vec3; 3]| {
        let bits = t.map(|p| p.to_array().map(f32::to_bits));
        let least = (0..3).min_by_key(|&k| bits[k]).unwrap();
        std::array::from_fn(|k| bits[(least + k) % 3])
    };
    let mut all: Vec<_> = triangles.into_iter().map(key).collect();
    all.sort_unstable();
    all
}

fn built(source: &TriangleMesh, options: &VertexPairOptions) -> Columns {
    vertex_pair_columns(source, options, &()).unwrap()
}

fn all_sorts() -> Vec<(&'static str, TriangleMesh)> {
    vec![
        ("scan", sample::scan(1_500)),
        ("several components", defects::several_components(1_500)),
        ("non-manifold edge", defects::non_manifold_edge(1_200)),
        ("bow tie", defects::bow_tie(1_000)),
        ("open sheet", defects::open_sheet(1_000)),
        ("tetrahedron", defects::tetrahedron()),
    ]
}

#[test]
fn columns_replay_to_the_source() {
    for (name, source) in all_sorts() {
        let columns = built(&source, &VertexPairOptions { bits: None, ..VertexPairOptions::default() });
        let corners = |t: &[VertexId; 3]| t.map(|v| source.positions[v.ix()]);
        assert_eq!(sorted(replay(&columns)), sorted(source.triangles.iter().map(corners)), "{name}");
        println!("{name}: {} triangles to {}", source.triangles.len(), columns.base.triangles.len());
    }
}
