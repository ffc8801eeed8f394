use crate::scene::{
    ContactForm, Keyframe, Layers, Material, Mesh, Poses, Rotation, SelfCollision, Tethers, Volume,
    VolumeForm,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Cloth or a soft body.
///
/// ```
/// use taffeta::glam::DVec3;
/// use taffeta::scene::{Body, Icosphere, Mass, Mesh, VolumeForm};
///
/// let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 });
/// let ball = Body::soft("ball", ball)
///     .with_mass(Mass::Volume(200.0))
///     .at(DVec3::Y)
///     .structural(500.0, 0.5)
///     .keep_volume(VolumeForm::Corrected);
/// assert_eq!(ball.place.position, [0.0, 1.0, 0.0]);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// A name of its own, used by forces, overrides and outputs. Without one: `body0`, `body1`, …
    #[serde(default)]
    pub name: String,
    /// Cloth (any surface) or soft (a closed surface).
    #[serde(default)]
    pub kind: Kind,
    /// Mass of each node [kg]. Exactly one of the four masses is given, or none with a material, which has a density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_mass: Option<f64>,
    /// Mass of the whole body [kg], lumped by a third of each triangle's area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Mass per area [kg/m²], lumped by a third of each triangle's area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area_density: Option<f64>,
    /// Mass per volume [kg/m³] of a soft body, lumped by a third of each triangle's area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// The shape.
    pub mesh: Mesh,
    /// Close the holes of a mesh file whose border passes each of its nodes once. Outputs keep the file's faces.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fill_holes: bool,
    /// A second mesh file with the same vertices and faces: the shape in which springs and hinges are at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_shape: Option<String>,
    /// A procedural shape to use where the mesh file is not there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand_in: Option<Mesh>,
    /// Where it starts.
    #[serde(default)]
    pub place: Place,
    /// Velocity at the start [m/s]. Nodes that pins hold start at rest.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub velocity: [f64; 3],
    /// Angular velocity at the start [rad/s], about the body's centre of mass.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub angular_velocity: [f64; 3],
    /// Its springs.
    #[serde(default)]
    pub springs: Springs,
    /// Its fabric, in place of springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// What keeps the volume of a soft body; without it nothing does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<Volume>,
    /// Contact with itself, and with other bodies that have this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub self_collision: Option<SelfCollision>,
    /// Which other bodies and which colliders it meets; all if nothing is said.
    #[serde(default, skip_serializing_if = "Layers::is_default")]
    pub layers: Layers,
    /// Pins: nodes that stay in place, follow keyframes or follow a collider.
    #[serde(default, rename = "pin", skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<Pin>,
    /// Tethers: limit how far free nodes get from pinned ones, whatever the stiffness of springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tethers: Option<Tethers>,
}

fn is_zero(vector: &[f64; 3]) -> bool {
    *vector == [0.0; 3]
}

