//! Contact of surfaces on the device's arrays, one number after the other: what rows compare kernels with.

use crate::contact::colliders::moving::ColliderNow;
use crate::contact::triangles::gpu::{bucket_of, order_of};
use crate::contact::triangles::gpu_layout::{self as layout, FORCE_RECORDS, SolvedContact, SurfaceContact};
use crate::contact::triangles::gpu_tables::CornersMoved;
use crate::contact::triangles::impulse::{Contact, mobility};
use crate::contact::triangles::slide::{UNLIMITED, lift, out_of_solids, part};
use crate::contact::triangles::solved::sustained;
use crate::gpu::layout::{Four, NONE};
use crate::real::{Real, add, dot, norm, scale, sub};

/// All arrays that kernels of contact share.
#[derive(Clone)]
pub struct Twin {
    pub tables: Vec<u32>,
    /// How surfaces pass through each other.
    pub knots: Vec<u32>,
    pub part: u32,
    pub places: Vec<Four>,
    pub boxes: Vec<Four>,
    pub pairs: Vec<[u32; 4]>,
    pub contacts: Vec<SurfaceContact>,
    /// The same as systems know them.
    pub solved: Vec<SolvedContact>,
    pub forces: Vec<[u32; 4]>,
    pub work: Vec<u32>,
    pub counts: Vec<u32>,
    /// Position and inverse mass, velocity and mass, after the sub-step.
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
    /// The sub-step, and the longest of its frame [s].
    pub h: f32,
    pub longest: f32,
    /// Where corners of colliders go in it.
    pub corners: CornersMoved,
}

impl Twin {
    pub fn table(&self, word: usize) -> usize {
        self.tables[word] as usize
    }

    pub fn length(&self, word: usize) -> f32 {
        f32::from_bits(self.tables[word])
    }

    pub fn place(&self, array: usize, place: usize) -> [f32; 3] {
        let [x, y, z, _] = self.places[array * self.table(layout::ALL_PLACES) + place];
        [x, y, z]
    }

    pub fn put(&mut self, array: usize, place: usize, [x, y, z]: [f32; 3]) {
        let at = array * self.table(layout::ALL_PLACES) + place;
        self.places[at] = [x, y, z, 0.0];
    }

    pub fn number(&self, word: usize) -> f32 {
        f32::from_bits(self.work[word])
    }

    pub fn nodes(&self) -> usize {
        self.table(layout::NODE_PLACES)
    }

    pub fn leaves(&self) -> usize {
        self.table(layout::LEAF_COUNT)
    }

    /// Where a list of numbers by place begins.
    pub fn list(&self, number: usize) -> usize {
        layout::LISTS + number * self.table(layout::ALL_PLACES)
    }

    fn after_marks(&self) -> usize {
        self.list(6) + self.leaves()
    }

    /// Where the lists by contact begin: parts, sorted parts, and the forces after others; then the first ones by bucket.
    pub fn lists_of_contacts(&self) -> [usize; 4] {
        [0, 4, 8, 9].map(|lists| self.after_marks() + lists * self.table(layout::CONTACT_ROOM))
    }

    fn first_force(&self, is_odd: u32, bucket: usize) -> usize {
        self.lists_of_contacts()[3] + is_odd as usize * self.table(layout::BUCKETS) + bucket
    }

    pub fn leaf(&self, leaf: usize) -> &[u32] {
        let at = self.table(layout::LEAVES_AT) + leaf * layout::LEAF_WORDS;
        &self.tables[at..at + layout::LEAF_WORDS]
    }

    pub fn has_surface(&self, place: usize) -> bool {
        self.tables[self.table(layout::HAS_SURFACE_AT) + place] != 0
    }

    pub fn material(&self, a: usize, b: usize) -> [f32; 2] {
        let [a, b] = [a, b].map(|leaf| self.leaf(leaf)[layout::LEAF_MATERIAL] as usize);
        let at = self.table(layout::MATERIALS_AT) + 2 * (a * self.table(layout::MATERIAL_COUNT) + b);
        [at, at + 1].map(|at| f32::from_bits(self.tables[at]))
    }

    pub fn keep_places(&mut self, old: &[Four]) {
        for (place, &[x, y, z, _]) in old.iter().take(self.nodes()).enumerate() {
            self.put(layout::AT_START, place, [x, y, z]);
        }
    }

