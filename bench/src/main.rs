//! Meshfront beside its rivals: the same meshes, the same machine, the same run. `cargo xtask bench` starts it with
//! everything installed; raw results go to a file, a table to the terminal.

mod ply;
mod report;
mod rivals;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Instant, SystemTime};

use anyhow::{Context, Result, bail};
use clap::{Parser, ValueEnum};
use ply::Mesh;
use report::Report;
use rivals::{Tools, number, path};
use serde_json::{Value, json};
use wait4::Wait4;

#[derive(Parser)]
struct Arguments {
    /// Meshes in any format that both sides read; a name is a file's name up to the first dot
    #[arg(required = true)]
    meshes: Vec<PathBuf>,
    /// The release binary
    #[arg(long)]
    meshfront: PathBuf,
    /// A Python with bench/requirements.txt
    #[arg(long)]
    python: PathBuf,
    /// bench/rivals.py
    #[arg(long)]
    rivals: PathBuf,
    /// xtask/page.mjs, which flies in a page
    #[arg(long)]
    page: PathBuf,
    /// The browser that it starts
    #[arg(long)]
    chromium: PathBuf,
    /// The module of @mapbox/martini
    #[arg(long)]
    martini: PathBuf,
    /// bench/martini.mjs
    #[arg(long)]
    martini_mjs: PathBuf,
    /// Where intermediate meshes go
    #[arg(long)]
    work: PathBuf,
    /// Folder of results
    #[arg(long)]
    results: PathBuf,
    /// Repetitions of what is timed; the median counts
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// Measure this alone (repeatable)
    #[arg(long, value_enum)]
    only: Vec<Part>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    Build,
    Quality,
    Promise,
    Flyby,
    Terrain,
    Pairs,
}

/// A mesh, as the rivals get it and as we get it.
struct Subject {
    name: String,
    /// The user's file.
    source: PathBuf,
    /// The same surface without duplicates, which all rivals read.
    clean: PathBuf,
    mesh: Mesh,
    /// Our hierarchy of `source`, with default options.
    front: PathBuf,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let measures = |part| arguments.only.is_empty() || arguments.only.contains(&part);
    let tools = Tools {
        meshfront: arguments.meshfront.clone(),
        python: arguments.python.clone(),
        rivals_py: arguments.rivals.clone(),
    };
    std::fs::create_dir_all(&arguments.work)?;
    std::fs::create_dir_all(&arguments.results)?;
    let mut report = Report::new(&arguments.meshfront)?;
    let of_meshes = [Part::Build, Part::Quality, Part::Promise, Part::Flyby].into_iter().any(measures);
    for source in arguments.meshes.iter().filter(|_| of_meshes) {
        let subject = prepare(&tools, source, &arguments.work)?;
        report.mesh(&subject.name, subject.mesh.positions.len(), subject.mesh.triangles());
        if measures(Part::Build) {
            build_time(&tools, &subject, arguments.runs, &mut report)?;
        }
        if measures(Part::Quality) {
            quality(&tools, &subject, &arguments.work, &mut report)?;
        }
        if measures(Part::Promise) {
            promise(&tools, &subject, &arguments.work, &mut report)?;
        }
        if measures(Part::Flyby) {
            fly_by(&tools, &subject, &arguments, &mut report)?;
        }
    }
    if measures(Part::Terrain) {
        terrain(&tools, &arguments, &mut report)?;
    }
    if measures(Part::Pairs) {
        pairs(&tools, &arguments, &mut report)?;
    }
    let date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    report.write(&arguments.results, &date)
}

fn prepare(tools: &Tools, source: &Path, work: &Path) -> Result<Subject> {
    let file = source.file_name().and_then(|name| name.to_str()).context("a mesh file's name must be UTF-8")?;
    let name = file.split('.').next().unwrap_or(file).to_owned();
    report::say(&format!("{name}: preparing"));
    let clean = work.join(format!("{name}.ply"));
    tools.python(&["clean", path(source), path(&clean)])?;
    let mesh = ply::read(&clean)?;
    let front = work.join(format!("{name}.front"));
    tools.meshfront(&["build", path(source), "-o", path(&front), "--force"])?;
    Ok(Subject { name, source: source.to_owned(), clean, mesh, front })
}

