//! The largest stable step of symplectic Euler with damped springs.
//!
//! Linearised: M ẍ = −K x − D ẋ, where a spring gives K = k n nᵀ, D = d n nᵀ along its direction n, and other elements the same
//! along the directions of their modes (a hinge along ∇θ). A mode with κ = uᵀM^-½KM^-½u and δ = uᵀM^-½DM^-½u is stable while h²κ + 2hδ < 4; the worst mode is found by
//! power iteration on h²K + 2hD. For a flat grid with equal springs of all three kinds it gives
//! k h² + 2 d h < 4 m/10.125.
//!
//! That holds at rest. Folded or slack springs may pull in any direction, but no stiffer than k: with k I in place of
//! k n nᵀ the same iteration bounds every state (16.3 in place of 10.125, without damping). Other elements are taken as stiff as
//! they can become.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::assembly::springs::{SpringKind, SpringList};
use crate::elements::element::{Kind, List};
use crate::elements::spring::stencil::GRID_STEPS;
use crate::real::{add, dot, norm, scale, sub};
use crate::topology::random::SplitMix64;
use patch::Patch;

mod parts;
mod patch;

/// Element visits that a power iteration may take; with millions of springs fewer rounds must do.
const ENOUGH: usize = 30_000_000;

/// Steps that are tried one after the other: the worst mode depends on the step, and the largest step on the mode.
const ROUNDS: usize = 6;

/// What h²κ + 2hδ must stay below.
const ROOM: f64 = 4.0;
/// The same in air, which in a step may take all of a velocity (elements/aero/aero.rs): 2hδ of its own is 2 at most.
const ROOM_IN_AIR: f64 = 2.0;

/// Kinds of the springs in each direction of a grid.
const GRID_KINDS: [SpringKind; 6] = {
    use SpringKind::{Bend, Shear, Structural};
    [Structural, Bend, Structural, Bend, Shear, Shear]
};

/// Power iteration comes to the largest eigenvalue from below.
const SAFETY: f64 = 0.995;

/// A spring as it pulls on its ends along a fixed direction.
#[derive(Clone, Copy)]
struct Axis {
    kind: SpringKind,
    nodes: [u32; 2],
    along: [f64; 3],
    k: f64,
    d: f64,
}

/// The modes of elements of one kind: so many nodes each, with a direction for each node.
#[derive(Clone)]
struct Modes {
    kind: &'static str,
    width: usize,
    nodes: Vec<u32>,
    directions: Vec<[f64; 3]>,
    /// k, d, and how much stiffer it may become.
    stiffness: Vec<[f64; 3]>,
}

/// A body's elements and inverse masses.
#[derive(Clone, Default)]
struct System {
    springs: Vec<Axis>,
    elements: Vec<Modes>,
    /// 1/√m [kg^-½]; 0 for held nodes.
    root_inverse_mass: Vec<f64>,
    /// Of each node [kg/s].
    drag: f64,
    /// What part of a grid it shows.
    patch: Option<Patch>,
}

/// The largest stable steps [s] of what is explicit in a scene; infinite if nothing sets one.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct LargestSteps {
    /// As the scene starts.
    pub at_rest: f64,
    /// However its springs are folded.
    pub folded: f64,
    /// The same in any flow of air, if air acts on the body.
    pub in_air: f64,
    /// The body that sets them.
    pub body: usize,
}

/// What takes explicit steps.
#[derive(Clone, Copy, PartialEq)]
pub enum Explicit {
    /// Springs, elements and drag.
    Springs,
    /// Elements and drag: springs are constraints.
    Elements,
    /// What the implicit solver does not solve for.
    Rest,
}

impl Explicit {
    /// Whether elements of a list are among it.
    pub fn has(self, list: &List) -> bool {
        self != Self::Rest || list.kind.implicit.is_none()
    }
}

/// The body that sets the largest steps, and its state that does, however springs are folded.
pub struct Worst {
    body: usize,
    system: System,
    mode: Vec<[f64; 3]>,
}

