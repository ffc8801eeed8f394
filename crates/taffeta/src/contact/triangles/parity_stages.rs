//! The arrays of contact of surfaces before each kernel, as rows compare them.

use crate::contact::triangles::carry::Phase;
use crate::contact::triangles::gpu_layout::{
    self as layout, FORCE_RECORDS, LEVELS, SolvedContact, SurfaceContact,
};
use crate::contact::triangles::gpu_tables::Room;
use crate::contact::triangles::parity::apply;
use crate::contact::triangles::slide::word;
use crate::contact::triangles::twin::Twin;
use crate::gpu::layout::NONE;
use crate::parity::fixture::{Chance, Fixture};
use crate::real::{add, scale};

/// Room for pairs of leaves, and for contacts.
pub const ROOM: u32 = 6_000;

/// Which kernel of a sub-step is next.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Before {
    Keep,
    Take,
    Bounds,
    Levels,
    List,
    Find,
    Pulls,
    Place,
    Fill,
    Sort,
    FirstImpulses,
    FirstApply,
    Impulses,
    Apply,
    Forces,
    Far,
    Corners,
    Push,
    Stuck,
    TakePushes,
    NextPush,
    Squeeze,
    Restart,
    Stop,
    LastStop,
    TakeStops,
    NextCorners,
    AtRest,
    Measure,
    Part,
    Limits,
    LimitsAround,
    LimitsOfAll,
    NextRound,
    LastRound,
}

/// Which kernel is next in a sub-step whose contacts are part of a system.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Solving {
    Take,
    Find,
    Keep,
    FindAgain,
    Impulses,
    Forces,
}

impl Twin {
    /// The arrays before a sub-step.
    pub fn of(fixture: &Fixture, seed: u64) -> Self {
        let mut tables = fixture.tables.surfaces.clone();
        let room = Room {
            pairs: ROOM as usize,
            contacts: ROOM as usize,
            impulses: 5,
            rounds: 3,
            jams: 17,
            parts: 2,
            pushes: 7,
        };
        tables.put_room(room);
        let mut chance = Chance::new(seed);
        let mut vector = || {
            let [x, y, z] = chance.three(0.3);
            [x, y, z, 0.0]
        };
        let mut places = tables.start();
        for place in places.iter_mut().filter(|place| **place == [0.0; 4]) {
            *place = vector();
        }
        Self {
            part: 1,
            places,
            boxes: vec![[0.0; 4]; 4 * tables.boxes()],
            pairs: vec![[0; 4]; room.pairs],
            contacts: vec![SurfaceContact::default(); room.contacts],
            solved: vec![SolvedContact::default(); room.contacts],
            forces: vec![[0; 4]; FORCE_RECORDS * room.contacts],
            work: vec![0; tables.work(room)],
            counts: vec![7; 3 * (layout::ON_BOXES + LEVELS)],
            position: fixture.new.position.clone(),
            velocity: fixture.new.velocity.clone(),
            h: fixture.substep().h,
            longest: fixture.substep().longest,
            corners: tables.corners_moved(fixture.substep()),
            knots: Vec::new(),
            tables: tables.words,
        }
        .with_tangle()
        .with_odd_lists()
    }