    /// Empties lists; then pairs of this kind are listed.
    fn empty_lists(&mut self, kind: usize) {
        for word in (0..layout::SHORT).filter(|&word| word != layout::FORCES && word != layout::IS_ODD) {
            self.work[word] = 0;
        }
        self.work[layout::NEAREST] = f32::FAR.to_bits();
        self.work[layout::LISTED] = kind as u32;
        for place in 0..self.nodes() {
            for (list, value) in [(0, 0), (2, 0), (3, UNLIMITED), (4, 0)] {
                let at = self.list(list) + place;
                self.work[at] = value;
            }
        }
        let (marks, leaves, buckets) = (self.list(6), self.leaves(), self.table(layout::BUCKETS));
        let first = self.first_force(1 - self.work[layout::IS_ODD], 0);
        self.work[marks..marks + leaves].fill(0);
        self.work[first..first + buckets].fill(NONE);
    }

    pub fn take_places(&mut self) {
        self.empty_lists(layout::NEAR);
        let three = |[x, y, z, _]: Four| [x, y, z];
        for place in 0..self.nodes() {
            self.put(layout::BEFORE, place, self.place(layout::AT_START, place));
            self.put(layout::AFTER, place, three(self.position[place]));
            self.put(layout::BASE_VELOCITY, place, three(self.velocity[place]));
        }
        if !self.corners.corners.is_empty() {
            for place in self.nodes()..self.table(layout::ALL_PLACES) {
                let [start, end] = self.corner_ends(place);
                self.put(layout::BEFORE, place, start);
                self.put(layout::AFTER, place, end);
            }
        }
    }

    pub fn take_start(&mut self) {
        self.empty_lists(layout::SOLVED);
        for place in 0..self.table(layout::ALL_PLACES) {
            let at = if place < self.nodes() { layout::AT_START } else { layout::BEFORE };
            let mut ends = [self.place(at, place); 2];
            if place >= self.nodes() && !self.corners.corners.is_empty() {
                ends = self.corner_ends(place);
            }
            self.put(layout::BEFORE, place, ends[0]);
            self.put(layout::AFTER, place, ends[0]);
            if place >= self.nodes() {
                self.put(layout::TARGET, place, ends[1]);
            }
        }
    }

    /// The box around some, each with its corners and those of its motion.
    fn bound(&mut self, number: usize, all: impl Iterator<Item = [[f32; 3]; 4]>) {
        let mut bounds = [[f32::FAR; 3], [-f32::FAR; 3], [f32::FAR; 3], [-f32::FAR; 3]];
        for one in all {
            for (which, (bound, one)) in bounds.iter_mut().zip(one).enumerate() {
                for (bound, one) in bound.iter_mut().zip(one) {
                    *bound = if which % 2 == 0 { bound.min(one) } else { bound.max(one) };
                }
            }
        }
        for (which, [x, y, z]) in bounds.into_iter().enumerate() {
            self.boxes[4 * number + which] = [x, y, z, 0.0];
        }
    }

    pub fn bound_leaves(&mut self) {
        for leaf in 0..self.leaves() {
            let words = self.leaf(leaf);
            let own = &words[..words[layout::LEAF_NODES] as usize];
            let around: Vec<_> = own
                .iter()
                .map(|&node| {
                    let x = self.place(layout::BEFORE, node as usize);
                    let way = sub(self.place(layout::AFTER, node as usize), x);
                    [x, x, way, way]
                })
                .collect();
            self.bound(leaf, around.into_iter());
        }
    }

    pub fn bound_level(&mut self) {
        let level = self.part as usize;
        let [first, count] = [0, 1].map(|word| self.table(layout::LEVEL_BOXES + 2 * level + word));
        let [below, below_count] = [0, 1].map(|word| self.table(layout::LEVEL_BOXES + 2 * level - 2 + word));
        for number in 0..count {
            let end = below_count.min((number + 1) * layout::LEAF_GROUP);
            let of = |number: usize| self.box_of(below + number);
            let around: Vec<_> = (number * layout::LEAF_GROUP..end).map(of).collect();
            self.bound(first + number, around.into_iter());
        }
    }

    pub fn box_of(&self, number: usize) -> [[f32; 3]; 4] {
        std::array::from_fn(|which| {
            let [x, y, z, _] = self.boxes[4 * number + which];
            [x, y, z]
        })
    }

    pub fn place_parts(&mut self) {
        for number in 0..self.work[layout::TOUCHED] as usize {
            let node = self.work[self.list(5) + number] as usize;
            let at = self.list(1) + node;
            self.work[at] = self.work[layout::PARTS];
            self.work[layout::PARTS] += self.work[self.list(0) + node];
        }
    }

