//! Which bodies and colliders meet, as their layers say.

use crate::assembly::Assembly;
use crate::scene::{Layers, Scene};

/// The layers of a scene.
#[derive(Clone, Debug, Default)]
pub struct Meetings {
    /// By body and by collider; empty where nothing is said, and all meet.
    bodies: Vec<Layers>,
    colliders: Vec<Layers>,
}

impl Meetings {
    fn new(scene: &Scene) -> Self {
        let bodies: Vec<Layers> = scene.bodies.iter().map(|body| body.layers).collect();
        let colliders: Vec<Layers> = scene.colliders.iter().map(|collider| collider.layers).collect();
        let is_said = bodies.iter().chain(&colliders).any(|layers| !layers.is_default());
        if is_said { Self { bodies, colliders } } else { Self::default() }
    }

    /// Whether all meet.
    pub fn all_meet(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Whether two bodies meet. Each meets itself.
    pub fn bodies(&self, a: usize, b: usize) -> bool {
        self.all_meet() || a == b || self.bodies[a].meets(&self.bodies[b])
    }

    /// Whether a body and a collider meet.
    pub fn collider(&self, body: usize, collider: usize) -> bool {
        self.all_meet() || self.bodies[body].meets(&self.colliders[collider])
    }

    /// The layers of a body.
    pub fn of_body(&self, body: usize) -> Layers {
        self.bodies.get(body).copied().unwrap_or_default()
    }

    /// The layers of a collider.
    pub fn of_collider(&self, collider: usize) -> Layers {
        self.colliders.get(collider).copied().unwrap_or_default()
    }
}

impl Assembly {
    /// Which bodies and colliders meet.
    pub fn meetings(&self) -> &Meetings {
        static ALL: std::sync::LazyLock<Meetings> = std::sync::LazyLock::new(Meetings::default);
        self.extensions.get().unwrap_or(&ALL)
    }

    /// Adds what a scene says of layers.
    pub(crate) fn add_meetings(&mut self, scene: &Scene) {
        let meetings = Meetings::new(scene);
        if !meetings.all_meet() {
            self.extensions.insert(meetings);
        }
    }
}
