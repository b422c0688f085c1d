//! Project chores: everything that a fresh clone needs, each by one command.

mod step;
mod web;

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
    /// Build the engine as WebAssembly and the page that the binary embeds
    Web {
        /// Where the standard library for WebAssembly comes from
        #[arg(long, value_enum, default_value_t)]
        std: web::Std,
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
        Chore::Web { std } => web::web(std),
    }
}
