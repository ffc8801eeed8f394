//! Lengths, areas and volumes of what a mesh holds.
//!
//! ```
//! use taffeta::scene::{Cube, Mesh};
//! use taffeta::topology::{measure, shapes};
//!
//! let cube = shapes::surface(&Mesh::Cube(Cube { size: 0.5, divisions: 1 }))?;
//! let areas = cube.triangles.iter().map(|triangle| measure::area(&cube.nodes, *triangle));
//! assert!((areas.sum::<f64>() - 6.0 * 0.25).abs() < 1e-12);
//! assert!((measure::volume(&cube.nodes, &cube.triangles) - 0.125).abs() < 1e-12);
//! assert_eq!(measure::bounds(&cube.nodes), [[-0.25; 3], [0.25; 3]]);
//! assert_eq!(measure::length(&cube.nodes, [0, 1]), 0.5);
//! # Ok::<(), String>(())
//! ```

use crate::real;

/// Difference a − b.
pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + s b.
pub(crate) fn add_scaled(a: [f64; 3], s: f64, b: [f64; 3]) -> [f64; 3] {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Distance between two nodes [m].
pub fn length(nodes: &[[f64; 3]], pair: [u32; 2]) -> f64 {
    norm(sub(nodes[pair[1] as usize], nodes[pair[0] as usize]))
}

/// Area of a triangle [m²].
pub fn area(nodes: &[[f64; 3]], triangle: [u32; 3]) -> f64 {
    real::area(triangle.map(|i| nodes[i as usize]))
}

/// Area between three corners [m²].
pub fn area_of(corners: [[f64; 3]; 3]) -> f64 {
    real::area(corners)
}

/// Lower and upper corner of the box around points [m]; of no points: two zeros.
pub fn bounds(points: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let Some(&first) = points.first() else { return [[0.0; 3]; 2] };
    points.iter().fold([first; 2], |[lo, hi], p| {
        [[0, 1, 2].map(|i| f64::min(lo[i], p[i])), [0, 1, 2].map(|i| f64::max(hi[i], p[i]))]
    })
}

/// Volume inside a closed surface [m³], positive if its triangles are counter-clockwise from outside:
/// V = Σ a·(b×c)/6, about the middle of the box so that no digits are lost far from the origin.
pub fn volume(nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let [lo, hi] = bounds(nodes);
    let middle = [0, 1, 2].map(|i| 0.5 * (lo[i] + hi[i]));
    let six_fold: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| sub(nodes[i as usize], middle));
            dot(a, cross(b, c))
        })
        .sum();
    six_fold / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_of_the_unit_cube_has_a_sixth_of_its_volume_anywhere() {
        let far = 1e6;
        let nodes = [[far, far, far], [far + 1.0, far, far], [far, far + 1.0, far], [far, far, far + 1.0]];
        let out = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!((volume(&nodes, &out) - 1.0 / 6.0).abs() < 1e-15);
        assert!((area(&nodes, [0, 1, 2]) - 0.5).abs() < 1e-15);
        assert!((length(&nodes, [1, 2]) - 2f64.sqrt()).abs() < 1e-15);
        assert_eq!(bounds(&[]), [[0.0; 3]; 2]);
    }
}
