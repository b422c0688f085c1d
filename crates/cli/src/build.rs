//! `meshfront build`: from a mesh to a `.front`.

use std::path::Path;

use anyhow::{Context, Result};
use meshfront::hierarchies::edge_collapse::Columns;
use meshfront::mesh::Bounds;
use meshfront::mesh::io::ReadReport;
use meshfront::simplify::edge_collapse_columns;
use meshfront::{EdgeCollapseOptions, format};

use crate::args::{Build, Precision, Threads};
use crate::progress::Phases;
use crate::{input, interrupt, output, text};

pub fn run(args: &Build, quiet: bool) -> Result<()> {
    output::check(&args.output, &[&args.source], args.force)?;
    let phases = Phases::new(quiet);
    let (columns, report) = columns_of(&args.source, args.precision, args.threads, &phases)?;
    phases.start("write");
    let options = format::WriteOptions { overwrite: args.force };
    let written = interrupt::uninterrupted(|| format::write_columns(&args.output, &columns, &options))?;
    let times = phases.finish();
    if !quiet {
        eprintln!("{}", summary(&args.output, &columns, &report, written.bytes, &times));
    }
    Ok(())
}

/// Reads a mesh and builds what is stored of its hierarchy.
pub fn columns_of(
    source: &Path,
    precision: Precision,
    threads: Threads,
    phases: &Phases,
) -> Result<(Columns, ReadReport)> {
    let name = source.display();
    if input::is_front(source)? {
        return Err(output::Usage(format!("{name}: is a hierarchy already; `meshfront view {name}` shows it")).into());
    }
    let pool = threads.pool()?;
    pool.install(|| {
        let source = input::mesh(source, input::Seams::Weld, phases)?;
        let options = EdgeCollapseOptions {
            bits: (!precision.lossless).then_some(precision.bits),
            ..EdgeCollapseOptions::default()
        };
        let columns = edge_collapse_columns(&source.mesh, &options, phases).with_context(|| name.to_string())?;
        Ok((columns, source.report))
    })
}

/// Everything worth knowing about a build, on one line.
fn summary(output: &Path, columns: &Columns, report: &ReadReport, bytes: u64, times: &str) -> String {
    let points: Vec<_> = columns.base.positions.iter().chain(columns.positions.iter().flatten()).copied().collect();
    let diagonal = Bounds::of(&points).map_or(0.0, |b| b.diagonal() as f64);
    let relative = |error: f32| if diagonal > 0.0 { error as f64 / diagonal } else { 0.0 };
    let coarsest = columns.errors.iter().copied().fold(columns.floor_error, f32::max);
    format!(
        "{} from {report}; base mesh of {} triangles; promised error {} to {} ({} to {} of the diagonal); {}, {:.2} \
         bytes per vertex; {times}",
        output.display(),
        text::count(columns.base.triangles.len() as u64),
        text::length(columns.floor_error as f64),
        text::length(coarsest as f64),
        text::percent(relative(columns.floor_error)),
        text::percent(relative(coarsest)),
        text::bytes(bytes),
        bytes as f64 / report.vertices.max(1) as f64,
    )
}