/// A kind of contact that a body finds with its own nodes or those of other bodies, for checks and estimates.
pub(crate) struct ContactOfBody {
    /// Where a scene describes it.
    pub key: &'static str,
    /// Its numbers: name, value, what it may be.
    pub numbers: Vec<(&'static str, f64, Range)>,
    /// Bytes that it takes by node, measured as those in `memory.rs`.
    pub bytes: u64,
}

/// What a number may be.
pub(crate) enum Range {
    /// More than 0, in this unit.
    Positive(&'static str),
    /// 0 or more, in this unit.
    NotNegative(&'static str),
    /// From 0 to 1.
    Share,
}

impl Body {
    /// Whether its surface touches itself and others by triangles (`form = "triangles"`).
    pub fn has_surface_contact(&self) -> bool {
        self.self_collision.as_ref().is_some_and(|contact| contact.form == ContactForm::Triangles)
    }

    /// Contacts that it finds beside those with colliders.
    pub(crate) fn contacts(&self) -> Vec<ContactOfBody> {
        let nodes = self.self_collision.as_ref().map(
            |SelfCollision { form, thickness, friction, restitution, .. }| ContactOfBody {
                key: "self_collision",
                numbers: vec![
                    ("thickness", *thickness, Range::Positive("m")),
                    ("friction", *friction, Range::NotNegative("")),
                    ("restitution", *restitution, Range::Share),
                ],
                bytes: if *form == ContactForm::Nodes { 250 } else { 4000 },
            },
        );
        nodes.into_iter().collect()
    }
}

/// What a body is.
///
/// ```
/// use taffeta::scene::{Body, Cube, Kind, Mesh};
///
/// let cube = Mesh::Cube(Cube { size: 0.2, divisions: 4 });
/// assert_eq!(Body::cloth("bag", cube.clone()).kind, Kind::Cloth);
/// assert_eq!(Body::soft("jelly", cube).kind, Kind::Soft);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A sheet, garment, chain or shell.
    #[default]
    Cloth,
    /// A body with an inside.
    Soft,
}

/// The one way in which a body's mass is given.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::{Options, Simulation};
///
/// // Cotton of 0.15 kg/m², 2 m by 1 m.
/// let cloth = Body::cloth("cloth", Mesh::grid(11, 21, [2.0, 1.0])).with_mass(Mass::Area(0.15)).structural(50.0, 0.05);
/// let simulation = Simulation::new(&Scene::new("").time(0.01, 1e-3).body(cloth), &Options::default())?;
/// assert!((simulation.bodies()[0].mass - 0.3).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass {
    /// Of each node [kg].
    Node(f64),
    /// Of the whole body [kg].
    Whole(f64),
    /// Per area [kg/m²].
    Area(f64),
    /// Per volume [kg/m³].
    Volume(f64),
}

/// Placement: scale, then rotate, then translate.
///
/// ```
/// use taffeta::scene::{Collider, Place, Rotation};
///
/// // A box of 1 m, turned by 45° about y and one metre up.
/// let place = Place {
///     position: [0.0, 1.0, 0.0],
///     rotation: Some(Rotation { axis: [0.0, 1.0, 0.0], degrees: 45.0 }),
///     ..Place::default()
/// };
/// let table = Collider::cuboid([0.0; 3], [0.5; 3]).placed(place);
/// assert_eq!(table.place.position[1], 1.0);
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Place {
    /// Shift [m].
    pub position: [f64; 3],
    /// Turn about the origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// Factor on all lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Instead of `scale`: the largest extent [m] after scaling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<f64>,
}

/// The springs of a body, by kind.
///
/// ```
/// use taffeta::scene::{Body, Hinge, Mass, Mesh, Spring, Springs};
///
/// let springs = Springs {
///     structural: Some(Spring { k: 200.0, d: 0.1 }),
///     hinge: Some(Hinge { k: 1e-5, d: 1e-7 }),
///     ..Springs::default()
/// };
/// let cloth = Body { springs, ..Body::cloth("cloth", Mesh::grid(20, 20, [1.0, 1.0])) };
/// assert_eq!(cloth.with_mass(Mass::Area(0.2)).springs.structural.unwrap().k, 200.0);
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Springs {
    /// Grid neighbours; on meshes: the edges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structural: Option<Spring>,
    /// Grid diagonals; grids only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<Spring>,
    /// Grids: two apart; meshes: opposite corners of adjacent triangles; chains: two apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bend: Option<Spring>,
    /// Struts inside a soft body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub internal: Option<Internal>,
    /// Dihedral bending.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hinge: Option<Hinge>,
}

/// Stiffness and damping of one kind of spring.
///
/// ```
/// use taffeta::scene::{Body, Mesh, Spring};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(20, 20, [1.0, 1.0])).structural(200.0, 0.1);
/// assert_eq!(cloth.springs.structural, Some(Spring { k: 200.0, d: 0.1 }));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Stiffness [N/m].
    pub k: f64,
    /// Damping along the spring [kg/s].
    #[serde(default)]
    pub d: f64,
}

