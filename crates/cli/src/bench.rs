//! `meshfront bench`: what the engine does on a hierarchy, and how long it takes.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use meshfront::{Everything, Front, LiveMesh, Outcome, Request, TriangleModel, fly_by, with_model};
use serde::Serialize;

use crate::args::Bench;
use crate::progress::Phases;
use crate::{input, text};

/// The flight and full refinement are measured this often, and the run in the middle is reported: other programs disturb.
const RUNS: usize = 5;
/// Time for the engine in a frame of the camera jump.
const JUMP_BUDGET_US: u32 = 4_000;
/// A jump that takes more frames than this does not converge.
const JUMP_FRAMES: u32 = 10_000;

/// All figures. Times are milliseconds.
#[derive(Serialize)]
struct Report {
    file: String,
    source_vertices: u32,
    source_triangles: u32,
    updates: usize,
    fly_by: FlyBy,
    top_down: TopDown,
    camera_jump: CameraJump,
    memory: Memory,
}

#[derive(Serialize)]
struct FlyBy {
    frames: usize,
    tolerance_px: f32,
    updates_per_frame: f64,
    triangles_mean: f64,
    triangles_max: usize,
    evaluations_per_frame: f64,
    /// Open decisions: what visiting the whole front would evaluate in every frame.
    open_decisions_mean: f64,
    /// Open decisions per evaluation.
    evaluations_saved: f64,
    ms: Times,
}

#[derive(Serialize)]
struct Times {
    mean: f64,
    p50: f64,
    p99: f64,
    max: f64,
}

#[derive(Serialize)]
struct TopDown {
    updates: usize,
    ms: f64,
    updates_per_second: f64,
}

#[derive(Serialize)]
struct CameraJump {
    budget_ms: f64,
    jumps: usize,
    /// The most that a frame took over its budget.
    worst_overshoot_ms: f64,
    /// Frames until the front was settled, at worst; a viewer shows them at its own rate.
    frames_to_converge: u32,
    /// Engine time until then, at worst.
    engine_ms_to_converge: f64,
    /// Until then at 60 frames a second.
    ms_to_converge_at_60_hz: f64,
}

#[derive(Serialize)]
struct Memory {
    hierarchy_bytes: usize,
    bytes_per_update: f64,
    front_bytes: usize,
    bytes_per_active_vertex: f64,
}

pub fn run(args: &Bench, quiet: bool) -> Result<()> {
    let phases = Phases::new(quiet);
    phases.start("read");
    let hierarchy = input::hierarchy(&args.file)?;
    let report = with_model!(&hierarchy, h => measure(h, args, &phases)?);
    phases.finish();
    if args.json { text::print_json(&report) } else { text::print(&in_words(&report)) }
}

fn measure<H: TriangleModel>(hierarchy: &H, args: &Bench, phases: &Phases) -> Result<Report> {
    let updates = hierarchy.updates().count();
    if updates == 0 {
        bail!("{}: has no updates, so there is nothing to measure", args.file.display());
    }
    phases.start("fly-by");
    let fly_by = middle((0..RUNS).map(|_| fly(hierarchy)), |f| f.ms.mean);
    phases.start("top-down");
    let top_down = middle((0..RUNS).map(|_| refine_fully(hierarchy)), |t| t.ms);
    phases.start("jump");
    let camera_jump = jump(hierarchy)?;
    let memory = weigh(hierarchy);
    Ok(Report {
        file: args.file.display().to_string(),
        source_vertices: hierarchy.source().vertices,
        source_triangles: hierarchy.source().triangles,
        updates,
        fly_by,
        top_down,
        camera_jump,
        memory,
    })
}

