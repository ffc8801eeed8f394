//! What an element is to the engine: a formula between a few nodes, and the facts that drivers need of it.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::real::{Real, scale};
use crate::scene::Scene;
use std::ops::Range;

/// The formula of an element between `N` nodes that `P` numbers describe: its shape at rest and its material.
///
/// All drivers are written by it: [`ByElement`](crate::elements::cpu::ByElement) on the CPU, [`System`] for the largest stable
/// step. Its twin in WGSL stands beside it, and kernels as [`Kernels`] names them.
///
/// [`System`]: crate::diagnostics::stability
pub trait Element<const N: usize, const P: usize>: Send + Sync + 'static {
    /// Forces [N] on its nodes, at positions `x` [m] with velocities `v` [m/s].
    fn forces<T: Real>(x: [[T; 3]; N], v: [[T; 3]; N], numbers: [T; P]) -> [[T; 3]; N];

    /// Energy [J].
    fn energy<T: Real>(x: [[T; 3]; N], numbers: [T; P]) -> T;

    /// The ways in which it resists near positions `x` [m]; those beyond what its kind has are [`Mode::NONE`].
    fn modes<T: Real>(x: [[T; 3]; N], numbers: [T; P]) -> [Mode<T, N>; MODES];

    /// The ways in which it resists alike whatever the direction, as a string under tension resists across itself: weights by node,
    /// whose sum is 0, and the stiffness k [N/m for weights without a unit], not below 0.
    #[inline(always)]
    fn tensions<T: Real>(_x: [[T; 3]; N], _numbers: [T; P]) -> [([T; N], T); TENSIONS] {
        [([T::ZERO; N], T::ZERO); TENSIONS]
    }
}

/// Modes of an element at most.
pub const MODES: usize = 3;

/// Ways in which an element resists alike in all directions, at most.
pub const TENSIONS: usize = 2;

/// One way in which an element resists: with a stiffness K = k g gᵀ and a damping D = d g gᵀ, where g has a direction for each
/// of its nodes.
#[derive(Clone, Copy, Debug)]
pub struct Mode<T, const N: usize> {
    /// g, by node; their sum is 0.
    pub directions: [[T; 3]; N],
    /// Stiffness along it, not below 0 [N/m for directions without a unit].
    pub k: T,
    /// Damping along it, not below 0 [kg/s].
    pub d: T,
    /// How many times stiffer, and more damped, it may become in another state.
    pub stiffest: T,
}

impl<T: Real, const N: usize> Mode<T, N> {
    /// One that resists nothing.
    pub const NONE: Self = Self { directions: [[T::ZERO; 3]; N], k: T::ZERO, d: T::ZERO, stiffest: T::ONE };

    /// Its directions [kg^½] over a step `h` [s]: g √(h² k + h d), so that their products are what it adds to the matrix of an
    /// implicit step.
    #[inline(always)]
    pub fn over_step(&self, h: T) -> [[T; 3]; N] {
        let root = (h * (h * self.k + self.d)).sqrt();
        let mut all = self.directions;
        for direction in &mut all {
            *direction = scale(*direction, root);
        }
        all
    }
}

