//! The fabric of a cloth, in SI units.

use crate::scene::Select;
use crate::scene::presets::{PRESETS, Preset};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// A fabric in place of springs: its numbers belong to the fabric, whatever the mesh.
///
/// What is left out is that of the preset, and without a preset that of [`Fabric::default`].
///
/// ```
/// use taffeta::scene::{Body, Material, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // A curtain of linen, half a metre wide, that hangs by its first row.
/// let curtain = Body::cloth("curtain", Mesh::grid(21, 11, [0.5, 1.0])).with_material(Material::preset("linen"));
/// let scene = Scene::new("").time(1.0 / 60.0, 1e-4).body(curtain.pin(Select::rows(0, 0)));
/// let simulation = Simulation::new(&scene, &Options::default())?;
/// assert!(simulation.bodies()[0].elements.contains(&("membranes", 400)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// The fabric that gives what other keys leave out; `taffeta materials` lists them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// Mass per area [kg/m²]. A mass of the body's own takes its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Membrane stiffness along warp and weft, Young's modulus times thickness [N/m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch: Option<WarpWeft>,
    /// Shear modulus in the plane, times thickness [N/m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<f64>,
    /// Poisson's ratio: contraction along the weft when pulled along the warp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson: Option<f64>,
    /// Flexural rigidity along warp and weft [N·m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending: Option<WarpWeft>,
    /// Poisson's ratio in bending, between -1 and 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_poisson: Option<f64>,
    /// Rigidity against twist B₆₆ [N·m]; without it that of an isotropic plate, (1 − ν)/2 √(B_warp B_weft).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twist: Option<f64>,
    /// Whether the fabric is flat at rest, or as the mesh is.
    pub rest_curvature: RestCurvature,
    /// Thickness of the fabric [m]. Contact between nodes has a distance of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Damping in proportion to stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<FabricDamping>,
    /// Engineering strain along warp or weft past which the fabric is nine times as stiff.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strain_limit: Option<f64>,
    /// Direction of the warp in the pattern: in texture coordinates, or in columns and rows of a grid. A mesh without texture
    /// coordinates that is flat at rest has its own axes; on one that is not, (1, 0) runs up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warp: Option<[f64; 2]>,
    /// Parts of the body that are of another fabric, by name. Where some overlap, the last by name counts.
    #[serde(rename = "zone", skip_serializing_if = "BTreeMap::is_empty")]
    pub zones: BTreeMap<String, Zone>,
}

/// A part of a body that is of another fabric: what is left out is that of the body.
///
/// ```
/// use taffeta::scene::{Material, Select, Zone};
///
/// // An elastic band: the first two rows would rest at nine tenths of their length.
/// let band = Zone { select: Select::rows(0, 1), rest_scale: Some(0.9.into()), ..Zone::default() };
/// let mut skirt = Material::preset("cotton");
/// skirt.zones.insert("waistband".into(), band);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Zone {
    /// Which nodes: a triangle is of the zone when all of its corners are.
    pub select: Select,
    /// Factor on lengths at rest along warp and weft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_scale: Option<WarpWeft>,
    /// The fabric that gives what other keys leave out, but for its density.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// As of the body [N/m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch: Option<WarpWeft>,
    /// As of the body [N/m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<f64>,
    /// As of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson: Option<f64>,
    /// As of the body [N·m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending: Option<WarpWeft>,
    /// As of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_poisson: Option<f64>,
    /// As of the body [N·m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twist: Option<f64>,
    /// As of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<FabricDamping>,
    /// As of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strain_limit: Option<f64>,
}

/// A number along the warp and one along the weft; in a file one number means both.
///
/// ```
/// use taffeta::scene::WarpWeft;
///
/// assert_eq!(WarpWeft::from(490.0), WarpWeft { warp: 490.0, weft: 490.0 });
/// assert_eq!(WarpWeft::from([205.0, 1014.0]).weft, 1014.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WarpWeft {
    /// Along the warp.
    pub warp: f64,
    /// Along the weft.
    pub weft: f64,
}

/// Damping of a fabric: as many newtons for a strain a second as its stiffness gives for a strain, times a time.
///
/// ```
/// use taffeta::scene::{FabricDamping, Material};
///
/// let calm = Material { damping: Some(FabricDamping { stretch: 0.01, bending: 0.01 }), ..Material::preset("silk") };
/// assert_eq!(calm.fabric().damping.bending, 0.01);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FabricDamping {
    /// Times the membrane stiffness [s].
    pub stretch: f64,
    /// Times the rigidity [s].
    pub bending: f64,
}

/// The shape in which a fabric does not bend.
///
/// ```
/// use taffeta::scene::{Material, RestCurvature};
///
/// // A pleat keeps its fold.
/// let pleated = Material { rest_curvature: RestCurvature::Mesh, ..Material::preset("wool") };
/// # let _ = pleated;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RestCurvature {
    /// A plane.
    #[default]
    Flat,
    /// The mesh as it is given.
    Mesh,
}

