//! Words for the user: before a run that cannot hold, and after one that did not.

use super::FrameReport;
use super::stability::FOLDED;

/// What the step is measured against.
#[derive(Clone, Copy, Debug)]
pub struct StepLimit {
    /// Longest sub-step of the scene [s].
    pub step: f64,
    /// Largest stable step at rest [s].
    pub largest: f64,
}

impl StepLimit {
    /// A warning before the run, if the step is too long at rest or may be when cloth folds.
    pub fn warning(&self, body: &str) -> Option<String> {
        let Self { step, largest } = *self;
        if step > largest {
            Some(format!(
                "the step of {step:.3e} s is longer than the largest stable step, {largest:.3e} s (body `{body}`, at \
                 rest): this run will blow up; {}",
                self.remedy()
            ))
        } else if step * FOLDED > largest {
            Some(format!(
                "the step of {step:.3e} s holds at rest (largest: {largest:.3e} s, body `{body}`), but folded or slack \
                 cloth can need steps up to {FOLDED} times smaller; {}",
                self.remedy()
            ))
        } else {
            None
        }
    }

    /// What to change.
    pub fn remedy(&self) -> String {
        let safe = round_down(self.largest / FOLDED);
        let softer = (safe / self.step).powi(2);
        format!("set time.max_step = {safe:e} or less, or multiply k by {softer:.1e} or the node mass by {:.1e}", 1.0 / softer)
    }

    /// Likely cause and remedy after a run has blown up.
    pub fn after(&self) -> String {
        if self.step > self.largest {
            format!(
                "Likely cause: the step of {:.3e} s is longer than the largest stable step at rest, {:.3e} s; {}",
                self.step,
                self.largest,
                self.remedy()
            )
        } else if self.step * FOLDED > self.largest {
            format!(
                "Likely cause: the step of {:.3e} s is close to the largest stable step at rest, {:.3e} s, and folded \
                 cloth needs smaller ones; {}",
                self.step,
                self.largest,
                self.remedy()
            )
        } else {
            format!(
                "The step of {:.3e} s is well within the largest stable step at rest ({:.3e} s), so look at \
                 forces, pins and colliders (one that moves far in a step tears what it holds) and at springs too \
                 weak for their load",
                self.step, self.largest
            )
        }
    }
}

/// Two digits, never above.
fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return value;
    }
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    let text = format!("{:.1e}", (value / unit).floor() * unit);
    text.parse().unwrap_or(value)
}

/// Why a frame cannot be shown to anyone, if so: a number that is not finite, or springs at twenty times their
/// length with ten times the energy that the start and gravity account for, and growing. Weak springs that are
/// merely pulled apart gain no energy and pass.
pub fn runaway(start: &FrameReport, last: &FrameReport, now: &FrameReport) -> Option<String> {
    if !now.is_finite() {
        return Some("a position or velocity is no longer a finite number".into());
    }
    let internal = |report: &FrameReport| report.kinetic + report.springs + report.hinges;
    let accounted = internal(start) + (now.gravitational - start.gravitational).abs();
    let growing = now.max_stretch > last.max_stretch && internal(now) > internal(last);
    (now.max_stretch > 20.0 && growing && internal(now) > 10.0 * accounted).then(|| {
        format!(
            "a spring is {:.1} times its rest length, and the energy of {:.3e} J is {:.0} times what the start and \
             gravity account for",
            now.max_stretch,
            internal(now),
            internal(now) / accounted
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_advised_step_is_below_the_limit_for_folded_cloth() {
        for largest in [3.1415e-3, 9.999e-4, 1.0, 0.05] {
            let safe = round_down(largest / FOLDED);
            assert!(safe <= largest / FOLDED && safe > 0.85 * largest / FOLDED, "{safe} for {largest}");
        }
        let limit = StepLimit { step: 0.01, largest: 0.005 };
        assert!(limit.warning("flag").unwrap().contains("max_step = 3.9e-3"));
        assert!(StepLimit { step: 0.001, largest: 0.005 }.warning("flag").is_none());
        assert!(StepLimit { step: 0.0045, largest: 0.005 }.warning("flag").unwrap().contains("folded"));
    }

    #[test]
    fn a_rubber_band_is_not_a_runaway_but_a_burst_is() {
        let start = FrameReport { max_stretch: 1.0, gravitational: 5.0, ..FrameReport::default() };
        let at = |max_stretch, springs, gravitational| FrameReport {
            max_stretch,
            springs,
            gravitational,
            ..FrameReport::default()
        };
        assert!(runaway(&start, &at(25.0, 3.0, 1.0), &at(30.0, 4.0, 0.5)).is_none());
        assert!(runaway(&start, &at(25.0, 3.0, 1.0), &at(30.0, 60.0, 0.5)).is_some());
        assert!(runaway(&start, &start, &at(1.0, f64::NAN, 5.0)).is_some());
    }
}
