//! Lines in a drawing, as SVG: the plots of this workspace's reports.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;

/// Width and height of a drawing, and width of the names of its lines at the right [pixels].
const SIZE: (u32, u32) = (820, 440);
const NAMES: u32 = 190;
const FONT: &str = "sans-serif";
/// Colours of lines in their order; for people who confuse red and green too (Okabe and Ito 2008), and two more.
pub const COLORS: [RGBColor; 10] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(130, 130, 130),
    RGBColor(140, 80, 20),
    RGBColor(110, 60, 190),
];

/// A line through points, in their order.
#[derive(Clone)]
pub struct Series {
    /// What it is called at the right.
    pub name: String,
    /// Its points. Those that a logarithm does not take are left out; a line without any keeps its colour.
    pub points: Vec<Point>,
}

/// A point of a line.
#[derive(Clone)]
pub struct Point {
    /// Along and up.
    pub at: (f64, f64),
    /// What stands beside it, or nothing.
    pub label: String,
}

impl Series {
    /// A line without points yet.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), points: Vec::new() }
    }

    /// With another point.
    pub fn point(mut self, at: (f64, f64), label: impl Into<String>) -> Self {
        self.points.push(Point { at, label: label.into() });
        self
    }

    /// Through points without labels.
    pub fn of(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        points.into_iter().fold(Self::new(name), |series, at| series.point(at, ""))
    }

    /// Whether its points go from left to right.
    fn ascends(&self) -> bool {
        self.points.windows(2).all(|pair| pair[0].at.0 <= pair[1].at.0)
    }

    /// As far as a logarithm takes it.
    fn positive(&self) -> Self {
        let fits = |number: f64| number.is_finite() && number > 0.0;
        self.kept(|points| points.into_iter().filter(|point| fits(point.at.0) && fits(point.at.1)).collect())
    }

    /// Until it is not a number or above `high`.
    fn until(&self, high: f64) -> Self {
        self.kept(|points| points.into_iter().take_while(|point| point.at.1 <= high).collect())
    }

    fn kept(&self, keep: impl FnOnce(Vec<Point>) -> Vec<Point>) -> Self {
        Self { name: self.name.clone(), points: keep(self.points.clone()) }
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Draws lines with their points on two logarithmic axes.
pub fn log_log(title: &str, x: &str, y: &str, series: &[Series]) -> String {
    let series: Vec<Series> = series.iter().map(Series::positive).collect();
    let numbers = |axis: fn(&Point) -> f64| series.iter().flat_map(|line| &line.points).map(axis);
    let (across, up) = (decades(numbers(|point| point.at.0)), decades(numbers(|point| point.at.1)));
    let chart = Chart { title, axes: [x, y], series: &series, size: 3, ticks: power };
    chart.drawn(across.log_scale(), up.log_scale())
}

/// Draws lines on two linear axes, of which the second has `low`; of a line that gets above `high` or is no number no more
/// is drawn.
pub fn linear(title: &str, x: &str, y: &str, series: &[Series], [low, high]: [f64; 2]) -> String {
    let series: Vec<Series> = series.iter().map(|line| line.until(high)).collect();
    let (across, up) = extent(&series, low);
    Chart { title, axes: [x, y], series: &series, size: 0, ticks: plain }.drawn(across, up)
}

/// Draws points on two linear axes, of which the second has `low`. Those that go from left to right are joined by lines.
///
/// ```
/// use taffeta_plot::{Series, marked};
///
/// let line = Series::of("drop of a cantilever", [(1.0, 0.125), (2.0, 0.247)]);
/// assert!(marked("Cantilever", "load", "drop/reach", &[line], 0.0).starts_with("<svg"));
/// ```
pub fn marked(title: &str, x: &str, y: &str, series: &[Series], low: f64) -> String {
    let (across, up) = extent(series, low);
    Chart { title, axes: [x, y], series, size: 3, ticks: plain }.drawn(across, up)
}

/// The axes of lines: from 0 to the right, and from `low`, or below it, up.
fn extent(series: &[Series], low: f64) -> (Range<f64>, Range<f64>) {
    let numbers = |axis: fn(&Point) -> f64| series.iter().flat_map(|line| &line.points).map(axis);
    let end = numbers(|point| point.at.0).fold(0.0, f64::max);
    let least = numbers(|point| point.at.1).fold(low, f64::min);
    let most = numbers(|point| point.at.1).fold(least, f64::max);
    // Room above, and some where there is nothing.
    (0.0..end.max(0.1), least..most + 0.06 * (most - least).max(1e-3))
}

/// What is drawn.
struct Chart<'a> {
    title: &'a str,
    axes: [&'a str; 2],
    series: &'a [Series],
    /// Radius of points [pixels].
    size: u32,
    ticks: fn(&f64) -> String,
}

impl Chart<'_> {
    fn drawn<X, Y>(&self, across: X, up: Y) -> String
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let mut svg = String::new();
        let drawn = self.draw(&mut svg, across, up);
        // Text takes all that is written to it, and these axes have a length.
        drawn.expect("a drawing in memory does not fail");
        svg
    }

    fn draw<X, Y>(&self, svg: &mut String, across: X, up: Y) -> Drawn
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let whole = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        whole.fill(&WHITE)?;
        let (left, right) = whole.titled(self.title, (FONT, 18))?.split_horizontally(SIZE.0 - NAMES);
        let mut chart = ChartBuilder::on(&left);
        chart.margin(10).x_label_area_size(44).y_label_area_size(64);
        let mut chart = chart.build_cartesian_2d(across, up)?;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(self.axes[0]).y_desc(self.axes[1]).light_line_style(WHITE).label_style((FONT, 14));
        mesh.x_labels(8).y_labels(10).x_label_formatter(&self.ticks).y_label_formatter(&self.ticks).draw()?;
        // The first on top.
        let colored: Vec<(&Series, RGBColor)> = self
            .series
            .iter()
            .zip(COLORS.into_iter().cycle())
            .filter(|(line, _)| !line.points.is_empty())
            .collect();
        for &(series, color) in colored.iter().rev() {
            let (at, style) = (series.points.iter().map(|point| point.at), color.stroke_width(2));
            if self.size > 0 && !series.ascends() {
                chart.draw_series(at.map(|at| Circle::new(at, self.size, style)))?;
            } else {
                chart.draw_series(LineSeries::new(at, style).point_size(self.size))?;
            }
            let style = (FONT, 12).into_font().color(&color);
            let label = |point: &Point| {
                EmptyElement::at(point.at) + Text::new(point.label.clone(), (6, -12), style.clone())
            };
            chart.draw_series(series.points.iter().filter(|point| !point.label.is_empty()).map(label))?;
        }
        names(&right, &colored)?;
        whole.present()?;
        Ok(())
    }
}

