//! Where surfaces pass through each other, found exactly.

use crate::simulation::Simulation;
use crate::topology::{Piercing, piercings_apart};

/// Edges of bodies and colliders that pass through triangles where they must not.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Rotation, Scene};
/// use taffeta::{Options, Simulation};
///
/// // A sheet that lies, and one that hangs through it.
/// let lies = Body::cloth("lies", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// let mut hangs = Body { name: "hangs".into(), ..lies.clone() };
/// hangs.place.rotation = Some(Rotation { axis: [1.0, 0.0, 0.0], degrees: 80.0 });
/// let simulation = Simulation::new(&Scene::new("").time(0.01, 1e-3).body(lies).body(hangs), &Options::default())?;
/// let found = simulation.intersections();
/// assert!(found.pairs > 0 && found.complete);
/// assert!(found.first.expect("a pair").contains("body `hangs`"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Intersections {
    /// Pairs of an edge and a triangle without a common corner that have a point in common. Corners that a rigid seam
    /// without length joins are common.
    pub pairs: u64,
    /// The first of them in words: body, vertices.
    pub first: Option<String>,
    /// Whether all pairs were looked at; a tangle of millions is not counted to the end.
    pub complete: bool,
}

/// The triangles of a scene.
#[derive(Default)]
pub(crate) struct Triangles {
    /// By places in the list of all corners: nodes of all bodies by the user's numbers, then corners of colliders.
    corners: Vec<[u32; 3]>,
    /// Whose first corner is where: bodies, then colliders with triangles by their places in the scene.
    bodies: Vec<u32>,
    colliders: Vec<(usize, u32)>,
    /// For each corner a number of the point that it stands for: what is sewn together is one.
    points: Vec<u32>,
    /// The body of each triangle of one; these come first. Then the collider of each.
    of_bodies: Vec<u32>,
    of_colliders: Vec<u32>,
}

/// What a triangle is of.
enum Owner {
    Body(usize),
    Collider(usize),
}

impl Triangles {
    fn owner(&self, triangle: u32) -> Owner {
        let triangle = triangle as usize;
        match self.of_bodies.get(triangle) {
            Some(&body) => Owner::Body(body as usize),
            None => Owner::Collider(self.of_colliders[triangle - self.of_bodies.len()] as usize),
        }
    }
}

impl Simulation {
    /// Counts where bodies pass through themselves, each other and the triangles of colliders (meshes, convex hulls, height
    /// fields, boxes), by exact arithmetic on the positions as they are. It shares no code with the contacts of the
    /// simulation but for what is sewn together, so it can check them. Nodes keep their distance from round colliders, which are
    /// not looked at; nor are two bodies that do not touch each other by
    /// [`SelfCollision::with`](crate::scene::SelfCollision::with) or `without`, or do not meet by their
    /// [`Layers`](crate::scene::Layers).
    pub fn intersections(&self) -> Intersections {
        let triangles = self.triangles.get_or_init(|| self.list_triangles());
        let nodes = self.corners();
        let (apart, meetings) = (self.backend.assembly().apart(), self.backend.assembly().meetings());
        let counts = |pair: [u32; 2]| match pair.map(|triangle| triangles.owner(triangle)) {
            [Owner::Body(a), Owner::Body(b)] => {
                let touch = apart.is_none_or(|apart| !apart.0.contains(&[a.min(b), a.max(b)]));
                touch && meetings.bodies(a, b)
            }
            [Owner::Body(body), Owner::Collider(collider)]
            | [Owner::Collider(collider), Owner::Body(body)] => meetings.collider(body, collider),
            [Owner::Collider(_), Owner::Collider(_)] => false,
        };
        let found =
            piercings_apart(&nodes, &triangles.corners, |corner| triangles.points[corner as usize], counts);
        Intersections {
            pairs: found.pairs,
            first: found.first.map(|Piercing { edge, triangle }| {
                format!(
                    "the edge of {} and the triangle of {}",
                    self.words(triangles, &edge),
                    self.words(triangles, &triangle)
                )
            }),
            complete: found.complete,
        }
    }

    fn list_triangles(&self) -> Triangles {
        let assembly = self.backend.assembly();
        let (mut all, mut first) = (Triangles::default(), 0);
        for body in &assembly.bodies {
            let number = all.bodies.len() as u32;
            all.bodies.push(first);
            all.of_bodies.extend(body.user_surface().triangles.iter().map(|_| number));
            all.corners.extend(body.user_surface().triangles.iter().map(|t| t.map(|node| first + node)));
            first += body.nodes as u32;
        }
        for (index, collider) in assembly.colliders().iter().enumerate() {
            let Some(faces) = collider.faces() else { continue };
            all.colliders.push((index, first));
            all.of_colliders.extend(faces.iter().map(|_| index as u32));
            all.corners.extend(faces.iter().map(|t| t.map(|node| first + node)));
            first += collider.corners(0.0).len() as u32;
        }
        let points = assembly.points();
        all.points = self.user_order().into_iter().map(|place| points[place]).collect();
        // Corners of colliders are behind all places.
        let corners = first as usize - all.points.len();
        all.points.extend((0..corners).map(|corner| (points.len() + corner) as u32));
        all
    }

    /// Positions of all corners [m].
    fn corners(&self) -> Vec<[f64; 3]> {
        let assembly = self.backend.assembly();
        let mut nodes: Vec<[f64; 3]> =
            self.user_order().into_iter().map(|node| self.backend.position(node)).collect();
        let now = f64::from(self.frame()) * self.dt();
        nodes.extend(assembly.colliders().iter().flat_map(|collider| collider.corners(now)));
        nodes
    }

    /// Corners in words.
    fn words(&self, all: &Triangles, corners: &[u32]) -> String {
        let first = corners[0];
        let named = |numbers: Vec<usize>| {
            let words: Vec<String> = numbers.iter().map(usize::to_string).collect();
            words.join(", ")
        };
        if let Some(&(index, from)) = all.colliders.iter().rev().find(|(_, from)| *from <= first) {
            let numbers = corners.iter().map(|corner| (corner - from) as usize).collect();
            return format!("corners {} of collider `{}`", named(numbers), self.colliders[index].name);
        }
        let index = all.bodies.iter().rposition(|from| *from <= first).unwrap_or_default();
        let body = &self.backend.assembly().bodies[index];
        let vertex = |node: usize| body.vertex_of_solver(body.solver_local(node));
        let numbers = corners.iter().map(|corner| vertex((corner - all.bodies[index]) as usize)).collect();
        format!("vertices {} of body `{}`", named(numbers), body.name)
    }
}
