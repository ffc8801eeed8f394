//! Above the picture: playing, and how fast it goes.

use super::room::{Left, Shown};
use crate::play::{AsRead, Restart, step};
use crate::plots::History;
use crate::save::Save;
use crate::stage::StageRoot;
use bevy::prelude::*;
use bevy_egui::egui::{self, Panel, Slider, Ui};
use bevy_taffeta::Running;
use bevy_taffeta::prelude::*;

/// Slowest and fastest, by the clock.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=4.0;

/// Width of the buttons at the right [point].
const BUTTONS: f32 = 290.0;

/// Shows the bar.
pub fn show(
    mut left: ResMut<Left>,
    mut shown: ResMut<Shown>,
    mut worlds: Query<(&mut Playback, Option<&Running>), With<StageRoot>>,
    history: Res<History>,
    mut restart: MessageWriter<Restart>,
    mut as_read: MessageWriter<AsRead>,
    mut save: MessageWriter<Save>,
) {
    let Ok((mut playback, running)) = worlds.single_mut() else { return };
    left.show(Panel::top("bar").exact_size(34.0), |ui| {
        ui.horizontal_centered(|ui| {
            playing(ui, &mut playback);
            if ui.button("⟲ reset").on_hover_text("Restart with the values as they are now (R)").clicked() {
                restart.write(Restart);
            }
            if ui.button("as read").on_hover_text("Restart with the values of the file").clicked() {
                as_read.write(AsRead);
            }
            ui.separator();
            let mut speed = playback.speed;
            ui.label("speed");
            ui.spacing_mut().slider_width = 90.0;
            let slider = Slider::new(&mut speed, SPEEDS).logarithmic(true).custom_formatter(|speed, _| {
                format!("{} ×", super::fields::number((speed * 100.0).round() / 100.0))
            });
            if ui.add(slider).changed() {
                playback.speed = speed;
            }
            ui.separator();
            if let Some(running) = running {
                numbers(ui, running, &history);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.toggle_value(&mut shown.values, "values").on_hover_text("Tab shows or hides both panels");
                ui.toggle_value(&mut shown.plots, "plots");
                ui.separator();
                if ui
                    .button("save scene")
                    .on_hover_text("As TOML, with its values as they are (Ctrl+S)")
                    .clicked()
                {
                    save.write(Save::Scene);
                }
                if ui.button("save picture").on_hover_text("As PNG, without panels (P)").clicked() {
                    save.write(Save::Picture);
                }
            });
        });
    });
}

fn playing(ui: &mut Ui, playback: &mut Mut<Playback>) {
    let words = if playback.paused { "▶ play" } else { "⏸ pause" };
    let size = egui::vec2(70.0, 24.0);
    if ui.add_sized(size, egui::Button::new(words)).on_hover_text("Space").clicked() {
        playback.paused = !playback.paused;
    }
    if ui.button("⏭ frame").on_hover_text("One frame ( . or N )").clicked() {
        step(playback);
    }
}

fn numbers(ui: &mut Ui, running: &Running, history: &History) {
    let simulation = running.simulation();
    let frame = simulation.frame();
    let shown = |ui: &mut Ui, words: String, width: f32| {
        // What has no room in a small window is left out.
        if ui.available_width() > width + BUTTONS {
            ui.add_sized([width, 20.0], egui::Label::new(egui::RichText::new(words).monospace()));
        }
    };
    shown(ui, format!("frame {frame}"), 84.0);
    shown(ui, format!("{:.2} s", f64::from(frame) * simulation.dt()), 62.0);
    let rate = 1.0 / history.seconds.max(1e-6);
    shown(ui, if rate < 10.0 { format!("{rate:.1} fps") } else { format!("{rate:.0} fps") }, 62.0);
}
