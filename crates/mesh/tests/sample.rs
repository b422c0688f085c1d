//! The procedural meshes are what their table says: looked at through edges counted here.

use std::collections::HashMap;

use glam::Vec3;
use meshfront_mesh::sample::{self, Sample, defects};
use meshfront_mesh::{TriangleMesh, VertexId};

/// What can be counted of a mesh without trusting who made it.
#[derive(Debug)]
struct Census {
    /// V - E + F
    euler: i64,
    boundary_edges: usize,
    /// Edges with three or more triangles.
    crowded_edges: usize,
    /// Edges whose two triangles run along them in the same direction.
    flipped_edges: usize,
    boundary_loops: usize,
    components: usize,
    /// Vertices whose triangles form more than one fan.
    bow_ties: usize,
    volume: f64,
}

fn census(mesh: &TriangleMesh) -> Census {
    let mut edges: HashMap<(u32, u32), Vec<bool>> = HashMap::new();
    let mut used = vec![false; mesh.positions.len()];
    for t in &mesh.triangles {
        assert!(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        for i in 0..3 {
            let (a, b) = (t[i].0, t[(i + 1) % 3].0);
            used[a as usize] = true;
            edges.entry((a.min(b), a.max(b))).or_default().push(a < b);
        }
    }
    assert!(used.iter().all(|&u| u), "every vertex is used");
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    let boundary: Vec<_> = edges.iter().filter(|(_, s)| s.len() == 1).map(|(&e, _)| e).collect();
    let v = mesh.positions.len();
    // Fans: corners joined across the edges they share at their vertex.
    let mut corners = Union::new(3 * mesh.triangles.len());
    let mut at_edge: HashMap<(u32, u32), usize> = HashMap::new();
    for (t, ids) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            for other in [ids[(i + 1) % 3], ids[(i + 2) % 3]] {
                let first = *at_edge.entry((ids[i].0, other.0)).or_insert(3 * t + i);
                corners.join(first, 3 * t + i);
            }
        }
    }
    let mut fans = vec![0; v];
    for c in 0..3 * mesh.triangles.len() {
        if corners.root(c) == c {
            fans[mesh.triangles[c / 3][c % 3].ix()] += 1;
        }
    }
    let volume = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.triangles[t].map(|v: VertexId| mesh.positions[v.ix()].as_dvec3());
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    Census {
        euler: v as i64 - edges.len() as i64 + mesh.triangles.len() as i64,
        boundary_edges: boundary.len(),
        crowded_edges: edges.values().filter(|s| s.len() > 2).count(),
        flipped_edges: edges.values().filter(|s| s.len() == 2 && s[0] == s[1]).count(),
        boundary_loops: {
            let mut loops = Union::new(v);
            let mut on = vec![false; v];
            for &(a, b) in &boundary {
                loops.join(a as usize, b as usize);
                on[a as usize] = true;
                on[b as usize] = true;
            }
            (0..v).filter(|&i| on[i] && loops.root(i) == i).count()
        },
        components: {
            let mut parts = Union::new(v);
            edges.keys().for_each(|&(a, b)| parts.join(a as usize, b as usize));
            (0..v).filter(|&i| parts.root(i) == i).count()
        },
        bow_ties: fans.iter().filter(|&&n| n > 1).count(),
        volume,
    }
}

struct Union(Vec<usize>);
impl Union {
    fn new(n: usize) -> Union {
        Union((0..n).collect())
    }
    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
    }
}

#[test]
fn samples_have_about_the_wanted_size_and_are_repeatable() {
    for sample in Sample::ALL {
        // 200 parts cannot be made of 3,000 triangles, and each step in roundness is a step in all of them.
        let sizes = if sample == Sample::Assembly { [25_000, 50_000, 100_000] } else { [500, 3_000, 20_000] };
        for wanted in sizes {
            let mesh = sample.make(wanted);
            let off = mesh.triangles.len().abs_diff(wanted) as f64;
            let allowed = match sample {
                Sample::Scan if wanted < 3_000 => 0.3 * wanted as f64,
                Sample::Assembly => 0.15 * wanted as f64,
                _ => 0.0,
            };
            assert!(off <= allowed + 0.02 * wanted as f64 + 4.0 * (wanted as f64).sqrt(), "{sample} {wanted}: {off}");
            assert_eq!(mesh, sample.make(wanted));
            assert_eq!(sample.name().parse(), Ok(sample));
        }
        for tiny in 0..40 {
            census(&sample.make(tiny));
        }
    }
    assert!("cube".parse::<Sample>().unwrap_err().to_string().contains("terrain"));
}

#[test]
fn sphere_is_a_closed_unit_sphere_facing_out() {
    let mesh = sample::sphere(8_000);
    let c = census(&mesh);
    assert_eq!((c.euler, c.boundary_edges, c.crowded_edges, c.flipped_edges, c.bow_ties), (2, 0, 0, 0, 0));
    assert!(mesh.positions.iter().all(|p| (p.length() - 1.0).abs() < 1e-6));
    assert!((c.volume - 4.0 / 3.0 * std::f64::consts::PI).abs() < 0.02, "{}", c.volume);
}

#[test]
fn knot_is_a_closed_tube_facing_out() {
    let mesh = sample::knot(8_000);
    let c = census(&mesh);
    assert_eq!((c.euler, c.boundary_edges, c.crowded_edges, c.flipped_edges), (0, 0, 0, 0));
    assert!(c.volume > 0.0);
    // The frame does not twist or jump: no edge is much longer than the rings are apart.
    let longest = (mesh.triangles.iter())
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| mesh.positions[a.ix()].distance(mesh.positions[b.ix()]))
        .fold(0.0, f32::max);
    assert!(longest < 0.4, "{longest}");
}

