//! A window that shows a scene.

use crate::args::Args;
use crate::failure::Failure;
use crate::stage::{self, Opened, StagePlugin};
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::window::WindowResolution;

/// Opens a window on a scene.
pub fn run(args: &Args, opened: Opened) -> Result<(), Failure> {
    let [width, height] = args.size;
    let window = Window {
        title: format!("taffeta: {}", args.scene.display()),
        resolution: WindowResolution::new(width, height),
        ..default()
    };
    let window = WindowPlugin { primary_window: Some(window), ..default() };
    let stage = StagePlugin::new(args, &opened, RenderTarget::default());
    match App::new().add_plugins((DefaultPlugins.set(window).set(stage::renderer()?), stage)).run() {
        AppExit::Success => Ok(()),
        AppExit::Error(code) => Err(Failure::Work(format!("the window closed with code {code}"))),
    }
}
