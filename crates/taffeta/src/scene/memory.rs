//! How much memory a scene will take, told before any of it is taken.

use crate::advice::Advice;
use crate::scene::{Body, Mesh, Method, Pin, Scene, Seam, Select, Spring, Springs, Surface};

/// Memory that building and running a scene takes at its peak, in 64 bits (in 32 bits it is up to 40 % less), beyond
/// that of the scene itself.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
///
/// let sheet = |n| Body::cloth("sheet", Mesh::grid(n, n, [1.0, 1.0])).with_mass(Mass::Area(0.2)).structural(50.0, 0.05);
/// let [small, large] = [100, 1000].map(|n| Scene::new("").body(sheet(n)).memory_needed());
/// assert!(large.bytes > 90 * small.bytes);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MemoryNeeded {
    /// In all [byte].
    pub bytes: u64,
    /// More [byte] while results are written that hold faces or normals.
    pub faces: u64,
    /// Lists of contacts between triangles [byte], which grow as surfaces come near each other: while they lie flat, and where dozens
    /// of layers lie on each other. `bytes` has those of a crumpled sheet.
    pub contact_lists: [u64; 2],
    /// What takes most of it, with its numbers.
    pub mostly: String,
    /// What would take less.
    pub remedy: &'static str,
    /// The settings among it.
    pub advice: Vec<Advice>,
}

// Bytes, measured as peaks of resident memory from 10 MB to 2 GB.
const BODY: u64 = 800;
const GRID_NODE: u64 = 198;
const NODE: u64 = 208;
const TRIANGLE: u64 = 16;
const EDGE: u64 = 20;
const SPRING: u64 = 165;
const VOLUME_NODE: u64 = 60;
const FACES_OF_NODE: u64 = 250;
const STRUT: u64 = 175;
const AERO_TRIANGLE: u64 = 100;
const CONSTRAINT: u64 = 215;
const NODE_OF_LEVELS: u64 = 560;
const SPRING_OF_LEVELS: u64 = 140;
const SECOND_ORDER_NODE: u64 = 80;
const POSITIONS_GRID_NODE: u64 = 60;
const POSITIONS_NODE: u64 = 250;
const POSITIONS_SPRING: u64 = 120;
const MOVING_PIN: u64 = 40;
const SUBSTEP: u64 = 60;
const POSE: u64 = 200;
const COLLIDER: u64 = 272;
const LOAD: u64 = 8;
const SEAM_PAIR: u64 = 170;
const TETHERED_NODE: u64 = 420;
/// Of lists of contacts.
const FLAT_TRIANGLE: u64 = 450;
const PILED_TRIANGLE: u64 = 8500;

/// A part of the memory, with words that are made only when they are asked for.
struct Part<'a> {
    bytes: u64,
    mostly: Box<dyn Fn() -> String + 'a>,
    remedy: &'static str,
    advice: Option<Advice>,
}

impl Scene {
    /// Memory that building and running the scene takes at its peak, within some tens of percent.
    pub fn memory_needed(&self) -> MemoryNeeded {
        let parts = self.bodies.iter().enumerate().flat_map(|(index, body)| self.body_parts(index, body));
        let mut bytes = 0_u64;
        let mut largest: Option<Part> = None;
        for part in parts.chain([self.frame_part(), self.seam_part()]) {
            bytes = bytes.saturating_add(part.bytes);
            if largest.as_ref().is_none_or(|so_far| part.bytes > so_far.bytes) {
                largest = Some(part);
            }
        }
        let (mostly, remedy, advice) =
            largest.map_or_else(Default::default, |part| ((part.mostly)(), part.remedy, part.advice));
        let nodes = self.bodies.iter().fold(0_u64, |sum, body| sum.saturating_add(body.mesh.nodes()));
        MemoryNeeded {
            bytes,
            faces: nodes.saturating_mul(FACES_OF_NODE),
            contact_lists: self.contact_lists(),
            mostly,
            remedy,
            advice: advice.into_iter().collect(),
        }
    }

    fn contact_lists(&self) -> [u64; 2] {
        let touching = self.bodies.iter().filter(|body| body.has_surface_contact());
        let triangles = touching.fold(0_u64, |sum, body| sum.saturating_add(triangles(&body.mesh)));
        [FLAT_TRIANGLE, PILED_TRIANGLE].map(|each| triangles.saturating_mul(each))
    }

