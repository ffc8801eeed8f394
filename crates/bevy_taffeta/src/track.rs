//! Entities that colliders and pins follow, and where they will be at the end of a step.

use crate::pose::Rigid;
use bevy::math::{DQuat, DVec3};

/// An entity that something follows.
#[derive(Clone, Copy)]
pub struct Track {
    /// Where the entity was when it was followed first.
    pub start: Rigid,
    /// Where it had brought what follows it by the last step.
    pub last: Rigid,
    /// Where it was seen last.
    seen: Rigid,
    /// Time since it was seen to move, and the time that its last move took [s].
    since: f64,
    took: f64,
    /// How fast it goes, by its last two moves.
    rates: [Rate; 2],
    /// How fast its last move was, even if it was put elsewhere by that.
    tried: Rate,
    /// The motion by which it was put elsewhere, until what follows it was, too.
    jumped: Option<Rigid>,
}

/// When an entity has not moved but was put elsewhere.
#[derive(Clone, Copy)]
pub struct Far {
    /// Distance from where its speed brings it [m].
    pub beyond: f64,
    /// The time [s] that is not left out of that since it was seen last, where some is: what it went in the rest counts.
    pub taken: Option<f64>,
}

/// Linear [m/s] and angular velocity [rad/s].
#[derive(Clone, Copy, Default)]
struct Rate {
    linear: DVec3,
    angular: DVec3,
}

/// Times its usual time that an entity may stand before it is said to have stopped: what is moved at fixed times is seen to
/// move now and then.
const STOPPED: f64 = 1.5;

impl Track {
    /// An entity that is `now` there, and stands.
    pub fn new(start: Rigid, now: Rigid) -> Self {
        let (rates, tried) = ([Rate::default(); 2], Rate::default());
        Self { start, last: now, seen: now, since: 0.0, took: 0.0, rates, tried, jumped: None }
    }

    /// The same for what starts where this has brought it.
    pub fn restarted(self) -> Self {
        Self { start: self.last, ..self }
    }

    /// Notes that the entity is `now` there, so many `seconds` of its world after it was seen last. While a world stands still nothing
    /// is noted, as nothing can follow.
    pub fn see(&mut self, now: Rigid, seconds: f64, far: Far) {
        if seconds <= 0.0 {
            return;
        }
        self.since += seconds;
        if now == self.seen {
            if self.since > STOPPED * self.took {
                self.rates = [Rate::default(); 2];
            }
            return;
        }
        let rate = Rate::between(&self.seen, &now, self.since);
        let expected = self.expected(far.taken.unwrap_or(self.since));
        let is_far = |from: Rigid| now.shift.distance(from.shift) > far.beyond;
        // What has gone as far before goes so fast.
        let goes_on = far.taken.is_none() && !is_far(self.tried.bring(&self.seen, self.since));
        if is_far(self.seen) && is_far(expected) && !goes_on {
            let motion = now.since(&expected);
            self.jumped = Some(motion);
            self.rates = self.rates.map(|rate| rate.turned(motion.turn));
        } else {
            self.rates = [rate, self.rates[0]];
        }
        if far.taken.is_none() {
            self.tried = rate;
        }
        (self.took, self.seen, self.since) = (self.since, now, 0.0);
    }

    /// Whether the entity was put elsewhere.
    pub fn has_jumped(&self) -> bool {
        self.jumped.is_some()
    }

    /// The motion by which the entity was put elsewhere, once.
    pub fn take_jump(&mut self) -> Option<Rigid> {
        self.jumped.take()
    }

    /// Where what follows it would be by a motion, from the start.
    pub fn carried(&self, motion: &Rigid) -> Rigid {
        motion.after(&self.last).since(&self.start)
    }

    /// Notes that what follows it was carried along.
    pub fn carry(&mut self, motion: &Rigid) {
        self.last = motion.after(&self.last);
    }

    /// Expects the entity to be carried along, too: then it has not jumped.
    pub fn expect(&mut self, motion: &Rigid) {
        self.seen = motion.after(&self.seen);
        self.rates = self.rates.map(|rate| rate.turned(motion.turn));
    }

    /// Where what follows it is, from the start.
    pub fn moved(&self) -> Rigid {
        self.last.since(&self.start)
    }

    /// Sends what follows the entity a `share` of the rest of the way to where it will be `ahead` seconds from now. `None` where it is
    /// there.
    pub fn follow(&mut self, share: f64, ahead: f64) -> Option<Rigid> {
        let to = self.expected(ahead);
        (to != self.last).then(|| {
            self.last = if share < 1.0 { self.last.toward(&to, share) } else { to };
            self.moved()
        })
    }

    /// Where the entity will be in a time [s], by the slower of its last two moves: one that is put elsewhere at once does not go on.
    fn expected(&self, ahead: f64) -> Rigid {
        let slower = |of: fn(&Rate) -> DVec3| {
            let [a, b] = self.rates.each_ref().map(of);
            if a.length_squared() < b.length_squared() { a } else { b }
        };
        let rate = Rate { linear: slower(|rate| rate.linear), angular: slower(|rate| rate.angular) };
        rate.bring(&self.seen, ahead)
    }
}

