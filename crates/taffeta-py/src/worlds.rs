//! The Python class `Worlds`: many simulations that are stepped at once, each on one thread.

use crate::arrays::{self, Rows};
use crate::control;
use crate::errors::{Failure, guarded};
use crate::options::Choices;
use crate::read::{self, Quantity};
use crate::running::{Running, hold};
use crate::scene::{Parts, Written};
use crate::simulation::Simulation;
use numpy::{Element, IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use taffeta::rayon::prelude::*;
use taffeta::rayon::{ThreadPool, ThreadPoolBuilder};
use taffeta::{Precision, Snapshot};

/// Most worlds.
const MOST: i64 = 1 << 20;
/// Time between two looks at signals.
const LOOK: Duration = Duration::from_millis(20);

/// Many independent copies of a scene, stepped at once.
///
/// Each world is a `Simulation` of its own on one thread, `worlds[i]`, with its own pins, forces, colliders and parameters. It has the
/// same bits as alone, whatever the others are and on any number of threads.
///
/// Args:
///     scene: A `Scene`, or what one is made of.
///     n: Number of worlds.
///     vary: What differs: paths as `Scene.set` takes them, each with n values.
///     threads: How many worlds are stepped at a time; as many as the machine runs, if it is not given.
///     precision: "f32" or "f64".
///
/// >>> import numpy, taffeta
/// >>> scene = taffeta.Scene().solver("ice", form="primal").sphere("ball", radius=0.2, center=(0.0, -0.3, 0.0))
/// >>> scene = scene.grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton")
/// >>> worlds = taffeta.Worlds(scene, 3, vary={"body.cloth.material.preset": ["silk", "cotton", "denim"]})
/// >>> worlds.step(5).tolist()           # none has diverged
/// [False, False, False]
/// >>> worlds.positions("cloth").shape
/// (3, 64, 3)
/// >>> worlds[2].move_collider("ball", (0.0, 0.01, 0.0))
/// >>> worlds.reset([True, False, True])
/// >>> worlds.frames.tolist()
/// [0, 5, 0]
#[pyclass(frozen, module = "taffeta", weakref)]
pub struct Worlds {
    worlds: Vec<Py<Simulation>>,
    /// Where each started.
    starts: Vec<Snapshot>,
    pool: ThreadPool,
    precision: Precision,
    /// Vertices of all bodies of one.
    vertices: usize,
}

/// A world while Python is elsewhere.
type World<'a> = &'a Mutex<Running>;

impl Worlds {
    fn all(&self) -> Vec<World<'_>> {
        self.worlds.iter().map(|world| world.get().shared()).collect()
    }

    /// Does `work` on the chosen worlds at once, without Python. All of it is done also where some fails; then the first failure
    /// counts.
    fn each<R: Send>(
        &self,
        py: Python<'_>,
        chosen: &[bool],
        work: impl Fn(usize, &mut Running) -> Result<R, Failure> + Sync,
    ) -> Result<Vec<Option<R>>, Failure> {
        let all = self.all();
        let one = |index: usize| chosen[index].then(|| hold(all[index]).work(|running| work(index, running)));
        let done: Vec<Option<Result<R, Failure>>> = py.detach(|| {
            self.pool.install(|| (0..all.len()).into_par_iter().with_max_len(1).map(one).collect())
        });
        done.into_iter().map(Option::transpose).collect()
    }

    fn mask(&self, mask: Option<&Bound<'_, PyAny>>) -> Result<Vec<bool>, Failure> {
        let Some(mask) = mask else { return Ok(vec![true; self.worlds.len()]) };
        let n = self.worlds.len();
        let unfit = || Failure::input(format!("mask is no array or list of {n} booleans"));
        let list = if mask.hasattr("tolist")? { mask.call_method0("tolist")? } else { mask.clone() };
        let booleans: Vec<Bound<'_, PyBool>> = list.extract().map_err(|_| unfit())?;
        if booleans.len() == n {
            Ok(booleans.iter().map(|boolean| boolean.is_true()).collect())
        } else {
            Err(unfit())
        }
    }

    /// One frame of the chosen worlds; those that have diverged stay.
    fn frame(&self, py: Python<'_>, chosen: &[bool], diverged: &mut [bool]) -> Result<(), Failure> {
        let ended = self.each(py, chosen, |_, running| match running.frame() {
            Err(Failure::Diverged(_)) => Ok(true),
            done => done.map(|()| false),
        })?;
        for (diverged, ended) in diverged.iter_mut().zip(ended) {
            *diverged = ended.unwrap_or(*diverged);
        }
        Ok(())
    }

    fn read(
        &self,
        py: Python<'_>,
        quantity: Quantity,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let count = match body {
            None => self.vertices,
            Some(name) => self.worlds[0]
                .get()
                .work(py, |running| Ok(read::vertices(&running.simulation, Some(name))?.len()))?,
        };
        let shape = [self.worlds.len(), count, 3];
        match self.precision {
            Precision::F32 => self.fill::<f32>(py, (quantity, body), shape, out),
            Precision::F64 => self.fill::<f64>(py, (quantity, body), shape, out),
        }
    }

    /// Has every world write its part of an array.
    fn fill<T: Number>(
        &self,
        py: Python<'_>,
        (quantity, body): (Quantity, Option<&str>),
        shape: [usize; 3],
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let out = match out {
            Some(out) => out.clone(),
            None => vec![T::default(); shape.iter().product()].into_pyarray(py).reshape(shape)?.into_any(),
        };
        let all = self.all();
        let part = shape[1] * 3;
        arrays::with(&out, &shape, |numbers: &mut [T]| {
            py.detach(|| {
                let parts = numbers.par_chunks_mut(part.max(1)).zip(&all).with_max_len(1);
                self.pool.install(|| {
                    parts.try_for_each(|(part, world)| {
                        hold(world).work(|running| {
                            let chosen = read::rows(running, quantity, body)?;
                            T::copy(&running.rows, chosen, part);
                            Ok(())
                        })
                    })
                })
            })
        })??;
        Ok(out.unbind())
    }
}

