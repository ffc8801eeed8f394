//! The largest stable step of symplectic Euler with damped springs.
//!
//! Linearised: M ẍ = −K x − D ẋ, where a spring gives K = k n nᵀ, D = d n nᵀ along its direction n, and other elements the same
//! along the directions of their modes (a hinge along ∇θ). A mode with κ = uᵀM^-½KM^-½u and δ = uᵀM^-½DM^-½u is stable while
//! h²κ + 2hδ < 4; the worst mode is found by a search (mode.rs). For a flat grid with equal springs of all three kinds it gives
//! k h² + 2 d h < 4 m/10.125.
//!
//! That holds at rest. Folded or slack springs may pull in any direction, but no stiffer than k: with k I in place of
//! k n nᵀ the same search bounds every state (16.3 in place of 10.125, without damping). Other elements are taken as stiff as
//! they can become.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::assembly::springs::{SpringKind, SpringList};
use crate::elements::aero;
use crate::elements::element::{Kind, List};
use crate::elements::spring::stencil::GRID_STEPS;
use crate::real::{add, dot, norm, scale, sub};
use mode::{Goal, Mode, Pull};
use patch::Patch;
use std::rc::Rc;

mod mode;
mod parts;
mod patch;

/// What h²κ + 2hδ must stay below.
const ROOM: f64 = 4.0;
/// The same in air, which in a step may take all of a velocity (elements/aero/aero.rs): 2hδ of its own is 2 at most.
const ROOM_IN_AIR: f64 = 2.0;

/// Kinds of the springs in each direction of a grid.
const GRID_KINDS: [SpringKind; 6] = {
    use SpringKind::{Bend, Shear, Structural};
    [Structural, Bend, Structural, Bend, Shear, Shear]
};

/// The search comes to the largest step from above.
const SAFETY: f64 = 0.995;

/// How far directions of springs may differ that are the same but for roundings.
const SAME: f64 = 1e-9;

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
#[derive(Clone, PartialEq)]
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
    /// By how much less than springs one by one those between all of some nodes resist at each of them: k and d.
    shared: Vec<[f64; 2]>,
    /// Of each node [kg/s].
    drag: f64,
    /// Whether air acts on the body.
    is_blown_on: bool,
    /// What part of a grid it shows.
    patch: Option<Patch>,
}

/// The largest stable steps [s] of what is explicit in a scene; infinite if nothing sets one.
#[derive(Clone, Copy, Debug)]
pub struct LargestSteps {
    /// As the scene starts.
    pub at_rest: f64,
    /// The body that sets it.
    pub stiffest: usize,
    /// However springs are folded.
    pub folded: f64,
    /// The same in any flow of air that acts on bodies.
    pub in_air: f64,
    /// The body that sets it.
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
    system: Rc<System>,
    mode: Vec<[f64; 3]>,
}