/// The run whose key is the median.
fn middle<T>(runs: impl Iterator<Item = T>, key: impl Fn(&T) -> f64) -> T {
    let mut runs: Vec<T> = runs.collect();
    runs.sort_by(|a, b| key(a).total_cmp(&key(b)));
    runs.swap_remove(runs.len() / 2)
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Calls the engine until it has nothing left to do.
fn settle<H: TriangleModel>(front: &mut Front<H>, hierarchy: &H, frame: u32) {
    let criterion = fly_by::criterion(hierarchy.bounds(), frame);
    while !front.adapt(hierarchy, &criterion, &Request::tolerance(fly_by::TOLERANCE_PX)).settled {}
    front.mesh_mut().buffers_mut().clear_changes();
}

fn fly<H: TriangleModel>(hierarchy: &H) -> FlyBy {
    let mut front = Front::new(hierarchy);
    settle(&mut front, hierarchy, 0);
    let frames: Vec<(Duration, Outcome)> = (0..fly_by::FRAMES)
        .map(|frame| {
            let criterion = fly_by::criterion(hierarchy.bounds(), frame);
            let start = Instant::now();
            let outcome = front.adapt(hierarchy, &criterion, &Request::tolerance(fly_by::TOLERANCE_PX));
            let time = start.elapsed();
            front.mesh_mut().buffers_mut().clear_changes();
            (time, outcome)
        })
        .collect();
    let mean = |of: &dyn Fn(&Outcome) -> f64| frames.iter().map(|(_, o)| of(o)).sum::<f64>() / frames.len() as f64;
    let evaluations = mean(&|o| o.evaluations as f64);
    let open = mean(&|o| o.open as f64);
    FlyBy {
        frames: frames.len(),
        tolerance_px: fly_by::TOLERANCE_PX,
        updates_per_frame: mean(&|o| (o.refined + o.coarsened) as f64),
        triangles_mean: mean(&|o| o.cells as f64),
        triangles_max: frames.iter().map(|(_, o)| o.cells).max().unwrap_or(0),
        evaluations_per_frame: evaluations,
        open_decisions_mean: open,
        evaluations_saved: open / evaluations.max(1.0),
        ms: Times::of(frames.iter().map(|(time, _)| ms(*time)).collect()),
    }
}

impl Times {
    fn of(mut ms: Vec<f64>) -> Times {
        ms.sort_by(f64::total_cmp);
        // Nearest rank.
        let percentile = |p: f64| ms[((p * ms.len() as f64).ceil() as usize).clamp(1, ms.len()) - 1];
        let mean = ms.iter().sum::<f64>() / ms.len() as f64;
        Times { mean, p50: percentile(0.5), p99: percentile(0.99), max: percentile(1.0) }
    }
}

fn refine_fully<H: TriangleModel>(hierarchy: &H) -> TopDown {
    let mut front = Front::new(hierarchy);
    let start = Instant::now();
    front.top_down(hierarchy, &Everything, &Request::tolerance(0.0));
    let time = start.elapsed();
    let updates = front.applied_count();
    TopDown { updates, ms: ms(time), updates_per_second: updates as f64 / time.as_secs_f64() }
}

/// Jumps between the flight's farthest and nearest views, and between two sides.
fn jump<H: TriangleModel>(hierarchy: &H) -> Result<CameraJump> {
    let views = [0, fly_by::FRAMES / 2, fly_by::FRAMES / 4, 3 * fly_by::FRAMES / 4, fly_by::FRAMES / 2, 0];
    let mut front = Front::new(hierarchy);
    settle(&mut front, hierarchy, views[0]);
    let budget = Duration::from_micros(JUMP_BUDGET_US as u64);
    let request = Request { deadline_us: Some(JUMP_BUDGET_US), ..Request::tolerance(fly_by::TOLERANCE_PX) };
    let (mut overshoot, mut most_frames, mut most_time) = (Duration::ZERO, 0, Duration::ZERO);
    for &view in &views[1..] {
        let criterion = fly_by::criterion(hierarchy.bounds(), view);
        let (mut frames, mut engine) = (0, Duration::ZERO);
        loop {
            let start = Instant::now();
            let outcome = front.adapt(hierarchy, &criterion, &request);
            let time = start.elapsed();
            front.mesh_mut().buffers_mut().clear_changes();
            (frames, engine) = (frames + 1, engine + time);
            overshoot = overshoot.max(time.saturating_sub(budget));
            if outcome.settled {
                break;
            }
            if frames == JUMP_FRAMES {
                bail!("a camera jump has not converged after {JUMP_FRAMES} frames of {} ms", ms(budget));
            }
        }
        (most_frames, most_time) = (most_frames.max(frames), most_time.max(engine));
    }
    Ok(CameraJump {
        budget_ms: ms(budget),
        jumps: views.len() - 1,
        worst_overshoot_ms: ms(overshoot),
        frames_to_converge: most_frames,
        engine_ms_to_converge: ms(most_time),
        ms_to_converge_at_60_hz: most_frames as f64 * 1e3 / 60.0,
    })
}

fn weigh<H: TriangleModel>(hierarchy: &H) -> Memory {
    let mut front = Front::new(hierarchy);
    front.top_down(hierarchy, &Everything, &Request::tolerance(0.0));
    let hierarchy_bytes = hierarchy.memory_bytes();
    let front_bytes = front.memory() + front.mesh().memory_bytes();
    Memory {
        hierarchy_bytes,
        bytes_per_update: hierarchy_bytes as f64 / hierarchy.updates().count() as f64,
        front_bytes,
        bytes_per_active_vertex: front_bytes as f64 / front.mesh().buffers().live_vertices() as f64,
    }
}

fn in_words(report: &Report) -> String {
    let Report { fly_by, top_down, camera_jump, memory, .. } = report;
    let ms = |x: f64| format!("{x:.3} ms");
    let rounded = |x: f64| text::count(x.round() as u64);
    let lines = [
        ("file", format!("{}: {} updates", report.file, text::count(report.updates as u64))),
        ("fly-by", format!("{} frames at {} px", fly_by.frames, fly_by.tolerance_px)),
        ("  updates/frame", format!("{:.1}", fly_by.updates_per_frame)),
        (
            "  triangles",
            format!(
                "{} in the mean, {} at most",
                rounded(fly_by.triangles_mean),
                text::count(fly_by.triangles_max as u64)
            ),
        ),
        (
            "  evaluations",
            format!(
                "{} a frame; the whole front would be {}: {:.1} times more",
                rounded(fly_by.evaluations_per_frame),
                rounded(fly_by.open_decisions_mean),
                fly_by.evaluations_saved
            ),
        ),
        (
            "  engine",
            format!(
                "mean {}, p50 {}, p99 {}, max {}",
                ms(fly_by.ms.mean),
                ms(fly_by.ms.p50),
                ms(fly_by.ms.p99),
                ms(fly_by.ms.max)
            ),
        ),
        (
            "top-down",
            format!(
                "{} updates in {}: {:.2} million a second",
                text::count(top_down.updates as u64),
                ms(top_down.ms),
                top_down.updates_per_second / 1e6
            ),
        ),
        (
            "camera jump",
            format!(
                "{} ms a frame: over by {} at worst; converged after {} frames at worst, {} of engine time",
                camera_jump.budget_ms,
                ms(camera_jump.worst_overshoot_ms),
                camera_jump.frames_to_converge,
                ms(camera_jump.engine_ms_to_converge)
            ),
        ),
        (
            "memory",
            format!(
                "{:.1} bytes per update; {:.1} bytes per active vertex of the full front",
                memory.bytes_per_update, memory.bytes_per_active_vertex
            ),
        ),
    ];
    lines.iter().map(|(name, value)| format!("{name:<18}{value}\n")).collect()
}