    /// Some places have to do with lines, and some pulls lead others.
    fn with_tangle(mut self) -> Self {
        let places = self.tables[layout::ALL_PLACES];
        for place in 0..places {
            let bits = place.wrapping_mul(2_654_435_761) >> 7;
            let lines = |shift: u32| [bits >> shift & 3, bits >> (shift + 2) & 3];
            let of = lines(0);
            let both = |[a, b]: [u32; 2]| [a & of[0], b & of[1]];
            let loose = if place % 16 == 5 { bits >> 16 & 3 } else { 0 };
            let none = [0; 2];
            let knot = match place % 8 {
                1 | 5 => [of, both(lines(4)), both(lines(8)), lines(12), [loose; 2]],
                // Next to either side of a line, and astray from none.
                3 => [none, [1, 0], none, none, none],
                7 => [none, [0, 1], none, none, none],
                _ => [none; 5],
            };
            self.knots.extend(knot.into_iter().flatten());
            // Whether it is led out of colliders.
            self.knots.push(u32::from(place % 12 == 2 && place < self.tables[layout::NODE_PLACES]));
        }
        (self.tables[layout::IS_TANGLED], self.tables[layout::PULL_COUNT]) = (1, 7);
        for pull in 0..7 {
            let nodes = [7 * pull, 43 + 2 * pull, 57 + pull, places - 1 - pull % 3];
            let numbers = [1.0, -0.2, -0.5, -0.3, 0.48, 0.64, 0.6, 0.013, 0.027 + pull as f32, 0.0, 0.0, 0.0];
            let mut numbers = numbers.map(f32::to_bits);
            numbers[layout::PULL_LED - layout::PULL_WEIGHTS] = u32::from(pull % 3 == 0);
            self.knots.extend(nodes.into_iter().chain(numbers));
        }
        self
    }

    /// The forces of the last sub-step are in the second lists.
    fn with_odd_lists(mut self) -> Self {
        self.work[layout::IS_ODD] = 1;
        self
    }

    /// The arrays before a kernel.
    pub fn before(kernel: Before, fixture: &mut Fixture) -> Self {
        let (mut twin, is_past) = (Self::of(fixture, kernel as u64), |one: Before| one < kernel);
        if is_past(Before::Keep) {
            twin.keep_places(&fixture.old.position);
        }
        if is_past(Before::Take) {
            twin.take_places();
        }
        if is_past(Before::Bounds) {
            twin.bound_leaves();
        }
        if is_past(Before::Levels) {
            twin.bound_levels();
        }
        if is_past(Before::List) {
            twin.list_leaf_pairs();
            twin.put_forces();
        }
        if is_past(Before::Find) {
            twin.find_surface_contacts();
        }
        if is_past(Before::Pulls) {
            twin.add_pulls();
        }
        if is_past(Before::Place) {
            twin.place_parts();
        }
        if is_past(Before::Fill) {
            twin.fill_parts();
        }
        if is_past(Before::Sort) {
            twin.sort_parts();
        }
        twin.go_through_rounds(kernel, fixture);
        twin.go_through_filter(kernel);
        twin
    }

    /// The arrays before a kernel, where contacts are part of a system.
    pub fn while_solving(kernel: Solving, fixture: &Fixture) -> Self {
        let (mut twin, is_past) = (Self::of(fixture, 70 + kernel as u64), |one: Solving| one < kernel);
        twin.tables[layout::IS_SOLVED] = 1;
        twin.keep_places(&fixture.old.position);
        if is_past(Solving::Take) {
            twin.take_start();
            twin.list_pairs_of_start();
        }
        if is_past(Solving::Find) {
            twin.find_surface_contacts();
            twin.add_pulls();
            twin.solve_for_impulses(kernel as u64);
        }
        if is_past(Solving::Keep) {
            twin.keep_solved();
            twin.solved.fill(SolvedContact::default());
            twin.work[layout::IS_ODD] = 1 - twin.work[layout::IS_ODD];
            twin.take_places();
            twin.bound_leaves();
            twin.bound_levels();
            twin.list_leaf_pairs();
        }
        if is_past(Solving::FindAgain) {
            twin.find_surface_contacts();
            twin.correct_impulses();
            twin.work[layout::ROUND] = 1;
        }
        if is_past(Solving::Impulses) {
            twin.correct_impulses();
            twin.work[layout::FORCES] = 0;
        }
        twin
    }

    fn list_pairs_of_start(&mut self) {
        self.bound_leaves();
        self.bound_levels();
        self.list_leaf_pairs();
        self.put_forces();
    }

