//! Gathers vertices, triangles, texture coordinates and groups, primitive by primitive.

use super::accessor::Data;
use super::document::{Mesh, Primitive};
use super::scene::{Placement, label};
use crate::mesh::RawMesh;
use crate::mesh::clean::counted;
use std::collections::HashMap;
use taffeta::topology::{Polygons, Uvs};

/// A document may ask for this many numbers of each kind without having bytes for them: copies of its meshes.
const COPIES: usize = 1 << 24;

/// What placing a primitive costs besides, counted in such numbers.
const PRIMITIVE: usize = 64;

/// Modes of primitives (glTF 2.0, 5.24.4).
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// What has been read so far.
pub(super) struct Builder<'a> {
    data: &'a Data<'a>,
    mesh: RawMesh,
    uvs: Uvs,
    /// Where the texture coordinates of an accessor start, and how many they are.
    uv_starts: HashMap<usize, (u32, usize)>,
    group_of_name: HashMap<String, usize>,
    /// How many vertices, corners and members of groups there may still be.
    room: usize,
    passed_over: usize,
    with_targets: usize,
    with_skin: usize,
}

/// Where the vertices of a primitive are.
#[derive(Clone, Copy)]
struct Span {
    start: u32,
    count: usize,
}

impl<'a> Builder<'a> {
    pub fn new(data: &'a Data<'a>) -> Self {
        let bytes: usize = data.buffers.iter().map(|buffer| buffer.len()).sum();
        Self {
            data,
            mesh: RawMesh { polygons: Polygons { offsets: vec![0], corners: vec![] }, ..RawMesh::default() },
            uvs: Uvs::default(),
            uv_starts: HashMap::new(),
            group_of_name: HashMap::new(),
            // A byte may be an index in a strip, and so three corners; a vertex has some names.
            room: bytes.saturating_mul(8).max(COPIES).min(u32::MAX as usize),
            passed_over: 0,
            with_targets: 0,
            with_skin: 0,
        }
    }

