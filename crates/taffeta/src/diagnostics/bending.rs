//! How true a mesh is to the bending of a fabric.

use crate::assembly::Assembly;
use crate::elements::bending::build::factors;
use crate::scene::{Body, SceneError};

/// How stiff a body's mesh is against bending to a cylinder, by the stiffness of its fabric: the least and the largest of all
/// directions, over all of the mesh but its border. 1 and 1 on regular meshes; `None` where no triangle is inside, and for a body without
/// fabric.
///
/// Each triangle and its neighbours, laid flat, are bent to one quadratic surface.
///
/// ```
/// use taffeta::diagnostics::bending_factors;
/// use taffeta::scene::{Body, Material, Mesh};
///
/// let sheet = Body::cloth("sheet", Mesh::grid(21, 31, [0.3, 0.2])).with_material(Material::preset("cotton"));
/// let [least, largest] = bending_factors(&sheet)?.expect("it has an inside");
/// assert!((least - 1.0).abs() < 1e-6 && (largest - 1.0).abs() < 1e-6);
/// # Ok::<(), taffeta::scene::SceneError>(())
/// ```
///
/// # Errors
/// Names what is wrong with the body.
pub fn bending_factors(body: &Body) -> Result<Option<[f64; 2]>, SceneError> {
    let assembly = Assembly::with_fabric(body)?;
    Ok(assembly.bodies[0].laid().and_then(factors))
}