    /// Gives contacts impulses as a solver might: some are none of its own, and some do not act.
    fn solve_for_impulses(&mut self, seed: u64) {
        let mut chance = Chance::new(seed);
        self.work[layout::FORCES] = 0;
        for (number, one) in self.solved.iter_mut().enumerate() {
            one.system = if number % 3 == 0 { NONE } else { number as u32 % 4 };
            // Some press harder than they rub.
            let along = if number % 2 == 0 { 0.02 } else { 0.0 };
            let impulse = add(scale(self.contacts[number].normal, along), chance.three(0.02 - 0.9 * along));
            one.applied = if number % 5 == 0 { [0.0; 3] } else { impulse };
        }
    }

    /// The same in the rounds of impulses.
    fn go_through_rounds(&mut self, kernel: Before, fixture: &mut Fixture) {
        for (round, impulses, apply_them) in
            [(0, Before::FirstImpulses, Before::FirstApply), (1, Before::Impulses, Before::Apply)]
        {
            if impulses <= kernel {
                self.work[layout::ROUND] = round;
            }
            if impulses < kernel {
                self.correct_impulses();
            }
            if apply_them < kernel {
                apply(self, fixture);
            }
        }
    }

    fn bound_levels(&mut self) {
        for level in 1..=self.tables[layout::TOP_LEVEL] {
            self.part = level;
            self.bound_level();
        }
    }

    /// The same where colliders carry what is in their way.
    fn go_through_carry(&mut self, kernel: Before) {
        if Before::Far < kernel {
            self.measure_places();
            self.work[layout::CORNER_PART] = 1;
        }
        if Before::Corners < kernel {
            self.advance_corners();
            self.bound_leaves();
            self.bound_levels();
            self.work[layout::LISTED] = layout::CARRIED as u32;
            self.list_leaf_pairs();
        }
        for (push, take) in [(Before::Push, Before::TakePushes), (Before::NextPush, Before::NextPush)] {
            if push < kernel {
                self.work[layout::PUSHED] = 0;
                self.push_nodes();
            }
            if take < kernel {
                self.take_pushes();
            }
        }
        if kernel == Before::TakePushes {
            // Some have been pushed before, and some as far as they may be.
            let most = self.corners.longest_push;
            for place in (0..self.table(layout::NODE_PLACES)).step_by(3) {
                self.put(layout::TARGET, place, [0.3 * most, 0.9 * most, -most]);
            }
        }
        if kernel == Before::Stuck {
            // All have been pushed as far as they may be.
            for place in 0..self.table(layout::NODE_PLACES) {
                let sent = [0, 1, 2].map(|axis| self.sent(self.work[self.list(axis) + place]));
                let most = self.corners.longest_push;
                let as_far = |push: f32| if push == 0.0 { 0.0 } else { most.copysign(push) };
                self.put(layout::TARGET, place, sent.map(as_far));
            }
        }
        match kernel {
            Before::NextPush => self.work[layout::PUSHED] = 0,
            Before::Squeeze => {
                self.begin_phase(Phase::Squeeze);
                // Some are driven into colliders by others.
                let mut chance = Chance::new(11);
                for place in 0..self.table(layout::NODE_PLACES) {
                    let way = chance.three(1.0).map(|along| self.corners.longest_push.copysign(along));
                    self.put(layout::TARGET, place, way);
                    self.put(layout::AFTER, place, add(self.place(layout::BEFORE, place), way));
                }
            }
            Before::Restart => self.begin_phase(Phase::Restart),
            Before::Stop => self.begin_phase(Phase::Stop),
            Before::LastStop => {
                self.begin_phase(Phase::Stop);
                self.work[layout::PUSH_ROUND] = 63;
            }
            Before::TakeStops => {
                self.work[layout::PUSH_ROUND] = 63;
                self.begin_phase(Phase::Stop);
                self.push_nodes();
            }
            Before::NextCorners => self.work[layout::CORNER_PART] = 2,
            Before::AtRest => self.work[layout::CORNER_PART] = self.corners.parts + 1,
            _ => {}
        }
    }

