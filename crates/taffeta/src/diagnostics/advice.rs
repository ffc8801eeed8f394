//! Advice for the user: before a run with too long a step, and after a run that diverged.

use crate::advice::{Advice, Warning, round_down};
use crate::assembly::Assembly;
use crate::diagnostics::culprit::Culprit;
use crate::diagnostics::stability::Explicit;
use crate::diagnostics::tension::{Tension, max_tension};
use crate::diagnostics::{FrameReport, stability};
use crate::elements::aero;
use crate::scene::{ConstraintForm, Method};

/// A factor on stiffness that makes another cloth of it: where something else helps, it is no advice.
const OTHER_CLOTH: f64 = 0.01;

/// Limits of the step.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StepLimit {
    /// Longest sub-step of the scene [s].
    pub step: f64,
    /// Largest stable step of explicit elements, at rest [s].
    pub at_rest: f64,
    /// Largest step that is stable in any folded state [s].
    pub folded: f64,
    /// The same in any air flow, if air acts on the body.
    pub in_air: Option<f64>,
    /// Name of the body that sets the step at rest.
    pub stiffest: String,
    /// What sets it there, if anything does.
    pub culprit: Option<Culprit>,
    /// The method of springs, and so which elements are explicit.
    pub method: Method,
    /// Kinds of explicit elements beside springs that limit the step: `hinges`.
    pub elements: Vec<&'static str>,
    /// Whether springs are implicit in velocities, and so across themselves, too.
    pub primal: bool,
    /// Whether the step would be stable if they were.
    pub holds_by_nodes: bool,
    /// The largest tension of implicit springs, if there are any.
    pub max_tension: Option<Tension>,
}

impl StepLimit {
    /// Measures a scene: in any case (`always`), or only as far as needed to tell whether its step is stable.
    pub fn new(assembly: &Assembly, always: bool) -> Self {
        let method = assembly.solver.method;
        // Constraints of the method "acad" have no compliance of the material.
        let compliant = method == Method::Ice && assembly.solver.ice.form == ConstraintForm::Compliant;
        let (primal, step) = (assembly.solver.is_primal(), assembly.time.longest_step());
        let explicit = match method {
            Method::Ice if primal => Explicit::Rest,
            Method::Ice | Method::Xpbd => Explicit::Elements,
            Method::Springs | Method::Acad => Explicit::Springs,
        };
        let measured = |enough| stability::largest_steps(assembly, explicit, enough);
        let enough = (!always).then(|| measured(step)).filter(|(steps, _)| steps.in_air >= step);
        let (largest, worst) = enough.unwrap_or_else(|| measured(f64::INFINITY));
        let limiting = assembly.elements().iter().filter(|list| {
            explicit.has(list) && list.kind.modes.is_some() && !list.bodies[largest.body].is_empty()
        });
        let air = (!assembly.elements_of(aero::NAME, largest.body).is_empty()).then_some(largest.in_air);
        let by_nodes = || stability::largest_steps(assembly, Explicit::Rest, step).0.folded >= step;
        Self {
            step,
            at_rest: largest.at_rest,
            folded: largest.folded,
            in_air: air,
            stiffest: assembly.bodies[largest.stiffest].name.clone(),
            culprit: worst.and_then(|worst| worst.culprit(assembly, (step, air.is_some()))),
            method,
            elements: limiting.map(|list| list.kind.name).collect(),
            primal,
            holds_by_nodes: !primal && (largest.folded >= step || by_nodes()),
            max_tension: if primal || matches!(method, Method::Springs | Method::Xpbd) {
                None
            } else {
                max_tension(assembly, compliant)
            },
        }
    }