/// From the user's file to our file, beside one call of `meshopt_simplify` to 1 % on the mesh in memory.
fn build_time(tools: &Tools, subject: &Subject, runs: usize, report: &mut Report) -> Result<()> {
    let (mut ours, mut theirs, mut peak) = (Vec::new(), Vec::new(), 0);
    for run in 0..runs {
        report::say(&format!("{}: build {} of {runs}", subject.name, run + 1));
        theirs.push(rivals::meshopt(&subject.mesh, subject.mesh.triangles() / 100)?.1);
        let start = Instant::now();
        let mut command = Command::new(&tools.meshfront);
        command.args(["build", path(&subject.source), "-o", path(&subject.front), "--force", "--quiet"]);
        let used = command.stdin(Stdio::null()).spawn()?.wait4()?;
        ours.push(start.elapsed().as_secs_f64());
        if !used.status.success() {
            bail!("{command:?} failed");
        }
        peak = peak.max(used.rusage.maxrss);
    }
    let bytes = std::fs::metadata(&subject.front)?.len();
    let (seconds, meshopt_seconds) = (median(&mut ours), median(&mut theirs));
    report.raw(
        &subject.name,
        "build",
        json!({ "seconds": ours, "meshopt_simplify_seconds": theirs, "peak_bytes": peak, "front_bytes": bytes }),
    );
    let name = &subject.name;
    report.at_most(&format!("{name}: build / meshopt_simplify to 1 %"), seconds / meshopt_seconds, 6.0, "×");
    report.at_most(&format!("{name}: build"), seconds, 8.0, "s");
    report.at_most(&format!("{name}: build, peak memory"), peak as f64 / 1e9, 1.2, "GB");
    report.at_most(&format!("{name}: file"), bytes as f64 / subject.mesh.positions.len() as f64, 9.0, "B/vertex");
    Ok(())
}

/// Mean distance at 10 % and 1 % of the triangles, at the very count that VTK arrives at.
fn quality(tools: &Tools, subject: &Subject, work: &Path, report: &mut Report) -> Result<()> {
    let Subject { name, clean, mesh, .. } = subject;
    let lossless = work.join(format!("{name}-lossless.front"));
    tools.meshfront(&["build", path(&subject.source), "-o", path(&lossless), "--force", "--lossless"])?;
    for percent in [10, 1] {
        let mut count = mesh.triangles() * percent / 100;
        if count < FEWEST {
            report.note(&format!("{name}: {percent} %"), &format!("{count} triangles are too few to compare"));
            continue;
        }
        let mut rows = Vec::new();
        let file = |rival: &str| work.join(format!("{name}-{percent}-{rival}.ply"));
        for rival in rivals::PYTHON.into_iter().chain(["meshopt"]) {
            report::say(&format!("{name}: {rival} to {percent} %"));
            let out = file(rival);
            let simple = tools.simplify(rival, mesh, clean, &out, count)?;
            if rival == "vtk" {
                count = simple.triangles;
            }
            let distances = compare(tools, clean, &out, QUALITY_SAMPLES)?;
            rows.push(json!({
                "who": rival, "triangles": simple.triangles, "seconds": simple.seconds, "distances": distances
            }));
        }
        for (who, front) in [("meshfront", &subject.front), ("meshfront --lossless", &lossless)] {
            report::say(&format!("{name}: {who} to {percent} %"));
            let out = file(&who.replace(" --", "-"));
            let triangles = count.to_string();
            tools.meshfront(&["extract", path(front), "-o", path(&out), "--force", "--triangles", &triangles])?;
            let distances = compare(tools, clean, &out, QUALITY_SAMPLES)?;
            rows.push(json!({ "who": who, "triangles": ply_triangles(&out)?, "distances": distances }));
        }
        // Someone else's yardstick on our own result: both must tell the same story.
        let second = tools.python(&["distance", path(clean), path(&file("meshfront")), "500000"])?;
        let mean = |row: &Value| number(row, "/distances/one_sided_mean");
        let symmetric = |row: &Value| number(row, "/distances/symmetric_mean");
        let [vtk, ours] = [0, rivals::PYTHON.len() + 1].map(|i| rows[i].clone());
        for row in &rows {
            report.note(
                &format!("{name}: {percent} %, mean distance / VTK's, {}", row["who"].as_str().unwrap_or_default()),
                &format!(
                    "{:.3} one way, {:.3} both ways, {} triangles",
                    mean(row)? / mean(&vtk)?,
                    symmetric(row)? / symmetric(&vtk)?,
                    row["triangles"]
                ),
            );
        }
        let what = format!("{name}: {percent} %, mean distance / VTK's");
        report.at_most(&format!("{what}, one way"), mean(&ours)? / mean(&vtk)?, 1.05, "");
        report.at_most(&format!("{what}, both ways"), symmetric(&ours)? / symmetric(&vtk)?, 1.05, "");
        report.note(
            &format!("{name}: {percent} %, our mean by MeshLab's yardstick / by ours"),
            &format!("{:.3}", number(&second, "/mean")? / mean(&ours)?),
        );
        report.raw(name, &format!("quality_{percent}_percent"), json!({ "rows": rows, "meshlab_of_ours": second }));
    }
    Ok(())
}

