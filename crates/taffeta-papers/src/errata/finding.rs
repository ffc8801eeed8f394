//! A number of an experiment.

use crate::report::look::grouped;

/// One number, as printed, as corrected and as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What is computed, with its unit.
    pub what: String,
    /// By the paper's form.
    pub printed: Option<f64>,
    /// By the corrected form.
    pub corrected: Option<f64>,
    /// By other means.
    pub exact: Option<f64>,
}

/// No number.
pub(super) const NONE: Option<f64> = None;

/// A finding; [`NONE`] stands where there is no number.
pub(super) fn found(
    what: impl Into<String>,
    printed: impl Into<Option<f64>>,
    corrected: impl Into<Option<f64>>,
    exact: impl Into<Option<f64>>,
) -> Finding {
    Finding { what: what.into(), printed: printed.into(), corrected: corrected.into(), exact: exact.into() }
}

impl Finding {
    /// A row of a table.
    pub(super) fn cells(&self) -> [String; 4] {
        [self.what.clone(), written(self.printed), written(self.corrected), written(self.exact)]
    }
}

/// A number with five digits; whole numbers in full, what is only rounding as 0.
fn written(number: Option<f64>) -> String {
    let Some(number) = number else { return "–".to_owned() };
    let size = number.abs();
    let sign = if number < 0.0 { "−" } else { "" };
    if number.is_nan() {
        "not a number".to_owned()
    } else if size < 1e-9 {
        "0".to_owned()
    } else if size < 1e9 && (size - size.round()).abs() < 1e-12 * size {
        format!("{sign}{}", grouped(size.round() as u64))
    } else if (1e-3..1e6).contains(&size) {
        let digits = (4.0 - size.log10().floor()).max(0.0) as usize;
        if digits == 0 {
            return format!("{sign}{}", grouped(size.round() as u64));
        }
        let text = format!("{size:.digits$}");
        format!("{sign}{}", text.trim_end_matches('0').trim_end_matches('.'))
    } else {
        format!("{sign}{size:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_short_and_plain() {
        let numbers =
            [7_820_856.0, -3.0, 1.0 / 3.0, 1e-12, 4.0 / 3.0 * 1e12, -0.5, 123_456.7, 0.999_999, f64::NAN];
        let texts = numbers.map(|number| written(Some(number)));
        let wanted = ["7,820,856", "−3", "0.33333", "0", "1.33e12", "−0.5", "123,457", "1", "not a number"];
        assert_eq!(texts, wanted);
        assert_eq!(written(None), "–");
    }
}