impl Rate {
    /// Where it brings something in a time [s].
    fn bring(&self, from: &Rigid, seconds: f64) -> Rigid {
        let [shift, turn] = [self.linear, self.angular].map(|rate| rate * seconds);
        if shift == DVec3::ZERO && turn == DVec3::ZERO {
            return *from;
        }
        let turned = DQuat::from_scaled_axis(turn) * from.turn;
        Rigid { turn: turned.normalize(), shift: from.shift + shift }
    }

    fn turned(self, turn: DQuat) -> Self {
        Self { linear: turn * self.linear, angular: turn * self.angular }
    }

    fn between(before: &Rigid, now: &Rigid, seconds: f64) -> Self {
        if seconds <= 0.0 {
            return Self::default();
        }
        let turn = now.turn * before.turn.inverse();
        // The short way round.
        let turn = if turn.w < 0.0 { -turn } else { turn };
        Self { linear: (now.shift - before.shift) / seconds, angular: turn.to_scaled_axis() / seconds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, angle: f64) -> Rigid {
        Rigid { turn: DQuat::from_rotation_y(angle), shift: DVec3::new(x, 1.0, 0.0) }
    }

    /// What has been seen at these places and angles, a hundredth of a second apart.
    fn seen(all: &[[f64; 2]]) -> Track {
        let start = at(all[0][0], all[0][1]);
        let mut track = Track::new(start, start);
        let far = Far { beyond: f64::INFINITY, taken: None };
        all[1..].iter().for_each(|&[x, angle]| track.see(at(x, angle), 0.01, far));
        track
    }

    #[test]
    fn what_goes_evenly_is_expected_to_go_on() {
        let expected = seen(&[[0.0, 0.0], [0.1, 0.2], [0.2, 0.4]]).expected(0.005);
        let wanted = at(0.25, 0.5);
        assert!(expected.shift.distance(wanted.shift) < 1e-12);
        assert!(expected.turn.angle_between(wanted.turn) < 1e-6);
    }

    #[test]
    fn what_is_put_elsewhere_or_stops_is_expected_to_stay() {
        for all in
            [&[[0.0, 0.0], [50.0, 3.0]][..], &[[0.0, 0.0], [0.1, 0.1], [0.2, 0.2], [0.2, 0.2], [0.2, 0.2]]]
        {
            let track = seen(all);
            assert!(track.expected(0.01) == track.seen);
        }
    }

    #[test]
    fn what_is_moved_at_fixed_times_goes_on_in_between() {
        // It is moved in each second of these times.
        let track = seen(&[[0.0, 0.0], [0.0, 0.0], [0.2, 0.0], [0.2, 0.0], [0.4, 0.0], [0.4, 0.0]]);
        assert!((track.expected(0.01).shift.x - 0.5).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_where_its_speed_brings_it_has_jumped_and_goes_on_from_there() {
        let evenly = [[0.0, 0.0], [3.0, 0.0], [6.0, 0.0]];
        let far = Far { beyond: 2.0, taken: None };
        let mut track = seen(&evenly);
        // A frame that takes five times as long.
        track.see(at(21.0, 0.0), 0.05, far);
        assert!(track.take_jump().is_none() && track.seen == at(21.0, 0.0));
        track.see(at(30.0, 0.0), 0.01, far);
        let motion = track.take_jump().unwrap();
        assert!(motion.shift.distance(DVec3::X * 6.0) < 1e-9 && track.take_jump().is_none());
        assert!(track.expected(0.01).shift.distance(at(33.0, 0.0).shift) < 1e-9);
        // Of a longer time a hundredth of a second is simulated.
        let mut track = seen(&evenly);
        track.see(at(21.0, 0.0), 0.05, Far { taken: Some(0.01), ..far });
        assert!(track.take_jump().unwrap().shift.distance(DVec3::X * 12.0) < 1e-9);
        assert!(track.expected(0.01).shift.distance(at(24.0, 0.0).shift) < 1e-9);
    }

    #[test]
    fn what_is_faster_than_that_jumps_once() {
        let mut track = seen(&[[0.0, 0.0]]);
        let jumps = [5.0, 10.0, 15.0, 20.0, 20.0, 25.0].map(|x| {
            track.see(at(x, 0.0), 0.01, Far { beyond: 2.0, taken: None });
            track.take_jump().is_some()
        });
        assert_eq!(jumps, [true, false, false, false, false, true]);
    }

    #[test]
    fn what_moves_while_a_world_stands_still_has_jumped_once_that_goes_on() {
        let mut track = seen(&[[0.0, 0.0]]);
        let far = Far { beyond: 2.0, taken: None };
        (1..5).for_each(|step| track.see(at(f64::from(step), 0.0), 0.0, far));
        assert!(track.take_jump().is_none() && track.seen == at(0.0, 0.0));
        track.see(at(4.0, 0.0), 0.01, far);
        assert!(track.take_jump().is_some());
    }

    #[test]
    fn steps_on_the_way_go_even_shares_of_it() {
        let mut track = seen(&[[0.0, 0.0], [0.3, 0.0]]);
        let shares = [1.0 / 3.0, 1.0 / 2.0, 1.0].map(|share| track.follow(share, 0.0).map(|way| way.shift.x));
        for (found, wanted) in shares.into_iter().zip([0.1, 0.2, 0.3]) {
            assert!((found.unwrap() - wanted).abs() < 1e-12);
        }
        assert!(track.follow(1.0, 0.0).is_none());
    }
}