/// Finds the largest stable steps of what is explicit in a scene, and what sets them.
pub fn largest_steps(assembly: &Assembly, explicit: Explicit) -> (LargestSteps, Option<Worst>) {
    let any = f64::INFINITY;
    let none = LargestSteps { at_rest: any, folded: any, in_air: any, body: 0 };
    (0..assembly.bodies.len()).fold((none, None), |(least, worst), body| {
        let system = System::new(assembly, body, explicit);
        let ([at_rest, blown_on], _) = system.largest_step(Pull::Along);
        if at_rest < least.at_rest {
            let ([folded, in_air], mode) = system.largest_step(Pull::AnyWay);
            let steps =
                LargestSteps { at_rest, folded: folded.min(at_rest), in_air: in_air.min(blown_on), body };
            (steps, Some(Worst { body, system, mode }))
        } else {
            (least, worst)
        }
    })
}

/// The direction in which a spring resists.
#[derive(Clone, Copy, PartialEq)]
enum Pull {
    /// Along itself.
    Along,
    /// Any: the bound for all states.
    AnyWay,
}

fn spring(places: &[[f64; 3]], kind: SpringKind, nodes: [u32; 2], [k, d]: [f64; 2]) -> Axis {
    let [a, b] = nodes.map(|node| places[node as usize]);
    let along = sub(b, a);
    let length = norm(along);
    // A spring that starts without length may take any direction.
    let along = if length > 0.0 { scale(along, 1.0 / length) } else { [1.0, 0.0, 0.0] };
    Axis { kind, nodes, along, k, d }
}

impl System {
    fn new(assembly: &Assembly, index: usize, explicit: Explicit) -> Self {
        let body = &assembly.bodies[index];
        let elements: Vec<&List> = assembly.elements().iter().filter(|list| explicit.has(list)).collect();
        let mut system = match (&body.springs, body.grid_layout) {
            (BodySprings::Grid(along), Some(layout)) => {
                Self::of_grid((body, index), &elements, along, Patch::of(body, index, &elements, layout))
            }
            (BodySprings::Mesh(lists), _) => Self::of_mesh((body, index), &elements, lists),
            (BodySprings::Grid(_), None) => Self::default(),
        };
        system.drag = assembly.world.drag;
        if explicit != Explicit::Springs {
            system.springs = Vec::new();
        }
        system
    }

    fn of_mesh((body, index): (&BodyAssembly, usize), elements: &[&List], lists: &[SpringList]) -> Self {
        let springs = |list: &SpringList| {
            let axis = |&pair: &[u32; 2]| spring(&body.start, list.kind, pair, [list.k, list.d]);
            list.pairs.iter().map(axis).collect::<Vec<_>>()
        };
        let of_list = |list: &&List| {
            let first = body.first as u32;
            let local = |(nodes, numbers)| (nodes, numbers, |node: u32| Some(node - first));
            Modes::new(list.kind, &body.start, list.of(list.bodies[index].clone()).map(local))
        };
        Self {
            springs: lists.iter().flat_map(springs).collect(),
            elements: elements.iter().filter_map(of_list).collect(),
            root_inverse_mass: (0..body.nodes).map(|node| root_inverse_mass(body, node)).collect(),
            drag: 0.0,
            patch: None,
        }
    }

    /// A patch of a grid.
    fn of_grid(
        (body, index): (&BodyAssembly, usize),
        elements: &[&List],
        along: &GridDirections,
        patch: Patch,
    ) -> Self {
        let (layout, [rows, cols]) = (patch.all, patch.small);
        // A grid starts flat and even, so its first nodes show where all of the patch would be.
        let step =
            |node: usize| if node < body.nodes { sub(body.start[node], body.start[0]) } else { [0.0; 3] };
        let (down, across) = (step(layout[1]), step(if layout[1] > 1 { 1 } else { usize::MAX }));
        let place = |n: usize| add(scale(down, (n / cols) as f64), scale(across, (n % cols) as f64));
        let places: Vec<[f64; 3]> = (0..rows * cols).map(place).collect();
        let mut springs = Vec::new();
        for n in 0..rows * cols {
            for ((&(rows_down, cols_across), kind), spec) in GRID_STEPS.iter().zip(GRID_KINDS).zip(along) {
                let to = ((n / cols) + rows_down, (n % cols).checked_add_signed(cols_across));
                if let (Some([k, d, _]), (row, Some(col))) = (spec, to)
                    && row < rows
                    && col < cols
                {
                    springs.push(spring(&places, kind, [n as u32, (row * cols + col) as u32], [*k, *d]));
                }
            }
        }
        let of_list = |list: &&List| {
            let of_body = list.of(list.bodies[index].clone());
            let inside = |(nodes, numbers)| Some((nodes, numbers, patch.mover(nodes, body.first)?));
            Modes::new(list.kind, &places, of_body.filter_map(inside))
        };
        Self {
            springs,
            elements: elements.iter().filter_map(of_list).collect(),
            root_inverse_mass: (0..rows * cols).map(|n| root_inverse_mass(body, patch.of_grid(n))).collect(),
            drag: 0.0,
            patch: Some(patch),
        }
    }
}

