//! The plots of the report.

use crate::behaviour::Point;
use crate::page::Plot;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

/// Width and height of a plot [pixels].
const SIZE: (u32, u32) = (760, 420);
const FONT: &str = "sans-serif";
/// Colours of lines that stand together; for people who confuse red and green too (Okabe and Ito 2008).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    BLACK,
];

/// A line with its name.
pub type Series<'a> = (&'a str, Vec<(f64, f64)>);

/// What a plot is called, and what is along its axes.
pub struct Axes<'a> {
    /// Of its file.
    pub name: &'a str,
    /// What is seen.
    pub caption: &'a str,
    /// To the right.
    pub x: &'a str,
    /// Upwards.
    pub y: &'a str,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Lines with points on logarithmic axes; nothing that is not positive is drawn.
pub fn log_log(axes: &Axes, series: &[Series]) -> Plot {
    let positive = |points: &[(f64, f64)]| {
        points.iter().copied().filter(|(x, y)| *x > 0.0 && *y > 0.0 && y.is_finite()).collect::<Vec<_>>()
    };
    let series: Vec<Series> = series.iter().map(|(name, points)| (*name, positive(points))).collect();
    let range = |of: fn(&(f64, f64)) -> f64| {
        let values = || series.iter().flat_map(|(_, points)| points.iter().map(of));
        let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        if least <= most { least * 0.7..most * 1.4 } else { 1.0..10.0 }
    };
    let (x, y) = (range(|point| point.0), range(|point| point.1));
    draw(axes, |area| chart(area, axes, &series, x.log_scale(), y.log_scale(), true))
}

/// Lines on linear axes; of what leaves the range from `low` to `high` nothing more is drawn.
pub fn linear(axes: &Axes, series: &[Series], low: f64, high: f64) -> Plot {
    let until = |points: &[(f64, f64)]| {
        points.iter().copied().take_while(|(_, y)| y.is_finite() && *y <= high).collect::<Vec<_>>()
    };
    let series: Vec<Series> = series.iter().map(|(name, points)| (*name, until(points))).collect();
    let points = || series.iter().flat_map(|(_, points)| points.iter());
    let end = points().map(|point| point.0).fold(0.1, f64::max);
    let least = points().map(|point| point.1).fold(low, f64::min);
    let most = points().map(|point| point.1).fold(least, f64::max);
    let top = most + 0.06 * (most - least).max(1e-9);
    draw(axes, |area| chart(area, axes, &series, 0.0..end, least..top, false))
}

/// Largest stretch over time.
pub fn stretch(name: &str, caption: &str, curves: &[(&str, Vec<Point>)]) -> Plot {
    let series: Vec<Series> = curves
        .iter()
        .map(|(label, curve)| (*label, curve.iter().map(|point| (point.time, point.stretch)).collect()))
        .collect();
    linear(&Axes { name, caption, x: "s", y: "largest l/L" }, &series, 1.0, 3.0)
}

/// Share of its volume that a body has, over time.
pub fn volume(name: &str, caption: &str, curves: &[(&str, Vec<Point>)]) -> Plot {
    let share = |point: &Point| Some((point.time, point.volume? * 1e2));
    let series: Vec<Series> =
        curves.iter().map(|(label, curve)| (*label, curve.iter().filter_map(share).collect())).collect();
    linear(&Axes { name, caption, x: "s", y: "% of the volume at rest" }, &series, 0.0, 200.0)
}

fn chart<X, Y>(area: &Area, axes: &Axes, series: &[Series], x: X, y: Y, points: bool) -> Drawn
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
{
    let mut chart = ChartBuilder::on(area);
    chart.margin(14).x_label_area_size(44).y_label_area_size(64);
    let mut chart = chart.build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(axes.x).y_desc(axes.y).light_line_style(WHITE).label_style((FONT, 14));
    mesh.x_label_formatter(&short).y_label_formatter(&short).draw()?;
    let drawn = series.iter().filter(|(_, points)| !points.is_empty());
    for ((name, line), color) in drawn.zip(COLORS) {
        let mut line = LineSeries::new(line.iter().copied(), color.stroke_width(2));
        if points {
            line = line.point_size(3);
        }
        let drawn = chart.draw_series(line)?.label(*name);
        drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    if series.iter().any(|(_, points)| !points.is_empty()) {
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperRight).label_font((FONT, 13));
        labels.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw()?;
    }
    Ok(())
}

/// 1 k, 100 k, 1 M; 0.01.
fn short(number: &f64) -> String {
    match number.abs() {
        n if n >= 1e6 => format!("{:.0} M", number * 1e-6),
        n if n >= 1e3 => format!("{:.0} k", number * 1e-3),
        n if n >= 10.0 || n == 0.0 => format!("{number:.0}"),
        n if n >= 0.01 => format!("{number:.2}").trim_end_matches('0').trim_end_matches('.').to_owned(),
        _ => format!("{number:.0e}"),
    }
}

/// Draws below the caption; into memory, where nothing can fail but the drawing itself, and then the plot says so.
fn draw(axes: &Axes, content: impl FnOnce(&Area) -> Drawn) -> Plot {
    let mut svg = String::new();
    let drawn = || -> Drawn {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        content(&area.titled(axes.caption, (FONT, 17))?)?;
        area.present()?;
        Ok(())
    };
    let caption = match drawn() {
        Ok(()) => axes.caption.to_owned(),
        Err(error) => format!("{}: {error}", axes.caption),
    };
    Plot { name: axes.name.to_owned(), caption, svg }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: Axes = Axes { name: "a", caption: "What is seen", x: "nodes", y: "ms" };

    #[test]
    fn every_line_is_drawn_and_named() {
        let plot = log_log(
            &AXES,
            &[("one", vec![(1.0, 1.0), (10.0, 3.0)]), ("two", vec![(1.0, 0.1)]), ("none", vec![])],
        );
        // In the chart, and beside its name.
        let lines = |color: &str| {
            plot.svg.matches(&format!("opacity=\"1\" stroke=\"#{color}\" stroke-width=\"2\" points")).count()
        };
        assert_eq!(["0072B2", "D55E00", "009E73"].map(lines), [2, 2, 0], "{}", plot.svg);
        assert!(
            plot.svg.contains(">\none") && plot.svg.contains("What is seen") && !plot.svg.contains(">\nnone")
        );
    }

    #[test]
    fn what_blows_up_is_drawn_until_it_does() {
        let plot = linear(&AXES, &[("up", vec![(0.0, 1.0), (1.0, 2.0), (2.0, 1e9)])], 0.0, 3.0);
        assert!(plot.svg.contains("polyline") && !plot.svg.contains("e9"), "{}", plot.svg);
        assert_eq!(linear(&AXES, &[], 0.0, 1.0).caption, AXES.caption);
        assert_eq!([0.0, 0.5, 12.0, 2e4, 3e6].map(|n| short(&n)), ["0", "0.5", "12", "20 k", "3 M"]);
    }
}
