//! The membranes of a body: one for each triangle of a fabric.

use crate::assembly::body::BodyAssembly;
use crate::elements::element::Described;
use crate::elements::membrane::membrane::NO_LIMIT;
use crate::scene::Scene;

/// The membranes of a body, if it is of a fabric.
pub fn membranes(body: &BodyAssembly, _: &Scene, _: usize) -> Described {
    let mut all = Described::default();
    let Some(laid) = body.laid() else { return all };
    for (_, triangle) in laid.in_order(body) {
        let ([a, b, c], area) = (triangle.rest, triangle.area());
        let Some(inverse) = inverse([b[0] - a[0], c[0] - a[0], b[1] - a[1], c[1] - a[1]]) else { continue };
        let fabric = &laid.fabrics[triangle.fabric];
        let [c11, c12, c22, g] = fabric.membrane().map(|stiffness| area * stiffness);
        // A stretch of 1 + e is a Green strain of e + e²/2.
        let limit = fabric.strain_limit.map_or(NO_LIMIT, |e| e + 0.5 * e * e);
        let [i11, i12, i21, i22] = inverse;
        all.push(&triangle.nodes, &[i11, i12, i21, i22, c11, c12, c22, g, fabric.damping.stretch, limit]);
    }
    all
}

/// Inverse of a matrix, row by row; nothing where it has none.
fn inverse([a, b, c, d]: [f64; 4]) -> Option<[f64; 4]> {
    let one_over = 1.0 / (a * d - b * c);
    let all = [d, -b, -c, a].map(|entry| entry * one_over);
    all.iter().all(|entry| entry.is_finite()).then_some(all)
}
