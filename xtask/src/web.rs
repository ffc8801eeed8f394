//! The npm package: the engine as wasm, one module with it inside, the page, and their tests in node and in a browser.

mod tools;

use crate::program::target;
use crate::test::Built;
use crate::{apt, root, vulkan};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use tools::Compiler;

const TRIPLE: &str = "wasm32-unknown-unknown";
/// Vector instructions, and the stack of a program: 1 MiB would do for scenes, and some meshes recurse.
const FLAGS: &str = "-C target-feature=+simd128 -C link-arg=-zstack-size=4194304";

/// `cargo xtask web`: builds the package and the page; with `--serve` shows the page.
pub fn run(words: &[&str]) -> ExitCode {
    let result = match words {
        [] => build().map(|_| ()),
        ["--serve"] => build().and_then(|()| serve()),
        _ => Err(format!("web {}: it takes [--serve]", words.join(" "))),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Builds the package as users get it, and tests it in node and in Chromium. Where there is no compiler, node or browser, and none
/// can be installed, it says so and tests nothing.
pub fn test(built: &Built) -> Result<(), String> {
    let program = built.program("taffeta-cli", "taffeta");
    let Some(program) = program else { return Err("web: the program `taffeta` was not built".to_owned()) };
    if let Some(missing) = tools::missing()
        && !apt::is_ours()
    {
        println!("xtask: web: skipped, there is no {missing}, and this user cannot install packages");
        return Ok(());
    }
    build()?;
    let mut tests = node(&["tests/run.mjs"]);
    tests.arg(program).arg(packed()?);
    tests
        .env("TAFFETA_CHROMIUM", tools::browser().unwrap_or_default())
        .env("TAFFETA_SITE", folder()?.join("site"));
    done(&mut tests, "its tests")
}

/// Builds the module, packs it, and lays out the page.
fn build() -> Result<(), String> {
    let compiler = tools::provide()?;
    wasm(&compiler)?;
    tools::modules()?;
    done(&mut node(&["build.mjs"]), "node build.mjs")?;
    let out = folder()?;
    for old in tarballs()? {
        fs::remove_file(&old).map_err(|error| format!("{}: {error}", old.display()))?;
    }
    let mut pack = Command::new("npm");
    pack.args(["pack", "--silent", "--pack-destination"]).arg(&out).current_dir(web().join("package"));
    done(&mut pack, "npm pack")?;
    done(node(&["site.mjs"]).arg(out.join("site")), "node site.mjs")?;
    println!("xtask: the package is {}, the page is in {}", packed()?.display(), out.join("site").display());
    Ok(())
}

/// Builds the engine, and what JavaScript calls it by, into the package's folder.
fn wasm(compiler: &Compiler) -> Result<(), String> {
    let mut cargo = compiler.cargo();
    cargo.args(["build", "--target", TRIPLE, "-p", "taffeta-web", "--profile", "web"]).current_dir(root());
    cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", FLAGS);
    done(&mut cargo, "cargo build for wasm32")?;
    let mut bindgen = Command::new(tools::bindgen()?);
    bindgen
        .args(["--target", "web", "--omit-default-module-path", "--out-dir"])
        .arg(web().join("package/build"));
    bindgen.args(["--remove-name-section", "--remove-producers-section"]);
    bindgen.arg(target().join(TRIPLE).join("web/taffeta_web.wasm"));
    done(&mut bindgen, "wasm-bindgen")
}

fn serve() -> Result<(), String> {
    done(node(&["serve.mjs"]).arg(folder()?.join("site")), "node serve.mjs")
}

/// Where the package and its page are built from.
fn web() -> PathBuf {
    root().join("web")
}

/// What is built that is no part of the sources.
fn folder() -> Result<PathBuf, String> {
    let folder = target().join("web");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    folder.canonicalize().map_err(|error| format!("{}: {error}", folder.display()))
}

fn tarballs() -> Result<Vec<PathBuf>, String> {
    let files = fs::read_dir(folder()?).map_err(|error| format!("target/web: {error}"))?;
    let is_tarball = |file: &PathBuf| file.extension().is_some_and(|ending| ending == "tgz");
    Ok(files.flatten().map(|entry| entry.path()).filter(is_tarball).collect())
}

/// The tarball of the package.
fn packed() -> Result<PathBuf, String> {
    tarballs()?.pop().ok_or_else(|| "npm pack: it has left no tarball".to_owned())
}

fn node(words: &[&str]) -> Command {
    let mut command = Command::new("node");
    command.args(words).current_dir(web());
    command
}

fn done(command: &mut Command, name: &str) -> Result<(), String> {
    let status =
        vulkan::quiet(command).status().map_err(|error| format!("web: {name}: cannot start: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("web: {name}: failed ({status})")) }
}