/// Struts between nodes of a soft body, through its inside: `count` of them at random, or those of a file.
///
/// ```
/// use taffeta::scene::{Body, Cube, Internal, Mass, Mesh, Scene};
/// use taffeta::{Options, Simulation};
///
/// let cube = Mesh::Cube(Cube { size: 0.4, divisions: 4 });
/// let mut jelly = Body::soft("jelly", cube).with_mass(Mass::Volume(500.0)).structural(200.0, 0.2);
/// jelly.springs.internal = Some(Internal { count: 60, k: 50.0, ..Internal::default() });
/// let simulation = Simulation::new(&Scene::new("").time(0.01, 1e-3).body(jelly), &Options::default())?;
/// assert!(simulation.bodies()[0].springs.contains(&("internal", 60)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Internal {
    /// How many.
    pub count: u32,
    /// Stiffness [N/m].
    pub k: f64,
    /// Damping along the strut [kg/s].
    pub d: f64,
    /// Seed of the random choice.
    pub seed: u64,
    /// Instead of `count`: a text file with two node indices a line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The pairs of such a file, or given as data.
    #[serde(skip)]
    pub pairs: Option<Vec<[u32; 2]>>,
}

impl Default for Internal {
    fn default() -> Self {
        Self { count: 0, k: 0.0, d: 0.0, seed: 1, file: None, pairs: None }
    }
}

/// Dihedral bending at each edge between two triangles: energy ½ k (θ − θ₀)².
///
/// ```
/// use taffeta::scene::{Body, Hinge, Mesh};
///
/// let sheet = Body::cloth("sheet", Mesh::grid(20, 20, [0.2, 0.3])).hinge(1e-4, 1e-6);
/// assert_eq!(sheet.springs.hinge, Some(Hinge { k: 1e-4, d: 1e-6 }));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Hinge {
    /// Stiffness [N·m/rad].
    pub k: f64,
    /// Damping [N·m·s/rad].
    pub d: f64,
}

/// Elements of one kind that a body has beside springs, for checks and estimates.
pub(crate) struct ElementsOfBody {
    /// Where a scene describes them.
    pub key: &'static str,
    /// Their numbers, none of which may be negative: name, value, unit.
    pub numbers: Vec<(&'static str, f64, &'static str)>,
    /// Bytes that they take: by edge of a mesh, by node of a grid, and by either more of both where they are solved for.
    pub bytes: [u64; 2],
    pub solved_bytes: [u64; 2],
}

impl Body {
    /// Elements beside springs.
    pub(crate) fn elements(&self) -> Vec<ElementsOfBody> {
        let hinges = self.springs.hinge.map(|Hinge { k, d }| ElementsOfBody {
            key: "springs.hinge",
            numbers: vec![("k", k, "N·m/rad"), ("d", d, "N·m·s/rad")],
            bytes: [165, 450],
            solved_bytes: [850, 3000],
        });
        // Numbers of a fabric have checks of their own.
        let of_fabric = self.material.iter().flat_map(|_| {
            [([300, 900], [2200, 6600]), ([300, 900], [2600, 7800])].map(|(bytes, solved_bytes)| {
                ElementsOfBody { key: "material", numbers: Vec::new(), bytes, solved_bytes }
            })
        });
        hinges.into_iter().chain(of_fabric).collect()
    }

    /// The same body with some elements of every kind, for comparisons of their kernels.
    #[cfg(feature = "gpu")]
    pub(crate) fn with_elements(mut self) -> Self {
        self.springs.hinge = Some(Hinge { k: 0.0031, d: 0.00017 });
        self
    }
}

/// Nodes that are held.
///
/// ```
/// use taffeta::scene::{Body, Keyframe, Mass, Mesh, Pin, Select};
///
/// // The first row rises by 0.2 m in a second, and lets go of what is pulled harder than 5 N.
/// let mut cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// cloth.pins.push(Pin {
///     select: Select::rows(0, 0),
///     motion: vec![Keyframe::translate(1.0, [0.0, 0.2, 0.0])],
///     break_force: Some(5.0),
///     ..Pin::default()
/// });
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pin {
    /// Which nodes.
    pub select: Select,
    /// How they move; without keyframes they stay.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Keyframe>,
    /// Or poses of the body's mesh that they follow, in straight lines from frame to frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<Poses>,
    /// Name of the collider that carries them instead, as if they were fixed to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub collider: Option<String>,
    /// Force at which the pin breaks at a node, for good [N]; without it, never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub break_force: Option<f64>,
}

