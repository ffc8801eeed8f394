//! Surfaces of boxes and bars, where the scene has them before their `place`.

use super::vector::{Vector, across, along, difference, dot, mix, unit};
use taffeta::scene::{Bar, Cube, Cuboid, Cylinder, Mesh, UvSphere};
use taffeta::topology::{Surface, shapes};

/// Sides of a bar.
const SEGMENTS: u32 = 64;
/// Bands of its round ends: an odd number, so that no ring of nodes is between the two and they can be drawn apart.
const RINGS: u32 = 31;

/// A box.
///
/// # Errors
/// Where it has no size.
pub fn cuboid(Cuboid { center, half }: Cuboid) -> Result<Surface, String> {
    let cube = shapes::surface(&Mesh::Cube(Cube { size: 2.0, divisions: 1 }))?;
    Ok(moved(cube, |x| std::array::from_fn(|axis| center[axis] + half[axis] * x[axis])))
}

/// A bar with flat ends.
///
/// # Errors
/// Where it has no size.
pub fn cylinder(bar: Bar) -> Result<Surface, String> {
    let way = difference(bar.b, bar.a);
    let height = dot(way, way).sqrt();
    let mesh = Cylinder { radius: bar.radius, height, segments: SEGMENTS, rings: 1, capped: true };
    let upright = shapes::surface(&Mesh::Cylinder(mesh))?;
    Ok(moved(upright, |x| laid(bar, x)))
}

/// A ball, its halves drawn apart.
pub fn capsule(bar: Bar) -> Result<Surface, String> {
    let way = difference(bar.b, bar.a);
    let half = 0.5 * dot(way, way).sqrt();
    let mesh = UvSphere { radius: bar.radius, rings: RINGS, segments: SEGMENTS };
    let ball = shapes::surface(&Mesh::UvSphere(mesh))?;
    Ok(moved(ball, |[x, y, z]| laid(bar, [x, y + half.copysign(y), z])))
}

/// From a frame in which a bar is upright in the origin to where it is.
fn laid(bar: Bar, [x, y, z]: Vector) -> Vector {
    let axis = unit(difference(bar.b, bar.a));
    let [right, front] = across(axis);
    along(along(along(mix(bar.a, bar.b, 0.5), x, front), y, axis), z, right)
}

/// A surface whose vertices are its nodes, elsewhere.
fn moved(surface: Surface, place: impl Fn(Vector) -> Vector) -> Surface {
    let nodes: Vec<Vector> = surface.nodes.iter().map(|x| place(*x)).collect();
    Surface { vertices: nodes.clone(), nodes, ..surface }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use taffeta::topology::measure::volume;

    #[test]
    fn solids_have_their_volumes_and_look_outwards() {
        let bar = Bar { a: [0.3, -0.2, 1.0], b: [1.5, 0.4, 0.6], radius: 0.25 };
        let length = (1.44_f64 + 0.36 + 0.16).sqrt();
        let round = PI * 0.0625 * length;
        for (surface, wanted) in [
            (cuboid(Cuboid { center: [1.0, 2.0, 3.0], half: [0.5, 0.25, 0.125] }), 0.125),
            (cylinder(bar), round),
            (capsule(bar), round + 4.0 / 3.0 * PI * 0.25_f64.powi(3)),
        ] {
            let Surface { nodes, triangles, .. } = surface.expect("sizes that are right");
            let found = volume(&nodes, &triangles);
            assert!((found / wanted - 1.0).abs() < 0.01, "{found} m³, {wanted} expected");
        }
    }

    #[test]
    fn bars_are_within_their_radius_of_their_axis_and_reach_their_ends() {
        let bar = Bar { a: [0.0, 1.0, 0.0], b: [2.0, 1.0, 0.0], radius: 0.5 };
        for (surface, end) in [(cylinder(bar), 2.0), (capsule(bar), 2.5)] {
            let nodes = surface.expect("sizes that are right").nodes;
            let far = nodes.iter().map(|x| x[0]).fold(f64::MIN, f64::max);
            assert!((far - end).abs() < 1e-12, "{far} m, {end} expected");
            let off = |x: &Vector| (x[1] - 1.0).hypot(x[2]);
            assert!(nodes.iter().all(|x| off(x) < 0.5 + 1e-12));
        }
    }
}
