//! What the workers do, held against the list of `step.rs`: a feature that carries out every operation writes down each call.

use crate::assembly::Assembly;
use crate::backend::{Backend, FrameInput};
use crate::cpu::CpuBackend;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::team::Team;
use crate::cpu::tile::Tile;
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::scene::{Body, Mass, Mesh, Scene};
use crate::step::{self, Line, Marks, On, Op, Parts};
use std::collections::BTreeSet;
use std::sync::{Arc, LazyLock, Mutex};

/// Every operation, as the lists of all scenes have them.
static OPS: LazyLock<Vec<Op>> = LazyLock::new(|| {
    let lines = Parts::all().flat_map(|parts| step::substep(&parts)).chain(step::frame_end());
    let all: BTreeSet<Op> = lines.flat_map(|line| line.passes().to_vec()).map(|pass| pass.op).collect();
    all.into_iter().collect()
});

const BODIES: usize = 13;
const SUBSTEPS: usize = 2;
/// Rounds after which nothing is left to do.
const ROUNDS: usize = 3;

/// What bodies may be: solved for never, where springs are too long, or always; with a volume or without.
fn marks_of(body: usize) -> Marks {
    let solved = [Marks::NONE, Marks::SOLVED, Marks::SOLVED.and(Marks::IMPLICIT)][body % 3];
    if body.is_multiple_of(2) { solved.and(Marks::VOLUME) } else { solved }
}

/// Whether an operation that moves nodes moves some of a tile.
fn moves(op: Op, tile: usize) -> bool {
    !(tile + op as usize).is_multiple_of(4)
}

/// A call: which worker, and an operation on the scene or on a tile; none where a sub-step begins.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Call {
    worker: usize,
    op: Option<Op>,
    tile: Option<usize>,
}

struct Recorder(Arc<Mutex<Vec<Call>>>);

impl Recorder {
    fn note(&self, call: Call) -> usize {
        if call.worker == 1 {
            // Who does not wait for it is ahead.
            (0..2000).for_each(|_| std::hint::spin_loop());
        }
        let mut calls = self.0.lock().expect("calls");
        calls.push(call);
        calls.iter().rev().take_while(|one| one.op.is_some()).filter(|one| **one == call).count()
    }
}

impl Feature<f32> for Recorder {
    fn ops(&self) -> &'static [Op] {
        &OPS
    }

    fn marks(&self, plan: &TilePlan) -> Marks {
        marks_of(plan.body)
    }

    fn begin(&self, worker: &mut Worker<'_, f32>) {
        self.note(Call { worker: worker.index, op: None, tile: None });
    }

    fn run(&self, op: Op, worker: &mut Worker<'_, f32>) -> Flow {
        let round = self.note(Call { worker: worker.index, op: Some(op), tile: None });
        worker.mark_moved(|tile| moves(op, tile));
        let ends = [Op::MeasureVolumes, Op::SurfaceImpulses, Op::SurfaceFilter].contains(&op);
        if ends && round == ROUNDS { Flow::Done } else { Flow::Go }
    }

    fn tile(&self, op: Op, tile: &mut Tile<'_, f32>) {
        self.note(Call { worker: tile.worker, op: Some(op), tile: Some(tile.index) });
    }
}

/// One operation that must be done: on the scene, or on tiles; whether all must have done what comes before it.
#[derive(Clone, Copy)]
struct Wanted {
    op: Option<Op>,
    on: On,
    sync: bool,
    /// The operation on the scene that last said which tiles it moves.
    moved_by: Op,
}

