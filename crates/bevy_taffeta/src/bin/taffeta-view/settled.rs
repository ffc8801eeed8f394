//! When all that is drawn can be drawn: what lacks a shader or a pipeline is left out until then.

use bevy::prelude::*;
use bevy::render::render_resource::{CachedPipelineState, PipelineCache};
use bevy::render::{Render, RenderApp, RenderSystems};
use std::sync::{Arc, Mutex, PoisonError};

/// Frames in a row in which no pipeline is made or waited for.
const CALM: usize = 4;

/// How far the renderer is, seen from the app.
#[derive(Resource, Clone, Default)]
pub struct Settled(Arc<Mutex<Progress>>);

#[derive(Default)]
struct Progress {
    calm: usize,
    known: usize,
    error: Option<String>,
}

impl Settled {
    /// Whether all that is drawn can be drawn.
    ///
    /// # Errors
    /// Why that will never be.
    pub fn is_reached(&self) -> Result<bool, String> {
        let progress = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        progress
            .error
            .clone()
            .map_or(Ok(progress.calm >= CALM), |error| Err(format!("the GPU cannot draw the scene: {error}")))
    }
}

/// Watches the renderer, which must be there.
pub fn settled(app: &mut App) {
    let settled = Settled::default();
    app.insert_resource(settled.clone());
    app.sub_app_mut(RenderApp)
        .insert_resource(settled)
        .add_systems(Render, watch.after(RenderSystems::Render));
}

fn watch(settled: Res<Settled>, pipelines: Res<PipelineCache>) {
    let mut progress = settled.0.lock().unwrap_or_else(PoisonError::into_inner);
    let (mut count, mut waits, mut error) = (0, pipelines.waiting_pipelines().next().is_some(), None);
    for pipeline in pipelines.pipelines() {
        count += 1;
        match &pipeline.state {
            CachedPipelineState::Ok(_) => (),
            CachedPipelineState::Err(why) => error = Some(why.to_string()),
            _ => waits = true,
        }
    }
    progress.calm = if waits || count != progress.known { 0 } else { progress.calm + 1 };
    progress.known = count;
    // A shader that is still being read is an error, too, until it is tried again.
    progress.error = if waits { None } else { error };
}
