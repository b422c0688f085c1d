//! `meshfront sample`: meshes by procedure.

use anyhow::Result;
use meshfront::mesh::sample::Sample;

use crate::args::MakeSample;
use crate::progress::Phases;
use crate::{output, text};

pub fn run(args: &MakeSample, quiet: bool) -> Result<()> {
    let sample: Sample = args.name.parse()?;
    output::check_mesh_name(&args.output)?;
    output::check(&args.output, &[], args.force)?;
    let phases = Phases::new(quiet);
    phases.start("make");
    let mesh = sample.make(args.triangles);
    phases.start("write");
    let length = output::write_mesh(&args.output, &mesh, args.force)?;
    phases.finish();
    if !quiet {
        let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
        let (vertices, triangles) = (text::count(vertices), text::count(triangles));
        eprintln!("{}: {vertices} vertices, {triangles} triangles, {}", args.output.display(), text::bytes(length));
    }
    Ok(())
}
