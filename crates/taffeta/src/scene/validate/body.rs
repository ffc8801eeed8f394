//! What a body may be.

use crate::advice::Advice;
use crate::scene::body::{ContactOfBody, Range};
use crate::scene::error::SceneError;
use crate::scene::validate::attach;
use crate::scene::validate::check_shape;
use crate::scene::validate::material;
use crate::scene::validate::path::{Checked, Path};
use crate::scene::validate::{check_motion, check_rotation, check_times};
use crate::scene::{
    Body, ContactForm, Internal, Kind, Mass, Mesh, Place, Select, SelfCollision, Springs, Volume, VolumeForm,
    VolumeKey,
};

pub(crate) fn check(path: &Path, body: &Body) -> Checked {
    check_mass(path, body)?;
    check_mesh(path, "mesh", &body.mesh)?;
    if let Some(mesh) = &body.stand_in {
        check_mesh(path, "stand_in", mesh)?;
    }
    check_file_keys(path, body)?;
    check_place(&path.key("place"), &body.place)?;
    path.key("velocity").rate(&body.velocity, "m/s")?;
    path.key("angular_velocity").rate(&body.angular_velocity, "rad/s")?;
    check_springs(&path.key("springs"), &body.springs, body.kind)?;
    for elements in body.elements() {
        for (field, number, unit) in elements.numbers {
            path.key(elements.key).key(field).not_negative(number, unit)?;
        }
    }
    body.material.as_ref().map_or(Ok(()), |one| material::check(&path.key("material"), body, one))?;
    if let Some(volume) = &body.volume {
        check_volume(&path.key("volume"), volume, body.kind)?;
    }
    body.contacts().iter().try_for_each(|contact| check_contact(&path.key(contact.key), contact))?;
    body.self_collision
        .as_ref()
        .map_or(Ok(()), |one| check_contact_zones(&path.key("self_collision"), one))?;
    for (i, pin) in body.pins.iter().enumerate() {
        let path = path.nth("pin", i);
        check_select(&path.key("select"), &pin.select)?;
        check_motion(&path, &pin.motion)?;
        attach::check_pin(&path, pin)?;
    }
    attach::check_tethers(path, body)
}

pub(crate) const NO_HOLES: &str =
    "is for a mesh from a file, and other shapes have no holes to fill; mesh.file would do, or leave it out";

/// Refuses what belongs to a mesh file where there is none, or where nobody has read it.
fn check_file_keys(path: &Path, body: &Body) -> Checked {
    let shaped = match &body.mesh {
        Mesh::File(_) => true,
        Mesh::Surface(surface) => surface.rest.is_some(),
        _ => false,
    };
    path.key("rest_shape").demand(shaped || body.rest_shape.is_none(), || {
        "is for a mesh from a file, as a second file of the same vertices and faces; mesh.file (in Rust: Surface::rest) \
         would do, or leave it out"
            .into()
    })?;
    path.key("fill_holes").demand(body.mesh.is_from_file() || !body.fill_holes, || NO_HOLES.to_owned())
}

fn check_mass(path: &Path, body: &Body) -> Checked {
    let (key, value, unit) = match body.mass_given() {
        Some(Mass::Node(m)) => ("node_mass", m, "kg"),
        Some(Mass::Whole(m)) => ("mass", m, "kg"),
        Some(Mass::Area(m)) => ("area_density", m, "kg/m²"),
        Some(Mass::Volume(m)) => ("density", m, "kg/m³"),
        None => {
            let masses = [body.node_mass, body.mass, body.area_density, body.density];
            let keys = ["node_mass", "mass", "area_density", "density"];
            let given: Vec<_> = keys.into_iter().zip(masses).filter_map(|(key, m)| m.map(|_| key)).collect();
            let have = if given.is_empty() { "no mass".into() } else { given.join(" and ") };
            return path.refuse(&format!("has {have}; one of {} would do", keys.join(", ")));
        }
    };
    path.key(key).positive(value, unit)?;
    path.key(key).demand(key != "density" || body.kind == Kind::Soft, || {
        "is for soft bodies, which have a volume; node_mass, mass or area_density would do".into()
    })
}

/// Checks a shape that stands at `key`; its own check says `mesh` there.
pub(crate) fn check_mesh(path: &Path, key: &str, mesh: &Mesh) -> Checked {
    check_shape(mesh).or_else(|(field, message)| path.key(&field.replacen("mesh", key, 1)).refuse(&message))
}

pub(crate) fn check_place(path: &Path, place: &Place) -> Checked {
    path.key("position").finite(&place.position)?;
    if let Some(turn) = &place.rotation {
        check_rotation(&path.key("rotation"), turn)?;
    }
    match (place.scale, place.fit) {
        (Some(_), Some(_)) => path.refuse("has scale and fit; one of them would do"),
        (Some(scale), None) => path.key("scale").positive(scale, ""),
        (None, Some(fit)) => path.key("fit").positive(fit, "m"),
        (None, None) => Ok(()),
    }
}

