//! The largest tension of implicit springs, and the step that it limits.
//!
//! An implicit spring takes any step along itself, but its direction is that of the old state. So a wave across a line
//! of masses m at distances L under the pull T is one of symplectic Euler: ω² = 4 T/(m L) sin²(q/2), stable while
//! h² ω² < 4, which is h² T/(m L) < 1 for the shortest waves. For any net of springs it is h² λmax/4 < 1, with λmax
//! that of the Laplacian with weights T/L, divided by the masses.
//!
//! The tensions are estimated from the connections of nodes, not from their positions: a body starts in another shape
//! than that in which it comes to hang. Each node passes its load on to the nodes nearer to a pin, along its springs.
//! If the body were stretched evenly away from the pins, a spring of length L between distances that differ by c L
//! would be longer by c² L, and c of its tension would carry; so its fraction is proportional to k c³ L. A compliant
//! spring is as long as its tension makes it, L + T/k, and T/L is less than k however heavy the load is. λmax is
//! bounded by the sums of rows (Gershgorin).
//!
//! Air loads a node with the most that it can do to the triangles there, as if they were perpendicular to the flow.
//! Cloth that streams along it has less tension.
//!
//! For a chain the step is at most a tenth too short. For sheets and meshes that hang from a row, corners or single
//! nodes, λmax was found to be 0.85 to 2.1 times that of the true statics, so the step is 0.7 to 1.1 times the right
//! one. It is too long if the weight hangs from a line that pins hold taut: the straighter it is, the higher its
//! tension. Motion increases tension, too: three times the weight at the bottom of an arc.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::diagnostics::wind;
use crate::elements::spring::stencil::GRID_STEPS;
use crate::real::{add, norm, scale};
use crate::topology::Csr;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The largest tension relative to the masses, by the weight of hanging bodies and by air.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Method, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // A chain of a metre and a kilogram that hangs from one end: of its 11 nodes 9 pull on the second link.
/// let chain = Body::cloth("chain", Mesh::chain(10, 1.0)).with_mass(Mass::Whole(1.0)).structural(1e6, 0.0);
/// let scene = Scene::new("hangs").time(0.01, 1e-3).body(chain.pin(Select::nodes([0]))).method(Method::Ice);
/// let simulation = Simulation::new(&scene, &Options::default())?;
/// let tension = simulation.max_tension().expect("it hangs");
/// assert_eq!(tension.vertex, 2);
/// assert!((tension.pull - 0.85 * 9.81).abs() < 1e-9);
/// assert!(tension.growth(1e-3) < 1.0 && tension.growth(1.01 * tension.largest_step()) > 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tension {
    /// Name of the body.
    pub body: String,
    /// The vertex, in the mesh's own order.
    pub vertex: usize,
    /// Largest tension T of its springs [N].
    pub pull: f64,
    /// T/(m L), as the mean over both sides [1/s²].
    pub rate: f64,
}

impl Tension {
    /// h² T/(m L) of a step `h` [s]: transverse waves grow if it is above 1.
    pub fn growth(&self, h: f64) -> f64 {
        h * h * self.rate
    }

    /// The longest step [s] in which they do not.
    pub fn largest_step(&self) -> f64 {
        1.0 / self.rate.sqrt()
    }
}

/// Estimates the largest T/(m L) of all bodies, whose springs are `compliant` or have their rest length; `None` if
/// nothing hangs: there is no load, or no pin.
pub fn max_tension(assembly: &Assembly, compliant: bool) -> Option<Tension> {
    let world = &assembly.world;
    let pushes = wind::pushes(assembly);
    let of_body = |body: &BodyAssembly| {
        let push = |node: usize| pushes.get(body.first + node).copied().unwrap_or(0.0);
        let weight = |mass: f64| norm(add(scale(world.gravity, mass), world.wind_force));
        let loads = body.mass.iter().enumerate().map(|(node, &mass)| weight(mass) + push(node));
        let (local, pull, rate) = Hanging::new(body).steepest(loads.collect(), compliant)?;
        Some(Tension { body: body.name.clone(), vertex: body.vertex_of_solver(local), pull, rate })
    };
    assembly.bodies.iter().filter_map(of_body).max_by(|a, b| a.rate.total_cmp(&b.rate))
}

/// A body's springs by node.
enum Springs<'a> {
    Grid { along: &'a GridDirections, size: [usize; 2] },
    Mesh { pairs: Vec<[u32; 2]>, kinds: Vec<[f64; 2]>, by_node: Csr },
}

/// A spring as one of its nodes sees it.
#[derive(Clone, Copy)]
struct Spring {
    to: usize,
    /// Length at rest [m].
    length: f64,
    /// Stiffness [N/m].
    k: f64,
}

