//! What friction of a pair may be.

use crate::scene::validate::Path;
use crate::scene::{ContactForm, Friction, Scene, SceneError};

/// One of a pair, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    Body(usize),
    Collider(usize),
}

impl Scene {
    /// The body or the collider of a name; of both, the body.
    pub(crate) fn side_named(&self, name: &str) -> Option<Side> {
        let body = (0..self.bodies.len()).find(|&index| self.body_name(index) == name).map(Side::Body);
        let collider = || (0..self.colliders.len()).find(|&index| self.collider_name(index) == name);
        body.or_else(|| collider().map(Side::Collider))
    }

    /// Both sides of a pair, bodies first; none where it names what is not there.
    pub(crate) fn sides(&self, pair: &Friction) -> Option<[Side; 2]> {
        let [a, b] = [0, 1].map(|side| self.side_named(&pair.between[side]));
        Some([a?.min(b?), a?.max(b?)])
    }
}

/// Checks the friction of all pairs.
pub fn check(scene: &Scene) -> Result<(), SceneError> {
    for (index, pair) in scene.frictions.iter().enumerate() {
        let path = Path::item("friction", index);
        path.key("value").not_negative(pair.value, "")?;
        let between = path.key("between");
        for name in &pair.between {
            between.demand(scene.side_named(name).is_some(), || {
                format!(
                    "names `{name}`, and there is no body or collider of that name; {} would do",
                    names(scene)
                )
            })?;
        }
        let sides = scene.sides(pair);
        let before = &scene.frictions[..index];
        let again = before.iter().position(|other| scene.sides(other) == sides);
        between.demand(again.is_none(), || {
            let [a, b] = &pair.between;
            format!(
                "names `{a}` and `{b}`, which friction[{}] has already; one of them would do",
                again.unwrap_or(0)
            )
        })?;
        match sides {
            Some([Side::Collider(_), _]) => between.demand(false, || {
                "names two colliders, which do not touch each other; a body and a collider, or two bodies, would do"
                    .to_owned()
            })?,
            Some([Side::Body(a), Side::Body(b)]) => [a, b].into_iter().try_for_each(|body| {
                let wish = scene.bodies[body].self_collision.as_ref();
                between.demand(wish.is_some_and(|wish| wish.form == ContactForm::Triangles), || {
                    format!(
                        "names `{}`, which has no contact between triangles; self_collision.form = \"triangles\" would do",
                        scene.body_name(body)
                    )
                })
            })?,
            _ => {}
        }
    }
    Ok(())
}

/// Some names that would do.
fn names(scene: &Scene) -> String {
    let bodies = (0..scene.bodies.len()).map(|index| scene.body_name(index));
    let colliders = (0..scene.colliders.len()).map(|index| scene.collider_name(index));
    let some: Vec<String> = bodies.chain(colliders).take(8).map(|name| format!("`{name}`")).collect();
    some.join(", ")
}
