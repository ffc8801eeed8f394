//! Vertex normals: node-centric, area-weighted (Va, Choi, Hong 2021, sec. 3.5).

use crate::real::{Real, dot, scale, sub};
use crate::topology::Csr;

/// sum + p × q, the products added one after the other, as some shader compilers order them anyway.
fn add_cross<T: Real>(sum: [T; 3], p: [T; 3], q: [T; 3]) -> [T; 3] {
    [
        (sum[0] + p[1] * q[2]) - p[2] * q[1],
        (sum[1] + p[2] * q[0]) - p[0] * q[2],
        (sum[2] + p[0] * q[1]) - p[1] * q[0],
    ]
}

/// Unit normals of nodes at `places` [m], each the sum over its triangles of normal times area; +y where a node has
/// none.
pub(crate) fn normals<T: Real>(places: &[[T; 3]], triangles: &[[u32; 3]]) -> Vec<[T; 3]> {
    sums(places, triangles).into_iter().map(unit_or_up).collect()
}

/// Twice the sum over each node's triangles of normal times area [m²].
pub(crate) fn sums<T: Real>(places: &[[T; 3]], triangles: &[[u32; 3]]) -> Vec<[T; 3]> {
    let by_node = Csr::corners(places.len(), triangles);
    let sum_of = |node| {
        let around = by_node.row(node).iter().map(|corner| triangles[*corner as usize / 3]);
        around.fold([T::ZERO; 3], |sum, triangle| {
            let [a, b, c] = triangle.map(|corner| places[corner as usize]);
            add_cross(sum, sub(b, a), sub(c, a))
        })
    };
    (0..places.len()).map(sum_of).collect()
}

/// The unit vector along `sum`; +y where that has no length.
pub(crate) fn unit_or_up<T: Real>(sum: [T; 3]) -> [T; 3] {
    let squared = dot(sum, sum);
    if squared > T::TINY { scale(sum, (T::ONE / squared).sqrt()) } else { [T::ZERO, T::ONE, T::ZERO] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ridge_gets_the_mean_of_its_sides_weighted_by_area() {
        // One side flat (normal +y, area 2), the other upright (normal +x, area 0.5); both meet at nodes 0 and 1.
        let places = [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [-4.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let normal = normals(&places, &[[0, 1, 2], [0, 3, 1]]);
        let expected = scale([1.0, 4.0, 0.0], 1.0 / 17.0_f64.sqrt());
        assert!(crate::real::norm(sub(normal[0], expected)) < 1e-15);
        assert_eq!(normal[2], [0.0, 1.0, 0.0]);
    }
}
