//! Merges random pairs of vertices, neighbours or not, with no thought of beauty: vertex-pair hierarchies whose stars,
//! sheets and parts do whatever may happen. Errors are bounds that hold, and nothing better.

use crate::random::Random;
use glam::Vec3;
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::vertex_pair::{Columns, Grid, Oct};
use meshfront_mesh::{TriangleMesh, VertexId};
use std::collections::{BTreeMap, BTreeSet};

/// How to merge.
#[derive(Clone, Copy, Debug)]
pub struct Merging {
    /// Bits of the grid of positions; `None`: lossless.
    pub bits: Option<u32>,
    /// Stop before fewer triangles than these are left.
    pub base_triangles: usize,
    /// One in so many merges joins any two vertices; the others join neighbours.
    pub far: usize,
    /// Of the random numbers.
    pub seed: u64,
}

#[derive(Clone, Copy)]
struct Node {
    position: Vec3,
    normal: Oct,
    color: [u8; 4],
    /// No leaf below is farther away.
    reach: f32,
}

/// A merge, and what was around at that moment.
struct Merge {
    children: [usize; 2],
    /// The neighbours of the merged node, by edges of the source: seen or not.
    ring: BTreeSet<usize>,
    /// Whether a neighbour, or the node itself, is at no live triangle of it.
    blind: bool,
    /// The triangles that go.
    gone: Vec<usize>,
}

/// Columns of a hierarchy over a source. Looks at all triangles for each merge.
pub fn merge(mesh: &TriangleMesh, options: &Merging) -> Columns {
    let mut random = Random::new(options.seed);
    let grid = options.bits.map(|bits| Grid::fit(mesh.bounds().expect("a source has vertices"), bits));
    let snap = |p: Vec3| grid.map_or(p, |grid| grid.snap(p));
    let (normals, colors) = (&mesh.vertex.normals, &mesh.vertex.colors);
    let mut nodes: Vec<Node> = (0..mesh.positions.len())
        .map(|v| Node {
            position: snap(mesh.positions[v]),
            normal: normals.get(v).map_or(Oct::default(), |&n| Oct::encode(n)),
            color: colors.get(v).copied().unwrap_or_default(),
            reach: 0.0,
        })
        .collect();
    let leaves = nodes.len();
    let mut above: Vec<usize> = (0..leaves).collect();
    let mut active: Vec<usize> = above.clone();
    let mut merges: Vec<Merge> = vec![];
    let corners = |above: &[usize], t: usize| mesh.triangles[t].map(|v| above[v.ix()]);
    let is_live = |[a, b, c]: [usize; 3]| a != b && b != c && c != a;
    let mut live: Vec<usize> = (0..mesh.triangles.len()).collect();
    while active.len() > 2 {
        let [u, v] = if random.below(options.far) == 0 {
            [0; 2].map(|_| active[random.below(active.len())])
        } else {
            let t = corners(&above, live[random.below(live.len())]);
            let k = random.below(3);
            [t[k], t[(k + 1) % 3]]
        };
        let has = |t: usize, x: usize| corners(&above, t).contains(&x);
        let (gone, stay): (Vec<usize>, Vec<usize>) = live.iter().partition(|&&t| has(t, u) && has(t, v));
        if u == v {
            continue;
        }
        if stay.len() < options.base_triangles.max(1) {
            break;
        }
        live = stay;
        let s = nodes.len();
        let (a, b) = (nodes[u], nodes[v]);
        let middle = (a.position + b.position) * 0.5;
        let position = [a.position, b.position, snap(middle)][random.below(3)];
        let reach = [a, b].map(|n| n.position.distance(position) + n.reach).into_iter().fold(0.0, f32::max);
        nodes.push(Node { position, reach: reach * 1.000_01, ..a });
        above.iter_mut().filter(|x| **x == u || **x == v).for_each(|x| *x = s);
        active.retain(|&x| x != u && x != v);
        active.push(s);
        let (mut ring, mut seen) = (BTreeSet::new(), BTreeSet::new());
        for t in 0..mesh.triangles.len() {
            let t = corners(&above, t);
            if t.contains(&s) {
                let others = t.into_iter().filter(|&x| x != s);
                if is_live(t) {
                    seen.extend(others.clone());
                }
                ring.extend(others);
            }
        }
        let blind = seen.is_empty() || seen != ring;
        merges.push(Merge { children: [u, v], ring, blind, gone });
    }

    // Numbers of nodes and updates: coarse to fine.
    let (updates, roots) = (merges.len(), active.len());
    let update = |k: usize| updates - 1 - k;
    let mut number = vec![VertexId(0); nodes.len()];
    active.iter().enumerate().for_each(|(i, &x)| number[x] = VertexId(i as u32));
    let mut maker = BTreeMap::new();
    for (k, merge) in merges.iter().enumerate() {
        for (which, &x) in merge.children.iter().enumerate() {
            number[x] = VertexId((roots + 2 * update(k) + which) as u32);
            maker.insert(x, update(k));
        }
    }
    // What is not seen may be as far from the mesh as the source is wide.
    let wide = mesh.bounds().expect("a source has vertices").diagonal() * 1.01;
    let floor_error = grid.map_or(0.0, |grid| grid.step as f32 * 0.87);
    let mut errors = vec![0.0f32; updates];
    for (k, merge) in merges.iter().enumerate() {
        let own = if merge.blind { wide } else { nodes[leaves + k].reach } + floor_error;
        let error = errors[update(k)].max(own);
        errors[update(k)] = error;
        for n in merge.ring.iter().chain([&(leaves + k)]).filter_map(|x| maker.get(x)) {
            errors[*n] = errors[*n].max(error);
        }
    }
    let coarse = merges.iter().enumerate().rev();
    let pair = |f: &dyn Fn(usize) -> Vec3| coarse.clone().map(|(_, merge)| merge.children.map(f)).collect();
    let of = |list: &[usize]| list.iter().map(|&t| mesh.triangles[t].map(|v| number[v.ix()])).collect::<Vec<_>>();
    let own = |keep: bool, column: Vec<_>| if keep { column } else { vec![] };
    let mut base = TriangleMesh {
        positions: active.iter().map(|&x| nodes[x].position).collect(),
        triangles: live.iter().map(|&t| corners(&above, t).map(|x| number[x])).collect(),
        ..TriangleMesh::default()
    };
    base.vertex.normals = own(!normals.is_empty(), active.iter().map(|&x| nodes[x].normal.decode()).collect());
    base.vertex.colors = if colors.is_empty() { vec![] } else { active.iter().map(|&x| nodes[x].color).collect() };
    let children = coarse.clone().map(|(_, merge)| merge.children);
    Columns {
        grid,
        base,
        triangles: of(&live).into_iter().chain(coarse.clone().flat_map(|(_, merge)| of(&merge.gone))).collect(),
        added: coarse.clone().map(|(_, merge)| merge.gone.len() as u32).collect(),
        vertex: coarse.clone().map(|(k, _)| number[leaves + k]).collect(),
        positions: pair(&|x| nodes[x].position),
        normals: if normals.is_empty() {
            vec![]
        } else {
            children.clone().map(|c| c.map(|x| nodes[x].normal)).collect()
        },
        colors: if colors.is_empty() { vec![] } else { children.map(|c| c.map(|x| nodes[x].color)).collect() },
        errors,
        floor_error,
        source: SourceCounts { vertices: leaves as u32, triangles: mesh.triangles.len() as u32 },
    }
}
