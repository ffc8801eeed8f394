//! The triangles that air acts on.

use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::real::{cross, norm, sub};
use crate::topology::RestShape;

/// Panels of some bodies, in the order in which nodes add up their forces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panels {
    /// Corners by solver index.
    pub corners: Vec<[u32; 3]>,
    /// 1/M of each [1/kg], where M is the mass that moves with it.
    pub lightness: Vec<f64>,
    /// Area of each at rest [m²].
    pub areas: Vec<f64>,
}

impl Panels {
    /// Those of a scene; none without air.
    pub(crate) fn new(assembly: &Assembly) -> Self {
        let mut panels = Self::default();
        if assembly.world.air.is_some() {
            assembly.bodies.iter().for_each(|body| panels.add(body));
        }
        panels
    }

    /// Adds the triangles of a body that have an area at rest.
    ///
    /// M is three times the least share of a corner's mass, shares being by area: then no node has more shares than mass,
    /// whatever the masses, and what slows every panel down by no more than its flow does so to the body. With one mass a
    /// square metre M is the panel's own mass.
    fn add(&mut self, body: &BodyAssembly) {
        let triangles = triangles(body);
        let mut around = vec![0.0; body.nodes];
        for (corners, area) in &triangles {
            corners.iter().for_each(|&corner| around[corner as usize] += area);
        }
        for (corners, area) in triangles.into_iter().filter(|(_, area)| *area > 0.0) {
            let share = |&corner: &u32| body.mass[corner as usize] * area / around[corner as usize];
            let mass = 3.0 * corners.iter().map(share).fold(f64::INFINITY, f64::min);
            self.corners.push(corners.map(|corner| corner + body.first as u32));
            self.lightness.push(1.0 / mass);
            self.areas.push(area);
        }
    }

    /// Whether some are a body's.
    pub fn are_of(&self, body: &BodyAssembly) -> bool {
        let own = body.first as u32..(body.first + body.nodes) as u32;
        self.corners.iter().any(|corners| own.contains(&corners[0]))
    }

    /// Number of panels.
    pub fn len(&self) -> usize {
        self.corners.len()
    }
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
    use crate::scene::{Air, Body, Icosphere, Mass, Mesh, Scene};

    fn assembly(body: Body) -> Assembly {
        let mut scene = Scene::new("").body(body);
        scene.world.air = Some(Air::default());
        Assembly::new(&scene).unwrap()
    }

    fn ball() -> Mesh {
        Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 })
    }

    #[test]
    fn panels_are_the_triangles_that_the_user_knows() {
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
            let mut found: Vec<_> = assembly.panels.corners.iter().copied().map(sorted).collect();
            wanted.sort_unstable();
            found.sort_unstable();
            assert_eq!(wanted, found);
        }
    }

    #[test]
    fn with_one_mass_a_square_metre_a_panel_has_its_own() {
        for mesh in [Mesh::grid(4, 6, [0.9, 1.0]), ball()] {
            let assembly = assembly(Body::cloth("", mesh).with_mass(Mass::Area(0.3)));
            let body = &assembly.bodies[0];
            for (corners, lightness) in assembly.panels.corners.iter().zip(&assembly.panels.lightness) {
                assert!((0.3 * area(&body.start, *corners) * lightness - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn no_node_gives_more_shares_than_it_has_mass() {
        let mut uneven = assembly(Body::cloth("", ball()).with_mass(Mass::Node(0.1)));
        for (node, mass) in uneven.bodies[0].mass.iter_mut().enumerate() {
            *mass *= 1.0 + (node % 5) as f64;
        }
        let panels = Panels::new(&uneven);
        let mut shares = vec![0.0; uneven.places];
        for (corners, lightness) in panels.corners.iter().zip(&panels.lightness) {
            corners.iter().for_each(|&corner| shares[corner as usize] += 1.0 / lightness / 3.0);
        }
        let full = uneven.bodies[0].mass.iter().zip(&shares).map(|(mass, shares)| shares / mass);
        assert!(full.clone().all(|full| full <= 1.0 + 1e-12) && full.fold(0.0, f64::max) > 0.9);
    }

    #[test]
    fn what_has_no_triangles_has_no_panels() {
        for mesh in [Mesh::chain(5, 1.0), Mesh::grid(1, 9, [1.0, 0.0]), Mesh::grid(9, 1, [0.0, 1.0])] {
            assert_eq!(assembly(Body::cloth("", mesh).with_mass(Mass::Node(0.1))).panels.len(), 0);
        }
        assert_eq!(
            Assembly::new(&Scene::new("").body(Body::cloth("", ball()).with_mass(Mass::Node(0.1))))
                .unwrap()
                .panels
                .len(),
            0
        );
    }
}
