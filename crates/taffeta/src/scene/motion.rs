use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A turn about an axis.
///
/// ```
/// use taffeta::glam::{DQuat, DVec3};
/// use taffeta::scene::Rotation;
///
/// let turned = Rotation::from(DQuat::from_axis_angle(DVec3::Y, 0.5));
/// assert!((turned.degrees - 0.5_f64.to_degrees()).abs() < 1e-12);
/// assert!(DQuat::from(turned).mul_vec3(DVec3::X).z < 0.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Direction of the axis; its length does not matter.
    pub axis: [f64; 3],
    /// Angle [°], right-handed.
    pub degrees: f64,
}

/// A pose at a time. Between keyframes the motion is linear; before the first it starts from rest at t = 0;
/// after the last it stays.
///
/// ```
/// use taffeta::scene::{Collider, Keyframe};
///
/// // A turntable: half a turn about y within two seconds.
/// let table = Collider::cuboid([0.0; 3], [0.5, 0.05, 0.5])
///     .keyframe(Keyframe::translate(0.0, [0.0; 3]))
///     .keyframe(Keyframe::rotate(2.0, [0.0, 1.0, 0.0], 180.0, [0.0; 3]));
/// assert_eq!(table.motion.len(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Time [s].
    pub t: f64,
    /// Shift from the start [m].
    #[serde(default)]
    pub translate: [f64; 3],
    /// Turn from the start, about `pivot`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<Rotation>,
    /// The point [m] that `rotate` turns about, and that `deform` leaves in place.
    #[serde(default)]
    pub pivot: [f64; 3],
    /// Stretch and shear from the start, row by row, about `pivot`, before `rotate`. For pins alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deform: Option<[[f64; 3]; 3]>,
}

impl Keyframe {
    /// A shift by `translate` [m] reached at time `t` [s].
    pub fn translate(t: f64, translate: impl Into<DVec3>) -> Self {
        Self { t, translate: translate.into().to_array(), ..Self::default() }
    }

    /// A turn by `degrees` about `axis` through `pivot`, reached at time `t` [s].
    pub fn rotate(t: f64, axis: impl Into<DVec3>, degrees: f64, pivot: impl Into<DVec3>) -> Self {
        let rotate = Some(Rotation { axis: axis.into().to_array(), degrees });
        Self { t, rotate, pivot: pivot.into().to_array(), ..Self::default() }
    }

    /// Stretch and shear by a matrix, row by row, about `pivot`, reached at time `t` [s]. For pins alone.
    ///
    /// ```
    /// use taffeta::scene::{Body, Keyframe, Material, Mesh, Select};
    ///
    /// // The border of a sheet is pulled to 1.1 times its width within a second.
    /// let pull = Keyframe::deform(1.0, [[1.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
    /// let border = Select { boundary: Some(true), ..Select::default() };
    /// let sheet = Body::cloth("sheet", Mesh::grid(20, 20, [0.2, 0.2])).with_material(Material::preset("cotton"));
    /// let sheet = sheet.pin_moving(border, vec![pull]);
    /// ```
    pub fn deform(t: f64, deform: [[f64; 3]; 3], pivot: impl Into<DVec3>) -> Self {
        Self { t, deform: Some(deform), pivot: pivot.into().to_array(), ..Self::default() }
    }
}

impl From<DQuat> for Rotation {
    /// The turn of at most half a circle.
    fn from(turn: DQuat) -> Self {
        let (axis, angle) = turn.to_axis_angle();
        Self { axis: axis.to_array(), degrees: angle.to_degrees() }
    }
}

impl From<Rotation> for DQuat {
    fn from(Rotation { axis, degrees }: Rotation) -> Self {
        Self::from_axis_angle(DVec3::from(axis).normalize_or(DVec3::Y), degrees.to_radians())
    }
}
