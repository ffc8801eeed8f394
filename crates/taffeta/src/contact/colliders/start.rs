//! Nodes that start inside colliders.

use crate::assembly::Assembly;
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::moving::MovingCollider;
use crate::contact::colliders::shape::ShapeNow;
use crate::real::Real;
use crate::scene::{Scene, plain};
use std::collections::HashSet;

/// Tolerance for rounding [m].
const ROUNDING: f64 = 1e-9;

/// How deep positions are in a collider as it is at some time.
pub(super) struct Depth {
    now: ColliderNow<f64>,
    /// Its triangles, if it has some.
    surface: Option<MeshSurface<f64>>,
    offset: f64,
}

impl Assembly {
    /// Warns of free nodes that start inside colliders, or within their offsets. Contact moves them out at once,
    /// which may stretch springs. Nodes that a collider carries are ignored.
    pub(crate) fn note_starts_inside(&mut self, scene: &Scene) {
        let mut meshes = 0;
        let carried = self.carried();
        let led_out = self.first_nodes_led_out();
        let meetings = self.meetings().clone();
        let Self { bodies, extensions, .. } = self;
        let colliders = extensions.list::<MovingCollider>();
        for (index, collider) in colliders.iter().enumerate() {
            let start = Depth::of(collider, 0.0, &mut meshes);
            let name = scene.collider_name(index);
            let met = bodies.iter_mut().enumerate().filter(|&(body, _)| meetings.collider(body, index));
            for (_, body) in met {
                let depth = |local: usize| {
                    let meets = body.free[local] && !carried.contains(&(body.first + local));
                    if meets { start.at(body.start[local]) } else { f64::NEG_INFINITY }
                };
                let (mut inside, mut near) = (Deep::default(), Deep::default());
                for (local, depth) in (0..body.nodes).map(|local| (local, depth(local))) {
                    if depth > ROUNDING {
                        inside.add(local, depth);
                    } else if depth + start.offset > ROUNDING {
                        near.add(local, depth + start.offset);
                    }
                }
                let said = [
                    inside.said("inside", &name, |worst| body.vertex_of_solver(worst)).map(|words| {
                        words
                            + match led_out.contains(&body.first) {
                                true => {
                                    " deep; they are led out while the scene runs, all that hang together to one side: another \
                                     place would spare the cloth that"
                                }
                                false => {
                                    " deep; nodes that start inside are moved to the surface in the first sub-step, and the \
                                     springs that this stretches throw the body: another place would do"
                                }
                            }
                    }),
                    near.said("within the offset of", &name, |worst| body.vertex_of_solver(worst)).map(|words| {
                        words + &format!(
                            " deep in its {} m; what starts there is put that far out at once: another place, or a smaller \
                             offset, would do",
                            plain(start.offset)
                        )
                    }),
                ];
                body.warnings.extend(said.into_iter().flatten());
            }
        }
    }
}

/// Nodes of a body that start too deep.
#[derive(Default)]
struct Deep {
    count: usize,
    worst: usize,
    /// The depth of the worst [m].
    depth: f64,
}

impl Deep {
    fn add(&mut self, node: usize, depth: f64) {
        self.count += 1;
        if depth > self.depth {
            (self.worst, self.depth) = (node, depth);
        }
    }

    /// The number of nodes, and the depth of the worst, by its vertex.
    fn said(&self, place: &str, collider: &str, vertex: impl Fn(usize) -> usize) -> Option<String> {
        let nodes = if self.count == 1 { "node starts" } else { "nodes start" };
        (self.count > 0).then(|| {
            format!(
                "{} {nodes} {place} collider `{collider}`, worst of all vertex {}, {:.3e} m",
                self.count,
                vertex(self.worst),
                self.depth
            )
        })
    }
}

impl Assembly {
    /// Nodes that a collider carries, by solver index.
    pub(super) fn carried(&self) -> HashSet<usize> {
        let attachments = self.attachments();
        let joints = attachments.joints.iter().filter(|joint| attachments.is_carried(joint));
        joints.map(|joint| joint.ends[0] as usize).collect()
    }
}

