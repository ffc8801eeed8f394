//! The camera in the user's hand: it orbits a point, shifts with it, comes near and goes away.

use crate::busy::Busy;
use crate::framing::{Extent, FIELD};
use crate::grab::Grab;
use crate::stage::StageCamera;
use bevy::ecs::system::SystemParam;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit};
use bevy::prelude::*;

/// Turn of the camera for a pixel of the mouse's way [rad].
const TURN: f32 = 0.006;
/// Share of the distance that is left after a notch of the wheel.
const NOTCH: f32 = 0.88;
/// Pixels that a touchpad scrolls for a notch.
const PIXELS: f32 = 60.0;
/// Nearest to straight up or down that the camera looks [rad].
const STEEPEST: f32 = 1.54;

/// A camera that looks at a point from some distance.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point [m].
    pub about: Vec3,
    /// [m]
    pub distance: f32,
    /// Angle about the vertical from +z, and above the horizon [rad].
    pub heading: f32,
    pub elevation: f32,
}

impl Orbit {
    /// As a camera is that looks at the plane across its view through `middle`.
    pub fn of(camera: &Transform, middle: Vec3) -> Self {
        let back = camera.back().as_vec3();
        let distance = (camera.translation - middle).dot(back).max(1e-3);
        Self {
            about: camera.translation - distance * back,
            distance,
            heading: back.x.atan2(back.z),
            elevation: back.y.clamp(-1.0, 1.0).asin(),
        }
    }

    /// Where the camera is.
    pub fn transform(&self) -> Transform {
        let turn = Quat::from_euler(EulerRot::YXZ, self.heading, -self.elevation, 0.0);
        Transform {
            translation: self.about + self.distance * (turn * Vec3::Z),
            rotation: turn,
            scale: Vec3::ONE,
        }
    }

    /// Goes round by a way of the mouse [pixel].
    pub fn turn(&mut self, way: Vec2) {
        self.heading -= TURN * way.x;
        self.elevation = (self.elevation + TURN * way.y).clamp(-STEEPEST, STEEPEST);
    }

    /// Shifts so that the point under the mouse stays there, in a picture of this height [pixel].
    pub fn shift(&mut self, way: Vec2, height: f32) {
        let pixel = 2.0 * self.distance * (0.5 * FIELD).tan() / height.max(1.0);
        let turn = self.transform().rotation;
        self.about += pixel * (turn * Vec3::new(-way.x, way.y, 0.0));
    }

    /// Comes nearer by notches of the wheel.
    pub fn come(&mut self, notches: f32, extent: &Extent) {
        let range = 0.02 * extent.radius..=50.0 * extent.radius;
        self.distance = (self.distance * NOTCH.powf(notches)).clamp(*range.start(), *range.end());
    }
}

/// A camera that is led by mouse and keys.
pub fn orbit(app: &mut App) {
    app.add_systems(PostStartup, take_camera).add_systems(Update, (lead, frame_again));
}

fn take_camera(
    mut commands: Commands,
    cameras: Query<(Entity, &Transform), With<StageCamera>>,
    extent: Res<Extent>,
) {
    for (camera, transform) in &cameras {
        commands.entity(camera).insert(Orbit::of(transform, extent.middle));
    }
}

/// What the mouse does.
#[derive(SystemParam)]
struct Mouse<'w> {
    buttons: Res<'w, ButtonInput<MouseButton>>,
    motion: Res<'w, AccumulatedMouseMotion>,
    scroll: Res<'w, AccumulatedMouseScroll>,
}

/// Left or right drag goes round, with shift, or with the middle button, it shifts; the wheel comes nearer.
fn lead(
    mouse: Mouse,
    keys: Res<ButtonInput<KeyCode>>,
    busy: Res<Busy>,
    grab: Res<Grab>,
    extent: Res<Extent>,
    mut dragged: Local<bool>,
    mut cameras: Query<(&mut Orbit, &mut Transform, &Camera)>,
) {
    let Mouse { buttons, motion, scroll } = mouse;
    let all = [MouseButton::Left, MouseButton::Right, MouseButton::Middle];
    if buttons.any_just_pressed(all) {
        *dragged = !busy.pointer;
    }
    let [left, right, middle] = all.map(|button| buttons.pressed(button));
    let leads = *dragged && (right || middle || left && !grab.holds());
    let notches = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / PIXELS,
    };
    let comes = notches != 0.0 && !busy.pointer;
    let turns = leads && motion.delta != Vec2::ZERO;
    if !comes && !turns {
        return;
    }
    for (mut orbit, mut transform, camera) in &mut cameras {
        let height = camera.logical_viewport_size().map_or(1.0, |size| size.y);
        if turns {
            if middle || keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]) {
                orbit.shift(motion.delta, height);
            } else {
                orbit.turn(motion.delta);
            }
        }
        if comes {
            orbit.come(notches, &extent);
        }
        *transform = orbit.transform();
    }
}

/// F brings the whole scene back into the picture.
fn frame_again(
    keys: Res<ButtonInput<KeyCode>>,
    busy: Res<Busy>,
    extent: Res<Extent>,
    mut cameras: Query<(&mut Orbit, &mut Transform, &Camera)>,
) {
    if !keys.just_pressed(KeyCode::KeyF) || busy.keys {
        return;
    }
    for (mut orbit, mut transform, camera) in &mut cameras {
        let size = camera.logical_viewport_size().unwrap_or(Vec2::new(16.0, 9.0));
        *transform = extent.camera(size.x / size.y.max(1.0), None, None);
        *orbit = Orbit::of(&transform, extent.middle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Orbit {
        Orbit { about: Vec3::new(1.0, 2.0, 3.0), distance: 4.0, heading: 0.7, elevation: 0.3 }
    }

    #[test]
    fn a_camera_is_found_again_from_where_it_is() {
        let orbit = some();
        let found = Orbit::of(&orbit.transform(), orbit.about);
        assert!(found.about.distance(orbit.about) < 1e-5 && (found.distance - 4.0).abs() < 1e-5);
        assert!((found.heading - 0.7).abs() < 1e-5 && (found.elevation - 0.3).abs() < 1e-5);
    }

    #[test]
    fn going_round_keeps_the_distance_and_looks_at_the_point() {
        let mut orbit = some();
        orbit.turn(Vec2::new(300.0, -900.0));
        let camera = orbit.transform();
        assert!((camera.translation.distance(orbit.about) - 4.0).abs() < 1e-5);
        let towards = (orbit.about - camera.translation).normalize();
        assert!(camera.forward().as_vec3().abs_diff_eq(towards, 1e-5));
        assert!(camera.up().y > 0.0, "never upside down");
    }

    #[test]
    fn what_is_shifted_stays_under_the_mouse() {
        let mut orbit = some();
        let (before, height) = (orbit.transform(), 720.0);
        let seen = |camera: &Transform, point: Vec3| {
            let local = camera.rotation.inverse() * (point - camera.translation);
            Vec2::new(local.x, -local.y) / (-local.z * (0.5 * FIELD).tan()) * 0.5 * height
        };
        let way = Vec2::new(120.0, -45.0);
        let point = orbit.about;
        orbit.shift(way, height);
        let moved = seen(&orbit.transform(), point) - seen(&before, point);
        assert!(moved.abs_diff_eq(way, 1e-2), "{moved}");
    }
}
