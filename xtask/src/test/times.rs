//! What each part of a run took, beside what it may take.

use std::fmt;
use std::time::Instant;

/// What is tested.
#[derive(Clone, Copy)]
pub enum Scope {
    All,
    Core,
}

impl Scope {
    /// Time [s] on two cores: from nothing, or with all that is foreign built.
    fn budget(self, from_nothing: bool) -> f64 {
        match (self, from_nothing) {
            (Self::All, true) => 1500.0,
            (Self::All, false) | (Self::Core, true) => 720.0,
            (Self::Core, false) => 300.0,
        }
    }
}

/// The times of the parts of a run.
pub struct Times {
    scope: Scope,
    start: Instant,
    /// Each part and its time [s].
    parts: Vec<(String, f64)>,
    /// Whether something foreign was compiled.
    pub from_nothing: bool,
}

impl Times {
    /// Starts the clock.
    pub fn start(scope: Scope) -> Self {
        Self { scope, start: Instant::now(), parts: Vec::new(), from_nothing: false }
    }

    /// Does a part.
    pub fn part<R>(&mut self, name: &str, work: impl FnOnce() -> R) -> R {
        println!("xtask: {name}");
        let start = Instant::now();
        let result = work();
        self.parts.push((name.to_owned(), start.elapsed().as_secs_f64()));
        result
    }
}

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, seconds) in &self.parts {
            writeln!(f, "{seconds:8.1} s  {name}")?;
        }
        let (took, budget) = (self.start.elapsed().as_secs_f64(), self.scope.budget(self.from_nothing));
        let how = if self.from_nothing { "from nothing" } else { "with dependencies built" };
        let verdict = if took > budget { ", too long" } else { "" };
        write!(f, "{took:8.1} s  in all {how}; {budget} s are allowed on two cores{verdict}")
    }
}
