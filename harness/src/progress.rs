//! A progress bar on a terminal for anything that takes over a second; silence otherwise. Ctrl-C stops what it shows.

use crate::interrupt;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use prt_transfer::{Progress, Result};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// How long a stage runs before its bar appears.
const PATIENCE: Duration = Duration::from_secs(1);

/// Draws the stages of one operation, one bar after the other, on standard error where that is a terminal.
pub struct Bar {
    began: Instant,
    current: Mutex<ProgressBar>,
}

impl Default for Bar {
    fn default() -> Bar {
        Bar { began: Instant::now(), current: Mutex::new(ProgressBar::hidden()) }
    }
}

impl Progress for Bar {
    fn start(&self, stage: &str, total: u64) {
        let bar = hidden(total);
        bar.set_message(stage.to_string());
        if let Ok(mut current) = self.current.lock() {
            current.finish_and_clear();
            *current = bar;
        }
    }

    fn advance(&self, done: u64) -> Result<()> {
        if let Ok(current) = self.current.lock() {
            reveal(&current, self.began);
            current.inc(done);
        }
        interrupt::check()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Ok(current) = self.current.lock() {
            current.finish_and_clear();
        }
    }
}

/// A bar that nobody sees until [`reveal`].
fn hidden(total: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{elapsed_precise}{prefix} {wide_bar} {pos}/{len} {msg}");
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Shows a bar once its operation has run for a second. On anything but a terminal it stays hidden by itself.
fn reveal(bar: &ProgressBar, began: Instant) {
    if bar.is_hidden() && began.elapsed() > PATIENCE {
        bar.set_draw_target(ProgressDrawTarget::stderr());
    }
}

/// A bar over the steps of a long command, with what it is at.
pub struct Steps {
    bar: ProgressBar,
    began: Instant,
}

impl Steps {
    /// So many steps are ahead.
    pub fn new(total: usize) -> Steps {
        let bar = hidden(total as u64);
        bar.enable_steady_tick(Duration::from_millis(200));
        Steps { bar, began: Instant::now() }
    }

    /// So many more.
    pub fn more(&self, steps: usize) {
        self.bar.inc_length(steps as u64);
    }

    /// What is being done now.
    pub fn show(&self, what: &str) {
        self.bar.set_message(what.to_string());
        reveal(&self.bar, self.began);
    }

    /// How long the steps that are left will take.
    pub fn expect(&self, left: Duration) {
        // Coarse, as it is known.
        let left = Duration::from_secs(left.as_secs().next_multiple_of(if left.as_secs() > 90 { 30 } else { 5 }));
        self.bar.set_prefix(format!(", {} left", HumanDuration(left)));
    }

    /// So many steps are finished.
    pub fn done(&self, steps: usize) {
        self.bar.inc(steps as u64);
    }

    /// Hides the bar while something is printed.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// Nothing is left to do.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
