//! The largest stable step of symplectic Euler with damped springs.
//!
//! Linearised: M ẍ = −K x − D ẋ, where a spring gives K = k n nᵀ, D = d n nᵀ along its direction n, and a hinge the same
//! along ∇θ. A mode with κ = uᵀM^-½KM^-½u and δ = uᵀM^-½DM^-½u is stable while h²κ + 2hδ < 4; the worst mode is found by
//! power iteration on h²K + 2hD. For a flat grid with equal springs of all three kinds it gives
//! k h² + 2 d h < 4 m/10.125.
//!
//! That holds at rest. Folded or slack springs may pull in any direction, but no stiffer than k: with k I in place of
//! k n nᵀ the same iteration bounds every state (16.3 in place of 10.125, without damping). Hinges are taken as stiff as
//! squashed triangles can make them.

use crate::build::Assembly;
use crate::build::body::{BodyAssembly, BodySprings, GridDirections};
use crate::elements::hinge::hinge::{Rest, STIFFEST, angle_and_gradient, rest, steepness};
use crate::elements::spring::lists::SpringList;
use crate::elements::spring::stencil::GRID_STEPS;
use crate::real::{add, dot, norm, scale, sub};
use crate::scene::Hinge;
use crate::topology::random::SplitMix64;
use crate::topology::{Edges, shapes};

/// Rows and columns of a grid that are looked at: its corners and edges, and enough of its middle for the shortest
/// waves, which are the fastest.
const PATCH: usize = 48;

/// Element visits that a power iteration may take; with millions of springs fewer rounds must do.
const ENOUGH: usize = 30_000_000;

/// What h²κ + 2hδ must stay below.
const ROOM: f64 = 4.0;
/// The same in air, which in a step may take all of a velocity (forces/air.rs): 2hδ of its own is 2 at most.
const ROOM_IN_AIR: f64 = 2.0;

/// Power iteration comes to the largest eigenvalue from below.
const SAFETY: f64 = 0.995;

/// Something that pulls on a few nodes along fixed directions.
#[derive(Clone, Copy)]
struct Element<const N: usize> {
    nodes: [u32; N],
    directions: [[f64; 3]; N],
    k: f64,
    d: f64,
    /// How much stiffer it may become.
    stiffest: f64,
}

/// A body's elements and inverse masses.
#[derive(Default)]
struct System {
    springs: Vec<Element<2>>,
    hinges: Vec<Element<4>>,
    /// 1/√m [kg^-½]; 0 for held nodes.
    root_inverse_mass: Vec<f64>,
}

/// The largest stable steps [s] of what is explicit in a scene; infinite if nothing sets one.
#[derive(Clone, Copy, Debug)]
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

