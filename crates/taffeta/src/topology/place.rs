//! Where a body starts: scale, then rotate, then translate.

use crate::scene::LARGEST_LENGTH;
use crate::scene::{Place, Rotation};
use crate::topology::measure::{bounds, norm};

/// Scale, then rotate, then translate.
///
/// ```
/// use taffeta::scene::Place;
/// use taffeta::topology::Placement;
///
/// // A mesh of centimetres, to be 0.3 m large.
/// let corners = [[0.0, 0.0, 0.0], [10.0, 60.0, 20.0]];
/// let place = Place { fit: Some(0.3), position: [1.0, 0.0, 0.0], ..Place::default() };
/// let placement = Placement::new(&place, &corners).map_err(|(field, message)| format!("{field} {message}"))?;
/// let top = placement.apply(corners[1]);
/// assert!((top[0] - 1.05).abs() < 1e-12 && (top[1] - 0.3).abs() < 1e-12);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Factor on all lengths, rest lengths among them.
    pub factor: f64,
    /// Rows of the rotation.
    pub rotation: [[f64; 3]; 3],
    /// Shift [m].
    pub position: [f64; 3],
}

impl Placement {
    /// The placement of a body with these nodes [m]; they count where `fit` asks for their largest extent (two
    /// opposite corners of their box would do). The error is (field, message), the field as keys from the body; none where it is
    /// as large as it says.
    pub fn new(place: &Place, nodes: &[[f64; 3]]) -> Result<Self, (&'static str, String)> {
        let factor = match place.fit {
            None => place.scale.unwrap_or(1.0),
            Some(wanted) => wanted / extent(nodes),
        };
        let field = if place.fit.is_some() { "place.fit" } else { "place.scale" };
        let from = extent(nodes);
        if !(factor > 0.0 && factor.is_finite()) {
            return Err((
                field,
                format!("makes a factor of {factor} from an extent of {from} m; more than 0 would do"),
            ));
        }
        if factor * from > LARGEST_LENGTH && place.fit.is_none() && place.scale.is_none() {
            return Err(("", format!("has an extent of {from:e} m; at most {LARGEST_LENGTH} m would do")));
        }
        if factor * from > LARGEST_LENGTH {
            let message = format!(
                "makes an extent of {:e} m from {from} m; at most {LARGEST_LENGTH} m would do",
                factor * from
            );
            return Err((field, message));
        }
        if let Some(far) = place.position.iter().find(|x| x.abs() > LARGEST_LENGTH) {
            let message = format!("is {far:e} m along an axis; within ±{LARGEST_LENGTH} m would do");
            return Err(("place.position", message));
        }
        let rotation = rotation_matrix(&place.rotation.unwrap_or_default());
        Ok(Self { factor, rotation, position: place.position })
    }

    /// Places one point [m].
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let p = point.map(|x| x * self.factor);
        let turned = self.rotation.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
        [0, 1, 2].map(|i| turned[i] + self.position[i])
    }

    /// Places points [m].
    pub fn apply_all(&self, points: &mut [[f64; 3]]) {
        points.iter_mut().for_each(|point| *point = self.apply(*point));
    }
}

/// Largest extent along an axis [m].
fn extent(nodes: &[[f64; 3]]) -> f64 {
    let [lo, hi] = bounds(nodes);
    (0..3).map(|i| hi[i] - lo[i]).fold(0.0, f64::max)
}

