//! A simulation's settings: what acts in it, how it is solved, when it runs and on what.

use bevy::prelude::*;
use taffeta::OnDivergence;
use taffeta::scene::{Force, Friction, Seam, Sleep, Solver, Time};

/// A simulation of its own: the bodies and colliders below this entity. How long its steps are and how they are solved.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{prelude::*, taffeta::scene};
///
/// /// A room of its own, whose bodies touch none outside of it.
/// fn room(mut commands: Commands) {
///     let time = scene::Time { dt: 1.0 / 120.0, max_step: Some(5e-4), ..default() };
///     let room = (SoftWorld { time, ..default() }, Transform::from_xyz(5.0, 0.0, 0.0));
///     commands.spawn(room).with_children(|room| {
///         room.spawn((Cloth::grid(20, 30, Vec2::new(1.5, 1.0)), Transform::from_xyz(0.0, 1.0, 0.0)));
///         room.spawn(SoftCollider::ground());
///     });
/// }
/// assert_eq!(SoftWorld::default().time.substeps(), 17);
/// ```
#[derive(Component, Clone, Debug)]
#[require(Environment, Playback, RunOn, Transform, Visibility)]
pub struct SoftWorld {
    /// Steps: `dt` [s] is a frame of the simulation, in sub-steps of at most `max_step` [s].
    pub time: Time,
    /// How springs are solved.
    pub solver: Solver,
    /// When bodies at rest fall asleep; without it none does.
    pub sleep: Option<Sleep>,
    /// Point loads and torques, on bodies by name.
    pub forces: Vec<Force>,
    /// Nodes sewn to nodes, of bodies by name.
    pub seams: Vec<Seam>,
    /// Friction of pairs of bodies, and of bodies and colliders, by name.
    pub frictions: Vec<Friction>,
}

impl Default for SoftWorld {
    /// Sixty frames a second, in sub-steps of a millisecond.
    fn default() -> Self {
        let time = Time { max_step: Some(1e-3), ..Time::default() };
        Self {
            time,
            solver: Solver::default(),
            sleep: None,
            forces: Vec::new(),
            seams: Vec::new(),
            frictions: Vec::new(),
        }
    }
}

/// The world of all bodies and colliders that are below no other.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{DefaultWorld, prelude::*};
///
/// fn on_the_moon(mut environment: Single<&mut Environment, With<DefaultWorld>>) {
///     environment.gravity = [0.0, -1.62, 0.0];
/// }
/// ```
#[derive(Component, Clone, Copy, Debug)]
pub struct DefaultWorld;

/// Gravity, drag, wind and air of a [`SoftWorld`].
///
/// ```
/// use bevy_taffeta::prelude::*;
/// use bevy_taffeta::taffeta::scene;
///
/// // A breeze of 3 m/s along x.
/// let air = Air { velocity: [3.0, 0.0, 0.0], ..Air::default() };
/// let mut environment = Environment(scene::World { air: Some(air), ..scene::World::default() });
/// environment.drag = 1e-4;
/// assert_eq!(environment.gravity, [0.0, -9.81, 0.0]);
/// ```
#[derive(Component, Clone, Debug, Default, Deref, DerefMut)]
pub struct Environment(pub taffeta::scene::World);

/// When a [`SoftWorld`] runs.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn by_keys(keys: Res<ButtonInput<KeyCode>>, mut worlds: Query<&mut Playback>) {
///     for mut playback in &mut worlds {
///         if keys.just_pressed(KeyCode::Space) {
///             playback.paused = !playback.paused;
///         }
///         if keys.just_pressed(KeyCode::KeyN) {
///             playback.single_frames += 1;
///         }
///         playback.speed = if keys.pressed(KeyCode::ShiftLeft) { 0.25 } else { 1.0 };
///     }
/// }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// Whether time stands still.
    pub paused: bool,
    /// Seconds that go by in it for each of Bevy's; less than 1 is slow motion.
    pub speed: f64,
    /// Frames that are still to be taken though it is paused; counts down.
    pub single_frames: u32,
    /// Most frames that are taken at once. What Bevy's clock asks for beyond is left out: the world is then slower than
    /// the clock.
    pub most_frames: u32,
    /// What carries pins, or is a collider, and is seen farther than this [m] from where its speed brings it is taken to be put
    /// elsewhere: a body of which it carries all pins is carried along at once, with what is sewn to it, and nothing is swept in
    /// between. So is what moves farther than this while the world stands still, or in time that is left out
    /// ([`Self::most_frames`]). A body that something else holds as well is pulled.
    pub teleport_beyond: f64,
}

impl Default for Playback {
    fn default() -> Self {
        Self { paused: false, speed: 1.0, single_frames: 0, most_frames: 4, teleport_beyond: 1.0 }
    }
}

/// What a [`SoftWorld`] computes on, and how its bodies come to be drawn.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{DefaultWorld, DeviceChoice, prelude::*};
///
/// fn on_two_threads(mut commands: Commands, world: Single<Entity, With<DefaultWorld>>) {
///     commands.entity(*world).insert(RunOn { device: DeviceChoice::Cpu, threads: Some(2), ..default() });
/// }
/// assert_eq!(RunOn::default().report_every, 120);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct RunOn {
    /// The device.
    pub device: DeviceChoice,
    /// The way to the screen.
    pub draw: DrawMethod,
    /// Threads on the CPU; `None`: as many as gain something.
    pub threads: Option<usize>,
    /// Frames from one report to the next where the device is shared. A report is read back, and the program waits for it;
    /// what is not finite is never drawn, whenever it is reported.
    pub report_every: u32,
    /// What becomes of the others where a body diverges: by default they go on, and it stands still ([`Frozen`](crate::Frozen)).
    pub on_divergence: OnDivergence,
}

impl Default for RunOn {
    /// A report every 120 frames: two seconds at sixty frames a second.
    fn default() -> Self {
        Self {
            device: DeviceChoice::default(),
            draw: DrawMethod::default(),
            threads: None,
            report_every: 120,
            on_divergence: OnDivergence::Freeze,
        }
    }
}

/// What to compute on.
///
/// ```
/// use bevy_taffeta::{DeviceChoice, prelude::*};
///
/// let on = RunOn { device: DeviceChoice::Gpu, ..RunOn::default() };
/// assert_ne!(on.device, DeviceChoice::default());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// Bevy's GPU where it is hardware and the scene fits it, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// Bevy's GPU, in software too.
    Gpu,
}

/// How bodies come to be drawn.
///
/// ```
/// use bevy_taffeta::{DrawMethod, prelude::*};
///
/// // A system reads the meshes of bodies in each frame, so they are to be in the main world.
/// let on = RunOn { draw: DrawMethod::Copied, ..RunOn::default() };
/// assert_eq!(on.draw, DrawMethod::Copied);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrawMethod {
    /// Where the simulation runs on Bevy's GPU, a compute shader writes places and normals to the buffer that Bevy draws.
    /// From the CPU they are copied.
    #[default]
    Shared,
    /// The mesh asset is changed in every frame.
    Copied,
}