impl<'a> Springs<'a> {
    fn new(body: &'a BodyAssembly) -> Self {
        match (&body.springs, body.grid_layout) {
            (BodySprings::Grid(along), Some(size)) => Self::Grid { along, size },
            (BodySprings::Mesh(lists), _) => {
                let pairs: Vec<_> = lists.iter().flat_map(|list| &list.pairs).copied().collect();
                let kinds =
                    lists.iter().flat_map(|list| list.rest.iter().map(|&rest| [rest, list.k])).collect();
                let by_node = Csr::corners(body.nodes, &pairs);
                Self::Mesh { pairs, kinds, by_node }
            }
            (BodySprings::Grid(_), None) => Self::Mesh {
                pairs: Vec::new(),
                kinds: Vec::new(),
                by_node: Csr::corners::<2>(body.nodes, &[]),
            },
        }
    }

    /// Visits the springs at a node that resist.
    fn around(&self, node: usize, mut visit: impl FnMut(Spring)) {
        let mut each = |to, [length, k]: [f64; 2]| {
            if k > 0.0 {
                visit(Spring { to, length, k });
            }
        };
        match self {
            Self::Grid { along, size: [rows, cols] } => {
                let (row, col) = (node / cols, node % cols);
                for (&(down, across), spec) in GRID_STEPS.iter().zip(*along) {
                    let Some([k, _, length]) = *spec else { continue };
                    let ends = [
                        (Some(row + down), col.checked_add_signed(across)),
                        (row.checked_sub(down), col.checked_add_signed(-across)),
                    ];
                    for (r, c) in ends {
                        if let (Some(r), Some(c)) = (r.filter(|r| r < rows), c.filter(|c| c < cols)) {
                            each(r * cols + c, [length, k]);
                        }
                    }
                }
            }
            Self::Mesh { pairs, kinds, by_node } => {
                for &end in by_node.row(node) {
                    let [spring, side] = [end / 2, end % 2].map(|i| i as usize);
                    each(pairs[spring][1 - side] as usize, kinds[spring]);
                }
            }
        }
    }
}

/// A body that hangs from its pins.
struct Hanging<'a> {
    body: &'a BodyAssembly,
    springs: Springs<'a>,
    /// Distance from the nearest pin along springs [m]; infinite if no pin holds.
    distance: Vec<f64>,
    /// Nodes that pins hold, nearest first.
    order: Vec<u32>,
}

impl<'a> Hanging<'a> {
    /// Measures distances (Dijkstra 1959).
    fn new(body: &'a BodyAssembly) -> Self {
        let springs = Springs::new(body);
        let mut distance: Vec<f64> =
            body.free.iter().map(|&free| if free { f64::INFINITY } else { 0.0 }).collect();
        // Bits of numbers that are not negative are in their order.
        let entry = |distance: f64, node: usize| Reverse((distance.to_bits(), node as u32));
        let mut next: BinaryHeap<_> =
            (0..body.nodes).filter(|&n| !body.free[n]).map(|n| entry(0.0, n)).collect();
        let mut order = Vec::new();
        while let Some(Reverse((bits, node))) = next.pop() {
            let at = f64::from_bits(bits);
            // Else a shorter way was found after this one was noted.
            if at == distance[node as usize] {
                order.push(node);
                springs.around(node as usize, |Spring { to, length, .. }| {
                    if at + length < distance[to] {
                        distance[to] = at + length;
                        next.push(entry(at + length, to));
                    }
                });
            }
        }
        Self { body, springs, distance, order }
    }

    /// Passes the load of each node on to the pins. Returns the node with the largest T/(m L) [1/s²], and its largest
    /// tension [N].
    fn steepest(&self, mut carried: Vec<f64>, compliant: bool) -> Option<(usize, f64, f64)> {
        let Self { body, springs, distance, order } = self;
        let mut pulls = vec![(0.0_f64, 0.0_f64); body.nodes];
        for node in order.iter().rev().map(|&node| node as usize).filter(|&node| body.free[node]) {
            // Fraction of the load that a spring takes, by k c³ L, and the part of its tension that carries.
            let share = |Spring { to, length, k }: Spring| {
                let carries = ((distance[node] - distance[to]) / length).clamp(0.0, 1.0);
                (k * carries.powi(3) * length, carries)
            };
            let mut all = 0.0;
            springs.around(node, |spring| all += share(spring).0);
            let load = carried[node];
            springs.around(node, |spring| {
                let (part, carries) = share(spring);
                if part > 0.0 {
                    let flow = load * part / all;
                    carried[spring.to] += flow;
                    let pull = flow / carries;
                    let longer = if compliant { pull / spring.k } else { 0.0 };
                    let length = spring.length + longer;
                    // A row's sum has the diagonal, and what stands beside it if the other end is free.
                    let both = if body.free[spring.to] { 2.0 } else { 1.0 };
                    for end in [node, spring.to] {
                        pulls[end].0 = pulls[end].0.max(pull);
                        pulls[end].1 += both * pull / length;
                    }
                }
            });
        }
        let rated = (0..body.nodes).filter(|&node| body.free[node]).map(|node| {
            let (pull, sum) = pulls[node];
            (node, pull, 0.25 * sum / body.mass[node])
        });
        rated.filter(|(.., rate)| *rate > 0.0 && rate.is_finite()).max_by(|a, b| a.2.total_cmp(&b.2))
    }
}
