//! Signs of life during long phases: on the terminal, and in the log.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// Shows phases on standard error; silent when that is not a terminal or when the user asked for quiet.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    quiet: bool,
}

/// A phase that runs; its line disappears when this is dropped.
#[derive(Debug)]
#[must_use = "the line disappears when the phase is dropped"]
pub struct Phase {
    bar: ProgressBar,
}

impl Progress {
    /// Shows nothing if `quiet`.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Begins a phase: a spinner, its name, and the time since it began.
    pub fn phase(&self, name: impl Into<String>) -> Phase {
        let name = name.into();
        tracing::info!("{name}");
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target).with_message(name);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        // A hidden bar needs no thread that redraws it.
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Phase { bar }
    }

    /// Begins a phase of `steps` known steps: a bar, the steps done, the time since it began; each [`Phase::advance`] is one step.
    pub fn bar(&self, name: impl Into<String>, steps: usize) -> Phase {
        let phase = self.phase(name);
        phase.bar.set_length(steps as u64);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} [{bar:30}] {pos}/{len} ({elapsed})") {
            phase.bar.set_style(style);
        }
        phase
    }
}

impl Phase {
    /// One more step is done.
    pub fn advance(&self) {
        self.bar.inc(1);
    }

    /// Says what is being done now.
    pub fn say(&self, what: impl Into<String>) {
        let what = what.into();
        tracing::info!("{what}");
        self.bar.set_message(what);
    }
}

impl Drop for Phase {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quiet_phase_is_hidden_and_counts_all_the_same() {
        let phase = Progress::new(true).bar("refine", 3);
        assert!(phase.bar.is_hidden());
        phase.advance();
        phase.advance();
        assert_eq!((phase.bar.position(), phase.bar.length()), (2, Some(3)));
        phase.say("solve");
        assert_eq!(phase.bar.message(), "solve");
    }
}