/// Finds the largest stable steps of what is explicit in a scene, and what sets them. Of a body that is stable at a step of `enough` [s]
/// they may be shorter, by a bound that costs little.
pub fn largest_steps(assembly: &Assembly, explicit: Explicit, enough: f64) -> (LargestSteps, Option<Worst>) {
    let any = f64::INFINITY;
    let mut steps = LargestSteps { at_rest: any, stiffest: 0, folded: any, in_air: any, body: 0 };
    let mut worst = None;
    let mut last: Option<Rc<System>> = None;
    for body in 0..assembly.bodies.len() {
        let system = Rc::new(System::new(assembly, body, explicit));
        if last.as_ref().is_some_and(|last| system.is_like(last)) {
            continue;
        }
        let sure = system.sure_steps();
        let (found, mode) = if sure[1] < enough && sure[0] < steps.at_rest {
            let (found, mode) = system.search(body, enough);
            (found, Some(mode))
        } else {
            (LargestSteps { at_rest: sure[0], stiffest: body, folded: sure[0], in_air: sure[1], body }, None)
        };
        if found.at_rest < steps.at_rest {
            (steps.at_rest, steps.stiffest) = (found.at_rest, body);
        }
        steps.folded = steps.folded.min(found.folded);
        if found.in_air < steps.in_air {
            (steps.in_air, steps.body) = (found.in_air, body);
            worst = mode.map(|mode| Worst { body, system: Rc::clone(&system), mode });
        }
        last = Some(system);
    }
    (steps, worst)
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
        system.is_blown_on = !assembly.elements_of(aero::NAME, index).is_empty();
        if explicit != Explicit::Springs {
            (system.springs, system.shared) = (Vec::new(), Vec::new());
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
        let mut system = Self {
            springs: lists.iter().flat_map(springs).collect(),
            elements: elements.iter().filter_map(of_list).collect(),
            root_inverse_mass: (0..body.nodes).map(|node| root_inverse_mass(body, node)).collect(),
            ..Self::default()
        };
        if let Some(list) = lists.iter().find(|list| list.kind == SpringKind::Structural) {
            system.share_triangles(body, [list.k, list.d]);
        }
        system
    }

    /// Notes what triangles of springs resist less than their springs one by one. With half of each edge, as others may have the
    /// other half, their eigenvalue is 3/2 k, and the sum of its edges would be 2 k at each corner.
    fn share_triangles(&mut self, body: &BodyAssembly, resists: [f64; 2]) {
        let (Some(surface), Some(edges)) = (&body.surface, &body.edges) else { return };
        if edges.non_manifold_edges() > 0 {
            return;
        }
        self.shared = vec![[0.0; 2]; body.nodes];
        for corners in &surface.triangles {
            self.share(
                corners.map(|node| body.solver_local(node as usize)),
                resists.map(|resists| 0.5 * resists),
            );
        }
    }

    /// Notes what nodes share, if none of them is held.
    fn share<const N: usize>(&mut self, nodes: [usize; N], less: [f64; 2]) {
        if nodes.iter().all(|&node| self.root_inverse_mass[node] > 0.0) {
            for node in nodes {
                let [k, d] = &mut self.shared[node];
                (*k, *d) = (*k + less[0], *d + less[1]);
            }
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
        let mut system = Self {
            springs,
            elements: elements.iter().filter_map(of_list).collect(),
            root_inverse_mass: (0..rows * cols).map(|n| root_inverse_mass(body, patch.of_grid(n))).collect(),
            patch: Some(patch),
            ..Self::default()
        };
        system.share_cells([rows, cols], along);
        system
    }

    /// Notes what cells of a grid resist less than their springs one by one. With half of each edge, k and l, and both diagonals, m, their
    /// eigenvalues are k + l, k + 2 m and l + 2 m, and the sum of its springs would be k + l + 2 m at each corner.
    fn share_cells(&mut self, [rows, cols]: [usize; 2], along: &GridDirections) {
        let [Some(first), _, Some(second), _, Some(shear), Some(_)] = along else { return };
        let less = [0, 1].map(|i| first[i].min(second[i]).min(2.0 * shear[i]));
        self.shared = vec![[0.0; 2]; rows * cols];
        for n in (0..(rows - 1) * cols).filter(|n| n % cols + 1 < cols) {
            self.share([n, n + 1, n + cols, n + cols + 1], less);
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
    /// What h²κ + 2hδ must stay below, and in any flow of air that acts on the body.
    fn rooms(&self) -> [f64; 2] {
        [ROOM, if self.is_blown_on { ROOM_IN_AIR } else { ROOM }]
    }

    /// How many elements and springs it has.
    fn len(&self) -> usize {
        self.springs.len() + self.elements.iter().map(Modes::len).sum::<usize>()
    }

    /// Steps [s] that are stable however springs are folded, without air and in it, shorter than the largest ones. The matrix of an
    /// element is at most a diagonal one, in which a node has the length of the element's direction there times the sum of all of them:
    /// their difference is diagonally dominant. What is left then is to look at each node by itself.
    fn sure_steps(&self) -> [f64; 2] {
        let w = &self.root_inverse_mass;
        let of_node =
            |node: usize| self.shared.get(node).map_or([0.0, self.drag], |[k, d]| [-k, self.drag - d]);
        let mut rates: Vec<[f64; 2]> = (0..w.len()).map(of_node).collect();
        let mut add = |node: u32, length: f64, [k, d]: [f64; 2]| {
            let [kappa, delta] = &mut rates[node as usize];
            (*kappa, *delta) = (*kappa + length * k, *delta + length * d);
        };
        let is_free = |node: u32| w[node as usize] > 0.0;
        for spring in &self.springs {
            let free = spring.nodes.into_iter().filter(|&node| is_free(node)).count() as f64;
            spring.nodes.into_iter().for_each(|node| add(node, free, [spring.k, spring.d]));
        }
        for (nodes, directions, [k, d, stiffest]) in self.elements.iter().flat_map(Modes::iter) {
            let ends = || nodes.iter().zip(directions).filter(|end| is_free(*end.0));
            let all: f64 = ends().map(|(_, &n)| norm(n)).sum();
            ends().for_each(|(&node, &n)| add(node, norm(n) * all * stiffest, [k, d]));
        }
        let [room, in_air] = self.rooms();
        let rates = rates.iter().zip(w).map(|(rates, w)| rates.map(|rate| rate * w * w));
        let steps = rates.fold([f64::INFINITY; 2], |[still, blown_on], rates| {
            [still.min(step_within(room, rates)), blown_on.min(step_within(in_air, rates))]
        });
        // One on the limit does not calm down.
        steps.map(|step| SAFETY * step)
    }

    /// The largest steps [s] of a body that has this system, and the mode that sets them however springs are folded. If they are
    /// `enough`, that at rest, which is longer, is not looked for.
    fn search(&self, body: usize, enough: f64) -> (LargestSteps, Vec<[f64; 3]>) {
        let ([folded, in_air], mode) = self.largest_step(Pull::AnyWay);
        let [at_rest, blown_on] =
            if in_air >= enough { [folded, in_air] } else { self.largest_step(Pull::Along).0 };
        let (folded, in_air) = (folded.min(at_rest), in_air.min(blown_on));
        (LargestSteps { at_rest, stiffest: body, folded, in_air, body }, mode)
    }

    /// Whether it has the same steps as another, however springs are folded.
    fn is_like(&self, other: &Self) -> bool {
        let alike = |(a, b): (&Axis, &Axis)| {
            (a.nodes, a.k, a.d) == (b.nodes, b.k, b.d) && norm(sub(a.along, b.along)) < SAME
        };
        self.springs.len() == other.springs.len()
            && self.is_blown_on == other.is_blown_on
            && self.root_inverse_mass == other.root_inverse_mass
            && self.springs.iter().zip(&other.springs).all(alike)
            && self.elements == other.elements
    }

    /// The largest step [s], and that in any flow of air, by the same mode; and the mode.
    fn largest_step(&self, pull: Pull) -> ([f64; 2], Vec<[f64; 3]>) {
        let Mode { kappa, delta, u } = self.worst(pull, Goal::Step(ROOM));
        (self.rooms().map(|room| SAFETY * step_within(room, [kappa, delta])), u)
    }

    /// Of a state u with unit masses, for each node: u, K u and D u.
    fn multiplied(&self, u: impl Iterator<Item = [f64; 3]>, pull: Pull) -> Vec<[f64; 9]> {
        let mut all: Vec<[f64; 9]> = u.map(|[x, y, z]| [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
        let w = &self.root_inverse_mass;
        for spring in &self.springs {
            let [a, b] = spring.nodes.map(|node| node as usize);
            let moved = |node: usize| scale([all[node][0], all[node][1], all[node][2]], w[node]);
            let strain = sub(moved(b), moved(a));
            let strain = match pull {
                Pull::Along => scale(spring.along, dot(spring.along, strain)),
                Pull::AnyWay => strain,
            };
            let resists = [spring.k, spring.d];
            add_to(&mut all[a], scale(strain, -w[a]), resists);
            add_to(&mut all[b], scale(strain, w[b]), resists);
        }
        for (nodes, directions, [k, d, stiffest]) in self.elements.iter().flat_map(Modes::iter) {
            let factor = if pull == Pull::AnyWay { stiffest } else { 1.0 };
            let ends = || nodes.iter().map(|&node| node as usize).zip(directions);
            let strain: f64 = ends().map(|(i, &n)| w[i] * dot(n, [all[i][0], all[i][1], all[i][2]])).sum();
            let resists = [factor * k, factor * d];
            ends().for_each(|(i, &n)| add_to(&mut all[i], scale(n, strain * w[i]), resists));
        }
        for (node, w) in all.iter_mut().zip(w) {
            let u = [node[0], node[1], node[2]];
            add_to(node, scale(u, w * w), [0.0, self.drag]);
        }
        all
    }
}

/// Adds what resists a strain with k and d.
fn add_to(node: &mut [f64; 9], strain: [f64; 3], [k, d]: [f64; 2]) {
    for axis in 0..3 {
        node[3 + axis] += k * strain[axis];
        node[6 + axis] += d * strain[axis];
    }
}

/// The step [s] at which h²κ + 2hδ comes to `room`; infinite if neither is there.
fn step_within(room: f64, [kappa, delta]: [f64; 2]) -> f64 {
    room / (delta + (delta * delta + room * kappa).sqrt())
}

#[cfg(test)]
mod tests;
