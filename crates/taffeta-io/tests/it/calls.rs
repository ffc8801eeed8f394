//! Sequences of calls that are made up at random, with the model of the fuzz target.

#[path = "../../../../fuzz/calls.rs"]
mod model;

use taffeta::topology::random::SplitMix64;

/// How many, unless `TAFFETA_RANDOM_SCENES` says it.
const COUNT: u64 = 60;

#[test]
fn any_sequence_of_calls_is_answered_and_repeated_from_a_snapshot() {
    let asked = std::env::var("TAFFETA_RANDOM_SCENES").ok().and_then(|count| count.parse().ok());
    for seed in 0..asked.unwrap_or(COUNT) {
        let mut random = SplitMix64::new(seed);
        let input: Vec<u8> = (0..400).map(|_| random.below(256) as u8).collect();
        if std::panic::catch_unwind(|| model::calls(&input)).is_err() {
            panic!("seed {seed}");
        }
    }
}
