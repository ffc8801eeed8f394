//! What the last seconds were like: energies, stretch, contacts, iterations.

use crate::stage::StageRoot;
use bevy::prelude::*;
use bevy_egui::egui::{Color32, RichText, Ui};
use bevy_taffeta::Running;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::diagnostics::FrameReport;
use egui_plot::{Line, Plot, PlotPoints, uniform_grid_spacer};
use std::collections::VecDeque;

/// Seconds of the scene that are shown.
const SHOWN: f64 = 10.0;
/// Most reports that are kept.
const MOST: usize = 2000;

/// The reports of the last seconds.
#[derive(Resource, Default)]
pub struct History {
    reports: VecDeque<FrameReport>,
    /// Smoothed seconds from one picture to the next.
    pub seconds: f64,
}

impl History {
    /// Takes a report; one of an earlier time begins again.
    fn note(&mut self, report: &FrameReport) {
        match self.reports.back() {
            Some(last) if last.frame == report.frame => return,
            Some(last) if last.frame > report.frame => self.reports.clear(),
            _ => {}
        }
        self.reports.push_back(report.clone());
        let oldest = report.time - SHOWN;
        while self.reports.len() > MOST || self.reports.front().is_some_and(|first| first.time < oldest) {
            self.reports.pop_front();
        }
    }

    /// The last report.
    pub fn last(&self) -> Option<&FrameReport> {
        self.reports.back()
    }

    /// One number of each report, by time.
    fn points(&self, of: impl Fn(&FrameReport) -> f64) -> Vec<[f64; 2]> {
        self.reports.iter().map(|report| [report.time, of(report)]).collect()
    }
}

/// Notes reports as they come.
pub fn history(app: &mut App) {
    app.init_resource::<History>().add_systems(PostUpdate, note.after(TaffetaSystems::Step));
}

fn note(worlds: Query<&Running, With<StageRoot>>, time: Res<Time<Real>>, mut history: ResMut<History>) {
    let seconds = time.delta_secs_f64();
    history.seconds = if history.seconds > 0.0 { 0.9 * history.seconds + 0.1 * seconds } else { seconds };
    if let Ok(running) = worlds.single() {
        history.note(running.simulation().report());
    }
}

/// A curve: its name, its colour, and its number in a report.
type Curve = (&'static str, [u8; 3], fn(&FrameReport) -> f64);

const ENERGIES: [Curve; 5] = [
    ("total", [40, 44, 52], FrameReport::energy),
    ("kinetic", [214, 90, 20], |report| report.kinetic),
    ("gravity", [30, 110, 190], |report| report.gravitational),
    ("springs", [20, 140, 80], |report| report.springs),
    ("hinges", [150, 60, 160], |report| report.energy_of("hinges")),
];
const STRETCH: [Curve; 1] = [("l/L", [200, 40, 60], |report| report.max_stretch)];

/// The names of energies in their colours.
pub fn names(ui: &mut Ui) {
    for (name, [r, g, b], _) in ENERGIES {
        ui.label(RichText::new(name).small().color(Color32::from_rgb(r, g, b)));
    }
}

/// Energies [J].
pub fn energy(ui: &mut Ui, history: &History, size: [f32; 2]) {
    plot(ui, "energy", &ENERGIES, history, size);
}

/// The largest stretch.
pub fn stretch(ui: &mut Ui, history: &History, size: [f32; 2]) {
    plot(ui, "stretch", &STRETCH, history, size);
}

fn plot(ui: &mut Ui, name: &str, curves: &[Curve], history: &History, [width, height]: [f32; 2]) {
    let plot = Plot::new(name.to_owned())
        .width(width)
        .height(height)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .y_axis_min_width(40.0)
        .x_grid_spacer(uniform_grid_spacer(|_| [10.0, 5.0, 1.0]))
        .set_margin_fraction([0.0, 0.08].into());
    let end = history.last().map_or(0.0, |last| last.time);
    plot.include_x(end.max(SHOWN)).include_x((end - SHOWN).max(0.0)).show(ui, |plot| {
        for (name, [r, g, b], of) in curves {
            let points = history.points(of);
            plot.line(
                Line::new(*name, PlotPoints::from(points)).color(Color32::from_rgb(*r, *g, *b)).width(1.6),
            );
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_of_the_last_seconds_are_kept_and_a_restart_begins_anew() {
        let mut history = History::default();
        let report = |frame: u32| FrameReport { frame, time: f64::from(frame) * 0.1, ..default() };
        (0..300).for_each(|frame| history.note(&report(frame)));
        history.note(&report(299));
        assert_eq!(history.reports.len(), 101);
        assert!((history.reports[0].time - 19.9).abs() < 1e-9);
        history.note(&report(0));
        assert_eq!(history.reports.len(), 1);
    }
}
