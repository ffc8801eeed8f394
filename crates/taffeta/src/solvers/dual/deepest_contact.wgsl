// The deepest predicted contact of a node.

#import contact/colliders/met.wgsl
#import contact/colliders/predicted_contact.wgsl
#import contact/colliders/shape.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/dual/solve.wgsl

/// The predicted contact of the node at a place: of several colliders, the deepest. Contacts with meshes are in `before`.
fn deepest_contact(place: u32, node: Approach, before: ContactRecord) -> ContactRecord {
    var found = contact_record(no_contact(), 0u, 0.0);
    var deepest = 0.0;
    if before.inside > 0.0 {
        found = before;
        deepest = before.inside;
    }
    let met = met_by(place, 0u);
    for (var i = 0u; i < met.count; i++) {
        let collider = collider_met(met, i);
        if collider.kind == MESH {
            continue;
        }
        let candidate = predict_contact(collider, node);
        // Of two colliders with the same depth, the first.
        let is_first = candidate.inside == deepest && deepest > 0.0 && i < found.collider;
        if candidate.inside > deepest || is_first {
            deepest = candidate.inside;
            found = contact_record(candidate.predicted, i, 0.0);
        }
    }
    return found;
}
