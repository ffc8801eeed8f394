//! Volume over time, as a plot.

use super::curve::Curve;
use super::experiment::Experiment;
use crate::results::plot::{self, COLORS, FONT};
use plotters::prelude::*;
use std::path::Path;

/// The forms that are drawn, in the order of the colours, with their words; `projected` looks as `corrected` does.
const DRAWN: [(&str, &str); 4] = [
    ("corrected", "kept"),
    ("none", "springs only"),
    ("paper-shader", "paper-shader"),
    ("printed", "printed"),
];
/// Frames a second: none of the scenes says otherwise.
const RATE: f64 = 60.0;
/// Largest share that is drawn, for what blows up.
const MOST: f64 = 3.2;

/// Draws an experiment's curves.
pub fn draw(file: &Path, experiment: &Experiment, curves: &[Curve]) -> Result<(), String> {
    let shares = || curves.iter().flat_map(|curve| curve.shares.iter().copied());
    let low = shares().fold(0.0, f64::min) - 0.02;
    let high = shares().filter(|share| *share < MOST).fold(1.0, f64::max) + 0.05;
    let seconds = curves.iter().map(|curve| curve.shares.len()).max().unwrap_or(1) as f64 / RATE;
    plot::draw(file, &format!("Volume over time: {}", experiment.what), |area| {
        let mut chart = ChartBuilder::on(area);
        chart.margin(14).x_label_area_size(44).y_label_area_size(56);
        let mut chart = chart.build_cartesian_2d(0.0..seconds, low..high)?;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("s").y_desc("volume / volume at rest").light_line_style(WHITE).label_style((FONT, 14));
        mesh.x_label_formatter(&|s| format!("{s:.0}")).y_label_formatter(&|v| format!("{v:.1}")).draw()?;
        for ((form, words), color) in DRAWN.iter().zip(COLORS) {
            let Some(curve) = curves.iter().find(|curve| curve.form == *form) else { continue };
            let start = std::iter::once((0.0, 1.0));
            let later = curve.shares.iter().enumerate().map(|(i, share)| ((i + 1) as f64 / RATE, *share));
            let points = start.chain(later).take_while(|(_, share)| *share < high);
            let drawn = chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?.label(*words);
            drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::MiddleRight).label_font((FONT, 14));
        labels.background_style(WHITE).border_style(BLACK.mix(0.3)).draw()?;
        Ok(())
    })
}
