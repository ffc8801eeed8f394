//! Bodies: what they are, what they are made of, and what holds them.

use bevy::camera::visibility::NoFrustumCulling;
use bevy::prelude::*;
use taffeta::scene::{
    Body, Grid, Hinge, Layers, Mass, Material, Mesh, Pin, Place, Select, SelfCollision, Spring, Springs,
    Tethers, Volume, VolumeForm,
};

/// Cloth: a sheet, garment, chain or shell of this shape. It starts where its transform is.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{prelude::*, taffeta::scene};
///
/// // A sheet of 1.5 m × 1 m, and a rope of two metres.
/// let sheet = Cloth::grid(20, 30, Vec2::new(1.5, 1.0));
/// let rope = Cloth(scene::Mesh::chain(50, 2.0));
/// assert_eq!((sheet.0.nodes(), rope.0.nodes()), (600, 51));
/// ```
#[derive(Component, Clone, Debug)]
#[require(SoftMaterial, Pins, Transform, Visibility, NoFrustumCulling)]
pub struct Cloth(pub Mesh);

impl Cloth {
    /// A rectangle in the xz plane about the origin: `rows` of nodes along z, `cols` along x, and its size along x and z
    /// [m]. Node `row · cols + col`, the first at −x and −z.
    pub fn grid(rows: u32, cols: u32, size: Vec2) -> Self {
        Self(Mesh::Grid(Grid { rows, cols, size: [f64::from(size.x), f64::from(size.y)] }))
    }
}

/// A soft body: a closed surface of this shape. It starts where its transform is.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn drop_ball(mut commands: Commands) {
///     commands.spawn((
///         SoftBody::ball(0.25, 3),
///         SoftMaterial::new(Mass::Volume(200.0)).structural(500.0, 0.5).keep_volume(VolumeForm::Corrected),
///         Transform::from_xyz(0.0, 2.0, 0.0),
///     ));
/// }
/// assert_eq!(SoftBody::ball(0.25, 3).0.nodes(), 642);
/// ```
#[derive(Component, Clone, Debug)]
#[require(SoftMaterial, Pins, Transform, Visibility, NoFrustumCulling)]
pub struct SoftBody(pub Mesh);

impl SoftBody {
    /// A ball about the origin: an icosahedron whose triangles are cut in four `subdivisions` times.
    pub fn ball(radius: f32, subdivisions: u32) -> Self {
        Self(Mesh::Icosphere(taffeta::scene::Icosphere { radius: radius.into(), subdivisions }))
    }
}

/// What a body is made of.
///
/// ```
/// use bevy_taffeta::prelude::*;
///
/// // Cotton of 0.2 kg/m² that keeps 5 mm from itself.
/// let cotton = SoftMaterial::new(Mass::Area(0.2))
///     .structural(50.0, 0.02)
///     .shear(20.0, 0.02)
///     .hinge(1e-4, 1e-6)
///     .collide(0.005);
/// assert_eq!(cotton.self_collision.map(|contact| contact.thickness), Some(0.005));
///
/// // The same by its name, in SI units that do not depend on the mesh; the implicit solver stands steps of a frame.
/// let cotton = SoftMaterial::preset("cotton");
/// assert_eq!(cotton.mass, Mass::Area(0.15));
/// ```
#[derive(Component, Clone, Debug)]
pub struct SoftMaterial {
    /// Its mass.
    pub mass: Mass,
    /// Its springs.
    pub springs: Springs,
    /// Its fabric, in place of springs.
    pub fabric: Option<Material>,
    /// What keeps the volume of a soft body.
    pub volume: Option<Volume>,
    /// Contact with itself, and with other bodies that have this.
    pub self_collision: Option<SelfCollision>,
    /// Which other bodies and which colliders it meets.
    pub layers: Layers,
    /// What keeps free nodes near held ones.
    pub tethers: Option<Tethers>,
}

impl Default for SoftMaterial {
    /// Light and loose: nodes of ten grams, edges of 50 N/m.
    fn default() -> Self {
        Self::new(Mass::Node(0.01)).structural(50.0, 0.02).bend(5.0, 0.02)
    }
}

impl SoftMaterial {
    /// A mass without springs.
    pub fn new(mass: Mass) -> Self {
        Self {
            mass,
            springs: Springs::default(),
            fabric: None,
            volume: None,
            self_collision: None,
            layers: Layers::default(),
            tethers: None,
        }
    }

    /// A fabric by its name, as [`PRESETS`](taffeta::scene::PRESETS) lists them.
    pub fn preset(name: impl Into<String>) -> Self {
        Self::fabric(Material::preset(name))
    }

    /// A fabric with its own mass per area.
    pub fn fabric(fabric: Material) -> Self {
        let mass = Mass::Area(fabric.fabric().density);
        Self { fabric: Some(fabric), ..Self::new(mass) }
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

    /// Keeps the volume of a soft body at that of rest.
    pub fn keep_volume(self, form: VolumeForm) -> Self {
        self.volume(Volume { form, ..Volume::default() })
    }

    /// Keeps the volume of a soft body, or its pressure.
    pub fn volume(mut self, volume: Volume) -> Self {
        self.volume = Some(volume);
        self
    }

    /// Has the body collide with itself, and with others that do so, at a distance of `thickness` [m]: what starts apart never
    /// passes through.
    pub fn collide(mut self, thickness: f64) -> Self {
        self.self_collision = Some(SelfCollision { thickness, ..SelfCollision::default() });
        self
    }

    /// Sets which other bodies and which colliders it meets.
    pub fn layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self
    }
}

