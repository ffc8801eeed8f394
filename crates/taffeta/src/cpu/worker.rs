//! A worker of a frame: it executes the list of `step.rs`.

use crate::backend::FrameInput;
use crate::cpu::cells::PerWorker;
use crate::cpu::clock::Clock;
use crate::cpu::feature::{Features, Flow};
use crate::cpu::numbers::TileMarks;
use crate::cpu::resting::Resting;
use crate::cpu::states::{States, Turn};
use crate::cpu::team::Barrier;
use crate::cpu::tile::{Fields, Moved, Nodes, Scratch, Tile};
use crate::plan::Substep;
use crate::real::Real;
use crate::step::{Line, Marks, On, Pass};
use std::ops::Range;
use std::rc::Rc;

/// The lists of a scene, with consecutive passes over tiles merged.
pub struct Program {
    /// Passes of a sub-step.
    substep: Vec<Block>,
    /// Passes at the end of a frame.
    end: Vec<Block>,
}

/// Some passes.
enum Block {
    /// A pass on the scene.
    Scene(Pass),
    /// Passes on tiles, one after the other on each tile.
    Tiles(Vec<Pass>),
    /// Rounds of blocks, up to this number.
    Rounds(usize, Vec<Block>),
}

impl Program {
    /// From the lists.
    pub fn new(substep: &[Line], end: &[Line]) -> Self {
        Self { substep: blocks(substep), end: blocks(end) }
    }
}

fn blocks(lines: &[Line]) -> Vec<Block> {
    let mut all: Vec<Block> = Vec::new();
    for line in lines {
        match (line, all.last_mut()) {
            (Line::Rounds(most, passes), _) => {
                let passes: Vec<Line> = passes.iter().map(|&pass| Line::Once(pass)).collect();
                all.push(Block::Rounds(*most, blocks(&passes)));
            }
            (Line::Once(pass), _) if matches!(pass.on, On::Scene(_)) => all.push(Block::Scene(*pass)),
            (Line::Once(pass), Some(Block::Tiles(passes))) if !pass.sync => passes.push(*pass),
            (Line::Once(pass), _) => all.push(Block::Tiles(vec![*pass])),
        }
    }
    all
}

/// A worker, and the data that it may access.
pub struct Worker<'a, T> {
    /// What is constant.
    pub nodes: &'a Nodes<T>,
    /// All features of the scene.
    pub features: &'a Features<T>,
    /// The user's input for this frame.
    pub input: &'a FrameInput,
    /// The parameters of the sub-step.
    pub substep: &'a Substep<T>,
    /// Its index, and the number of workers.
    pub index: usize,
    pub workers: usize,
    /// Its tiles.
    pub tiles: Range<usize>,
    /// The states, and which of them is the one before the sub-step.
    pub states: &'a States<T>,
    pub turn: Turn,
    /// The marks of each tile.
    pub marks: &'a [TileMarks],
    /// Which bodies rest: nothing of them changes, so nothing of them is computed.
    pub resting: &'a Resting,
    /// Scratch memory.
    pub scratch: &'a PerWorker<Scratch<T>>,
    /// The barrier.
    pub barrier: &'a Barrier,
    /// Time that it has waited for others where work is uneven [s].
    pub waited: f64,
    /// Sub-steps that it has done.
    pub done: usize,
    /// The clock, if the frame is timed.
    pub clock: Option<Rc<Clock>>,
}

impl<'a, T: Real> Worker<'a, T> {
    /// Runs a frame. Where the team is stopped on the way, what is left of it is not done.
    pub fn frame(&mut self, program: &Program, substeps: &'a [Substep<T>], at_rest: &'a Substep<T>) {
        for substep in substeps {
            if self.is_stopped() {
                return;
            }
            self.substep = substep;
            for feature in self.features.iter() {
                feature.begin(self);
            }
            self.blocks(&program.substep);
            self.timed(None, |worker| worker.barrier.wait());
            self.turn.pass();
            self.done += 1;
            if self.features.iter().any(|feature| feature.is_in_vain()) {
                break;
            }
        }
        self.substep = at_rest;
        self.blocks(&program.end);
    }

    /// Runs passes of a sub-step that has been begun elsewhere, and does not end it.
    #[cfg(feature = "gpu")]
    pub fn passes(&mut self, program: &Program) {
        self.blocks(&program.substep);
    }

    fn blocks(&mut self, blocks: &[Block]) -> Flow {
        for block in blocks {
            if self.is_stopped() || self.block(block) == Flow::Done {
                return Flow::Done;
            }
        }
        Flow::Go
    }

    fn block(&mut self, block: &Block) -> Flow {
        match block {
            Block::Scene(pass) => return self.scene(pass),
            Block::Tiles(passes) => self.timed(None, |worker| worker.over_tiles(passes)),
            Block::Rounds(most, blocks) => {
                for _ in 0..*most {
                    if self.blocks(blocks) == Flow::Done {
                        break;
                    }
                }
            }
        }
        Flow::Go
    }

