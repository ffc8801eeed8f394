//! Contacts of a sub-step, and the rounds in which their impulses are found.

use super::{NO_SLOT, Scratch, Touched, TriangleContact, read};
use crate::contact::triangles::cones::Nearest;
use crate::contact::triangles::cpu::broad_phase::{LeafPair, Looked};
use crate::contact::triangles::cpu::contacts::{Active, Carried, What};
use crate::contact::triangles::cpu::lanes::{Distances, See, Seen, motion};
use crate::contact::triangles::cpu::narrow_phase::{Close, Look};
use crate::contact::triangles::cpu::untangle::{back, lifts};
use crate::contact::triangles::impulse::{Contact, KEEPS, SINKS, grip, mobility};
use crate::contact::triangles::order::Order;
use crate::contact::triangles::surfaces::Corners;
use crate::contact::triangles::tangle::Rule;
use crate::cpu::feature::Flow;
use crate::cpu::simd::SimdLevel;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale};
use std::sync::atomic::Ordering;

/// Which contacts are looked for.
#[derive(Clone, Copy)]
pub(super) struct Asked<T> {
    /// The sub-step [s].
    pub h: T,
    /// How near they end, relative to their thickness.
    pub within: T,
    /// Whether those are among them that lead back what passes through a surface.
    pub leads: bool,
}

impl<T: Real> Look<'_, T> {
    /// A pair as a contact, if it would end as near as is asked. One that carries a force remains one a little longer.
    fn contact(
        &self,
        (seen, lane, x): (&Seen<T>, usize, [&[T]; 3]),
        close: &Close<T>,
        (order, force, solved): (Order, [T; 3], Option<[T; 3]>),
        asked: &Asked<T>,
    ) -> Option<Active<T>> {
        let (distance, thickness) = (seen.distance[lane], close.thickness);
        let is_new = force == [T::ZERO; 3] && solved.is_none();
        let keeps = if is_new { asked.within } else { asked.within.max(T::from_f64(KEEPS)) };
        if !(seen.then[lane] < keeps * thickness && distance > T::ZERO) {
            return None;
        }
        let (kind, nodes, weights) = (close.kind(), close.nodes, seen.weights.map(|lanes| lanes[lane]));
        let nearest =
            Nearest { kind, nodes, weights, apart: seen.apart.map(|lanes| lanes[lane]), carries: !is_new };
        if !nearest
            .is_in_cones(|place| self.surfaces.fan(place), |place| x.map(|column| column[place as usize]))
        {
            return None;
        }
        let key = close.candidate.key(self.leaves.map(|leaf| leaf.first));
        let normal = nearest.apart.map(|along| along / distance);
        Some(Active {
            carried: Carried { order, kind, key, force, solved },
            nodes,
            weights,
            contact: Contact {
                normal,
                gap: distance - thickness,
                thickness,
                friction: self.friction,
                grip: solved.map_or(T::ZERO, |solved| grip(solved, normal, self.friction)),
                advance: T::ZERO,
                mobility: T::ZERO,
            },
            // What the solver has given is there already.
            impulse: scale(force, if solved.is_some() { T::ZERO } else { asked.h }),
        })
    }
}

impl<T: Real> TriangleContact<T> {
    /// Finds the contacts of the sub-step.
    pub(super) fn find(&self, worker: &mut Worker<'_, T>, scratch: &mut Scratch<T>) {
        let moving = worker.substep.extensions.get::<Corners<T>>();
        self.take(worker, moving.map(|corners| [&corners.before[..], &corners.after[..]]));
        worker.synchronise();
        scratch.contacts.clear();
        self.lead_out(worker, &mut scratch.contacts);
        // In an implicit step the solver leads back what passes through a surface.
        let leads = !scratch.is_solved;
        if leads {
            self.pull(worker, &mut scratch.contacts);
        }
        let asked = Asked { h: worker.substep.h, within: T::ONE, leads };
        self.look(worker, scratch, Some(asked), 0.0);
        (scratch.round, scratch.filter_round) = (0, Some(0));
        let nearest = scratch.contacts.iter().map(|one| {
            let Active { contact, .. } = one;
            (T::ONE + contact.gap / contact.thickness).max(T::ZERO).to_f64()
        });
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        self.found[worker.index].begin(scratch.contacts.len(), nearest);
        let places = self.surfaces.places as u32;
        self.mail.send_parts(worker.index, &scratch.contacts, places, |node| self.worker_of(node));
        worker.synchronise();
        self.take_nodes(worker, scratch);
    }

