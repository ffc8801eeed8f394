//! What panels take of mouse and keys.

use bevy::prelude::*;

/// What panels take for themselves; mouse and keys do nothing else then.
#[derive(Resource, Default)]
pub struct Busy {
    /// The mouse is on a panel.
    pub pointer: bool,
    /// Something is typed.
    pub keys: bool,
    /// A value is on its way to another: a slider is dragged, or something is typed.
    pub edits: bool,
}