#[test]
fn terrain_is_a_sheet_facing_up() {
    let mesh = sample::terrain(5_000);
    let c = census(&mesh);
    assert_eq!((c.euler, c.boundary_edges, c.boundary_loops, c.flipped_edges), (1, 200, 1, 0));
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v.ix()]);
        assert!((b - a).cross(c - a).y > 0.0);
    }
    let heights = mesh.bounds().unwrap();
    assert!((0.1..1.0).contains(&(heights.max.y - heights.min.y)));
}

#[test]
fn scan_is_one_shell_with_five_holes() {
    for wanted in [2_000, 20_000] {
        let c = census(&sample::scan(wanted));
        assert_eq!((c.components, c.boundary_loops, c.crowded_edges, c.flipped_edges), (1, 5, 0, 0), "{wanted}");
        assert_eq!((c.euler, c.bow_ties), (2 - 5, 0), "{wanted}");
        assert!(c.volume > 1.0);
    }
}

#[test]
fn assembly_is_two_hundred_closed_parts_that_do_not_touch() {
    for wanted in [0, 40_000] {
        let mesh = sample::assembly(wanted);
        let c = census(&mesh);
        assert_eq!((c.components, c.boundary_edges, c.crowded_edges, c.flipped_edges, c.bow_ties), (200, 0, 0, 0, 0));
        // Nine holes go through each of forty plates, one through each of twenty bushings.
        assert_eq!(c.euler, 2 * 200 - 2 * (40 * 9 + 20));
        let mut part = Union::new(mesh.positions.len());
        mesh.triangles.iter().for_each(|t| (1..3).for_each(|k| part.join(t[0].ix(), t[k].ix())));
        let mut volumes: HashMap<usize, f64> = HashMap::new();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v: VertexId| mesh.positions[v.ix()].as_dvec3());
            *volumes.entry(part.root(t[0].ix())).or_default() += a.dot(b.cross(c)) / 6.0;
        }
        assert!(volumes.values().all(|v| *v > 0.0), "each part faces out");
        let mut along: Vec<usize> = (0..mesh.positions.len()).collect();
        let at = |v: usize| mesh.positions[v];
        along.sort_by(|a, b| at(*a).x.total_cmp(&at(*b).x));
        for (i, &a) in along.iter().enumerate() {
            for &b in along[i + 1..].iter().take_while(|b| at(**b).x - at(a).x < 0.004) {
                assert!(part.root(a) == part.root(b) || at(a).distance(at(b)) > 0.004);
            }
        }
    }
}

#[test]
fn paint_gives_unit_normals_that_point_outwards() {
    let mut mesh = sample::sphere(2_000);
    sample::paint(&mut mesh);
    assert_eq!(mesh.vertex.colors.len(), mesh.positions.len());
    for (n, p) in mesh.vertex.normals.iter().zip(&mesh.positions) {
        assert!((n.length() - 1.0).abs() < 1e-5 && n.dot(*p) > 0.99);
    }
}

#[test]
fn defects_are_the_defects_they_name() {
    let c = census(&defects::several_components(2_000));
    assert_eq!((c.components, c.boundary_edges, c.euler, c.flipped_edges), (4, 0, 8, 0));

    let c = census(&defects::non_manifold_edge(600));
    assert_eq!((c.components, c.crowded_edges, c.bow_ties), (1, 10, 0));

    let mesh = defects::bow_tie(1_000);
    let c = census(&mesh);
    assert_eq!((c.components, c.bow_ties, c.boundary_edges, c.crowded_edges, c.flipped_edges), (1, 1, 0, 0, 0));
    assert!((c.volume - 8.0 / 3.0 * std::f64::consts::PI).abs() < 0.5, "{}", c.volume);
    assert!(mesh.bounds().unwrap().max.abs_diff_eq(Vec3::new(1.0, 1.0, 3.0), 1e-5));

    let c = census(&defects::open_sheet(200));
    assert_eq!((c.components, c.boundary_loops, c.euler, c.boundary_edges), (1, 1, 1, 40));

    let c = census(&defects::tetrahedron());
    assert_eq!((c.euler, c.boundary_edges, c.flipped_edges), (2, 0, 0));
    assert!(c.volume > 0.0);
}

#[test]
fn terrain_heights_are_hills_and_windows_of_one_terrain() {
    let field = sample::terrain_heights(700, 500);
    assert_eq!((field.columns, field.rows, field.heights.len()), (700, 500, 350_000));
    assert!(field.heights.iter().all(|h| (0.0..2400.0).contains(h)));
    let (least, most) = field.heights.iter().fold((f32::MAX, f32::MIN), |(a, b), &h| (a.min(h), b.max(h)));
    assert!((300.0..1500.0).contains(&(most - least)), "{least} to {most}");
    let window = sample::terrain_heights(33, 257);
    assert!((0..257).all(|row| (0..33).all(|column| window.height(column, row) == field.height(column, row))));
    // No seam shows between the cells of any lattice: slopes across are as along, and as inside.
    let mean = |pairs: &mut dyn Iterator<Item = f32>| {
        let (sum, count) = pairs.fold((0.0, 0), |(sum, count), d| (sum + f64::from(d.abs()), count + 1));
        sum / f64::from(count) / 30.0
    };
    let slope = |a: (u32, u32), b: (u32, u32)| field.height(a.0, a.1) - field.height(b.0, b.1);
    let across = mean(&mut (0..500).map(|row| slope((256, row), (255, row))));
    let along = mean(&mut (1..500).map(|row| slope((256, row), (256, row - 1))));
    let inside = mean(&mut (0..500).map(|row| slope((300, row), (299, row))));
    for slope in [across, along, inside] {
        assert!((0.03..0.2).contains(&slope), "slopes {across} {along} {inside}");
    }
}