impl Depth {
    /// In a collider at a time [s]. Meshes are counted in `meshes`.
    pub(super) fn of(collider: &MovingCollider, time: f64, meshes: &mut u32) -> Self {
        let surface = collider.mesh().map(|mesh| mesh.surface());
        Self { now: collider.at(time - 1.0, 1.0, meshes), surface, offset: collider.offset() }
    }

    /// Depth of a position behind the surface itself [m]; below 0 in front of it. Nothing is behind a sheet. Beyond
    /// the offset, any number below that.
    pub(super) fn at(&self, x: [f64; 3]) -> f64 {
        let depth = match (&self.now.shape, &self.surface) {
            (ShapeNow::Mesh(mesh), Some(surface)) => {
                let place = mesh.local(x);
                let is_within = surface.solid && !surface.tree(mesh).is_outside(place);
                let most = if is_within { f64::FAR } else { self.offset * self.offset };
                surface.depth(mesh, place, most).map(|depth| depth - mesh.offset)
            }
            _ => self.now.depth_and_normal(x).map(|(depth, _)| depth - self.offset),
        };
        depth.unwrap_or(f64::NEG_INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Collider, Icosphere, Mass, Mesh};

    /// The warning for a level sheet of 3 × 3 nodes and 1 m on a collider.
    fn warning(y: f64, collider: Collider) -> String {
        let sheet = Body::cloth("sheet", Mesh::grid(3, 3, [1.0, 1.0])).with_mass(Mass::Node(0.1));
        let scene =
            Scene::new("inside").body(sheet.structural(1.0, 0.0).at([0.0, y, 0.0])).collider(collider);
        Assembly::new(&scene).unwrap().bodies[0].warnings.join("\n")
    }

    #[test]
    fn nodes_that_start_inside_are_counted_and_the_deepest_is_named() {
        let icosphere = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
        let shapes = [
            Collider::sphere([0.0; 3], 0.5),
            Collider::mesh(icosphere.clone()).named("ball"),
            Collider::convex(icosphere),
        ];
        for collider in shapes {
            let name = if collider.name.is_empty() { "collider0" } else { "ball" };
            let words = warning(0.3, collider.clone().offset(0.01));
            let start = format!("1 node starts inside collider `{name}`, worst of all vertex 4, ");
            let depth = words.strip_prefix(&start).and_then(|rest| rest.split(' ').next()).unwrap();
            assert!((depth.parse::<f64>().unwrap() - 0.2).abs() < 5e-3, "{words}");
            let (clear, near) =
                (warning(0.512, collider.clone().offset(0.01)), warning(0.504, collider.offset(0.01)));
            assert_eq!(clear, "");
            let start =
                format!("1 node starts within the offset of collider `{name}`, worst of all vertex 4, ");
            let depth = near.strip_prefix(&start).and_then(|rest| rest.split(' ').next()).unwrap();
            assert!((depth.parse::<f64>().unwrap() - 0.006).abs() < 1e-3, "{near}");
            assert!(near.contains(" m deep in its 0.01 m; "), "{near}");
        }
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.01);
        assert_eq!(warning(0.01, floor.clone()), "");
        assert!(
            warning(0.0, floor.clone())
                .starts_with("9 nodes start within the offset of collider `collider0`, worst")
        );
        assert!(warning(-0.25, floor).starts_with("9 nodes start inside collider `collider0`, worst"));
    }

    #[test]
    fn nothing_is_inside_a_sheet_and_held_nodes_may_be_anywhere() {
        for (y, words) in
            [(-0.06, "9 nodes start within"), (-0.11, ""), (0.04, "9 nodes start within"), (0.11, "")]
        {
            let said = warning(y, Collider::mesh(Mesh::grid(2, 2, [2.0, 2.0])).offset(0.1));
            assert!(said.starts_with(words) && said.is_empty() == words.is_empty(), "{y}: {said}");
        }
        let held = Body::cloth("sheet", Mesh::grid(2, 2, [0.1, 0.1]))
            .with_mass(Mass::Node(0.1))
            .structural(1.0, 0.0)
            .pin(crate::scene::Select::nodes([0, 1, 2, 3]));
        let scene = Scene::new("held").body(held).collider(Collider::sphere([0.0; 3], 0.5));
        assert!(Assembly::new(&scene).unwrap().bodies[0].warnings.is_empty());
    }
}
