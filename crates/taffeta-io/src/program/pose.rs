//! Poses: rigid motions as the 4 × 4 matrices that programs have.

use taffeta::Pose;
use taffeta::glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

/// How far the columns of a rotation may be from unit vectors that are perpendicular: what 32 bits leave of them.
const ROUNDED: f64 = 1e-5;

/// The pose that a matrix says, row by row; its last column is a shift [m].
///
/// ```
/// use taffeta_io::program::pose;
///
/// let up = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
/// assert_eq!(pose::rigid(up), Ok(pose::shift([0.0, 0.5, 0.0])));
/// assert!(pose::rigid([[2.0; 4]; 4]).is_err());
/// ```
///
/// # Errors
/// What of it is not rigid.
pub fn rigid(rows: [[f64; 4]; 4]) -> Result<Pose, String> {
    if !rows.as_flattened().iter().all(|number| number.is_finite()) {
        return Err("a pose has a number that is not finite".to_owned());
    }
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("the last row of a pose is {:?}; [0, 0, 0, 1] would do", rows[3]));
    }
    let matrix = DMat4::from_cols_array_2d(&rows).transpose();
    let turn = DMat3::from_mat4(matrix);
    let off = turn.transpose() * turn - DMat3::IDENTITY;
    if off.to_cols_array().iter().any(|c| c.abs() > ROUNDED) || turn.determinant() < 0.0 {
        let what = "the upper left 3 × 3 numbers of a pose are no rotation; columns of length 1 that are perpendicular and \
                    right-handed would do";
        return Err(what.to_owned());
    }
    let shift = matrix.w_axis.truncate();
    if turn == DMat3::IDENTITY {
        return Ok(Pose { translate: shift.to_array(), ..Pose::default() });
    }
    Ok(Pose::new(DQuat::from_mat3(&turn).normalize(), shift))
}

/// The pose that is a shift alone [m].
pub fn shift(translate: [f64; 3]) -> Pose {
    Pose { translate, ..Pose::default() }
}

/// The matrix of a rigid motion, row by row, with a shift [m] in its last column.
pub fn matrix(motion: &DAffine3) -> [[f64; 4]; 4] {
    DMat4::from(*motion).transpose().to_cols_array_2d()
}

/// Velocity of the origin [m/s] and angular velocity [rad/s] of a motion that goes evenly from one pose to another within `dt` [s].
pub fn velocity(from: &DAffine3, to: &DAffine3, dt: f64) -> [[f64; 3]; 2] {
    let linear = (to.translation - from.translation) / dt;
    let turn = DQuat::from_mat3(&(to.matrix3 * from.matrix3.transpose()));
    let angular: DVec3 = turn.normalize().to_scaled_axis() / dt;
    [linear.to_array(), angular.to_array()]
}
