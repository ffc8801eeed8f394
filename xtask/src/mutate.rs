//! `cargo xtask mutate`: plants faults in the sources of kernels and sees that the parity rows find them, and runs many scenes that
//! are made up at random.

use crate::{program, test, vulkan};
use std::process::{Command, ExitCode};

/// The test that plants them, in the engine's program of tests, and the one that rounds otherwise in each row.
const TESTS: [&str; 2] = [
    "parity::faults::planted_faults_are_found",
    "parity::roundings::what_hardware_may_round_otherwise_is_allowed_there",
];
/// What chooses among the faults and rows there.
const CHOICE: &str = "TAFFETA_FAULTS";
/// Tests of scenes that are made up at random, and of sequences of calls, and what says how many each of them makes up: more than 10,000
/// in all.
const RANDOM: [(&str, &str); 2] = [("taffeta", "random_surfaces::"), ("taffeta-io", "calls::")];
const COUNT: (&str, &str) = ("TAFFETA_RANDOM_SCENES", "3400");
/// Faults, and rows, of a sample in `cargo xtask test`.
const SAMPLE: usize = 20;

/// The faults to plant.
#[derive(Debug, PartialEq)]
enum Choice {
    All,
    /// As many as that, drawn by the seed: the commit's hash if there is none.
    Sample(usize, Option<String>),
}

fn parse(words: &[&str]) -> Result<Choice, String> {
    let count = |count: &str| count.parse().map_err(|_| format!("--sample {count}: a number would do"));
    match words {
        [] | ["--all"] => Ok(Choice::All),
        ["--sample", number] => Ok(Choice::Sample(count(number)?, None)),
        ["--sample", number, "--seed", seed] => Ok(Choice::Sample(count(number)?, Some((*seed).to_owned()))),
        _ => Err(format!("mutate {}: it takes --all, or --sample N [--seed SEED]", words.join(" "))),
    }
}

/// Builds the tests and plants the faults that `words` choose.
pub fn run(words: &[&str]) -> ExitCode {
    let result = parse(words).and_then(|choice| {
        vulkan::provide()?;
        let built = test::build(&test::CORE)?;
        plant(&built, &choice)?;
        if choice == Choice::All { try_scenes(&built) } else { Ok(()) }
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Plants the sample that `cargo xtask test` has.
pub fn sample(built: &test::Built, seed: Option<&str>) -> Result<(), String> {
    plant(built, &Choice::Sample(SAMPLE, seed.map(str::to_owned)))
}

fn plant(built: &test::Built, choice: &Choice) -> Result<(), String> {
    let mut command = tests_of(built, "taffeta")?;
    command.args(["--ignored", "--exact", "--nocapture"]).args(TESTS);
    match choice {
        Choice::All => {
            command.env_remove(CHOICE);
        }
        Choice::Sample(count, seed) => {
            let seed = seed.clone().map_or_else(program::head, Ok)?;
            println!("xtask: mutate --sample {count} --seed {seed}");
            command.env(CHOICE, format!("{count} {seed}"));
        }
    }
    finish(&mut command)
}

/// Runs scenes of contact between surfaces that are made up at random.
fn try_scenes(built: &test::Built) -> Result<(), String> {
    RANDOM
        .iter()
        .try_for_each(|(package, tests)| finish(tests_of(built, package)?.arg(tests).env(COUNT.0, COUNT.1)))
}

fn tests_of(built: &test::Built, package: &str) -> Result<Command, String> {
    let tests = built.tests(package, "it");
    Ok(tests.ok_or_else(|| format!("the tests of {package} were not built"))?.command())
}

fn finish(command: &mut Command) -> Result<(), String> {
    let status = vulkan::quiet(command).status().map_err(|error| format!("mutate: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("mutate: {status}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_chosen_by_words() {
        assert_eq!(parse(&[]), Ok(Choice::All));
        assert_eq!(parse(&["--all"]), Ok(Choice::All));
        assert_eq!(parse(&["--sample", "20"]), Ok(Choice::Sample(20, None)));
        assert_eq!(
            parse(&["--sample", "3", "--seed", "8299734"]),
            Ok(Choice::Sample(3, Some("8299734".into())))
        );
        assert!(parse(&["--sample"]).is_err() && parse(&["--sample", "many"]).is_err());
    }
}
