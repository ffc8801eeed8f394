//! The vertices of a PLY file.

use super::skip_property;
use crate::mesh::MeshError;
use crate::mesh::ply_body::Body;
use crate::mesh::ply_header::{Element, Number, Property};

/// Properties that mean something else than a group.
const NOT_GROUPS: &[&str] = &["x", "y", "z", "nx", "ny", "nz", "s", "t", "u", "v"];
/// Colours: what is painted with more than half of one becomes a group.
const COLOURS: &[&str] = &["red", "green", "blue", "alpha"];

/// What a file says of its vertices.
#[derive(Default)]
pub(super) struct Vertices {
    pub places: Vec<[f64; 3]>,
    /// Texture coordinates, if there are any.
    pub coords: Option<Vec<[f32; 2]>>,
    pub groups: Vec<(String, Vec<u32>)>,
}

/// A property that says who belongs to a group.
struct Painted {
    property: usize,
    /// Members have more.
    bound: f64,
    members: Vec<u32>,
}

impl Vertices {
    pub fn read(body: &mut Body, element: &Element, count: usize) -> Result<Self, MeshError> {
        let find = |name: &str| element.properties.iter().position(|p| p.name == name && p.list.is_none());
        let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(find) else {
            return Err(MeshError::new("the vertices need the properties x, y and z"));
        };
        let uv = [["u", "v"], ["s", "t"]].map(|names| names.map(find));
        let uv = uv.into_iter().find_map(|[u, v]| Some([u?, v?]));
        let mut painted: Vec<Painted> = (0..).zip(&element.properties).filter_map(Painted::by).collect();
        let (mut places, mut coords) = (Vec::with_capacity(count), Vec::new());
        let mut values = vec![0.0; element.properties.len()];
        for vertex in 0..count {
            for (value, property) in values.iter_mut().zip(&element.properties) {
                match property.list {
                    Some(_) => skip_property(body, property)?,
                    None => *value = body.number(property.number)?,
                }
            }
            let place = [values[x], values[y], values[z]];
            check_finite(body, vertex, "coordinate", &place)?;
            places.push(place);
            if let Some(uv) = uv {
                let uv = uv.map(|i| values[i] as f32);
                check_finite(body, vertex, "texture coordinate", &uv.map(f64::from))?;
                coords.push(uv);
            }
            for group in painted.iter_mut().filter(|group| values[group.property] > group.bound) {
                group.members.push(vertex as u32);
            }
        }
        let named = |group: Painted| (element.properties[group.property].name.clone(), group.members);
        let groups = painted.into_iter().map(named).collect();
        Ok(Self { places, coords: uv.is_some().then_some(coords), groups })
    }
}

impl Painted {
    fn by((index, property): (usize, &Property)) -> Option<Self> {
        let name = property.name.as_str();
        if property.list.is_some() || NOT_GROUPS.contains(&name) {
            return None;
        }
        let full = if COLOURS.contains(&name) { largest(property.number) } else { 1.0 };
        Some(Self { property: index, bound: 0.5 * full, members: Vec::new() })
    }
}

/// The value of a full colour.
fn largest(number: Number) -> f64 {
    match number {
        Number::I8 => f64::from(i8::MAX),
        Number::U8 => f64::from(u8::MAX),
        Number::I16 => f64::from(i16::MAX),
        Number::U16 => f64::from(u16::MAX),
        Number::I32 => f64::from(i32::MAX),
        Number::U32 => f64::from(u32::MAX),
        Number::F32 | Number::F64 => 1.0,
    }
}

fn check_finite(body: &Body, vertex: usize, what: &str, values: &[f64]) -> Result<(), MeshError> {
    match values.iter().find(|x| !x.is_finite()) {
        Some(bad) => Err(body.error(format!("vertex {vertex} has the {what} {bad}; it must be finite"))),
        None => Ok(()),
    }
}
