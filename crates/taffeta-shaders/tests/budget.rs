//! What Mesa's compiler for AMD makes of the kernels: code within a cache for instructions, no vectors spilled to memory, and few
//! enough registers that a SIMD has many waves to choose from while others wait for memory.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::process::Command;

/// Bytes of the cache for instructions.
const CACHE: f64 = 32768.0;
/// Waves that a SIMD of navi21 should have at least, in units of 32 lanes, of 32.
const WAVES: f64 = 16.0;
/// Kernels that have fewer, and how many. Contact with a mesh computes with nine numbers a triangle, beside all that it knows of its
/// node; the others miss by a few registers.
const FEWER: [(&str, &str, f64); 12] = [
    ("contact_all", "contact/collider_mesh/surface.wgsl", 8.0),
    ("contact_after_self_collision", "", 8.0),
    ("apply_attachments", "contact/collider_mesh/surface.wgsl", 8.0),
    ("apply_impulses", "contact/collider_mesh/surface.wgsl", 8.0),
    ("restore_volumes", "contact/collider_mesh/surface.wgsl", 8.0),
    ("predict_mesh_contacts", "", 10.0),
    ("predict_mesh_contacts_implicit", "", 10.0),
    ("limit_ways", "", 12.0),
    ("bend_triangles", "", 14.0),
    ("bend_triangles", "solvers/implicit/moved.wgsl", 14.0),
    ("grid_patches", "", 14.0),
    ("mesh_patches", "", 14.0),
];
/// What the program ends with where it has no driver to ask.
const NO_DRIVER: i32 = 2;
/// The version that waves are of. Others have other schedulers.
const MESA: &str = "Mesa 22.3.6";

#[derive(Deserialize)]
struct Found {
    driver: String,
    kernels: Vec<Compiled>,
}

#[derive(Deserialize)]
struct Compiled {
    entry: String,
    with: String,
    statistics: BTreeMap<String, f64>,
}

#[test]
fn kernels_keep_within_registers_and_the_cache_for_instructions() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_taffeta-shaders")).arg("navi21").output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(NO_DRIVER) {
        println!("not checked: {said}");
        return;
    }
    assert!(output.status.success(), "{said}");
    let found: [Found; 1] = serde_json::from_slice(&output.stdout).expect("an array of one");
    let [Found { driver, kernels }] = found;
    assert!(kernels.len() > 150, "{} kernels", kernels.len());
    let counts_waves = driver.starts_with(MESA);
    if !counts_waves {
        println!("waves are not checked: the driver is {driver}, and the numbers are of {MESA}");
    }
    let over: Vec<String> = kernels.iter().filter_map(|one| over_budget(one, counts_waves)).collect();
    assert!(over.is_empty(), "{}", over.join("\n"));
}

/// What is too much of a kernel.
fn over_budget(kernel: &Compiled, counts_waves: bool) -> Option<String> {
    let of = |name: &str| kernel.statistics[name];
    let is_it = |&&(entry, with, _): &&(&str, &str, f64)| entry == kernel.entry && with == kernel.with;
    let waves = FEWER.iter().find(is_it).map_or(WAVES, |&(.., waves)| waves);
    let is_over = of("Code size") > CACHE
        || counts_waves && of("Subgroups per SIMD") < waves
        || of("Spilled VGPRs") > 0.0
        || of("Scratch size") > 0.0;
    is_over.then(|| {
        format!(
            "{} with `{}`: {} bytes of code (at most {CACHE}), {} waves (at least {waves}), {} VGPRs, {} spilled",
            kernel.entry,
            kernel.with,
            of("Code size"),
            of("Subgroups per SIMD"),
            of("VGPRs"),
            of("Spilled VGPRs"),
        )
    })
}
