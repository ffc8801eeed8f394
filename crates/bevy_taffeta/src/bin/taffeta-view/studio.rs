//! An app that renders a scene into pictures, without a window and without a clock.

use crate::args::Args;
use crate::settled::{Settled, settled};
use crate::stage::{self, Opened, Pipelines, StageCamera, StagePlugin, StageRoot};
use bevy::app::{PluginsState, TerminalCtrlCHandlerPlugin};
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_taffeta::Running;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta_io::program::Failure;
use bevy_taffeta::taffeta_io::program::advised;
use std::collections::BTreeMap;

/// Updates after which what has not come will not come.
const PATIENCE: usize = 5000;

/// An app that renders into pictures.
pub struct Studio {
    app: App,
    canvas: Handle<Image>,
    /// Pictures that were asked for, and handed out.
    asked: usize,
    handed: usize,
}

/// Pictures that have come and were not handed out, by number: rows of RGBA.
#[derive(Resource, Default)]
struct Taken(BTreeMap<usize, Vec<u8>>);

/// Why the simulation cannot go on, in the engine's words.
#[derive(Resource, Default)]
struct Halted(Option<String>);

impl Studio {
    /// Puts the scene on stage, in its first state.
    pub fn open(args: &Args, opened: &Opened) -> Result<Self, Failure> {
        let mut app = App::new();
        let window =
            WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
        // What is logged of a simulation is said in our own words; which adapter it is, too.
        let filter = "warn,bevy_taffeta=off,bevy_render::renderer=error,bevy_render::view::window=off".into();
        let log = LogPlugin { filter, ..default() };
        let plugins = DefaultPlugins.set(window).set(log).set(stage::renderer(Pipelines::First)?);
        app.add_plugins(
            plugins
                .disable::<WinitPlugin>()
                .disable::<PipelinedRenderingPlugin>()
                .disable::<TerminalCtrlCHandlerPlugin>(),
        );
        let [width, height] = args.size;
        let image = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
        let canvas = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        let mut stage = StagePlugin::new(args, opened, canvas.clone().into());
        stage.playback.paused = true;
        // Every frame is looked at: what goes wrong is found before its picture is kept.
        stage.on.report_every = 1;
        app.add_plugins((stage, settled))
            .init_resource::<Taken>()
            .init_resource::<Halted>()
            .add_systems(Last, listen);
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        let mut studio = Self { app, canvas, asked: 0, handed: 0 };
        studio.settle()?;
        Ok(studio)
    }

    /// Lets time stand still until all pipelines are made.
    fn settle(&mut self) -> Result<(), Failure> {
        for _ in 0..PATIENCE {
            self.update().map_err(Failure::Input)?;
            if self.app.world().resource::<Settled>().is_reached().map_err(Failure::Work)? {
                return Ok(());
            }
        }
        Err(Failure::Work("timed out waiting for the GPU to draw the scene".into()))
    }

    fn update(&mut self) -> Result<(), String> {
        self.app.update();
        self.app.world_mut().resource_mut::<Halted>().0.take().map_or(Ok(()), Err)
    }

    /// The device of the simulation, in words.
    pub fn device(&mut self) -> String {
        let mut all = self.app.world_mut().query::<&Running>();
        all.iter(self.app.world()).next().map_or_else(String::new, |one| one.simulation().device())
    }

    /// Simulates one more frame.
    fn advance(&mut self) {
        let mut all = self.app.world_mut().query_filtered::<&mut Playback, With<StageRoot>>();
        for mut playback in all.iter_mut(self.app.world_mut()) {
            playback.single_frames = 1;
        }
    }

    /// Simulates a frame that is not drawn.
    pub fn pass(&mut self) -> Result<(), String> {
        self.draw(false);
        self.advance();
        let result = self.update();
        self.draw(true);
        result
    }

    fn draw(&mut self, on: bool) {
        let mut all = self.app.world_mut().query_filtered::<&mut Camera, With<StageCamera>>();
        for mut camera in all.iter_mut(self.app.world_mut()) {
            camera.is_active = on;
        }
    }

    /// Takes a picture of the scene as it is, or as it is a frame later. It comes later.
    pub fn shoot(&mut self, later: bool) -> Result<(), String> {
        if later {
            self.advance();
        }
        let number = self.asked;
        self.app.world_mut().spawn(Screenshot::image(self.canvas.clone())).observe(
            move |captured: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| {
                taken.0.insert(number, captured.image.data.clone().unwrap_or_default());
            },
        );
        // A picture of a frame that went wrong does not count.
        self.update()?;
        self.asked += 1;
        Ok(())
    }

    /// Pictures that have come, in order.
    pub fn taken(&mut self) -> Vec<Vec<u8>> {
        let mut taken = self.app.world_mut().resource_mut::<Taken>();
        let mut pictures = Vec::new();
        while self.handed < self.asked
            && let Some(picture) = taken.0.remove(&self.handed)
        {
            pictures.push(picture);
            self.handed += 1;
        }
        pictures
    }

    /// Pictures that are still to come, in order.
    pub fn rest(&mut self) -> Vec<Vec<u8>> {
        let mut pictures = self.taken();
        for _ in 0..PATIENCE {
            if self.handed == self.asked {
                break;
            }
            self.app.update();
            pictures.extend(self.taken());
        }
        pictures
    }
}

/// Listens for what goes wrong; what went wrong first counts.
fn listen(
    mut diverged: MessageReader<Diverged>,
    mut refused: MessageReader<Refused>,
    mut halted: ResMut<Halted>,
) {
    let refused = refused.read().map(|one| advised(&one.error, one.error.advice()));
    let said = refused.chain(diverged.read().map(|one| advised(&one.error, one.error.advice()))).next();
    halted.0 = halted.0.take().or(said);
}
