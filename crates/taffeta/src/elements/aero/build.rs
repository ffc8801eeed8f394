//! The triangles that air acts on.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::elements::aero::aero::AirNow;
use crate::elements::element::Described;
use crate::plan::Substep;
use crate::real::Real;
use crate::real::{cross, norm, sub};
use crate::scene::Scene;
use crate::topology::RestShape;

/// A triangle that air acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AeroTriangle {
    /// Corners in solver order within the body.
    pub corners: [u32; 3],
    /// 1/M [1/kg], where M is the mass that moves with it.
    pub lightness: f64,
    /// Area at rest [m²].
    pub area: f64,
}

/// The air at the start of a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    if let Some(air) = &assembly.world.air {
        substep.extensions.insert(AirNow::<T>::new(air, t, h));
    }
}

impl<T: Real> Substep<T> {
    /// The air at its start, if there is any.
    pub fn air(&self) -> Option<&AirNow<T>> {
        self.extensions.get()
    }
}

/// The triangles of a body that have an area at rest, in the order in which nodes add up their forces.
///
/// M is three times the least share of a corner's mass, shares being by area: then no node has more shares than mass,
/// whatever the masses, and what slows every triangle down by no more than its flow does so to the body. With one mass a
/// square metre M is the triangle's own mass.
pub fn aero_triangles(body: &BodyAssembly) -> Vec<AeroTriangle> {
    let triangles = triangles(body);
    let mut around = vec![0.0; body.nodes];
    for (corners, area) in &triangles {
        corners.iter().for_each(|&corner| around[corner as usize] += area);
    }
    let triangle = |(corners, area): ([u32; 3], f64)| {
        let share = |&corner: &u32| body.mass[corner as usize] * area / around[corner as usize];
        let mass = 3.0 * corners.iter().map(share).fold(f64::INFINITY, f64::min);
        AeroTriangle { corners, lightness: 1.0 / mass, area }
    };
    triangles.into_iter().filter(|(_, area)| *area > 0.0).map(triangle).collect()
}

/// The triangles of a body as elements; none without air.
pub fn described(body: &BodyAssembly, scene: &Scene, _: usize) -> Described {
    let mut all = Described::default();
    if scene.world.air.is_some() {
        aero_triangles(body).iter().for_each(|triangle| all.push(&triangle.corners, &[triangle.lightness]));
    }
    all
}

/// A body's triangles in solver order within it, and their areas at rest [m²]. Neighbours follow each other, on grids so that
/// their corners do too.
fn triangles(body: &BodyAssembly) -> Vec<([u32; 3], f64)> {
    if let Some([rows, cols]) = body.grid_layout {
        let (rows, cols) = (rows as u32, cols as u32);
        let upper = move |i: u32| [i, i + cols, i + 1];
        let lower = move |i: u32| [i + 1, i + cols, i + cols + 1];
        let row = |r: u32| r * cols..(r + 1) * cols - 1;
        let corners = (0..rows.max(1) - 1).flat_map(|r| row(r).map(upper).chain(row(r).map(lower)));
        return corners.map(|corners| (corners, area(&body.start, corners))).collect();
    }
    let Some(surface) = &body.surface else { return Vec::new() };
    let solver = |node: u32| body.solver_local(node as usize) as u32;
    let corners = surface.triangles.iter().map(|corners| corners.map(solver));
    let rest = RestShape::of(surface, body.placement.factor);
    let mut triangles: Vec<([u32; 3], f64)> = if rest.is_given() {
        corners.zip(rest.areas()).collect()
    } else {
        corners.map(|corners| (corners, area(&body.start, corners))).collect()
    };
    triangles.sort_by_key(|(corners, _)| {
        let mut sorted = *corners;
        sorted.sort_unstable();
        sorted
    });
    triangles
}

/// Area of a triangle [m²].
fn area(places: &[[f64; 3]], corners: [u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| places[corner as usize]);
    0.5 * norm(cross(sub(b, a), sub(c, a)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::elements::{KINDS, aero};
    use crate::scene::{Air, Body, Icosphere, Mass, Mesh};

    fn assembly(body: Body) -> Assembly {
        let mut scene = Scene::new("").body(body);
        scene.world.air = Some(Air::default());
        Assembly::new(&scene).unwrap()
    }

    fn ball() -> Mesh {
        Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 })
    }

    #[test]
    fn aero_triangles_are_the_triangles_that_the_user_knows() {
        let exchanged = Mesh::grid(3, 2051, [1.0, 40.0]);
        for mesh in [Mesh::grid(5, 7, [1.0, 2.0]), exchanged, ball()] {
            let assembly = assembly(Body::cloth("", mesh).with_mass(Mass::Node(0.1)));
            let body = &assembly.bodies[0];
            let sorted = |mut corners: [u32; 3]| {
                corners.sort_unstable();
                corners
            };
            let of_user = |corners: &[u32; 3]| sorted(corners.map(|n| body.solver_index(n as usize) as u32));
            let mut wanted: Vec<_> = body.user_surface().triangles.iter().map(of_user).collect();
            let mut found: Vec<_> =
                aero_triangles(body).iter().map(|triangle| sorted(triangle.corners)).collect();
            wanted.sort_unstable();
            found.sort_unstable();
            assert_eq!(wanted, found);
        }
    }

    #[test]
    fn with_one_mass_a_square_metre_a_triangle_has_its_own() {
        for mesh in [Mesh::grid(4, 6, [0.9, 1.0]), ball()] {
            let assembly = assembly(Body::cloth("", mesh).with_mass(Mass::Area(0.3)));
            let body = &assembly.bodies[0];
            for triangle in aero_triangles(body) {
                assert!((0.3 * area(&body.start, triangle.corners) * triangle.lightness - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn no_node_gives_more_shares_than_it_has_mass() {
        let mut uneven = assembly(Body::cloth("", ball()).with_mass(Mass::Node(0.1)));
        for (node, mass) in uneven.bodies[0].mass.iter_mut().enumerate() {
            *mass *= 1.0 + (node % 5) as f64;
        }
        let mut shares = vec![0.0; uneven.places];
        for AeroTriangle { corners, lightness, .. } in aero_triangles(&uneven.bodies[0]) {
            corners.iter().for_each(|&corner| shares[corner as usize] += 1.0 / lightness / 3.0);
        }
        let full = uneven.bodies[0].mass.iter().zip(&shares).map(|(mass, shares)| shares / mass);
        assert!(full.clone().all(|full| full <= 1.0 + 1e-12) && full.fold(0.0, f64::max) > 0.9);
    }

    /// Elements of the air in a scene.
    fn count(assembly: &Assembly) -> usize {
        let at = KINDS.iter().position(|kind| kind.name == aero::NAME).unwrap();
        assembly.elements()[at].len()
    }

    #[test]
    fn what_has_no_triangles_has_no_aero_triangles_and_without_air_nothing_has() {
        for mesh in [Mesh::chain(5, 1.0), Mesh::grid(1, 9, [1.0, 0.0]), Mesh::grid(9, 1, [0.0, 1.0])] {
            assert_eq!(count(&assembly(Body::cloth("", mesh).with_mass(Mass::Node(0.1)))), 0);
        }
        let ball = Body::cloth("", ball()).with_mass(Mass::Node(0.1));
        assert_eq!(count(&assembly(ball.clone())), 320);
        assert_eq!(count(&Assembly::new(&Scene::new("").body(ball)).unwrap()), 0);
    }
}
