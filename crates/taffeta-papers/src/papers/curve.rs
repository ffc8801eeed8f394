//! Runs over time, as plots.

use crate::report::page::Plot;
use crate::runs::behaviour::Point;
use taffeta_plot::{Series, linear};

/// A run's curve with its name.
pub type Curve<'a> = (&'a str, Vec<Point>);

/// Largest stretch over time.
pub fn stretch(name: &str, caption: &str, curves: &[Curve]) -> Plot {
    let line =
        |(label, curve): &Curve| Series::of(*label, curve.iter().map(|point| (point.time, point.stretch)));
    let series: Vec<Series> = curves.iter().map(line).collect();
    let svg = linear(caption, "s", "largest l/L", &series, [1.0, 3.0]);
    Plot { name: name.to_owned(), caption: caption.to_owned(), svg }
}

/// Volume of all bodies over that at rest, over time.
pub fn volume(name: &str, caption: &str, curves: &[Curve]) -> Plot {
    let share = |point: &Point| Some((point.time, point.volume? * 1e2));
    let line = |(label, curve): &Curve| Series::of(*label, curve.iter().filter_map(share));
    let series: Vec<Series> = curves.iter().map(line).collect();
    let svg = linear(caption, "s", "% of the volume at rest", &series, [0.0, 200.0]);
    Plot { name: name.to_owned(), caption: caption.to_owned(), svg }
}
