//! What of a body sets its largest step.

use super::mode::{Goal, Mode, Pull, rates};
use super::{Axis, Modes, ROOM, ROOM_IN_AIR, SAFETY, System, Worst, step_within};
use crate::assembly::Assembly;
use crate::diagnostics::culprit::{Culprit, Given, Part, Source, given};
use crate::real::{dot, scale, sub};

/// What a part that is scaled down must leave to the others, by the same measure.
const KEPT: f64 = 0.98;

impl Worst {
    /// What sets the largest step, in air (`is_in_air`) or without, and what would do without it where the `step` [s] is longer.
    pub fn culprit(&self, assembly: &Assembly, (step, is_in_air): (f64, bool)) -> Option<Culprit> {
        let Self { body, system, mode } = self;
        let room = if is_in_air { ROOM_IN_AIR } else { ROOM };
        let longest = |system: &System| system.largest_step(Pull::AnyWay).0[usize::from(is_in_air)];
        let h = system.step_of(mode, room);
        let parts = system.parts().into_iter().map(|part| (part, system.rate_of(part, mode, h)));
        let rates: Vec<(Part, f64)> = parts.collect();
        let all: f64 = rates.iter().map(|(_, rate)| rate).sum();
        let &(part, most) =
            rates.iter().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, most)| *most > 0.0)?;
        let size = |node: usize| system.root_inverse_mass[node].powi(2) * dot(mode[node], mode[node]);
        let node = (0..mode.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        let body = &assembly.bodies[*body];
        let mut culprit = Culprit {
            body: body.name.clone(),
            vertex: body.vertex_of_solver(system.patch.map_or(node, |patch| patch.of_grid(node))),
            part,
            value: system.value(part),
            share: most / all,
            alone: None,
            without: None,
            factor: None,
        };
        if step > SAFETY * h {
            let (only, rest) = (system.only(part), system.without(part));
            let left = KEPT * room - rest.largest_rate(step);
            (culprit.alone, culprit.without) = (Some(longest(&only)), Some(longest(&rest)));
            culprit.factor =
                Some(left / only.largest_rate(step)).filter(|factor| (0.0..1.0).contains(factor));
        }
        Some(culprit)
    }
}

impl System {
    /// All that resists in it.
    fn parts(&self) -> Vec<Part> {
        let mut sources: Vec<Source> = Vec::new();
        let springs = self.springs.iter().map(|spring| Source::Springs(spring.kind));
        for source in springs.chain(self.elements.iter().map(|modes| Source::Elements(modes.kind))) {
            if !sources.contains(&source) {
                sources.push(source);
            }
        }
        let both = |source| [false, true].map(|is_damping| Part { source, is_damping });
        let drag = Part { source: Source::Drag, is_damping: true };
        sources.into_iter().flat_map(both).chain([drag]).collect()
    }

    /// A part alone.
    fn only(&self, part: Part) -> Self {
        let springs = self.springs.iter().filter(|spring| part.source == Source::Springs(spring.kind));
        let elements = self.elements.iter().filter(|modes| part.source == Source::Elements(modes.kind));
        let mut only = Self {
            springs: springs.copied().collect(),
            elements: elements.cloned().collect(),
            root_inverse_mass: self.root_inverse_mass.clone(),
            drag: if part.source == Source::Drag { self.drag } else { 0.0 },
            is_blown_on: self.is_blown_on,
            patch: self.patch,
            shared: Vec::new(),
        };
        only.set_to_zero(Part { is_damping: !part.is_damping, ..part });
        only
    }

    /// All but a part.
    fn without(&self, part: Part) -> Self {
        let mut rest = self.clone();
        if part.source == Source::Drag {
            rest.drag = 0.0;
        }
        rest.set_to_zero(part);
        rest
    }

    /// Takes the stiffness or the damping of springs or elements out.
    fn set_to_zero(&mut self, part: Part) {
        for spring in self.springs.iter_mut().filter(|spring| part.source == Source::Springs(spring.kind)) {
            *(if part.is_damping { &mut spring.d } else { &mut spring.k }) = 0.0;
        }
        for modes in self.elements.iter_mut().filter(|modes| part.source == Source::Elements(modes.kind)) {
            modes.stiffness.iter_mut().for_each(|numbers| numbers[usize::from(part.is_damping)] = 0.0);
        }
    }

    /// The number by which the user gave a part, in its unit, where it is one.
    fn value(&self, part: Part) -> Option<f64> {
        let which = usize::from(part.is_damping);
        let most = |all: &mut dyn Iterator<Item = f64>| all.max_by(f64::total_cmp);
        match part.source {
            Source::Springs(kind) => {
                let springs = self.springs.iter().filter(|spring| spring.kind == kind);
                most(&mut springs.map(|spring| [spring.k, spring.d][which]))
            }
            Source::Elements(kind) => {
                let modes = self.elements.iter().filter(|modes| modes.kind == kind);
                let numbers = modes.flat_map(|modes| modes.stiffness.iter());
                match given(kind, part.is_damping) {
                    Given::Itself => most(&mut numbers.map(|numbers| numbers[which])),
                    Given::Time => most(&mut numbers.filter(|n| n[0] > 0.0).map(|n| n[1] / n[0])),
                    Given::Tensor => None,
                }
            }
            Source::Drag => Some(self.drag),
        }
    }

    /// The step [s] at which a state comes to `room`.
    fn step_of(&self, mode: &[[f64; 3]], room: f64) -> f64 {
        let all = self.multiplied(mode.iter().copied(), Pull::AnyWay);
        step_within(room, rates(&all))
    }

    /// What a part adds to h²κ + 2hδ of a state, times its size.
    fn rate_of(&self, part: Part, mode: &[[f64; 3]], h: f64) -> f64 {
        let times = |k: f64, d: f64| if part.is_damping { 2.0 * h * d } else { h * h * k };
        let moved = |node: u32| scale(mode[node as usize], self.root_inverse_mass[node as usize]);
        match part.source {
            Source::Springs(kind) => {
                let rate = |spring: &Axis| {
                    let strain = sub(moved(spring.nodes[1]), moved(spring.nodes[0]));
                    times(spring.k, spring.d) * dot(strain, strain)
                };
                self.springs.iter().filter(|spring| spring.kind == kind).map(rate).sum()
            }
            Source::Elements(kind) => {
                let rate = |(nodes, directions, [k, d, stiffest]): (&[u32], &[[f64; 3]], [f64; 3])| {
                    let ends = nodes.iter().zip(directions);
                    let strain: f64 = ends.map(|(&node, &direction)| dot(direction, moved(node))).sum();
                    stiffest * times(k, d) * strain * strain
                };
                let modes = self.elements.iter().filter(|modes| modes.kind == kind);
                modes.flat_map(Modes::iter).map(rate).sum()
            }
            Source::Drag => {
                let all = (0..mode.len() as u32).map(moved).map(|x| dot(x, x));
                times(0.0, self.drag) * all.sum::<f64>()
            }
        }
    }

    /// The largest h²κ + 2hδ of a step [s].
    fn largest_rate(&self, h: f64) -> f64 {
        let Mode { kappa, delta, .. } = self.worst(Pull::AnyWay, Goal::Rate(h));
        h * h * kappa + 2.0 * h * delta
    }
}
