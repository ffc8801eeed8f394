//! Below the picture: plots of the last seconds, numbers of the last frame, times of its stages.

use super::fields::number;
use super::room::{Left, Shown};
use crate::plots::{self, History};
use crate::stage::StageRoot;
use bevy::prelude::*;
use bevy_egui::egui::{self, Panel, RichText, ScrollArea, Ui};
use bevy_taffeta::Running;

/// One frame in so many is timed by stages while these are shown.
const TIMED: u32 = 30;
/// Widths of numbers and of times [point].
const NUMBERS: f32 = 158.0;
const TIMES: f32 = 158.0;
/// Between columns, and the least that both plots need [point].
const BETWEEN: f32 = 44.0;
const PLOTS: f32 = 260.0;
/// Width of a title with the names of all energies [point].
const NAMED: f32 = 225.0;

/// Shows the panel.
pub fn show(
    mut left: ResMut<Left>,
    shown: Res<Shown>,
    history: Res<History>,
    mut worlds: Query<&mut Running, With<StageRoot>>,
) {
    let Ok(mut running) = worlds.single_mut() else { return };
    running.time_stages(if shown.plots { TIMED } else { 0 });
    if !shown.plots {
        return;
    }
    left.show(Panel::bottom("plots").resizable(true).default_size(200.0).size_range(120.0..=420.0), |ui| {
        ui.add_space(4.0);
        ui.horizontal_top(|ui| {
            let height = ui.available_height() - 24.0;
            // What has no room in a small window is left out.
            let room = ui.available_width() - PLOTS - BETWEEN;
            let (has_numbers, has_times) = (room > NUMBERS, room > NUMBERS + TIMES);
            let taken = if has_numbers { NUMBERS } else { 0.0 } + if has_times { TIMES } else { 0.0 };
            let rest = (ui.available_width() - taken - BETWEEN).max(0.0);
            let (wide, narrow) = (0.58 * rest, 0.42 * rest);
            // Names go beside the title where they have room.
            let names = |ui: &mut Ui| {
                if wide > NAMED {
                    plots::names(ui)
                }
            };
            column(ui, "energy [J]", wide, names, |ui| plots::energy(ui, &history, [wide, height]));
            let stretch = |ui: &mut Ui| plots::stretch(ui, &history, [narrow, height]);
            column(ui, "largest stretch l/L", narrow, |_| (), stretch);
            if has_numbers {
                ui.separator();
                column(ui, "this frame", NUMBERS, |_| (), |ui| numbers(ui, &running, &history));
            }
            if has_times {
                ui.separator();
                column(ui, "time of a frame", TIMES, |_| (), |ui| times(ui, &running));
            }
        });
    });
}

/// A part of the panel, under a title with something beside it.
fn column(ui: &mut Ui, title: &str, width: f32, beside: impl FnOnce(&mut Ui), job: impl FnOnce(&mut Ui)) {
    let size = egui::vec2(width, ui.available_height());
    ui.allocate_ui_with_layout(size, egui::Layout::top_down(egui::Align::Min), |ui| {
        ui.set_width(width);
        ui.horizontal(|ui| {
            ui.label(RichText::new(title).strong());
            beside(ui);
        });
        job(ui);
    });
}

/// Numbers of the last report.
fn numbers(ui: &mut Ui, running: &Running, history: &History) {
    let Some(report) = history.last() else { return };
    let solver = report.solver;
    let mut lines = vec![
        ("energy", format!("{} J", number(report.energy()))),
        ("contacts", report.contacts.to_string()),
        ("pairs of nodes", report.pairs.to_string()),
    ];
    if solver.iterations > 0 {
        lines.push(("iterations", solver.iterations.to_string()));
        lines.push(("residual", number(solver.residual)));
        lines.push(("active springs", format!("{:.1} %", 100.0 * solver.active_fraction)));
    }
    if report.broken > 0 {
        lines.push(("broken joints", report.broken.to_string()));
    }
    let bodies = running.simulation().bodies();
    let closed = report.volumes.iter().flatten().count();
    for (body, volume) in bodies.iter().zip(&report.volumes) {
        if let (Some(volume), Some(rest)) = (volume, body.rest_volume) {
            let key = if closed > 1 { &body.name[..] } else { "volume" };
            lines.push((key, format!("{:.2} %", 100.0 * volume / rest)));
        }
    }
    lines.push(("vertices", bodies.iter().map(|body| body.vertices).sum::<usize>().to_string()));
    table(ui, "numbers", &lines);
}

/// How long frames and their stages take.
fn times(ui: &mut Ui, running: &Running) {
    let timing = running.timing();
    let milliseconds = |seconds: f64| format!("{:.3} ms", 1e3 * seconds);
    let mut lines = vec![("one frame", milliseconds(timing.frame))];
    lines.extend(timing.stages.iter().map(|&(stage, seconds)| (stage, milliseconds(seconds))));
    table(ui, "times", &lines);
    let device = running.simulation().device();
    ui.add(egui::Label::new(RichText::new(&device).weak()).truncate()).on_hover_text(device);
}

fn table(ui: &mut Ui, name: &str, lines: &[(&str, String)]) {
    ScrollArea::vertical().id_salt(name).auto_shrink([false, true]).show(ui, |ui| {
        egui::Grid::new(name).num_columns(2).spacing([10.0, 2.0]).striped(true).show(ui, |ui| {
            for (key, value) in lines {
                ui.label(*key);
                ui.label(RichText::new(value).monospace());
                ui.end_row();
            }
        });
    });
}
