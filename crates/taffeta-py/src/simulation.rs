//! The Python class `Simulation`: it converts and calls. Its documentation is what Python shows.

mod controls;
mod reads;

use crate::control;
use crate::errors::{Failure, guarded};
use crate::options::Choices;
use crate::report::{self, Names};
use crate::running::{Running, hold, step};
use crate::scene::Parts;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::ffi::CString;
use std::sync::{Mutex, MutexGuard};
use taffeta::OnDivergence;

/// A scene that runs.
///
/// Args:
///     scene: A `Scene`, or what one is made of: the path of a TOML file, TOML text, a dict.
///     backend: "cpu", "gpu", or "auto": a GPU where the scene gains by it; `backend_reason` says why.
///     threads: Threads of the CPU; as many as help where it is not given. No bit depends on it.
///     precision: Arithmetic: "f32", or "f64" for a reference. Arrays are float32 or float64 accordingly.
///     on_divergence: What becomes of a body that diverges: "stop" raises `DivergedError`, "freeze" has it stand still while the
///         others go on.
///
/// Raises:
///     SceneError: The scene cannot be simulated. The message names the place, and what would do.
///     DeviceError: There is no such device, or it cannot run the scene.
///
/// >>> import taffeta
/// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal").pin("cloth", rows=0)
/// >>> simulation = taffeta.Simulation(scene, threads=1)
/// >>> simulation
/// <taffeta.Simulation of cloth: frame 0, cpu, 1 thread, ...>
///
/// Threads of Python may share a simulation: each call has it to itself. While frames run, other threads of Python do, too. It can
/// be pickled, with its state.
#[pyclass(frozen, name = "Simulation", module = "taffeta", weakref)]
pub struct Simulation {
    running: Mutex<Running>,
    /// The scene as it was when this was built: a copy of the Python object.
    scene: Py<PyAny>,
    choices: Choices,
    why: String,
    names: Names,
}

/// Says what the user should know.
pub fn warn(py: Python<'_>, warnings: &[String]) -> PyResult<()> {
    let kind = py.import("taffeta._errors")?.getattr("SceneWarning")?;
    warnings.iter().try_for_each(|warning| PyErr::warn(py, &kind, &CString::new(warning.as_str())?, 1))
}

impl Simulation {
    /// A scene that runs, from its Python object.
    pub fn of(running: Running, scene: Py<PyAny>, choices: Choices, why: String) -> Self {
        let names = Names::of(&running.simulation);
        Self { running: Mutex::new(running), scene, choices, why, names }
    }

    /// What it shares with other threads.
    pub fn shared(&self) -> &Mutex<Running> {
        &self.running
    }

