//! A window that shows a scene: what can be seen, and what can be done with mouse and keys.

use crate::args::Args;
use crate::busy::Busy;
use crate::plots::history;
use crate::save::{Source, saved};
use crate::settled::{Settled, settled};
use crate::stage::{self, Opened, Pipelines, StagePlugin};
use crate::{changes, colours, grab, looks, orbit, panel, play, save, wires};
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::window::WindowResolution;
use bevy_taffeta::taffeta_io::program::Failure;
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;

/// Frames from one report of a simulation on a shared device to the next: plots need some.
const REPORTS: u32 = 6;

/// Opens a window on a scene.
pub fn run(args: &Args, opened: Opened) -> Result<(), Failure> {
    let [width, height] = args.size;
    let window = Window {
        title: format!("taffeta: {}", args.scene.display()),
        resolution: WindowResolution::new(width, height),
        ..default()
    };
    let window = WindowPlugin { primary_window: Some(window), ..default() };
    let mut stage = StagePlugin::new(args, &opened, RenderTarget::default());
    stage.on.report_every = REPORTS;
    let source = Source::read(&args.scene, &args.sets).map_err(Failure::Input)?;
    let mut app = App::new();
    let plugins = DefaultPlugins.set(window).set(stage::renderer(Pipelines::Meanwhile)?);
    unless_it_panics(|| _ = app.add_plugins((plugins, stage, settled, hands, panel::panel)))?;
    app.insert_resource(source);
    if let Some(updates) = args.exit_after {
        app.insert_resource(Ending { updates, picture: args.window_picture.clone(), seen: 0 })
            .add_systems(Last, end);
    }
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(code) if code.get() == INTERRUPTED => {
            Err(Failure::Interrupted("interrupted".to_owned()))
        }
        AppExit::Error(_) => Err(Failure::Work("the window closed with an error".to_owned())),
    }
}

/// Where there is no display Bevy panics while the app is put together.
fn unless_it_panics(job: impl FnOnce()) -> Result<(), Failure> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let result = panic::catch_unwind(AssertUnwindSafe(job));
    panic::set_hook(hook);
    result.map_err(|payload| {
        let why = payload.downcast_ref::<String>().map_or("Bevy does not say why", |why| why);
        let would_do = "a display would do, or --record and --picture, which need none";
        Failure::Input(format!("no window can be opened: {why}; {would_do}"))
    })
}

/// With this Bevy ends an app on Ctrl-C.
const INTERRUPTED: u8 = 130;

/// All that needs no panel.
pub fn hands(app: &mut App) {
    app.init_resource::<Busy>();
    app.add_plugins((
        looks::looks,
        play::play,
        changes::changes,
        history,
        orbit::orbit,
        grab::grab,
        colours::colours,
        wires::wires,
        save::save,
    ));
}

/// When the window closes by itself, and what is kept of it.
#[derive(Resource)]
struct Ending {
    updates: u32,
    picture: Option<PathBuf>,
    seen: u32,
}

/// Closes the window when it is time, with a picture of it, if that is wanted.
fn end(
    mut commands: Commands,
    mut ending: ResMut<Ending>,
    settled: Res<Settled>,
    mut exit: MessageWriter<AppExit>,
) {
    match settled.is_reached() {
        // What cannot be drawn yet is no update that anybody saw.
        Ok(false) if ending.seen == 0 => return,
        Ok(_) => ending.seen += 1,
        Err(why) => {
            error!("{why}");
            exit.write(AppExit::error());
            return;
        }
    }
    if ending.seen != ending.updates {
        return;
    }
    let Some(path) = ending.picture.clone() else {
        exit.write(AppExit::Success);
        return;
    };
    // What is there from before does not count.
    let _ = std::fs::remove_file(&path);
    commands.spawn(Screenshot::primary_window()).observe(
        move |captured: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
            save_to_disk(&path)(captured);
            match saved(&path) {
                Ok(words) => {
                    crate::say(&words);
                    exit.write(AppExit::Success);
                }
                Err(words) => {
                    error!("{words}");
                    exit.write(AppExit::error());
                }
            }
        },
    );
}

#[cfg(test)]
mod tests;