    /// Finds the pairs that come near each other in the sub-step, by up to `extra` [m] more than nodes say; and the
    /// contacts that are asked for.
    pub(super) fn look(
        &self,
        worker: &Worker<'_, T>,
        Scratch { pairs, memory, close, contacts, carried, .. }: &mut Scratch<T>,
        asked: Option<Asked<T>>,
        extra: f64,
    ) {
        let (before, after, level) = (read(&self.before), read(&self.after), worker.nodes.level);
        let (index, surfaces) = (worker.index, &self.surfaces);
        self.leaves.follow(index, surfaces, [before, after], level);
        worker.synchronise();
        let lifts = lifts(worker);
        pairs.extra = extra;
        self.leaves.advance(index, pairs, surfaces, level, || worker.synchronise());
        close.iter_mut().for_each(Vec::clear);
        let mut carried = carried.iter().peekable();
        self.leaves.each_due(pairs, surfaces, level, |pair, wanted| {
            if worker.gives_up() {
                return Looked::AGAIN;
            }
            let look = self.look_at(pair, level);
            let looked = look.renew(pair, wanted, (before, surfaces.mean_edge), memory);
            let mut nearest = looked.others;
            for sixteen in &mut pair.list {
                let (kind, nodes) = (sixteen.kind, &sixteen.nodes);
                let see = || level.run(See { kind, nodes, before, after });
                // Where some were close they are likely to be so again.
                let seen = (sixteen.any_close && asked.is_some()).then(see);
                let distances = seen
                    .as_ref()
                    .map_or_else(|| level.run(Distances { kind, nodes, x: before }), |seen| seen.distance);
                let left = sixteen.left(distances);
                let least = left[..sixteen.count].iter().copied().fold(f64::INFINITY, f64::min);
                nearest = nearest.min(least);
                sixteen.any_close = least < wanted.needs;
                if !sixteen.any_close {
                    continue;
                }
                let seen = seen.or_else(|| asked.map(|_| see()));
                for lane in (0..sixteen.count).filter(|&lane| left[lane] < wanted.needs) {
                    let one = sixteen.pair(lane);
                    let rule = self.rule(lifts, &one);
                    if rule == Rule::Apart {
                        close[kind as usize].push(one);
                    }
                    if let (Some(seen), Some(asked)) = (&seen, &asked) {
                        let order = Order::new(pair.leaves, one.candidate);
                        while carried.next_if(|carried| carried.order < order).is_some() {}
                        let carried = carried.next_if(|carried| carried.order == order);
                        let force = carried.map_or([T::ZERO; 3], |carried| carried.force);
                        let last = (order, force, carried.and_then(|carried| carried.solved));
                        contacts.extend(match rule {
                            Rule::Apart if one.candidate.gives_way(look.leaves) => {
                                look.contact((seen, lane, before), &one, last, asked)
                            }
                            Rule::Through { above } if asked.leads => {
                                let weights = seen.weights.map(|lanes| lanes[lane]);
                                let most = asked.within.max(T::from_f64(KEEPS)) * one.thickness;
                                let is_near = seen.distance[lane] < most;
                                if is_near { back(before, &one, weights, above) } else { None }
                            }
                            Rule::Apart | Rule::Through { .. } | Rule::Ignored => None,
                        });
                    }
                }
            }
            Looked { nearest, ..looked }
        });
    }

