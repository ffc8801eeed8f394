//! Specimens of fabric: flat meshes, their files and their scenes.

use crate::bench::{Extent, Solver, Variant};
use crate::flat::{Flat, Lattice, Pattern};
use std::fmt::Write;

/// Gravity [m/s²].
pub const GRAVITY: f64 = 9.81;

/// A fabric with one stiffness in all directions of its plane.
#[derive(Clone, Copy, Debug)]
pub struct Plain {
    /// Mass per area [kg/m²].
    pub density: f64,
    /// Membrane stiffness [N/m].
    pub stretch: f64,
    /// Poisson's ratio of the membrane.
    pub poisson: f64,
    /// Flexural rigidity [N·m].
    pub bending: f64,
    /// Poisson's ratio in bending.
    pub bending_poisson: f64,
    /// Damping of stretch and bending [s].
    pub damping: [f64; 2],
}

impl Plain {
    /// The table of a scene.
    pub fn toml(&self) -> String {
        let Self { density, stretch, poisson, bending, bending_poisson, damping } = self;
        let shear = 0.5 * stretch / (1.0 + poisson);
        format!(
            "[body.material]\ndensity = {density:?}\nstretch = {stretch:?}\nshear = {shear:?}\npoisson = {poisson:?}\n\
             bending = {bending:?}\nbending_poisson = {bending_poisson:?}\ntwist = {:?}\nthickness = 1e-3\n\
             damping = {{ stretch = {:?}, bending = {:?} }}\n",
            0.5 * (1.0 - bending_poisson) * bending,
            damping[0],
            damping[1],
        )
    }
}

/// A list of nodes for a scene's `select`.
pub fn nodes(list: &[usize]) -> String {
    let mut text = String::from("{ nodes = [");
    for (index, node) in list.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}{node}", if index == 0 { "" } else { ", " });
    }
    text + "] }"
}

/// A strip of some elements a length, clamped at x = 0: it begins two edges behind.
pub fn strip(length: f64, width: f64, lattice: Lattice) -> Flat {
    let behind = -2.0 * lattice.edge;
    Flat::rectangle([behind, -0.5 * width], [length, 0.5 * width], &[0.0], lattice)
}

/// Nodes of a strip that its clamp holds.
pub fn clamped(strip: &Flat) -> Vec<usize> {
    strip.select(|[x, _]| x < 1e-9)
}

/// Nodes of the free end of a strip.
pub fn tip(strip: &Flat, length: f64) -> Vec<usize> {
    strip.select(|[x, _]| x > length - 1e-9)
}

/// The mesh of a test, and how it is solved.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// How triangles are laid.
    pub pattern: Pattern,
    /// Turn against the outline [degrees].
    pub turn: f64,
    /// Edges a length.
    pub elements: usize,
    /// How it is solved.
    pub solver: Solver,
}

impl Case {
    /// A case that is solved as users do.
    pub fn new(pattern: Pattern, turn: f64, elements: usize) -> Self {
        Self { pattern, turn, elements, solver: Solver::IMPLICIT }
    }

    /// Solved otherwise.
    pub fn by(self, solver: Solver) -> Self {
        Self { solver, ..self }
    }

    /// Its lattice on a length [m].
    pub fn lattice(&self, length: f64) -> Lattice {
        Lattice { pattern: self.pattern, edge: length / self.elements as f64, turn: self.turn }
    }

    /// What its points are called in a plot: those of all turns are alike.
    pub fn line(&self) -> String {
        format!("{}, {}", self.pattern, self.solver.slug())
    }

    /// Its place in a test: names of files and words.
    pub fn variant(&self, test: &str) -> Variant {
        let Self { pattern, turn, elements, solver } = *self;
        let turned = format!("{turn}").replace('.', "_");
        Variant {
            name: format!("{test}-{pattern}-{elements}-{turned}-{}", solver.slug()),
            mesh: format!("{pattern} at {turn}°, {elements}"),
            solver,
        }
    }
}

/// Patterns at all turns and sizes, solved as users do; then the middle size of a grid with the other solvers. A quick run takes the
/// middle size of a turned grid and of the other patterns.
pub fn cases(extent: Extent, elements: [usize; 3]) -> Vec<Case> {
    let middle = elements[1];
    let others = [Solver::EXPLICIT, Solver::DOUBLE, Solver::GPU];
    if extent == Extent::Quick {
        let meshes = [(Pattern::Equilateral, 0.0), (Pattern::Grid, 22.5), (Pattern::Irregular, 0.0)];
        let all = meshes.map(|(pattern, turn)| Case::new(pattern, turn, middle));
        let grid = Case::new(Pattern::Grid, 0.0, middle);
        return all.into_iter().chain([grid.by(Solver::EXPLICIT), grid.by(Solver::GPU)]).collect();
    }
    let mut all = Vec::new();
    for pattern in Pattern::ALL {
        for turn in TURNS {
            all.extend(elements.map(|elements| Case::new(pattern, turn, elements)));
        }
    }
    all.extend(others.map(|solver| Case::new(Pattern::Grid, 0.0, middle).by(solver)));
    all
}

/// Turns of meshes against the outline [degrees]: a grid that is not turned hides faults.
pub const TURNS: [f64; 4] = [0.0, 22.5, 45.0, 135.0];

/// The beginning of a scene: its title, the length of a frame [s] and what acts on it.
pub fn head(title: &str, dt: f64, solver: Solver, world: &str) -> String {
    format!("title = \"{title}\"\n\n[time]\ndt = {dt:?}\n\n[world]\n{world}\n\n{}\n", solver.toml())
}

/// A body of a mesh file of the same name as the variant, and its fabric.
pub fn body(variant: &Variant, fabric: &str) -> String {
    format!("[[body]]\nname = \"cloth\"\nmesh.file = \"{}.obj\"\n{fabric}", variant.name)
}

/// A pin of some nodes.
pub fn pin(list: &[usize]) -> String {
    format!("[[body.pin]]\nselect = {}\n", nodes(list))
}

/// Mean of a coordinate over some nodes [m].
pub fn mean(places: &[[f64; 3]], list: &[usize], axis: usize) -> f64 {
    list.iter().map(|&node| places[node][axis]).sum::<f64>() / list.len().max(1) as f64
}