    /// Adds the primitives of a mesh in its place.
    pub fn add(&mut self, placement: &Placement) -> Result<(), String> {
        let meshes = &self.data.document.meshes;
        let mesh = meshes
            .get(placement.mesh)
            .ok_or_else(|| format!("mesh {}; there are {}", placement.mesh, meshes.len()))?;
        let first = self.mesh.vertices.len() as u32;
        let mut spans = HashMap::new();
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            self.primitive(primitive, placement, &mut spans).map_err(|what| {
                format!("{}, primitive {index}: {what}", label("mesh", placement.mesh, mesh.name.as_deref()))
            })?;
        }
        self.name_vertices(mesh, placement, first)
    }

    /// The node's and the mesh's names become groups.
    fn name_vertices(&mut self, mesh: &Mesh, placement: &Placement, first: u32) -> Result<(), String> {
        let node = placement.node.map(|index| &self.data.document.nodes[index]);
        self.with_skin += usize::from(node.is_some_and(|node| node.skin.is_some()));
        self.with_targets += usize::from(mesh.primitives.iter().any(|p| !p.targets.is_empty()));
        let end = self.mesh.vertices.len() as u32;
        for name in [node.and_then(|node| node.name.as_ref()), mesh.name.as_ref()].into_iter().flatten() {
            self.take((end - first) as usize)?;
            self.group(name).extend(first..end);
        }
        Ok(())
    }

    /// Adds a primitive. Those of one mesh may share vertices: `spans` says where an accessor's are.
    fn primitive(
        &mut self,
        primitive: &Primitive,
        placement: &Placement,
        spans: &mut HashMap<usize, Span>,
    ) -> Result<(), String> {
        self.take(PRIMITIVE)?;
        match primitive.mode {
            TRIANGLES..=FAN => {}
            0..TRIANGLES => {
                self.passed_over += 1;
                return Ok(());
            }
            mode => return Err(format!("mode {mode} is not a kind of primitives")),
        }
        let Some(&positions) = primitive.attributes.get("POSITION") else {
            return Err("it has no POSITION".to_owned());
        };
        let span = match spans.get(&positions) {
            Some(&span) => span,
            None => self.vertices(positions, placement).map_err(|what| format!("POSITION: {what}"))?,
        };
        spans.insert(positions, span);
        let uvs = primitive.attributes.get("TEXCOORD_0");
        let uv_start = uvs.map(|&accessor| self.coords(accessor, span.count)).transpose();
        let uv_start = uv_start.map_err(|what| format!("TEXCOORD_0: {what}"))?;
        for (name, &accessor) in
            primitive.attributes.range("_".to_owned()..).take_while(|(name, _)| name.starts_with('_'))
        {
            self.attribute(name, accessor, span).map_err(|what| format!("{name}: {what}"))?;
        }
        self.triangles(primitive, span, uv_start, placement.transform.mirrors())
    }

    fn vertices(&mut self, accessor: usize, placement: &Placement) -> Result<Span, String> {
        let places = self.data.numbers::<3>(accessor)?;
        self.take(places.len())?;
        let span = Span { start: self.mesh.vertices.len() as u32, count: places.len() };
        self.mesh.vertices.reserve(places.len());
        for (vertex, place) in places.into_iter().enumerate() {
            let place = placement.transform.apply(place);
            if let Some(bad) = place.iter().find(|x| !x.is_finite()) {
                return Err(format!("vertex {vertex} has the coordinate {bad}; it must be finite"));
            }
            self.mesh.vertices.push(place);
        }
        Ok(span)
    }

    /// Reads texture coordinates, once for all that use them; returns where they start.
    fn coords(&mut self, accessor: usize, vertices: usize) -> Result<u32, String> {
        let (start, count) = match self.uv_starts.get(&accessor) {
            Some(&known) => known,
            None => self.read_coords(accessor)?,
        };
        self.uv_starts.insert(accessor, (start, count));
        if count == vertices { Ok(start) } else { Err(format!("{count} for {}", counted_vertices(vertices))) }
    }

    fn read_coords(&mut self, accessor: usize) -> Result<(u32, usize), String> {
        let coords = self.data.numbers::<2>(accessor)?;
        self.take(coords.len())?;
        let start = self.uvs.coords.len() as u32;
        if let Some((vertex, [u, v])) =
            coords.iter().enumerate().find(|(_, uv)| uv.iter().any(|x| !x.is_finite()))
        {
            return Err(format!("vertex {vertex} has ({u}, {v}); texture coordinates must be finite"));
        }
        // glTF counts v from the top of the picture, OBJ and USD from the bottom.
        self.uvs.coords.extend(coords.iter().map(|&[u, v]| [u as f32, (1.0 - v) as f32]));
        Ok((start, coords.len()))
    }

    /// A number for each vertex becomes a group: the vertices above 0.5.
    fn attribute(&mut self, name: &str, accessor: usize, span: Span) -> Result<(), String> {
        if self.data.accessor(accessor)?.kind != "SCALAR" {
            return Ok(());
        }
        let values = self.data.numbers::<1>(accessor)?;
        self.take(values.len())?;
        if values.len() != span.count {
            return Err(format!("{} for {}", counted(values.len(), "number"), counted_vertices(span.count)));
        }
        let members = values.iter().zip(span.start..).filter(|([value], _)| *value > 0.5);
        self.group(name).extend(members.map(|(_, vertex)| vertex));
        Ok(())
    }

    fn triangles(
        &mut self,
        primitive: &Primitive,
        span: Span,
        uv_start: Option<u32>,
        mirrored: bool,
    ) -> Result<(), String> {
        let corners = match primitive.indices {
            Some(accessor) => {
                self.data.indices(accessor, span.count).map_err(|what| format!("indices: {what}"))?
            }
            None => (0..span.count as u32).collect(),
        };
        let (count, fits) = match primitive.mode {
            TRIANGLES => (corners.len() / 3, corners.len().is_multiple_of(3)),
            _ => (corners.len().saturating_sub(2), corners.len() != 1 && corners.len() != 2),
        };
        if !fits {
            let kind = ["triangles", "a strip", "a fan"][(primitive.mode - TRIANGLES) as usize];
            return Err(format!("{} do not make {kind}", counted(corners.len(), "corner")));
        }
        self.take(count.saturating_mul(3))?;
        for i in 0..count {
            let mut triangle = match primitive.mode {
                TRIANGLES => [3 * i, 3 * i + 1, 3 * i + 2],
                STRIP => [i, i + 1 + i % 2, i + 2 - i % 2],
                _ => [i + 1, i + 2, 0],
            }
            .map(|at| corners[at]);
            if mirrored {
                triangle.swap(1, 2);
            }
            self.mesh.polygons.push(&triangle.map(|corner| span.start + corner));
            self.uvs.corners.extend(triangle.map(|corner| uv_start.map_or(u32::MAX, |start| start + corner)));
        }
        Ok(())
    }

    fn group(&mut self, name: &str) -> &mut Vec<u32> {
        let groups = &mut self.mesh.groups;
        let index = *self.group_of_name.entry(name.to_owned()).or_insert_with(|| {
            groups.push((name.to_owned(), Vec::new()));
            groups.len() - 1
        });
        &mut groups[index].1
    }

    fn take(&mut self, count: usize) -> Result<(), String> {
        let left = self.room.checked_sub(count);
        self.room = left.ok_or("the document repeats its data too often for its size; use fewer copies")?;
        Ok(())
    }

    /// The mesh, with what was left out said.
    pub fn finish(mut self) -> RawMesh {
        for (_, members) in &mut self.mesh.groups {
            members.sort_unstable();
            members.dedup();
        }
        let notes = &mut self.mesh.repairs;
        if self.passed_over > 0 {
            notes.push(format!("passed over {} of points or lines", counted(self.passed_over, "primitive")));
        }
        if self.with_skin > 0 {
            notes.push(format!("{} ignored: the mesh is in its bind pose", counted(self.with_skin, "skin")));
        }
        if self.with_targets > 0 {
            let meshes = if self.with_targets == 1 {
                "1 mesh".to_owned()
            } else {
                format!("{} meshes", self.with_targets)
            };
            notes.push(format!("morph targets of {meshes} ignored: the base shape is read"));
        }
        self.mesh.uvs = finish_uvs(self.uvs, notes);
        self.mesh
    }
}

/// `None` where no corner has texture coordinates; corners without get (0, 0).
fn finish_uvs(mut uvs: Uvs, notes: &mut Vec<String>) -> Option<Uvs> {
    let without = uvs.corners.iter().filter(|&&uv| uv == u32::MAX).count();
    if without == uvs.corners.len() {
        return None;
    }
    if without > 0 {
        let none = uvs.coords.len() as u32;
        uvs.corners.iter_mut().filter(|uv| **uv == u32::MAX).for_each(|uv| *uv = none);
        uvs.coords.push([0.0; 2]);
        notes.push(format!("{without} face corners without a texture coordinate got (0, 0)"));
    }
    Some(uvs)
}

fn counted_vertices(count: usize) -> String {
    if count == 1 { "1 vertex".to_owned() } else { format!("{count} vertices") }
}