    /// Parts of nodes in contacts: the node, and the part.
    fn parts(&self) -> Vec<(usize, u32)> {
        let contacts = self.contacts[..self.work[layout::CONTACTS] as usize].iter();
        let parts = contacts.enumerate().flat_map(|(number, one)| {
            let corners = one.nodes.into_iter().zip(one.weights).enumerate();
            corners
                .filter(|(_, (_, weight))| *weight != 0.0)
                .map(move |(corner, (node, _))| (node as usize, (4 * number + corner) as u32))
        });
        parts.filter(|(node, _)| *node < self.nodes()).collect()
    }

    pub fn fill_parts(&mut self) {
        for (node, part) in self.parts() {
            let filled = self.list(2) + node;
            let at =
                self.lists_of_contacts()[0] + (self.work[self.list(1) + node] + self.work[filled]) as usize;
            self.work[at] = part;
            self.work[filled] += 1;
        }
    }

    pub fn sort_parts(&mut self) {
        let mut parts = self.parts();
        let order = |part: u32| self.contacts[part as usize / 4].order;
        // Pulls, which have no leaf, come first.
        parts.sort_by_key(|&(node, part)| (node, order(part)[0] != NONE, order_of(order(part))));
        for of_node in parts.chunk_by(|a, b| a.0 == b.0) {
            let first = self.lists_of_contacts()[1] + self.work[self.list(1) + of_node[0].0] as usize;
            for (at, (_, part)) in of_node.iter().enumerate() {
                self.work[first + at] = *part;
            }
        }
    }

    /// As the formulas take it.
    pub fn formula(&self, one: &SurfaceContact) -> Contact<f32> {
        let moved = |corner: usize| match one.nodes[corner] as usize {
            place if place < self.nodes() => [0.0; 3],
            place => {
                let way = sub(self.place(layout::AFTER, place), self.place(layout::BEFORE, place));
                scale(way, one.weights[corner])
            }
        };
        let moved = (0..4).map(moved).fold([0.0; 3], add);
        Contact {
            normal: one.normal,
            gap: one.gap,
            thickness: one.thickness,
            friction: one.friction,
            grip: one.grip,
            advance: (-dot(one.normal, moved)).max(0.0),
            mobility: one.mobility,
        }
    }

    fn velocity_at(&self, place: usize) -> [f32; 3] {
        if place < self.nodes() {
            let [u, v, w, _] = self.velocity[place];
            return [u, v, w];
        }
        sub(self.place(layout::AFTER, place), self.place(layout::BEFORE, place)).map(|way| way / self.h)
    }

    pub fn correct_impulses(&mut self) {
        for number in 0..self.work[layout::CONTACTS] as usize {
            let mut one = self.contacts[number];
            if self.work[layout::ROUND] == 0 {
                let part = |corner: usize| {
                    let (node, weight) = (one.nodes[corner] as usize, one.weights[corner].abs());
                    let count = if node < self.nodes() { self.work[self.list(0) + node] as f32 } else { 0.0 };
                    (weight, if node < self.nodes() { self.position[node][3] * count } else { 0.0 })
                };
                one.mobility = mobility([0, 1, 2, 3].map(part));
                let formula = self.formula(&one);
                one.impulse = formula.start(one.impulse);
                let by = 1.0 / if one.mobility > 0.0 { one.mobility } else { 1.0 };
                let lead = formula.lead(self.h);
                let way = if lead > 0.0 { lead + formula.advance } else { 0.0 };
                one.push = if one.mobility > 0.0 { way * by } else { 0.0 };
            } else {
                let v = one.nodes.map(|node| self.velocity_at(node as usize));
                let part = |corner: usize| scale(sub(v[corner], v[3]), one.weights[corner]);
                let velocity = add(add(part(0), part(1)), part(2));
                let formula = self.formula(&one);
                let sinks = formula.sinks(velocity, self.h).max(0.0);
                self.work[layout::SINKS] = self.work[layout::SINKS].max(sinks.to_bits());
                one.impulse = formula.correct(one.impulse, velocity, self.h);
            }
            self.contacts[number] = one;
        }
    }