/// Fewer triangles than this are about what a base mesh has.
const FEWEST: usize = 400;
/// Points spread over each surface where means are compared, and where a maximum is looked for.
const QUALITY_SAMPLES: usize = 1_000_000;
const PROMISE_SAMPLES: usize = 2_000_000;

/// Twelve tolerances: how far the original really is, against what was promised.
fn promise(tools: &Tools, subject: &Subject, work: &Path, report: &mut Report) -> Result<()> {
    let name = &subject.name;
    let diagonal = subject.mesh.diagonal();
    let out = work.join(format!("{name}-promise.ply"));
    let (mut rows, mut shares, mut broken) = (Vec::new(), Vec::new(), 0);
    for i in 0..12 {
        let relative = 1e-4 * 100f64.powf(f64::from(i) / 11.0);
        report::say(&format!("{name}: promise {relative:.1e} of the diagonal"));
        let promised = relative * diagonal;
        let error = promised.to_string();
        tools.meshfront(&["extract", path(&subject.front), "-o", path(&out), "--force", "--error", &error])?;
        let distances = compare(tools, &subject.source, &out, PROMISE_SAMPLES)?;
        let measured = number(&distances, "/one_sided_max")?;
        broken += usize::from(measured > promised);
        shares.push(measured / promised);
        rows.push(json!({
            "promised_of_diagonal": relative, "promised": promised, "measured": measured,
            "measured_of_promised": measured / promised, "triangles": ply_triangles(&out)?
        }));
    }
    report.raw(name, "promise", Value::Array(rows));
    report.at_most(&format!("{name}: broken promises among 12"), broken as f64, 0.0, "");
    report.at_least(&format!("{name}: measured / promised, median"), median(&mut shares), 0.4, "");
    Ok(())
}

/// The engine's own figures, natively and in a page.
fn fly_by(tools: &Tools, subject: &Subject, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let name = &subject.name;
    report::say(&format!("{name}: fly-by"));
    let native = tools.meshfront_json(&["bench", path(&subject.front)])?;
    let mean = number(&native, "/fly_by/ms/mean")?;
    let at_most = [
        ("fly-by, mean", "/fly_by/ms/mean", 0.3, "ms"),
        ("fly-by, p99", "/fly_by/ms/p99", 1.5, "ms"),
        ("camera jump, over its time budget", "/camera_jump/worst_overshoot_ms", 1.0, "ms"),
        ("camera jump, until converged", "/camera_jump/ms_to_converge_at_60_hz", 500.0, "ms"),
        ("hierarchy in memory", "/memory/bytes_per_update", 80.0, "B/update"),
        ("front in memory", "/memory/bytes_per_active_vertex", 120.0, "B/vertex"),
    ];
    for (what, pointer, reach, unit) in at_most {
        report.at_most(&format!("{name}: {what}"), number(&native, pointer)?, reach, unit);
    }
    let per_second = number(&native, "/top_down/updates_per_second")?;
    report.at_least(&format!("{name}: top-down to full resolution"), per_second / 1e6, 2.0, "M updates/s");
    let saved = number(&native, "/fly_by/evaluations_saved")?;
    report.at_least(&format!("{name}: fly-by, whole front / evaluations"), saved, 4.0, "×");
    report::say(&format!("{name}: fly-by in the browser"));
    let mut page = Command::new("node");
    page.arg(&arguments.page).arg("--meshfront").arg(&tools.meshfront).arg("--chromium").arg(&arguments.chromium);
    let browser = rivals::json_of(page.arg("--fly-by").arg(&subject.front))?;
    let browser_mean = number(&browser, "/meanMs")?;
    report.at_most(&format!("{name}: fly-by in the browser / natively"), browser_mean / mean, 2.5, "×");
    report.raw(name, "fly_by", json!({ "native": native, "browser": browser }));
    Ok(())
}

