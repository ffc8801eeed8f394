//! What is counted of contact of surfaces, as rows compare it: count.wgsl one number after the other.

use crate::contact::triangles::carry::{Phase, Pushed};
use crate::contact::triangles::filter::JAMS;
use crate::contact::triangles::gpu_layout as layout;
use crate::contact::triangles::impulse::SINKS;
use crate::contact::triangles::slide::SLIDES;
use crate::contact::triangles::twin::Twin;
use crate::gpu::layout::GROUP;
use crate::step::{FILTERS, IMPULSES};
use taffeta_gpu::GROUPS_IN_ROW;

impl Twin {
    /// Workgroups of a command.
    fn put_groups(&mut self, on: usize, groups: usize) {
        let groups = groups as u32;
        let three = [groups.min(GROUPS_IN_ROW), groups.div_ceil(GROUPS_IN_ROW), 1];
        self.counts[3 * on..3 * on + 3].copy_from_slice(&three);
    }

    fn put_each(&mut self, on: usize, count: usize, is_on: bool) {
        self.put_groups(on, if is_on { count.div_ceil(GROUP) } else { 0 });
    }

    fn check_room(&mut self, list: usize, room: usize, most: usize, flag: u32) -> usize {
        let wanted = self.work[list];
        self.need(most, wanted, room, flag);
        self.work[list] = wanted.min(self.tables[room]);
        self.work[list] as usize
    }

    fn need(&mut self, most: usize, wanted: u32, room: usize, flag: u32) {
        self.work[most] = self.work[most].max(wanted);
        self.work[layout::SHORT] |= if wanted > self.tables[room] { flag } else { 0 };
    }

    pub fn count_surfaces(&mut self) {
        match self.part as usize {
            layout::COUNT_PAIRS => {
                let pairs = self.check_room(layout::PAIRS, layout::PAIR_ROOM, layout::MOST_PAIRS, 1);
                self.put_groups(layout::ON_PAIRS, pairs);
            }
            layout::COUNT_CONTACTS => {
                let contacts =
                    self.check_room(layout::CONTACTS, layout::CONTACT_ROOM, layout::MOST_CONTACTS, 2);
                let touched = self.work[layout::TOUCHED] as usize;
                for (on, count) in [
                    (layout::ON_CONTACTS, contacts),
                    (layout::ON_ROUND_CONTACTS, contacts),
                    (layout::ON_TOUCHED, touched),
                    (layout::ON_ROUND_TOUCHED, touched),
                ] {
                    self.put_each(on, count, true);
                }
                (self.work[layout::FORCES], self.work[layout::IS_ACTIVE]) = (0, 1);
            }
            layout::COUNT_ROUND => {
                let next = self.work[layout::ROUND] + 1;
                if next > 1 && self.number(layout::SINKS) <= SINKS as f32 {
                    self.put_groups(layout::ON_ROUND_CONTACTS, 0);
                    self.put_groups(layout::ON_ROUND_TOUCHED, 0);
                } else if (next as usize) < IMPULSES {
                    self.need(layout::MOST_IMPULSES, next + 1, layout::IMPULSE_ROOM, 32);
                }
                (self.work[layout::SINKS], self.work[layout::ROUND]) = (0, next);
            }
            layout::COUNT_WAYS => self.count_ways(),
            layout::COUNT_HELD => self.count_held(),
            layout::COUNT_PART => self.count_part(),
            layout::COUNT_CARRIED => self.count_carried(),
            layout::COUNT_PUSHES => self.count_pushes(),
            layout::COUNT_SOLVED => self.work[layout::IS_ODD] = 1 - self.work[layout::IS_ODD],
            _ => self.count_filter_round(),
        }
    }

    fn put_list(&mut self, is_on: bool) {
        let groups = if is_on { self.leaves().div_ceil(layout::LEAF_GROUP) } else { 0 };
        self.put_groups(layout::ON_LIST, groups);
    }

    fn put_boxes(&mut self, is_on: bool) {
        for level in 0..=self.table(layout::TOP_LEVEL) {
            self.put_each(layout::ON_BOXES + level, self.table(layout::LEVEL_BOXES + 2 * level + 1), is_on);
        }
    }

    fn count_part(&mut self) {
        let (part, parts) = (self.work[layout::CORNER_PART], self.corners.parts);
        let goes_on = part < parts;
        let moves = parts > 0 && part <= parts;
        self.put_each(layout::ON_CORNERS, self.table(layout::ALL_PLACES), moves);
        self.put_boxes(goes_on);
        self.put_list(goes_on);
        self.work[layout::LISTED] = layout::CARRIED as u32;
        self.work[if goes_on { layout::PAIRS } else { layout::FARTHEST_PLACE }] = 0;
        self.work[layout::CORNER_PART] = part + 1;
    }

