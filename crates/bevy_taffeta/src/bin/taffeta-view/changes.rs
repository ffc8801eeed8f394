//! Values that the user changes, until the simulation takes them up.

use crate::busy::Busy;
use crate::stage::StageRoot;
use bevy::ecs::component::Mutable;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;
use bevy_taffeta::Running;
use bevy_taffeta::prelude::*;

/// Longest time for building a simulation again while a slider is dragged [s]: what takes longer waits for its last value.
const AT_ONCE: f64 = 1.0 / 30.0;

/// What has a value that the simulation does not have yet.
#[derive(Resource)]
pub struct Changes {
    /// Entities with such values.
    pub waiting: HashSet<Entity>,
    /// Longest time for building again with every value on the way [s].
    pub at_once: f64,
}

impl Default for Changes {
    fn default() -> Self {
        Self { waiting: HashSet::default(), at_once: AT_ONCE }
    }
}

/// Taking up what was changed.
pub fn changes(app: &mut App) {
    app.init_resource::<Changes>().add_systems(PostUpdate, take_up.before(TaffetaSystems::Build));
}

/// Has the simulation built again, with the values as they are: at once, or when the user is done with them.
fn take_up(
    mut changes: ResMut<Changes>,
    busy: Res<Busy>,
    running: Query<&Running, With<StageRoot>>,
    mut worlds: Query<&mut SoftWorld>,
    mut materials: Query<&mut SoftMaterial>,
    mut colliders: Query<&mut SoftCollider>,
) {
    let slow = running.iter().any(|running| running.timing().build > changes.at_once);
    if changes.waiting.is_empty() || busy.edits && slow {
        return;
    }
    for entity in std::mem::take(&mut changes.waiting) {
        mark(&mut worlds, entity);
        mark(&mut materials, entity);
        mark(&mut colliders, entity);
    }
}

fn mark<C: Component<Mutability = Mutable>>(all: &mut Query<&mut C>, entity: Entity) {
    if let Ok(mut one) = all.get_mut(entity) {
        one.set_changed();
    }
}
