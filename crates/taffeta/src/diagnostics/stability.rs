//! The largest stable step of symplectic Euler with damped springs.
//!
//! Linearised at the start: M ẍ = −K x − D ẋ, where a spring gives K = k n nᵀ, D = d n nᵀ along its direction n, and
//! a hinge the same along ∇θ. A mode with κ = uᵀM^-½KM^-½u and δ = uᵀM^-½DM^-½u is stable while h²κ + 2hδ < 4; the
//! worst mode is found by power iteration on h²K + 2hD. For a flat grid with equal springs of all three kinds it
//! gives k h² + 2 d h < 4 m/10.125. It holds at rest: slack or folded cloth needs steps up to 1.27 times smaller.

use crate::assembly::{Assembly, BodyAssembly, BodySprings};
use crate::forces::hinge;
use crate::real::{dot, norm, scale, sub};
use crate::topology::random::SplitMix64;

/// How much smaller steps folded or slack cloth may need than cloth at rest: √(16.3/10.125).
pub const FOLDED: f64 = 1.27;

/// Rows and columns of a grid that are looked at: its corners and edges, and enough of its middle for the shortest
/// waves, which are the fastest.
const PATCH: usize = 48;

/// Something that pulls on a few nodes along fixed directions.
struct Element<const N: usize> {
    nodes: [u32; N],
    directions: [[f64; 3]; N],
    k: f64,
    d: f64,
}

/// A body's elements and inverse masses.
#[derive(Default)]
struct System {
    springs: Vec<Element<2>>,
    hinges: Vec<Element<4>>,
    root_inverse_mass: Vec<f64>,
}

/// The largest stable step [s] of a scene, and the body that sets it; infinite if nothing does.
pub fn largest_step(assembly: &Assembly) -> (f64, usize) {
    let steps = assembly.bodies.iter().map(|body| system(body).largest_step(assembly.world.drag));
    steps.enumerate().fold((f64::INFINITY, 0), |best, (index, step)| if step < best.0 { (step, index) } else { best })
}

fn system(body: &BodyAssembly) -> System {
    let (nodes, mut system) = match (&body.springs, &body.grid) {
        (BodySprings::Grid(_), Some(_)) => grid_patch(body),
        _ => mesh(body),
    };
    system.root_inverse_mass =
        nodes.iter().map(|&n| if body.free[n] { (1.0 / body.mass[n]).sqrt() } else { 0.0 }).collect();
    system
}

fn spring(body: &BodyAssembly, [a, b]: [usize; 2], at: [u32; 2], k: f64, d: f64) -> Option<Element<2>> {
    let along = sub(body.start[b], body.start[a]);
    let length = norm(along);
    (length > 0.0).then(|| {
        let n = scale(along, 1.0 / length);
        Element { nodes: at, directions: [scale(n, -1.0), n], k, d }
    })
}

fn mesh(body: &BodyAssembly) -> (Vec<usize>, System) {
    let mut system = System::default();
    if let BodySprings::Mesh(lists) = &body.springs {
        for list in lists {
            let element = |&pair: &[u32; 2]| spring(body, pair.map(|n| n as usize), pair, list.k, list.d);
            system.springs.extend(list.pairs.iter().filter_map(element));
        }
    }
    system.hinges = body.hinges.iter().map(|&nodes| bend(body, nodes.map(|n| n as usize), nodes)).collect();
    ((0..body.nodes).collect(), system)
}

fn bend(body: &BodyAssembly, corners: [usize; 4], at: [u32; 4]) -> Element<4> {
    let (_, directions) = hinge::angle_and_gradient(corners.map(|n| body.start[n]));
    Element { nodes: at, directions, k: body.hinge.k, d: body.hinge.d }
}

