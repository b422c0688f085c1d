//! What was measured: a table for people, JSON for later.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::{Map, Value, json};

/// Says what is going on.
pub fn say(what: &str) {
    eprintln!("bench: {what}");
}

/// Grows while measuring; [`Report::write`] ends it.
pub struct Report {
    machine: Value,
    meshfront: String,
    meshes: Map<String, Value>,
    figures: Vec<Figure>,
}

struct Figure {
    what: String,
    value: String,
    reach: String,
    met: Option<bool>,
}

impl Report {
    pub fn new(meshfront: &Path) -> Result<Report> {
        let version = first_line(Command::new(meshfront).arg("--version"))
            .with_context(|| format!("{} does not start", meshfront.display()))?;
        let commit = first_line(Command::new("git").args(["describe", "--always", "--dirty"])).unwrap_or_default();
        Ok(Report {
            machine: machine(),
            meshfront: format!("{version} {commit}").trim().to_owned(),
            meshes: Map::new(),
            figures: Vec::new(),
        })
    }

    pub fn mesh(&mut self, name: &str, vertices: usize, triangles: usize) {
        self.meshes.insert(name.to_owned(), json!({ "vertices": vertices, "triangles": triangles }));
    }

    pub fn raw(&mut self, mesh: &str, key: &str, value: Value) {
        self.meshes[mesh][key] = value;
    }

    pub fn note(&mut self, what: &str, value: &str) {
        self.figures.push(Figure { what: what.to_owned(), value: value.to_owned(), reach: String::new(), met: None });
    }

    pub fn at_most(&mut self, what: &str, value: f64, reach: f64, unit: &str) {
        self.figure(what, value, &format!("≤ {reach}"), unit, value <= reach);
    }

    pub fn at_least(&mut self, what: &str, value: f64, reach: f64, unit: &str) {
        self.figure(what, value, &format!("≥ {reach}"), unit, value >= reach);
    }

    fn figure(&mut self, what: &str, value: f64, reach: &str, unit: &str, met: bool) {
        self.figures.push(Figure {
            what: what.to_owned(),
            value: format!("{value:.3} {unit}").trim_end().to_owned(),
            reach: reach.to_owned(),
            met: Some(met),
        });
    }

    /// Prints the table, and writes everything to `results/DATE.json`; `date` is RFC 3339.
    pub fn write(self, results: &Path, date: &str) -> Result<()> {
        let width = self.figures.iter().map(|figure| figure.what.chars().count()).max().unwrap_or(0);
        for Figure { what, value, reach, met } in &self.figures {
            let verdict = match met {
                Some(true) => "reached",
                Some(false) => "MISSED",
                None => "",
            };
            println!("{}", format!("{what:width$}  {value:18}  {reach:8}  {verdict}").trim_end());
        }
        let figures = self.figures.iter().map(|figure| {
            json!({ "what": figure.what, "value": figure.value, "reach": figure.reach, "reached": figure.met })
        });
        let all = json!({
            "date": date, "meshfront": self.meshfront, "machine": self.machine,
            "figures": figures.collect::<Vec<_>>(), "meshes": self.meshes,
        });
        let day = date.split('T').next().unwrap_or(date);
        let file = results.join(format!("{day}.json"));
        std::fs::write(&file, serde_json::to_string_pretty(&all)? + "\n")
            .with_context(|| format!("cannot write {}", file.display()))?;
        println!("\nraw results: {}", file.display());
        Ok(())
    }
}

fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or("").to_owned())
}

/// Processor, cores and memory; what the system does not tell is left out.
fn machine() -> Value {
    let field = |file: &str, key: &str| {
        let text = std::fs::read_to_string(file).ok()?;
        let line = text.lines().find(|line| line.starts_with(key))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    json!({
        "system": std::env::consts::OS,
        "architecture": std::env::consts::ARCH,
        "processor": field("/proc/cpuinfo", "model name"),
        "cores": std::thread::available_parallelism().map_or(0, |n| n.get()),
        "memory": field("/proc/meminfo", "MemTotal"),
    })
}
