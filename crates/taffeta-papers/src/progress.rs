//! How far the runs are, and whether the user wants them to end.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use taffeta_io::program::{Failure, complain};

/// Progress on a terminal; elsewhere a line each run.
pub struct Progress {
    bar: ProgressBar,
    stopped: Arc<AtomicBool>,
}

impl Progress {
    /// Begins, and listens for Ctrl-C from now on. A second one does not wait for the run that is under way: what was run before is
    /// kept.
    ///
    /// # Errors
    /// Where it cannot listen.
    pub fn new() -> Result<Self, Failure> {
        let stopped = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stopped);
        let stop = move || {
            if asked.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        };
        ctrlc::set_handler(stop)
            .map_err(|error| Failure::Work(format!("cannot listen for Ctrl-C: {error}")))?;
        let bar = ProgressBar::new(0);
        let template = "{bar:30} run {pos} of {len}, {elapsed} so far, {eta} left\n{wide_msg}";
        // The template is ours and right; were it not, the plain bar serves.
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        Ok(Self { bar, stopped })
    }

    /// A run begins: its number, how many there are, and its command.
    pub fn begins(&self, number: usize, count: usize, command: &str) {
        self.bar.set_length(count as u64);
        self.bar.set_position(number as u64);
        self.bar.set_message(command.to_owned());
        if self.bar.is_hidden() {
            complain(&format!("{number} of {count}: {command}"));
        }
    }

    /// Says something that the user should know.
    pub fn says(&self, words: &str) {
        self.bar.suspend(|| complain(words));
    }

    /// Whether it is to end.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Takes the bar off the terminal.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}