    /// Where impulses have nodes go, by place; colliders act on that.
    pub fn apply_impulses(&mut self) -> Vec<(usize, [f32; 6])> {
        let (mut all, is_first) = (Vec::new(), self.work[layout::ROUND] == 0);
        for number in 0..self.work[layout::TOUCHED] as usize {
            let node = self.work[self.list(5) + number] as usize;
            let start = self.lists_of_contacts()[1] + self.work[self.list(1) + node] as usize;
            let parts = start..start + self.work[self.list(0) + node] as usize;
            let mut push = if is_first { [0.0; 3] } else { self.place(layout::PUSH, node) };
            let mut sum = [0.0; 3];
            for part in parts.map(|at| self.work[at] as usize) {
                let one = &self.contacts[part / 4];
                sum = add(sum, scale(one.impulse, one.weights[part % 4]));
                if is_first {
                    push = add(push, scale(scale(one.normal, one.push), one.weights[part % 4]));
                }
            }
            self.put(layout::PUSH, node, push);
            let w = self.position[node][3];
            let change = scale(sum, w);
            let x = add(add(self.place(layout::AFTER, node), scale(change, self.h)), scale(push, w));
            let v = add(self.place(layout::BASE_VELOCITY, node), change);
            all.push((node, [x[0], x[1], x[2], v[0], v[1], v[2]]));
        }
        all
    }

    pub fn note_forces(&mut self) {
        let Self { h, longest, .. } = *self;
        let old = if h < longest { 1.0 - h / longest } else { 0.0 };
        for number in 0..self.work[layout::CONTACTS] as usize {
            let one = self.contacts[number];
            let given = scale(add(one.solved, one.impulse), 1.0 / h.max(longest));
            let mut force = add(scale(one.force, old), given);
            if self.tables[layout::IS_SOLVED] != 0 {
                force = sustained(force, one.force);
            }
            if force != [0.0; 3] && one.leads == 0 {
                self.keep_force(one.order, force, None);
            }
        }
    }

    /// Puts a force into the list, with the impulse of the solver if it has given one.
    pub fn keep_force(&mut self, order: [u32; 3], force: [f32; 3], solved: Option<[f32; 3]>) {
        let at = self.work[layout::FORCES] as usize;
        self.work[layout::FORCES] += 1;
        let [a, b, pair] = order;
        let vector = |v: [f32; 3]| [v[0].to_bits(), v[1].to_bits(), v[2].to_bits(), 0];
        let records =
            [[a, b, pair, solved.is_some().into()], vector(force), vector(solved.unwrap_or_default())];
        self.forces[FORCE_RECORDS * at..][..FORCE_RECORDS].copy_from_slice(&records);
        let bucket = bucket_of(order, self.table(layout::BUCKETS));
        let first = self.first_force(1 - self.work[layout::IS_ODD], bucket);
        let next = self.lists_of_contacts()[2] + at;
        self.work[next] = std::mem::replace(&mut self.work[first], at as u32);
    }

    pub fn keep_solved(&mut self) {
        for number in 0..self.work[layout::CONTACTS] as usize {
            let (one, in_system) = (self.contacts[number], self.solved[number]);
            let solved = (in_system.system != NONE).then_some(in_system.applied);
            if one.leads == 0 && solved.unwrap_or(one.force) != [0.0; 3] {
                self.keep_force(one.order, one.force, solved);
            }
        }
    }

    pub fn measure_ways(&mut self) {
        let is_later = self.work[layout::FILTER_ROUND] > 0;
        for place in
            (0..self.table(layout::ALL_PLACES)).filter(|&place| self.has_surface(place)).collect::<Vec<_>>()
        {
            let [x, y, z, _] = self.position.get(place).copied().unwrap_or_default();
            let is_node = place < self.nodes();
            if is_node && is_later {
                self.put(layout::BEFORE, place, [x, y, z]);
            }
            let start = self.place(layout::BEFORE, place);
            let most =
                |work: &mut [u32], word: usize, value: f32| work[word] = work[word].max(value.to_bits());
            start.iter().for_each(|x| most(&mut self.work, layout::FARTHEST_PLACE, x.abs()));
            if is_node {
                let to = if is_later { self.place(layout::TARGET, place) } else { [x, y, z] };
                let (way, change) = (sub(to, start), sub(to, self.place(layout::AFTER, place)));
                self.put(layout::AFTER, place, to);
                most(&mut self.work, layout::WAY, dot(way, way));
                most(&mut self.work, layout::CHANGE_OF_WAY, dot(change, change));
            }
        }
    }

    pub fn surface_nodes(&self) -> Vec<usize> {
        (0..self.nodes()).filter(|&place| self.has_surface(place)).collect()
    }