/// The numbers of a fabric, none left out.
///
/// ```
/// use taffeta::scene::Material;
///
/// let denim = Material::preset("denim").fabric();
/// assert!(denim.stretch.weft > denim.stretch.warp && denim.bending.weft > 2e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Fabric {
    /// Mass per area [kg/m²].
    pub density: f64,
    /// Membrane stiffness [N/m].
    pub stretch: WarpWeft,
    /// Shear modulus times thickness [N/m].
    pub shear: f64,
    /// Poisson's ratio from warp to weft.
    pub poisson: f64,
    /// Flexural rigidity [N·m].
    pub bending: WarpWeft,
    /// Poisson's ratio in bending.
    pub bending_poisson: f64,
    /// Rigidity against twist B₆₆ [N·m]; `None`: that of an isotropic plate.
    pub twist: Option<f64>,
    /// Thickness [m].
    pub thickness: f64,
    /// Damping [s].
    pub damping: FabricDamping,
    /// Engineering strain past which it is stiffer.
    pub strain_limit: Option<f64>,
}

impl Material {
    /// A fabric by name; an unknown one is refused when the scene is checked.
    pub fn preset(name: impl Into<String>) -> Self {
        Self { preset: Some(name.into()), ..Self::default() }
    }

    /// Its numbers, with those of the preset; an unknown preset gives none.
    pub fn fabric(&self) -> Fabric {
        let base = Preset::of(self.preset.as_deref()).map_or_else(Fabric::default, |preset| preset.fabric);
        Fabric {
            density: self.density.unwrap_or(base.density),
            stretch: self.stretch.unwrap_or(base.stretch),
            shear: self.shear.unwrap_or(base.shear),
            poisson: self.poisson.unwrap_or(base.poisson),
            bending: self.bending.unwrap_or(base.bending),
            bending_poisson: self.bending_poisson.unwrap_or(base.bending_poisson),
            // The preset's own twist belongs to its own rigidity.
            twist: self.twist.or(base.twist.filter(|_| self.bending.is_none())),
            thickness: self.thickness.unwrap_or(base.thickness),
            damping: self.damping.unwrap_or(base.damping),
            strain_limit: self.strain_limit.or(base.strain_limit),
        }
    }
}

impl Zone {
    /// Its numbers, on a body of a fabric.
    pub fn fabric(&self, body: &Fabric) -> Fabric {
        let base = Preset::of(self.preset.as_deref()).map_or(*body, |preset| preset.fabric);
        Fabric {
            density: body.density,
            stretch: self.stretch.unwrap_or(base.stretch),
            shear: self.shear.unwrap_or(base.shear),
            poisson: self.poisson.unwrap_or(base.poisson),
            bending: self.bending.unwrap_or(base.bending),
            bending_poisson: self.bending_poisson.unwrap_or(base.bending_poisson),
            twist: self.twist.or(base.twist.filter(|_| self.bending.is_none())),
            thickness: base.thickness,
            damping: self.damping.unwrap_or(base.damping),
            strain_limit: self.strain_limit.or(base.strain_limit),
        }
    }
}

impl Fabric {
    /// C₁₁, C₁₂, C₂₂ and G [N/m].
    pub fn membrane(&self) -> [f64; 4] {
        let WarpWeft { warp, weft } = self.stretch;
        let d = 1.0 - self.poisson * self.poisson * weft / warp;
        [warp / d, self.poisson * weft / d, weft / d, self.shear]
    }

    /// B₁₁, B₁₂, B₂₂ and B₆₆ [N·m].
    pub fn plate(&self) -> [f64; 4] {
        let WarpWeft { warp, weft } = self.bending;
        let mean = (warp * weft).sqrt();
        let twist = self.twist.unwrap_or(0.5 * (1.0 - self.bending_poisson) * mean);
        [warp, self.bending_poisson * mean, weft, twist]
    }

    /// The magnitude that Poisson's ratio must stay below for the tensor to be positive definite.
    pub fn largest_poisson(&self) -> f64 {
        (self.stretch.warp / self.stretch.weft).sqrt()
    }
}

impl Default for Fabric {
    /// About a light cotton.
    fn default() -> Self {
        PRESETS[0].fabric
    }
}

impl Default for FabricDamping {
    fn default() -> Self {
        Self { stretch: 1e-5, bending: 1e-3 }
    }
}

impl From<f64> for WarpWeft {
    fn from(both: f64) -> Self {
        Self { warp: both, weft: both }
    }
}

impl From<[f64; 2]> for WarpWeft {
    fn from([warp, weft]: [f64; 2]) -> Self {
        Self { warp, weft }
    }
}

impl Serialize for WarpWeft {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        [self.warp, self.weft].serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for WarpWeft {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrTwo)
    }
}

/// Reads one number or two.
struct OneOrTwo;

impl<'de> Visitor<'de> for OneOrTwo {
    type Value = WarpWeft;

    fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str("a number, or one along the warp and one along the weft")
    }

    fn visit_f64<E>(self, both: f64) -> Result<WarpWeft, E> {
        Ok(both.into())
    }

    fn visit_i64<E>(self, both: i64) -> Result<WarpWeft, E> {
        Ok((both as f64).into())
    }

    fn visit_u64<E>(self, both: u64) -> Result<WarpWeft, E> {
        Ok((both as f64).into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<WarpWeft, A::Error> {
        let short = |count| serde::de::Error::invalid_length(count, &self);
        let warp = numbers.next_element()?.ok_or_else(|| short(0))?;
        let weft = numbers.next_element()?.ok_or_else(|| short(1))?;
        if numbers.next_element::<f64>()?.is_some() {
            return Err(short(3));
        }
        Ok(WarpWeft { warp, weft })
    }
}

impl JsonSchema for WarpWeft {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "WarpWeft".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number along the warp and one along the weft; one number means both.",
            "anyOf": [
                { "type": "number" },
                { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 },
            ],
        })
    }
}
