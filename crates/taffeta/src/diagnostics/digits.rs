//! The precision of 32 bits at a body's position.

use crate::assembly::body::{BodyAssembly, BodySprings};

/// Fraction of the shortest spring up to which positions may be rounded: more acts as a strain.
const FELT: f64 = 0.01;

/// A warning if places of a body are too coarse in 32 bits for its springs.
pub fn too_coarse(body: &BodyAssembly) -> Option<String> {
    let farthest = body.start.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let spacing = f64::from(f32::EPSILON) * farthest.log2().floor().exp2();
    let shortest = shortest_spring(&body.springs)?;
    (spacing > FELT * shortest).then(|| {
        format!(
            "body `{}` is {farthest:.1e} m from the origin, where 32 bits tell places {spacing:.1e} m apart, and its shortest \
             spring is {shortest:.1e} m: forces are rounded; a place nearer to the origin, or 64 bits (precision f64, on the CPU), \
             would do",
            body.name
        )
    })
}

/// Rest length [m] of the shortest spring with one.
fn shortest_spring(springs: &BodySprings) -> Option<f64> {
    let shortest =
        |lengths: &mut dyn Iterator<Item = f64>| lengths.filter(|&rest| rest > 0.0).reduce(f64::min);
    match springs {
        BodySprings::Grid(directions) => shortest(&mut directions.iter().flatten().map(|[_, _, rest]| *rest)),
        BodySprings::Mesh(lists) => shortest(&mut lists.iter().flat_map(|list| list.rest.iter().copied())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::scene::{Body, Icosphere, Mass, Mesh, Scene};

    #[test]
    fn springs_far_from_the_origin_are_warned_of_once_places_are_a_hundredth_of_them_apart() {
        let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 1 });
        // Springs of 0.1 m, and of 0.27 m in the ball; places are 1/512 m apart from 16,384 m on, twice that from 32,768 m on.
        for (mesh, near, far) in [(Mesh::grid(3, 3, [0.2, 0.2]), 1.6e4, 1.7e4), (ball, 3.2e4, 3.3e4)] {
            let warning = |x: f64| {
                let body = Body::cloth("far", mesh.clone()).with_mass(Mass::Node(0.1)).structural(1.0, 0.0);
                let scene = Scene::new("").body(body.at([0.0, 0.0, -x]));
                too_coarse(&Assembly::new(&scene).unwrap().bodies[0])
            };
            assert_eq!(warning(near), None);
            assert_eq!(warning(0.0), None);
            assert!(warning(far).expect("a warning").starts_with("body `far` is "));
        }
    }
}
