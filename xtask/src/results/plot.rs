//! The measured lines as plots.

use super::Line;
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;
use std::path::Path;

/// Width and height of a plot [pixels].
const SIZE: (u32, u32) = (720, 440);
pub const FONT: &str = "sans-serif";
/// Nodes on the plot's axis, from and to.
const NODES: [f64; 2] = [8e2, 1.2e7];
/// Colours of lines that stand together in a plot; for people who confuse red and green too (Okabe and Ito 2008).
pub const COLORS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167)];

/// Where a plot is drawn.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What drawing returns.
pub type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Points of a line, with its name.
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
}

impl Series {
    fn new(name: String, mut points: Vec<(f64, f64)>) -> Self {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        Self { name, points }
    }
}

/// Nanoseconds of a node's sub-step against the number of nodes, for all threads and for one.
pub fn nodes(file: &Path, lines: &[Line]) -> Result<(), String> {
    let series = [("all threads", true), ("1 thread", false)].map(|(name, free)| {
        let single =
            |line: &&Line| line.command.ends_with("--threads 1") || line.command.contains("--threads 1 ");
        let grids = lines.iter().filter(|line| line.bench == "grid" && line.n[0] == line.n[1]);
        let chosen = grids.filter(|line| if free { line.free() } else { single(line) });
        let point = |line: &Line| (line.nodes as f64, 1e9 / line.particle_substeps_per_s);
        Series::new(name.to_owned(), chosen.map(point).collect())
    });
    draw(file, "Square grid: time of one node in one sub-step", |area| {
        let mut chart = ChartBuilder::on(area);
        chart.margin(14).x_label_area_size(44).y_label_area_size(56);
        let mut chart = chart.build_cartesian_2d((NODES[0]..NODES[1]).log_scale(), 0.0..top(&series))?;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("nodes").y_desc("ns").light_line_style(WHITE).label_style((FONT, 14));
        mesh.x_label_formatter(&short).y_label_formatter(&|ns| format!("{ns:.1}")).draw()?;
        curves(&mut chart, &series, SeriesLabelPosition::LowerLeft)
    })
}

/// Speed against the number of threads, for each bench that was run with several.
pub fn threads(file: &Path, lines: &[Line]) -> Result<(), String> {
    let series = scaled(lines);
    let most = lines.iter().map(Line::threads).max().unwrap_or(1) as f64;
    draw(file, "Grid: speed for each number of threads", |area| {
        let mut chart = ChartBuilder::on(area);
        chart.margin(14).x_label_area_size(44).y_label_area_size(56);
        let mut chart = chart.build_cartesian_2d(0.0..most + 0.5, 0.0..top(&series))?;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("threads")
            .y_desc("M particle-substeps/s")
            .light_line_style(WHITE)
            .label_style((FONT, 14));
        mesh.x_labels(most.min(16.0) as usize + 1)
            .x_label_formatter(&whole)
            .y_label_formatter(&whole)
            .draw()?;
        curves(&mut chart, &series, SeriesLabelPosition::LowerRight)
    })
}

/// Draws lines with their points, and says which is which.
fn curves<'a, T>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, T>,
    series: &[Series],
    legend: SeriesLabelPosition,
) -> Drawn
where
    T: CoordTranslate<From = (f64, f64)>,
{
    for (series, color) in series.iter().zip(COLORS) {
        let line = LineSeries::new(series.points.iter().copied(), color.stroke_width(2)).point_size(3);
        let drawn = chart.draw_series(line)?.label(series.name.as_str());
        drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    let mut labels = chart.configure_series_labels();
    labels.position(legend).label_font((FONT, 14));
    labels.background_style(WHITE).border_style(BLACK.mix(0.3)).draw()?;
    Ok(())
}

/// For each grid that was told its threads, and told more than one: speed against threads.
fn scaled(lines: &[Line]) -> Vec<Series> {
    let told = |line: &&Line| line.bench == "grid" && !line.free();
    let mut grids: Vec<&Vec<u32>> =
        lines.iter().filter(told).filter(|line| line.threads() > 1).map(|l| &l.n).collect();
    grids.sort();
    grids.dedup();
    let series = |n: &Vec<u32>| {
        let name = n.iter().map(u32::to_string).collect::<Vec<_>>().join(" × ");
        let same = lines.iter().filter(told).filter(|line| line.n == *n);
        Series::new(
            name,
            same.map(|line| (line.threads() as f64, line.particle_substeps_per_s * 1e-6)).collect(),
        )
    };
    grids.into_iter().map(series).collect()
}

/// Draws `content` below a title into an SVG.
pub fn draw(file: &Path, title: &str, content: impl FnOnce(&Area) -> Drawn) -> Result<(), String> {
    let backend = SVGBackend::new(file, SIZE).into_drawing_area();
    let all = || {
        backend.fill(&WHITE)?;
        content(&backend.titled(title, (FONT, 18))?)?;
        backend.present()?;
        Ok(())
    };
    let drawn: Drawn = all();
    drawn.map_err(|error| format!("{}: {error}", file.display()))
}

/// Upper end of an axis from zero that holds all points.
fn top(series: &[Series]) -> f64 {
    let values = series.iter().flat_map(|series| series.points.iter().map(|point| point.1));
    values.fold(0.0, f64::max).max(1e-3) * 1.1
}

fn whole(number: &f64) -> String {
    format!("{number:.0}")
}

/// 1 k, 100 k, 1 M.
fn short(count: &f64) -> String {
    match *count {
        c if c >= 1e6 => format!("{:.0} M", c * 1e-6),
        c if c >= 1e3 => format!("{:.0} k", c * 1e-3),
        c => format!("{c:.0}"),
    }
}
