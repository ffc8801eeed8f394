//! What a simulation, the package and the machine are.

use crate::document::to_python;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice};
use taffeta::scene::PRESETS;
use taffeta::taffeta_gpu::adapters;
use taffeta_io::program::processor;

/// A body of a running scene, as it was when the scene was built.
#[pyclass(frozen, get_all, module = "taffeta")]
pub struct Body {
    pub name: String,
    /// Where its first vertex is among those of all bodies.
    pub first: usize,
    pub vertices: usize,
    pub nodes: usize,
    pub triangles: usize,
    pub springs: usize,
    pub pins: usize,
    pub pinned: usize,
    pub mass: f64,
    pub rest_volume: Option<f64>,
    pub repairs: Vec<String>,
}

#[pymethods]
impl Body {
    /// Its rows among those of all bodies.
    #[getter]
    fn rows<'py>(&self, py: Python<'py>) -> Bound<'py, PySlice> {
        let [first, end] = [self.first, self.first + self.vertices].map(|row| row as isize);
        PySlice::new(py, first, end, 1)
    }

    fn __repr__(&self) -> String {
        let Self { name, vertices, pins, mass, .. } = self;
        format!("<taffeta.Body {name}: {vertices} vertices, {pins} pins, {mass:.6} kg>")
    }
}

impl Body {
    /// The bodies of a simulation, in the scene's order.
    pub fn all(simulation: &taffeta::Simulation) -> Vec<(String, Self)> {
        let mut first = 0;
        let of = |body: &taffeta::BodyInfo| {
            let one = Self {
                name: body.name.clone(),
                first,
                vertices: body.vertices,
                nodes: body.nodes,
                triangles: body.triangles,
                springs: body.springs.iter().map(|(_, count)| count).sum(),
                pins: body.pins,
                pinned: body.pinned,
                mass: body.mass,
                rest_volume: body.rest_volume,
                repairs: body.repairs.clone(),
            };
            first += body.vertices;
            (body.name.clone(), one)
        };
        simulation.bodies().iter().map(of).collect()
    }
}

/// A collider of a running scene.
#[pyclass(frozen, get_all, module = "taffeta")]
pub struct Collider {
    pub name: String,
    pub shape: &'static str,
    pub keyframes: usize,
    pub repairs: Vec<String>,
}

#[pymethods]
impl Collider {
    fn __repr__(&self) -> String {
        format!("<taffeta.Collider {}: {}>", self.name, self.shape)
    }
}

impl Collider {
    /// The colliders of a simulation, in the scene's order.
    pub fn all(simulation: &taffeta::Simulation) -> Vec<(String, Self)> {
        let of = |collider: &taffeta::ColliderInfo| {
            let (name, repairs) = (collider.name.clone(), collider.repairs.clone());
            (name.clone(), Self { name, shape: collider.shape, keyframes: collider.keyframes, repairs })
        };
        simulation.colliders().iter().map(of).collect()
    }
}

/// What this build and this machine are.
#[pyfunction]
pub fn info(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("version", env!("CARGO_PKG_VERSION"))?;
    dict.set_item("cpu", processor())?;
    dict.set_item("simd", taffeta::simd_level())?;
    dict.set_item("threads", std::thread::available_parallelism().map_or(1, usize::from))?;
    let gpus = py.detach(|| adapters().iter().map(ToString::to_string).collect::<Vec<_>>());
    dict.set_item("gpus", gpus)?;
    Ok(dict)
}

/// Fabrics by name, those that `material` may be: for each a dict of its numbers, `title` and `source`.
///
/// The keys are those of `[body.material]`: `density` [kg/m²], `stretch` and `shear` [N/m], `bending` [N·m], and others.
///
/// >>> import taffeta
/// >>> fabrics = taffeta.materials()
/// >>> fabrics["denim"]["density"] > fabrics["silk"]["density"]
/// True
#[pyfunction]
pub fn materials(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for preset in PRESETS {
        let numbers = toml::Value::try_from(preset.fabric);
        let numbers = numbers.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let fabric = to_python(py, &numbers)?;
        fabric.set_item("title", preset.title)?;
        fabric.set_item("source", preset.source)?;
        all.set_item(preset.name, fabric)?;
    }
    Ok(all)
}
