//! Contact: of nodes with colliders, with meshes among them, and with each other, and of surfaces.

pub mod clusters;
pub mod collider_mesh;
pub mod colliders;
pub mod friction;
pub mod layers;
pub mod nodes;
pub mod triangles;

#[cfg(feature = "gpu")]
use crate::advice::{Advice, Refusal};
use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::scene::{Body, ContactForm, Scene, SceneError, plain};

impl BodyAssembly {
    /// Where a scene describes the contacts that it finds beside those with colliders, if it finds any.
    pub fn contact_key(&self) -> Option<&'static str> {
        (self.self_contact().is_some() || self.surface_contact().is_some()).then_some("self_collision")
    }

    /// Enables what the description asks for. Springs are known.
    pub(crate) fn enable_contact(&mut self, body: &Body) -> Result<(), SceneError> {
        body.self_collision.as_ref().map_or(Ok(()), |wish| match wish.form {
            ContactForm::Nodes => self.enable_self_collision(wish),
            ContactForm::Triangles => self.enable_surface_contact(wish),
        })
    }
}

impl Assembly {
    /// Warns of contacts at the start.
    pub(crate) fn note_start_contacts(&mut self, scene: &Scene) -> Result<(), SceneError> {
        self.check_surface_crowd(scene)?;
        self.note_close_nodes(scene)
    }

    /// The error of a distance that has too much within it: the largest that is kept, and what there is most of beside its owner.
    /// `thickness` is that of a body which has contact, with the zone that it is of [m].
    fn too_crowded<'a>(
        &'a self,
        scene: &Scene,
        thickness: impl Fn(&'a BodyAssembly) -> Option<(f64, Option<&'a str>)>,
        offsets: bool,
    ) -> SceneError {
        let mut kept = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            if let Some((thickness, zone)) = thickness(body) {
                let zone = zone.map_or(String::new(), |name| format!("zone.{name}."));
                let key = format!("body[{index}].self_collision.{zone}thickness");
                kept.push((
                    thickness,
                    key,
                    body.nodes,
                    format!("body `{}` has {} nodes", body.name, body.nodes),
                ));
            }
        }
        for (index, collider) in self.colliders().iter().enumerate().filter(|_| offsets) {
            if let Some(faces) = collider.faces().map(<[_]>::len) {
                let words = format!("collider `{}` has {faces} triangles", scene.collider_name(index));
                kept.push((collider.offset(), format!("collider[{index}].offset"), faces, words));
            }
        }
        kept.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (distance, key) = kept.first().map_or((0.0, ""), |(distance, key, ..)| (*distance, key));
        let most = kept.iter().skip(1).max_by_key(|other| other.2);
        let message = format!(
            "is {} m, and there are too many pairs of triangles or nodes within that distance at the start{}; 0.002 to 0.005 m \
             is usual for cloth (mm are divided by 1000), or coarser meshes would do",
            plain(distance),
            most.map_or(String::new(), |(.., words)| format!(": {words}"))
        );
        SceneError::new(key, message)
    }
}

/// Refuses bodies that may touch each other and are in several partitions of a GPU. `touches` says which bodies touch others.
#[cfg(feature = "gpu")]
fn check_in_one_piece(
    assembly: &Assembly,
    partitions: &[std::ops::Range<usize>],
    limit: u64,
    touches: impl Fn(usize) -> bool,
) -> Result<(), Refusal> {
    let mut with = partitions.iter().filter_map(|bodies| bodies.clone().find(|&body| touches(body)));
    let (Some(one), Some(other)) = (with.next(), with.next()) else { return Ok(()) };
    let message = format!(
        "bodies `{}` and `{}` have self_collision and may touch each other, and the GPU does not give a kernel enough to hold \
         both: {limit} bytes in one piece; the CPU or coarser meshes would do",
        assembly.bodies[one].name, assembly.bodies[other].name
    );
    Err(Refusal::new(message, [Advice::Cpu]))
}