/// Which line is which, for those that have points.
fn names(area: &Area, colored: &[(&Series, RGBColor)]) -> Drawn {
    let style = (FONT, 14).into_font().color(&BLACK);
    for ((series, color), y) in colored.iter().zip((24..).step_by(22)) {
        area.draw(&PathElement::new([(0, y), (22, y)], color.stroke_width(2)))?;
        area.draw(&Text::new(series.name.clone(), (28, y - 7), style.clone()))?;
    }
    Ok(())
}

/// The powers of ten around some numbers.
fn decades(numbers: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = numbers.fold((f64::MAX, f64::MIN), |(low, high), n| (low.min(n), high.max(n)));
    if low > high {
        return 0.1..1.0;
    }
    10_f64.powf(low.log10().floor())..10_f64.powf(high.log10().floor() + 1.0)
}

/// 0.01, 1, 100; small and large ones as powers. A tick may be a digit off its power of ten.
fn power(number: &f64) -> String {
    let number = format!("{number:.2e}").parse().unwrap_or(*number);
    if (1e-2..1e5).contains(&number) { format!("{number}") } else { format!("{number:e}") }
}

/// As short as it can be told.
fn plain(number: &f64) -> String {
    let digits = if number.abs() < 10.0 { 2 } else { 0 };
    let text = format!("{number:.digits$}");
    if digits == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
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

    #[test]
    fn ticks_are_short() {
        let ticks = [0.09999999999999998, 1.0000000000000002e-7, 99.99999999999999, 1e5, 0.02];
        assert_eq!(ticks.map(|tick| power(&tick)), ["0.1", "1e-7", "100", "1e5", "0.02"]);
    }

    #[test]
    fn lines_keep_their_colours_and_what_has_no_logarithm_is_left_out() {
        let lines = [
            Series::new("none").point((0.0, 1.0), "zero").point((1.0, f64::NAN), "nan"),
            Series::new("some").point((1.0, 0.1), "first").point((10.0, 0.01), ""),
        ];
        let svg = log_log("Title & more", "x", "y", &lines);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(svg.contains("Title &amp; more") && svg.contains("some") && svg.contains("first"));
        assert!(!svg.contains("none<") && !svg.contains("zero") && !svg.contains("NaN"));
        assert!(svg.contains("#D55E00") && !svg.contains("#0072B2"), "{svg}");
        assert!(log_log("", "", "", &[]).contains("</svg>"));
    }

    #[test]
    fn points_that_go_to_and_fro_are_not_joined() {
        let svg =
            |last: f64| marked("", "", "", &[Series::of("a", [(1.0, 1.0), (2.0, 2.0), (last, 3.0)])], 0.0);
        let lines =
            |svg: &str| svg.lines().filter(|l| l.contains("polyline") && l.contains("#0072B2")).count();
        // The name has a line of its own.
        assert_eq!((lines(&svg(3.0)), lines(&svg(0.0))), (2, 1));
        assert_eq!(svg(0.0).matches("<circle").count(), 3);
    }

    #[test]
    fn what_blows_up_is_drawn_until_it_does() {
        let up = Series::of("up", [(0.0, 1.0), (1.0, 2.0), (2.0, 1e9), (3.0, 1.0)]);
        let lost = Series::of("lost", [(0.0, f64::NAN)]);
        let svg = linear("", "s", "l/L", &[up, lost], [1.0, 3.0]);
        let line = svg
            .lines()
            .find(|line| line.contains("polyline") && line.contains("#0072B2"))
            .unwrap_or_default();
        assert_eq!(line.matches(',').count(), 2, "{line}");
        assert!(svg.contains("up") && !svg.contains("lost"));
        assert_eq!([0.0, 0.5, 1.25, 12.0].map(|number| plain(&number)), ["0", "0.5", "1.25", "12"]);
        assert!(linear("", "", "", &[], [0.0, 1.0]).contains("</svg>"));
    }
}
