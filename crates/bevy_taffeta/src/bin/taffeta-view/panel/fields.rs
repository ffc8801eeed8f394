//! Values of a table of the scene format as sliders and fields: one line of a list for each key.

use bevy_egui::egui::{self, DragValue, Slider, SliderClamping, Ui};

/// A key of a table `T`, with its unit and what it may be.
pub struct Field<T> {
    /// As scenes have it.
    pub key: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it is.
    pub value: Value<T>,
}

/// A value of a table, and where a slider for it ends. What is typed may be beyond that: the engine says what is too much.
pub enum Value<T> {
    /// From 0 on, evenly by powers of ten from the first number to the second.
    Log(f64, f64, fn(&mut T) -> &mut f64),
    /// Evenly from the first number to the second.
    Even(f64, f64, fn(&mut T) -> &mut f64),
    /// A whole number, up to this.
    Whole(u32, fn(&mut T) -> &mut u32),
    /// A seed.
    Seed(fn(&mut T) -> &mut u64),
    /// Yes or no.
    Flag(fn(&mut T) -> &mut bool),
    /// Three numbers, and how much a pixel changes them.
    Three(f64, fn(&mut T) -> &mut [f64; 3]),
}

impl<T> Field<T> {
    /// A field.
    pub const fn new(key: &'static str, unit: &'static str, value: Value<T>) -> Self {
        Self { key, unit, value }
    }
}

/// Width of keys [point].
const KEY: f32 = 96.0;
/// Width of the bar of a slider [point].
const BAR: f32 = 104.0;

/// Shows fields; returns whether one was changed.
pub fn fields<T>(ui: &mut Ui, fields: &[Field<T>], of: &mut T) -> bool {
    fields.iter().fold(false, |changed, field| field.show(ui, of) | changed)
}

impl<T> Field<T> {
    fn show(&self, ui: &mut Ui, of: &mut T) -> bool {
        row(ui, self.key, |ui| match &self.value {
            Value::Log(low, high, get) => slider(ui, get(of), (*low, *high), true, self.unit),
            Value::Even(low, high, get) => slider(ui, get(of), (*low, *high), false, self.unit),
            Value::Whole(most, get) => {
                let slider = Slider::new(get(of), 0..=*most).logarithmic(*most > 1000);
                ui.add(slider.clamping(SliderClamping::Never)).changed()
            }
            Value::Seed(get) => ui.add(DragValue::new(get(of)).speed(0.05)).changed(),
            Value::Flag(get) => ui.checkbox(get(of), "").changed(),
            Value::Three(speed, get) => three(ui, get(of), *speed, self.unit),
        })
    }
}

/// A key, and beside it what is shown of its value.
pub fn row<R>(ui: &mut Ui, key: &str, value: impl FnOnce(&mut Ui) -> R) -> R {
    let line = ui.horizontal(|ui| {
        let size = egui::vec2(KEY, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.set_min_width(KEY);
            ui.add(egui::Label::new(key).truncate());
        });
        value(ui)
    });
    line.inner
}

/// A slider from `low` to `high`; with powers of ten it starts at 0, below `low`.
fn slider(ui: &mut Ui, value: &mut f64, (low, high): (f64, f64), log: bool, unit: &str) -> bool {
    ui.spacing_mut().slider_width = BAR;
    let range = if log { 0.0..=high } else { low..=high };
    let slider = Slider::new(value, range)
        .logarithmic(log)
        .smallest_positive(low)
        .clamping(SliderClamping::Never)
        .smart_aim(true)
        .custom_formatter(|value, _| number(value))
        .custom_parser(|text| text.trim().parse().ok());
    let changed = ui.add(slider).changed();
    ui.weak(unit);
    changed
}

fn three(ui: &mut Ui, value: &mut [f64; 3], speed: f64, unit: &str) -> bool {
    ui.spacing_mut().item_spacing.x = 3.0;
    let mut changed = false;
    for number in value {
        let field = DragValue::new(number).speed(speed).max_decimals(3);
        changed |= ui.add_sized([46.0, ui.spacing().interact_size.y], field).changed();
    }
    ui.weak(unit);
    changed
}

/// A number with four digits, in powers of ten where it is small or large.
pub fn number(value: f64) -> String {
    rounded(value, 4)
}

/// A number with some digits, in powers of ten where it is small or large.
pub fn rounded(value: f64, digits: i32) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e5).contains(&size) {
        let text = format!("{value:.2e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.'))
    } else {
        let decimals = (digits - 1 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }
}

/// A choice of one among several, by name; returns whether it was changed.
pub fn choice<E: Copy + PartialEq>(ui: &mut Ui, key: &str, all: &[(E, &str)], value: &mut E) -> bool {
    let before = *value;
    row(ui, key, |ui| {
        let name = all.iter().find(|(one, _)| one == value).map_or("", |(_, name)| name);
        egui::ComboBox::from_id_salt((key, ui.id())).selected_text(name).width(140.0).show_ui(ui, |ui| {
            for (one, name) in all {
                ui.selectable_value(value, *one, *name);
            }
        });
    });
    *value != before
}

/// A table that may be absent, under a tick; `or` is what it starts with. Returns whether it was changed.
pub fn optional<T: Clone>(
    ui: &mut Ui,
    key: &str,
    value: &mut Option<T>,
    or: T,
    show: impl FnOnce(&mut Ui, &mut T) -> bool,
) -> bool {
    let mut there = value.is_some();
    let mut changed = ui.checkbox(&mut there, egui::RichText::new(key).strong()).changed();
    if changed {
        *value = there.then_some(or);
    }
    if let Some(value) = value {
        changed |= ui.indent(key, |ui| show(ui, value)).inner;
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_four_digits_whatever_their_size() {
        let written = [
            (0.0, "0"),
            (1e-7, "1e-7"),
            (2.34e-7, "2.34e-7"),
            (0.001, "0.001"),
            (0.016666667, "0.01667"),
            (9.81, "9.81"),
            (-9.81, "-9.81"),
            (100.0, "100"),
            (1234.5, "1234"),
            (2.5e6, "2.5e6"),
        ];
        for (value, text) in written {
            assert_eq!(number(value), text);
        }
    }
}
