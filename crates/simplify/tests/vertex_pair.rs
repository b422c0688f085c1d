//! Columns of vertex pairs, replayed here from what their documentation says, without the hierarchy's own code.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use glam::{Vec2, Vec3};
use meshfront_hierarchies::vertex_pair::Columns;
use meshfront_mesh::sample::{self, defects};
use meshfront_mesh::{TriangleMesh, VertexId};
use meshfront_simplify::metrics::MetricChoice;
use meshfront_simplify::{BuildError, Pairs, Progress, VertexPairOptions, vertex_pair_columns};

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

/// Replays all updates, and shows the mesh of positions after each, the base mesh first.
fn replay(columns: &Columns, mut show: impl FnMut(usize, Box<dyn Iterator<Item = [Vec3; 3]> + '_>)) {
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
    let at = |t: &[u32; 3]| t.map(|v| forest.position[v as usize]);
    show(0, Box::new(live.iter().map(at)));
    for m in 0..columns.vertex.len() {
        let s = columns.vertex[m].0;
        let (u, v) = ((roots + 2 * m) as u32, (roots + 2 * m + 1) as u32);
        let mut moved = HashSet::new();
        let mut around = HashSet::new();
        for (t, corners) in live.iter_mut().enumerate().filter(|(_, c)| c.contains(&s)) {
            let corner = corners.iter().position(|&c| c == s).unwrap();
            corners[corner] = forest.active(columns.triangles[t][corner], m + 1);
            assert!([u, v].contains(&corners[corner]));
            around.extend(*corners);
            corners.rotate_left(corner);
            assert!(moved.insert(*corners), "update {m}: two triangles lie on each other after it");
            corners.rotate_right(corner);
        }
        assert!(!moved.is_empty(), "update {m}: the star of what splits is empty");
        for _ in 0..columns.added[m] {
            let corners = columns.triangles[next].map(|v| forest.active(v, m + 1));
            assert!(corners.contains(&u) || corners.contains(&v), "update {m} adds a triangle elsewhere");
            assert!(corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]);
            around.extend(corners);
            live.push(corners);
            next += 1;
        }
        // What made the corners of the cells before and after is at least as wrong.
        for x in around.into_iter().chain([s]).filter(|&x| x >= roots as u32 && x != u && x != v) {
            let maker = (x as usize - roots) / 2;
            assert!(columns.errors[maker] >= columns.errors[m], "update {m} is worse than {maker}, which it needs");
        }
        show(m + 1, Box::new(live.iter().map(at)));
    }
}

