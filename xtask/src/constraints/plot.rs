//! Runs over time, as plots.

use super::curve::{COLUMNS, Curve};
use super::experiment::Experiment;
use crate::results::plot::{self, Area, COLORS, Drawn, FONT};
use plotters::prelude::*;
use std::path::Path;

/// A part of a plot: a number over time.
struct Panel {
    title: &'static str,
    column: usize,
    factor: f64,
    /// Least on the axis, and the most that is drawn of what blows up.
    range: [f64; 2],
}

const PANELS: [Panel; 4] = [
    Panel { title: "largest l/L", column: 1, factor: 1.0, range: [1.0, 3.0] },
    Panel { title: "energy beyond the start, J", column: 2, factor: 1.0, range: [0.0, 300.0] },
    Panel { title: "iterations", column: 3, factor: 1.0, range: [0.0, 2000.0] },
    Panel { title: "residual / right side", column: 4, factor: 1.0, range: [0.0, 2.0] },
];
/// In place of the last, where not all springs are constraints.
const ACTIVE: Panel =
    Panel { title: "springs that are constraints, %", column: 5, factor: 100.0, range: [0.0, 100.0] };

/// Draws the curves of an experiment's variants, as far as they were kept.
pub fn draw(file: &Path, experiment: &Experiment, curves: &[Option<Curve>]) -> Result<(), String> {
    let labels = experiment.variants.iter().map(|variant| variant.label);
    let curves: Vec<(&str, &Curve)> =
        labels.zip(curves).filter_map(|(label, curve)| Some((label, curve.as_ref()?))).collect();
    let panels = panels(&curves);
    plot::draw(file, experiment.title, |area| {
        let areas = area.split_evenly((2, panels.len() / 2));
        panels.iter().zip(&areas).enumerate().try_for_each(|(index, (panel, area))| {
            let labelled = index == 0;
            draw_panel(panel, area, &curves, labelled)
        })
    })
}

/// Those that say something: springs alone have neither iterations nor constraints.
fn panels(curves: &[(&str, &Curve)]) -> Vec<Panel> {
    let rows = || curves.iter().flat_map(|(_, curve)| &curve.rows);
    let solved = rows().any(|row| row[3] > 0.0);
    let adaptive = rows().any(|row| row[5] > 0.0 && row[5] < 1.0);
    let [stretch, energy, iterations, residual] = PANELS;
    match (solved, adaptive) {
        (false, _) => vec![stretch, energy],
        (_, false) => vec![stretch, energy, iterations, residual],
        (_, true) => vec![stretch, energy, iterations, ACTIVE],
    }
}

fn draw_panel(panel: &Panel, area: &Area, curves: &[(&str, &Curve)], labelled: bool) -> Drawn {
    let at = |row: &[f64; COLUMNS]| (row[0], row[panel.column] * panel.factor);
    let points = || curves.iter().flat_map(|(_, curve)| curve.rows.iter().map(at));
    let end = points().map(|(time, _)| time).fold(0.1, f64::max);
    let [least, most] = panel.range;
    let drawn = || points().map(|(_, value)| value).filter(|value| value.is_finite());
    let low = drawn().fold(least, f64::min);
    let high = drawn().fold(low, f64::max).min(most);
    let room = 0.05 * (high - low).max(1e-6);
    let mut chart = ChartBuilder::on(area);
    chart.margin(8).x_label_area_size(24).y_label_area_size(48).caption(panel.title, (FONT, 14));
    let mut chart = chart.build_cartesian_2d(0.0..end, low..high + room)?;
    let digits = if high - low > 20.0 { 0 } else { 2 };
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE).label_style((FONT, 12)).x_labels(6).y_labels(6);
    mesh.x_label_formatter(&|s| format!("{s:.0} s"))
        .y_label_formatter(&|v| format!("{v:.digits$}"))
        .draw()?;
    for ((label, curve), color) in curves.iter().zip(COLORS) {
        let line = curve.rows.iter().map(at).take_while(|(_, value)| *value <= high + room);
        let drawn = chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?.label(*label);
        drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], color.stroke_width(2)));
    }
    if labelled {
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperRight).label_font((FONT, 12));
        labels.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_those_that_say_something() {
        let curve = |iterations, active| Curve { rows: vec![[1.0, 1.0, 0.0, iterations, 0.0, active]] };
        let last = |curve: &Curve| panels(&[("", curve)]).pop().map(|panel| panel.title);
        assert_eq!(last(&curve(0.0, 0.0)), Some(PANELS[1].title));
        assert_eq!(last(&curve(9.0, 1.0)), Some(PANELS[3].title));
        assert_eq!(last(&curve(9.0, 0.5)), Some(ACTIVE.title));
    }
}
