//! Project chores: everything that a fresh clone needs, each by one command.

mod bench;
mod browser;
mod demo;
mod fuzz;
mod models;
mod step;
mod test;
mod web;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Meshfront's chores. Each installs what it needs through the ordinary package managers.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", disable_help_subcommand = true)]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Show the Stanford dragon in the browser, refined for where you look from
    Demo {
        /// Only print the address
        #[arg(long)]
        no_open: bool,
        /// Port on 127.0.0.1; 0 takes any free one
        #[arg(long, default_value_t = 0)]
        port: u16,
        /// Look at the page with a headless browser, write target/demo/dragon.png, and end
        #[arg(long, conflicts_with_all = ["no_open", "port"])]
        check: bool,
    },
    /// Check everything: format, lints, tests, the page in a browser
    Test {
        /// Also what takes long: promises on real scans, documentation, dependencies, fuzzing
        #[arg(long)]
        all: bool,
    },
    /// Build the engine as WebAssembly and the page that the binary embeds
    Web {
        /// Where the standard library for WebAssembly comes from
        #[arg(long, value_enum, default_value_t)]
        std: web::Std,
    },
    /// Measure beside the rivals; raw results go to bench/results
    Bench {
        /// Measure this mesh (repeatable) [default: the dragon and a small bunny]
        #[arg(long, value_name = "PATH")]
        mesh: Vec<PathBuf>,
        /// Handed on: --runs N, --only build|quality|promise|flyby
        #[arg(last = true)]
        arguments: Vec<String>,
    },
    /// Feed random bytes to the readers
    Fuzz {
        /// One of fuzz/fuzz_targets [default: each in turn]
        target: Option<String>,
        /// How long, for each target
        #[arg(long, default_value_t = 60)]
        seconds: u32,
    },
}

fn main() -> ExitCode {
    match run(Arguments::parse().chore) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(chore: Chore) -> Result<()> {
    match chore {
        Chore::Demo { check: true, .. } => demo::demo(demo::End::Check),
        Chore::Demo { no_open, port, .. } => demo::demo(demo::End::View { open: !no_open, port }),
        Chore::Test { all } => test::test(all),
        Chore::Web { std } => web::web(std),
        Chore::Bench { mesh, arguments } => bench::bench(mesh, &arguments),
        Chore::Fuzz { target, seconds } => fuzz::fuzz(target.as_deref(), seconds),
    }
}
