//! What a row of the comparison has found.

use std::fmt;

/// What a row has found.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The largest difference, in units in the last place of the largest number of that output; infinite where one of
    /// the two is no number, or where numbers that are only copied differ.
    pub ulps: f64,
    /// Where it is, unless all are the same.
    pub place: Option<Difference>,
    /// Numbers compared.
    pub compared: usize,
}

/// A number on which the twins do not agree.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The array, or the sum.
    pub output: String,
    /// Which of its numbers.
    pub index: usize,
    /// What the CPU says.
    pub cpu: f32,
    /// What the GPU says.
    pub gpu: f32,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { output, index, cpu, gpu } = self;
        write!(f, "{output}[{index}] is {cpu:e} on the CPU and {gpu:e} on the GPU")
    }
}

impl Outcome {
    /// Compares numbers of one quantity, in units in the last place of the largest.
    pub fn compare(&mut self, output: &str, wanted: &[f32], found: &[f32]) {
        let finite = wanted.iter().filter(|number| number.is_finite());
        let largest = finite.fold(0.0_f32, |most, number| most.max(number.abs()));
        self.compare_to(output, wanted, found, f64::from(largest));
    }

    /// Compares numbers in units in the last place of `largest`.
    pub fn compare_to(&mut self, output: &str, wanted: &[f32], found: &[f32], largest: f64) {
        self.count(output, wanted.len(), found.len());
        let unit = last_place(largest);
        for (index, (&cpu, &gpu)) in wanted.iter().zip(found).enumerate() {
            let apart = (f64::from(cpu) - f64::from(gpu)).abs();
            let alike = cpu == gpu || cpu.is_nan() && gpu.is_nan();
            let ulps = if alike { 0.0 } else { apart / unit };
            self.note(if ulps.is_nan() { f64::INFINITY } else { ulps }, output, index, [cpu, gpu]);
        }
    }

    /// Compares numbers that are only copied: they are the same on every device.
    pub fn copied(&mut self, output: &str, wanted: &[f32], found: &[f32]) {
        self.count(output, wanted.len(), found.len());
        for (index, (&cpu, &gpu)) in wanted.iter().zip(found).enumerate() {
            let alike = cpu == gpu || cpu.is_nan() && gpu.is_nan();
            self.note(if alike { 0.0 } else { f64::INFINITY }, output, index, [cpu, gpu]);
        }
    }

    fn count(&mut self, output: &str, wanted: usize, found: usize) {
        self.compared += wanted;
        if wanted != found {
            self.note(f64::INFINITY, &format!("{output}.len()"), 0, [wanted as f32, found as f32]);
        }
    }

    fn note(&mut self, ulps: f64, output: &str, index: usize, [cpu, gpu]: [f32; 2]) {
        if ulps > self.ulps {
            self.ulps = ulps;
            self.place = Some(Difference { output: output.to_owned(), index, cpu, gpu });
        }
    }
}

/// The unit in the last place of a number of 32 bits. What is below the least normal number may be taken for zero.
fn last_place(number: f64) -> f64 {
    let number = (number as f32).max(f32::MIN_POSITIVE);
    (f64::from(number.next_up()) - f64::from(number)).max(f64::from(f32::MIN_POSITIVE))
}
