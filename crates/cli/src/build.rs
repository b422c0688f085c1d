//! `meshfront build`: from a mesh to a `.front`.

use std::path::Path;

use anyhow::{Context, Result};
use meshfront::mesh::io::ReadReport;
use meshfront::refine::{MultiTessellation, UpdateId};
use meshfront::{EdgeCollapse, EdgeCollapseOptions, edge_collapse, format};

use crate::args::{Build, Precision, Threads};
use crate::progress::Phases;
use crate::{input, interrupt, output, text};

pub fn run(args: &Build, quiet: bool) -> Result<()> {
    output::check(&args.output, &[&args.source], args.force)?;
    let phases = Phases::new(quiet);
    let (hierarchy, report) = hierarchy_of(&args.source, args.precision, args.threads, &phases)?;
    phases.start("write");
    let options = format::WriteOptions { overwrite: args.force };
    let written = interrupt::uninterrupted(|| format::write(&args.output, &hierarchy, &options))?;
    let times = phases.finish();
    if !quiet {
        eprintln!("{}", summary(&args.output, &hierarchy, &report, written.bytes, &times));
    }
    Ok(())
}

/// Reads a mesh and builds its hierarchy.
pub fn hierarchy_of(
    source: &Path,
    precision: Precision,
    threads: Threads,
    phases: &Phases,
) -> Result<(EdgeCollapse, ReadReport)> {
    let name = source.display();
    if input::is_front(source)? {
        return Err(output::Usage(format!("{name}: is a hierarchy already; `meshfront view {name}` shows it")).into());
    }
    let pool = threads.pool()?;
    pool.install(|| {
        let source = input::mesh(source, phases)?;
        let options = EdgeCollapseOptions {
            bits: (!precision.lossless).then_some(precision.bits),
            ..EdgeCollapseOptions::default()
        };
        let hierarchy = edge_collapse(&source.mesh, &options, phases).with_context(|| name.to_string())?;
        Ok((hierarchy, source.report))
    })
}

/// Everything worth knowing about a build, on one line.
fn summary(output: &Path, hierarchy: &EdgeCollapse, report: &ReadReport, bytes: u64, times: &str) -> String {
    let diagonal = hierarchy.bounds().diagonal() as f64;
    let relative = |error: f32| if diagonal > 0.0 { error as f64 / diagonal } else { 0.0 };
    let coarsest =
        (0..hierarchy.len() as u32).map(|m| hierarchy.error(UpdateId(m))).fold(hierarchy.floor_error(), f32::max);
    format!(
        "{} from {report}; base mesh of {} triangles; promised error {} to {} ({} to {} of the diagonal); {}, {:.2} \
         bytes per vertex; {times}",
        output.display(),
        text::count(hierarchy.base_mesh().triangles.len() as u64),
        text::length(hierarchy.floor_error() as f64),
        text::length(coarsest as f64),
        text::percent(relative(hierarchy.floor_error())),
        text::percent(relative(coarsest)),
        text::bytes(bytes),
        bytes as f64 / report.vertices.max(1) as f64,
    )
}
