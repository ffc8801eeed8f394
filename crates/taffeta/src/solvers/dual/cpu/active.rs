//! Adaptive constraints: stream compaction of the active ones and of their nodes, tile by tile, in ascending order.

use crate::real::{Real, sub};
use crate::solvers::dual::cpu::{Dual, Layout, SolveWorker};
use crate::solvers::dual::distance::becomes_active;
use crate::step::Marks;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

impl<T: Real> Dual<T> {
    /// Recounts the nodes with active constraints. A tile whose count is not 0 checks its constraints again.
    pub(crate) fn recount(&mut self, active: &[bool]) {
        for (tile, counts) in self.tiles.iter().zip(&mut self.work.tile_nodes) {
            let here = |place| self.by_place.row(place).iter().filter(|&&end| active[end as usize / 2]);
            let ends = tile.runs().flat_map(|(_, run)| run).map(|place| here(place).count() as u32);
            let new = ends.fold([0; 2], |[nodes, all], here| [nodes + u32::from(here > 0), all + here]);
            *counts = new.map(AtomicU32::new);
        }
    }
}

impl<T: Real> SolveWorker<'_, '_, T> {
    /// The chunks of a system of all constraints.
    pub(crate) fn cut_all(&mut self) {
        if self.scratch.layout.count > 0 {
            return;
        }
        let layout = &mut self.scratch.layout;
        layout.clear();
        for ((nodes, rows), bands) in
            self.solve.bodies.iter().zip(&self.solve.list.bodies).zip(&self.solve.bands)
        {
            match bands {
                Some(bands) => layout.push_bands(bands, rows.len()),
                None => layout.push(rows.clone(), nodes.clone()),
            }
        }
    }

    /// Lists the active constraints and their nodes, after all workers have computed forces.
    pub(crate) fn compact(&mut self) {
        self.worker.tiles.clone().for_each(|tile| self.activate(tile));
        self.worker.synchronise();
        // Counted before a barrier, and counted again after the next.
        let first_rows = prefix(&self.shared.tile_rows, |rows| rows);
        if first_rows.last() == Some(&0) {
            self.worker.tiles.clone().for_each(|tile| self.note_counts(tile, [0; 2]));
            self.scratch.layout = Layout::default();
            return;
        }
        for tile in self.worker.tiles.clone() {
            self.list_rows(tile, first_rows[tile] as usize);
            self.count_nodes(tile);
        }
        self.worker.synchronise();
        let counts = &self.shared.tile_nodes;
        let [first_nodes, first_ends] = [0, 1].map(|which| prefix(counts, |count| &count[which]));
        for tile in self.worker.tiles.clone() {
            self.list_nodes(tile, first_nodes[tile], first_ends[tile]);
        }
        self.cut(&first_rows, &first_nodes);
        self.worker.synchronise();
    }

    /// Decides which constraints of a tile are active, and counts them.
    fn activate(&self, tile: usize) {
        let mut count = 0;
        if self.waits(tile) {
            for range in &self.solve.of_tile[tile] {
                count += self.activate_some(range);
            }
        }
        self.shared.tile_rows[tile].store(count, Ordering::Relaxed);
    }

    fn activate_some(&self, range: &Range<usize>) -> u32 {
        let acad = &self.solve.solver.acad;
        let limits = [acad.threshold, acad.release].map(|share| {
            let stretch = T::from_f64(1.0 + share);
            stretch * stretch
        });
        // SAFETY: tiles own different constraints, each tile is in one worker's share, and others read after a barrier.
        let multiplier = unsafe { self.shared.multiplier.write(range.clone()) };
        let mut count = 0;
        for (multiplier, row) in multiplier.iter_mut().zip(range.clone()) {
            let [first, second] = self.solve.list.ends[row];
            let ends = [first as usize, second as usize];
            let [a, b] = [self.worker.old_position(ends[0]), self.worker.old_position(ends[1])];
            let free = ends.iter().any(|&end| self.worker.nodes.inverse_mass[end] > T::ZERO);
            let was_active = self.is_active(row);
            let active = becomes_active(sub(b, a), self.solve.rest[row], limits, free, was_active);
            self.shared.active[row].store(active, Ordering::Relaxed);
            count += u32::from(active);
            if !active {
                *multiplier = T::ZERO;
            }
        }
        count
    }

    fn is_active(&self, constraint: usize) -> bool {
        self.shared.active[constraint].load(Ordering::Relaxed)
    }

