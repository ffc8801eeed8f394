//! Which bodies touch each other.

use crate::scene::validate::Path;
use crate::scene::{Body, ContactForm, Scene, SceneError};
use std::collections::HashMap;

/// Checks whom a body is to touch, and whom not.
pub fn check(
    scene: &Scene,
    index: usize,
    body: &Body,
    names: &HashMap<String, usize>,
) -> Result<(), SceneError> {
    let Some(wish) = &body.self_collision else { return Ok(()) };
    let path = Path::item("body", index).key("self_collision");
    for (key, list) in [("with", &wish.with), ("without", &wish.without)] {
        let path = path.key(key);
        path.demand(list.is_empty() || wish.form == ContactForm::Triangles, || {
            "is for contact between triangles; form = \"triangles\", or nothing, would do".into()
        })?;
        for name in list {
            let Some(&other) = names.get(name) else {
                return path
                    .demand(false, || format!("there is no body `{name}`; {} would do", scene.some_names()));
            };
            path.demand(other != index, || {
                format!("names `{name}` itself, which always touches itself; other bodies would do")
            })?;
            let touches = scene.bodies[other].self_collision.as_ref();
            path.demand(touches.is_some_and(|wish| wish.form == ContactForm::Triangles), || {
                format!(
                    "names `{name}`, which has no contact between triangles; bodies that have some would do"
                )
            })?;
        }
    }
    path.demand(wish.with.is_empty() || wish.without.is_empty(), || {
        "has `with` and `without`; one of them would do".into()
    })
}