impl Pin {
    /// Whether its nodes may move: by keyframes, or with a collider.
    pub(crate) fn may_move(&self) -> bool {
        !self.motion.is_empty() || self.collider.is_some()
    }
}

/// A choice of nodes. Where several keys are given, a node must meet them all.
///
/// ```
/// use taffeta::scene::{Bounds, Select};
///
/// let corners = Select::nodes([0, 19]);
/// let top = Select::rows(0, 0);
/// // The border of a mesh, as far as it lies above 1 m. A node must fit all that is given.
/// let above = Bounds { min: [-9.0, 1.0, -9.0], max: [9.0, 9.0, 9.0] };
/// let hem = Select { boundary: Some(true), inside: Some(above), ..Select::default() };
/// # let _ = (corners, top, hem);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Select {
    /// Indices in the mesh's own order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Vec<u32>>,
    /// First and last row of a grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<[u32; 2]>,
    /// First and last column of a grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cols: Option<[u32; 2]>,
    /// A box in the scene's coordinates, at the start.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub inside: Option<Bounds>,
    /// Nodes on an open edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundary: Option<bool>,
    /// A side of a sheet (`left`, `right`, `back`, `front`), an OBJ group or object, an ASCII STL solid, a glTF node or mesh, or a PLY or glTF vertex attribute above 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
}

/// An axis-aligned box.
///
/// ```
/// use taffeta::scene::{Body, Bounds, Mass, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // Pins the nodes of a sheet from -0.5 m to 0.5 m that lie left of x = -0.45 m.
/// let left = Bounds { min: [-1.0, -1.0, -1.0], max: [-0.45, 1.0, 1.0] };
/// let sheet = Body::cloth("sheet", Mesh::grid(5, 11, [1.0, 1.0])).with_mass(Mass::Area(0.2)).structural(50.0, 0.05);
/// let sheet = sheet.pin(Select { inside: Some(left), ..Select::default() });
/// let simulation = Simulation::new(&Scene::new("").time(0.01, 1e-3).body(sheet), &Options::default())?;
/// assert_eq!(simulation.bodies()[0].pinned, 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Lower corner [m].
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
}

impl Select {
    /// Nodes by index.
    pub fn nodes(nodes: impl Into<Vec<u32>>) -> Self {
        Self { nodes: Some(nodes.into()), ..Self::default() }
    }

    /// Rows `first` to `last` of a grid.
    pub fn rows(first: u32, last: u32) -> Self {
        Self { rows: Some([first, last]), ..Self::default() }
    }

    /// Columns `first` to `last` of a grid.
    pub fn cols(first: u32, last: u32) -> Self {
        Self { cols: Some([first, last]), ..Self::default() }
    }

    /// A group of a mesh by its name.
    pub fn group(name: impl Into<String>) -> Self {
        Self { group: Some(name.into()), ..Self::default() }
    }
}

impl Body {
    /// A cloth. Give it a mass and springs.
    pub fn cloth(name: impl Into<String>, mesh: Mesh) -> Self {
        Self {
            name: name.into(),
            kind: Kind::Cloth,
            node_mass: None,
            mass: None,
            area_density: None,
            density: None,
            mesh,
            fill_holes: false,
            rest_shape: None,
            stand_in: None,
            place: Place::default(),
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            springs: Springs::default(),
            material: None,
            volume: None,
            self_collision: None,
            layers: Layers::default(),
            pins: Vec::new(),
            tethers: None,
        }
    }

    /// A soft body: a closed surface. Give it a mass and springs.
    pub fn soft(name: impl Into<String>, mesh: Mesh) -> Self {
        Self { kind: Kind::Soft, ..Self::cloth(name, mesh) }
    }