impl Modes {
    /// Those of elements by nodes, numbers and what gives a node's number among `places`; `None` where there are none.
    fn new<'e, M: Fn(u32) -> Option<u32>>(
        kind: &Kind,
        places: &[[f64; 3]],
        elements: impl Iterator<Item = (&'e [u32], &'e [f64], M)>,
    ) -> Option<Self> {
        let visit = kind.modes?;
        let mut modes = Self {
            kind: kind.name,
            width: kind.nodes,
            nodes: Vec::new(),
            directions: Vec::new(),
            stiffness: Vec::new(),
        };
        for (nodes, numbers, mover) in elements {
            let Some(nodes) = nodes.iter().map(|&node| mover(node)).collect::<Option<Vec<u32>>>() else {
                continue;
            };
            let x: Vec<[f64; 3]> = nodes.iter().map(|&node| places[node as usize]).collect();
            visit(&x, numbers, &mut |directions, stiffness| {
                modes.nodes.extend(&nodes);
                modes.directions.extend(directions);
                modes.stiffness.push(stiffness);
            });
        }
        (!modes.stiffness.is_empty()).then_some(modes)
    }

    /// Number of modes.
    fn len(&self) -> usize {
        self.stiffness.len()
    }

    /// Nodes, directions, and k, d, `stiffest` of each.
    fn iter(&self) -> impl Iterator<Item = (&[u32], &[[f64; 3]], [f64; 3])> {
        let ends = self.nodes.chunks_exact(self.width).zip(self.directions.chunks_exact(self.width));
        ends.zip(&self.stiffness).map(|((nodes, directions), &stiffness)| (nodes, directions, stiffness))
    }
}

fn root_inverse_mass(body: &BodyAssembly, node: usize) -> f64 {
    if body.free[node] { (1.0 / body.mass[node]).sqrt() } else { 0.0 }
}

impl System {
    /// A state without any order.
    fn any_state(&self) -> Vec<[f64; 3]> {
        let mut random = SplitMix64::new(1);
        self.root_inverse_mass.iter().map(|_| [(); 3].map(|()| random.unit() - 0.5)).collect()
    }

    /// The largest step [s], and that in any flow of air, by the same mode; and the mode.
    fn largest_step(&self, pull: Pull) -> ([f64; 2], Vec<[f64; 3]>) {
        let any = self.any_state();
        let mut u = any.clone();
        let mut steps = [1.0; 2];
        for _ in 0..ROUNDS {
            // What is fastest at a long step may have nothing of what is fastest at a short one, as waves in the plane of a sheet
            // have nothing of those across it: iteration would never come from one to the other.
            u = half_of_each(&u, &any);
            let mode = self.worst_mode(&mut u, steps[0], pull);
            let next = [ROOM, ROOM_IN_AIR].map(|room| step_within(room, mode));
            let settled = next[0].is_infinite() || (next[0] - steps[0]).abs() < 1e-4 * next[0];
            steps = next;
            if settled {
                break;
            }
        }
        (steps.map(|step| SAFETY * step), u)
    }

    /// Stiffness and damping of the mode with the largest h²κ + 2hδ, by power iteration from `u`.
    fn worst_mode(&self, u: &mut Vec<[f64; 3]>, h: f64, pull: Pull) -> (f64, f64) {
        let mut last = 0.0;
        let mut rates = (0.0, 0.0);
        let elements: usize = self.elements.iter().map(Modes::len).sum();
        for _ in 0..(ENOUGH / (1 + self.springs.len() + elements)).clamp(30, 300) {
            let length = u.iter().map(|&x| dot(x, x)).sum::<f64>().sqrt();
            if length == 0.0 {
                return (0.0, 0.0);
            }
            for x in u.iter_mut() {
                *x = scale(*x, 1.0 / length);
            }
            let (next, kappa, delta) = self.apply(u, h, pull);
            rates = (kappa, delta);
            *u = next;
            let value = h * h * kappa + 2.0 * h * delta;
            if (value - last).abs() < 1e-6 * value {
                break;
            }
            last = value;
        }
        rates
    }

