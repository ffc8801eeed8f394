//! Springs on the CPU: of grids by sweeps over rows, of meshes by gathers, and what is measured of them.

use crate::assembly::body::{BodyAssembly, BodySprings};
use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::feature::Feature;
use crate::cpu::lanes::Lanes;
use crate::cpu::numbers::Numbers;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::cpu::tile::Tile;
use crate::cpu::tiles::{TILE_NODES, TilePlan};
use crate::cpu::worker::Worker;
use crate::elements::spring::cpu_gathers::level_for_gathers;
use crate::elements::spring::cpu_grid::{Direction, GridSprings, Sweep};
use crate::elements::spring::cpu_mesh::{GatheredSprings, gather, lanes_of};
use crate::elements::spring::cpu_narrow::{Masks, NARROW, NarrowSweep};
use crate::elements::spring::spring;
use crate::real::{Real, norm};
use crate::report::FrameSums;
use crate::scene::Method;
use crate::step::{Marks, Op};
use crate::topology::LANES;

/// The springs of all bodies.
pub struct Springs<T> {
    bodies: Vec<BodyRows<T>>,
    /// Stretch from which on springs have their tile wait for a solver, if they do.
    stretch_limit: Option<T>,
    /// Whether springs have energy: as constraints on positions they have forces that their stretch does not say.
    have_energy: bool,
    /// Of wide grids and of narrow ones.
    sweeps: PerWorker<(Sweep<T>, NarrowSweep<T>)>,
    /// By tile: energy [J], and the largest stretch.
    sums: Numbers<2>,
}

/// The springs of a body.
enum BodyRows<T> {
    /// By rows.
    Grid(GridSprings<T>),
    /// By blocks of rows.
    Narrow(GridSprings<T>, Masks<T>),
    /// By slices; where the body keeps its volume, the first are those along its edges.
    Mesh { sets: Vec<GatheredSprings<T>>, has_rings: bool },
}

impl<T: Real> BodyRows<T> {
    fn new(body: &BodyAssembly, level: SimdLevel) -> Result<Self, String> {
        match &body.springs {
            BodySprings::Grid(along) => {
                let [rows, cols] = body.grid_layout.ok_or("a grid's springs without a grid")?;
                let along = along.map(|direction| direction.map(Direction::new));
                let grid = GridSprings { rows, cols, along };
                let masks = || Masks::new(cols, rows.saturating_mul(cols).min(TILE_NODES));
                Ok(if cols <= NARROW { Self::Narrow(grid, masks()) } else { Self::Grid(grid) })
            }
            BodySprings::Mesh(_) => {
                // Tried now: the first frame is not to wait for it.
                level_for_gathers(level);
                let set = |(k, d, gather)| GatheredSprings::new((k, d), gather, body.nodes);
                let sets = body.gathered()?.into_iter().map(set).collect();
                Ok(Self::Mesh { sets, has_rings: body.volume().is_some() })
            }
        }
    }
}

impl<T: Real> Springs<T> {
    /// Those of a scene.
    pub fn new(context: &Context<'_, T>) -> Result<Self, String> {
        let solver = &context.assembly.solver;
        let adaptive = solver.method == Method::Acad && !context.assembly.constraints().is_empty();
        let stretch_limit = adaptive.then(|| T::from_f64(1.0 + solver.acad.threshold));
        let columns = context.nodes.tiles.iter().map(|tile| tile.cols.len()).max().unwrap_or(0);
        let nodes = context.nodes.tiles.iter().map(TilePlan::len).max().unwrap_or(0);
        Ok(Self {
            bodies: (context.assembly.bodies.iter().map(|body| BodyRows::new(body, context.nodes.level)))
                .collect::<Result<_, _>>()?,
            stretch_limit,
            have_energy: solver.method != Method::Xpbd,
            sweeps: PerWorker::new(context.workers(), |_| {
                (Sweep::new(columns, stretch_limit), NarrowSweep::new(nodes, stretch_limit))
            }),
            sums: Numbers::new(context.nodes.tiles.len()),
        })
    }

    /// The springs along the edges of a body that keeps its volume: where there are none, its edges.
    pub fn rings(&self, body: usize) -> Option<&GatheredSprings<T>> {
        match &self.bodies[body] {
            BodyRows::Mesh { sets, has_rings: true } => sets.first(),
            _ => None,
        }
    }

    fn add(&self, tile: &mut Tile<'_, T>) {
        let old = tile.old.map(|column| &column[tile.plan.first..]);
        let (plan, level) = (tile.plan, tile.nodes.level);
        let force = &mut tile.scratch.force;
        let (wide, narrow) = &mut *self.sweeps.of(tile.worker);
        let is_beyond = match &self.bodies[plan.body] {
            BodyRows::Grid(grid) => {
                wide.springs(level, (plan.body, grid), (plan.units.clone(), plan.cols.clone()), old, force)
            }
            BodyRows::Narrow(grid, masks) => {
                narrow.springs(level, (plan.body, grid, masks), plan.units.clone(), old, force)
            }
            BodyRows::Mesh { sets, has_rings } => {
                // Those along rings are not watched.
                let mut is_beyond = *has_rings;
                let level = level_for_gathers(level);
                for set in &sets[usize::from(*has_rings)..] {
                    is_beyond |= set.springs(level, plan.units.clone(), old, force, self.stretch_limit);
                }
                is_beyond
            }
        };
        if is_beyond && self.stretch_limit.is_some() {
            tile.marks.set(tile.marks.get().and(Marks::SOLVED));
        }
    }

