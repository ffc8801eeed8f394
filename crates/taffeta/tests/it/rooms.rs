//! What the folders of the engine import: each stands above all that it imports.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The Rust files under a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let of = |path: PathBuf| if path.is_dir() { files(&path) } else { vec![path] };
    entries.flat_map(of).filter(|path| path.extension().is_some_and(|is| is == "rs")).collect()
}

/// Comparisons of a kernel with the CPU and tests may use everything.
fn is_test(file: &str) -> bool {
    ["parity", "twin", "tests"].iter().any(|word| file.contains(word)) || file == "lib.rs"
}

/// The code of a file, without comments and unit tests.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).expect("a text");
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The first names of all paths that begin with `crate::`.
fn imports(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = BTreeSet::new();
    for after in code.split("crate::").skip(1) {
        let Some(list) = after.strip_prefix('{') else {
            found.insert(word(after));
            continue;
        };
        let (mut depth, mut first) = (1, true);
        for (at, c) in list.char_indices() {
            depth += i32::from(c == '{') - i32::from(c == '}');
            if depth == 0 {
                break;
            }
            if depth == 1 && first && c.is_alphabetic() {
                found.insert(word(&list[at..]));
                first = false;
            }
            first |= depth == 1 && c == ',';
        }
    }
    found
}

/// What each folder, or file beside them, of the engine imports, and where.
fn graph() -> BTreeMap<String, BTreeMap<String, String>> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut graph: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for path in files(&src) {
        let file = path.strip_prefix(&src).expect("below").to_string_lossy().replace('\\', "/");
        let room = file.split(['/', '.']).next().unwrap_or_default().to_owned();
        let of = graph.entry(room.clone()).or_default();
        if !is_test(&file) {
            let others = imports(&code(&path)).into_iter().filter(|other| *other != room);
            others.for_each(|other| drop(of.insert(other, file.clone())));
        }
    }
    graph
}

#[test]
fn no_two_folders_import_each_other_by_any_way() {
    let mut left = graph();
    assert!(left["contact"].contains_key("cpu") && left["cpu"].contains_key("step"), "imports are found");
    // Folders that import none of those that are left are taken away, until none is.
    loop {
        let names: BTreeSet<String> = left.keys().cloned().collect();
        let before = left.len();
        left.retain(|_, imports| imports.keys().any(|other| names.contains(other)));
        if left.len() == before {
            break;
        }
    }
    let names: BTreeSet<&String> = left.keys().collect();
    let ties: Vec<String> = left
        .iter()
        .flat_map(|(room, of)| of.iter().map(move |(other, file)| (room, other, file)))
        .filter(|(_, other, _)| names.contains(other))
        .map(|(room, other, file)| format!("{room} imports {other}: {file}"))
        .collect();
    assert!(ties.is_empty(), "a circle, or above one:\n{}", ties.join("\n"));
}

/// Words of `unsafe` in the crates, but for comparisons, twins and tests: that they become no more. Each says why it is sound, which
/// Clippy sees to. `taffeta-shaders`, which users do not get, is there to call Vulkan.
const UNSAFE: usize = 197;

#[test]
fn unsafe_code_does_not_grow() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let count = |path: &PathBuf| {
        let name = path.to_string_lossy();
        let counts = name.contains("/src/")
            && !["parity", "twin", "tests", "taffeta-shaders"].iter().any(|word| name.contains(word));
        let is_part = |c: char| !c.is_alphanumeric() && c != '_';
        if counts { code(path).split(is_part).filter(|word| *word == "unsafe").count() } else { 0 }
    };
    let found: usize = files(&crates).iter().map(count).sum();
    assert!(found <= UNSAFE, "{found} words of `unsafe`, and {UNSAFE} are allowed");
    assert!(found + 5 > UNSAFE, "{found} words of `unsafe`: lower the number that is allowed to it");
}
