use crate::scene::{Keyframe, Layers, Mesh, Place};
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Something that bodies cannot enter: exactly one shape, at rest or moved by keyframes.
///
/// ```
/// use taffeta::glam::DVec3;
/// use taffeta::scene::{Collider, Keyframe};
///
/// let floor = Collider::plane(DVec3::ZERO, DVec3::Y).friction(0.4);
/// let ball = Collider::sphere([0.0, 1.0, 0.0], 0.3).keyframe(Keyframe::translate(2.0, [0.5, 0.0, 0.0]));
/// # let _ = (floor, ball);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Collider {
    /// A name of its own, used by pins and messages. Without one: `collider0`, `collider1`, …
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// A ball.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Sphere>,
    /// A half-space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
    /// A box.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<Cuboid>,
    /// A round bar with round ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capsule: Option<Bar>,
    /// A round bar with flat ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cylinder: Option<Bar>,
    /// A surface of triangles. A closed one is solid, an open one a sheet with two sides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Mesh>,
    /// The convex hull of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub convex: Option<Mesh>,
    /// Ground whose height is given over a rectangle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heightfield: Option<Heightfield>,
    /// Close the holes of a mesh file, as for bodies.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub fill_holes: bool,
    /// A procedural shape to use where the file of `mesh` or `convex` is not there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stand_in: Option<Mesh>,
    /// How the vertices of `mesh` move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses: Option<Poses>,
    /// Where it starts.
    pub place: Place,
    /// Distance kept between surface and nodes [m].
    pub offset: f64,
    /// Coulomb coefficient of friction.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Which bodies it meets; all if nothing is said.
    #[serde(skip_serializing_if = "Layers::is_default")]
    pub layers: Layers,
    /// Rigid motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Keyframe>,
}

impl Default for Collider {
    fn default() -> Self {
        Self {
            name: String::new(),
            sphere: None,
            plane: None,
            cuboid: None,
            capsule: None,
            cylinder: None,
            mesh: None,
            convex: None,
            heightfield: None,
            fill_holes: false,
            stand_in: None,
            poses: None,
            place: Place::default(),
            offset: 0.01,
            friction: 0.3,
            restitution: 0.0,
            layers: Layers::default(),
            motion: Vec::new(),
        }
    }
}

/// A ball.
///
/// ```
/// use taffeta::scene::{Collider, Shape, Sphere};
///
/// let ball = Collider::sphere([0.0, 1.0, 0.0], 0.3);
/// assert!(matches!(ball.shape(), Some(Shape::Sphere(Sphere { radius: 0.3, .. }))));
/// ```
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre [m].
    #[serde(default)]
    pub center: [f64; 3],
    /// Radius [m].
    pub radius: f64,
}

/// A half-space: everything on the side away from `normal` is solid.
///
/// ```
/// use taffeta::scene::{Collider, Plane};
///
/// // A slope: y = -x.
/// let slope = Collider { plane: Some(Plane { point: [0.0; 3], normal: [1.0, 1.0, 0.0] }), ..Collider::default() };
/// assert_eq!(slope.shape().map(|shape| shape.key()), Some("plane"));
/// ```
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// A point [m] on the surface.
    #[serde(default)]
    pub point: [f64; 3],
    /// Outward direction; its length does not matter.
    #[serde(default = "up")]
    pub normal: [f64; 3],
}

fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

/// A box with its faces along the axes; `place` and `motion` turn it.
///
/// ```
/// use taffeta::scene::{Collider, Cuboid};
///
/// // A table top, 1.2 m by 0.8 m and 4 cm thick.
/// let table = Collider::cuboid([0.0, 0.7, 0.0], [0.6, 0.02, 0.4]);
/// assert!(matches!(table.cuboid, Some(Cuboid { half: [0.6, 0.02, 0.4], .. })));
/// ```
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// Centre [m].
    #[serde(default)]
    pub center: [f64; 3],
    /// Half of its extent along each axis [m].
    pub half: [f64; 3],
}

