//! `meshfront sample`: meshes and height fields by procedure.

use anyhow::Result;
use meshfront::mesh::io::height::{HeightFormat, is_height_format};
use meshfront::mesh::sample::{self, Sample};

use crate::args::MakeSample;
use crate::progress::Phases;
use crate::{output, text};

pub fn run(args: &MakeSample, quiet: bool) -> Result<()> {
    let sample: Sample = args.name.parse()?;
    if is_height_format(&args.output) {
        return run_heights(sample, args, quiet);
    }
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

/// Writes a terrain as heights: the square grid that comes nearest to so many triangles.
fn run_heights(sample: Sample, args: &MakeSample, quiet: bool) -> Result<()> {
    let name = args.output.display();
    let format = HeightFormat::from_path(&args.output);
    if sample != Sample::Terrain {
        let message = format!("{name}: holds heights, and only terrain has them; name the output .ply for a {sample}");
        return Err(output::Usage(message).into());
    }
    if format == Some(HeightFormat::UsgsDem) {
        return Err(
            output::Usage(format!("{name}: USGS DEM is not written; name the output .tif, .asc or .png")).into()
        );
    }
    output::check(&args.output, &[], args.force)?;
    let phases = Phases::new(quiet);
    phases.start("make");
    let side = ((args.triangles as f64 / 2.0).sqrt().round() as u32).max(1) + 1;
    let mut field = sample::terrain_heights(side, side);
    if format == Some(HeightFormat::Png) {
        // An image holds whole numbers only.
        field.heights.iter_mut().for_each(|height| *height = height.round());
        field.step = Some(1.0);
    }
    phases.start("write");
    let length = output::write_heights(&args.output, &field, args.force)?;
    phases.finish();
    if !quiet {
        let (samples, side) = (text::count(field.heights.len() as u64), text::count(side));
        eprintln!("{name}: {side} × {side} heights, {samples} samples 30 m apart, {}", text::bytes(length));
    }
    Ok(())
}