/// The numbers of an arithmetic.
trait Number: Element + Copy + Default + Send + Sync {
    /// Copies the chosen rows.
    fn copy(rows: &Rows, chosen: std::ops::Range<usize>, to: &mut [Self]);
}

impl Number for f32 {
    fn copy(rows: &Rows, chosen: std::ops::Range<usize>, to: &mut [Self]) {
        if let Rows::F32(all) = rows {
            to.copy_from_slice(all[chosen].as_flattened());
        }
    }
}

impl Number for f64 {
    fn copy(rows: &Rows, chosen: std::ops::Range<usize>, to: &mut [Self]) {
        if let Rows::F64(all) = rows {
            to.copy_from_slice(all[chosen].as_flattened());
        }
    }
}

#[pymethods]
impl Worlds {
    #[new]
    #[pyo3(signature = (scene, n, *, vary=None, threads=None, precision="f32"))]
    fn new(
        scene: &Bound<'_, PyAny>,
        n: i64,
        vary: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
        precision: &str,
    ) -> PyResult<Self> {
        let py = scene.py();
        if !(1..=MOST).contains(&n) {
            return Err(Failure::input(format!("n is {n}; 1 to {MOST} would do")).into());
        }
        let choices = Choices::of("cpu", Some(1), precision, "stop")?;
        let threads =
            threads.map(|threads| control::at_least_one("threads", threads)).transpose()?.unwrap_or(0);
        let pool = ThreadPoolBuilder::new().num_threads(threads.min(1024)).build();
        let pool = pool.map_err(|error| Failure::Device(format!("threads={threads}: {error}")))?;
        let scenes = py.import("taffeta._scene")?.getattr("varied")?.call1((scene, n, vary))?;
        let scenes: Vec<Bound<'_, PyAny>> = scenes.extract()?;
        let written = scenes.iter().map(|scene| scene.extract::<Parts<'_>>()?.write());
        let written: Vec<Written> = written.collect::<Result<_, Failure>>()?;
        let build = |written| guarded(|| Running::build(written, &choices));
        let built: Result<Vec<(Running, String)>, Failure> =
            py.detach(|| pool.install(|| written.into_par_iter().with_max_len(1).map(build).collect()));
        let built = built?;
        let starts = built.iter().map(|(running, _)| running.simulation.snapshot()).collect();
        let vertices = read::vertices(&built[0].0.simulation, None).map_err(Failure::from)?.len();
        let precision = choices.precision;
        let mut said = Vec::new();
        for (running, _) in &built {
            said.extend(
                running.warnings().into_iter().filter(|warning| !said.contains(warning)).collect::<Vec<_>>(),
            );
        }
        crate::simulation::warn(py, &said)?;
        let worlds = built.into_iter().zip(scenes).map(|((running, why), scene)| {
            Py::new(py, Simulation::of(running, scene.unbind(), choices.clone(), why))
        });
        Ok(Self { worlds: worlds.collect::<PyResult<_>>()?, starts, pool, precision, vertices })
    }

    /// Runs frames of the chosen worlds, all at once.
    ///
    /// A world that diverges keeps its last good frame and is not stepped any more until `reset`; the others go on. Ctrl-C stops all
    /// after the same whole frame.
    ///
    /// Args:
    ///     frames: How many.
    ///     mask: Which worlds, a boolean for each; all, if it is not given.
    ///
    /// Returns:
    ///     Which of the chosen worlds have diverged, bool [n].
    #[pyo3(signature = (frames=1, *, mask=None))]
    fn step(&self, py: Python<'_>, frames: i64, mask: Option<&Bound<'_, PyAny>>) -> PyResult<Py<PyAny>> {
        let frames = control::frames(frames)?;
        let chosen = self.mask(mask)?;
        let mut diverged = vec![false; self.worlds.len()];
        let mut looked = Instant::now();
        for _ in 0..frames {
            let runs: Vec<bool> =
                chosen.iter().zip(&diverged).map(|(chosen, diverged)| *chosen && !diverged).collect();
            self.frame(py, &runs, &mut diverged)?;
            if looked.elapsed() >= LOOK {
                py.check_signals()?;
                looked = Instant::now();
            }
        }
        Ok(diverged.into_pyarray(py).into_any().unbind())
    }

    /// Has the chosen worlds start again: with the pins, poses and world that their scene describes.
    ///
    /// Args:
    ///     mask: Which worlds, a boolean for each; all, if it is not given.
    #[pyo3(signature = (mask=None))]
    fn reset(&self, py: Python<'_>, mask: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let chosen = self.mask(mask)?;
        self.each(py, &chosen, |index, running| running.take_up(&self.starts[index]))?;
        Ok(())
    }

    /// Positions of all vertices [m], [n, vertices, 3], as `Simulation.positions` has them.
    ///
    /// Args:
    ///     body: Name of the body whose vertices are meant; all where it is not given.
    ///     out: An array to write to, of that shape and of the precision of the run. Every world writes its own part.
    #[pyo3(signature = (body=None, *, out=None))]
    fn positions(
        &self,
        py: Python<'_>,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.read(py, Quantity::Positions, body, out)
    }

    /// Velocities of all vertices [m/s], as `positions`.
    #[pyo3(signature = (body=None, *, out=None))]
    fn velocities(
        &self,
        py: Python<'_>,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.read(py, Quantity::Velocities, body, out)
    }

    /// Unit normals of all vertices, as `positions`.
    #[pyo3(signature = (body=None, *, out=None))]
    fn normals(
        &self,
        py: Python<'_>,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.read(py, Quantity::Normals, body, out)
    }

    /// Applies forces to vertices of all worlds during the next frame.
    ///
    /// Args:
    ///     body: Name of the body.
    ///     vertices: One vertex, or a list or array of them; the same in all worlds.
    ///     force: Force on each vertex [N]: [3], [n, 3], or [n, vertices, 3].
    fn apply_force(
        &self,
        py: Python<'_>,
        body: &str,
        vertices: &Bound<'_, PyAny>,
        force: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let vertices = arrays::vertices(vertices)?;
        let forces = arrays::vectors_of_worlds(force, [self.worlds.len(), vertices.len()], "force")?;
        let every = vec![true; self.worlds.len()];
        self.each(py, &every, |index, running| {
            let forces = &forces[index * vertices.len()..][..vertices.len()];
            control::apply_forces(&mut running.simulation, body, &vertices, forces)
        })?;
        Ok(())
    }

    /// Pins vertices of all worlds, and moves them to places during the next frame.
    ///
    /// Args:
    ///     body: Name of the body.
    ///     vertices: One vertex, or a list or array of them; the same in all worlds.
    ///     to: Places [m]: [3], [n, 3], or [n, vertices, 3]; where they are, if it is not given.
    #[pyo3(signature = (body, vertices, to=None))]
    fn pin(
        &self,
        py: Python<'_>,
        body: &str,
        vertices: &Bound<'_, PyAny>,
        to: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let vertices = arrays::vertices(vertices)?;
        let shape = [self.worlds.len(), vertices.len()];
        let to = to.map(|to| arrays::vectors_of_worlds(to, shape, "to")).transpose()?;
        let every = vec![true; self.worlds.len()];
        self.each(py, &every, |index, running| {
            let to = to.as_ref().map(|to| to[index * vertices.len()..][..vertices.len()].to_vec());
            control::pin(running, body, &vertices, to)
        })?;
        Ok(())
    }

    /// Brings a collider of all worlds to poses during the next frame.
    ///
    /// Args:
    ///     collider: Name of the collider.
    ///     shifts: Shifts from the start [m], [3] or [n, 3]. `worlds[i].move_collider` also turns one.
    fn move_collider(&self, py: Python<'_>, collider: &str, shifts: &Bound<'_, PyAny>) -> PyResult<()> {
        let shifts = arrays::vectors(shifts, self.worlds.len(), "shifts")?;
        let every = vec![true; self.worlds.len()];
        self.each(py, &every, |index, running| {
            let collider = running.simulation.collider(collider)?;
            Ok(running.simulation.move_collider(collider, taffeta_io::program::pose::shift(shifts[index]))?)
        })?;
        Ok(())
    }

    /// The last frames in numbers, a dict of arrays [n]: `frame`, `time` [s], `kinetic`, `gravitational`, `springs` and `energy` [J],
    /// `max_stretch` and `contacts`. `worlds[i].report` has all of one.
    fn reports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let every = vec![true; self.worlds.len()];
        let rows = self.each(py, &every, |_, running| {
            let report = running.simulation.report();
            let energies =
                [report.kinetic, report.gravitational, report.springs, report.energy(), report.max_stretch];
            Ok((i64::from(report.frame), report.time, energies, report.contacts as i64))
        })?;
        let rows: Vec<_> = rows.into_iter().flatten().collect();
        let dict = PyDict::new(py);
        dict.set_item("frame", rows.iter().map(|row| row.0).collect::<Vec<_>>().into_pyarray(py))?;
        dict.set_item("time", rows.iter().map(|row| row.1).collect::<Vec<_>>().into_pyarray(py))?;
        for (index, name) in
            ["kinetic", "gravitational", "springs", "energy", "max_stretch"].into_iter().enumerate()
        {
            dict.set_item(name, rows.iter().map(|row| row.2[index]).collect::<Vec<_>>().into_pyarray(py))?;
        }
        dict.set_item("contacts", rows.iter().map(|row| row.3).collect::<Vec<_>>().into_pyarray(py))?;
        Ok(dict)
    }