    /// Lists the active constraints of a tile from row `first` on.
    fn list_rows(&self, tile: usize, first: usize) {
        let all = self.solve.of_tile[tile].iter().cloned().flatten();
        for (row, constraint) in (first..).zip(all.filter(|&constraint| self.is_active(constraint))) {
            // SAFETY: rows of tiles follow each other, tiles own different constraints; others read after a barrier.
            let (which, row_of) =
                unsafe { (self.shared.which.item(row), self.shared.row_of.item(constraint)) };
            (*which, *row_of) = (constraint as u32, row as u32);
        }
    }

    /// The active entries of a place.
    fn entries(&self, place: usize) -> impl Iterator<Item = u32> + use<'_, T> {
        let active = &self.shared.active;
        let is_active = |end: u32| active[end as usize / 2].load(Ordering::Relaxed);
        self.solve.by_place.row(place).iter().copied().filter(move |&end| is_active(end))
    }

    /// Counts the nodes of a tile that have active constraints.
    fn count_nodes(&self, tile: usize) {
        let mut counts = [0; 2];
        if self.waits(tile) {
            for place in self.worker.nodes.tiles[tile].runs().flat_map(|(_, run)| run) {
                let here = self.entries(place).count() as u32;
                counts = [counts[0] + u32::from(here > 0), counts[1] + here];
            }
        }
        self.note_counts(tile, counts);
    }

    /// Lists them and their entries.
    fn list_nodes(&self, tile: usize, first: u32, first_end: u32) {
        let [count, count_ends] =
            self.shared.tile_nodes[tile].each_ref().map(|count| count.load(Ordering::Relaxed));
        if count == 0 {
            return;
        }
        let (nodes, ends) = (part(first, count), part(first_end, count_ends));
        // SAFETY: nodes and entries of tiles follow each other, tiles have different places; others read after a barrier.
        // Rows were listed before a barrier.
        let (places, spans, entries, row_of) = unsafe {
            (
                self.shared.places.write(nodes.clone()),
                self.shared.spans.write(nodes.clone()),
                self.shared.entries.write(ends.clone()),
                self.shared.row_of.read(),
            )
        };
        let (mut node, mut entry) = (0, 0);
        for place in self.worker.nodes.tiles[tile].runs().flat_map(|(_, run)| run) {
            let from = entry;
            for end in self.entries(place) {
                entries[entry] = 2 * row_of[end as usize / 2] + end % 2;
                entry += 1;
            }
            if entry > from {
                places[node] = place as u32;
                spans[node] = [from, entry].map(|at| (ends.start + at) as u32);
                // SAFETY: as above.
                *unsafe { self.shared.node_of.item(place) } = (nodes.start + node) as u32;
                node += 1;
            }
        }
    }

    /// Cuts the active system into chunks.
    fn cut(&mut self, first_rows: &[u32], first_nodes: &[u32]) {
        let tiles = &self.worker.nodes.tiles;
        let bodies = (0..self.solve.bodies.len()).map(|body| {
            let from = tiles.partition_point(|tile| tile.body < body);
            let to = tiles.partition_point(|tile| tile.body <= body);
            let between = |first: &[u32]| first[from] as usize..first[to] as usize;
            (between(first_rows), between(first_nodes))
        });
        let layout = &mut self.scratch.layout;
        layout.cut(bodies);
        let mine = first_nodes[self.worker.tiles.start..=self.worker.tiles.end].windows(2);
        layout.nodes_of_tile.clear();
        layout.nodes_of_tile.extend(mine.map(|pair| pair[0] as usize..pair[1] as usize));
    }

    /// Whether the nodes of one of its tiles wait.
    fn waits(&self, tile: usize) -> bool {
        self.worker.marks[tile].has(Marks::SOLVED)
    }

    /// Sets the counts of one of its tiles.
    fn note_counts(&self, tile: usize, counts: [u32; 2]) {
        let all = self.shared.tile_nodes[tile].iter().zip(counts);
        all.for_each(|(old, count)| old.store(count, Ordering::Relaxed));
    }
}

/// Prefix sums of the counts, and their total.
fn prefix<C>(counts: &[C], count: impl Fn(&C) -> &AtomicU32) -> Vec<u32> {
    let mut before = vec![0];
    let mut sum = 0;
    before.extend(counts.iter().map(|one| {
        sum += count(one).load(Ordering::Relaxed);
        sum
    }));
    before
}

fn part(first: u32, count: u32) -> Range<usize> {
    first as usize..(first + count) as usize
}
