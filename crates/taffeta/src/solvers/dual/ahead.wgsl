// The surface that will hold a node.

#import contact/colliders/press.wgsl
#import contact/colliders/shape.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/dual/solve.wgsl

/// The surface that will hold a node: of several, that in which it would be deepest. Of meshes, `before` says it.
fn surface_ahead(node: Coming, before: Met) -> Met {
    var found = met_of(free_press(), 0u, 0.0);
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
        let held = press_of(collider, node);
        // Of two that are as deep, the first.
        let is_first = held.inside == deepest && deepest > 0.0 && i < found.surface;
        if held.inside > deepest || is_first {
            deepest = held.inside;
            found = met_of(held.press, i, 0.0);
        }
    }
    return found;
}