fn check_springs(path: &Path, springs: &Springs, kind: Kind) -> Result<(), SceneError> {
    let stiff = |key: &str, k: f64, d: f64, [k_unit, d_unit]: [&str; 2]| {
        path.key(key).key("k").not_negative(k, k_unit)?;
        path.key(key).key("d").not_negative(d, d_unit)
    };
    let kinds = [("structural", springs.structural), ("shear", springs.shear), ("bend", springs.bend)];
    for (key, spring) in kinds {
        spring.map_or(Ok(()), |spring| stiff(key, spring.k, spring.d, ["N/m", "kg/s"]))?;
    }
    if let Some(internal) = &springs.internal {
        stiff("internal", internal.k, internal.d, ["N/m", "kg/s"])?;
        check_internal(&path.key("internal"), internal, kind)?;
    }
    Ok(())
}

fn check_internal(path: &Path, internal: &Internal, kind: Kind) -> Checked {
    let listed = internal.file.is_some() || internal.pairs.is_some();
    let wanted = internal.count > 0 || listed;
    if kind != Kind::Soft && wanted {
        let error = path.error("a cloth has no inside for struts; a soft body of a closed mesh would do");
        return Err(error.advise(Advice::SoftBody));
    }
    path.demand(internal.count == 0 || !listed, || {
        format!("has a count of {} and a file of its own; one of them would do", internal.count)
    })
}

fn check_contact(path: &Path, contact: &ContactOfBody) -> Checked {
    contact.numbers.iter().try_for_each(|&(name, value, ref range)| match range {
        Range::Positive(unit) => path.key(name).positive(value, unit),
        Range::NotNegative(unit) => path.key(name).not_negative(value, unit),
        Range::Share => path.key(name).share(value),
    })
}

fn check_contact_zones(path: &Path, contact: &SelfCollision) -> Checked {
    path.key("zone").demand(contact.zones.is_empty() || contact.form == ContactForm::Triangles, || {
        "is for contact between triangles; form = \"triangles\", or nothing, would do".into()
    })?;
    contact.zones.iter().try_for_each(|(name, zone)| {
        let path = path.key("zone").key(name);
        check_select(&path.key("select"), &zone.select)?;
        path.key("thickness").positive(zone.thickness, "m")
    })
}

fn check_volume(path: &Path, volume: &Volume, kind: Kind) -> Checked {
    if kind != Kind::Soft && volume.form != VolumeForm::None {
        let error = path
            .error("is for soft bodies, and a cloth has no inside; a soft body of a closed mesh would do");
        return Err(error.advise(Advice::SoftBody));
    }
    if let Some(target) = volume.target {
        path.key("target").positive(target, "")?;
    }
    if let Some(pressure) = volume.pressure {
        path.key("pressure").finite(&[pressure])?;
    }
    check_times(path, volume.motion.iter().map(|key| key.t))?;
    for (i, key) in volume.motion.iter().enumerate() {
        check_volume_key(&path.nth("motion", i), key)?;
    }
    check_one_drive(path, volume)?;
    if let Some(weights) = &volume.weights {
        let path = path.key("weights");
        path.key("center").finite(&weights.center)?;
        path.key("radius").positive(weights.radius, "m")?;
    }
    Ok(())
}

fn check_volume_key(path: &Path, key: &VolumeKey) -> Checked {
    match (key.target, key.pressure) {
        (Some(target), None) => path.key("target").positive(target, ""),
        (None, Some(pressure)) => path.key("pressure").finite(&[pressure]),
        (Some(_), Some(_)) => path.refuse("has target and pressure; one of them would do"),
        (None, None) => path.refuse("has neither target nor pressure; one of them would do"),
    }
}

/// Either a volume is kept, or a pressure acts.
fn check_one_drive(path: &Path, volume: &Volume) -> Checked {
    let kept = volume.target.is_some() || volume.motion.iter().any(|key| key.target.is_some());
    path.demand(!(kept && volume.is_pressure()), || {
        "has a target and a pressure; a body either keeps a volume or is under a pressure".into()
    })?;
    let only_kept = !matches!(volume.form, VolumeForm::Corrected | VolumeForm::None);
    path.key("form").demand(!(only_kept && volume.is_pressure()), || {
        format!("is {}, but a body under a pressure keeps no volume; leave it out", volume.form.name())
    })?;
    path.key("weights").demand(!(volume.weights.is_some() && volume.is_pressure()), || {
        "say where a body gives way to keep its volume, and under a pressure it keeps none; leave them out".into()
    })
}

/// Numbers of a selection; a box may reach to infinity.
pub(crate) fn check_select(path: &Path, select: &Select) -> Checked {
    let Some(bounds) = select.inside else { return Ok(()) };
    for (key, corner) in [("min", bounds.min), ("max", bounds.max)] {
        let odd = corner.iter().any(|x| x.is_nan());
        path.key("box").key(key).demand(!odd, || format!("is {corner:?}, three numbers would do"))?;
    }
    Ok(())
}