/// Rows of the matrix of a right-handed turn, R = cos θ I + sin θ [u]× + (1 − cos θ) u uᵀ (Rodrigues 1840);
/// without an axis the identity.
///
/// ```
/// use taffeta::scene::Rotation;
/// use taffeta::topology::place::rotation_matrix;
///
/// let quarter = rotation_matrix(&Rotation { axis: [0.0, 2.0, 0.0], degrees: 90.0 });
/// assert_eq!(quarter, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
/// ```
pub fn rotation_matrix(rotation: &Rotation) -> [[f64; 3]; 3] {
    let length = norm(rotation.axis);
    let u = if length > 0.0 { rotation.axis.map(|x| x / length) } else { [0.0; 3] };
    let (sin, cos) = if length > 0.0 { sin_cos_degrees(rotation.degrees) } else { (0.0, 1.0) };
    let skew = [[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]];
    let entry = |i: usize, j: usize| {
        let diagonal = if i == j { cos } else { 0.0 };
        diagonal + sin * skew[i][j] + (1.0 - cos) * u[i] * u[j]
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

/// Sine and cosine of an angle [°], exact at quarter turns, so that a sheet turned upright is upright; from libm,
/// the same on all platforms.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let within = degrees.rem_euclid(360.0);
    match [0.0, 90.0, 180.0, 270.0].iter().position(|quarter| *quarter == within) {
        Some(quarter) => [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarter],
        None => libm::sincos(within.to_radians()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(axis: [f64; 3], degrees: f64) -> Option<Rotation> {
        Some(Rotation { axis, degrees })
    }

    #[test]
    fn scale_comes_first_then_the_turn_then_the_shift() {
        let place = Place {
            position: [10.0, 0.0, 0.0],
            rotation: turn([0.0, 0.0, 3.0], 90.0),
            scale: Some(2.0),
            fit: None,
        };
        let placement = Placement::new(&place, &[]).unwrap();
        assert_eq!(placement.factor, 2.0);
        let mut points = [[1.0, 0.0, 0.0], [0.0, 1.0, 5.0]];
        placement.apply_all(&mut points);
        assert_eq!(points, [[10.0, 2.0, 0.0], [8.0, 0.0, 10.0]]);
    }

    #[test]
    fn fit_makes_the_largest_extent_what_is_asked() {
        let place = Place { fit: Some(3.0), ..Place::default() };
        let placement = Placement::new(&place, &[[1.0, 1.0, 1.0], [2.0, 7.0, 0.0]]).unwrap();
        assert_eq!(placement.factor, 0.5);
        let (field, message) = Placement::new(&place, &[[1.0; 3]]).unwrap_err();
        assert_eq!(field, "place.fit");
        assert!(message.contains("extent of 0 m"), "{message}");
    }

    #[test]
    fn what_32_bits_cannot_tell_apart_is_refused() {
        let refused = |place: Place| Placement::new(&place, &[[0.0; 3], [2.0; 3]]).unwrap_err();
        let (field, message) = refused(Place { scale: Some(1e7), ..Place::default() });
        assert_eq!((field, message.contains("extent of 2e7 m from 2 m")), ("place.scale", true), "{message}");
        assert_eq!(refused(Place { fit: Some(1e7), ..Place::default() }).0, "place.fit");
        let (field, message) = Placement::new(&Place::default(), &[[0.0; 3], [2e6; 3]]).unwrap_err();
        assert_eq!((field, message.contains("has an extent of 2e6 m")), ("", true), "{message}");
        let (field, message) = refused(Place { position: [0.0, -1e9, 0.0], ..Place::default() });
        assert_eq!((field, message.contains("is -1e9 m")), ("place.position", true), "{message}");
    }

    #[test]
    fn a_turn_about_any_axis_keeps_lengths_and_the_axis() {
        let m = rotation_matrix(&Rotation { axis: [1.0, 2.0, -2.0], degrees: 77.0 });
        for i in 0..3 {
            for j in 0..3 {
                let dot: f64 = (0..3).map(|k| m[i][k] * m[j][k]).sum();
                assert!((dot - f64::from(i == j)).abs() < 1e-15);
            }
            let kept: f64 = (0..3).map(|k| m[i][k] * [1.0, 2.0, -2.0][k]).sum();
            assert!((kept - [1.0, 2.0, -2.0][i]).abs() < 1e-15);
        }
        assert_eq!(rotation_matrix(&Rotation { axis: [0.0; 3], degrees: 30.0 })[0], [1.0, 0.0, 0.0]);
        assert_eq!(sin_cos_degrees(-450.0), (-1.0, 0.0));
    }
}