    /// Number of frames done by each world, int64 [n].
    #[getter]
    fn frames(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let every = vec![true; self.worlds.len()];
        let frames = self.each(py, &every, |_, running| Ok(i64::from(running.simulation.frame())))?;
        Ok(frames.into_iter().flatten().collect::<Vec<_>>().into_pyarray(py).into_any().unbind())
    }

    /// How many worlds are stepped at a time.
    #[getter]
    fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Memory of all worlds [byte].
    #[getter]
    fn memory(&self, py: Python<'_>) -> PyResult<usize> {
        let every = vec![true; self.worlds.len()];
        let all = self.each(py, &every, |_, running| Ok(running.simulation.memory()))?;
        Ok(all.into_iter().flatten().sum())
    }

    fn __len__(&self) -> usize {
        self.worlds.len()
    }

    /// One world: a `Simulation`, with all that one can do.
    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<Py<Simulation>> {
        let n = self.worlds.len() as isize;
        let from_start = if index < 0 { index + n } else { index };
        let found = usize::try_from(from_start).ok().and_then(|index| self.worlds.get(index));
        // Loops end where this is raised.
        let error = || {
            pyo3::exceptions::PyIndexError::new_err(format!(
                "there are {n} worlds and none with index {index}"
            ))
        };
        Ok(found.ok_or_else(error)?.clone_ref(py))
    }

    fn __repr__(&self) -> String {
        let threads = self.threads();
        format!("<taffeta.Worlds: {} worlds, {threads} at a time>", self.worlds.len())
    }
}