    fn scene(&mut self, pass: &Pass) -> Flow {
        self.timed(Some(pass), |worker| {
            if pass.sync {
                worker.barrier.wait();
            }
            let mut flow = Flow::Go;
            for feature in worker.features.of(pass.op) {
                flow = feature.run(pass.op, worker);
            }
            flow
        })
    }

    fn over_tiles(&mut self, passes: &[Pass]) {
        if passes.first().is_some_and(|first| first.sync) {
            self.barrier.wait();
        }
        let (features, clock) = (self.features, self.clock.clone());
        let mut scratch = self.scratch.of(self.index);
        for index in self.awake_tiles() {
            let mut tile = self.tile(index, &mut scratch);
            for pass in passes {
                if pass.on.chooses(tile.marks.get()) {
                    let run = || features.of(pass.op).for_each(|feature| feature.tile(pass.op, &mut tile));
                    Clock::time(clock.as_deref(), Some(pass.op.stage()), run);
                }
            }
        }
    }

    fn timed<R>(&mut self, pass: Option<&Pass>, job: impl FnOnce(&mut Self) -> R) -> R {
        let clock = self.clock.clone();
        Clock::time(clock.as_deref(), pass.map(|pass| pass.op.stage()), || job(self))
    }

    /// A tile of its chunk.
    fn tile<'t>(&self, index: usize, scratch: &'t mut Scratch<T>) -> Tile<'t, T>
    where
        'a: 't,
    {
        Tile {
            nodes: self.nodes,
            features: self.features,
            input: self.input,
            substep: self.substep,
            plan: &self.nodes.tiles[index],
            index,
            number: index - self.tiles.start,
            worker: self.index,
            old: self.old(),
            next: self.next(),
            scratch,
            marks: &self.marks[index],
            moved: Moved::None,
        }
    }

    /// Does something with each tile of its chunk whose body does not rest.
    pub fn each_tile(&self, mut job: impl FnMut(&mut Tile<'_, T>)) {
        let mut scratch = self.scratch.of(self.index);
        self.awake_tiles().for_each(|index| job(&mut self.tile(index, &mut scratch)));
    }

    /// Tiles of its chunk whose bodies do not rest.
    fn awake_tiles(&self) -> impl Iterator<Item = usize> + use<'a, T> {
        let (nodes, resting) = (self.nodes, self.resting);
        self.tiles.clone().filter(move |&index| !resting.has(nodes.tiles[index].body))
    }

    /// The state at the start of the sub-step.
    pub fn old(&self) -> [&'a [T]; 6] {
        std::array::from_fn(|axis| self.old_column(axis))
    }

    /// Position of a place before the sub-step [m].
    #[inline(always)]
    pub fn old_position(&self, place: usize) -> [T; 3] {
        self.old_three(0, place)
    }

    /// Velocity of a place before the sub-step [m/s].
    #[inline(always)]
    pub fn old_velocity(&self, place: usize) -> [T; 3] {
        self.old_three(3, place)
    }

    /// Three columns from one on at a place: all six as slices would take longer than what is read of them.
    #[inline(always)]
    fn old_three(&self, first: usize, place: usize) -> [T; 3] {
        [0, 1, 2].map(|axis| self.old_column(first + axis)[place])
    }

    #[inline(always)]
    fn old_column(&self, axis: usize) -> &'a [T] {
        // SAFETY: in a sub-step all workers read this buffer and write another; they take turns after a barrier.
        unsafe { self.states[self.turn.now][axis].read() }
    }

    /// The state after it.
    pub fn next(&self) -> &'a Fields<T> {
        &self.states[self.turn.next()]
    }

    /// Waits for all workers. What they have written before it is visible after it.
    pub fn synchronise(&self) {
        self.barrier.wait();
    }

    /// The same where work is uneven. The waiting times show which workers have too little to do.
    pub fn synchronise_uneven(&mut self) {
        self.waited += self.barrier.wait_timed();
    }

    /// Whether the frame is to end early: the same for all workers from one barrier to the next.
    pub fn is_stopped(&self) -> bool {
        self.barrier.is_stopped()
    }

    /// Whether it may leave out what is left until the next barrier: the frame ends there, and what it has found is given up.
    pub fn gives_up(&self) -> bool {
        self.barrier.gives_up()
    }

    /// An even part of `count` things.
    pub fn part(&self, count: usize) -> Range<usize> {
        count * self.index / self.workers..count * (self.index + 1) / self.workers
    }

    /// Marks the tiles of its chunk that have nodes to move in the next passes.
    pub fn mark_moved(&self, moved: impl Fn(usize) -> bool) {
        for tile in self.tiles.clone() {
            let marks = self.marks[tile].get().without(Marks::MOVED);
            self.marks[tile].set(if moved(tile) { marks.and(Marks::MOVED) } else { marks });
        }
    }

    /// Whether any tile of the scene has a mark. All workers must have synchronised since marks were set.
    pub fn any_tile_has(&self, mark: Marks) -> bool {
        self.marks.iter().any(|marks| marks.has(mark))
    }
}
