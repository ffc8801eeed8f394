//! Room for panels: which there are, and what of the window they leave.

use bevy::prelude::*;
use bevy_egui::egui::{self, Ui};

/// Which panels there are.
#[derive(Resource)]
pub struct Shown {
    /// The values, at the right.
    pub values: bool,
    /// The plots, below.
    pub plots: bool,
}

impl Default for Shown {
    fn default() -> Self {
        Self { values: true, plots: true }
    }
}

/// The part of the window that no panel has taken yet.
#[derive(Resource)]
pub struct Left(pub Option<Ui>);

impl Left {
    /// Shows a panel in it.
    pub fn show(&mut self, panel: egui::Panel, job: impl FnOnce(&mut Ui)) {
        if let Some(ui) = &mut self.0 {
            panel.show(ui, job);
        }
    }
}