    /// Sets the mass, in any of the four ways.
    pub fn with_mass(mut self, mass: Mass) -> Self {
        (self.node_mass, self.mass, self.area_density, self.density) = (None, None, None, None);
        match mass {
            Mass::Node(m) => self.node_mass = Some(m),
            Mass::Whole(m) => self.mass = Some(m),
            Mass::Area(m) => self.area_density = Some(m),
            Mass::Volume(m) => self.density = Some(m),
        }
        self
    }

    /// Sets where it starts [m].
    pub fn at(mut self, position: impl Into<DVec3>) -> Self {
        self.place.position = position.into().to_array();
        self
    }

    /// Sets the velocity at the start [m/s].
    pub fn moving(mut self, velocity: impl Into<DVec3>) -> Self {
        self.velocity = velocity.into().to_array();
        self
    }

    /// Sets the angular velocity at the start [rad/s], about the centre of mass.
    pub fn spinning(mut self, angular_velocity: impl Into<DVec3>) -> Self {
        self.angular_velocity = angular_velocity.into().to_array();
        self
    }

    /// Structural springs (edges on meshes): stiffness [N/m] and damping [kg/s].
    pub fn structural(mut self, k: f64, d: f64) -> Self {
        self.springs.structural = Some(Spring { k, d });
        self
    }

    /// Shear springs of a grid: stiffness [N/m] and damping [kg/s].
    pub fn shear(mut self, k: f64, d: f64) -> Self {
        self.springs.shear = Some(Spring { k, d });
        self
    }

    /// Bend springs: stiffness [N/m] and damping [kg/s].
    pub fn bend(mut self, k: f64, d: f64) -> Self {
        self.springs.bend = Some(Spring { k, d });
        self
    }

    /// Dihedral bending: stiffness [N·m/rad] and damping [N·m·s/rad].
    pub fn hinge(mut self, k: f64, d: f64) -> Self {
        self.springs.hinge = Some(Hinge { k, d });
        self
    }

    /// Sets the fabric, which stands in place of springs and brings a mass with it.
    pub fn with_material(mut self, material: Material) -> Self {
        self.material = Some(material);
        self
    }

    /// Keeps the volume of a soft body at that of rest.
    pub fn keep_volume(mut self, form: VolumeForm) -> Self {
        self.volume = Some(Volume { form, ..Volume::default() });
        self
    }

    /// Holds nodes where they are.
    pub fn pin(self, select: Select) -> Self {
        self.pin_moving(select, Vec::new())
    }

    /// Moves nodes by keyframes.
    pub fn pin_moving(mut self, select: Select, motion: Vec<Keyframe>) -> Self {
        self.pins.push(Pin { select, motion, ..Pin::default() });
        self
    }

    /// Has nodes follow poses of the body's mesh, before it is placed [m], `interval` [s] apart from the start on.
    pub fn pin_posed(mut self, select: Select, interval: f64, poses: Vec<Vec<[f64; 3]>>) -> Self {
        let nodes = poses.into_iter().map(Arc::new).collect();
        let poses = Some(Poses { interval, nodes, ..Poses::default() });
        self.pins.push(Pin { select, poses, ..Pin::default() });
        self
    }

    /// Fixes nodes to a collider, which carries them from where they are.
    pub fn pin_to(mut self, select: Select, collider: impl Into<String>) -> Self {
        self.pins.push(Pin { select, collider: Some(collider.into()), ..Pin::default() });
        self
    }

    /// Holds nodes where they are, each until that takes more than a force [N].
    pub fn pin_breaking(mut self, select: Select, break_force: f64) -> Self {
        self.pins.push(Pin { select, break_force: Some(break_force), ..Pin::default() });
        self
    }

    /// The mass, if it is given in exactly one way.
    pub fn mass_given(&self) -> Option<Mass> {
        match (self.node_mass, self.mass, self.area_density, self.density) {
            (Some(m), None, None, None) => Some(Mass::Node(m)),
            (None, Some(m), None, None) => Some(Mass::Whole(m)),
            (None, None, Some(m), None) => Some(Mass::Area(m)),
            (None, None, None, Some(m)) => Some(Mass::Volume(m)),
            (None, None, None, None) => {
                self.material.as_ref().map(|material| Mass::Area(material.fabric().density))
            }
            _ => None,
        }
    }
}
