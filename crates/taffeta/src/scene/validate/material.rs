//! What a fabric may be.

use crate::scene::presets::{PRESETS, Preset};
use crate::scene::validate::body::check_select;
use crate::scene::validate::path::{Checked, Path};
use crate::scene::{Body, Fabric, FabricDamping, Kind, Material, Springs, WarpWeft};

pub(crate) fn check(path: &Path, body: &Body, material: &Material) -> Checked {
    let Springs { structural, shear, bend, internal, hinge } = &body.springs;
    let springs = structural.is_some() || shear.is_some() || bend.is_some() || hinge.is_some();
    path.demand(!springs && internal.is_none(), || {
        "stands beside springs; a fabric or springs would do, not both".into()
    })?;
    let masses = [body.node_mass, body.mass, body.area_density, body.density];
    path.key("density").demand(material.density.is_none() || masses.iter().all(Option::is_none), || {
        "stands beside a mass of the body; one of them would do".into()
    })?;
    path.demand(
        body.kind == Kind::Cloth || masses.iter().any(Option::is_some) || material.density.is_some(),
        || {
            "leaves the mass of a soft body open; a density here, or mass or density of the body would do"
                .into()
        },
    )?;
    check_preset(path, material.preset.as_deref())?;
    let fabric = material.fabric();
    check_fabric(path, &fabric)?;
    path.key("density").positive(fabric.density, "kg/m²")?;
    path.key("thickness").positive(fabric.thickness, "m")?;
    if let Some(warp) = material.warp {
        path.key("warp").finite(&warp)?;
        path.key("warp")
            .demand(warp != [0.0; 2], || "is [0, 0]; a direction such as [1, 0] would do".into())?;
    }
    for (name, zone) in &material.zones {
        let path = path.key("zone").key(name);
        check_select(&path.key("select"), &zone.select)?;
        check_preset(&path, zone.preset.as_deref())?;
        check_fabric(&path, &zone.fabric(&fabric))?;
        if let Some(WarpWeft { warp, weft }) = zone.rest_scale {
            path.key("rest_scale").positive(warp, "")?;
            path.key("rest_scale").positive(weft, "")?;
        }
    }
    Ok(())
}

fn check_preset(path: &Path, name: Option<&str>) -> Checked {
    path.key("preset").demand(name.is_none() || Preset::of(name).is_some(), || {
        let names: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
        format!("is `{}`; one of {} would do", name.unwrap_or_default(), names.join(", "))
    })
}

fn check_fabric(path: &Path, fabric: &Fabric) -> Checked {
    for (key, WarpWeft { warp, weft }, unit) in
        [("stretch", fabric.stretch, "N/m"), ("bending", fabric.bending, "N·m")]
    {
        let check = |number| match key {
            "stretch" => path.key(key).positive(number, unit),
            _ => path.key(key).not_negative(number, unit),
        };
        check(warp)?;
        check(weft)?;
    }
    path.key("shear").not_negative(fabric.shear, "N/m")?;
    path.key("poisson").finite(&[fabric.poisson])?;
    let most = fabric.largest_poisson();
    path.key("poisson").demand(fabric.poisson.abs() < most, || {
        format!(
            "is {}; with these stiffnesses less than {most:.4} would do (the root of warp over weft): else a pull would give \
             energy",
            fabric.poisson
        )
    })?;
    path.key("bending_poisson").demand(fabric.bending_poisson.abs() < 1.0, || {
        format!("is {}; between -1 and 1 would do", fabric.bending_poisson)
    })?;
    if let Some(twist) = fabric.twist {
        path.key("twist").not_negative(twist, "N·m")?;
    }
    let FabricDamping { stretch, bending } = fabric.damping;
    path.key("damping").key("stretch").not_negative(stretch, "s")?;
    path.key("damping").key("bending").not_negative(bending, "s")?;
    fabric.strain_limit.map_or(Ok(()), |limit| path.key("strain_limit").positive(limit, ""))
}