/// The nodes of a body that are held.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// let mut world = World::new();
/// let hand = world.spawn(Transform::from_xyz(0.7, 1.0, 0.0)).id();
/// // One corner of a grid with 30 columns stays, the next goes where the hand goes.
/// let pins = Pins::hold(Select::nodes([0])).and_carry(Select::nodes([29]), hand);
/// assert_eq!((pins.0[0].by, pins.0[1].by), (None, Some(hand)));
/// ```
#[derive(Component, Clone, Debug, Default)]
pub struct Pins(pub Vec<Pinned>);

/// Nodes that are held: by a pin of the scene format, and by an entity where there is one.
///
/// ```
/// use bevy_taffeta::{Pinned, prelude::*};
/// use bevy_taffeta::taffeta::scene::{Keyframe, Pin};
///
/// // The first row rises by 0.2 m in a second, and lets go of what is pulled harder than 5 N.
/// let motion = vec![Keyframe::translate(1.0, [0.0, 0.2, 0.0])];
/// let pin = Pin { select: Select::rows(0, 0), motion, break_force: Some(5.0), ..Pin::default() };
/// let pins = Pins(vec![Pinned { pin, by: None }]);
/// assert_eq!(pins.0[0].pin.break_force, Some(5.0));
/// ```
#[derive(Clone, Debug)]
pub struct Pinned {
    /// Which nodes, and how they move by themselves.
    pub pin: Pin,
    /// The entity whose transform carries them, from where they start.
    pub by: Option<Entity>,
}

impl Pins {
    /// Nodes that stay where they start.
    pub fn hold(select: Select) -> Self {
        Self::default().and_hold(select)
    }

    /// Nodes that an entity carries.
    pub fn carry(select: Select, by: Entity) -> Self {
        Self::default().and_carry(select, by)
    }

    /// More nodes that stay where they start.
    pub fn and_hold(mut self, select: Select) -> Self {
        self.0.push(Pinned { pin: Pin { select, ..Pin::default() }, by: None });
        self
    }

    /// More nodes that an entity carries.
    pub fn and_carry(mut self, select: Select, by: Entity) -> Self {
        self.0.push(Pinned { pin: Pin { select, ..Pin::default() }, by: Some(by) });
        self
    }
}

/// Where a body starts in the coordinates of its transform, as a scene file has it, in 64 bits.
///
/// ```
/// use bevy_taffeta::taffeta::scene::Place;
/// use bevy_taffeta::{BodyPlace, prelude::*};
///
/// // A mesh in centimetres.
/// let place = BodyPlace(Place { scale: Some(0.01), ..Place::default() });
/// assert_eq!(place.0.position, [0.0; 3]);
/// ```
#[derive(Component, Clone, Debug, Default)]
pub struct BodyPlace(pub Place);

/// How a body moves at the start, in the coordinates of its transform; nodes that pins hold start at rest.
///
/// ```
/// use bevy_taffeta::BodyVelocity;
///
/// // Thrown, with a spin of a turn a second about the vertical.
/// let thrown = BodyVelocity { linear: [2.0, 3.0, 0.0], angular: [0.0, std::f64::consts::TAU, 0.0] };
/// assert!(thrown.angular[1] > BodyVelocity::default().angular[1]);
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyVelocity {
    /// [m/s]
    pub linear: [f64; 3],
    /// About the centre of mass [rad/s].
    pub angular: [f64; 3],
}

/// The components of a body of a scene.
#[derive(Bundle)]
pub struct SceneBody {
    material: SoftMaterial,
    pins: Pins,
    place: BodyPlace,
    velocity: BodyVelocity,
}

impl SceneBody {
    /// Those of a body; `None` where its mass is not given in one way.
    pub fn of(body: &Body) -> Option<Self> {
        // All fields by name, so that none is forgotten when the scene format gains one.
        let Body {
            name: _,
            kind: _,
            node_mass: _,
            mass: _,
            area_density: _,
            density: _,
            mesh: _,
            fill_holes: _,
            rest_shape: _,
            stand_in: _,
            place,
            velocity,
            angular_velocity,
            springs,
            material,
            volume,
            self_collision,
            layers,
            pins,
            tethers,
        } = body;
        let material = SoftMaterial {
            mass: body.mass_given()?,
            springs: springs.clone(),
            fabric: material.clone(),
            volume: volume.clone(),
            self_collision: self_collision.clone(),
            layers: *layers,
            tethers: *tethers,
        };
        Some(Self {
            material,
            pins: Pins(pins.iter().map(|pin| Pinned { pin: pin.clone(), by: None }).collect()),
            place: BodyPlace(place.clone()),
            velocity: BodyVelocity { linear: *velocity, angular: *angular_velocity },
        })
    }
}

impl SoftMaterial {
    /// What a body of a scene is made of; `None` where its mass is not given in one way.
    pub fn of(body: &Body) -> Option<Self> {
        SceneBody::of(body).map(|body| body.material)
    }

    /// A body of a scene that is made of it.
    pub fn put(&self, body: Body) -> Body {
        let weighed = body.with_mass(self.mass);
        let mut body = Body {
            springs: self.springs.clone(),
            material: self.fabric.clone(),
            volume: self.volume.clone(),
            self_collision: self.self_collision.clone(),
            layers: self.layers,
            tethers: self.tethers,
            ..weighed
        };
        // A fabric's own mass is not said twice.
        let own = body.area_density.take();
        if own != self.fabric.as_ref().map(|fabric| fabric.fabric().density) {
            body.area_density = own;
        }
        body
    }
}
