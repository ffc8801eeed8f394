//! Loads on the CPU: wind, drag, point loads and torques of the scene, and forces by the user.

use crate::cpu::cells::PerWorker;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::simd::Kernel;
use crate::cpu::tile::{Tile, within};
use crate::cpu::worker::Worker;
use crate::elements::load::build::{Load, LoadKind};
use crate::elements::load::load;
use crate::real::{Real, scale};
use crate::step::Op;
use std::ops::Range;

/// The loads of a scene.
pub struct Loads<T> {
    loads: Vec<Load>,
    /// Factor of each load that is a torque [N/m]: each worker finds all of them.
    torques: PerWorker<Vec<T>>,
}

impl<T: Real> Loads<T> {
    /// For some workers.
    pub fn new(loads: &[Load], workers: usize) -> Self {
        Self { loads: loads.to_vec(), torques: PerWorker::new(workers, |_| Vec::new()) }
    }

    /// Factor of each load that is a torque [N/m], as last found.
    #[cfg(feature = "gpu")]
    pub fn torques(&mut self) -> &[T] {
        self.torques.iter_mut().next().map_or(&[], |torques| torques)
    }

    fn sum_torques(&self, worker: &Worker<'_, T>) {
        let state = worker.old();
        let mut torques = self.torques.of(worker.index);
        torques.clear();
        for (load, &scale) in self.loads.iter().zip(worker.substep.scales()) {
            torques.push(match load.kind {
                LoadKind::Force(_) => T::ZERO,
                LoadKind::Torque { axis, value, about } => {
                    let (axis, about) = (axis.map(T::from_f64), about.map(T::from_f64));
                    let place = |&node: &u32| [0, 1, 2].map(|c| state[c][node as usize]);
                    let levers = load.nodes.iter().map(|node| load::lever(place(node), axis, about));
                    load::torque_factor(T::from_f64(value) * scale, levers)
                }
            });
        }
    }

    fn add_point_loads(&self, tile: &mut Tile<'_, T>, at: usize, run: &Range<usize>) {
        if self.loads.is_empty() && tile.input.forces.is_empty() {
            return;
        }
        let torques = self.torques.read(tile.worker);
        let scales = tile.substep.scales();
        for (index, load) in self.loads.iter().enumerate() {
            for &node in within(&load.nodes, run, |&node| node) {
                let force = match load.kind {
                    LoadKind::Force(f) => scale(f.map(T::from_f64), scales[index]),
                    LoadKind::Torque { axis, about, .. } => {
                        let x = [0, 1, 2].map(|c| tile.old[c][node as usize]);
                        let lever = load::lever(x, axis.map(T::from_f64), about.map(T::from_f64));
                        load::torque_force(torques[index], lever)
                    }
                };
                tile.add_force(at + node as usize - run.start, force);
            }
        }
        let input = tile.input;
        for &(node, force) in within(&input.forces, run, |&(node, _)| node) {
            tile.add_force(at + node as usize - run.start, force.map(T::from_f64));
        }
    }
}

impl<T: Real> Feature<T> for Loads<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Elements, Op::Loads]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        self.sum_torques(worker);
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        for axis in 0..3 {
            for (at, run) in tile.plan.runs() {
                tile.nodes.level.run(WindAndDrag {
                    force: &mut tile.scratch.force[axis][at..at + run.len()],
                    velocity: &tile.old[3 + axis][run],
                    wind: T::from_f64(tile.substep.wind_force[axis]),
                    drag: T::from_f64(tile.substep.drag),
                });
            }
        }
        for (at, run) in tile.plan.runs() {
            self.add_point_loads(tile, at, &run);
        }
    }
}

/// Kernel: wind and drag along one axis.
struct WindAndDrag<'a, T> {
    force: &'a mut [T],
    velocity: &'a [T],
    wind: T,
    drag: T,
}

impl<T: Real> Kernel for WindAndDrag<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        if self.drag == T::ZERO {
            self.force.fill(self.wind);
            return;
        }
        for (force, &velocity) in self.force.iter_mut().zip(self.velocity) {
            *force = load::wind_and_drag(self.wind, self.drag, velocity);
        }
    }
}
