//! Places in a scene, and what may stand there.

use crate::scene::error::SceneError;
use crate::scene::validate::shape::LARGEST_LENGTH;

/// Largest and smallest size of a number: beyond, 32 bits and squares have no room for it.
const LARGEST: f64 = 1e15;
pub(crate) const SMALLEST: f64 = 1e-15;
/// Largest velocity [m/s], and angular velocity [rad/s], that a body may start with.
const LARGEST_RATE: f64 = 1e6;

pub(crate) type Checked = Result<(), SceneError>;

/// Keys and indices from the scene down: `body[0].pin[1].motion[2].t`.
pub(crate) struct Path(String);

impl Path {
    pub(crate) fn of(key: &str) -> Self {
        Self(key.into())
    }

    pub(crate) fn item(key: &str, index: usize) -> Self {
        Self(format!("{key}[{index}]"))
    }

    pub(crate) fn key(&self, key: &str) -> Self {
        Self(format!("{}.{key}", self.0))
    }

    pub(crate) fn nth(&self, key: &str, index: usize) -> Self {
        Self(format!("{}.{key}[{index}]", self.0))
    }

    pub(crate) fn error(&self, message: &str) -> SceneError {
        SceneError::new(self.0.as_str(), message)
    }

    pub(crate) fn refuse(&self, message: &str) -> Checked {
        Err(self.error(message))
    }

    pub(crate) fn demand(&self, met: bool, message: impl FnOnce() -> String) -> Checked {
        if met { Ok(()) } else { self.refuse(&message()) }
    }

    pub(crate) fn positive(&self, value: f64, unit: &str) -> Checked {
        self.demand(value > 0.0 && value.is_finite(), || {
            format!("is {}, more than 0 would do", quantity(value, unit))
        })?;
        let within = format!("{} to {}", plain(SMALLEST), quantity(LARGEST, unit));
        self.demand((SMALLEST..=LARGEST).contains(&value), || {
            format!("is {}, {within} would do", quantity(value, unit))
        })
    }

    pub(crate) fn not_negative(&self, value: f64, unit: &str) -> Checked {
        let met = value >= 0.0 && value.is_finite();
        self.demand(met, || format!("is {}, 0 or more would do", quantity(value, unit)))?;
        self.demand(value <= LARGEST, || {
            format!("is {}, up to {} would do", quantity(value, unit), quantity(LARGEST, unit))
        })
    }

    /// A length that a shape may have [m].
    pub(crate) fn length(&self, value: f64) -> Checked {
        self.positive(value, "m")?;
        self.short(value)
    }

    /// No longer than a shape may be [m].
    pub(crate) fn short(&self, value: f64) -> Checked {
        self.demand(value <= LARGEST_LENGTH, || {
            format!("is {} m, at most {LARGEST_LENGTH} m would do", plain(value))
        })
    }

    /// A place that a shape may have, or a way that it may go [m].
    pub(crate) fn within(&self, place: &[f64]) -> Checked {
        self.finite(place)?;
        let far = place.iter().any(|x| x.abs() > LARGEST_LENGTH);
        self.demand(!far, || format!("is {place:?} m, within ±{LARGEST_LENGTH} m would do"))
    }

    /// A velocity that a body may start with, in this unit.
    pub(crate) fn rate(&self, velocity: &[f64], unit: &str) -> Checked {
        self.finite(velocity)?;
        let fast = velocity.iter().any(|v| v.abs() > LARGEST_RATE);
        self.demand(!fast, || format!("is {velocity:?} {unit}, within ±{LARGEST_RATE} {unit} would do"))
    }

    /// From 0 to 1.
    pub(crate) fn share(&self, value: f64) -> Checked {
        self.demand((0.0..=1.0).contains(&value), || format!("is {value}, 0 to 1 would do"))
    }

    pub(crate) fn finite(&self, values: &[f64]) -> Checked {
        let odd = values.iter().any(|x| !x.is_finite());
        self.demand(!odd, || format!("is {values:?}, finite numbers would do"))?;
        let far = values.iter().any(|x| x.abs() > LARGEST);
        self.demand(!far, || format!("is {values:?}, numbers up to {} would do", plain(LARGEST)))
    }

    /// A vector whose length does not matter, but that has one.
    pub(crate) fn direction(&self, axis: [f64; 3]) -> Checked {
        let squared: f64 = axis.iter().map(|x| x * x).sum();
        let met = squared.is_normal();
        self.demand(met, || format!("is {axis:?}, a direction like [0, 1, 0] would do"))
    }
}

fn quantity(value: f64, unit: &str) -> String {
    format!("{} {unit}", plain(value)).trim_end().into()
}

/// A number for people: with an exponent where it would have many zeros.
pub(crate) fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-4..1e9).contains(&size) { value.to_string() } else { format!("{value:e}") }
}