/// Finds the largest stable steps of what is explicit in a scene: hinges, drag and, unless all of them are implicit,
/// `springs`.
pub fn largest_steps(assembly: &Assembly, springs: bool) -> LargestSteps {
    let drag = assembly.world.drag;
    let any = f64::INFINITY;
    let none = LargestSteps { at_rest: any, folded: any, in_air: any, body: 0 };
    assembly.bodies.iter().enumerate().fold(none, |least, (body, described)| {
        let mut system = System::new(described);
        if !springs {
            system.springs = Vec::new();
        }
        let [at_rest, blown_on] = system.largest_step(drag, Pull::Along);
        if at_rest < least.at_rest {
            let [folded, in_air] = system.largest_step(drag, Pull::AnyWay);
            LargestSteps { at_rest, folded: folded.min(at_rest), in_air: in_air.min(blown_on), body }
        } else {
            least
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

fn spring(places: &[[f64; 3]], nodes: [u32; 2], k: f64, d: f64) -> Element<2> {
    let [a, b] = nodes.map(|node| places[node as usize]);
    let along = sub(b, a);
    let length = norm(along);
    // A spring that starts without length may take any direction.
    let n = if length > 0.0 { scale(along, 1.0 / length) } else { [1.0, 0.0, 0.0] };
    Element { nodes, directions: [scale(n, -1.0), n], k, d, stiffest: 1.0 }
}

/// A hinge as it starts, which may be another shape than that at rest.
fn bend(places: &[[f64; 3]], nodes: [u32; 4], hinge: Hinge, at_rest: Rest<f64>) -> Element<4> {
    let (_, directions) = angle_and_gradient(nodes.map(|node| places[node as usize]));
    let most = STIFFEST * at_rest.steepness / steepness(&directions);
    // A hinge without height has no way to go, and neither has one without height at rest.
    let (now, stiffest) =
        if most > 0.0 && most.is_finite() { (most.min(1.0), most.max(1.0)) } else { (0.0, 1.0) };
    Element { nodes, directions, k: now * hinge.k, d: now * hinge.d, stiffest }
}

impl System {
    fn new(body: &BodyAssembly) -> Self {
        match (&body.springs, body.grid_layout) {
            (BodySprings::Grid(along), Some(layout)) => Self::of_grid(body, along, layout),
            (BodySprings::Mesh(lists), _) => Self::of_mesh(body, lists),
            (BodySprings::Grid(_), None) => Self::default(),
        }
    }

    fn of_mesh(body: &BodyAssembly, lists: &[SpringList]) -> Self {
        let springs = |list: &SpringList| {
            let (k, d) = (list.k, list.d);
            list.pairs.iter().map(|&pair| spring(&body.start, pair, k, d)).collect::<Vec<_>>()
        };
        Self {
            springs: lists.iter().flat_map(springs).collect(),
            hinges: body
                .hinges
                .iter()
                .zip(&body.hinge_rest)
                .map(|(&nodes, &at_rest)| bend(&body.start, nodes, body.hinge, at_rest))
                .collect(),
            root_inverse_mass: (0..body.nodes).map(|node| root_inverse_mass(body, node)).collect(),
        }
    }

    /// The corners of a grid put together to a small one: its fastest waves are as short as two nodes.
    fn of_grid(body: &BodyAssembly, along: &GridDirections, [rows, cols]: [usize; 2]) -> Self {
        let small = [rows.min(PATCH), cols.min(PATCH)];
        let real = |i: usize, small: usize, all: usize| if i < small / 2 { i } else { i + all - small };
        let of_patch =
            |n: usize| real(n / small[1], small[0], rows) * cols + real(n % small[1], small[1], cols);
        // A grid starts flat and even, so its first nodes show where all of the patch would be.
        let step =
            |node: usize| if node < body.nodes { sub(body.start[node], body.start[0]) } else { [0.0; 3] };
        let (down, across) = (step(cols), step(if cols > 1 { 1 } else { usize::MAX }));
        let nodes = small[0] * small[1];
        let places: Vec<[f64; 3]> = (0..nodes)
            .map(|n| add(scale(down, (n / small[1]) as f64), scale(across, (n % small[1]) as f64)))
            .collect();
        let mut springs = Vec::new();
        for n in 0..nodes {
            for (&(rows_down, cols_across), spec) in GRID_STEPS.iter().zip(along) {
                let to = ((n / small[1]) + rows_down, (n % small[1]).checked_add_signed(cols_across));
                if let (Some([k, d, _]), (row, Some(col))) = (spec, to)
                    && row < small[0]
                    && col < small[1]
                {
                    springs.push(spring(&places, [n as u32, (row * small[1] + col) as u32], *k, *d));
                }
            }
        }
        let hinges = if body.hinges.is_empty() { Vec::new() } else { patch_hinges(small) };
        Self {
            springs,
            hinges: hinges
                .into_iter()
                .map(|nodes| bend(&places, nodes, body.hinge, rest(nodes.map(|node| places[node as usize]))))
                .collect(),
            root_inverse_mass: (0..nodes).map(|n| root_inverse_mass(body, of_patch(n))).collect(),
        }
    }
}

fn patch_hinges([rows, cols]: [usize; 2]) -> Vec<[u32; 4]> {
    let surface = shapes::grid_surface(rows as u32, cols as u32, [1.0, 1.0]);
    Edges::new(surface.nodes.len(), &surface.triangles, &surface.links).hinges(&surface.triangles)
}

fn root_inverse_mass(body: &BodyAssembly, node: usize) -> f64 {
    if body.free[node] { (1.0 / body.mass[node]).sqrt() } else { 0.0 }
}

impl System {
    /// The largest step [s], and that in any flow of air, by the same mode.
    fn largest_step(&self, drag: f64, pull: Pull) -> [f64; 2] {
        let n = self.root_inverse_mass.len();
        let mut random = SplitMix64::new(1);
        let mut u: Vec<[f64; 3]> = (0..n).map(|_| [(); 3].map(|()| random.unit() - 0.5)).collect();
        let mut steps = [1.0; 2];
        for _ in 0..4 {
            let mode = self.worst_mode(&mut u, steps[0], (drag, pull));
            let next = [ROOM, ROOM_IN_AIR].map(|room| step_within(room, mode));
            let settled = next[0].is_infinite() || (next[0] - steps[0]).abs() < 1e-4 * next[0];
            steps = next;
            if settled {
                break;
            }
        }
        steps.map(|step| SAFETY * step)
    }

    /// Stiffness and damping of the mode with the largest h²κ + 2hδ, by power iteration from `u`.
    fn worst_mode(&self, u: &mut Vec<[f64; 3]>, h: f64, kind: (f64, Pull)) -> (f64, f64) {
        let mut last = 0.0;
        let mut rates = (0.0, 0.0);
        for _ in 0..(ENOUGH / (1 + self.springs.len() + self.hinges.len())).clamp(30, 300) {
            let length = u.iter().map(|&x| dot(x, x)).sum::<f64>().sqrt();
            if length == 0.0 {
                return (0.0, 0.0);
            }
            for x in u.iter_mut() {
                *x = scale(*x, 1.0 / length);
            }
            let (next, kappa, delta) = self.apply(u, h, kind);
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
    fn apply(&self, u: &[[f64; 3]], h: f64, (drag, pull): (f64, Pull)) -> (Vec<[f64; 3]>, f64, f64) {
        let mut out = vec![[0.0; 3]; u.len()];
        let w = &self.root_inverse_mass;
        let mut rates = Rates { kappa: 0.0, delta: 0.0 };
        for element in &self.springs {
            match pull {
                Pull::Along => element.apply(u, w, h, &mut out, &mut rates),
                Pull::AnyWay => element.apply_any_way(u, w, h, &mut out, &mut rates),
            }
        }
        for element in &self.hinges {
            let stiffer = match pull {
                Pull::Along => element.scaled(1.0),
                Pull::AnyWay => element.scaled(element.stiffest),
            };
            stiffer.apply(u, w, h, &mut out, &mut rates);
        }
        let Rates { kappa, mut delta } = rates;
        for ((out, &x), w) in out.iter_mut().zip(u).zip(w) {
            let rate = drag * w * w;
            delta += rate * dot(x, x);
            *out = add(*out, scale(x, 2.0 * h * rate));
        }
        (out, kappa, delta)
    }
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

impl<const N: usize> Element<N> {
    fn scaled(&self, factor: f64) -> Self {
        Self { k: factor * self.k, d: factor * self.d, ..*self }
    }

    fn apply(&self, u: &[[f64; 3]], w: &[f64], h: f64, out: &mut [[f64; 3]], rates: &mut Rates) {
        let nodes = self.nodes.map(|node| node as usize);
        let strain: f64 =
            nodes.iter().zip(&self.directions).map(|(&node, &n)| w[node] * dot(n, u[node])).sum();
        rates.kappa += self.k * strain * strain;
        rates.delta += self.d * strain * strain;
        let pull = (h * h * self.k + 2.0 * h * self.d) * strain;
        for (&node, &n) in nodes.iter().zip(&self.directions) {
            out[node] = add(out[node], scale(n, pull * w[node]));
        }
    }
}

impl Element<2> {
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