/// A round bar.
///
/// ```
/// use taffeta::scene::{Bar, Collider};
///
/// // A clothes line, 2 cm thick.
/// let line = Collider::capsule([-1.0, 1.5, 0.0], [1.0, 1.5, 0.0], 0.01);
/// assert!(matches!(line.capsule, Some(Bar { radius: 0.01, .. })));
/// ```
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bar {
    /// One end of its axis [m].
    pub a: [f64; 3],
    /// The other end [m].
    pub b: [f64; 3],
    /// Radius [m].
    pub radius: f64,
}

/// Ground whose height is given over a rectangle in the xz plane, centred on the origin; solid down to `depth` below its
/// lowest point.
///
/// ```
/// use taffeta::scene::Collider;
///
/// // A ditch across ground of 4 m by 2 m.
/// let ground = Collider::heightfield([4.0, 2.0], vec![vec![0.0, -0.5, 0.0], vec![0.0, -0.5, 0.0]]);
/// assert_eq!(ground.heightfield.unwrap().heights[1][1], -0.5);
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Heightfield {
    /// Extent along x and z [m].
    pub size: [f64; 2],
    /// Heights [m] by rows, row 0 at −z, the first of a row at −x; two rows and columns at least.
    pub heights: Vec<Vec<f64>>,
    /// How far it goes below its lowest point [m].
    #[serde(default = "one")]
    pub depth: f64,
}

fn one() -> f64 {
    1.0
}

/// Shapes that a mesh takes one after the other: its vertices go straight from one to the next. They stay in the first
/// until `start`, and in the last when it is over. Velocities come with it.
///
/// ```
/// use taffeta::scene::{Collider, Cube, Mesh};
/// use taffeta::topology::shapes;
///
/// // A cube of 0.4 m that grows by half within a second.
/// let cube = Mesh::Cube(Cube { size: 0.4, divisions: 1 });
/// let nodes: Vec<[f64; 3]> = shapes::surface(&cube).unwrap().nodes;
/// let grown = nodes.iter().map(|node| node.map(|x| 1.5 * x)).collect();
/// let growing = Collider::mesh(cube).posed(1.0, vec![nodes, grown]);
/// assert_eq!(growing.poses.unwrap().nodes.len(), 2);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Poses {
    /// A PC2 file with the mesh's vertices in its order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Or mesh files, one for each pose, with the vertices and faces of the mesh.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// Time from a pose to the next [s].
    pub interval: f64,
    /// When it is in the first [s].
    pub start: f64,
    /// Places of the mesh's nodes [m] in each pose: those of the files, or given as data.
    #[serde(skip)]
    pub nodes: Vec<Arc<Vec<[f64; 3]>>>,
}

impl Default for Poses {
    fn default() -> Self {
        Self { file: None, files: Vec::new(), interval: 1.0 / 30.0, start: 0.0, nodes: Vec::new() }
    }
}

/// The one shape of a collider.
///
/// ```
/// use taffeta::scene::{Collider, Shape};
///
/// let ball = Collider::sphere([0.0; 3], 0.5);
/// assert_eq!(ball.shape().map(|shape| shape.key()), Some("sphere"));
/// assert!(Collider::default().shape().is_none());
/// ```
#[derive(Clone, Copy, Debug)]
pub enum Shape<'a> {
    /// A ball.
    Sphere(Sphere),
    /// A half-space.
    Plane(Plane),
    /// A box.
    Box(Cuboid),
    /// A round bar with round ends.
    Capsule(Bar),
    /// A round bar with flat ends.
    Cylinder(Bar),
    /// A surface of triangles.
    Mesh(&'a Mesh),
    /// The convex hull of a mesh.
    Convex(&'a Mesh),
    /// Ground.
    Heightfield(&'a Heightfield),
}

impl Shape<'_> {
    /// Its key in a scene, one of [`Collider::SHAPES`].
    pub fn key(&self) -> &'static str {
        let number = match self {
            Self::Sphere(_) => 0,
            Self::Plane(_) => 1,
            Self::Box(_) => 2,
            Self::Capsule(_) => 3,
            Self::Cylinder(_) => 4,
            Self::Mesh(_) => 5,
            Self::Convex(_) => 6,
            Self::Heightfield(_) => 7,
        };
        Collider::SHAPES[number]
    }
}

