//! What cannot be simulated, while the rest of its world is.

use crate::build::Members;
use crate::pose::place_in_world;
use crate::running::{Carried, Running, RunningBody, RunningCollider};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use taffeta::BuildError;
use taffeta::scene::{Body, Collider, Keyframe};

/// What was refused of a world when it was built last. The next time all are tried again: an error may be about two of them.
#[derive(Default)]
pub struct Refusals {
    /// Bodies and colliders that it is built without, or as they were, and what is wrong with each.
    entities: HashMap<Entity, Refusal>,
    /// What is wrong with the world itself.
    whole: Option<String>,
    /// What it had when it could not be built at all.
    pub unbuilt: Option<Members>,
}

/// What is wrong with a body or collider.
struct Refusal {
    what: String,
    /// Whether it cannot be as it was either.
    is_out: bool,
}

impl Refusals {
    /// Whether an entity is among them.
    pub fn has(&self, entity: Entity) -> bool {
        self.entities.contains_key(&entity)
    }

    /// Whether an entity cannot be as it was either, or was not there.
    pub fn is_out(&self, entity: Entity) -> bool {
        self.entities.get(&entity).is_some_and(|refusal| refusal.is_out)
    }

    /// All of them.
    pub fn entities(&self) -> impl Iterator<Item = Entity> {
        self.entities.keys().copied()
    }

    /// Adds what is wrong with an entity, or with the world where there is none; `runs`: whether it can be tried as it was. Returns
    /// whether that is new.
    pub fn add(&mut self, entity: Option<Entity>, error: &BuildError, runs: bool) -> bool {
        let Some(entity) = entity else {
            self.whole = Some(without_number(error));
            return true;
        };
        match self.entities.get_mut(&entity) {
            Some(refusal) => {
                refusal.is_out = true;
                false
            }
            None => {
                let what = without_number(error);
                self.entities.insert(entity, Refusal { what, is_out: !runs });
                true
            }
        }
    }

    /// Whether the same was wrong.
    pub fn has_said(&self, entity: Option<Entity>, error: &BuildError) -> bool {
        let said = match entity {
            Some(entity) => self.entities.get(&entity).map(|refusal| &refusal.what),
            None => self.whole.as_ref(),
        };
        said == Some(&without_number(error))
    }
}

/// What is wrong, without the number of the body or collider: that depends on which others are there.
fn without_number(error: &BuildError) -> String {
    let text = error.to_string();
    match text.split_once(']') {
        Some((_, rest)) if matches!(error, BuildError::Scene(_)) => rest.to_owned(),
        _ => text,
    }
}

/// The body or collider that an error is about, among those of the scene.
pub fn named(error: &BuildError, bodies: &[Entity], colliders: &[Entity]) -> Option<Entity> {
    let BuildError::Scene(error) = error else { return None };
    [("body[", bodies), ("collider[", colliders)].into_iter().find_map(|(kind, all)| {
        let (index, _) = error.path.strip_prefix(kind)?.split_once(']')?;
        all.get(index.parse::<usize>().ok()?).copied()
    })
}

impl Carried {
    /// Where its pins are, as the only keyframe: they can be moved from there.
    pub fn keyframe(&self) -> Keyframe {
        self.track.moved().keyframe()
    }
}

impl Running {
    /// Whether an entity is one of its bodies or colliders.
    pub fn has(&self, entity: Entity) -> bool {
        let bodies = self.bodies.iter().map(|one| one.entity);
        bodies.chain(self.colliders.iter().map(|one| one.entity)).any(|one| one == entity)
    }

    /// A body of it, to be built again as it is here.
    pub fn body_as_it_is(&self, entity: Entity) -> Option<(Body, RunningBody)> {
        let index = self.bodies.iter().position(|one| one.entity == entity)?;
        let (mut body, running) = (self.scene.bodies[index].clone(), self.bodies[index].again());
        for carried in &running.carried {
            body.pins[carried.pin].motion = vec![carried.keyframe()];
        }
        Some((body, running))
    }

    /// A collider of it, where its entity was seen last. One on keyframes stays on them.
    pub fn collider_as_it_is(&self, entity: Entity) -> Option<(Collider, RunningCollider)> {
        let index = self.colliders.iter().position(|one| one.entity == entity)?;
        let (mut collider, running) = (self.scene.colliders[index].clone(), &self.colliders[index]);
        let mut track = running.track;
        if !running.keyed {
            let moved = track.moved().transform(Vec3::ONE);
            collider.place = place_in_world(&moved.into(), &collider.place);
            track = track.restarted();
        }
        Some((collider, RunningCollider { track, shown: None, ..*running }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taffeta::scene::SceneError;

    #[test]
    fn errors_name_an_entity_by_its_number_in_the_scene() {
        let all: Vec<Entity> = (1..=12).map(|index| Entity::from_raw_u32(index).unwrap()).collect();
        let (bodies, colliders) = all.split_at(11);
        let of = |path: &str| named(&SceneError::new(path, "").into(), bodies, colliders);
        assert_eq!([of("body[10].pin[1]"), of("collider[0]")], [Some(all[10]), Some(all[11])]);
        assert_eq!([of("body[11].pin"), of("time.dt"), of("body"), of("seam[0]")], [None; 4]);
        assert_eq!(named(&BuildError::Lost(String::new()), bodies, colliders), None);
    }
}
