//! The machine that a program runs on.

use std::process::Command;

/// The processor's name, as the system has it; its architecture, where the system has none.
pub fn processor() -> String {
    let linux = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let apple = || {
        let output = Command::new("sysctl").args(["-n", "machdep.cpu.brand_string"]).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    linux.or_else(apple).unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}
