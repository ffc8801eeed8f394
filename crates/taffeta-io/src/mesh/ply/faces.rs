//! The faces of a PLY file, and its strips of triangles.

use super::skip_property;
use crate::mesh::MeshError;
use crate::mesh::clean::counted;
use crate::mesh::ply_body::Body;
use crate::mesh::ply_header::{Element, Number};
use taffeta::topology::{Polygons, Uvs};

/// Faces, and the texture coordinates of their corners.
pub(super) struct Faces {
    /// Number of vertices that the header promises.
    vertices: u64,
    polygons: Polygons,
    /// Texture coordinates of the first corners.
    coords: Vec<[f32; 2]>,
    /// Corners that have none.
    without: usize,
}

impl Faces {
    pub fn of_vertices(vertices: u64) -> Self {
        let polygons = Polygons { offsets: vec![0], corners: Vec::new() };
        Self { vertices, polygons, coords: Vec::new(), without: 0 }
    }

    pub fn read_faces(&mut self, body: &mut Body, element: &Element, count: usize) -> Result<(), MeshError> {
        let indices = find_indices(element, "faces")?;
        let uv = element.properties.iter().position(|p| p.list.is_some() && p.name == "texcoord");
        if uv.is_some() {
            self.fill_coords();
        }
        let mut values = Vec::new();
        for row in 0..count {
            for (i, property) in element.properties.iter().enumerate() {
                match property.list {
                    Some(length) if i == indices => {
                        let length = body.list_length(length, property.number, format_args!("face {row}"))?;
                        self.read_corners(body, property.number, row, length)?;
                    }
                    Some(length) if Some(i) == uv => {
                        let length = body.list_length(length, property.number, format_args!("face {row}"))?;
                        values.clear();
                        for _ in 0..length {
                            values.push(body.number(property.number)? as f32);
                        }
                    }
                    _ => skip_property(body, property)?,
                }
            }
            if uv.is_some() {
                self.take_coords(row, &values).map_err(|what| body.error(what))?;
            }
        }
        Ok(())
    }

    fn read_corners(
        &mut self,
        body: &mut Body,
        number: Number,
        row: usize,
        length: usize,
    ) -> Result<(), MeshError> {
        if length < 3 {
            return Err(
                body.error(format!("face {row} has {}; it needs at least 3", counted(length, "corner")))
            );
        }
        for _ in 0..length {
            let index = body.number(number)?;
            let vertex = self.vertex(index);
            let vertex = vertex.ok_or_else(|| self.beyond(body, number, index, format!("face {row}")))?;
            self.polygons.corners.push(vertex);
        }
        self.end_face(body)
    }

    /// Each three neighbours in a strip are a triangle, every other one turned; −1 ends a strip.
    pub fn read_strips(&mut self, body: &mut Body, element: &Element, count: usize) -> Result<(), MeshError> {
        let indices = find_indices(element, "triangle strips")?;
        for row in 0..count {
            for (i, property) in element.properties.iter().enumerate() {
                match property.list {
                    Some(length) if i == indices => {
                        let length =
                            body.list_length(length, property.number, format_args!("triangle strip {row}"))?;
                        self.read_strip(body, property.number, row, length)?;
                    }
                    _ => skip_property(body, property)?,
                }
            }
        }
        Ok(())
    }

    fn read_strip(
        &mut self,
        body: &mut Body,
        number: Number,
        row: usize,
        length: usize,
    ) -> Result<(), MeshError> {
        let (mut last, mut turned) = ([None; 2], false);
        for _ in 0..length {
            let index = body.number(number)?;
            // Unsigned numbers cannot say −1 otherwise.
            if index == -1.0 || index == f64::from(u32::MAX) {
                (last, turned) = ([None; 2], false);
                continue;
            }
            let vertex = self.vertex(index);
            let c =
                vertex.ok_or_else(|| self.beyond(body, number, index, format!("triangle strip {row}")))?;
            if let [Some(a), Some(b)] = last {
                // Strips repeat vertices to get around bends; triangles of those are not meant.
                if a != b && b != c && c != a {
                    self.polygons.corners.extend(if turned { [b, a, c] } else { [a, b, c] });
                    self.end_face(body)?;
                }
                turned = !turned;
            }
            last = [last[1], Some(c)];
        }
        Ok(())
    }

    /// A number as the index of a vertex.
    fn vertex(&self, index: f64) -> Option<u32> {
        // What is no u32 does not come back the same.
        let vertex = index as u32;
        (f64::from(vertex) == index && u64::from(vertex) < self.vertices).then_some(vertex)
    }

    fn beyond(&self, body: &Body, number: Number, index: f64, of: String) -> MeshError {
        let valid = match self.vertices {
            0 => "the file has no vertices".to_owned(),
            count => format!("valid: 0 to {}", count - 1),
        };
        body.error_behind(number, format!("{of}: vertex index {index}; {valid}"))
    }

    fn end_face(&mut self, body: &Body) -> Result<(), MeshError> {
        let end = u32::try_from(self.polygons.corners.len());
        self.polygons.offsets.push(end.map_err(|_| body.error("more than 4294967295 corners"))?);
        Ok(())
    }

    /// Takes the texture coordinates of the face that has been read last; it may have none.
    fn take_coords(&mut self, row: usize, values: &[f32]) -> Result<(), String> {
        let corners = self.polygons.corners.len() - self.coords.len();
        if let Some(bad) = values.iter().find(|x| !x.is_finite()) {
            return Err(format!("face {row} has the texture coordinate {bad}; it must be finite"));
        }
        if values.is_empty() {
            self.fill_coords();
        } else if values.len() == 2 * corners {
            self.coords.extend(values.chunks_exact(2).map(|uv| [uv[0], uv[1]]));
        } else {
            let found = values.len();
            return Err(format!(
                "face {row} has {corners} corners and {found} texture coordinates; it needs 2 each"
            ));
        }
        Ok(())
    }

    /// Gives (0, 0) to the corners that have no texture coordinate.
    fn fill_coords(&mut self) {
        self.without += self.polygons.corners.len() - self.coords.len();
        self.coords.resize(self.polygons.corners.len(), [0.0; 2]);
    }

    /// The faces with the texture coordinates of their corners, or else those of the vertices.
    pub fn finish(
        mut self,
        vertices: Option<Vec<[f32; 2]>>,
        repairs: &mut Vec<String>,
    ) -> (Polygons, Option<Uvs>) {
        if self.coords.len() == self.without {
            let uvs = vertices.map(|coords| Uvs { coords, corners: self.polygons.corners.clone() });
            return (self.polygons, uvs);
        }
        self.fill_coords();
        if self.without > 0 {
            let corners = counted(self.without, "face corner");
            repairs.push(format!("{corners} without a texture coordinate got (0, 0)"));
        }
        let corners = (0..self.coords.len() as u32).collect();
        (self.polygons, Some(Uvs { coords: self.coords, corners }))
    }
}

fn find_indices(element: &Element, who: &str) -> Result<usize, MeshError> {
    let is_indices = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
    let found = element.properties.iter().position(|p| p.list.is_some() && is_indices(&p.name));
    found.ok_or_else(|| MeshError::new(format!("the {who} need a list property `vertex_indices`")))
}
