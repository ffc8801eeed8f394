//! What the springs of a body become: constraints by colour, and coarser levels of limits.
//!
//! On each level nodes are some of those of the finer one, and the others follow them by weights. A limit is between two nodes of a level
//! (Matthias Müller, "Hierarchical Position Based Dynamics", VRIPHYS 2008). A node of a level is at the mean of those that follow
//! it, each by its mass and weight, and has their mass: the mean restricts, the weights prolongate, as in multigrid methods. As one is the
//! transpose of the other, a limit changes no momentum, and does the same work on the level as on the nodes. If a node stood where one
//! node of the finer level is, the jitter of that would move all that follow. A limit lets its ends be as far apart as they are at rest,
//! but on a mesh that starts folded as far as the cloth between them is long.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::assembly::springs::{SpringKind, SpringList};
use crate::real::{add, scale};
use crate::scene::Xpbd;
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::xpbd::colours::colours;
use crate::solvers::xpbd::grid::GridLevels;
use crate::solvers::xpbd::mesh;
use std::ops::Range;

/// Most levels of limits.
pub const MOST_LEVELS: usize = 16;

/// Most sweeps over the limits of a level.
const MOST_SWEEPS: usize = 8;

/// Times that the limits of a level, from 1 for the finest of limits, act in a sub-step: twice as often as those of the level below it, as
/// they are a fourth as many.
pub fn sweeps(level: usize) -> usize {
    MOST_SWEEPS.min(1 << (level - 1).min(MOST_SWEEPS))
}

/// The springs of a body and its levels of limits.
pub enum BodyConstraints {
    /// Of a grid, whose springs follow from rows and columns.
    Grid { springs: GridDirections, levels: GridLevels },
    /// By lists.
    Mesh(Lists),
}

/// Constraints as lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lists {
    /// Springs, between nodes of the body.
    pub springs: Coloured,
    /// Stiffness [N/m] and damping [kg/s] of each material.
    pub materials: Vec<[f64; 2]>,
    /// From the finest to the coarsest.
    pub levels: Vec<Level>,
}

/// A level of limits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Level {
    /// Which node of the finer level each node is.
    pub own: Vec<u32>,
    /// For each node of the finer level the nodes that it follows, by weights whose sum is 1.
    pub parents: Weighted,
    /// Its limits; of no material.
    pub limits: Coloured,
}

/// Constraints, those of one colour after those of another. No two of a colour share a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coloured {
    /// Nodes at the ends.
    pub ends: Vec<[u32; 2]>,
    /// Squared length at rest [m²].
    pub rest: Vec<f64>,
    /// Which material.
    pub material: Vec<u32>,
    /// Those of each colour.
    pub colours: Vec<Range<usize>>,
}

/// The constraints of all bodies; none of one without springs. None at all with another method.
#[derive(Default)]
pub struct Constraints(pub Vec<Option<BodyConstraints>>);

impl Constraints {
    /// Of some bodies.
    pub fn new(bodies: &[BodyAssembly], wish: &Xpbd) -> Self {
        Self(bodies.iter().map(|body| BodyConstraints::new(body, wish)).collect())
    }
}

impl Assembly {
    /// Springs that are constraints on positions, by body.
    pub fn position_constraints(&self) -> &[Option<BodyConstraints>] {
        self.extensions.get::<Constraints>().map_or(&[], |all| &all.0)
    }

    /// The same, for a backend to keep.
    pub(crate) fn take_position_constraints(&mut self) -> Vec<Option<BodyConstraints>> {
        match self.extensions.get::<Constraints>() {
            Some(_) => std::mem::take(&mut self.extensions.get_mut::<Constraints>().0),
            None => Vec::new(),
        }
    }
}

impl BodyConstraints {
    fn new(body: &BodyAssembly, wish: &Xpbd) -> Option<Self> {
        let most = wish.levels.map_or(MOST_LEVELS, |levels| levels as usize).min(MOST_LEVELS);
        let slack = 1.0 + wish.stretch_limit;
        match (&body.springs, body.grid_layout) {
            (BodySprings::Grid(along), Some(layout)) => {
                let acts = along.iter().flatten().any(|&[k, d, _]| k > 0.0 || d > 0.0);
                acts.then(|| Self::Grid {
                    springs: *along,
                    levels: GridLevels::new(layout, along, (most, slack)),
                })
            }
            (BodySprings::Mesh(_), _) => Self::of_mesh(body, (most, slack)),
            (BodySprings::Grid(_), None) => None,
        }
    }