    fn body_parts<'a>(&'a self, index: usize, body: &'a Body) -> [Part<'a>; 4] {
        let count =
            body.springs.internal.as_ref().map_or(0, |wish| {
                wish.pairs.as_ref().map_or(u64::from(wish.count), |pairs| pairs.len() as u64)
            });
        let nodes = body.mesh.nodes();
        [
            Part {
                bytes: body.mesh_bytes(),
                mostly: Box::new(move || format!("the {nodes} nodes of body `{}`", self.body_name(index))),
                remedy: "a coarser mesh would do",
                advice: None,
            },
            Part {
                bytes: count.saturating_mul(STRUT),
                mostly: Box::new(move || format!("the {count} struts of body `{}`", self.body_name(index))),
                remedy: "fewer struts would do",
                advice: None,
            },
            self.implicit_part(index, nodes, body.springs_along().saturating_add(count)),
            self.air_part(index, body),
        ]
    }

    /// Of a body's triangles, where there is air.
    fn air_part<'a>(&'a self, index: usize, body: &Body) -> Part<'a> {
        let triangles = if self.world.air.is_some() { triangles(&body.mesh) } else { 0 };
        Part {
            bytes: triangles.saturating_mul(AERO_TRIANGLE),
            mostly: Box::new(move || {
                format!("{triangles} triangles of body `{}` in the air", self.body_name(index))
            }),
            remedy: "a coarser mesh, or the same force of wind on every node, would do",
            advice: Some(Advice::EvenWind),
        }
    }

    /// Of a body's springs, where they are implicit.
    fn implicit_part(&self, index: usize, nodes: u64, springs: u64) -> Part<'_> {
        let of_body = |name: &str| (0..).zip(&self.bodies).find(|&(at, _)| self.body_name(at) == name);
        let is_solved = |name: &str| of_body(name).is_some_and(|(_, body)| body.solved_bytes() > 0);
        let name = self.body_name(index);
        let is_sewn = self.seams.iter().any(|seam| {
            let bodies = seam.bodies();
            seam.makes_points() && bodies.contains(&&*name) && bodies.into_iter().all(is_solved)
        });
        // Where bodies are sewn, there are blocks for before and for after seams are closed.
        let elements = self.bodies[index].solved_bytes().saturating_mul(if is_sewn { 2 } else { 1 });
        let by_nodes = self.solver.is_primal() && (springs > 0 || elements > 0);
        let more = if self.solver.is_second_order() { SECOND_ORDER_NODE } else { 0 };
        let bytes = match self.solver.method {
            Method::Springs => 0,
            Method::Xpbd if matches!(self.bodies[index].mesh, Mesh::Grid(_)) => {
                nodes.saturating_mul(POSITIONS_GRID_NODE)
            }
            Method::Xpbd => {
                nodes.saturating_mul(POSITIONS_NODE).saturating_add(springs.saturating_mul(POSITIONS_SPRING))
            }
            _ if by_nodes => nodes
                .saturating_mul(NODE_OF_LEVELS + more)
                .saturating_add(springs.saturating_mul(SPRING_OF_LEVELS))
                .saturating_add(elements),
            _ => springs.saturating_mul(CONSTRAINT),
        };
        Part {
            bytes,
            mostly: Box::new(move || {
                let name = self.body_name(index);
                if by_nodes {
                    format!("the {springs} springs of body `{name}`, solved for by its {nodes} nodes")
                } else {
                    format!("the {springs} constraints of body `{name}`")
                }
            }),
            remedy: "a coarser mesh, or explicit springs, would do",
            advice: Some(Advice::ExplicitSprings),
        }
    }

    /// Of seams, and of nodes that pins hold until they break, at most.
    fn seam_part(&self) -> Part<'_> {
        let of_seam = |seam: &Seam| match (&seam.pairs, &seam.from.select) {
            (Some(pairs), _) => pairs.len() as u64,
            (None, select) => {
                let body = self.bodies.iter().zip(0..).find(|(_, i)| self.body_name(*i) == seam.from.body);
                let all = |body: &Body| body.mesh.nodes();
                body.map_or(0, |(body, _)| select.as_ref().map_or(all(body), |one| body.most_selected(one)))
            }
        };
        let breaking = self.bodies.iter().flat_map(|body| {
            let pins = body.pins.iter().filter(|pin| pin.break_force.is_some());
            pins.map(|pin| body.most_selected(&pin.select))
        });
        let pairs = self.seams.iter().map(of_seam).chain(breaking).fold(0_u64, u64::saturating_add);
        Part {
            bytes: pairs.saturating_mul(SEAM_PAIR),
            mostly: Box::new(move || format!("the {pairs} joints of seams and of pins that break")),
            remedy: "selections of fewer nodes would do",
            advice: None,
        }
    }

    /// What the sub-steps of a frame are told.
    fn frame_part(&self) -> Part<'_> {
        // Contact between triangles may cut them into parts.
        let parts =
            if self.bodies.iter().any(Body::has_surface_contact) { self.time.most_parts() } else { 1 };
        let steps = u64::from(self.time.substeps()) * u64::from(parts);
        let moving = self.bodies.iter().flat_map(|body| &body.pins).filter(|pin| pin.may_move()).count();
        let [poses, colliders, loads] =
            [moving, self.colliders.len(), self.forces.len()].map(|count| count as u64);
        let each = SUBSTEP + poses * POSE + colliders * COLLIDER + loads * LOAD;
        Part {
            bytes: steps.saturating_mul(each),
            mostly: Box::new(move || {
                format!(
                    "{steps} sub-steps a frame with {poses} moving pins, {colliders} colliders, {loads} forces"
                )
            }),
            remedy: "shorter frames, longer sub-steps or fewer of these would do",
            advice: None,
        }
    }
}