/// A frame as the list has it, one after the other.
fn wanted(parts: &Parts) -> Vec<Wanted> {
    let whole = On::Scene(Marks::NONE);
    let (mut all, mut moved_by) = (Vec::new(), Op::Elements);
    let mut add = |lines: &[Line]| {
        for line in lines {
            let (rounds, passes) = match line {
                Line::Once(_) => (1, line.passes()),
                Line::Rounds(most, passes) => (*most.min(&ROUNDS), &passes[..]),
            };
            // The last round ends where it finds that nothing is left to do.
            let last = if matches!(line, Line::Rounds(..)) { 1 } else { passes.len() };
            for pass in
                (1..=rounds).flat_map(|round| &passes[..if round < rounds { passes.len() } else { last }])
            {
                if matches!(pass.on, On::Scene(_)) {
                    moved_by = pass.op;
                }
                all.push(Wanted { op: Some(pass.op), on: pass.on, sync: pass.sync, moved_by });
            }
        }
    };
    for _ in 0..SUBSTEPS {
        add(&[Line::Once(step::Pass { op: Op::Integrate, on: whole, sync: true })]);
        add(&step::substep(parts));
    }
    add(&step::frame_end());
    // What stands for a begin, and the end of the last sub-step.
    let per_substep = (all.len() - step::frame_end().len()) / SUBSTEPS;
    (0..SUBSTEPS).for_each(|substep| all[substep * per_substep].op = None);
    all[SUBSTEPS * per_substep].sync = true;
    all
}

fn scene() -> Assembly {
    let mut scene = Scene::new("order").time(0.02, 0.02 / SUBSTEPS as f64);
    scene.bodies = (0..BODIES)
        .map(|body| Body::cloth(format!("body {body}"), Mesh::chain(16, 1.0)).with_mass(Mass::Node(1.0)))
        .map(|body| body.structural(10.0, 0.01))
        .collect();
    Assembly::new(&scene).expect("a scene")
}

/// The calls of a frame, and which worker has which tile.
fn calls(parts: &Parts, threads: usize) -> (Vec<Call>, Vec<usize>) {
    let calls = Arc::new(Mutex::new(Vec::new()));
    let recorder = Recorder(Arc::clone(&calls));
    let mut cpu = CpuBackend::<f32>::new(
        scene(),
        parts,
        |_, _, _| {},
        Team::new(threads),
        |_| Ok(vec![Box::new(recorder)]),
    )
    .expect("a backend");
    assert_eq!(cpu.nodes.tiles.len(), BODIES, "a tile a body");
    let worker = |tile| cpu.chunks.iter().position(|chunk| chunk.contains(&tile)).expect("a worker");
    let workers = (0..BODIES).map(worker).collect();
    cpu.frame(0.0, FrameInput::default()).expect("a frame");
    let found = calls.lock().expect("calls").clone();
    (found, workers)
}

#[test]
fn every_tile_goes_through_the_list_in_its_order() {
    for (parts, threads) in Parts::all().flat_map(|parts| [1, 2].map(|threads| (parts, threads))) {
        let (list, (calls, workers)) = (wanted(&parts), calls(&parts, threads));
        for (tile, &worker) in workers.iter().enumerate() {
            let chosen = |one: &&Wanted| {
                let moved = if moves(one.moved_by, tile) { Marks::MOVED } else { Marks::NONE };
                matches!(one.on, On::Scene(_)) || one.on.chooses(marks_of(tile).and(moved))
            };
            let wanted: Vec<Option<Op>> = list.iter().filter(chosen).map(|one| one.op).collect();
            let own = |call: &&Call| call.worker == worker && call.tile.is_none_or(|one| one == tile);
            let found: Vec<Option<Op>> = calls.iter().filter(own).map(|call| call.op).collect();
            assert_eq!(found, wanted, "tile {tile} of {threads} threads, {parts:?}");
        }
    }
}

#[test]
fn workers_synchronise_where_the_list_says_so() {
    for parts in Parts::all() {
        let (list, (calls, workers)) = (wanted(&parts), calls(&parts, 2));
        assert!(workers.contains(&1), "two workers have tiles");
        // How often all must have synchronised before each line, and how far each tile and each worker is.
        let mut count = 0;
        let syncs: Vec<usize> = list
            .iter()
            .map(|one| {
                count += usize::from(one.sync);
                count
            })
            .collect();
        let mut at = [0; BODIES + 2];
        let mut most = 0;
        for call in &calls {
            let who = call.tile.unwrap_or(BODIES + call.worker);
            let is_next = |&line: &usize| {
                let one = list[line];
                one.op == call.op && matches!(one.on, On::Scene(_)) == call.tile.is_none()
            };
            let line =
                (at[who]..list.len()).find(is_next).unwrap_or_else(|| panic!("{call:?} is not in the list"));
            at[who] = line + 1;
            assert!(syncs[line] >= most, "{call:?} comes after what waits for it, {parts:?}");
            most = syncs[line];
        }
    }
}