    /// Two leaves to look at.
    pub(super) fn look_at(&self, pair: &LeafPair<T>, level: SimdLevel) -> Look<'_, T> {
        let start = self.start.each_ref().map(|column| &column[..]);
        Look::new(pair, &self.surfaces, (self.leaves.packed(), start), level)
    }

    /// Counts the contacts of a worker's nodes, and keeps the state of these.
    fn take_nodes(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>) {
        for one in scratch.touched.drain(..) {
            scratch.slot[one.node as usize] = NO_SLOT;
            // Its own node; others read after the barrier.
            self.counts[one.node as usize].store(0, Ordering::Relaxed);
        }
        let state = self.state(worker);
        self.mail.each_part(worker.index, |part| {
            let place = part.node as usize;
            let count = self.counts[place].load(Ordering::Relaxed);
            if count == 0 {
                let base = state.map(|column| column[place]);
                let (node, zero) = (part.node, [T::ZERO; 3]);
                scratch.touched.push(Touched { node, base, push: zero, sum: zero });
            }
            self.counts[place].store(count + 1, Ordering::Relaxed);
        });
        scratch.touched.sort_unstable_by_key(|one| (self.tile_of[one.node as usize], one.node));
        for (slot, one) in (0..).zip(&scratch.touched) {
            scratch.slot[one.node as usize] = slot;
        }
        self.mail.each_part(worker.index, |part| part.node = scratch.slot[part.node as usize]);
    }

    /// A round of impulses: corrects them for the velocities that those of the round before gave.
    pub(super) fn round(&self, worker: &mut Worker<'_, T>, scratch: &mut Scratch<T>) -> Flow {
        let h = worker.substep.h;
        let any = self.found.iter().any(|found| found.contacts.get() > 0.0);
        let last = scratch.round.wrapping_sub(1) % 2;
        let sinks = scratch.round < 2 || self.found.iter().any(|found| found.sinks[last].get() > SINKS);
        if !any || !sinks {
            worker.mark_moved(|_| false);
            return Flow::Done;
        }
        if scratch.round == 0 {
            self.start(worker, scratch, h);
        } else {
            let state = self.state(worker);
            let (before, after) = (read(&self.before), read(&self.after));
            let v = |node: u32| match node as usize {
                place if place < self.surfaces.places => [3, 4, 5].map(|column| state[column][place]),
                place => motion(before, after, place).map(|way| way / h),
            };
            let mut sinks = T::ZERO;
            for one in &mut scratch.contacts {
                let velocity = one.velocity(v);
                sinks = sinks.max(one.contact.sinks(velocity, h));
                one.impulse = one.contact.correct(one.impulse, velocity, h);
            }
            self.found[worker.index].sinks[scratch.round % 2].set(sinks.to_f64());
        }
        let impulses = scratch.contacts.iter().map(|one| one.impulse);
        self.mail.send(What::Impulses, worker.index, impulses);
        worker.synchronise();
        let touched = &mut scratch.touched;
        if scratch.round == 0 {
            let more = |node: usize, vector| touched[node].push = add(touched[node].push, vector);
            self.mail.sum(What::Pushes, worker.index, more);
        }
        touched.iter_mut().for_each(|one| one.sum = [T::ZERO; 3]);
        let more = |node: usize, vector| touched[node].sum = add(touched[node].sum, vector);
        self.mail.sum(What::Impulses, worker.index, more);
        let w = &worker.nodes.inverse_mass;
        scratch.responses.clear();
        for Touched { node, base, push, sum } in &scratch.touched {
            let w = w[*node as usize];
            let change = scale(*sum, w);
            let (way, push) = (scale(change, h), scale(*push, w));
            let state = std::array::from_fn(|axis| match axis {
                0..3 => base[axis] + way[axis] + push[axis],
                _ => base[axis] + change[axis - 3],
            });
            scratch.responses.push((*node, state));
        }
        scratch.round += 1;
        self.list_by_tile(worker, scratch);
        Flow::Go
    }

    /// The first guess: impulses of the last sub-step, and what old overlaps ask for.
    fn start(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>, h: T) {
        let count = |place: usize| self.counts[place].load(Ordering::Relaxed);
        let w = &worker.nodes.inverse_mass;
        let (before, after) = (read(&self.before), read(&self.after));
        let w = |place: usize| if place < self.surfaces.places { w[place] } else { T::ZERO };
        for one in &mut scratch.contacts {
            let parts = [0, 1, 2, 3].map(|node| {
                let (weight, place) = (one.weights[node], one.nodes[node] as usize);
                (weight.abs(), w(place) * T::from_f64(f64::from(count(place))))
            });
            one.contact.mobility = mobility(parts);
            one.impulse = one.contact.start(one.impulse);
            let moved = (0..4).fold([T::ZERO; 3], |sum, node| match one.nodes[node] as usize {
                place if place < self.surfaces.places => sum,
                place => add(sum, scale(motion(before, after, place), one.weights[node])),
            });
            one.contact.advance = (-dot(one.contact.normal, moved)).max(T::ZERO);
        }
        let pushes = scratch.contacts.iter().map(|one| one.contact.push(h));
        self.mail.send(What::Pushes, worker.index, pushes);
    }

    /// Sorts the responses by tile, and marks tiles that have some.
    pub(super) fn list_by_tile(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>) {
        scratch.tiles.clear();
        for tile in worker.tiles.start..=worker.tiles.end {
            let before = |(node, _): &(u32, [T; 6])| (self.tile_of[*node as usize] as usize) < tile;
            scratch.tiles.push(scratch.responses.partition_point(before));
        }
        let any = |tile: usize| {
            let number = tile - worker.tiles.start;
            scratch.tiles[number] < scratch.tiles[number + 1]
        };
        worker.mark_moved(any);
    }
}