impl Body {
    /// Of nodes, springs and other elements [byte].
    fn mesh_bytes(&self) -> u64 {
        let of_elements = |by: usize| self.elements().iter().map(|one| one.bytes[by]).sum::<u64>();
        let nodes = self.mesh.nodes();
        let pins = self.moving_nodes().saturating_mul(MOVING_PIN).saturating_add(self.pose_bytes());
        let mesh = match &self.mesh {
            Mesh::Grid(_) => nodes.saturating_mul(GRID_NODE + of_elements(1)),
            mesh => {
                let [surface, triangles, edges] = extent(mesh);
                let kept = u64::from(self.volume.is_some());
                // A volume needs neighbours along edges, with springs or without.
                let along = kept.max(u64::from(self.springs.structural.is_some()));
                let springs = along + u64::from(self.springs.bend.is_some());
                let edge = EDGE + springs * SPRING + of_elements(0);
                let tables =
                    [nodes.saturating_mul(NODE + kept * VOLUME_NODE), triangles.saturating_mul(TRIANGLE)];
                tables
                    .iter()
                    .fold(surface.saturating_add(edges.saturating_mul(edge)), |sum, b| sum.saturating_add(*b))
            }
        };
        let touching = self.contacts().iter().map(|contact| contact.bytes).sum::<u64>()
            + u64::from(self.tethers.is_some()) * TETHERED_NODE;
        mesh.saturating_add(pins).saturating_add(BODY).saturating_add(nodes.saturating_mul(touching))
    }

    /// Of elements beside springs, where they are solved for [byte].
    fn solved_bytes(&self) -> u64 {
        let all = self.elements();
        let of = |by: usize| all.iter().map(|one| one.solved_bytes[by]).sum::<u64>();
        match &self.mesh {
            Mesh::Grid(_) => self.mesh.nodes().saturating_mul(of(1)),
            mesh => extent(mesh)[2].saturating_mul(of(0)),
        }
    }

    /// Springs but for struts, about as many as there are.
    fn springs_along(&self) -> u64 {
        let kinds = |all: &[Option<Spring>]| all.iter().flatten().count() as u64;
        let Springs { structural, shear, bend, .. } = &self.springs;
        match &self.mesh {
            Mesh::Grid(_) => self.mesh.nodes().saturating_mul(2 * kinds(&[*structural, *shear, *bend])),
            mesh => extent(mesh)[2].saturating_mul(kinds(&[*structural, *bend])),
        }
    }

    /// Of places that pins follow, at most [byte].
    fn pose_bytes(&self) -> u64 {
        let of = |pin: &Pin| {
            let poses = pin.poses.as_ref().map_or(0, |poses| poses.nodes.len() as u64);
            poses.saturating_mul(self.most_selected(&pin.select)).saturating_mul(24)
        };
        self.pins.iter().map(of).fold(0, u64::saturating_add)
    }

