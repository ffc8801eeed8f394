//! A bar on a terminal; nothing elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress through the frames.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar from frame `start` to frame `end` on standard error, which hides itself where that is not a terminal.
    pub fn new(start: u32, end: u32, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(u64::from(end)), target).with_position(u64::from(start));
        let template = "{bar:40} frame {pos}/{len}, {msg}, {eta} left";
        // The template is ours and right; were it not, the plain bar serves.
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        Self { bar }
    }

    /// One more frame, which took `ms` [ms].
    pub fn frame(&self, ms: f64) {
        self.bar.set_message(format!("{ms:.2} ms"));
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