impl Collider {
    /// The keys of shapes.
    pub const SHAPES: [&'static str; 8] =
        ["sphere", "plane", "box", "capsule", "cylinder", "mesh", "convex", "heightfield"];

    /// A ball with the default offset, friction and restitution.
    pub fn sphere(center: impl Into<DVec3>, radius: f64) -> Self {
        Self { sphere: Some(Sphere { center: center.into().to_array(), radius }), ..Self::default() }
    }

    /// A half-space with the default offset, friction and restitution.
    pub fn plane(point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Self {
        let (point, normal) = (point.into().to_array(), normal.into().to_array());
        Self { plane: Some(Plane { point, normal }), ..Self::default() }
    }

    /// A box by its centre and half of its extent along each axis [m].
    pub fn cuboid(center: impl Into<DVec3>, half: impl Into<DVec3>) -> Self {
        let (center, half) = (center.into().to_array(), half.into().to_array());
        Self { cuboid: Some(Cuboid { center, half }), ..Self::default() }
    }

    /// A round bar with round ends about the points `a` and `b` [m].
    pub fn capsule(a: impl Into<DVec3>, b: impl Into<DVec3>, radius: f64) -> Self {
        let (a, b) = (a.into().to_array(), b.into().to_array());
        Self { capsule: Some(Bar { a, b, radius }), ..Self::default() }
    }

    /// A round bar from `a` to `b` [m], with flat ends.
    pub fn cylinder(a: impl Into<DVec3>, b: impl Into<DVec3>, radius: f64) -> Self {
        let (a, b) = (a.into().to_array(), b.into().to_array());
        Self { cylinder: Some(Bar { a, b, radius }), ..Self::default() }
    }

    /// A surface of triangles: solid if it is closed, else a sheet with two sides.
    pub fn mesh(mesh: Mesh) -> Self {
        Self { mesh: Some(mesh), ..Self::default() }
    }

    /// The convex hull of a mesh.
    pub fn convex(mesh: Mesh) -> Self {
        Self { convex: Some(mesh), ..Self::default() }
    }

    /// Ground over a rectangle of extent `size` [m] along x and z, from heights [m] by rows.
    pub fn heightfield(size: impl Into<DVec2>, heights: Vec<Vec<f64>>) -> Self {
        let field = Heightfield { size: size.into().to_array(), heights, depth: one() };
        Self { heightfield: Some(field), ..Self::default() }
    }

    /// Gives it a name.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Sets the Coulomb coefficient of friction.
    pub fn friction(mut self, friction: f64) -> Self {
        self.friction = friction;
        self
    }

    /// Sets the share of normal speed that is given back.
    pub fn restitution(mut self, restitution: f64) -> Self {
        self.restitution = restitution;
        self
    }

    /// Sets the distance kept between surface and nodes [m].
    pub fn offset(mut self, offset: f64) -> Self {
        self.offset = offset;
        self
    }

    /// Sets where it starts.
    pub fn placed(mut self, place: Place) -> Self {
        self.place = place;
        self
    }

    /// Adds a keyframe.
    pub fn keyframe(mut self, key: Keyframe) -> Self {
        self.motion.push(key);
        self
    }

    /// Poses of the nodes of its mesh [m], `interval` [s] apart, from t = 0 on.
    pub fn posed(mut self, interval: f64, nodes: Vec<Vec<[f64; 3]>>) -> Self {
        let nodes = nodes.into_iter().map(Arc::new).collect();
        self.poses = Some(Poses { interval, nodes, ..Poses::default() });
        self
    }

    /// Its shapes; one would do.
    pub fn shapes(&self) -> Vec<Shape<'_>> {
        let all = [
            self.sphere.map(Shape::Sphere),
            self.plane.map(Shape::Plane),
            self.cuboid.map(Shape::Box),
            self.capsule.map(Shape::Capsule),
            self.cylinder.map(Shape::Cylinder),
            self.mesh.as_ref().map(Shape::Mesh),
            self.convex.as_ref().map(Shape::Convex),
            self.heightfield.as_ref().map(Shape::Heightfield),
        ];
        all.into_iter().flatten().collect()
    }

    /// The shape, if there is exactly one.
    pub fn shape(&self) -> Option<Shape<'_>> {
        match self.shapes().as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }
}