    fn of_mesh(body: &BodyAssembly, limits: (usize, f64)) -> Option<Self> {
        let BodySprings::Mesh(lists) = &body.springs else { return None };
        let mut all = Lists::default();
        let mut springs: Vec<([u32; 2], f64, u32)> = Vec::new();
        for list in lists.iter().filter(|list| list.k > 0.0 || list.d > 0.0) {
            let material = all.materials.len() as u32;
            all.materials.push([list.k, list.d]);
            springs.extend(
                list.pairs
                    .iter()
                    .zip(&list.rest)
                    .map(|(&[a, b], &rest)| ([a.min(b), a.max(b)], rest, material)),
            );
        }
        // Those along edges first, by node: neighbours are near in memory.
        springs.sort_by_key(|&(ends, _, material)| (material, ends));
        all.springs = Coloured::new(body.nodes, springs.into_iter());
        let resists = |list: &SpringList| list.kind == SpringKind::Structural && list.k > 0.0;
        if lists.iter().any(resists) {
            all.levels = mesh::levels(body, limits);
        }
        (!all.springs.ends.is_empty()).then_some(Self::Mesh(all))
    }

    /// The same as lists, in the order in which they act.
    #[cfg(test)]
    pub fn into_lists(self, body: &BodyAssembly) -> Lists {
        match self {
            Self::Mesh(lists) => lists,
            Self::Grid { springs, levels } => {
                crate::solvers::xpbd::grid::lists(&springs, &levels, Nodes::of(body))
            }
        }
    }
}

impl Coloured {
    /// Colours constraints, each with its ends, its length at rest [m] and its material.
    pub fn new(nodes: usize, all: impl Iterator<Item = ([u32; 2], f64, u32)>) -> Self {
        let all: Vec<_> = all.collect();
        let pairs: Vec<[u32; 2]> = all.iter().map(|one| one.0).collect();
        let colour = colours(nodes, &pairs);
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by_key(|&one| colour[one]);
        let mut coloured = Self::default();
        for group in order.chunk_by(|&a, &b| colour[a] == colour[b]) {
            coloured.add(group.iter().map(|&one| (all[one].0, all[one].1 * all[one].1, all[one].2)));
        }
        coloured
    }

    /// Adds a colour: ends, squared length at rest [m²], material of each.
    pub fn add(&mut self, all: impl Iterator<Item = ([u32; 2], f64, u32)>) {
        let from = self.ends.len();
        for (ends, rest, material) in all {
            self.ends.push(ends);
            self.rest.push(rest);
            self.material.push(material);
        }
        if from < self.ends.len() {
            self.colours.push(from..self.ends.len());
        }
    }
}

/// What the nodes of a level have.
#[derive(Clone, Debug)]
pub struct Nodes {
    /// Mass [kg], and position at rest [m].
    pub mass: Vec<f64>,
    pub position: Vec<[f64; 3]>,
    pub held: Vec<bool>,
}

impl Nodes {
    /// Those of a body.
    pub fn of(body: &BodyAssembly) -> Self {
        let held = body.free.iter().map(|free| !free).collect();
        Self { mass: body.mass.clone(), position: body.start.clone(), held }
    }

    /// Of a coarser level, whose nodes are `own` of these: means of those that follow them; where a held one follows a node most, it
    /// holds that, its own before others.
    pub fn coarser(&self, own: &[u32], parents: &Weighted) -> Self {
        let count = own.len();
        let (mut mass, mut sums, mut holder) = (vec![0.0; count], vec![[0.0; 3]; count], vec![None; count]);
        for row in 0..parents.rows() {
            let of = parents.row(row);
            for &(parent, weight) in of {
                let share = f64::from(weight) * self.mass[row];
                mass[parent as usize] += share;
                sums[parent as usize] = add(sums[parent as usize], scale(self.position[row], share));
            }
            let most = of.iter().reduce(|most, one| if one.1 > most.1 { one } else { most });
            if let Some(&(most, _)) = most.filter(|_| self.held[row]) {
                let holder = &mut holder[most as usize];
                if *holder != Some(own[most as usize] as usize) {
                    *holder = Some(row);
                }
            }
        }
        let position = (0..count).map(|node| match holder[node] {
            Some(row) => self.position[row],
            None if mass[node] > 0.0 => scale(sums[node], 1.0 / mass[node]),
            None => self.position[own[node] as usize],
        });
        Self { position: position.collect(), mass, held: holder.iter().map(Option::is_some).collect() }
    }
}

/// The least of some masses [kg], but for nodes without any.
pub fn lightest(masses: &[f64]) -> f64 {
    masses.iter().copied().filter(|&mass| mass > 0.0).fold(f64::INFINITY, f64::min)
}

/// Masses of the nodes of a level [kg], from those of the finer one.
pub fn masses(parents: &Weighted, nodes: usize, finer: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; nodes];
    for (row, mass) in finer.iter().enumerate() {
        for &(parent, weight) in parents.row(row) {
            all[parent as usize] += f64::from(weight) * mass;
        }
    }
    all
}
