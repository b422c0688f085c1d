//! `meshfront compare`: the distance between two surfaces.

use anyhow::{Context, Result};
use meshfront::compare::Distances;
use meshfront::{CompareOptions, compare};
use serde_json::{Value, json};

use crate::args::Compare;
use crate::progress::Phases;
use crate::{input, text};

pub fn run(args: &Compare, quiet: bool) -> Result<()> {
    let pool = args.threads.pool()?;
    let phases = Phases::new(quiet);
    let found = pool.install(|| -> Result<_> {
        let a = input::any_mesh(&args.a, &phases)?;
        let b = input::any_mesh(&args.b, &phases)?;
        phases.start("measure");
        compare(&a, &b, &CompareOptions { samples: args.samples })
            .with_context(|| format!("A is {}, B is {}", args.a.display(), args.b.display()))
    })?;
    phases.finish();

    let relative = |x: f64| if found.diagonal > 0.0 { x / found.diagonal } else { 0.0 };
    if args.json {
        let one = |d: &Distances| -> Value {
            json!({
                "max": d.max, "mean": d.mean, "rms": d.rms,
                "max_relative": relative(d.max), "mean_relative": relative(d.mean), "rms_relative": relative(d.rms),
                "farthest": d.farthest.to_array(), "samples": d.samples,
            })
        };
        let (max, mean, rms) = (found.max(), found.mean(), found.rms());
        return text::print_json(&json!({
            "a": args.a.display().to_string(),
            "b": args.b.display().to_string(),
            "diagonal": found.diagonal,
            "a_to_b": one(&found.a_to_b),
            "b_to_a": one(&found.b_to_a),
            "symmetric": {
                "max": max, "mean": mean, "rms": rms,
                "max_relative": relative(max), "mean_relative": relative(mean), "rms_relative": relative(rms),
            },
        }));
    }
    let row = |name: &str, max: f64, mean: f64, rms: f64| {
        let cell = |x: f64| format!("{:>12} {:>12}", text::length(x), text::percent(relative(x)));
        format!("{name:<10}{}{}{}\n", cell(max), cell(mean), cell(rms))
    };
    let head = format!("{:<10}{:>25}{:>25}{:>25}\n", "", "max", "mean", "RMS");
    let (ab, ba) = (&found.a_to_b, &found.b_to_a);
    text::print(&format!(
        "A = {}\nB = {}\n{head}{}{}{}percentages of the diagonal of A, {}; {} + {} samples\n",
        args.a.display(),
        args.b.display(),
        row("A to B", ab.max, ab.mean, ab.rms),
        row("B to A", ba.max, ba.mean, ba.rms),
        row("both", found.max(), found.mean(), found.rms()),
        text::length(found.diagonal),
        text::count(ab.samples as u64),
        text::count(ba.samples as u64),
    ))
}