/// A kind of elements: facts that do not depend on a scene.
pub struct Kind {
    /// Its name in reports, and of the buffer of its elements in shaders.
    pub name: &'static str,
    /// Nodes of an element.
    pub nodes: usize,
    /// Forces that are kept of an element: one for each node, or one that all its nodes share.
    pub forces: usize,
    /// Nodes with their springs that cost as much time as an element.
    pub cost: usize,
    /// The struct of an element in WGSL: its name, and those of its numbers, which follow `corners`.
    pub record: (&'static str, &'static [&'static str]),
    /// Its kernels.
    pub kernels: Kernels,
    /// Its shaders.
    #[cfg(feature = "gpu")]
    pub shaders: &'static [taffeta_gpu::Shader],
    /// The elements of a body.
    pub build: fn(&BodyAssembly, &Scene, usize) -> Described,
    /// Calls back for each mode of an element at positions by node, for the largest stable step; nothing where it sets none.
    pub modes: Option<Modes>,
    /// How it is solved for where the solver is implicit; nothing where it acts explicitly there, too.
    pub implicit: Option<Implicit>,
}

/// How elements of a kind are solved for.
pub struct Implicit {
    /// Modes of an element, [`MODES`] at most.
    pub modes: usize,
    /// Whether it has ways in which it resists alike in all directions, no more than modes.
    pub is_tense: bool,
    /// Finds directions of modes over the step, an invocation an element, into `element_directions`: by mode, then by node, with
    /// the weights of what resists alike in all directions as the fourth number.
    pub directions: Kernel,
}

/// Visits the modes of an element at some positions [m], with its numbers.
pub type Modes = fn(&[[f64; 3]], &[f64], &mut Visitor<'_>);

/// Is called with directions by node, and k, d, `stiffest`.
pub type Visitor<'v> = dyn FnMut(&[[f64; 3]], [f64; 3]) + 'v;

/// The kernels of a kind of elements.
pub struct Kernels {
    /// Finds forces, an invocation an element, into `element_forces`.
    pub forces: Kernel,
    /// Adds up energies into `element_energies`, where it has some.
    pub energies: Option<Kernel>,
}

/// A kernel, and how far from the CPU's its numbers may be, in units in the last place of the largest.
#[derive(Clone, Copy)]
pub struct Kernel {
    /// Entry point.
    pub entry: &'static str,
    /// On adapters that run kernels on the CPU.
    pub software: f64,
    /// On others, which may fuse a product and a sum.
    pub hardware: f64,
    /// Why so much.
    pub why: &'static str,
}

/// Elements of a body: nodes by the solver's number within the body, and numbers, of one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Described {
    /// Nodes, so many an element.
    pub nodes: Vec<u32>,
    /// Numbers, so many an element.
    pub numbers: Vec<f64>,
    /// What the user should know of them, in words.
    pub warning: Option<String>,
}

/// All elements of a kind in a scene, bodies one after the other.
pub struct List {
    /// Which.
    pub kind: &'static Kind,
    /// Nodes by solver index, and numbers.
    pub all: Described,
    /// The elements of each body.
    pub bodies: Vec<Range<usize>>,
    /// Whether the scene's solver solves for them.
    pub implicit: bool,
    /// What the user should know, in words, and of which body.
    pub warnings: Vec<(usize, String)>,
}

impl Assembly {
    /// Elements whose forces are found one by one, a list for each of [`KINDS`](crate::elements::KINDS).
    pub fn elements(&self) -> &[List] {
        self.extensions.list()
    }

    /// The same, to change them.
    pub fn elements_mut(&mut self) -> &mut [List] {
        self.extensions.get_mut::<Vec<List>>()
    }

    /// Gives back the memory of the lists once backends have theirs.
    pub(crate) fn forget_elements(&mut self) {
        self.elements_mut().iter_mut().for_each(|list| list.all = Described::default());
    }

    /// The elements of a kind, by name, that a body has, among all of its kind.
    pub fn elements_of(&self, kind: &str, body: usize) -> Range<usize> {
        let list = self.elements().iter().find(|list| list.kind.name == kind);
        list.map_or(0..0, |list| list.bodies[body].clone())
    }

    /// Whether a body has elements other than springs that are solved for.
    pub fn has_solved_elements(&self, body: usize) -> bool {
        self.elements().iter().any(|list| list.implicit && !list.bodies[body].is_empty())
    }
}

impl Kind {
    /// The visitor of the modes of a formula.
    pub fn visit<E: Element<N, P>, const N: usize, const P: usize>(
        x: &[[f64; 3]],
        numbers: &[f64],
        see: &mut Visitor<'_>,
    ) {
        let (Ok(x), Ok(numbers)) = (x.try_into(), numbers.try_into()) else {
            unreachable!("a kind has as many nodes and numbers as its formula");
        };
        for mode in E::modes(x, numbers).iter().filter(|mode| mode.k != 0.0 || mode.d != 0.0) {
            see(&mode.directions, [mode.k, mode.d, mode.stiffest]);
        }
        for (weights, k) in E::tensions(x, numbers).into_iter().filter(|tension| tension.1 != 0.0) {
            for axis in 0..3 {
                see(
                    &weights.map(|weight| [0, 1, 2].map(|one| if one == axis { weight } else { 0.0 })),
                    [k, 0.0, 1.0],
                );
            }
        }
    }

    /// All kernels.
    pub fn kernels(&self) -> impl Iterator<Item = Kernel> {
        let directions = self.implicit.as_ref().map(|implicit| implicit.directions);
        [self.kernels.forces].into_iter().chain(self.kernels.energies).chain(directions)
    }

    /// Numbers of an element.
    pub fn numbers(&self) -> usize {
        self.record.1.len()
    }
}

impl Described {
    /// Adds an element.
    pub fn push(&mut self, nodes: &[u32], numbers: &[f64]) {
        self.nodes.extend(nodes);
        self.numbers.extend(numbers);
    }
}

impl List {
    /// Those of a scene whose bodies these are.
    pub fn new(kind: &'static Kind, bodies: &[BodyAssembly], scene: &Scene) -> Self {
        let implicit = kind.implicit.is_some() && scene.solver.is_primal();
        let mut list =
            Self { kind, all: Described::default(), bodies: Vec::new(), implicit, warnings: Vec::new() };
        for (index, body) in bodies.iter().enumerate() {
            let from = list.len();
            let of_body = (kind.build)(body, scene, index);
            list.all.nodes.extend(of_body.nodes.iter().map(|node| node + body.first as u32));
            list.all.numbers.extend(of_body.numbers);
            list.warnings.extend(of_body.warning.map(|warning| (index, warning)));
            list.bodies.push(from..list.len());
        }
        list
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.all.nodes.len() / self.kind.nodes
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.all.nodes.is_empty()
    }

    /// Nodes and numbers of some elements.
    pub fn of(&self, range: Range<usize>) -> impl Iterator<Item = (&[u32], &[f64])> {
        let (nodes, numbers) = (self.kind.nodes, self.kind.numbers());
        range.map(move |i| {
            (&self.all.nodes[i * nodes..(i + 1) * nodes], &self.all.numbers[i * numbers..(i + 1) * numbers])
        })
    }
}
