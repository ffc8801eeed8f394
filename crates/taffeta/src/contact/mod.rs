//! Contact: of nodes with colliders, with meshes among them, and with each other.

pub mod collider_mesh;
pub mod colliders;
pub mod nodes;

use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::scene::{Body, SceneError};
use nodes::self_contact::SelfContact;

/// What bodies find contacts of, beside colliders.
#[derive(Default)]
pub struct BodyContact {
    /// Their nodes, with each other and with those of other bodies that have this.
    pub nodes: Option<SelfContact>,
}

impl BodyContact {
    /// Where a scene describes it, if the body finds any contacts.
    pub fn key(&self) -> Option<&'static str> {
        self.nodes.is_some().then_some("self_collision")
    }
}

impl BodyAssembly {
    /// Enables what the description asks for. Springs are known.
    pub(crate) fn enable_contact(&mut self, body: &Body) -> Result<(), SceneError> {
        body.self_collision.as_ref().map_or(Ok(()), |wish| self.enable_self_collision(wish))
    }
}

impl Assembly {
    /// Warns of contacts at the start.
    pub(crate) fn note_start_contacts(&mut self) {
        self.note_close_nodes();
    }
}