    /// Warnings before the run.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        self.explicit().into_iter().chain(self.too_long_to_hang())
    }

    /// A warning if the step is too long for what is explicit at rest, or may be when cloth folds.
    fn explicit(&self) -> Option<Warning> {
        let Self { step, at_rest, folded, stiffest, .. } = self;
        let springs = "folded or slack springs".to_owned();
        let (which, then, loose) = match self.method {
            Method::Springs => (String::new(), "this run will blow up", springs),
            Method::Ice | Method::Xpbd => {
                (format!(" of {}", self.explicit_parts()), "this run will blow up", self.folded_elements())
            }
            Method::Acad => (
                String::new(),
                "springs below the threshold stay explicit, and gain energy until they are constraints",
                springs + ", which stay explicit below the threshold,",
            ),
        };
        if step > at_rest {
            let remedy = self.remedy();
            Some(remedy.after(format!(
                "the step of {step:.3e} s is longer than the largest stable step{which} at rest, {at_rest:.3e} s (body \
                 `{stiffest}`): {then}{}",
                self.words_on_culprit()
            )))
        } else if step > folded {
            Some(self.remedy().after(format!(
                "the step of {step:.3e} s holds at rest (largest{which}: {at_rest:.3e} s, body `{stiffest}`), but {loose} \
                 can need steps down to {folded:.3e} s{}{}",
                self.words_on_air(),
                self.words_on_culprit()
            )))
        } else {
            None
        }
    }

    /// A warning if waves grow across the springs of a hanging body.
    fn too_long_to_hang(&self) -> Option<Warning> {
        let pulled = self.max_tension.as_ref().filter(|_| self.method == Method::Ice)?;
        let growth = pulled.growth(self.step);
        (growth > 1.0).then(|| {
            let Tension { body, vertex, pull, .. } = pulled;
            self.remedy_to_hang(pulled).after(format!(
                "the step of {:.3e} s is too long for the load that hangs in body `{body}`: h² T/(m L) is {} \
                 (T = {pull:.2e} N at vertex {vertex}), and from 1 on waves across the pull grow",
                self.step,
                digits(growth)
            ))
        })
    }

    /// The longest step [s] that is stable whatever springs and air do.
    fn longest(&self) -> f64 {
        self.in_air.unwrap_or(self.folded)
    }

    /// Explicit elements beside springs, in words.
    fn names_of_elements(&self) -> String {
        self.elements.join(" and ").replace('_', " ")
    }

    /// What is explicit where springs are implicit, in words.
    fn explicit_parts(&self) -> String {
        if self.elements.is_empty() { "drag".to_owned() } else { self.names_of_elements() + " and drag" }
    }

    /// What resists more where it is folded, where springs are implicit. Drag alone does not.
    fn folded_elements(&self) -> String {
        format!(
            "folded {}",
            if self.elements.is_empty() { "cloth".to_owned() } else { self.names_of_elements() }
        )
    }

    /// How air reduces the step.
    fn words_on_air(&self) -> String {
        self.in_air
            .map_or_else(String::new, |step| format!(", in a gale {step:.3e} s, for air damps as well"))
    }

    /// What sets the step.
    fn words_on_culprit(&self) -> String {
        let words = self.culprit.as_ref().and_then(Culprit::words);
        words.map_or_else(String::new, |words| format!("; {words}"))
    }

    /// Suggested changes.
    fn remedy(&self) -> Warning {
        let safe = round_down(self.longest());
        if let Some(one) = self.culprit.as_ref().and_then(Culprit::remedy) {
            return self.shorter_step(safe, Some(&one));
        }
        let softer = (safe / self.step).powi(2);
        if self.holds_by_nodes && softer < OTHER_CLOTH {
            return self.shorter_step(safe, None);
        }
        let heavier = 1.0 / softer;
        let stiff = "stiffness and damping";
        let what = match self.method {
            Method::Ice | Method::Xpbd if self.elements.is_empty() => "drag",
            Method::Ice | Method::Xpbd => &format!("drag and {stiff} of {}", self.names_of_elements()),
            Method::Springs | Method::Acad => stiff,
        };
        let other = format!("multiply {what} by {softer:.1e} or the mass by {heavier:.1e}");
        self.shorter_step(safe, Some(&other))
    }

    /// Suggested changes if transverse waves grow. Mass does not help, unless the load is wind: the weight grows with
    /// it.
    fn remedy_to_hang(&self, pulled: &Tension) -> Warning {
        let safe = round_down(pulled.largest_step());
        self.shorter_step(
            safe,
            Some("add stiff bend springs (on a grid also shear springs), which share the pull"),
        )
    }

    /// A step of `safe` [s], something else, or springs that are solved for by nodes where that would do.
    fn shorter_step(&self, safe: f64, other: Option<&str>) -> Warning {
        let or = other.map_or_else(String::new, |other| format!(", or {other}"));
        let message = format!("take sub-steps of {safe:e} s or less{or}");
        let shorter = Advice::LongestStep(safe);
        if self.holds_by_nodes {
            let message =
                format!("{message}, or use the primal form of implicit springs, which is stable at any step");
            Warning::new(message, [shorter, Advice::SolveByNodes])
        } else {
            Warning::new(message, [shorter])
        }
    }

    /// Likely cause and remedy after a run has blown up.
    pub fn after(&self) -> Warning {
        let Self { step, at_rest, folded, .. } = self;
        if let Some(cause) = self.too_long_to_hang() {
            Warning { message: format!("Likely cause: {cause}"), ..cause }
        } else if *step > self.longest() {
            let why = if step > at_rest {
                "too long even at rest".to_owned()
            } else if step > folded {
                let loose = match self.method {
                    Method::Ice | Method::Xpbd => self.folded_elements(),
                    Method::Springs | Method::Acad => "folded or slack springs".to_owned(),
                };
                format!("too long for {loose}")
            } else {
                "too long for a gale".to_owned()
            };
            self.remedy().after(format!(
                "Likely cause: the step of {step:.3e} s is {why} (largest stable step: {at_rest:.3e} s at rest, \
                 {folded:.3e} s folded{}){}",
                self.words_on_air(),
                self.words_on_culprit()
            ))
        } else if self.primal {
            "Springs solved for by nodes hold in any step, so look at forces, wind, pins and colliders (one that moves far in a \
             step tears what it holds)"
                .to_owned()
                .into()
        } else if self.method == Method::Xpbd {
            "Springs that are constraints on positions hold in any step, so look at forces, wind, pins and colliders (one that moves far in \
             a step tears what it holds)"
                .to_owned()
                .into()
        } else if self.method == Method::Ice {
            "Implicit springs hold in any step while their pull stays below m L/h², so look at what pulls harder: forces, wind, \
             pins and colliders (one that moves far in a step tears what it holds)"
                .to_owned()
                .into()
        } else {
            format!(
                "The step of {step:.3e} s is stable for these springs ({folded:.3e} s even when folded), so look at \
                 forces, wind, pins and colliders (one that moves far in a step tears what it holds) and at springs too weak for \
                 their load"
            )
            .into()
        }
    }
}

