//! Volume over time, as a table in a small file.

use std::fmt::Write;
use std::path::Path;

/// A run's volume after each frame.
pub struct Curve {
    /// The form that kept it.
    pub form: String,
    /// Volume of all bodies over that at rest, of frame 1 on; it ends where the run blew up.
    pub shares: Vec<f64>,
}

impl Curve {
    /// Without frames yet.
    pub fn new(form: &str) -> Self {
        Self { form: form.to_owned(), shares: Vec::new() }
    }
}

/// Writes curves: a column each, a row for each frame, nothing where a run has ended.
pub fn write(file: &Path, curves: &[Curve]) -> Result<(), String> {
    let mut text = "frame".to_owned();
    curves.iter().for_each(|curve| text.extend([",", curve.form.as_str()]));
    text.push('\n');
    let rows = curves.iter().map(|curve| curve.shares.len()).max().unwrap_or(0);
    for row in 0..rows {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}", row + 1);
        for curve in curves {
            let share = curve.shares.get(row).map(|share| format!("{share:.6}"));
            text.extend([",", share.as_deref().unwrap_or_default()]);
        }
        text.push('\n');
    }
    std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()))
}

/// Reads what [`write`] wrote.
pub fn read(file: &Path) -> Result<Vec<Curve>, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut lines = text.lines();
    let forms = lines.next().unwrap_or_default().split(',').skip(1);
    let mut curves: Vec<Curve> = forms.map(Curve::new).collect();
    for (index, line) in lines.enumerate() {
        for (curve, share) in curves.iter_mut().zip(line.split(',').skip(1)) {
            if !share.is_empty() {
                let number =
                    share.parse().map_err(|_| format!("{}:{}: {share}", file.display(), index + 2))?;
                curve.shares.push(number);
            }
        }
    }
    Ok(curves)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_a_run_may_end_early() {
        let file = std::env::temp_dir().join(format!("taffeta-curve-{}.csv", std::process::id()));
        let long = Curve { form: "none".into(), shares: vec![1.0, 0.5, -0.25] };
        let short = Curve { form: "printed".into(), shares: vec![1.0] };
        write(&file, &[long, short]).unwrap();
        let curves = read(&file);
        std::fs::remove_file(&file).unwrap();
        let curves = curves.unwrap();
        assert_eq!((curves[0].form.as_str(), curves[0].shares.as_slice()), ("none", &[1.0, 0.5, -0.25][..]));
        assert_eq!((curves[1].form.as_str(), curves[1].shares.as_slice()), ("printed", &[1.0][..]));
    }
}
