//! Transforms in 64 bits, and the engine's words for them.

use bevy::math::{DAffine3, DQuat, DVec3};
use bevy::prelude::*;
use taffeta::Pose;
use taffeta::scene::{Keyframe, Place, Rotation};

/// A rigid motion in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// Turn about the origin.
    pub turn: DQuat,
    /// Shift after it [m].
    pub shift: DVec3,
}

impl Rigid {
    /// A transform without its scale.
    pub fn of(transform: &GlobalTransform) -> Self {
        let (_, turn, shift) = transform.to_scale_rotation_translation();
        Self { turn: turn.as_dquat().normalize(), shift: shift.as_dvec3() }
    }

    /// Of a motion that neither stretches nor shears.
    pub fn of_motion(motion: DAffine3) -> Self {
        Self { turn: DQuat::from_mat3(&motion.matrix3), shift: motion.translation }
    }

    /// The motion that brings what was at `start` to here.
    pub fn since(&self, start: &Self) -> Self {
        let turn = self.turn * start.turn.inverse();
        Self { turn, shift: self.shift - turn * start.shift }
    }

    /// First `before`, then this.
    pub fn after(&self, before: &Self) -> Self {
        Self { turn: self.turn * before.turn, shift: self.turn * before.shift + self.shift }
    }

    /// A share of the way from here to `to`, the short way round.
    pub fn toward(&self, to: &Self, share: f64) -> Self {
        Self { turn: self.turn.slerp(to.turn, share), shift: self.shift.lerp(to.shift, share) }
    }

    /// As the engine moves colliders and pins.
    pub fn pose(&self) -> Pose {
        Pose::new(self.turn, self.shift)
    }

    /// As the only keyframe: what follows it starts there, and can be moved.
    pub fn keyframe(&self) -> Keyframe {
        let translate = self.shift.to_array();
        Keyframe { translate, rotate: Some(self.turn.into()), ..Keyframe::default() }
    }

    /// As a transform.
    pub fn transform(&self, scale: Vec3) -> Transform {
        Transform { translation: self.shift.as_vec3(), rotation: self.turn.as_quat(), scale }
    }
}

/// Where something is in the world that has this place in the coordinates of a transform. Of the scale the mean counts:
/// springs and colliders know no other.
pub fn place_in_world(transform: &GlobalTransform, place: &Place) -> Place {
    if *transform == GlobalTransform::IDENTITY {
        return place.clone();
    }
    let (scale, ..) = transform.to_scale_rotation_translation();
    let scale = f64::from(scale.element_sum()) / 3.0;
    let rigid = Rigid::of(transform);
    let Rotation { axis, degrees } =
        place.rotation.unwrap_or(Rotation { axis: [0.0, 1.0, 0.0], degrees: 0.0 });
    let axis = DVec3::from(axis).try_normalize().unwrap_or(DVec3::Y);
    let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
    let whole = Rigid { turn: rigid.turn * turn, shift: rigid.shift };
    Place {
        position: (rigid.turn * (scale * DVec3::from(place.position)) + rigid.shift).to_array(),
        rotation: Some(whole.turn.into()),
        scale: place.fit.is_none().then(|| scale * place.scale.unwrap_or(1.0)),
        fit: place.fit.map(|fit| scale * fit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_below_a_transform_is_turned_scaled_and_shifted_by_it() {
        let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let above =
            Transform { translation: Vec3::new(0.0, 1.0, 0.0), rotation: turn, scale: Vec3::splat(2.0) };
        let place = Place { position: [1.0, 0.0, 0.0], scale: Some(3.0), ..Place::default() };
        let found = place_in_world(&above.into(), &place);
        assert!(DVec3::from(found.position).distance(DVec3::new(0.0, 1.0, -2.0)) < 1e-6);
        assert_eq!(found.scale, Some(6.0));
        assert!((found.rotation.unwrap().degrees - 90.0).abs() < 1e-4);
        assert_eq!(place_in_world(&GlobalTransform::IDENTITY, &place).position, place.position);
    }

    #[test]
    fn what_was_at_the_start_is_brought_to_where_the_entity_is() {
        let at = |angle, x| Rigid { turn: DQuat::from_rotation_z(angle), shift: DVec3::new(x, 2.0, 0.0) };
        let (start, now) = (at(0.3, 1.0), at(1.0, -4.0));
        let back = now.since(&start).after(&start);
        assert!(back.shift.distance(now.shift) < 1e-12 && back.turn.angle_between(now.turn) < 1e-6);
    }
}
