//! What a program reads of a simulation.

use super::Simulation;
use crate::arrays;
use crate::document;
use crate::errors::Failure;
use crate::info::{Body, Collider};
use crate::read::{self, Quantity};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taffeta_io::program::pose;

impl Simulation {
    fn read(
        &self,
        py: Python<'_>,
        quantity: Quantity,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let (rows, chosen) = self.work(py, |running| {
            let chosen = read::rows(running, quantity, body)?;
            Ok((running.rows.take(), chosen))
        })?;
        let array = match out {
            None => rows.to_array(py, chosen)?,
            Some(out) => rows.write(out, chosen).map(|()| out.clone().unbind())?,
        };
        // To be filled again next time.
        self.hold(py).rows = rows;
        Ok(array)
    }
}

#[pymethods]
impl Simulation {
    /// Positions of all vertices [m], [vertices, 3], bodies one after the other in the scene's order, vertices in the order of the mesh.
    ///
    /// Args:
    ///     body: Name of the body whose vertices are meant; all where it is not given.
    ///     out: An array to write to, of that shape and of the precision of the run. It is returned, and nothing is allocated.
    ///
    /// >>> import numpy, taffeta
    /// >>> simulation = taffeta.Simulation(taffeta.Scene().grid("cloth", rows=2, cols=3, size=(2.0, 1.0), material="silk"))
    /// >>> positions = simulation.positions("cloth")
    /// >>> positions[0].tolist(), positions.dtype
    /// ([-1.0, 0.0, -0.5], dtype('float32'))
    /// >>> positions is simulation.positions(out=positions)
    /// True
    /// >>> numpy.from_dlpack(positions).shape
    /// (6, 3)
    #[pyo3(signature = (body=None, *, out=None))]
    fn positions(
        &self,
        py: Python<'_>,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.read(py, Quantity::Positions, body, out)
    }

    /// Velocities of all vertices [m/s], as `positions`. A vertex that is in no face has none.
    #[pyo3(signature = (body=None, *, out=None))]
    fn velocities(
        &self,
        py: Python<'_>,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.read(py, Quantity::Velocities, body, out)
    }

    /// Unit normals of all vertices, area-weighted, as `positions`.
    #[pyo3(signature = (body=None, *, out=None))]
    fn normals(
        &self,
        py: Python<'_>,
        body: Option<&str>,
        out: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.read(py, Quantity::Normals, body, out)
    }

    /// Triangles by their vertices, uint32 [triangles, 3]: those of a body, counted from its first vertex, or those of all.
    ///
    /// Faces with more corners are cut as they are simulated.
    #[pyo3(signature = (body=None))]
    fn faces(&self, py: Python<'_>, body: Option<&str>) -> PyResult<Py<PyAny>> {
        let faces = self.work(py, |running| read::faces(&running.simulation, body))?;
        arrays::array(py, faces)
    }

    /// Distances of all vertices from colliders [m], less the colliders' offsets, float32 [vertices]: 0 in contact, below 0 inside, and
    /// `reach` [m] where nothing is nearer.
    fn collider_distances<'py>(&self, py: Python<'py>, reach: f64) -> PyResult<Bound<'py, PyAny>> {
        let distances = self.work(py, |running| {
            let mut distances = Vec::new();
            running.simulation.fetch()?;
            running.simulation.collider_distances(reach, &mut distances);
            Ok(distances)
        })?;
        Ok(distances.into_pyarray(py).into_any())
    }

    /// Counts where bodies pass through themselves, each other and colliders made of triangles, by exact arithmetic.
    ///
    /// Returns:
    ///     A dict: `pairs` of an edge and a triangle, the `first` of them in words or None, and whether the count is `complete`.
    fn intersections<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.work(py, |running| {
            running.simulation.fetch()?;
            Ok(running.simulation.intersections())
        })?;
        let dict = PyDict::new(py);
        dict.set_item("pairs", found.pairs)?;
        dict.set_item("first", found.first)?;
        dict.set_item("complete", found.complete)?;
        Ok(dict)
    }

    /// The bodies by name, in the scene's order: counts, mass, and `rows`, the slice of a body's vertices among all.
    ///
    /// >>> import taffeta
    /// >>> simulation = taffeta.Simulation(taffeta.Scene().grid("cloth", rows=2, cols=3, size=(2.0, 1.0), mass=0.5))
    /// >>> simulation.bodies["cloth"]
    /// <taffeta.Body cloth: 6 vertices, 0 pins, 0.500000 kg>
    /// >>> simulation.positions()[simulation.bodies["cloth"].rows].shape
    /// (6, 3)
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let bodies = Body::all(&self.hold(py).simulation);
        for (name, body) in bodies {
            dict.set_item(name, body)?;
        }
        Ok(dict)
    }

    /// The colliders by name, in the scene's order.
    #[getter]
    fn colliders<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let colliders = Collider::all(&self.hold(py).simulation);
        for (name, collider) in colliders {
            dict.set_item(name, collider)?;
        }
        Ok(dict)
    }

    /// Force with which a pin of the scene holds its nodes in the last sub-step [N], float64 [3].
    ///
    /// None at the start, and for pins that break.
    ///
    /// Args:
    ///     body: Name of the body.
    ///     pin: Number of the pin among those of its body in the scene, from 0.
    #[pyo3(signature = (body, pin=0))]
    fn reaction(&self, py: Python<'_>, body: &str, pin: i64) -> PyResult<Option<Py<PyAny>>> {
        let force = self.work(py, |running| {
            let pin = super::controls::pin_of(&running.simulation, body, pin)?;
            Ok(running.simulation.reaction(pin)?)
        })?;
        Ok(force.map(|force| force.to_array().to_vec().into_pyarray(py).into_any().unbind()))
    }

    /// Where a collider has been brought from its start: a matrix [4, 4] that moves points [m], as `move_collider` takes it.
    ///
    /// Args:
    ///     collider: Name of the collider.
    ///     fraction: The part of the last frame that has gone by, 0 to 1.
    #[pyo3(signature = (collider, fraction=1.0))]
    fn collider_pose(&self, py: Python<'_>, collider: &str, fraction: f64) -> PyResult<Py<PyAny>> {
        let rows = self.work(py, |running| {
            let collider = running.simulation.collider(collider)?;
            let fraction = crate::control::fraction(fraction)?;
            Ok(pose::matrix(&running.simulation.collider_pose(collider, fraction)?))
        })?;
        arrays::array(py, rows.to_vec())
    }

    /// How a collider moved in the last frame, float64 [2, 3]: the velocity of what starts at the origin [m/s], and the angular velocity
    /// [rad/s].
    fn collider_velocity(&self, py: Python<'_>, collider: &str) -> PyResult<Py<PyAny>> {
        let rows = self.work(py, |running| {
            let simulation = &running.simulation;
            let collider = simulation.collider(collider)?;
            let [from, to] = [0.0, 1.0].map(|fraction| simulation.collider_pose(collider, fraction));
            Ok(pose::velocity(&from?, &to?, simulation.dt()))
        })?;
        arrays::array(py, rows.to_vec())
    }

    /// Gravity, drag, wind and air as they are now, as a dict with the keys of `[world]`.
    #[getter]
    fn world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let world = self.work(py, |running| {
            toml::Value::try_from(&running.world).map_err(|error| Failure::Internal(error.to_string()))
        })?;
        document::to_python(py, &world)
    }
}
