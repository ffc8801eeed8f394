//! The bench on fabric: a cotton flag, explicit or solved for by nodes.

use super::form::Form;
use super::measure::Bench;
use std::sync::Arc;
use taffeta::scene::{
    Body, ConstraintForm, Material, Mesh, Method, Place, Rotation, Scene, Select, WarpWeft,
};
use taffeta::topology::Surface;

/// Side of the flag [m].
const SIDE: f64 = 1.0;
/// Explicit sub-steps of a frame, and a step by the distance of neighbours, which cotton stands [s/m].
const EXPLICIT: (u32, f64) = (34, 2e-3);
/// A frame that is one implicit step [s], and frames in which the flag comes down.
const IMPLICIT: (f64, u32) = (1.0 / 60.0, 60);
/// How far nodes of an irregular mesh are from those of a grid, in distances of neighbours along each side.
const IRREGULAR: f64 = 0.2;

/// What is asked for of the fabric.
#[derive(Clone, Copy)]
pub struct Cloth {
    pub sides: [u32; 2],
    /// How many times stiffer the warp is than the weft, if not as cotton is.
    pub ratio: Option<f64>,
    pub is_irregular: bool,
    /// Implicit steps, solved for by nodes.
    pub form: Option<Form>,
}

impl Cloth {
    /// A flag that hangs by two corners of its upper edge, lifted by an eighth of a turn at the start.
    pub fn bench(&self) -> Bench {
        let [rows, cols] = self.sides;
        let mesh = if self.is_irregular {
            Mesh::Surface(Arc::new(irregular(self.sides)))
        } else {
            Mesh::grid(rows, cols, [SIDE; 2])
        };
        let mut body = Body::cloth("flag", mesh).with_material(self.material());
        body = body.pin(Select::nodes([0, cols - 1]));
        body.place =
            Place { rotation: Some(Rotation { axis: [1.0, 0.0, 0.0], degrees: 45.0 }), ..Place::default() };
        let scene = Scene::new("bench fabric").body(body);
        let bench = |scene| Bench { form: self.form, ..Bench::new("fabric", self.sides.to_vec(), scene) };
        let Some(Form::Ice(form)) = self.form else {
            let step = EXPLICIT.1 * SIDE / f64::from(rows.max(cols) - 1);
            return bench(scene.time(f64::from(EXPLICIT.0) * step, step));
        };
        let mut scene = scene.time(IMPLICIT.0, IMPLICIT.0).method(Method::Ice);
        scene.solver.ice.form = form;
        Bench { most: IMPLICIT.1, ..bench(scene) }
    }

    fn material(&self) -> Material {
        let cotton = Material::preset("cotton");
        let Some(ratio) = self.ratio else { return cotton };
        let fabric = cotton.fabric();
        let weft = |warp: f64| Some(WarpWeft { warp, weft: warp / ratio });
        Material { stretch: weft(fabric.stretch.warp), bending: weft(fabric.bending.warp), ..cotton }
    }
}

/// Whether fabric can be measured in a form.
pub fn fits(form: Form) -> bool {
    form == Form::Ice(ConstraintForm::Primal)
}

/// A flat mesh whose nodes are off those of a grid, and whose diagonals run either way.
fn irregular([rows, cols]: [u32; 2]) -> Surface {
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    };
    let along = |index: u32, count: u32, by: f64| {
        let inside = index > 0 && index + 1 < count;
        let moved = f64::from(index) + if inside { IRREGULAR * (2.0 * by - 1.0) } else { 0.0 };
        SIDE * (moved / f64::from(count - 1) - 0.5)
    };
    let cells = || (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col)));
    let mut node = |(row, col)| [along(col, cols, random()), 0.0, along(row, rows, random())];
    let nodes: Vec<[f64; 3]> = cells().map(&mut node).collect();
    let cell = |(row, col): (u32, u32)| {
        let a = row * cols + col;
        let [b, c, d] = [a + 1, a + cols, a + cols + 1];
        if random() < 0.5 { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] }
    };
    let whole = cells().filter(|&(row, col)| row + 1 < rows && col + 1 < cols);
    Surface::of_triangles(nodes, whole.flat_map(cell).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_irregular_mesh_covers_the_flag() {
        let surface = irregular([5, 7]);
        let corner = |node: u32| surface.nodes[node as usize];
        let twice = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(corner);
            (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2])
        };
        let areas: Vec<f64> = surface.triangles.iter().map(twice).collect();
        assert!(areas.iter().all(|&area| area > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 2.0 * SIDE * SIDE).abs() < 1e-12);
    }
}
