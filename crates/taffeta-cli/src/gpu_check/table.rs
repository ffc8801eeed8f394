//! The report for people.

use super::parity::Row;
use super::report::Report;
use super::scenes::Compared;
use super::speed::Speed;
use crate::console::{counted, grouped};

const GIB: f64 = (1_u64 << 30) as f64;

/// The whole table.
pub fn of(report: &Report) -> String {
    let mut lines = head(report);
    lines.extend(parity(report));
    lines.push(String::new());
    lines.push("scenes, GPU against CPU".to_owned());
    lines.extend(report.scenes.iter().map(scene));
    lines.extend(speeds(report));
    if !report.faults.is_empty() {
        lines.push(String::new());
        lines.push(counted(report.faults.len(), "part was not measured:", "parts were not measured:"));
        lines.extend(report.faults.iter().map(|fault| format!("  {fault}")));
    }
    lines.push(String::new());
    lines.push(verdict(report));
    lines.join("\n")
}

fn head(report: &Report) -> Vec<String> {
    let (device, limits) = (&report.device, &report.device.limits);
    let commit = report.commit.map_or_else(String::new, |commit| format!(" ({commit})"));
    let mut lines = vec![
        format!("taffeta {}{commit} on {} ({}, {})", report.version, device.name, device.api, device.kind),
        format!("  driver {}; host {}", device.driver, device.host),
        format!(
            "  binding {:.2} GiB, buffer {:.2} GiB, {} storage buffers a stage, workgroups of {} invocations and {} KiB",
            limits.storage_binding_bytes as f64 / GIB,
            limits.buffer_bytes as f64 / GIB,
            limits.storage_buffers_per_stage,
            limits.workgroup_invocations,
            limits.workgroup_bytes / 1024
        ),
    ];
    if device.software {
        lines.push(
            "  a software adapter: its results are valid, its timings say nothing of hardware".to_owned(),
        );
    }
    lines.push(String::new());
    lines
}

fn parity(report: &Report) -> Vec<String> {
    let passed = report.parity.iter().filter(|row| row.passed).count();
    let all = report.parity.len();
    let mut lines = vec![format!("kernels: {passed} of {all} agree with their twins on the CPU")];
    lines.push(format!("  {:<36} {:>10} {:>10}", "kernel", "ulps", "allowed"));
    lines.extend(report.parity.iter().map(row));
    lines
}

fn row(row: &Row) -> String {
    let ulps = row.ulps.map_or_else(|| "-".to_owned(), |ulps| format!("{ulps:.2}"));
    let why = row.error.as_ref().or(row.place.as_ref().filter(|_| !row.passed));
    let why = why.map_or_else(String::new, |why| format!(": {why}"));
    let mark = if row.passed { "ok" } else { "FAILED" };
    format!("  {:<36} {ulps:>10} {:>10} {mark}{why}", row.name, row.allowed)
}

fn scene(scene: &Compared) -> String {
    let mark = if scene.passed { "ok" } else { "FAILED" };
    if let Some(error) = &scene.error {
        return format!("  {}, {}: {mark}: {error}", scene.name, scene.kernels);
    }
    let apart = scene.apart.map_or_else(|| "no number".to_owned(), |apart| format!("{apart:.1e} m"));
    let vertex = scene.vertex.map_or_else(String::new, |vertex| format!(" at vertex {vertex}"));
    let twice = if scene.same_twice { "the same bits twice" } else { "NOT the same bits twice" };
    format!(
        "  {}, {}: {apart} apart{vertex} after {} frames ({:.0e} m allowed), {twice}: {mark}",
        scene.name, scene.kernels, scene.frames, scene.allowed
    )
}

fn speeds(report: &Report) -> Vec<String> {
    let mut lines = vec![String::new()];
    if let Some(copy) = &report.copy {
        lines.push(format!(
            "copy: {:.0} GB/s by a kernel, {:.0} GB/s between buffers ({} MiB)",
            copy.kernel_gb_per_s,
            copy.buffer_gb_per_s,
            copy.bytes >> 20
        ));
    }
    if let Some(cost) = &report.substep {
        lines.push(format!(
            "a sub-step on its own: {:.2} µs, and {:.4} ns a node",
            cost.microseconds, cost.nanoseconds_per_node
        ));
    }
    if let Some(read) = &report.read_back {
        lines.push(format!(
            "a frame of {}×{}: {:.3} ms, with its report {:.3} ms, with all positions and velocities {:.3} ms",
            read.n[0], read.n[1], read.ms_without_waiting, read.ms_with_report, read.ms_with_state
        ));
    }
    lines.push(String::new());
    lines.push(format!(
        "{:<8} {:>11} {:<15} {:>12} {:>10} {:>10} {:>9} {:>9} {:>9} {:>8}",
        "part", "n", "kernels", "µs/sub-step", "min", "max", "M nodes/s", "M spr./s", "GB/s", "of copy"
    ));
    lines.extend(report.speeds.iter().map(speed));
    lines
}

fn speed(speed: &Speed) -> String {
    let ms = speed.ms_per_substep;
    let share = speed.copy_fraction.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", share * 1e2));
    format!(
        "{:<8} {:>11} {:<15} {:>12.2} {:>10.2} {:>10.2} {:>9} {:>9} {:>9.1} {share:>8}",
        speed.part,
        format!("{}×{}", speed.n[0], speed.n[1]),
        speed.kernels,
        ms.median * 1e3,
        ms.min * 1e3,
        ms.max * 1e3,
        grouped((speed.particle_substeps_per_s * 1e-6).round() as usize),
        grouped((speed.springs_per_s * 1e-6).round() as usize),
        speed.gb_per_s
    )
}

fn verdict(report: &Report) -> String {
    let seconds = report.seconds;
    match report.failed() {
        0 => format!("all checks passed, {seconds:.0} s in all"),
        count => format!("{} FAILED, {seconds:.0} s in all", counted(count, "check", "checks")),
    }
}