    fn measure_tile(&self, tile: &Tile<'_, T>) {
        let state = tile.old.map(|column| &column[tile.plan.first..]);
        let (plan, level) = (tile.plan, tile.nodes.level);
        let mut sums = [0.0; 2];
        match &self.bodies[plan.body] {
            BodyRows::Grid(grid) | BodyRows::Narrow(grid, _) => {
                for row in plan.units.clone() {
                    for direction in 0..6 {
                        let end = grid.count(direction, row).min(plan.cols.end);
                        let count = end.saturating_sub(plan.cols.start);
                        if let (Some(along), 1..) = (grid.along[direction], count) {
                            let (a, b) = grid.ends(direction, row);
                            let [a, b] = [a + plan.cols.start, b + plan.cols.start];
                            level.run(RowStretch { state, a, b, count, along, sums: &mut sums });
                        }
                    }
                }
            }
            BodyRows::Mesh { sets, .. } => {
                let level = level_for_gathers(level);
                for springs in sets {
                    for slice in plan.units.clone() {
                        level.run(SliceStretch { state, springs, slice, sums: &mut sums });
                    }
                }
            }
        }
        self.sums.set(tile.index, sums);
    }

    /// Energy [J] and largest stretch of the tiles that `chosen` says, as last measured.
    pub fn sums_of(&self, chosen: impl Fn(usize) -> bool) -> [f64; 2] {
        let tiles = self.sums.iter().enumerate().filter(|(tile, _)| chosen(*tile));
        tiles.fold([0.0; 2], |[energy, most], (_, sums)| {
            [energy + sums[0], if sums[1] > most { sums[1] } else { most }]
        })
    }
}

impl<T: Real> Feature<T> for Springs<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Springs, Op::MeasureTiles]
    }

    fn begin(&self, worker: &mut Worker<'_, T>) {
        let (wide, narrow) = &mut *self.sweeps.of(worker.index);
        wide.restart();
        narrow.restart();
    }

    fn tile(&self, op: Op, tile: &mut Tile<'_, T>) {
        if op == Op::Springs { self.add(tile) } else { self.measure_tile(tile) }
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        let [energy, stretch] = self.sums_of(|_| true);
        sums.all.springs = if self.have_energy { energy } else { 0.0 };
        sums.all.max_stretch = stretch;
    }

    fn bytes(&self) -> usize {
        let of_body = |body: &BodyRows<T>| match body {
            BodyRows::Grid(_) => 0,
            BodyRows::Narrow(_, masks) => masks.bytes(),
            BodyRows::Mesh { sets, .. } => sets.iter().map(GatheredSprings::bytes).sum(),
        };
        self.bodies.iter().map(of_body).sum()
    }
}

/// Adds energy and notes the largest stretch.
#[inline(always)]
fn note(sums: &mut [f64; 2], energy: f64, stretch: f64) {
    sums[0] += energy;
    sums[1] = if stretch > sums[1] { stretch } else { sums[1] };
}

/// Kernel: energy and stretch of one row's springs in one direction.
struct RowStretch<'a, T> {
    state: [&'a [T]; 6],
    a: usize,
    b: usize,
    count: usize,
    along: Direction<T>,
    sums: &'a mut [f64; 2],
}

impl<T: Real> Kernel for RowStretch<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { state, a, b, count, along, sums } = self;
        let [ax, ay, az] = [0, 1, 2].map(|c| &state[c][a..a + count]);
        let [bx, by, bz] = [0, 1, 2].map(|c| &state[c][b..b + count]);
        let (mut energy, mut longest) = (Lanes::ZERO, Lanes::ZERO);
        for start in (0..count).step_by(LANES) {
            for (lane, i) in (start..count.min(start + LANES)).enumerate() {
                let length = norm([bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]]);
                energy.0[lane] += spring::energy(length, along.k, along.rest_length).to_f64();
                let length = length.to_f64();
                longest.0[lane] = if length > longest.0[lane] { length } else { longest.0[lane] };
            }
        }
        note(sums, energy.total(), longest.largest() / along.rest_length.to_f64());
    }
}

/// Kernel: energy and stretch of one slice's springs. Each is met from both ends: half its energy each time.
struct SliceStretch<'a, T> {
    state: [&'a [T]; 6],
    springs: &'a GatheredSprings<T>,
    slice: usize,
    sums: &'a mut [f64; 2],
}

impl<T: Real> Kernel for SliceStretch<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { state, springs, slice, sums } = self;
        let own = lanes_of(&state, slice);
        let mut other = [[T::ZERO; LANES]; 6];
        let (mut energy, mut longest) = (Lanes::ZERO, Lanes::ZERO);
        for (neighbours, rest_lengths) in springs.slice(slice) {
            gather(&state, neighbours, &mut other);
            for lane in 0..LANES {
                let rest = rest_lengths[lane];
                let d = [
                    other[0][lane] - own[0][lane],
                    other[1][lane] - own[1][lane],
                    other[2][lane] - own[2][lane],
                ];
                let length = norm(d);
                let (length, rest, k) =
                    if rest > T::ZERO { (length, rest, springs.k) } else { (T::ZERO, T::ONE, T::ZERO) };
                energy.0[lane] += spring::energy(length, k, rest).to_f64() * 0.5;
                let stretch = (length / rest).to_f64();
                longest.0[lane] = if stretch > longest.0[lane] { stretch } else { longest.0[lane] };
            }
        }
        note(sums, energy.total(), longest.largest());
    }
}
