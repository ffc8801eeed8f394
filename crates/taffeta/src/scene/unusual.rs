//! Numbers that no fabric has: most are in another unit than the scene's.

use crate::scene::{Fabric, Material, WarpWeft};

/// What numbers of a sort are among fabrics, and what others often are.
struct Usual {
    key: &'static str,
    unit: &'static str,
    least: f64,
    most: f64,
    otherwise: &'static str,
}

/// From a veil to a carpet; bending up to leather of 1 mm.
const fn usual(
    key: &'static str,
    unit: &'static str,
    [least, most]: [f64; 2],
    otherwise: &'static str,
) -> Usual {
    Usual { key, unit, least, most, otherwise }
}

const DENSITY: Usual = usual("density", " kg/m²", [0.003, 3.0], "g/m² are divided by 1000");
const STRETCH: Usual =
    usual("stretch", " N/m", [1.0, 1e6], "Young's modulus in Pa is multiplied by the thickness in m");
const BENDING: Usual = usual("bending", " N·m", [0.0, 0.02], "gf·cm²/cm are multiplied by 9.81e-5");
const THICKNESS: Usual = usual("thickness", " m", [1e-5, 0.02], "mm are divided by 1000");
const STRAIN_LIMIT: Usual = usual("strain_limit", "", [1e-4, 2.0], "percent are divided by 100");
const REST_SCALE: Usual = usual("rest_scale", "", [0.1, 10.0], "percent are divided by 100");

impl Usual {
    /// What to say of a number, of the fabric of `whose`.
    fn says(&self, value: f64, whose: &str) -> Option<String> {
        let Self { key, unit, least, most, otherwise } = self;
        (!(*least..=*most).contains(&value)).then(|| {
            format!("{whose} {key} is {value}{unit}; fabrics have {least} to {most}{unit} ({otherwise})")
        })
    }

    /// The same of numbers along warp and weft.
    fn says_of_both(&self, both: WarpWeft, whose: &str) -> Option<String> {
        self.says(both.warp, whose).or_else(|| self.says(both.weft, whose))
    }
}

impl Material {
    /// What to say of numbers that no fabric has.
    pub(crate) fn unusual(&self) -> Vec<String> {
        let base = self.fabric();
        let mut all = of_fabric(&base, "its fabric's");
        all.extend(DENSITY.says(base.density, "its fabric's"));
        all.extend(THICKNESS.says(base.thickness, "its fabric's"));
        for (name, zone) in &self.zones {
            let whose = format!("zone `{name}`: its fabric's");
            all.extend(of_fabric(&zone.fabric(&base), &whose));
            all.extend(zone.rest_scale.and_then(|both| REST_SCALE.says_of_both(both, &whose)));
        }
        all
    }
}

fn of_fabric(fabric: &Fabric, whose: &str) -> Vec<String> {
    let Fabric { stretch, bending, strain_limit, .. } = *fabric;
    let limit = strain_limit.and_then(|limit| STRAIN_LIMIT.says(limit, whose));
    [STRETCH.says_of_both(stretch, whose), BENDING.says_of_both(bending, whose), limit]
        .into_iter()
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PRESETS, Zone};

    #[test]
    fn presets_are_usual_and_numbers_in_other_units_are_not() {
        for preset in PRESETS {
            assert_eq!(Material::preset(preset.name).unusual(), Vec::<String>::new(), "{}", preset.name);
        }
        let mut linen = Material {
            density: Some(185.0),
            bending: Some(0.12.into()),
            thickness: Some(0.45),
            strain_limit: Some(5.0),
            ..Material::preset("linen")
        };
        let band = Zone { rest_scale: Some(90.0.into()), stretch: Some(1e8.into()), ..Zone::default() };
        linen
            .zones
            .insert("band".into(), Zone { strain_limit: Some(0.5), bending: Some(1e-5.into()), ..band });
        let said = linen.unusual();
        assert_eq!(
            said[0],
            "its fabric's bending is 0.12 N·m; fabrics have 0 to 0.02 N·m (gf·cm²/cm are multiplied by 9.81e-5)"
        );
        let keys = ["bending", "strain_limit", "density", "thickness", "stretch", "rest_scale"];
        assert!(said.len() == keys.len(), "{said:#?}");
        assert!(said.iter().zip(keys).all(|(said, key)| said.contains(&format!(" {key} is "))), "{said:#?}");
        assert!(said[4].starts_with("zone `band`: its fabric's stretch is 100000000 N/m"), "{}", said[4]);
    }
}
