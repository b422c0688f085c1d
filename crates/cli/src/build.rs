//! `meshfront build`: from a mesh or a height field to a `.front`.

use std::path::Path;

use anyhow::{Context, Result};
use meshfront::hierarchies::edge_collapse;
use meshfront::mesh::Bounds;
use meshfront::mesh::io::height::is_height_format;
use meshfront::refine::MultiTessellation;
use meshfront::simplify::{
    VertexRemovalOptions, edge_collapse_columns, right_triangles_columns, vertex_removal_columns,
};
use meshfront::{
    EdgeCollapseOptions, Model, RightTriangles, RightTrianglesOptions, Stored, TriangleMesh, TriangleModel, format,
};

use crate::args::{Build, Choice, Recipe};
use crate::progress::Phases;
use crate::{input, interrupt, output, text};

/// What was built, and what to say about it.
pub struct Built {
    pub stored: Stored,
    /// The source as it was read.
    report: String,
    /// Why it is of this model, if nobody asked for it.
    because: &'static str,
    source_vertices: u64,
    base_triangles: usize,
    /// Least and greatest promised error, mesh units.
    errors: [f32; 2],
    diagonal: f64,
}

pub fn run(args: &Build, quiet: bool) -> Result<()> {
    output::check(&args.output, &[&args.source], args.force)?;
    let phases = Phases::new(quiet);
    let built = build(&args.source, &args.recipe, &phases)?;
    phases.start("write");
    let options = format::WriteOptions { overwrite: args.force };
    let written = interrupt::uninterrupted(|| format::write(&args.output, &built.stored, &options))?;
    let times = phases.finish();
    if !quiet {
        eprintln!("{}", built.summary(&args.output, written.bytes, &times));
    }
    Ok(())
}

/// Reads a source and builds what is stored of its hierarchy.
pub fn build(source: &Path, recipe: &Recipe, phases: &Phases) -> Result<Built> {
    let name = source.display();
    if input::is_front(source)? {
        return Err(output::Usage(format!("{name}: is a hierarchy already; `meshfront view {name}` shows it")).into());
    }
    let heights = is_height_format(source);
    let (model, because) = match (recipe.model, heights) {
        (Choice::Auto, true) => (Model::RightTriangles, ", since it is a height field"),
        (Choice::Auto, false) => (Model::EdgeCollapse, ", which takes any mesh"),
        (Choice::EdgeCollapse, _) => (Model::EdgeCollapse, ""),
        (Choice::RightTriangles, _) => (Model::RightTriangles, ""),
        (Choice::VertexRemoval, _) => (Model::VertexRemoval, ""),
    };
    recipe.threads.pool()?.install(|| match model {
        Model::RightTriangles if !heights => Err(output::Usage(format!(
            "{name}: is a mesh, and right triangles need a height field ({}); `--model edge_collapse` takes any mesh",
            input::HEIGHT_ENDINGS
        ))
        .into()),
        Model::RightTriangles => terrain(source, recipe, because, phases),
        Model::EdgeCollapse | Model::VertexRemoval => {
            let (mesh, report) = if heights {
                let source = input::heights(source, phases)?;
                phases.start("triangulate");
                (source.field.to_mesh(recipe.exaggeration), source.report.to_string())
            } else {
                let source = input::mesh(source, input::Seams::Weld, phases)?;
                (source.mesh, source.report.to_string())
            };
            let simplify = if model == Model::EdgeCollapse { collapse } else { remove };
            simplify(&mesh, report, recipe, because, phases).with_context(|| name.to_string())
        }
    })
}

fn collapse(mesh: &TriangleMesh, report: String, recipe: &Recipe, because: &'static str, p: &Phases) -> Result<Built> {
    let options = EdgeCollapseOptions { bits: recipe.precision.bits(), ..EdgeCollapseOptions::default() };
    let columns = edge_collapse_columns(mesh, &options, p)?;
    let edge_collapse::Columns { base, positions, errors, floor_error, .. } = &columns;
    let points: Vec<_> = base.positions.iter().chain(positions.iter().flatten()).copied().collect();
    Ok(Built {
        report,
        because,
        source_vertices: mesh.positions.len() as u64,
        base_triangles: base.triangles.len(),
        errors: [*floor_error, errors.iter().copied().fold(*floor_error, f32::max)],
        diagonal: Bounds::of(&points).map_or(0.0, |b| b.diagonal() as f64),
        stored: Stored::EdgeCollapse(columns),
    })
}

fn remove(mesh: &TriangleMesh, report: String, recipe: &Recipe, because: &'static str, p: &Phases) -> Result<Built> {
    let options = VertexRemovalOptions { bits: recipe.precision.bits(), ..VertexRemovalOptions::default() };
    let columns = vertex_removal_columns(mesh, &options, p)?;
    let (errors, floor) = (&columns.errors, columns.floor_error);
    Ok(Built {
        report,
        because,
        source_vertices: mesh.positions.len() as u64,
        base_triangles: columns.base.triangles.len(),
        errors: [floor, errors.iter().copied().fold(floor, f32::max)],
        diagonal: mesh.bounds().map_or(0.0, |b| b.diagonal() as f64),
        stored: Stored::VertexRemoval(columns),
    })
}

fn terrain(source: &Path, recipe: &Recipe, because: &'static str, phases: &Phases) -> Result<Built> {
    let name = || source.display().to_string();
    let source = input::heights(source, phases)?;
    phases.start("quantize");
    let options = RightTrianglesOptions { bits: recipe.precision.bits(), exaggeration: recipe.exaggeration };
    let columns = right_triangles_columns(&source.field, &options).with_context(name)?;
    drop(source.field);
    // Nothing of this is stored; but what cannot be opened must not be written, and people want to know the errors.
    phases.start("measure");
    let hierarchy = RightTriangles::new(columns.clone()).with_context(name)?;
    let mut errors = [hierarchy.floor_error(); 2];
    hierarchy.roots(|m| errors[1] = errors[1].max(hierarchy.footprint(m).error));
    Ok(Built {
        report: source.report.to_string(),
        because,
        source_vertices: hierarchy.source().vertices.into(),
        base_triangles: hierarchy.base_triangles(),
        errors,
        diagonal: hierarchy.bounds().diagonal() as f64,
        stored: Stored::RightTriangles(columns),
    })
}

impl Built {
    /// Everything worth knowing about a build, on one line.
    fn summary(&self, output: &Path, bytes: u64, times: &str) -> String {
        let relative = |error: f32| if self.diagonal > 0.0 { error as f64 / self.diagonal } else { 0.0 };
        let [least, greatest] = self.errors;
        format!(
            "{} from {}; model {}{}; base mesh of {} triangles; promised error {} to {} ({} to {} of the diagonal); {}, \
             {:.2} bytes per vertex; {times}",
            output.display(),
            self.report,
            self.stored.model().name(),
            self.because,
            text::count(self.base_triangles as u64),
            text::length(least as f64),
            text::length(greatest as f64),
            text::percent(relative(least)),
            text::percent(relative(greatest)),
            text::bytes(bytes),
            bytes as f64 / self.source_vertices.max(1) as f64,
        )
    }
}
