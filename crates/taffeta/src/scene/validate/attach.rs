//! What seams, pins that break and tethers may be.

use crate::scene::validate::MOST_NAMES;
use crate::scene::validate::body::check_select;
use crate::scene::validate::collider::check_poses;
use crate::scene::validate::path::{Checked, Path, plain};
use crate::scene::{Body, Closing, Pin, Scene, Seam, SeamSide};
use std::collections::HashMap;

/// `names` are those of the bodies.
pub(crate) fn check_seam(scene: &Scene, path: &Path, seam: &Seam, names: &HashMap<String, usize>) -> Checked {
    for (key, side) in [("from", &seam.from), ("to", &seam.to)] {
        let path = path.key(key);
        path.key("body").demand(names.contains_key(&side.body), || {
            format!("there is no body `{}`; {} would do", side.body, scene.some_names())
        })?;
        if let Some(select) = &side.select {
            check_select(&path.key("select"), select)?;
        }
    }
    check_ways(path, seam)?;
    path.key("length").not_negative(seam.length, "m")?;
    let close = path.key("close");
    close.key("start").not_negative(seam.close.start, "s")?;
    close.key("end").not_negative(seam.close.end, "s")?;
    let closed = Closing::default().end;
    close.key("start").demand(seam.close.start < closed || seam.close.end != closed, || {
        format!(
            "is {} s, and the seam is closed at {closed} s where close.end does not say otherwise; a later close.end would do",
            seam.close.start
        )
    })?;
    close.key("end").demand(seam.close.end > seam.close.start, || {
        format!("is {} s, and it starts at {} s; later than that would do", seam.close.end, seam.close.start)
    })?;
    let (way, step) = (seam.close.end - seam.close.start, scene.time.substep(0).1);
    close.key("end").demand(way >= step, || {
        format!(
            "is {} s after the start, less than a sub-step of {} s: its nodes would jump; that or more would do",
            plain(way),
            plain(step)
        )
    })?;
    seam.k.map_or(Ok(()), |k| path.key("k").positive(k, "N/m"))?;
    check_break(path, seam.break_force)
}

/// Pairs are given in one way.
fn check_ways(path: &Path, seam: &Seam) -> Checked {
    let sides = [("from", &seam.from), ("to", &seam.to)];
    let selected = sides.iter().find(|(_, side)| side.select.is_some());
    match (&seam.pairs, seam.reach, selected) {
        (Some(_), Some(_), _) => path.refuse("has pairs and reach; one of them would do"),
        (Some(_), None, Some((key, _))) => path
            .key(key)
            .key("select")
            .refuse("says which nodes, as pairs do; pairs alone, or both selections, would do"),
        (Some(pairs), None, None) => {
            path.key("pairs").demand(!pairs.is_empty(), || "is empty; one pair or more would do".into())
        }
        (None, Some(reach), _) => path.key("reach").positive(reach, "m"),
        (None, None, _) => {
            let missing: Option<&(&str, &SeamSide)> = sides.iter().find(|(_, side)| side.select.is_none());
            missing.map_or(Ok(()), |(key, _)| {
                path.key(key).refuse("has no select; two selections, pairs or reach would do")
            })
        }
    }
}

fn check_break(path: &Path, force: Option<f64>) -> Checked {
    force.map_or(Ok(()), |force| path.key("break_force").positive(force, "N"))
}

/// Names of colliders fit into a line and are their own, and pins on colliders name one of them.
pub(crate) fn check_carried(scene: &Scene) -> Checked {
    let names: Vec<String> = (0..scene.colliders.len()).map(|i| scene.collider_name(i)).collect();
    let mut seen = HashMap::new();
    for (i, name) in names.iter().enumerate() {
        let short = name.len() <= 100 && !name.contains(char::is_control);
        Path::item("collider", i)
            .key("name")
            .demand(short, || format!("is {name:?}; up to 100 letters in a line would do"))?;
        if let Some(twin) = seen.insert(name, i) {
            return Path::item("collider", i)
                .key("name")
                .refuse(&format!("is `{name}`, as is that of collider[{twin}]; a name of its own would do"));
        }
    }
    for (b, body) in scene.bodies.iter().enumerate() {
        for (p, pin) in body.pins.iter().enumerate() {
            let Some(name) = &pin.collider else { continue };
            let path = Path::item("body", b).nth("pin", p).key("collider");
            let Some(collider) = scene.collider_named(name) else {
                return path.refuse(&format!("there is no collider `{name}`; {}", some_of(&names)));
            };
            path.demand(pin.motion.is_empty(), || {
                format!("is `{name}`, and the pin has a motion too; one of them would do")
            })?;
            path.demand(collider.poses.is_none(), || {
                format!(
                    "is `{name}`, whose vertices move by poses; a collider that moves as a whole would do"
                )
            })?;
        }
    }
    Ok(())
}

fn some_of(names: &[String]) -> String {
    if names.is_empty() {
        return "the scene has no colliders; one of that name would do".to_owned();
    }
    let mut some: Vec<String> = names.iter().take(MOST_NAMES).map(|name| format!("`{name}`")).collect();
    if names.len() > MOST_NAMES {
        some.push(format!("{} more", names.len() - MOST_NAMES));
    }
    format!("{} would do", some.join(", "))
}

/// What a pin has beside nodes and motion.
pub(crate) fn check_pin(path: &Path, pin: &Pin) -> Checked {
    check_break(path, pin.break_force)?;
    let Some(poses) = &pin.poses else { return Ok(()) };
    let path = path.key("poses");
    check_poses(&path, poses)?;
    let others = [
        (!pin.motion.is_empty(), "motion"),
        (pin.collider.is_some(), "collider"),
        (pin.break_force.is_some(), "break_force"),
    ];
    match others.iter().find(|(given, _)| *given) {
        Some((_, key)) => path.refuse(&format!("cannot be beside {key}; one of them would do")),
        None => Ok(()),
    }
}

pub(crate) fn check_tethers(path: &Path, body: &Body) -> Checked {
    let Some(tethers) = &body.tethers else { return Ok(()) };
    let path = path.key("tethers");
    path.key("slack").not_negative(tethers.slack, "")?;
    path.demand(body.pins.iter().any(|pin| pin.break_force.is_none()), || {
        let have = if body.pins.is_empty() { "has no pins" } else { "has only pins that break" };
        format!(
            "need nodes that are pinned for good, and the body {have}; a pin that does not break would do, or leave \
             them out"
        )
    })
}
