//! Vertex normals: node-centric, area-weighted (Va, Choi, Hong 2021, sec. 3.5).

use crate::real::{add, cross, norm, scale, sub};
use crate::topology::Csr;

/// Unit normals of nodes at `places` [m], each the sum over its triangles of normal times area; +y where a node has
/// none.
pub fn normals(places: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[f64; 3]> {
    let by_node = Csr::corners(places.len(), triangles);
    (0..places.len())
        .map(|node| {
            let around = by_node.row(node).iter().map(|corner| triangles[*corner as usize / 3]);
            let sum = around.fold([0.0; 3], |sum, triangle| {
                let [a, b, c] = triangle.map(|corner| places[corner as usize]);
                add(sum, cross(sub(b, a), sub(c, a)))
            });
            let length = norm(sum);
            if length > 0.0 { scale(sum, 1.0 / length) } else { [0.0, 1.0, 0.0] }
        })
        .collect()
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
        assert!(norm(sub(normal[0], expected)) < 1e-15);
        assert_eq!(normal[2], [0.0, 1.0, 0.0]);
    }
}
