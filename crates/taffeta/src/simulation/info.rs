//! What a running scene is made of, for people and outputs.

use crate::assembly::Assembly;
use crate::attachments::constraints::IS_POINT;
use crate::contact::nodes::self_contact::SelfContact;
use crate::scene::{Mesh, Scene, Shape};
use crate::simulation::{BodyHandle, ColliderHandle};

/// One body of a running scene.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::rows(0, 0)));
/// let simulation = Simulation::new(&scene, &Options::default())?;
/// let [cloth] = simulation.bodies() else { panic!("one body") };
/// assert_eq!((cloth.nodes, cloth.pinned, cloth.triangles), (20, 5, 24));
/// assert_eq!(cloth.springs, [("structural", 31)]);
/// assert!((cloth.mass - 0.2 * 0.4 * 0.3).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BodyInfo {
    /// What to address it by.
    pub handle: BodyHandle,
    /// Its name.
    pub name: String,
    /// Number of its pins in the scene.
    pub pins: usize,
    /// Number of vertices: what outputs have.
    pub vertices: usize,
    /// Number of nodes: what is simulated.
    pub nodes: usize,
    /// Number of nodes that pins hold.
    pub pinned: usize,
    /// Number of nodes that pins hold until they break.
    pub breaking: usize,
    /// Number of tethers.
    pub tethers: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Springs by kind, with their number: `("structural", 1984)`.
    pub springs: Vec<(&'static str, usize)>,
    /// Nodes of its coarser levels, the finest first, where its springs are solved for by multigrid.
    pub levels: Vec<usize>,
    /// Elements beside springs by kind, with their number: `("hinges", 1920)`.
    pub elements: Vec<(&'static str, usize)>,
    /// Mass [kg], held nodes included.
    pub mass: f64,
    /// Volume at rest [m³], of a closed body.
    pub rest_volume: Option<f64>,
    /// Of a body whose nodes touch others: stretch from which on nodes of another layer can pass between its own.
    pub slips_from: Option<f64>,
    /// What was repaired in its mesh, in words.
    pub repairs: Vec<String>,
}

/// One collider of a running scene.
///
/// ```
/// use taffeta::scene::{Collider, Cube, Mesh, Scene};
/// use taffeta::{Options, Simulation};
/// # let body = taffeta::scene::Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3]));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(body.with_mass(taffeta::scene::Mass::Area(0.2)).at([0.0, 1.0, 0.0]));
///
/// let table = Collider::mesh(Mesh::Cube(Cube { size: 0.5, divisions: 1 })).named("table");
/// let scene = scene.collider(table).collider(Collider::sphere([0.0, -1.0, 0.0], 0.2));
/// let simulation = Simulation::new(&scene, &Options::default())?;
/// let [table, ball] = simulation.colliders() else { panic!("two colliders") };
/// assert_eq!((table.shape, table.surface), ("mesh", Some((12, true))));
/// assert_eq!((ball.shape, ball.name.as_str()), ("sphere", "collider1"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ColliderInfo {
    /// What to address it by.
    pub handle: ColliderHandle,
    /// Its name.
    pub name: String,
    /// The key of its shape: `"sphere"`, `"mesh"`, …
    pub shape: &'static str,
    /// Of triangles: how many there are, and whether they close around an inside; an open surface is a sheet.
    pub surface: Option<(usize, bool)>,
    /// Number of keyframes of its rigid motion.
    pub keyframes: usize,
    /// Number of poses of its nodes.
    pub poses: usize,
    /// What was repaired in its mesh, in words.
    pub repairs: Vec<String>,
}

impl BodyInfo {
    pub(crate) fn of(scene: &Scene, assembly: &Assembly, handle: BodyHandle) -> Self {
        let index = handle.index();
        let body = &assembly.bodies[index];
        let nodes = body.first as u32..(body.first + body.nodes) as u32;
        let attachments = assembly.attachments();
        let points = attachments.joints.iter().filter(|joint| joint.ends[1] & IS_POINT != 0);
        let coarser = assembly.levels().iter().map(|level| level.bodies[index].len());
        Self {
            handle,
            name: body.name.clone(),
            pins: scene.bodies[index].pins.len(),
            vertices: body.vertices(),
            nodes: body.nodes,
            pinned: body.free.iter().filter(|free| !**free).count(),
            breaking: points.filter(|joint| nodes.contains(&joint.ends[0])).count(),
            tethers: attachments.tethers.iter().filter(|tether| nodes.contains(&tether.node)).count(),
            triangles: body.triangles(),
            springs: body.spring_counts(),
            levels: coarser.take_while(|&nodes| nodes > 0).collect(),
            elements: assembly
                .elements()
                .iter()
                .map(|list| (list.kind.name, list.bodies[index].len()))
                .collect(),
            mass: body.mass.iter().sum(),
            rest_volume: body.rest_volume,
            slips_from: body.self_contact().map(SelfContact::slips_from),
            repairs: body.surface.as_ref().map_or_else(Vec::new, |surface| surface.repairs.clone()),
        }
    }
}

impl ColliderInfo {
    pub(crate) fn of(scene: &Scene, assembly: &Assembly, handle: ColliderHandle) -> Self {
        let index = handle.index();
        let described = &scene.colliders[index];
        let repairs = match described.shape() {
            Some(Shape::Mesh(Mesh::Surface(surface)) | Shape::Convex(Mesh::Surface(surface))) => {
                surface.repairs.clone()
            }
            _ => Vec::new(),
        };
        Self {
            handle,
            name: scene.collider_name(index),
            shape: described.shape().map_or("", |shape| shape.key()),
            surface: assembly.colliders()[index].mesh().map(|mesh| (mesh.triangles.len(), mesh.solid)),
            keyframes: described.motion.len(),
            poses: described.poses.as_ref().map_or(0, |poses| poses.nodes.len()),
            repairs,
        }
    }
}
