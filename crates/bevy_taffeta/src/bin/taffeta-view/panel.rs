//! Panels around the picture: playing and messages above, plots below, values at the right.

mod fields;
mod messages;
mod numbers;
mod room;
mod side;
mod top;
mod values;

use crate::busy::Busy;
use crate::save::Picture;
use crate::stage::StageCamera;
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{CameraOutputMode, Viewport};
use bevy::prelude::*;
use bevy::render::render_resource::BlendState;
use bevy::window::PrimaryWindow;
use bevy_egui::egui::{self, Color32, Context, CornerRadius, LayerId, Rect, Ui, UiBuilder};
use bevy_egui::{EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext};
use room::{Left, Shown};

/// Panels, and a camera for them.
pub fn panel(app: &mut App) {
    app.add_plugins(EguiPlugin::default())
        .init_resource::<Shown>()
        .insert_resource(EguiGlobalSettings { auto_create_primary_context: false, ..default() })
        .add_systems(Startup, spawn_camera)
        .add_systems(Update, keys)
        .add_systems(
            EguiPrimaryContextPass,
            (
                begin,
                top::show,
                messages::show,
                side::show,
                numbers::show,
                side::show_legend,
                side::show_waiting,
                end,
            )
                .chain(),
        );
}

/// A camera that draws panels alone, over the picture.
fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        PrimaryEguiContext,
        Camera2d,
        RenderLayers::none(),
        Camera {
            order: 1,
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::ALPHA_BLENDING),
                clear_color: ClearColorConfig::None,
            },
            clear_color: ClearColorConfig::Custom(Color::NONE),
            ..default()
        },
    ));
}

/// Tab hides the panels, and brings them back.
fn keys(keys: Res<ButtonInput<KeyCode>>, busy: Res<Busy>, mut shown: ResMut<Shown>) {
    if keys.just_pressed(KeyCode::Tab) && !busy.keys {
        let any = shown.values || shown.plots;
        (shown.values, shown.plots) = (!any, !any);
    }
}

fn begin(
    mut contexts: EguiContexts,
    mut commands: Commands,
    picture: Res<Picture>,
    mut styled: Local<bool>,
) -> Result {
    let context = contexts.ctx_mut()?;
    if !*styled {
        *styled = true;
        style(context);
    }
    let builder = UiBuilder::new().layer_id(LayerId::background()).max_rect(context.viewport_rect());
    let ui = (!picture.hides_panels()).then(|| Ui::new(context.clone(), "window".into(), builder));
    commands.insert_resource(Left(ui));
    Ok(())
}

fn style(context: &Context) {
    context.set_theme(egui::Theme::Light);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 4.0);
        style.spacing.indent = 12.0;
        style.visuals.panel_fill = Color32::from_rgb(246, 247, 249);
        style.visuals.widgets.noninteractive.corner_radius = CornerRadius::same(3);
        style.visuals.widgets.noninteractive.fg_stroke.color = Color32::from_rgb(40, 44, 52);
    });
}

/// Gives the rest of the window to the picture.
fn end(
    mut contexts: EguiContexts,
    left: Res<Left>,
    mut busy: ResMut<Busy>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut camera: Single<&mut Camera, With<StageCamera>>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let free = left.0.as_ref().map(Ui::available_rect_before_wrap);
    let at = context.input(|input| input.pointer.hover_pos());
    let over = |at: egui::Pos2| {
        let above = context.layer_id_at(at).is_some_and(|layer| layer.order != egui::Order::Background);
        above || free.is_some_and(|free| !free.contains(at))
    };
    let (drags, keys) = (context.egui_is_using_pointer(), context.text_edit_focused());
    *busy = Busy { pointer: drags || at.is_some_and(over), keys, edits: drags || keys };
    let viewport = free.and_then(|free| viewport(free, &window));
    let same = match (&camera.viewport, &viewport) {
        (Some(a), Some(b)) => {
            (a.physical_position, a.physical_size) == (b.physical_position, b.physical_size)
        }
        (None, None) => true,
        _ => false,
    };
    if !same {
        camera.viewport = viewport;
    }
    Ok(())
}

/// A part of the window, in its pixels; nothing where it has none.
fn viewport(free: Rect, window: &Window) -> Option<Viewport> {
    let scale = window.scale_factor();
    let whole = window.physical_size();
    let low = UVec2::new((free.min.x * scale) as u32, (free.min.y * scale) as u32).min(whole);
    let high = UVec2::new((free.max.x * scale) as u32, (free.max.y * scale) as u32).min(whole);
    let physical_size = high.saturating_sub(low);
    (physical_size.min_element() > 0).then(|| Viewport { physical_position: low, physical_size, ..default() })
}