/// Two decimals, or three digits of a large number.
fn digits(value: f64) -> String {
    if value < 1000.0 { format!("{value:.2}") } else { format!("{value:.2e}") }
}

/// Why a frame must not be shown, if so. It has a number that is not finite. Or springs are at twenty times their
/// length, with ten times the energy that the start and gravity account for, and growing; weak springs that are
/// merely pulled apart gain no energy and pass. Or a volume is a hundred times its target, and growing. In a `driven`
/// scene pins, loads or wind may add energy, too: there it must also be four times that of the frame before.
///
/// ```
/// use taffeta::diagnostics::{FrameReport, advice::runaway};
///
/// let start = FrameReport { max_stretch: 1.0, ..FrameReport::default() };
/// let lost = FrameReport { kinetic: f64::NAN, ..start.clone() };
/// assert_eq!(runaway(&start, &start, &start, false), None);
/// let why = runaway(&start, &start, &lost, false);
/// assert_eq!(why.as_deref(), Some("a position or velocity is no longer a finite number"));
/// ```
pub fn runaway(start: &FrameReport, last: &FrameReport, now: &FrameReport, driven: bool) -> Option<String> {
    if !now.is_finite() {
        return Some("a position or velocity is no longer a finite number".into());
    }
    if let Some(times) = overblown(last, now) {
        return Some(format!("a body encloses {times:.0} times the volume that it should"));
    }
    let internal = |report: &FrameReport| report.kinetic + report.springs + report.energy_of_elements();
    let accounted = internal(start) + (now.gravitational - start.gravitational).abs();
    let growth = if driven { 4.0 } else { 1.0 };
    let growing = now.max_stretch > last.max_stretch && internal(now) > growth * internal(last);
    (now.max_stretch > 20.0 && growing && internal(now) > 10.0 * accounted).then(|| {
        format!(
            "a spring or the fabric is {:.1} times its rest length, and the energy of {:.3e} J is more than ten times what the start \
             and gravity account for ({accounted:.3e} J)",
            now.max_stretch,
            internal(now)
        )
    })
}

