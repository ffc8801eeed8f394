//! The bench on nodes that touch each other; a software adapter serves for its rungs on a GPU.

use crate::desk::{Desk, SHEET, ending};

/// Every rung of S2's ladder on a GPU.
const LADDER: [&str; 6] = ["naive", "constants", "squared", "swapped", "scanned", "refreshed"];

#[test]
fn every_rung_prints_a_line_in_the_ladder_s_order() {
    let desk = Desk::with(SHEET);
    let words = "bench contact --n 8 --frames 2 --json --rungs binned,refreshed,scanned,swapped,squared,constants,naive";
    let (out, err, code) = ending(desk.taffeta(&words.split(' ').collect::<Vec<_>>()));
    assert_eq!(code, Some(0), "{err}");
    let lines: Vec<serde_json::Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let rungs: Vec<_> = lines.iter().map(|line| line["rung"].as_str().unwrap()).collect();
    assert_eq!(rungs, [&LADDER[..], &["binned"]].concat());
    for line in &lines[..6] {
        assert_eq!((&line["backend"], &line["frames"]), (&"gpu".into(), &2.into()));
        assert!(line["device"].as_str().unwrap().starts_with("gpu, "), "{line}");
        assert!(line["kernels"].is_null());
        for path in ["/ms_per_frame/min", "/limits/memory_gb_per_s", "/particle_substeps_per_s"] {
            assert!(line.pointer(path).unwrap().as_f64().unwrap() > 0.0, "{path}");
        }
    }
    let note = |line: &serde_json::Value| line["note"].as_str().unwrap_or_default().to_owned();
    assert!(note(&lines[4]).contains("0 nodes found no room in a bin"), "{out}");
    assert!(note(&lines[5]).contains("0 nodes are in no bin any more"), "{out}");
}

#[test]
fn rungs_that_cannot_be_are_refused() {
    let desk = Desk::with(SHEET);
    let refused = |words: &str, parts: &[&str]| {
        let mut command = desk.taffeta(&words.split(' ').collect::<Vec<_>>());
        command.env("TAFFETA_ADAPTER", "nonsense");
        let (_, err, code) = ending(command);
        assert_eq!(code, Some(2), "{words}: {err}");
        assert!(parts.iter().all(|part| err.contains(part)), "{words}: {err}");
    };
    refused("bench contact --rungs nave", &["invalid value 'nave'", "serial, naive, constants", "naive'"]);
    refused("bench contact --rungs naive,", &["a value is required for '--rungs"]);
    refused("bench grid --rungs naive", &["--rungs is for `bench contact`"]);
    refused("bench contact --rungs swapped --precision f64", &["--rungs swapped computes in 32 bits"]);
    // Said before the rung on the CPU takes its time.
    let adapter = ["--rungs scanned: TAFFETA_ADAPTER=`nonsense` fits no adapter; there ", "0: "];
    refused("bench contact --n 8 --rungs serial,scanned", &adapter);
}

#[test]
fn more_nodes_than_a_software_adapter_loops_over_are_refused() {
    let desk = Desk::with(SHEET);
    let words = "bench contact --rows 2 --cols 32768 --rungs naive";
    let mut command = desk.taffeta(&words.split(' ').collect::<Vec<_>>());
    command.env("TAFFETA_ADAPTER", "software");
    let (_, err, code) = ending(command);
    assert_eq!(code, Some(2), "{err}");
    if !err.contains("fits no adapter") {
        assert!(
            err.contains("--rungs naive: 65536 nodes on ") && err.contains("a smaller --n would do"),
            "{err}"
        );
    }
}