/// The mesh after all updates.
fn finest(columns: &Columns) -> Vec<[Vec3; 3]> {
    let mut mesh = vec![];
    replay(columns, |applied, triangles| {
        if applied == columns.vertex.len() {
            mesh = triangles.collect();
        }
    });
    mesh
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

/// How many pieces hang together by vertices; vertices are positions.
fn pieces(triangles: &[[Vec3; 3]]) -> usize {
    let mut left: Vec<[[u32; 3]; 3]> = triangles.iter().map(|t| t.map(|p| p.to_array().map(f32::to_bits))).collect();
    let mut pieces = 0;
    while let Some(first) = left.pop() {
        pieces += 1;
        let mut frontier = first.to_vec();
        while let Some(x) = frontier.pop() {
            left.retain(|t| {
                let meets = t.contains(&x);
                if meets {
                    frontier.extend(t);
                }
                !meets
            });
        }
    }
    pieces
}

fn base_of(columns: &Columns) -> Vec<[Vec3; 3]> {
    columns.base.triangles.iter().map(|t| t.map(|v| columns.base.positions[v.ix()])).collect()
}

#[test]
fn columns_replay_to_the_source() {
    let plain = VertexPairOptions { bits: None, ..VertexPairOptions::default() };
    let length = VertexPairOptions { metric: MetricChoice::Length, ..plain.clone() };
    let geometry_first = VertexPairOptions { pairs: Pairs::GeometryFirst, ..plain.clone() };
    for (name, source) in all_sorts() {
        let corners = |t: &[VertexId; 3]| t.map(|v| source.positions[v.ix()]);
        for options in [&plain, &length, &geometry_first] {
            let columns = built(&source, options);
            assert_eq!(sorted(finest(&columns)), sorted(source.triangles.iter().map(corners)), "{name}, {options:?}");
            assert!(columns.base.triangles.len() <= 20, "{name}, {options:?}");
            assert_eq!((columns.floor_error, columns.source.triangles as usize), (0.0, source.triangles.len()));
        }
    }
}

#[test]
fn parts_stay_until_they_join() {
    let source = defects::several_components(1_500);
    let alone =
        VertexPairOptions { base_triangles: 0, longest_virtual: 0.0, bits: None, ..VertexPairOptions::default() };
    let columns = built(&source, &alone);
    // Two triangles back to back are the least that is left of something closed.
    assert_eq!((pieces(&base_of(&columns)), columns.base.triangles.len()), (4, 8));
    finest(&columns);
    let joined = built(&source, &VertexPairOptions { longest_virtual: 1.0, ..alone });
    assert_eq!(pieces(&base_of(&joined)), 1);
    assert!(joined.base.triangles.len() <= 2);
    finest(&joined);
}

#[test]
fn geometry_first_keeps_the_topology_for_as_long_as_it_can() {
    let source = defects::several_components(1_500);
    let options = VertexPairOptions { pairs: Pairs::GeometryFirst, base_triangles: 16, ..VertexPairOptions::default() };
    // Four closed pieces have sixteen triangles at the least, where they stay as they are.
    let kept = built(&source, &options);
    assert_eq!((pieces(&base_of(&kept)), kept.base.triangles.len(), kept.base.positions.len()), (4, 16, 16));
    let further = built(&source, &VertexPairOptions { base_triangles: 4, ..options.clone() });
    assert!(further.base.triangles.len() <= 4);
    // A thin tube stays one: as many vertices and triangles as edges, each with two triangles.
    let tube = built(&sample::knot(1_500), &VertexPairOptions { base_triangles: 80, ..options });
    let mut edges: Vec<[u32; 2]> = vec![];
    for t in &tube.base.triangles {
        edges.extend([(0, 1), (1, 2), (2, 0)].map(|(i, j)| [t[i].0.min(t[j].0), t[i].0.max(t[j].0)]));
    }
    edges.sort_unstable();
    assert!(edges.chunk_by(|a, b| a == b).all(|uses| uses.len() == 2));
    assert_eq!(tube.base.positions.len() + tube.base.triangles.len(), edges.len() / 2);
}

#[test]
fn triangles_that_come_to_lie_on_each_other_go_but_for_one() {
    // Two fans of three around the same three corners, their tips near each other: where the tips merge, one fan is left.
    let corners = (0..3).map(|k| Vec2::from_angle(k as f32 * 2.0944).extend(0.0));
    let tips = [Vec3::Z * 0.5, Vec3::Z * 0.501];
    let positions: Vec<Vec3> = corners.chain(tips).collect();
    let fan = |tip: u32| (0..3u32).map(move |k| [tip, k, (k + 1) % 3].map(VertexId));
    let triangles: Vec<[VertexId; 3]> = fan(3).chain(fan(4)).collect();
    let source = TriangleMesh { positions, triangles, ..TriangleMesh::default() };
    let options = VertexPairOptions { bits: None, base_triangles: 3, ..VertexPairOptions::default() };
    let columns = built(&source, &options);
    assert_eq!((columns.vertex.len(), &columns.added[..], columns.base.triangles.len()), (1, &[3][..], 3));
    assert_eq!(sorted(finest(&columns)).len(), 6);
    assert!(columns.errors[0] < 0.003, "{}", columns.errors[0]);
    // Turned the other way round, they are the two sides of a sheet: both stay.
    let mut closed = source;
    closed.triangles[3..].iter_mut().for_each(|t| t.swap(1, 2));
    let columns = built(&closed, &VertexPairOptions { base_triangles: 6, ..options });
    assert_eq!((columns.vertex.len(), columns.base.triangles.len()), (0, 6));
    let columns = built(&closed, &VertexPairOptions { bits: None, base_triangles: 5, ..VertexPairOptions::default() });
    assert_eq!((columns.added.first(), columns.base.triangles.len()), (Some(&2), 4), "a tip merged with a corner");
}

#[test]
fn nothing_that_is_flat_folds_over() {
    let mut source = defects::open_sheet(1_500);
    let spacing = 1.0 / (source.positions.len() as f32).sqrt();
    for (i, p) in source.positions.iter_mut().enumerate() {
        // Off its place by up to a third of the way to the next, so that triangles are of all shapes.
        let off = |k: u32| ((i as u32 * 2 + k).wrapping_mul(0x9e37_79b9) >> 16) as f32 / 65536.0 - 0.5;
        let inside = |x: f32| x > 0.0 && x < 1.0;
        let shift = if inside(p.x) && inside(p.z) { 0.6 * spacing } else { 0.0 };
        *p = Vec3::new(p.x + shift * off(0), 0.0, p.z + shift * off(1));
    }
    let columns = built(&source, &VertexPairOptions { bits: None, base_triangles: 10, ..VertexPairOptions::default() });
    replay(&columns, |applied, mut triangles| {
        if applied % 10 == 0 {
            let turned = triangles.find(|[a, b, c]| (*b - *a).cross(*c - *a).y < 0.0);
            assert_eq!(turned, None, "after {applied} updates");
        }
    });
    assert!(columns.base.triangles.len() <= 10);
    assert!(columns.errors.iter().all(|e| *e < 1e-3 || *e > 0.01), "the inside costs nothing");
}

#[test]
fn threads_change_nothing_and_anybody_may_stop() {
    let source = defects::several_components(2_000);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| built(&source, &VertexPairOptions::default()))
    };
    let one = on(1);
    assert_eq!(one, on(3));

    /// Gives up when a phase begins.
    struct Stop(&'static str, AtomicBool);
    impl Progress for Stop {
        fn phase(&self, name: &'static str, _: &'static str, _: u64) {
            self.1.fetch_or(name == self.0, Relaxed);
        }
        fn at(&self, _: u64) {}
        fn cancelled(&self) -> bool {
            self.1.load(Relaxed)
        }
    }
    for phase in ["simplify", "measure"] {
        let stopped = vertex_pair_columns(&source, &VertexPairOptions::default(), &Stop(phase, AtomicBool::new(false)));
        assert!(matches!(stopped, Err(BuildError::Cancelled)));
    }
    let nothing = vertex_pair_columns(&TriangleMesh::default(), &VertexPairOptions::default(), &());
    assert!(matches!(nothing, Err(BuildError::Empty)));
}
