//! `meshfront build`: from a mesh or a height field to a `.front`.

use std::path::Path;

use anyhow::{Context, Result};
use meshfront::mesh::io::height::is_height_format;
use meshfront::refine::MultiTessellation;
use meshfront::simplify::{
    VertexRemovalOptions, edge_collapse_columns, right_triangles_columns, vertex_pair_columns, vertex_removal_columns,
};
use meshfront::{
    EdgeCollapseOptions, Model, RightTriangles, RightTrianglesOptions, Stored, Survey, TriangleMesh, TriangleModel,
    format, survey,
};

use crate::args::{Build, Choice, Code, Recipe};
use crate::progress::Phases;
use crate::{input, interrupt, output, text};

/// What was built, and what to say about it.
pub struct Built {
    pub stored: Stored,
    /// The source as it was read.
    report: String,
    /// Why it is of this model, if nobody asked for it.
    because: String,
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

/// Builds a file that nobody else knows of, as `meshfront build` does without options.
pub fn build_plainly(source: &Path, front: &Path, phases: &Phases) -> Result<()> {
    let built = build(source, &Recipe::PLAIN, phases)?;
    phases.start("write");
    interrupt::uninterrupted(|| format::write(front, &built.stored, &format::WriteOptions::default()))?;
    phases.finish();
    Ok(())
}

/// Reads a source and builds what is stored of its hierarchy.
pub fn build(source: &Path, recipe: &Recipe, phases: &Phases) -> Result<Built> {
    let name = source.display();
    if input::is_front(source)? {
        return Err(output::Usage(format!("{name}: is a hierarchy already; `meshfront view {name}` shows it")).into());
    }
    let heights = is_height_format(source);
    let asked = match recipe.model {
        Choice::Auto => heights.then_some(Model::RightTriangles),
        Choice::EdgeCollapse => Some(Model::EdgeCollapse),
        Choice::RightTriangles => Some(Model::RightTriangles),
        Choice::VertexPair => Some(Model::VertexPair),
        Choice::VertexRemoval => Some(Model::VertexRemoval),
    };
    if let Some(option) = recipe.pairing.given().filter(|_| asked.is_some_and(|m| m != Model::VertexPair)) {
        return Err(output::Usage(format!("{option} is for vertex pairs: add `--model vertex_pair`")).into());
    }
    if recipe.connectivity.is_some() && asked != Some(Model::VertexRemoval) {
        let advice = "--connectivity is for vertex removal: add `--model vertex_removal`";
        return Err(output::Usage(advice.into()).into());
    }
    recipe.threads.pool()?.install(|| match asked {
        Some(Model::RightTriangles) if !heights => Err(output::Usage(format!(
            "{name}: is a mesh, and right triangles need a height field ({}); `--model edge_collapse` takes any mesh",
            input::HEIGHT_ENDINGS
        ))
        .into()),
        Some(Model::RightTriangles) => terrain(source, recipe, phases),
        _ => {
            let (mesh, report) = if heights {
                let source = input::heights(source, phases)?;
                phases.start("triangulate");
                (source.field.to_mesh(recipe.exaggeration), source.report.to_string())
            } else {
                let source = input::mesh(source, input::Seams::Weld, phases)?;
                (source.mesh, source.report.to_string())
            };
            let (model, because) = match asked {
                Some(model) => (model, String::new()),
                None if recipe.pairing.given().is_some() => (Model::VertexPair, ", as its options say".to_owned()),
                None => {
                    phases.start("survey");
                    best_model(&survey(&mesh))
                }
            };
            simplify(&mesh, report, model, because, recipe, phases).with_context(|| name.to_string())
        }
    })
}

/// What serves a mesh best, and why.
///
/// Where the topology stays, edge collapse has as many triangles at the same error or fewer, in a quarter of the time. Pairs need
/// half as many where sheets share edges, and a few in a hundred where many parts have come down to what their topology allows.
fn best_model(survey: &Survey) -> (Model, String) {
    /// No closed piece has fewer triangles.
    const LEAST: usize = 4;
    let least = EdgeCollapseOptions::default().base_triangles;
    let flaws = survey.non_manifold_edges + survey.non_manifold_vertices + survey.inconsistent_edges;
    let (pieces, many) = (text::count(survey.components as u64), survey.components * LEAST > least);
    if flaws == 0 && many {
        let why = format!(
            ", since it is a 2-manifold; `--model vertex_pair` would join its {pieces} pieces as it gets coarse"
        );
        (Model::EdgeCollapse, why)
    } else if flaws == 0 {
        (Model::EdgeCollapse, ", since it is a 2-manifold".to_owned())
    } else if many {
        let why =
            format!(", since it is no 2-manifold, and {pieces} pieces must join to come down to {least} triangles");
        (Model::VertexPair, why)
    } else if flaws * 1000 > survey.edges {
        let flaws = text::count(flaws as u64);
        let why =
            format!(", since it is no 2-manifold at {flaws} edges and vertices, and pairs need fewer triangles there");
        (Model::VertexPair, why)
    } else {
        let flaws = text::count(flaws as u64);
        (
            Model::EdgeCollapse,
            format!(", since it is a 2-manifold but for {flaws} edges and vertices, which it takes too"),
        )
    }
}

/// From a mesh to what is stored of a model that takes meshes.
fn simplify(
    mesh: &TriangleMesh,
    report: String,
    model: Model,
    because: String,
    recipe: &Recipe,
    p: &Phases,
) -> Result<Built> {
    let bits = recipe.precision.bits();
    let stored = match model {
        Model::EdgeCollapse => {
            let options = EdgeCollapseOptions { bits, ..EdgeCollapseOptions::default() };
            Stored::EdgeCollapse(edge_collapse_columns(mesh, &options, p)?)
        }
        Model::VertexPair => Stored::VertexPair(vertex_pair_columns(mesh, &recipe.pairing.options(bits), p)?),
        Model::VertexRemoval => {
            let connectivity = recipe.connectivity.map_or_else(Default::default, Code::connectivity);
            let options = VertexRemovalOptions { bits, connectivity, ..VertexRemovalOptions::default() };
            Stored::VertexRemoval(vertex_removal_columns(mesh, &options, p)?)
        }
        Model::RightTriangles => unreachable!("is not made of a mesh"),
    };
    let (base, errors, floor) = match &stored {
        Stored::EdgeCollapse(c) => (&c.base, &c.errors, c.floor_error),
        Stored::VertexPair(c) => (&c.base, &c.errors, c.floor_error),
        Stored::VertexRemoval(c) => (&c.base, &c.errors, c.floor_error),
        Stored::RightTriangles(_) => unreachable!("is not made of a mesh"),
    };
    Ok(Built {
        report,
        because,
        source_vertices: mesh.positions.len() as u64,
        base_triangles: base.triangles.len(),
        errors: [floor, errors.iter().copied().fold(floor, f32::max)],
        diagonal: mesh.bounds().map_or(0.0, |b| b.diagonal() as f64),
        stored,
    })
}

fn terrain(source: &Path, recipe: &Recipe, phases: &Phases) -> Result<Built> {
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
        because: match recipe.model {
            Choice::Auto => ", since it is a height field".to_owned(),
            _ => String::new(),
        },
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