/// Terrain by procedure: a large one built, and one beside martini at the errors that martini's meshes really have.
fn terrain(tools: &Tools, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let file = |name: &str| arguments.work.join(name);
    let sample = |out: &Path, side: usize| {
        let triangles = (2 * (side - 1) * (side - 1)).to_string();
        tools.meshfront(&["sample", "terrain", "-o", path(out), "--force", "--triangles", &triangles])
    };
    report.mesh("terrain", 4097 * 4097, 2 * 4096 * 4096);
    report::say("terrain: 4097 × 4097 heights");
    let (large, front) = (file("terrain-4097.tif"), file("terrain-4097.front"));
    sample(&large, 4097)?;
    let mut seconds = Vec::new();
    for _ in 0..arguments.runs {
        let start = Instant::now();
        tools.meshfront(&["build", path(&large), "-o", path(&front), "--force"])?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    let info = tools.meshfront_json(&["info", path(&front)])?;
    let per_sample = number(&info, "/memory_bytes")? / (4097.0 * 4097.0);
    report.raw("terrain", "build_4097", json!({ "seconds": seconds, "bytes_per_sample": per_sample }));
    report.at_most("terrain: build of 4097 × 4097, from file to file", median(&mut seconds), 2.5, "s");
    // The base mesh, two triangles, is beyond what is told.
    report.at_most("terrain: hierarchy in memory", (per_sample * 100.0).round() / 100.0, 12.0, "B/sample");

    report::say("terrain: 1025 × 1025 heights, martini");
    let (small, front, out) = (file("terrain-1025.asc"), file("terrain-1025.front"), file("terrain-1025.ply"));
    sample(&small, 1025)?;
    tools.meshfront(&["build", path(&small), "-o", path(&front), "--force", "--lossless"])?;
    let mut node = Command::new("node");
    node.arg(&arguments.martini_mjs).arg(&arguments.martini).arg(&small).args(["1", "2", "5", "10", "20", "40"]);
    let martini = rivals::json_of(&mut node)?;
    let (mut rows, mut ratios) = (Vec::new(), Vec::new());
    for mesh in martini["meshes"].as_array().context("martini.mjs prints meshes")? {
        let measured = number(mesh, "/measured")?;
        tools.meshfront(&["extract", path(&front), "-o", path(&out), "--force", "--error", &measured.to_string()])?;
        let (ours, theirs) = (ply_triangles(&out)?, number(mesh, "/triangles")?);
        report.note(
            &format!("terrain: triangles at a true error of {measured:.2} m"),
            &format!("{ours}, martini {theirs} (asked for {} m)", mesh["asked"]),
        );
        ratios.push(ours as f64 / theirs);
        rows.push(json!({ "martini": mesh, "triangles": ours }));
    }
    let engine = tools.meshfront_json(&["bench", path(&front)])?;
    let rate = number(&engine, "/source_triangles")? / number(&engine, "/top_down/ms")? / 1e3;
    report.raw("terrain", "martini", json!({ "martini": martini, "rows": rows, "engine": engine }));
    report.at_most(
        "terrain: triangles / martini's at the same true error, worst",
        ratios.into_iter().fold(0.0, f64::max),
        1.0,
        "",
    );
    report.at_least("terrain: top-down to full resolution", rate, 10.0, "M triangles/s");
    Ok(())
}

/// Vertex pairs beside edge collapse: an assembly where topology is in the way, and a scan where it is not.
fn pairs(tools: &Tools, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let file = |name: String| arguments.work.join(name);
    for sample in ["assembly", "scan"] {
        let source = file(format!("pairs-{sample}.ply"));
        tools.meshfront(&["sample", sample, "-o", path(&source), "--force", "--triangles", "100000"])?;
        let mut models = Vec::new();
        for model in ["edge_collapse", "vertex_pair"] {
            report::say(&format!("{sample}: build with {model}"));
            let front = file(format!("pairs-{sample}-{model}.front"));
            let mut seconds = Vec::new();
            for _ in 0..arguments.runs {
                let start = Instant::now();
                tools.meshfront(&["build", path(&source), "-o", path(&front), "--force", "--model", model])?;
                seconds.push(start.elapsed().as_secs_f64());
            }
            let info = tools.meshfront_json(&["info", path(&front)])?;
            let updates = number(&info, "/updates")?;
            report.mesh(
                &format!("pairs-{sample}"),
                number(&info, "/source_vertices")? as usize,
                number(&info, "/source_triangles")? as usize,
            );
            models.push(json!({
                "model": model, "front": path(&front), "seconds": median(&mut seconds),
                "file_bytes_per_update": number(&info, "/bytes")? / updates,
                "memory_bytes_per_update": number(&info, "/memory_bytes")? / updates,
            }));
        }
        for (what, pointer) in [
            ("build", "/seconds"),
            ("file per update", "/file_bytes_per_update"),
            ("memory per update", "/memory_bytes_per_update"),
        ] {
            let [theirs, ours] = [number(&models[0], pointer)?, number(&models[1], pointer)?];
            let both = format!("{ours:.2}, edge collapse {theirs:.2}");
            report.note(&format!("{sample}: vertex pairs, {what} (s, B)"), &both);
        }
        // The source from the mesh: what edge collapse ends with, and twelve of ours around that.
        let out = file(format!("pairs-{sample}-out.ply"));
        let extracted = |k: usize, error: &str| -> Result<(usize, f64)> {
            let front = models[k]["front"].as_str().unwrap_or_default();
            tools.meshfront(&["extract", front, "-o", path(&out), "--force", "--error", error])?;
            Ok((ply_triangles(&out)?, number(&compare(tools, &source, &out, 200_000)?, "/one_sided_max")?))
        };
        let share = if sample == "assembly" { "100%" } else { "0.2%" };
        let (fewest, reached) = extracted(0, share)?;
        let (first, factor) = if sample == "assembly" { (6.0, 4f64) } else { (0.12, 2.5) };
        let mut rows = Vec::new();
        for i in 0..12 {
            let error = format!("{:.4}%", first * factor.powf(f64::from(i) / 11.0));
            report::say(&format!("{sample}: vertex pairs at {error}"));
            let (triangles, measured) = extracted(1, &error)?;
            rows.push(json!({ "promised": error, "measured": measured, "triangles": triangles }));
        }
        let within = rows.iter().filter(|row| row["measured"].as_f64().is_some_and(|m| m <= reached));
        let ours = within.filter_map(|row| row["triangles"].as_f64()).fold(f64::INFINITY, f64::min);
        let what = format!("{sample}: triangles / edge collapse's {fewest} at the same measured error");
        if sample == "assembly" {
            report.at_most(&what, ours / fewest as f64, 0.05, "");
        } else {
            report.note(&what, &format!("{:.3}", ours / fewest as f64));
        }
        report.raw(
            &format!("pairs-{sample}"),
            "pairs",
            json!({ "models": models, "edge_collapse": { "triangles": fewest, "measured": reached }, "rows": rows }),
        );
    }
    Ok(())
}

/// One yardstick for everybody: from `original` to `simple`, and both ways; in mesh units.
fn compare(tools: &Tools, original: &Path, simple: &Path, samples: usize) -> Result<Value> {
    let said = tools.meshfront_json(&["compare", path(original), path(simple), "--samples", &samples.to_string()])?;
    Ok(json!({
        "one_sided_max": number(&said, "/a_to_b/max")?,
        "one_sided_mean": number(&said, "/a_to_b/mean")?,
        "symmetric_max": number(&said, "/symmetric/max")?,
        "symmetric_mean": number(&said, "/symmetric/mean")?,
    }))
}

/// Triangles that a PLY's header promises.
fn ply_triangles(path: &Path) -> Result<usize> {
    let bytes = std::fs::read(path)?;
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(1000)]).into_owned();
    let count = header.lines().find_map(|line| line.strip_prefix("element face ")).context("a PLY without faces")?;
    Ok(count.trim().parse()?)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}