    fn begin_phase(&mut self, phase: Phase) {
        for (word, number) in [(layout::PUSHED, 0), (layout::WAITING, 0), (layout::PUSH_PHASE, phase as u32)]
        {
            self.work[word] = number;
        }
    }

    /// The same in the filter. In a later round of it some nodes are held back already.
    fn go_through_filter(&mut self, kernel: Before) {
        if Before::Forces <= kernel {
            self.work[layout::FORCES] = 0;
        }
        if Before::Forces < kernel {
            self.note_forces();
        }
        if (Before::Far..Before::Measure).contains(&kernel) {
            self.go_through_carry(kernel);
            return;
        }
        if Before::Measure < kernel {
            self.measure_ways();
            self.work[layout::IS_ACTIVE] = 1;
        }
        if Before::Limits < kernel {
            self.limit_ways();
            self.mark_held();
            self.work[layout::JAM] = 1;
            for place in (0..self.tables[layout::NODE_PLACES] as usize).step_by(5) {
                let at = self.list(3) + place;
                let away = [0.3, place as f32 * 0.1 - 1.0, -0.2];
                self.work[at] = self.work[at].min(word(0.37_f32, away));
            }
        }
        self.work[layout::LISTED] = match kernel {
            Before::LimitsAround => layout::AROUND,
            Before::LimitsOfAll => layout::ALL,
            _ => layout::NEAR,
        } as u32;
        if kernel == Before::LimitsOfAll {
            self.work[layout::JAM] = 2;
        }
        if Before::NextRound <= kernel {
            (self.work[layout::FILTER_ROUND], self.work[layout::IN_ROUNDS]) = (1, 1);
            self.work[layout::JAM] = layout::STAMPS as u32;
            // Some arrive, and none is where it was at the start of the sub-step.
            for place in 0..self.tables[layout::NODE_PLACES] as usize {
                let [x, y, z, _] = self.position[place];
                self.put(
                    layout::BEFORE,
                    place,
                    add(self.place(layout::AT_START, place), [1e-3, -2e-3, 1e-3]),
                );
                if place % 2 == 0 || kernel == Before::LastRound {
                    self.put(layout::TARGET, place, [x, y + 1e-4 * (place % 2) as f32, z]);
                }
            }
        }
        if kernel == Before::LastRound {
            // Nobody has far to go any more, and who is held has less to slide than others go.
            self.work[layout::WAY] = 0;
            for place in 0..self.nodes() {
                let at = self.list(3) + place;
                self.work[at] = word(if place % 5 == 0 { 0.9_f32 } else { 1.0 }, [0.2, 0.3, -0.1]);
            }
        }
    }

    /// Gives some pairs a force in the last sub-step.
    fn put_forces(&mut self) {
        // Some have come so far apart that only those with a force remain contacts.
        let mut other = self.clone();
        let materials = other.tables[layout::MATERIALS_AT] as usize;
        let count = (other.tables[layout::MATERIAL_COUNT] as usize).pow(2);
        for pair in 0..count {
            let thickness = &mut other.tables[materials + 2 * pair];
            *thickness = (1.05 * f32::from_bits(*thickness)).to_bits();
        }
        other.find_surface_contacts();
        let buckets = self.tables[layout::BUCKETS] as usize;
        let first = self.lists_of_contacts()[3];
        self.work[first..first + 2 * buckets].fill(u32::MAX);
        self.work[layout::FORCES] = 0;
        for one in other.contacts[..other.work[layout::CONTACTS] as usize].iter().step_by(3) {
            let force = [0.3 * one.normal[0] + 0.05, 0.4 * one.normal[1], 0.2 * one.normal[2]];
            // As if it were the list of the next sub-step.
            self.work[layout::IS_ODD] = 0;
            self.keep_force(one.order, force, None);
            self.work[layout::IS_ODD] = 1;
        }
    }
}