    /// Nodes that follow keyframes, at most.
    fn moving_nodes(&self) -> u64 {
        let moving = self.pins.iter().filter(|pin| pin.may_move());
        let nodes = moving.fold(0_u64, |sum, pin| sum.saturating_add(self.most_selected(&pin.select)));
        nodes.min(self.mesh.nodes())
    }

    fn most_selected(&self, select: &Select) -> u64 {
        let within = |[first, last]: [u32; 2]| u64::from(last.saturating_sub(first)) + 1;
        let listed = select.nodes.as_ref().map(|nodes| nodes.len() as u64);
        let on_grid = match &self.mesh {
            Mesh::Grid(grid) if select.rows.is_some() || select.cols.is_some() => {
                let rows = select.rows.map_or(u64::from(grid.rows), within);
                Some(rows.saturating_mul(select.cols.map_or(u64::from(grid.cols), within)))
            }
            _ => None,
        };
        let most = self.mesh.nodes();
        listed.unwrap_or(most).min(on_grid.unwrap_or(most))
    }
}

/// Bytes of a mesh's surface, and its numbers of triangles and edges; by Euler's formula, to within holes and handles.
fn extent(mesh: &Mesh) -> [u64; 3] {
    const SHAPE_NODE: u64 = 104;
    const UVS_NODE: u64 = 32;
    let nodes = mesh.nodes();
    match mesh {
        Mesh::Chain(_) => [nodes.saturating_mul(SHAPE_NODE / 2), 0, nodes],
        Mesh::Surface(surface) => {
            let triangles = surface.triangles.len() as u64;
            [bytes_of(surface), triangles, nodes + triangles + surface.links.len() as u64]
        }
        Mesh::Sheet(_) | Mesh::Disc(_) => {
            [SHAPE_NODE + UVS_NODE, 2, 3].map(|each| nodes.saturating_mul(each))
        }
        _ => [SHAPE_NODE, 2, 3].map(|each| nodes.saturating_mul(each)),
    }
}

/// Number of a mesh's triangles.
fn triangles(mesh: &Mesh) -> u64 {
    match mesh {
        Mesh::Grid(grid) => 2_u64
            .saturating_mul(u64::from(grid.rows.max(1) - 1))
            .saturating_mul(u64::from(grid.cols.max(1) - 1)),
        mesh => extent(mesh)[1],
    }
}