/// The corners of a grid, put together to a small one.
fn grid_patch(body: &BodyAssembly) -> (Vec<usize>, System) {
    let mut system = System::default();
    let (BodySprings::Grid(along), Some(grid)) = (&body.springs, &body.grid) else { return (Vec::new(), system) };
    let (rows, cols) = (grid.rows as usize, grid.cols as usize);
    let (small_rows, small_cols) = (rows.min(PATCH), cols.min(PATCH));
    let real = |i: usize, small: usize, all: usize| if i < small / 2 { i } else { i + all - small };
    let nodes: Vec<usize> = (0..small_rows * small_cols)
        .map(|n| real(n / small_cols, small_rows, rows) * cols + real(n % small_cols, small_cols, cols))
        .collect();
    for row in 0..small_rows {
        for col in 0..small_cols {
            for (&(down, across), spec) in crate::topology::GRID_STEPS.iter().zip(along) {
                let (Some([k, d, _]), Some(to)) = (spec, col.checked_add_signed(across)) else { continue };
                if row + down >= small_rows || to >= small_cols {
                    continue;
                }
                // The direction is that of neighbours near the first corner: it is the same all over the grid.
                let from_col = if across < 0 { 1 } else { 0 };
                let ends = [from_col, (down * cols + from_col).wrapping_add_signed(across)];
                let at = [(row * small_cols + col) as u32, ((row + down) * small_cols + to) as u32];
                system.springs.extend(spring(body, ends, at, *k, *d));
            }
        }
    }
    if !body.hinges.is_empty() && small_rows == rows && small_cols == cols {
        system.hinges = body.hinges.iter().map(|&h| bend(body, h.map(|n| n as usize), h)).collect();
    } else if let Some(&first) = body.hinges.first() {
        // On a large grid hinges are many and alike: the strongest of the first few rows, on its own nodes.
        system.hinges.push(bend(body, first.map(|n| n as usize), [0, 1, small_cols as u32, small_cols as u32 + 1]));
    }
    (nodes, system)
}

impl System {
    fn largest_step(&self, drag: f64) -> f64 {
        let n = self.root_inverse_mass.len();
        let mut random = SplitMix64::new(1);
        let mut u: Vec<[f64; 3]> = (0..n).map(|_| [(); 3].map(|()| random.unit() - 0.5)).collect();
        let mut h = 1.0;
        for _ in 0..4 {
            let (kappa, delta) = self.worst_mode(&mut u, h, drag);
            let next = if kappa > 0.0 {
                ((delta * delta + 4.0 * kappa).sqrt() - delta) / kappa
            } else if delta > 0.0 {
                2.0 / delta
            } else {
                return f64::INFINITY;
            };
            let settled = (next - h).abs() < 1e-4 * next;
            h = next;
            if settled {
                break;
            }
        }
        h
    }

    /// Stiffness and damping of the mode with the largest h²κ + 2hδ, by power iteration from `u`.
    fn worst_mode(&self, u: &mut Vec<[f64; 3]>, h: f64, drag: f64) -> (f64, f64) {
        let mut last = 0.0;
        let mut rates = (0.0, 0.0);
        for _ in 0..300 {
            let length = u.iter().map(|&x| dot(x, x)).sum::<f64>().sqrt();
            if !(length > 0.0) {
                return (0.0, 0.0);
            }
            for x in u.iter_mut() {
                *x = scale(*x, 1.0 / length);
            }
            let (next, kappa, delta) = self.apply(u, h, drag);
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
    fn apply(&self, u: &[[f64; 3]], h: f64, drag: f64) -> (Vec<[f64; 3]>, f64, f64) {
        let mut out = vec![[0.0; 3]; u.len()];
        let (mut kappa, mut delta) = (0.0, 0.0);
        let w = &self.root_inverse_mass;
        for element in &self.springs {
            element.apply(u, w, h, &mut out, &mut kappa, &mut delta);
        }
        for element in &self.hinges {
            element.apply(u, w, h, &mut out, &mut kappa, &mut delta);
        }
        for ((out, &x), w) in out.iter_mut().zip(u).zip(w) {
            let rate = drag * w * w;
            delta += rate * dot(x, x);
            *out = crate::real::add(*out, scale(x, 2.0 * h * rate));
        }
        (out, kappa, delta)
    }
}

impl<const N: usize> Element<N> {
    fn apply(
        &self,
        u: &[[f64; 3]],
        w: &[f64],
        h: f64,
        out: &mut [[f64; 3]],
        kappa: &mut f64,
        delta: &mut f64,
    ) {
        let nodes = self.nodes.map(|node| node as usize);
        let strain: f64 =
            nodes.iter().zip(&self.directions).map(|(&node, &n)| w[node] * dot(n, u[node])).sum();
        *kappa += self.k * strain * strain;
        *delta += self.d * strain * strain;
        let pull = (h * h * self.k + 2.0 * h * self.d) * strain;
        for (&node, &n) in nodes.iter().zip(&self.directions) {
            out[node] = crate::real::add(out[node], scale(n, pull * w[node]));
        }
    }
}
