//! Runs the benches, one after the other, and keeps the line of each.

use crate::{program, root};
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use taffeta_io::program::processor;

/// Sides of square grids.
const SIDES: [u32; 8] = [32, 64, 160, 256, 512, 1024, 2048, 2796];
/// Sides whose speed is measured with every number of threads.
const SCALED: [u32; 2] = [512, 2048];

/// Builds the program and measures it; appends each line to the file of this machine.
pub fn all(folder: &Path, frames: Option<u32>) -> Result<(), String> {
    if !program::build().arg("--quiet").status().map_err(|error| format!("cargo: {error}"))?.success() {
        return Err("the program was not built".into());
    }
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let processor = processor();
    let machine = format!("{processor}, {threads} threads, {}", taffeta::simd_level());
    let file = folder.join(program::slug(&machine)).with_extension("jsonl");
    let commit = program::commit()?;
    for mut words in benches(threads) {
        if let Some(frames) = frames {
            words.push_str(&format!(" --frames {frames}"));
        }
        println!("taffeta {words}");
        let measured = bench(&words)?;
        let line = with(
            measured,
            [("machine", &machine), ("commit", &commit), ("command", &format!("taffeta {words}"))],
        );
        append(&file, &line?).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
}

/// The words after `taffeta` of each bench.
fn benches(threads: usize) -> Vec<String> {
    let squares = SIDES.iter().map(|side| format!("bench grid --n {side} --json"));
    let others = ["bench grid --rows 1368 --cols 5717 --json", "bench mesh --json", "bench drape --json"];
    let all: Vec<String> = squares.chain(others.map(String::from)).collect();
    let alone = all.iter().map(|words| format!("{words} --threads 1"));
    let scaled = SCALED.iter().flat_map(|side| {
        let threaded = move |count| format!("bench grid --n {side} --json --threads {count}");
        (2..=threads).map(threaded)
    });
    all.iter().cloned().chain(alone).chain(scaled).collect()
}

/// The line that a bench prints.
pub fn bench(words: &str) -> Result<Value, String> {
    let mut command = Command::new(program::path());
    command.args(words.split(' ')).current_dir(root()).stderr(Stdio::inherit());
    let output = command.output().map_err(|error| format!("{}: {error}", program::path().display()))?;
    if !output.status.success() {
        return Err(format!("taffeta {words}: failed ({})", output.status));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("taffeta {words}: {error}"))
}

fn with(mut line: Value, more: [(&str, &String); 3]) -> Result<Value, String> {
    let entries = line.as_object_mut().ok_or("the bench printed no JSON object")?;
    entries.extend(more.map(|(key, value)| (key.to_owned(), Value::from(value.as_str()))));
    Ok(line)
}

fn append(file: &Path, line: &Value) -> std::io::Result<()> {
    let mut file = std::fs::OpenOptions::new().create(true).append(true).open(file)?;
    writeln!(file, "{line}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_bench_runs_twice() {
        let mut benches = benches(4);
        let count = benches.len();
        benches.sort();
        benches.dedup();
        assert_eq!(benches.len(), count);
    }
}
