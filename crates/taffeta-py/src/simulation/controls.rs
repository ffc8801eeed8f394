//! What a program does to a simulation.

use super::Simulation;
use crate::errors::Failure;
use crate::scene::table;
use crate::{arrays, control};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taffeta::PinHandle;
use taffeta_io::program::changed;

/// A pin by its body and its number.
pub fn pin_of(simulation: &taffeta::Simulation, body: &str, pin: i64) -> Result<PinHandle, Failure> {
    let body = simulation.body(body)?;
    let index =
        usize::try_from(pin).map_err(|_| Failure::input(format!("pin is {pin}; 0 or more would do")))?;
    Ok(simulation.pin(body, index)?)
}

#[pymethods]
impl Simulation {
    /// Pins vertices, and moves them to places during the next frame, in straight lines; there they stay until `unpin`.
    ///
    /// Args:
    ///     body: Name of the body.
    ///     vertices: One vertex, or a list or array of them, in the order of the mesh.
    ///     to: Places [m], [3] or one for each vertex, [n, 3]; where they are, if it is not given.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
    /// >>> simulation = taffeta.Simulation(scene)
    /// >>> simulation.pin("cloth", [0, 7])
    /// >>> simulation.pin("cloth", 7, (0.5, 0.01, -0.5))
    /// >>> report = simulation.step()
    /// >>> simulation.positions()[7].round(6).tolist()
    /// [0.5, 0.009999999776482582, -0.5]
    #[pyo3(signature = (body, vertices, to=None))]
    fn pin(
        &self,
        py: Python<'_>,
        body: &str,
        vertices: &Bound<'_, PyAny>,
        to: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let vertices = arrays::vertices(vertices)?;
        let to = to.map(|to| arrays::vectors(to, vertices.len(), "to")).transpose()?;
        self.work(py, |running| control::pin(running, body, &vertices, to))
    }

    /// Frees vertices that `pin` has pinned, with the velocity that they were moved with. What a pin of the scene holds stays pinned.
    fn unpin(&self, py: Python<'_>, body: &str, vertices: &Bound<'_, PyAny>) -> PyResult<()> {
        let vertices = arrays::vertices(vertices)?;
        self.work(py, |running| control::unpin(&mut running.simulation, body, &vertices))
    }

    /// Applies forces to vertices during the next frame. Those on one vertex add up.
    ///
    /// Args:
    ///     body: Name of the body.
    ///     vertices: One vertex, or a list or array of them, in the order of the mesh.
    ///     force: Force on each vertex [N], [3] or [n, 3].
    fn apply_force(
        &self,
        py: Python<'_>,
        body: &str,
        vertices: &Bound<'_, PyAny>,
        force: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let vertices = arrays::vertices(vertices)?;
        let forces = arrays::vectors(force, vertices.len(), "force")?;
        self.work(py, |running| control::apply_forces(&mut running.simulation, body, &vertices, &forces))
    }

    /// Brings the nodes of a pin of the scene to a pose during the next frame, evenly; there they stay.
    ///
    /// Args:
    ///     body: Name of the body.
    ///     pin: Number of the pin among those of its body in the scene, from 0. It must be movable and follow no keyframes.
    ///     pose: Motion from the start: a shift [3] [m], or a rigid matrix [4, 4], as `taffeta.pose` makes it.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
    /// >>> simulation = taffeta.Simulation(scene.pin("cloth", rows=0, movable=True))
    /// >>> simulation.move_pin("cloth", 0, taffeta.pose((0.0, 0.02, 0.0), axis=(0, 1, 0), degrees=2.0))
    /// >>> report = simulation.step()
    fn move_pin(&self, py: Python<'_>, body: &str, pin: i64, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        let pose = control::pose(pose)?;
        self.work(py, |running| {
            let pin = pin_of(&running.simulation, body, pin)?;
            Ok(running.simulation.move_pin(pin, pose)?)
        })
    }

    /// Brings a collider to a pose during the next frame, evenly, so that it has the velocity of that motion; there it stays.
    ///
    /// Args:
    ///     collider: Name of the collider. It must follow no keyframes any more.
    ///     pose: Motion from the start: a shift [3] [m], or a rigid matrix [4, 4], as `taffeta.pose` makes it.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
    /// >>> simulation = taffeta.Simulation(scene.sphere("ball", radius=0.2, center=(0.0, -0.5, 0.0)))
    /// >>> simulation.move_collider("ball", (0.0, simulation.dt * 0.6, 0.0))
    /// >>> report = simulation.step()
    /// >>> simulation.collider_velocity("ball")[0].round(9).tolist()
    /// [0.0, 0.6, 0.0]
    fn move_collider(&self, py: Python<'_>, collider: &str, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        let pose = control::pose(pose)?;
        self.work(py, |running| {
            let collider = running.simulation.collider(collider)?;
            Ok(running.simulation.move_collider(collider, pose)?)
        })
    }

    /// Changes gravity, drag, wind and air from the next frame on.
    ///
    /// Args:
    ///     **changes: Keys of `[world]`: `gravity` [m/s²], `drag` [kg/s], `wind_force` [N], `air`, a dict. What is not given stays. Air
    ///         cannot be added to a scene that was built without.
    ///
    /// >>> import taffeta
    /// >>> scene = taffeta.Scene().grid("cloth", rows=8, cols=8, size=(1.0, 1.0), material="cotton").solver("ice", form="primal")
    /// >>> simulation = taffeta.Simulation(scene)
    /// >>> simulation.set_world(gravity=(0.0, -1.62, 0.0))
    /// >>> simulation.world["gravity"]
    /// [0.0, -1.62, 0.0]
    #[pyo3(signature = (**changes))]
    fn set_world(&self, py: Python<'_>, changes: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let Some(changes) = changes else { return Ok(()) };
        let changes = table(changes)?;
        self.work(py, |running| {
            let world = changed(changes, &running.world).map_err(Failure::Input)?;
            running.simulation.set_world(&world)?;
            running.world = world;
            Ok(())
        })
    }

    /// Moves every free node by up to `amplitude` [m] along each axis, at random but the same for the same seed.
    #[pyo3(signature = (amplitude, seed=1))]
    fn disturb(&self, py: Python<'_>, amplitude: f64, seed: i64) -> PyResult<()> {
        self.work(py, |running| {
            let seed = control::seed(seed)?;
            running.simulation.disturb(control::finite("amplitude", amplitude)?, seed);
            Ok(())
        })
    }

    /// Has at most so many threads work from now on, and never more than at the start. No bit depends on it.
    fn limit_threads(&self, py: Python<'_>, most: i64) -> PyResult<()> {
        self.work(py, |running| {
            running.simulation.limit_threads(control::at_least_one("most", most)?);
            Ok(())
        })
    }
}