    /// Does `work` without Python.
    pub fn work<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Running) -> Result<R, Failure> + Send,
    ) -> PyResult<R> {
        Ok(py.detach(|| hold(&self.running).work(work))?)
    }

    /// Holds the simulation while Python is at hand; until it can be held, other threads of Python run. Nothing of Python may be called
    /// before it is let go: that might call this.
    fn hold<'a>(&'a self, py: Python<'_>) -> MutexGuard<'a, Running> {
        self.running.lock_py_attached(py).unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, *, backend="auto", threads=None, precision="f32", on_divergence="stop"))]
    fn new(
        scene: &Bound<'_, PyAny>,
        backend: &str,
        threads: Option<i64>,
        precision: &str,
        on_divergence: &str,
    ) -> PyResult<Self> {
        let py = scene.py();
        let choices = Choices::of(backend, threads, precision, on_divergence)?;
        let scene = py.import("taffeta._scene")?.getattr("copy_of")?.call1((scene,))?;
        let written = scene.extract::<Parts<'_>>()?.write()?;
        let (running, why) = py.detach(|| guarded(|| Running::build(written, &choices)))?;
        warn(py, &running.warnings())?;
        Ok(Self::of(running, scene.unbind(), choices, why))
    }

    /// Runs frames, and reports the last.
    ///
    /// Ctrl-C stops it, and leaves the state of the last whole frame. On the CPU also a long frame is given up on its way, and with it
    /// what was asked for that frame, such as forces.
    ///
    /// Args:
    ///     frames: How many.
    ///
    /// Returns:
    ///     A dict: `frame`, `time` [s], energies [J] by kind and their sum `energy`, `momentum` [kg·m/s], `angular_momentum`
    ///     [kg·m²/s], `max_stretch`, `contacts`, `iterations` of the solver, `volumes` [m³] and `reactions` of pins [N] by body, and
    ///     what else `docs/outputs.md` has of frames.
    ///
    /// Raises:
    ///     DivergedError: A body diverged. The state is that of the last good frame.
    ///     DeviceError: A GPU does not answer any more.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
    /// >>> simulation = taffeta.Simulation(scene)
    /// >>> report = simulation.step(30)
    /// >>> report["frame"], round(report["time"], 3)
    /// (30, 0.5)
    #[pyo3(signature = (frames=1))]
    fn step<'py>(&self, py: Python<'py>, frames: i64) -> PyResult<Bound<'py, PyDict>> {
        step(py, &self.running, control::frames(frames)?)?;
        self.report(py)
    }

    /// Runs as many whole frames as last `seconds` [s], or the first number that lasts longer; as `step` otherwise.
    fn advance<'py>(&self, py: Python<'py>, seconds: f64) -> PyResult<Bound<'py, PyDict>> {
        let dt = self.hold(py).simulation.dt();
        step(py, &self.running, control::frames_of(seconds, dt)?)?;
        self.report(py)
    }

    /// The state as bytes, in the format of the program's checkpoints.
    ///
    /// Pinned vertices, poses of colliders and pins, and the world are part of it. What was asked for the frame to come is not.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
    /// >>> simulation = taffeta.Simulation(scene)
    /// >>> start = simulation.snapshot()
    /// >>> before = simulation.step(5)
    /// >>> simulation.restore(start)
    /// >>> simulation.step(5) == before
    /// True
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.work(py, Running::snapshot)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Takes up the state of a snapshot of the same scene. From there it goes on bit by bit as the other one did.
    ///
    /// The bytes of a checkpoint of the program do as well.
    ///
    /// Raises:
    ///     SnapshotError: The snapshot is damaged, or of another version or scene; the message says what differs.
    fn restore(&self, py: Python<'_>, snapshot: &[u8]) -> PyResult<()> {
        self.work(py, |running| running.restore(snapshot))
    }

    /// Goes on where a simulation of another scene is: takes its time, and positions and velocities of bodies with the same name and
    /// as many nodes.
    ///
    /// So materials and all else change while cloth runs: change the scene, build it, and adopt the state. Pins and poses by the
    /// program do not come along.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal").pin("cloth", rows=0)
    /// >>> cotton = taffeta.Simulation(scene)
    /// >>> report = cotton.step(10)
    /// >>> denim = taffeta.Simulation(cotton.scene.set("body.cloth.material.preset", "denim"))
    /// >>> denim.adopt_state(cotton)
    /// >>> denim.frame, bool((denim.positions() == cotton.positions()).all())
    /// (10, True)
    fn adopt_state(&self, py: Python<'_>, other: &Bound<'_, Self>) -> PyResult<()> {
        let other = other.get();
        if std::ptr::eq(self, other) {
            return Ok(());
        }
        let is_first = std::ptr::from_ref(self) < std::ptr::from_ref(other);
        Ok(py.detach(|| {
            // In one order for all, so that no two threads wait for each other.
            let (mut to, from) = if is_first {
                let to = hold(&self.running);
                (to, hold(&other.running))
            } else {
                let from = hold(&other.running);
                (hold(&self.running), from)
            };
            to.work(|to| {
                to.simulation.adopt_state(&from.simulation);
                Ok(())
            })
        })?)
    }

    /// 64-bit hash of positions and velocities as 16 hexadecimal digits, as the program prints it. Equal states have equal hashes, on
    /// any number of threads.
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        self.work(py, |running| {
            running.simulation.fetch()?;
            Ok(format!("{:016x}", running.simulation.state_hash()))
        })
    }

    /// Report of the last frame, or of the start, as `step` returns it.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = self.work(py, |running| Ok(running.simulation.report().clone()))?;
        report::dict(py, &report, &self.names)
    }

    /// Number of frames done.
    #[getter]
    fn frame(&self, py: Python<'_>) -> u32 {
        self.hold(py).simulation.frame()
    }

    /// Time since the start [s].
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        let running = self.hold(py);
        f64::from(running.simulation.frame()) * running.simulation.dt()
    }

    /// Length of a frame [s].
    #[getter]
    fn dt(&self, py: Python<'_>) -> f64 {
        self.hold(py).simulation.dt()
    }

    /// A copy of the scene that it was built from.
    #[getter]
    fn scene(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.scene.call_method0(py, "copy")
    }

    /// "f32" or "f64".
    #[getter]
    fn precision(&self, py: Python<'_>) -> String {
        self.hold(py).simulation.precision().to_string()
    }

    /// "cpu" or "gpu".
    #[getter]
    fn backend(&self, py: Python<'_>) -> &'static str {
        self.hold(py).simulation.backend()
    }

    /// Why it runs there.
    #[getter]
    fn backend_reason(&self) -> &str {
        &self.why
    }

    /// The device in words: "cpu, 2 threads, avx512".
    #[getter]
    fn device(&self, py: Python<'_>) -> String {
        self.hold(py).simulation.device()
    }

    /// Threads of the CPU.
    #[getter]
    fn threads(&self, py: Python<'_>) -> usize {
        self.hold(py).simulation.threads()
    }

    /// Memory that state, springs and lists of contacts take [byte].
    #[getter]
    fn memory(&self, py: Python<'_>) -> usize {
        self.hold(py).simulation.memory()
    }

    /// What should be known before it runs, such as a step that is too long. Each was a `SceneWarning` when this was built.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> Vec<String> {
        self.hold(py).warnings()
    }

    /// Names of bodies that diverged and stand still.
    #[getter]
    fn frozen(&self, py: Python<'_>) -> Vec<String> {
        self.hold(py).simulation.frozen().iter().map(|one| one.why.body.clone()).collect()
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let names: Vec<&str> = self.names.bodies.iter().map(|(name, _)| name.as_str()).collect();
        let (frame, device) = (self.frame(py), self.device(py));
        format!("<taffeta.Simulation of {}: frame {frame}, {device}>", names.join(", "))
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        slf.py().import("taffeta._html")?.getattr("of_simulation")?.call1((slf,))?.extract()
    }

    /// The scene, how it runs, and a snapshot: what `taffeta._scene.restored` makes this of again.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restored = py.import("taffeta._scene")?.getattr("restored")?;
        let options = PyDict::new(py);
        options.set_item("backend", self.backend(py))?;
        options.set_item("threads", self.choices.threads)?;
        options.set_item("precision", self.precision(py))?;
        let freezes = self.choices.on_divergence == OnDivergence::Freeze;
        options.set_item("on_divergence", if freezes { "freeze" } else { "stop" })?;
        let arguments = (self.scene.clone_ref(py), options, self.snapshot(py)?);
        (restored, arguments).into_pyobject(py)
    }
}
