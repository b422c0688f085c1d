//! What vertex removal makes of a mesh, beside edge collapse: time, memory, codes, the promise and the quality.
//!
//!     cargo run --release --example vertex_removal -- scan.ply

use meshfront::hierarchies::vertex_removal::{Connectivity, encode};
use meshfront::refine::MultiTessellation;
use meshfront::simplify::{VertexRemovalOptions, vertex_removal};
use meshfront::{
    CompareOptions, EdgeCollapseOptions, Front, Request, TriangleModel, Uniform, compare, edge_collapse, extract_cells,
    promised_error,
};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: vertex_removal MESH")?;
    let source = meshfront::mesh::io::read(&path)?.mesh;
    let samples = CompareOptions { samples: 300_000 };
    let start = Instant::now();
    let h = vertex_removal(&source, &VertexRemovalOptions::default(), &())?;
    println!("built in {:.2?} from {} triangles", start.elapsed(), source.triangles.len());
    let start = Instant::now();
    let e = edge_collapse(&source, &EdgeCollapseOptions::default(), &())?;
    println!("edge collapse in {:.2?}", start.elapsed());
    println!(
        "{} updates on {} triangles, {:.1} bytes per update; edge collapse {:.1}",
        h.len(),
        h.base_mesh().triangles.len(),
        h.memory_bytes() as f64 / h.len() as f64,
        e.memory_bytes() as f64 / e.len() as f64
    );
    for c in Connectivity::ALL {
        let published = c.published_bits().map_or(String::new(), |bits| format!(", the tutorial has {bits}"));
        println!("{c}: {:.2} bits per update{published}", c.mean_bits(&h));
    }
    println!("entropy: {:.2} bits per update", encode::entropy(&h));

    let diagonal = h.bounds().diagonal();
    for share in [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2] {
        let request = Request::tolerance(share * diagonal);
        let (mut ours, mut theirs) = (Front::new(&h), Front::new(&e));
        ours.top_down(&h, &Uniform, &request);
        theirs.top_down(&e, &Uniform, &request);
        let measured = compare(&source, &ours.mesh().buffers.to_mesh(), &samples)?.a_to_b.max as f32;
        println!(
            "{:.2} % of the diagonal: {} triangles, measured over promised {:.3}; edge collapse {} triangles",
            share * 100.0,
            ours.mesh().buffers.live_triangles(),
            measured / promised_error(&h, &ours),
            theirs.mesh().buffers.live_triangles()
        );
    }
    for share in [0.3, 0.1, 0.03, 0.01] {
        let count = (share * source.triangles.len() as f64) as usize;
        let ours = compare(&source, &extract_cells(&h, count).mesh, &samples)?;
        let theirs = compare(&source, &extract_cells(&e, count).mesh, &samples)?;
        println!(
            "{count} triangles: mean distance {:.2} times that of edge collapse, greatest {:.2} times",
            ours.mean() / theirs.mean(),
            ours.max() / theirs.max(),
        );
    }
    Ok(())
}