    pub fn go_part(&mut self) {
        let most = self.length(layout::LONGEST_WAY);
        for place in self.surface_nodes() {
            let ([x, y, z, w], [u, v, t, _]) = (self.position[place], self.velocity[place]);
            if self.work[layout::FILTER_ROUND] == 0 {
                self.put(layout::TARGET, place, [x, y, z]);
                self.put(layout::TARGET_VELOCITY, place, [u, v, t]);
            }
            let (start, target) = (self.place(layout::BEFORE, place), self.place(layout::TARGET, place));
            let way = sub(target, start);
            let length = norm(way);
            let to = if length > most { add(start, scale(way, most / length)) } else { target };
            self.position[place] = [to[0], to[1], to[2], w];
            self.put(layout::AFTER, place, to);
        }
    }

    pub fn mark_held(&mut self) {
        let (stamp, marks) = (self.work[layout::JAM] + 1, self.list(6));
        for place in self.surface_nodes() {
            let (limit, held) = (self.work[self.list(3) + place], self.list(4) + place);
            if limit != UNLIMITED
                && self.work[held] <= self.work[layout::FILTER_ROUND] * layout::STAMPS as u32
            {
                self.work[held] = stamp;
                let starts = self.table(layout::LEAVES_OF_AT) + place;
                for at in self.tables[starts]..self.tables[starts + 1] {
                    let leaf = self.tables[self.table(layout::LEAF_ITEMS_AT) + at as usize];
                    self.work[marks + leaf as usize] = stamp;
                }
                self.work[layout::HELD] += 1;
            }
        }
    }

    /// `met` are the colliders that the node at a place meets.
    pub fn hold_back<'m>(&mut self, met: &dyn Fn(usize) -> &'m [ColliderNow<f32>]) {
        let in_rounds = self.work[layout::IN_ROUNDS] != 0;
        for place in self.surface_nodes() {
            let at = self.list(3) + place;
            let limit = std::mem::replace(&mut self.work[at], UNLIMITED);
            if limit == UNLIMITED && !in_rounds {
                let ([x, y, z, _], [u, v, t, _]) = (self.position[place], self.velocity[place]);
                self.put(layout::TARGET, place, [x, y, z]);
                self.put(layout::TARGET_VELOCITY, place, [u, v, t]);
            } else {
                // Who is led out of colliders is not thrown out.
                let is_led = self.knots[layout::KNOT_WORDS * place + layout::KNOT_LED] != 0;
                self.hold_node(place, limit, in_rounds, if is_led { &[] } else { met(place) });
            }
        }
    }

    fn hold_node(&mut self, place: usize, limit: u32, in_rounds: bool, met: &[ColliderNow<f32>]) {
        let ([x, y, z, w], [u, v, t, m]) = (self.position[place], self.velocity[place]);
        let (start, wanted) = (self.place(layout::BEFORE, place), [x, y, z]);
        let to = if limit == UNLIMITED { wanted } else { add(start, scale(sub(wanted, start), part(limit))) };
        let (goal, speed) = if in_rounds {
            (self.place(layout::TARGET, place), self.place(layout::TARGET_VELOCITY, place))
        } else {
            (wanted, [u, v, t])
        };
        self.position[place] = [to[0], to[1], to[2], w];
        if in_rounds && to == goal {
            self.velocity[place] = [speed[0], speed[1], speed[2], m];
            return;
        }
        let (h, at_start) = (self.h, self.place(layout::AT_START, place));
        let speed_to = |to: [f32; 3]| sub(to, at_start).map(|way| way / h);
        let [p, q, r] = speed_to(to);
        self.velocity[place] = [p, q, r, m];
        let left = sub(wanted, to);
        let lift = if limit != UNLIMITED && w > 0.0 { lift(left, limit) } else { [0.0; 3] };
        let slides = lift != [0.0; 3];
        let goal = if slides { out_of_solids(met, add(goal, lift), norm(left)) } else { goal };
        self.put(layout::TARGET, place, goal);
        self.put(layout::TARGET_VELOCITY, place, if slides { speed_to(goal) } else { speed });
        let is_far = self.number(layout::WAY) > self.length(layout::SQUARED_WAY);
        let [way, slid, rest] = [sub(to, start), add(left, lift), sub(goal, to)].map(|way| dot(way, way));
        let mut most = |word: usize, number: f32| self.work[word] = self.work[word].max(number.to_bits());
        most(layout::PROGRESS, if is_far { way } else { 0.0 });
        most(layout::PROGRESS, if slides { slid } else { 0.0 });
        most(layout::WAY_TAKEN, if w > 0.0 { rest } else { 0.0 });
        most(layout::MOST_WAY_TAKEN, dot(lift, lift));
    }
}