    /// (h²K + 2hD) u with unit masses, and the shares κ = uᵀKu, δ = uᵀDu.
    fn apply(&self, u: &[[f64; 3]], h: f64, pull: Pull) -> (Vec<[f64; 3]>, f64, f64) {
        let mut out = vec![[0.0; 3]; u.len()];
        let w = &self.root_inverse_mass;
        let mut rates = Rates { kappa: 0.0, delta: 0.0 };
        for spring in &self.springs {
            match pull {
                Pull::Along => {
                    let directions = [scale(spring.along, -1.0), spring.along];
                    apply_mode(
                        (&spring.nodes, &directions),
                        [spring.k, spring.d],
                        (u, w, h),
                        &mut out,
                        &mut rates,
                    );
                }
                Pull::AnyWay => spring.apply_any_way(u, w, h, &mut out, &mut rates),
            }
        }
        for (nodes, directions, [k, d, stiffest]) in self.elements.iter().flat_map(Modes::iter) {
            let factor = if pull == Pull::AnyWay { stiffest } else { 1.0 };
            apply_mode((nodes, directions), [factor * k, factor * d], (u, w, h), &mut out, &mut rates);
        }
        let Rates { kappa, mut delta } = rates;
        for ((out, &x), w) in out.iter_mut().zip(u).zip(w) {
            let rate = self.drag * w * w;
            delta += rate * dot(x, x);
            *out = add(*out, scale(x, 2.0 * h * rate));
        }
        (out, kappa, delta)
    }
}

/// The sum of two states of the same length.
fn half_of_each(a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let inverse_length = |u: &[[f64; 3]]| {
        let squared: f64 = u.iter().map(|&x| dot(x, x)).sum();
        if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 }
    };
    let [of_a, of_b] = [a, b].map(inverse_length);
    a.iter().zip(b).map(|(&a, &b)| add(scale(a, of_a), scale(b, of_b))).collect()
}

/// The step [s] at which h²κ + 2hδ comes to `room`; infinite if neither is there.
fn step_within(room: f64, (kappa, delta): (f64, f64)) -> f64 {
    if kappa > 0.0 {
        ((delta * delta + room * kappa).sqrt() - delta) / kappa
    } else if delta > 0.0 {
        room / (2.0 * delta)
    } else {
        f64::INFINITY
    }
}

/// uᵀKu and uᵀDu.
struct Rates {
    kappa: f64,
    delta: f64,
}

/// Adds what a mode with stiffness k and damping d does.
fn apply_mode(
    (nodes, directions): (&[u32], &[[f64; 3]]),
    [k, d]: [f64; 2],
    (u, w, h): (&[[f64; 3]], &[f64], f64),
    out: &mut [[f64; 3]],
    rates: &mut Rates,
) {
    let along = |(&node, &n): (&u32, &[f64; 3])| w[node as usize] * dot(n, u[node as usize]);
    let strain: f64 = nodes.iter().zip(directions).map(along).sum();
    rates.kappa += k * strain * strain;
    rates.delta += d * strain * strain;
    let pull = (h * h * k + 2.0 * h * d) * strain;
    for (&node, &n) in nodes.iter().zip(directions) {
        let out = &mut out[node as usize];
        *out = add(*out, scale(n, pull * w[node as usize]));
    }
}

impl Axis {
    /// As if the spring resisted in every direction.
    fn apply_any_way(&self, u: &[[f64; 3]], w: &[f64], h: f64, out: &mut [[f64; 3]], rates: &mut Rates) {
        let [a, b] = self.nodes.map(|node| node as usize);
        let strain = sub(scale(u[b], w[b]), scale(u[a], w[a]));
        rates.kappa += self.k * dot(strain, strain);
        rates.delta += self.d * dot(strain, strain);
        let pull = scale(strain, h * h * self.k + 2.0 * h * self.d);
        out[a] = sub(out[a], scale(pull, w[a]));
        out[b] = add(out[b], scale(pull, w[b]));
    }
}
