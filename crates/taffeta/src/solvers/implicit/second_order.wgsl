// Steps of second order: with what nodes go on that a surface holds.

#import contact/colliders/predicted_contact.wgsl

/// Velocity [m/s] and acceleration [m/s²].
struct NodeMotion {
    velocity: vec3f,
    rate: vec3f,
}

/// The velocity and the acceleration with which a node goes on, as a surface that holds it wants.
fn motion_of(predicted: PredictedContact, v: vec3f, rate: vec3f) -> NodeMotion {
    if !in_contact(predicted) {
        return NodeMotion(v, rate);
    }
    return NodeMotion(
        filtered(predicted, v) + (predicted.velocity - friction_change(predicted)),
        filtered(predicted, rate),
    );
}