/// By what factor a body exceeds its target volume, if that is absurd.
fn overblown(last: &FrameReport, now: &FrameReport) -> Option<f64> {
    let mut volumes = last.volumes.iter().zip(&now.volumes).zip(&now.volume_targets);
    volumes.find_map(|((before, volume), target)| {
        let (before, volume) = ((*before)?.abs(), (*volume)?.abs());
        let times = volume / (*target)?;
        (volume > before && times > 100.0).then_some(times)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_advised_step_is_below_the_limit_for_folded_cloth() {
        for largest in [3.1415e-3, 9.999e-4, 1.0, 0.05] {
            let safe = round_down(largest);
            assert!(safe <= largest && safe > 0.85 * largest, "{safe} for {largest}");
        }
        let at = |step| limit(step, Method::Springs).warnings().collect::<Vec<_>>();
        assert!(matches!(&at(0.01)[..], [one] if one.advice[0] == Advice::LongestStep(3.9e-3)));
        assert!(matches!(&at(0.0045)[..], [one] if one.message.contains("folded")));
        assert_eq!(at(0.001), []);
    }

    #[test]
    fn the_primal_form_is_named_where_it_lifts_the_limit() {
        let said = |limit: &StepLimit| limit.warnings().chain([limit.after()]).collect::<Vec<_>>();
        let named = |one: &Warning| one.advice.contains(&Advice::SolveByNodes);
        let springs = limit(0.01, Method::Springs);
        assert!(said(&springs).iter().all(named) && said(&springs).len() == 2);
        // Springs a million times softer are no answer where another form is one.
        let multiplied = |limit: &StepLimit| said(limit)[0].message.contains("multiply");
        assert!(multiplied(&springs) && !multiplied(&StepLimit { step: 1.0, ..springs.clone() }));
        let hinges = StepLimit { holds_by_nodes: false, ..springs };
        assert!(!said(&hinges).iter().any(named));
        let primal = StepLimit { primal: true, ..limit(0.001, Method::Ice) }.after().message;
        assert!(primal.contains("by nodes hold in any step") && !primal.contains("h²"), "{primal}");
    }

    #[test]
    fn in_air_advice_goes_by_what_air_takes_of_the_step() {
        let still = limit(0.003, Method::Springs);
        let windy = StepLimit { in_air: Some(0.00276), ..still.clone() };
        assert_eq!(windy.warnings().count(), 0, "few gales are so strong");
        assert!(still.after().message.contains("is stable"));
        assert!(windy.after().message.contains("too long for a gale"));
        assert_eq!(windy.after().advice[0], Advice::LongestStep(2.7e-3));
        let folds = StepLimit { step: 0.0045, ..windy };
        let [said] = &folds.warnings().collect::<Vec<_>>()[..] else { panic!("one warning") };
        assert!(said.message.contains("in a gale 2.760e-3 s"), "{said}");
        assert_eq!(said.advice[0], Advice::LongestStep(2.7e-3));
    }

    fn limit(step: f64, method: Method) -> StepLimit {
        StepLimit {
            culprit: None,
            step,
            at_rest: 0.005,
            folded: 0.0039,
            in_air: None,
            stiffest: "flag".to_owned(),
            method,
            elements: vec!["hinges"],
            primal: false,
            holds_by_nodes: method == Method::Springs,
            max_tension: None,
        }
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
        assert!(runaway(&start, &at(25.0, 3.0, 1.0), &at(30.0, 4.0, 0.5), false).is_none());
        assert!(runaway(&start, &at(25.0, 3.0, 1.0), &at(30.0, 60.0, 0.5), false).is_some());
        // Pulled by a pin, energy grows without gravity, but not by bounds.
        assert!(runaway(&start, &at(25.0, 40.0, 5.0), &at(30.0, 60.0, 5.0), true).is_none());
        assert!(runaway(&start, &start, &at(1.0, f64::NAN, 5.0), true).is_some());
    }

    #[test]
    fn a_volume_a_hundred_times_what_it_should_be_is_a_runaway() {
        let with = |volume, target| FrameReport {
            volumes: vec![None, Some(volume)],
            volume_targets: vec![None, target],
            ..FrameReport::default()
        };
        let (last, odd) = (with(90.0, Some(1.0)), with(101.0, Some(1.0)));
        assert!(runaway(&last, &last, &odd, true).is_some_and(|what| what.contains("101 times")));
        assert!(
            runaway(&last, &odd, &last, true).is_none()
                && runaway(&last, &last, &with(101.0, None), true).is_none()
        );
    }
}
