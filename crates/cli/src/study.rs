//! `meshfront study`: what could have been done otherwise, measured.

use anyhow::{Context, Result};
use meshfront::dependencies::{Dependencies, DependencyOptions, RuleFigures, dependencies};
use serde_json::json;

use crate::args::{Study, StudyDependencies, StudyOf};
use crate::progress::Phases;
use crate::{input, text};

pub fn run(args: &Study, quiet: bool) -> Result<()> {
    match &args.of {
        StudyOf::Dependencies(args) => rules(args, quiet),
    }
}

fn rules(args: &StudyDependencies, quiet: bool) -> Result<()> {
    let phases = Phases::new(quiet);
    let source = input::mesh(&args.mesh, input::Seams::Weld, &phases)?;
    let options = DependencyOptions { tolerance_px: args.tolerance, ..DependencyOptions::default() };
    let found = args.threads.pool()?.install(|| dependencies(&source.mesh, &options, &phases));
    let found = found.with_context(|| args.mesh.display().to_string())?;
    phases.finish();
    if !args.json {
        return text::print(&in_words(&found));
    }
    let rule = |r: &RuleFigures| {
        json!({
            "name": r.name, "paper": r.paper, "bytes_per_update": r.bytes_per_update, "wanted": r.wanted,
            "forced_per_wanted": r.forced_per_wanted, "triangles": r.triangles, "error_px_max": r.error_px_max,
            "error_px_mean": r.error_px_mean, "share_above": r.share_above, "foreign": r.foreign, "folded": r.folded,
            "folded_foreign": r.folded_foreign, "steps_per_frame": r.steps_per_frame, "ns_per_step": r.ns_per_step,
        })
    };
    text::print_json(&json!({
        "mesh": args.mesh.display().to_string(),
        "updates": found.updates,
        "forest_bytes_per_update": found.forest_bytes_per_update,
        "tolerance_px": found.tolerance_px,
        "frames": found.frames[0],
        "frames_looked_at": found.frames[1],
        "rules": found.rules.iter().map(rule).collect::<Vec<_>>(),
    }))
}

fn in_words(found: &Dependencies) -> String {
    let rows = found.rules.iter().map(|r| {
        [
            r.name.into(),
            format!("{:.1}", r.bytes_per_update),
            format!("{:.2}", r.forced_per_wanted),
            text::count(r.triangles.round() as u64),
            format!("{:.3}", r.error_px_mean),
            format!("{:.2}", r.error_px_max),
            format!("{:.0}", r.foreign),
            format!("{:.1}", r.folded),
            format!("{:.1}", r.folded_foreign),
            format!("{:.0}", r.ns_per_step),
        ]
    });
    let head = [
        ["", "bytes", "forced", "triangles", "error", "error", "foreign", "folded", "folded", "time"],
        ["rule", "/update", "/wanted", "mean", "mean px", "max px", "cells", "cells", "foreign", "ns/step"],
    ];
    let line = |row: [String; 10]| {
        let [name, figures @ ..] = row;
        format!("{name:<24}{}\n", figures.map(|figure| format!("{figure:>10}")).concat())
    };
    let table: String = head.map(|row| row.map(String::from)).into_iter().chain(rows).map(line).collect();
    format!(
        "{} updates, {:.1} bytes each without dependencies; {} frames at {} px, {} of them looked at\n\n{table}\n\
         error: of vertices of the source that are seen and face the eye. foreign: cells that no mesh of the sequence\n\
         of collapses had. folded: cells turned away from the surface below them.\n",
        text::count(found.updates as u64),
        found.forest_bytes_per_update,
        found.frames[0],
        found.tolerance_px,
        found.frames[1],
    )
}
