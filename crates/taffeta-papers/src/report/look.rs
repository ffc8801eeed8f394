//! Tables look at what is kept; what is not there has a reason.

use crate::report::store::{Kept, Store};
use crate::report::table::{Cell, Table};
use serde_json::Value;
use std::collections::BTreeMap;

/// What is kept, and why the rest is not.
pub struct Look<'a> {
    store: &'a Store,
    missing: &'a BTreeMap<String, String>,
}

impl<'a> Look<'a> {
    /// At a store, with what is missing in it by name.
    pub fn new(store: &'a Store, missing: &'a BTreeMap<String, String>) -> Self {
        Self { store, missing }
    }

    /// What a run left.
    ///
    /// # Errors
    /// Why there is nothing.
    pub fn at(&self, name: &str) -> Result<&'a Kept, String> {
        match self.missing.get(name) {
            Some(why) => Err(why.clone()),
            None => self.store.get(name).ok_or_else(|| "was not run".to_owned()),
        }
    }

    /// A number of a run, in writing.
    pub fn cell(&self, name: &str, read: impl Fn(&Value) -> Option<String>) -> Cell {
        Cell::ours(self.at(name), read)
    }

    /// A number of a run with so many digits after the point, times a factor.
    pub fn number(&self, name: &str, key: &str, factor: f64, digits: usize) -> Cell {
        self.cell(name, |value| Some(format!("{:.digits$}", value[key].as_f64()? * factor)))
    }

    /// A count of a run.
    pub fn count(&self, name: &str, key: &str) -> Cell {
        self.cell(name, |value| Some(grouped(value[key].as_u64()?)))
    }

    /// What a run left, as it was.
    pub fn of<T: serde::de::DeserializeOwned>(&self, name: &str) -> Option<T> {
        serde_json::from_value(self.at(name).ok()?.result.clone()).ok()
    }
}

/// `number` with commas between thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let commas = |(index, digit): (usize, char)| {
        let comma = index > 0 && (digits.len() - index).is_multiple_of(3);
        comma.then_some(',').into_iter().chain([digit])
    };
    digits.chars().enumerate().flat_map(commas).collect()
}

/// A table of speeds; `published` heads the column of what a paper prints.
pub fn speeds(name: &'static str, caption: &str, published: &str) -> Table {
    let columns = [
        "what",
        "nodes",
        "springs",
        "device",
        "precision",
        "steps a frame",
        "ms a frame: median (least to most)",
        "steps/s",
        "of bandwidth; of FLOP/s",
        published,
        "like for like",
    ];
    Table::new(name, caption, &columns)
}

/// A row of a table of speeds: what a run measured, what is published, and what differs.
pub fn speed(look: &Look, what: &str, job: &str, published: Cell, alike: &str) -> Vec<Cell> {
    if let Err(why) = look.at(job) {
        let mut row = vec![Cell::words(what), Cell::Open(why.clone())];
        row.resize(9, Cell::none());
        row.extend([published, Cell::words(format!("open: {why}"))]);
        return row;
    }
    let words = |key: &'static str| look.cell(job, move |value| value[key].as_str().map(str::to_owned));
    vec![
        Cell::words(what),
        look.count(job, "nodes"),
        look.count(job, "springs"),
        words("device"),
        words("precision"),
        look.count(job, "substeps_per_frame"),
        look.cell(job, |value| {
            let [median, min, max] = ["median", "min", "max"].map(|key| value["ms_per_frame"][key].as_f64());
            Some(format!("{} ({} to {})", short(median?), short(min?), short(max?)))
        }),
        look.cell(job, |value| Some(grouped(value["steps_per_s"].as_f64()?.round() as u64))),
        roofline(look, job),
        published,
        Cell::words(alike),
    ]
}

/// The shares of the machine's limits that a run used.
fn roofline(look: &Look, job: &str) -> Cell {
    if look.at(job).is_ok_and(|kept| kept.result["limits"].is_null()) {
        return Cell::words("not measured");
    }
    look.cell(job, |value| {
        let memory = value["limits"]["memory_fraction"].as_f64()? * 1e2;
        let flops = value["limits"]["fma_fraction"].as_f64();
        Some(
            flops.map_or_else(
                || format!("{memory:.0} %"),
                |flops| format!("{memory:.0} %; {:.0} %", flops * 1e2),
            ),
        )
    })
}

/// Three digits that count.
pub fn short(number: f64) -> String {
    let digits = match number.abs() {
        n if n >= 99.95 => 0,
        n if n >= 9.995 => 1,
        n if n >= 0.9995 => 2,
        _ => 3,
    };
    format!("{number:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_short() {
        assert_eq!([0.0213, 1.234, 12.34, 123.4, 99.96].map(short), ["0.021", "1.23", "12.3", "123", "100"]);
        assert_eq!([7, 1234, 7_820_856].map(grouped), ["7", "1,234", "7,820,856"]);
    }
}
