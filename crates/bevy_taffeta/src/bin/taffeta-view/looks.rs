//! How the scene is drawn: what its colours say, which lines are drawn, and what that needs of the engine.

use crate::busy::Busy;
use crate::stage::StageRoot;
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::springs::SpringKind;
use bevy_taffeta::{DrawMethod, Running};

/// How the scene is drawn.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Looks {
    /// What colours say.
    pub colouring: Colouring,
    /// Whether bodies are drawn as surfaces.
    pub surfaces: bool,
    /// Whether colliders are drawn.
    pub colliders: bool,
    /// Which lines are drawn.
    pub lines: [bool; 5],
}

/// What the colours of bodies say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colouring {
    /// Nothing.
    #[default]
    Plain,
    /// How far springs at a vertex are beyond their length at rest, the farthest of them.
    Strain,
    /// How fast vertices are.
    Velocity,
    /// How far vertices are from colliders.
    Contact,
}

impl Colouring {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Plain, Self::Strain, Self::Velocity, Self::Contact];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Strain => "strain",
            Self::Velocity => "velocity",
            Self::Contact => "contact",
        }
    }

    /// What a legend says, and what a number of it is to be multiplied by.
    pub fn legend(self) -> (&'static str, f32) {
        match self {
            Self::Plain => ("", 1.0),
            Self::Strain => ("longest spring beyond rest [%]", 100.0),
            Self::Velocity => ("speed [m/s]", 1.0),
            Self::Contact => ("gap to colliders [mm]", 1000.0),
        }
    }
}

/// Lines that may be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lines {
    /// Edges of triangles.
    Edges,
    /// Springs of a kind.
    Springs(SpringKind),
}

impl Lines {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Edges,
        Self::Springs(SpringKind::Structural),
        Self::Springs(SpringKind::Shear),
        Self::Springs(SpringKind::Bend),
        Self::Springs(SpringKind::Internal),
    ];

    /// Their name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Edges => "wireframe",
            Self::Springs(kind) => kind.name(),
        }
    }

    /// Their colour, in sRGB.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Self::Edges => [30, 34, 40],
            Self::Springs(SpringKind::Structural) => [20, 90, 200],
            Self::Springs(SpringKind::Shear) => [0, 150, 80],
            Self::Springs(SpringKind::Bend) => [215, 90, 0],
            Self::Springs(SpringKind::Internal) => [160, 40, 160],
        }
    }
}

impl Default for Looks {
    fn default() -> Self {
        Self { colouring: Colouring::Plain, surfaces: true, colliders: true, lines: [false; 5] }
    }
}

impl Looks {
    /// Whether it takes positions on the host.
    pub fn needs_copies(&self) -> bool {
        self.colouring != Colouring::Plain || self.lines.contains(&true)
    }
}

/// How the scene is drawn, by keys and panel.
pub fn looks(app: &mut App) {
    app.init_resource::<Looks>().add_systems(Update, (keys, draw_as_needed, hide).chain());
}

fn keys(keys: Res<ButtonInput<KeyCode>>, busy: Res<Busy>, mut looks: ResMut<Looks>) {
    if busy.keys {
        return;
    }
    if keys.just_pressed(KeyCode::KeyC) {
        let all = Colouring::ALL;
        let at = all.iter().position(|one| *one == looks.colouring).unwrap_or(0);
        looks.colouring = all[(at + 1) % all.len()];
    }
    if keys.just_pressed(KeyCode::KeyW) {
        looks.lines[0] = !looks.lines[0];
    }
}

/// Positions come to the host only while something needs them there.
fn draw_as_needed(looks: Res<Looks>, mut worlds: Query<(&mut RunOn, &Running), With<StageRoot>>) {
    let wanted = if looks.needs_copies() { DrawMethod::Copied } else { DrawMethod::Shared };
    for (mut on, running) in &mut worlds {
        // From the CPU they are copied in any case.
        if on.draw != wanted && running.simulation().backend() == "gpu" {
            on.draw = wanted;
        }
    }
}

type Shown<'w, 's> =
    Query<'w, 's, (&'static mut Visibility, Has<SoftCollider>), Or<(With<SoftMaterial>, With<SoftCollider>)>>;

fn hide(looks: Res<Looks>, mut shown: Shown) {
    for (mut visibility, is_collider) in &mut shown {
        let wanted = if is_collider { looks.colliders } else { looks.surfaces };
        visibility.set_if_neq(if wanted { Visibility::Inherited } else { Visibility::Hidden });
    }
}
