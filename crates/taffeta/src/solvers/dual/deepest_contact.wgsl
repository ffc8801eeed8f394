// The surface that will hold a node.

#import contact/colliders/predicted_contact.wgsl
#import contact/colliders/shape.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/dual/solve.wgsl

/// The surface that will hold a node: of several, that in which it would be deepest. Of meshes, `before` says it.
fn deepest_contact(node: Approach, before: ContactRecord) -> ContactRecord {
    var found = contact_record(no_contact(), 0u, 0.0);
    var deepest = 0.0;
    if before.inside > 0.0 {
        found = before;
        deepest = before.inside;
    }
    let first = substeps[0].first_collider;
    for (var i = 0u; i < substeps[0].colliders; i++) {
        let collider = colliders[first + i];
        if collider.kind == MESH {
            continue;
        }
        let candidate = predict_contact(collider, node);
        // Of two that are as deep, the first.
        let is_first = candidate.inside == deepest && deepest > 0.0 && i < found.collider;
        if candidate.inside > deepest || is_first {
            deepest = candidate.inside;
            found = contact_record(candidate.predicted, i, 0.0);
        }
    }
    return found;
}
