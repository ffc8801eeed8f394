//! What a run did over time, as a table in a small file.

use std::fmt::Write;
use std::path::Path;
use taffeta::diagnostics::FrameReport;

/// Rows of a file, at most: a row is the largest of some frames.
const ROWS: usize = 150;
const HEAD: &str = "time,max_stretch,energy,iterations,residual,active";
/// Numbers of a row.
pub const COLUMNS: usize = 6;

/// Numbers over time. It ends where the run blew up.
#[derive(Default)]
pub struct Curve {
    /// Time at the end [s]; then the largest in the row's frames: l/L, energy beyond that at the start [J], iterations, relative
    /// residual, share of springs that are constraints.
    pub rows: Vec<[f64; COLUMNS]>,
}

impl Curve {
    /// Of the reports of all frames, that of the start first.
    pub fn new(reports: &[FrameReport]) -> Self {
        let Some((start, later)) = reports.split_first() else { return Self::default() };
        let row = |report: &FrameReport| {
            let solver = &report.solver;
            let energy = report.energy() - start.energy();
            let iterations = f64::from(solver.iterations);
            [report.time, report.max_stretch, energy, iterations, solver.residual, solver.active_fraction]
        };
        let largest = |a: [f64; COLUMNS], b: [f64; COLUMNS]| std::array::from_fn(|i| a[i].max(b[i]));
        let frames = later.len().div_ceil(ROWS).max(1);
        let rows = later.chunks(frames).filter_map(|some| some.iter().map(row).reduce(largest));
        Self { rows: rows.collect() }
    }
}

/// Writes a curve.
pub fn write(file: &Path, curve: &Curve) -> Result<(), String> {
    let mut text = format!("{HEAD}\n");
    for [time, stretch, energy, iterations, residual, active] in &curve.rows {
        // Writing to a string cannot fail.
        let _ =
            writeln!(text, "{time:.3},{stretch:.5},{energy:.4},{iterations:.0},{residual:.2e},{active:.5}");
    }
    std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()))
}

/// Reads what [`write`] wrote.
pub fn read(file: &Path) -> Result<Curve, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let row = |(index, line): (usize, &str)| {
        let numbers: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
        let row = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        row.ok_or_else(|| format!("{}:{}: {line}", file.display(), index + 1))
    };
    let rows: Result<_, String> = text.lines().enumerate().skip(1).map(row).collect();
    Ok(Curve { rows: rows? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(frame: u32, stretch: f64, kinetic: f64) -> FrameReport {
        FrameReport { frame, time: f64::from(frame), max_stretch: stretch, kinetic, ..FrameReport::default() }
    }

    #[test]
    fn a_row_is_the_largest_of_its_frames_and_energy_is_beyond_the_start() {
        let mut reports: Vec<FrameReport> =
            (0..=2 * ROWS as u32).map(|frame| report(frame, 1.0, 5.0)).collect();
        (reports[1].max_stretch, reports[2].kinetic) = (1.5, 7.0);
        let curve = Curve::new(&reports);
        assert_eq!(curve.rows.len(), ROWS);
        assert_eq!(curve.rows[0], [2.0, 1.5, 2.0, 0.0, 0.0, 0.0]);
        assert_eq!(curve.rows[1][..3], [4.0, 1.0, 0.0]);
    }

    #[test]
    fn what_is_written_is_read() {
        let file = std::env::temp_dir().join(format!("taffeta-constraints-{}.csv", std::process::id()));
        let row = [0.5, 1.25, -3.5, 20.0, 2.5e-4, 0.125];
        let read = write(&file, &Curve { rows: vec![row] }).and_then(|()| read(&file));
        let _ = std::fs::remove_file(&file);
        assert_eq!(read.map(|curve| curve.rows), Ok(vec![row]));
    }
}
