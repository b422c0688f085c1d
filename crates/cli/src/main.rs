//! The command `meshfront`: a thin shell around the library. One file per command; [`args`] has what they take.
//!
//! Exit codes: 0; 1 something failed; 2 the command line makes no sense; 130 interrupted.

mod args;
mod bench;
mod build;
mod compare;
mod dropped;
mod extract;
mod info;
mod input;
mod interrupt;
mod output;
mod progress;
mod sample;
mod study;
mod text;
mod view;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use args::{Cli, Command};

fn main() -> ExitCode {
    let cli = Cli::parse();
    match interrupt::install().and_then(|()| run(&cli)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("meshfront: {}", one_line(&e));
            ExitCode::from(if e.is::<output::Usage>() { 2 } else { 1 })
        }
    }
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    match &cli.command {
        Command::Build(args) => build::run(args, cli.quiet),
        Command::Info(args) => info::run(args, cli.quiet),
        Command::Extract(args) => extract::run(args, cli.quiet),
        Command::Compare(args) => compare::run(args, cli.quiet),
        Command::View(args) => view::run(args, cli.quiet),
        Command::Bench(args) => bench::run(args, cli.quiet),
        Command::Study(args) => study::run(args, cli.quiet),
        Command::Sample(args) => sample::run(args, cli.quiet),
        Command::Completions(args) => {
            let mut script = Vec::new();
            clap_complete::generate(args.shell, &mut Cli::command(), "meshfront", &mut script);
            text::print(&String::from_utf8_lossy(&script))
        }
    }
}

/// What went wrong and why, outermost first. Messages that repeat their cause are not said twice.
fn one_line(error: &anyhow::Error) -> String {
    let mut line = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line
}