    fn count_carried(&mut self) {
        let goes_on = self.work[layout::CORNER_PART] <= self.corners.parts;
        let pairs = if goes_on {
            self.check_room(layout::PAIRS, layout::PAIR_ROOM, layout::MOST_PAIRS, 1)
        } else {
            0
        };
        self.put_groups(layout::ON_PUSH, pairs);
        self.put_each(layout::ON_TAKE, self.nodes(), goes_on);
        for word in [layout::PUSH_ROUND, layout::PUSHED, layout::WAITING, layout::PUSH_PHASE] {
            self.work[word] = 0;
        }
    }

    /// What is done in this round of pushes.
    pub fn phase(&self) -> Phase {
        [Phase::Push, Phase::Restart, Phase::Squeeze, Phase::Stop, Phase::Over]
            [self.work[layout::PUSH_PHASE] as usize]
    }

    fn count_pushes(&mut self) {
        let round = self.work[layout::PUSH_ROUND];
        let [moved, waiting] =
            [layout::PUSHED, layout::WAITING].map(|word| std::mem::take(&mut self.work[word]));
        let phase = self.phase().next(round as usize, Pushed { moved: moved != 0, waiting });
        if phase == Phase::Stop {
            self.work[layout::SQUEEZED] = self.work[layout::SQUEEZED].max(waiting);
        }
        if phase == Phase::Over {
            self.put_groups(layout::ON_PUSH, 0);
            self.put_groups(layout::ON_TAKE, 0);
        } else {
            self.need(layout::MOST_PUSHES, round + 2, layout::PUSH_ROOM, 16);
        }
        (self.work[layout::PUSH_ROUND], self.work[layout::PUSH_PHASE]) = (round + 1, phase as u32);
    }

    fn count_ways(&mut self) {
        let (round, is_active) = (self.work[layout::FILTER_ROUND], self.work[layout::IS_ACTIVE] != 0);
        if round == 0 {
            self.work[layout::IS_ODD] = 1 - self.work[layout::IS_ODD];
        }
        let is_far = self.number(layout::WAY) > self.length(layout::SQUARED_WAY);
        let in_rounds = is_active && (is_far || round > 0);
        let is_changed = self.number(layout::CHANGE_OF_WAY) > self.length(layout::SQUARED_CHANGE);
        let is_carried = round == 0 && self.corners.parts > 0;
        let again = is_active && (in_rounds || is_changed || is_carried);
        self.put_each(layout::ON_PART, self.nodes(), in_rounds);
        self.put_boxes(again);
        self.put_list(again);
        self.put_each(layout::ON_MARK, self.nodes(), is_active);
        self.put_groups(layout::ON_HOLD, 0);
        self.work[layout::IN_ROUNDS] = u32::from(in_rounds);
        self.work[layout::LISTED] = layout::NEAR as u32;
        self.work[layout::JAM] = round * layout::STAMPS as u32;
        if again || !is_active {
            self.work[layout::PAIRS] = 0;
        }
    }

    fn count_held(&mut self) {
        let jam = self.work[layout::JAM] % layout::STAMPS as u32;
        let is_written = jam < self.tables[layout::JAM_ROOM];
        let any = self.work[layout::HELD] > 0 && is_written;
        if self.work[layout::HELD] > 0 {
            self.need(layout::MOST_JAMS, jam + 1, layout::JAM_ROOM, 8);
        }
        if jam == 0 && self.work[layout::IS_ACTIVE] != 0 && (any || self.work[layout::IN_ROUNDS] != 0) {
            self.put_each(layout::ON_HOLD, self.nodes(), true);
        }
        self.put_list(any);
        if !any {
            self.put_groups(layout::ON_MARK, 0);
        }
        self.work[layout::LISTED] = if jam == JAMS { layout::ALL } else { layout::AROUND } as u32;
        self.work[layout::JAM] += 1;
        (self.work[layout::HELD], self.work[layout::PAIRS]) = (0, 0);
    }

    fn count_filter_round(&mut self) {
        let is_far = self.number(layout::WAY) > self.length(layout::SQUARED_WAY);
        let gets_on = self.number(layout::PROGRESS) >= self.length(layout::SQUARED_PROGRESS);
        let next = self.work[layout::FILTER_ROUND] + 1;
        let goes_on = is_far || (next as usize) < SLIDES;
        let wanted = self.work[layout::IS_ACTIVE] != 0 && gets_on && goes_on;
        let another = wanted && next < self.tables[layout::ROUND_ROOM];
        if wanted && (next as usize) < FILTERS {
            self.need(layout::MOST_ROUNDS, next + 1, layout::ROUND_ROOM, 4);
        }
        (self.work[layout::FILTER_ROUND], self.work[layout::IS_ACTIVE]) = (next, u32::from(another));
        self.put_each(layout::ON_MEASURE, self.table(layout::ALL_PLACES), another);
        for word in [layout::WAY, layout::CHANGE_OF_WAY, layout::FARTHEST_PLACE, layout::PROGRESS] {
            self.work[word] = 0;
        }
        let taken = std::mem::take(&mut self.work[layout::WAY_TAKEN]);
        if !another {
            self.work[layout::MOST_WAY_TAKEN] = self.work[layout::MOST_WAY_TAKEN].max(taken);
        }
    }
}
