//! From a mesh file to a hierarchy on disk, and to a small mesh with a promise:
//!
//!     cargo run --release --example build_and_extract -- scan.ply

use meshfront::mesh::io;
use meshfront::{
    CompareOptions, EdgeCollapseOptions, Request, TriangleModel, Uniform, compare, edge_collapse, extract, format,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: build_and_extract MESH")?;
    let source = io::read(&path)?;
    println!("{path}: {}", source.report);

    let hierarchy = edge_collapse(&source.mesh, &EdgeCollapseOptions::default(), &())?;
    let written = format::write("out.front", &hierarchy.stored(), &format::WriteOptions { overwrite: true })?;
    println!("out.front: {} bytes", written.bytes);

    // At most a thousandth of the diagonal away from the source.
    let tolerance = 1e-3 * hierarchy.bounds().diagonal();
    let coarse = extract(&hierarchy, &Uniform, &Request::tolerance(tolerance));
    io::write("out.ply", &coarse.mesh, io::WriteOptions { overwrite: true })?;
    println!("out.ply: {} triangles, promised within {}", coarse.mesh.triangles.len(), coarse.error);

    let measured = compare(&source.mesh, &coarse.mesh, &CompareOptions::default())?;
    println!("measured: {} at {}", measured.a_to_b.max, measured.a_to_b.farthest);
    Ok(())
}
