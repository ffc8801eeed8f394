//! Error against time: a panel for each size and stiffness.

use super::page::cells;
use super::run::Run;
use super::way::Way;
use crate::results::plot::{Area, COLORS, Drawn, FONT};
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

/// Width and height of a panel, and of the legend above [pixels].
const PANEL: (u32, u32) = (360, 250);
const LEGEND: u32 = 44;
/// Panels in a row: stiffnesses of a size.
const COLUMNS: usize = 3;

/// Draws all runs that did not blow up.
pub fn draw(file: &Path, runs: &[Run]) -> Result<(), String> {
    let cells = cells(runs);
    let rows = cells.len().div_ceil(COLUMNS);
    let size = (PANEL.0 * COLUMNS as u32, PANEL.1 * rows as u32 + LEGEND);
    let backend = SVGBackend::new(file, size).into_drawing_area();
    let all = || -> Drawn {
        backend.fill(&WHITE)?;
        let (top, below) = backend.split_vertically(LEGEND);
        legend(&top)?;
        let errors = decades(good(runs).filter_map(|run| run.error));
        let areas = below.split_evenly((rows, COLUMNS));
        cells.iter().zip(&areas).try_for_each(|(cell, area)| panel(area, cell, runs, errors.clone()))?;
        backend.present()?;
        Ok(())
    };
    all().map_err(|error| format!("{}: {error}", file.display()))
}

/// Runs that can be drawn.
fn good(runs: &[Run]) -> impl Iterator<Item = &Run> {
    runs.iter().filter(|run| run.error.is_some_and(|error| error > 0.0) && run.cost() > 0.0)
}

/// The powers of ten around some numbers.
fn decades(numbers: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = numbers.fold((f64::MAX, f64::MIN), |(low, high), n| (low.min(n), high.max(n)));
    if low > high {
        return 0.1..1.0;
    }
    10_f64.powf(low.log10().floor())..10_f64.powf(high.log10().floor() + 1.0)
}

fn color(way: Way) -> RGBColor {
    let place = Way::ALL.iter().position(|known| *known == way).unwrap_or(0);
    COLORS[place % COLORS.len()]
}

/// Names of ways, and what their marks mean.
fn legend(area: &Area) -> Drawn {
    let style = (FONT, 14).into_font().color(&BLACK);
    let mut x = 14;
    for way in Way::ALL {
        area.draw(&PathElement::new([(x, 14), (x + 22, 14)], color(way).stroke_width(2)))?;
        area.draw(&Text::new(way.label(), (x + 28, 8), style.clone()))?;
        x += 50 + 8 * way.label().len() as i32;
    }
    area.draw(&Circle::new((x + 8, 14), 5, BLACK.stroke_width(1)))?;
    area.draw(&Text::new("one step a frame", (x + 20, 8), style.clone()))?;
    area.draw(&Cross::new((x + 150, 14), 5, BLACK.stroke_width(1)))?;
    area.draw(&Text::new("crumpled: a spring is 5 % too long", (x + 162, 8), style.clone()))?;
    let below = "error against wall seconds by simulated second; vertical: real time; dashes: the reference in twice its steps";
    area.draw(&Text::new(below, (14, 28), style))?;
    Ok(())
}

/// A size and a stiffness; on axes that all panels of the size share.
fn panel(area: &Area, cell: &[Run], runs: &[Run], errors: Range<f64>) -> Drawn {
    let Run { size, k, side, reference, seconds, .. } = &cell[0];
    let times = decades(good(runs).filter(|run| run.side == *side).map(Run::cost));
    let mut chart = ChartBuilder::on(area);
    chart.margin(8).x_label_area_size(24).y_label_area_size(48);
    chart.caption(format!("{size} nodes, {k} N/m, {seconds:.2} s"), (FONT, 14));
    let mut chart = chart.build_cartesian_2d(times.clone().log_scale(), errors.clone().log_scale())?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE).label_style((FONT, 12)).x_labels(6).y_labels(8);
    mesh.x_label_formatter(&power).y_label_formatter(&power).draw()?;
    let grey = BLACK.mix(0.5);
    if times.contains(&1.0) {
        chart.draw_series(LineSeries::new([(1.0, errors.start), (1.0, errors.end)], grey))?;
    }
    if errors.contains(reference) {
        let level = [(times.start, *reference), (times.end, *reference)];
        chart.draw_series(DashedLineSeries::new(level, 4, 4, grey.into()))?;
    }
    for way in Way::ALL {
        let own = || good(cell).filter(move |run| run.way == way);
        let at = |run: &Run| (run.cost(), run.error.unwrap_or(errors.end));
        let line = LineSeries::new(own().map(at), color(way).stroke_width(2)).point_size(3);
        chart.draw_series(line)?;
        let rough = own().filter(|run| !run.holds());
        chart.draw_series(rough.map(|run| Cross::new(at(run), 6, color(way).stroke_width(1))))?;
        let single = own().filter(|run| run.steps == 1);
        chart.draw_series(single.map(|run| Circle::new(at(run), 6, color(way).stroke_width(1))))?;
    }
    Ok(())
}

/// 0.01, 1, 100; small ones as powers.
fn power(number: &f64) -> String {
    if (1e-2..1e4).contains(number) { format!("{number}") } else { format!("{number:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_powers_of_ten_around_all_points() {
        let range = decades([0.3, 2e-4].into_iter());
        assert!((range.start / 1e-4 - 1.0).abs() < 1e-12 && (range.end - 1.0).abs() < 1e-12, "{range:?}");
        assert_eq!(decades(std::iter::empty()), 0.1..1.0);
    }
}
