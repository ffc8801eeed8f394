//! What of the door needs no Python. Everything else is tested from Python, by `cargo xtask test`.

use std::f64::consts::FRAC_PI_2;
use taffeta::glam::{DAffine3, DQuat, DVec3};
use taffeta_io::program::pose::{matrix, rigid, shift, velocity};

/// A quarter turn about y and a shift: x goes to -z.
const QUARTER: [[f64; 4]; 4] =
    [[0.0, 0.0, 1.0, 0.1], [0.0, 1.0, 0.0, 0.2], [-1.0, 0.0, 0.0, 0.3], [0.0, 0.0, 0.0, 1.0]];

#[test]
fn a_matrix_is_a_turn_and_a_shift() {
    let found = rigid(QUARTER).expect("a pose");
    assert_eq!(found.translate, [0.1, 0.2, 0.3]);
    assert!((found.rotate.degrees - 90.0).abs() < 1e-12, "{found:?}");
    assert!((DVec3::from(found.rotate.axis) - DVec3::Y).length() < 1e-12, "{found:?}");
    let motion = DAffine3::from_rotation_translation(DQuat::from(found.rotate), found.translate.into());
    let rows = matrix(&motion);
    let off = rows.as_flattened().iter().zip(QUARTER.as_flattened()).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-12);
}

#[test]
fn a_matrix_without_a_turn_is_a_shift_to_the_last_bit() {
    let mut rows = [[1.0, 0.0, 0.0, 0.1], [0.0, 1.0, 0.0, -0.3], [0.0, 0.0, 1.0, 0.7], [0.0, 0.0, 0.0, 1.0]];
    assert_eq!(rigid(rows), Ok(shift([0.1, -0.3, 0.7])));
    rows[1][1] = 2.0;
    assert!(rigid(rows).is_err_and(|what| what.contains("no rotation")));
    rows[1][1] = -1.0;
    assert!(rigid(rows).is_err(), "a reflection");
    rows[1][1] = f64::NAN;
    assert!(rigid(rows).is_err_and(|what| what.contains("not finite")));
    rows[3] = [0.0; 4];
    rows[1][1] = 1.0;
    assert!(rigid(rows).is_err_and(|what| what.contains("last row")));
}

#[test]
fn an_even_motion_has_the_velocity_that_brings_it_there() {
    let to =
        DAffine3::from_rotation_translation(DQuat::from_rotation_y(FRAC_PI_2), DVec3::new(0.0, 0.0, 0.5));
    let [linear, angular] = velocity(&DAffine3::IDENTITY, &to, 0.25);
    assert_eq!(linear, [0.0, 0.0, 2.0]);
    assert!((angular[1] - 4.0 * FRAC_PI_2).abs() < 1e-12 && angular[0] == 0.0 && angular[2] == 0.0);
}
