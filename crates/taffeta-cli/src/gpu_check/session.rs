//! Part after part: what fails is kept and the rest goes on, and the file is whole after each part.

use super::guard::guarded;
use super::report::{Report, Substep};
use super::{jobs, parity, readback, scenes, speed};
use crate::bench::kernels;
use crate::console;
use crate::gpu::Copied;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use taffeta::GpuCost;
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta_io::files;
use taffeta_io::program::{Failure, complain};

/// After this time no further speed is measured, so that a slow device ends too [s].
const LONGEST: Duration = Duration::from_secs(420);

/// A check under way.
pub struct Session {
    gpu: Gpu,
    choice: Choice,
    small: bool,
    out: Option<PathBuf>,
    start: Instant,
    report: Report,
}

impl Session {
    /// Opens the device.
    pub fn open(out: Option<&Path>, quick: bool, only: &[String]) -> Result<Self, Failure> {
        let choice = Choice::from_env();
        let gpu = Gpu::open(&choice).map_err(|error| Failure::Input(error.to_string()))?;
        let report = Report::new(&gpu, quick, only);
        let small = quick || report.device.software;
        let out = out.map(Path::to_owned);
        let session = Self { gpu, choice, small, out, start: Instant::now(), report };
        complain(&format!("gpu-check: {}", session.gpu.info()));
        session.save()?;
        Ok(session)
    }

    /// Compares kernels, then whole scenes, with the CPU.
    pub fn checks(&mut self) -> Result<(), Failure> {
        for row in taffeta::parity::rows() {
            let name = format!("parity {}", row.name);
            if !self.wants(&name) {
                continue;
            }
            self.begin(&name);
            let row = parity::run(&row, &self.gpu);
            self.report.parity.push(row);
            self.end_part()?;
        }
        for check in scenes::checks(self.report.quick) {
            let name = format!("scene {}, {}", check.scene.title, kernels::name(check.kernels));
            if !self.wants(&name) {
                continue;
            }
            self.begin(&name);
            let compared = scenes::compare(&check, &self.gpu);
            self.report.scenes.push(compared);
            self.end_part()?;
        }
        Ok(())
    }

    /// Measures copies, sub-steps, scenes and read-back.
    pub fn measurements(&mut self) -> Result<(), Failure> {
        let small = self.small;
        self.report.copy = self.part("copy bandwidth", |gpu, _| {
            Copied::measure(gpu, small).map_err(|error| error.to_string())
        })?;
        self.report.substep = self.part("cost of a sub-step", |gpu, _| substep(gpu))?;
        self.report.read_back = self.part("read-back", |gpu, _| readback::measure(gpu, small))?;
        for job in jobs::all(small) {
            let speed = self.part(&job.name(), |gpu, report| {
                let copy = report.copy.map(|copy| copy.best());
                speed::measure(&job, gpu, small, copy)
            })?;
            self.report.speeds.extend(speed);
        }
        Ok(())
    }

    /// The whole report, as it was written.
    pub fn end(mut self) -> Result<Report, Failure> {
        self.report.complete = true;
        self.report.seconds = self.start.elapsed().as_secs_f64();
        self.save()?;
        Ok(self.report)
    }

    /// Does a measurement, if there is time left; keeps why it failed.
    fn part<T>(
        &mut self,
        name: &str,
        work: impl FnOnce(&Gpu, &Report) -> Result<T, String>,
    ) -> Result<Option<T>, Failure> {
        if !self.wants(name) {
            return Ok(None);
        }
        let done = if self.start.elapsed() > LONGEST {
            Err(format!("left out, for {} s were over", LONGEST.as_secs()))
        } else {
            self.begin(name);
            guarded(|| work(&self.gpu, &self.report))
        };
        let kept = done.map_err(|why| self.report.faults.push(format!("{name}: {why}"))).ok();
        self.end_part()?;
        Ok(kept)
    }

    fn wants(&self, name: &str) -> bool {
        let only = &self.report.only;
        only.is_empty() || only.iter().any(|word| name.contains(word.as_str()))
    }

    fn begin(&self, name: &str) {
        complain(&format!("gpu-check: {:5.1} s: {name}", self.start.elapsed().as_secs_f64()));
    }

    /// A device that has failed once says so for ever: the next part gets a new one.
    fn end_part(&mut self) -> Result<(), Failure> {
        if let Err(error) = self.gpu.health() {
            let again = match Gpu::open(&self.choice) {
                Ok(gpu) => {
                    self.gpu = gpu;
                    "opened again".to_owned()
                }
                Err(why) => format!("not opened again ({why})"),
            };
            self.report.faults.push(format!("the device was {again} after this: {error}"));
        }
        self.report.seconds = self.start.elapsed().as_secs_f64();
        self.save()
    }

    /// Writes the report as it is: what is known by now is not lost with what follows.
    fn save(&self) -> Result<(), Failure> {
        let Some(file) = &self.out else { return Ok(()) };
        let text = console::json(&self.report)? + "\n";
        // Put in place when it is whole: a driver may take the program down at any time.
        files::replace(file, &[text.as_bytes()]).map_err(|error| Failure::Work(error.to_string()))
    }
}

fn substep(gpu: &Gpu) -> Result<Substep, String> {
    let cost = GpuCost::measure(gpu)?;
    Ok(Substep {
        microseconds: cost.seconds_per_substep * 1e6,
        nanoseconds_per_node: cost.seconds_per_node * 1e9,
    })
}
