//! Fabrics by name.

use crate::scene::{Fabric, FabricDamping, WarpWeft};

/// A fabric by name.
///
/// ```
/// use taffeta::scene::PRESETS;
///
/// for preset in PRESETS {
///     println!("{}: {} kg/m², {}", preset.name, preset.fabric.density, preset.source);
/// }
/// assert!(PRESETS.iter().any(|preset| preset.name == "denim"));
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Preset {
    /// What a scene calls it.
    pub name: &'static str,
    /// What it is.
    pub title: &'static str,
    /// Where its numbers are from.
    pub source: &'static str,
    /// Cusick's drape coefficient [%] as simulated on nine meshes of 1,000 to 4,000 nodes, least and largest: what `taffeta validate
    /// drape` has found.
    pub drape: [f64; 2],
    /// Its numbers.
    pub fabric: Fabric,
}

impl Preset {
    /// The one of a name.
    pub fn of(name: Option<&str>) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| Some(preset.name) == name)
    }
}

const WANG: &str = "H. Wang, J. O'Brien, R. Ramamoorthi, Data-Driven Elastic Models for Cloth, 2011: its first row of stretch, \
                    and its bending samples divided by 4";
const KES: &str = "an estimate: mass, stretch and shear in the range of measurements by Kawabata's evaluation system (S. Kawabata, The \
                   Standardization and Analysis of Hand Evaluation, 1980); bending such that Cusick's drape coefficient lies in the band \
                   of the fabric (docs/models/fabric.md)";

/// A woven fabric: density, stretch, shear, Poisson's ratio, bending, thickness.
const fn woven(density: f64, stretch: [f64; 2], shear: f64, bending: [f64; 2], thickness: f64) -> Fabric {
    Fabric {
        density,
        stretch: WarpWeft { warp: stretch[0], weft: stretch[1] },
        shear,
        poisson: 0.3,
        bending: WarpWeft { warp: bending[0], weft: bending[1] },
        bending_poisson: 0.0,
        twist: None,
        thickness,
        damping: FabricDamping { stretch: 1e-5, bending: 1e-3 },
        strain_limit: None,
    }
}

/// A fabric of Wang's: C₁₁, C₁₂, C₂₂, C₃₃ [N/m], bending samples along warp, bias and weft [µN·m].
const fn measured(density: f64, [c11, c12, c22, c33]: [f64; 4], samples: [f64; 3], thickness: f64) -> Fabric {
    let d = 1.0 - c12 * c12 / (c11 * c22);
    let [warp, bias, weft] = [samples[0] / 4e6, samples[1] / 4e6, samples[2] / 4e6];
    Fabric {
        poisson: c12 / c22,
        // A strip on the bias bends with (B₁₁ + B₂₂ + 4 B₆₆)/4.
        twist: Some(bias - (warp + weft) / 4.0),
        ..woven(density, [c11 * d, c22 * d], c33, [warp, weft], thickness)
    }
}

/// All fabrics by name. The first is what a material without a preset is made of.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "cotton",
        title: "plain woven cotton",
        source: KES,
        drape: [66.8, 73.4],
        fabric: woven(0.150, [2500.0, 1500.0], 60.0, [1.6e-5, 1.0e-5], 4e-4),
    },
    Preset {
        name: "silk",
        title: "silk, plain woven",
        source: KES,
        drape: [31.5, 45.1],
        fabric: woven(0.060, [1500.0, 1000.0], 15.0, [1.2e-6, 8.0e-7], 1.5e-4),
    },
    Preset {
        name: "wool",
        title: "worsted wool suiting",
        source: KES,
        drape: [56.9, 62.9],
        fabric: woven(0.220, [1200.0, 700.0], 35.0, [1.6e-5, 1.1e-5], 6e-4),
    },
    Preset {
        name: "linen",
        title: "plain woven linen",
        source: KES,
        drape: [75.4, 82.7],
        fabric: woven(0.185, [3500.0, 3000.0], 40.0, [3.2e-5, 2.4e-5], 4.5e-4),
    },
    Preset {
        name: "denim",
        title: "denim, 11 oz",
        source: WANG,
        drape: [55.2, 58.8],
        fabric: measured(0.324, [205.0, 10.2, 1014.0, 53.4], [64.0, 73.0, 97.0], 8e-4),
    },
    Preset {
        name: "jersey",
        title: "interlock knit of a T-shirt",
        source: WANG,
        drape: [33.8, 35.4],
        fabric: measured(0.187, [16.6, -14.7, 34.5, 36.9], [23.2, 24.7, 14.3], 7e-4),
    },
    Preset {
        name: "ponte",
        title: "ponte roma, a double knit",
        source: WANG,
        drape: [34.6, 36.6],
        fabric: measured(0.284, [31.1, -12.8, 44.0, 31.9], [36.0, 33.0, 37.0], 9e-4),
    },
    Preset {
        name: "rib",
        title: "rib knit",
        source: WANG,
        drape: [36.2, 40.4],
        fabric: measured(0.276, [42.9, -0.2, 65.2, 83.2], [46.0, 30.0, 32.0], 1e-3),
    },
    Preset {
        name: "polyester",
        title: "polyester tablecloth",
        source: WANG,
        drape: [64.5, 68.7],
        fabric: measured(0.128, [2002.0, 0.3, 2027.0, 19.2], [52.0, 41.0, 31.0], 3e-4),
    },
    Preset {
        name: "blanket",
        title: "polyester blanket",
        source: WANG,
        drape: [65.7, 66.7],
        fabric: measured(0.228, [151.0, 106.0, 245.0, 30.3], [117.0, 88.0, 60.0], 3e-3),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_positive_definite() {
        for Preset { name, fabric, .. } in PRESETS {
            let [c11, c12, c22, g] = fabric.membrane();
            let [b11, b12, b22, b66] = fabric.plate();
            assert!(c11 > 0.0 && c11 * c22 > c12 * c12 && g > 0.0, "{name}");
            assert!(b11 > 0.0 && b11 * b22 > b12 * b12 && b66 > 0.0, "{name}: {b66}");
        }
    }

    #[test]
    fn a_measured_fabric_has_the_tensor_that_was_measured() {
        let denim = Preset::of(Some("denim")).unwrap().fabric;
        for (ours, measured) in denim.membrane().into_iter().zip([205.0, 10.2, 1014.0, 53.4]) {
            assert!((ours - measured).abs() < 1e-9 * measured, "{ours} {measured}");
        }
        // A sample bent along the bias.
        let [warp, _, weft, twist] = denim.plate();
        assert!(((warp + weft) / 4.0 + twist - 73e-6 / 4.0).abs() < 1e-12);
    }
}