fn bytes_of(surface: &Surface) -> u64 {
    let of = |count: usize, each: u64| count as u64 * each;
    let uvs = surface.uvs.as_ref().map_or(0, |uvs| of(uvs.coords.len(), 8) + of(uvs.corners.len(), 4));
    of(surface.vertices.len() + surface.nodes.len(), 24)
        + of(surface.node_of_vertex.as_ref().map_or(0, Vec::len), 4)
        + of(surface.triangles.len(), 12)
        + of(surface.polygons.offsets.len() + surface.polygons.corners.len(), 4)
        + of(surface.rest.as_ref().map_or(0, Vec::len), 72)
        + of(surface.links.len(), 8)
        + surface.groups.iter().map(|(_, members)| of(members.len(), 4)).sum::<u64>()
        + uvs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Air, Collider, ConstraintForm, Cube, Internal, Keyframe, Mass, SeamSide};

    fn sheet(side: u32) -> Body {
        Body::cloth("sheet", Mesh::grid(side, side, [1.0; 2])).with_mass(Mass::Node(1.0)).structural(1.0, 0.0)
    }

    fn needed(body: Body) -> u64 {
        Scene::new("").body(body).memory_needed().bytes
    }

    #[test]
    fn what_takes_most_is_named_with_its_numbers() {
        let needed = Scene::new("").body(sheet(2)).body(sheet(1000)).memory_needed();
        assert_eq!(needed.mostly, "the 1000000 nodes of body `sheet`");
        let mut cube = Body::soft("cube", Mesh::Cube(Cube { size: 1.0, divisions: 2 }));
        cube.springs.internal = Some(Internal { count: 1_000_000, ..Internal::default() });
        let needed = Scene::new("").body(cube).memory_needed();
        assert_eq!(
            (needed.mostly.as_str(), needed.remedy),
            ("the 1000000 struts of body `cube`", "fewer struts would do")
        );
        let balls = (0..100).map(|_| Collider::sphere([0.0; 3], 1.0));
        let mut scene = Scene::new("").body(sheet(2)).time(1.0, 1e-5);
        scene.colliders.extend(balls);
        let needed = scene.memory_needed();
        assert!(needed.mostly.starts_with("100000 sub-steps a frame with 0 moving pins, 100 colliders"));
        assert!(needed.bytes > 100 * 100_000 * 100);
    }

    #[test]
    fn springs_that_are_constraints_take_more() {
        let scene = |method| Scene::new("").body(sheet(100).shear(1.0, 0.0)).method(method).memory_needed();
        let [springs, ice, acad] = [Method::Springs, Method::Ice, Method::Acad].map(scene);
        assert_eq!(ice.bytes - springs.bytes, 4 * 10_000 * CONSTRAINT);
        assert_eq!((acad.bytes, ice.mostly.as_str()), (ice.bytes, "the 40000 constraints of body `sheet`"));
        let ball = Body::soft("ball", Mesh::Cube(Cube { size: 1.0, divisions: 20 })).structural(1.0, 0.0);
        let scene = |method| Scene::new("").body(ball.clone()).method(method).memory_needed().bytes;
        assert!(scene(Method::Ice) > scene(Method::Springs) + 7000 * CONSTRAINT);
    }

    #[test]
    fn springs_that_are_solved_for_by_nodes_take_more_for_each_node() {
        let of_order = |body: Body, form, order| {
            let mut scene = Scene::new("").body(body).method(Method::Ice);
            (scene.solver.ice.form, scene.solver.ice.order) = (form, order);
            scene.memory_needed()
        };
        let scene = |body, form| of_order(body, form, 1);
        let body = sheet(100).shear(1.0, 0.0);
        let explicit = needed(body.clone());
        let second = of_order(body.clone(), ConstraintForm::Primal, 2);
        let of = scene(body, ConstraintForm::Primal);
        assert_eq!(of.bytes - explicit, 10_000 * NODE_OF_LEVELS + 40_000 * SPRING_OF_LEVELS);
        assert_eq!(second.bytes - of.bytes, 10_000 * SECOND_ORDER_NODE);
        assert_eq!(of.mostly, "the 40000 springs of body `sheet`, solved for by its 10000 nodes");
        // Without springs there is nothing to solve for.
        let bare = Body { springs: Springs::default(), ..sheet(100) };
        assert_eq!(
            scene(bare.clone(), ConstraintForm::Primal).bytes,
            scene(bare, ConstraintForm::Compliant).bytes
        );
    }

    #[test]
    fn triangles_in_the_air_take_more() {
        let scene = |body: Body, air: Option<Air>| {
            let mut scene = Scene::new("").body(body);
            scene.world.air = air;
            scene.memory_needed().bytes
        };
        let more = |body: Body| scene(body.clone(), Some(Air::default())) - scene(body, None);
        assert_eq!(more(sheet(100)), 2 * 99 * 99 * AERO_TRIANGLE);
        assert_eq!(
            more(Body { mesh: Mesh::Cube(Cube { size: 1.0, divisions: 10 }), ..sheet(2) }),
            2 * 602 * AERO_TRIANGLE
        );
        assert_eq!(more(sheet(1)), 0);
        let endless = Mesh::grid(u32::MAX, u32::MAX, [1.0; 2]);
        assert_eq!(scene(Body { mesh: endless, ..sheet(2) }, Some(Air::default())), u64::MAX);
    }

    #[test]
    fn joints_and_tethers_take_more() {
        let body = sheet(100).pin(Select::rows(0, 0));
        assert_eq!(needed(body.clone().tether(0.0)) - needed(body.clone()), 10_000 * TETHERED_NODE);
        let side = || SeamSide::new("sheet", Select::cols(3, 4));
        let plain = Scene::new("").body(body);
        let sewn = plain.clone().seam(Seam::new(side(), side())).memory_needed();
        assert_eq!(sewn.bytes - plain.memory_needed().bytes, 200 * SEAM_PAIR);
    }

    #[test]
    fn sizes_beyond_counting_do_not_overflow() {
        let endless = Body { mesh: Mesh::grid(u32::MAX, u32::MAX, [1.0; 2]), ..sheet(2) }.hinge(1.0, 0.0);
        assert_eq!(needed(endless), u64::MAX);
        let all = Select { rows: Some([0, u32::MAX]), ..Select::default() };
        assert!(needed(sheet(2).pin_moving(all, vec![Keyframe::default()])) < 2200);
    }
}
