//! Phases of a long job: a bar for each on a terminal, nothing in a pipe, and their times for the summary.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use meshfront::simplify::Progress;

use crate::text;

/// Follows the phases of one job.
pub struct Phases {
    draw: bool,
    told: Option<Told>,
    state: Mutex<State>,
}

/// Is told the phase, and which part of it is done where that is known.
type Told = Box<dyn Fn(&'static str, Option<f64>) + Send + Sync>;

#[derive(Default)]
struct State {
    /// Of the phase that runs, and how much of it was told last.
    total: u64,
    last_told: u64,
    running: Option<(&'static str, Instant, ProgressBar)>,
    finished: Vec<(&'static str, Duration)>,
}

impl Phases {
    /// Draws bars if standard error is a terminal and nobody asked for silence.
    pub fn new(quiet: bool) -> Phases {
        Phases::telling(quiet, None)
    }
    /// The same; `told` hears of every phase and of every hundredth of it.
    pub fn told(quiet: bool, told: impl Fn(&'static str, Option<f64>) + Send + Sync + 'static) -> Phases {
        Phases::telling(quiet, Some(Box::new(told)))
    }
    fn telling(quiet: bool, told: Option<Told>) -> Phases {
        Phases { draw: !quiet && std::io::stderr().is_terminal(), told, state: Mutex::default() }
    }

    /// A phase of unknown length.
    pub fn start(&self, name: &'static str) {
        self.phase(name, "", 0);
    }

    /// Ends the last phase, and says what took how long: `read 0.41 s, collapse 2.10 s`.
    pub fn finish(&self) -> String {
        self.change(|state| {
            let parts = state.finished.iter().map(|(name, time)| format!("{name} {}", text::seconds(*time)));
            parts.collect::<Vec<_>>().join(", ")
        })
    }

    /// Ends the phase that runs.
    fn change<T>(&self, then: impl FnOnce(&mut State) -> T) -> T {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((name, start, bar)) = state.running.take() {
            bar.finish_and_clear();
            state.finished.push((name, start.elapsed()));
        }
        then(&mut state)
    }
}

impl Drop for Phases {
    /// An error leaves no half-drawn bar above its message.
    fn drop(&mut self) {
        self.change(|_| ());
    }
}

impl Progress for Phases {
    fn phase(&self, name: &'static str, unit: &'static str, total: u64) {
        let target = if self.draw { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let (bar, template) = if total == 0 {
            (ProgressBar::with_draw_target(None, target), "{msg:>10} {spinner} {elapsed}".to_owned())
        } else {
            let template =
                format!("{{msg:>10}} {{wide_bar}} {{human_pos}}/{{human_len}} {unit}, {{rate}}/s, {{eta}} left");
            (ProgressBar::with_draw_target(Some(total), target), template)
        };
        // The templates are the two above: a mistake in them shows in the first test on a terminal, as plain bars.
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar()).with_key(
            "rate",
            |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                // A bar that cannot be drawn is no reason to fail.
                let _ = out.write_str(&text::count(state.per_sec() as u64));
            },
        );
        let bar = bar.with_style(style).with_message(name);
        if self.draw {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        self.change(|state| {
            (state.total, state.last_told) = (total, 0);
            state.running = Some((name, Instant::now(), bar));
        });
        if let Some(told) = &self.told {
            told(name, (total > 0).then_some(0.0));
        }
    }

    fn at(&self, done: u64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((name, _, bar)) = &state.running else { return };
        bar.set_position(done);
        let (name, total) = (*name, state.total);
        if let Some(told) = &self.told
            && total > 0
            && done.saturating_sub(state.last_told) * 100 >= total
        {
            state.last_told = done;
            told(name, Some((done as f64 / total as f64).min(1.0)));
        }
    }
}
