//! A pose of all bodies as GLB, the binary form of glTF 2.0: a node and a mesh for each, in triangles and lines.

use super::glb_buffer::GlbBuffer;
use super::part::Part;
use super::triangles::each_triangle;
use super::uvs::Split;
use super::{Begin, Positions};
use serde_json::{Map, Value, json};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;

/// glTF's numbers for what indices join.
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;
/// `glTF`, `JSON` and `BIN` as numbers.
const MAGIC: u32 = u32::from_le_bytes(*b"glTF");
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");
const VERSION: u32 = 2;
/// Whole numbers up to here are exact in 32 bits.
const EXACT: usize = 1 << 24;

/// A body as it goes into a GLB file.
///
/// ```
/// use taffeta_io::output::{GlbBody, Positions, write_glb};
/// use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};
///
/// # let folder = tempfile::tempdir()?;
/// let kite = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let surface = parse_mesh(kite, MeshFormat::Obj, &MeshOptions::default())?;
/// let positions = Positions::F64(&surface.vertices);
/// let kite = GlbBody { name: "kite", surface: &surface, positions, normals: &[] };
/// let file = write_glb(&folder.path().join("kite.glb"), &[kite])?;
/// assert!(std::fs::read(file)?.starts_with(b"glTF"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct GlbBody<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its faces and texture coordinates.
    pub surface: &'a Surface,
    /// Where its vertices are [m].
    pub positions: Positions<'a>,
    /// Unit vectors, one a vertex, or empty.
    pub normals: &'a [[f32; 3]],
}

/// Writes a pose of all bodies into one file.
///
/// Faces become triangles as in the simulation, links become lines. Vertices keep the file's order. Where the texture
/// has a seam, copies of vertices follow after all of the file's own, and `_VERTEX` gives the vertex that each is
/// (up to 2²⁴ vertices, beyond which its 32 bits would not be exact).
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{GlbBody, Positions, write_glb};
///
/// let body = &simulation.bodies()[0];
/// let (surface, normals) = (simulation.surface(body.handle)?, simulation.normals(body.handle)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// simulation.positions_f32(&mut positions);
/// let positions = Positions::F32(&positions);
/// let cloth = GlbBody { name: &body.name, surface: &surface, positions, normals: &normals };
/// write_glb(&folder.path().join("scene.glb"), &[cloth])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_glb(path: &Path, bodies: &[GlbBody]) -> io::Result<PathBuf> {
    let mut part = Part::open(path, Begin::New)?;
    if bodies.is_empty() {
        return Err(part.refuse("no bodies; glTF has no empty scenes".to_owned()));
    }
    let mut buffer = GlbBuffer::default();
    let mut meshes = Vec::new();
    for body in bodies {
        check(body).map_err(|what| part.refuse(format!("{}: {what}", body.name)))?;
        meshes.push(json!({ "name": body.name, "primitives": primitives(body, &mut buffer) }));
    }
    let mut json = document(&meshes, &buffer).to_string();
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    // Header, then either chunk after its length and kind.
    let lengths = [12 + 8 + json.len() + 8 + buffer.bytes.len(), json.len(), buffer.bytes.len()];
    let lengths = lengths.map(u32::try_from);
    let [Ok(all), Ok(text), Ok(binary)] = lengths else {
        return Err(part.refuse("GLB files end at 4 GiB; USD would do".to_owned()));
    };
    for number in [MAGIC, VERSION, all, text, JSON_CHUNK] {
        part.write_all(&number.to_le_bytes())?;
    }
    part.write_all(json.as_bytes())?;
    part.write_all(&binary.to_le_bytes())?;
    part.write_all(&BINARY_CHUNK.to_le_bytes())?;
    part.write_all(&buffer.bytes)?;
    part.finish()
}

/// What glTF cannot say of a body.
fn check(body: &GlbBody) -> Result<(), String> {
    let count = body.surface.vertices.len();
    let (places, normals) = (body.positions.len(), body.normals.len());
    if count == 0 || places != count || !(normals == 0 || normals == count) {
        return Err(format!("{places} positions and {normals} normals for {count} vertices"));
    }
    let mut places = body.positions.iter_f32().enumerate();
    if let Some((vertex, place)) = places.find(|(_, place)| place.iter().any(|x| !x.is_finite())) {
        return Err(format!("vertex {vertex} is at {place:?}; glTF knows finite numbers only"));
    }
    let mut uvs = body.surface.uvs.iter().flat_map(|uvs| &uvs.coords).enumerate();
    if let Some((index, uv)) = uvs.find(|(_, uv)| uv.iter().any(|x| !x.is_finite())) {
        return Err(format!("texture coordinate {index} is {uv:?}; glTF knows finite numbers only"));
    }
    Ok(())
}

/// Puts the arrays of a body into the buffer, and returns what is made of them.
fn primitives(body: &GlbBody, buffer: &mut GlbBuffer) -> Vec<Value> {
    let surface = body.surface;
    let split = surface.uvs.as_ref().map(|uvs| Split::of(surface, uvs));
    let attributes = attributes(body, split.as_ref(), buffer);
    let entries = split.as_ref().map_or(&surface.polygons.corners, |split| &split.corners);
    let mut triangles = Vec::new();
    each_triangle(surface, |corners| triangles.push(corners.map(|corner| entries[corner])));
    let mut primitives = Vec::new();
    for (mode, indices) in [(TRIANGLES, triangles.as_flattened()), (LINES, surface.links.as_flattened())] {
        if !indices.is_empty() {
            let indices = buffer.indices(indices.iter().copied());
            primitives
                .push(json!({ "attributes": attributes, "indices": indices, "material": 0, "mode": mode }));
        }
    }
    if primitives.is_empty() {
        primitives.push(json!({ "attributes": attributes, "material": 0, "mode": POINTS }));
    }
    primitives
}

/// Puts positions and what else each vertex has into the buffer.
fn attributes(body: &GlbBody, split: Option<&Split>, buffer: &mut GlbBuffer) -> Value {
    let own: Vec<[f32; 3]> = body.positions.iter_f32().collect();
    let unsplit: Vec<u32> = (0..own.len() as u32).collect();
    let source = split.map_or(&unsplit, |split| &split.source);
    let places: Vec<[f32; 3]> = source.iter().map(|&vertex| own[vertex as usize]).collect();
    let mut attributes = Map::new();
    attributes.insert("POSITION".to_owned(), json!(buffer.positions(&places)));
    if !(body.normals.is_empty() || body.surface.polygons.is_empty()) {
        let normals = source.iter().map(|&vertex| unit(body.normals[vertex as usize]));
        attributes.insert("NORMAL".to_owned(), json!(buffer.vertices(normals)));
    }
    if let Some(split) = split {
        // glTF counts from the top of the picture.
        let uvs = split.coords.iter().map(|[u, v]| [*u, 1.0 - v]);
        attributes.insert("TEXCOORD_0".to_owned(), json!(buffer.vertices(uvs)));
        if source.len() > own.len() && own.len() <= EXACT {
            let vertices = source.iter().map(|&vertex| [vertex as f32]);
            attributes.insert("_VERTEX".to_owned(), json!(buffer.vertices(vertices)));
        }
    }
    Value::Object(attributes)
}

/// The normal, or +y where there is none: glTF wants unit vectors everywhere.
fn unit(normal: [f32; 3]) -> [f32; 3] {
    let square: f32 = normal.iter().map(|x| x * x).sum();
    if (square - 1.0).abs() < 1e-3 { normal } else { [0.0, 1.0, 0.0] }
}

/// The JSON half: a node for each mesh, named as it is.
fn document(meshes: &[Value], buffer: &GlbBuffer) -> Value {
    let nodes: Vec<Value> =
        meshes.iter().enumerate().map(|(mesh, body)| json!({ "mesh": mesh, "name": body["name"] })).collect();
    json!({
        "asset": { "generator": concat!("taffeta ", env!("CARGO_PKG_VERSION")), "version": "2.0" },
        "scene": 0,
        "scenes": [{ "name": "Scene", "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        // Cloth is seen from both sides, and is not the metal that glTF takes for granted.
        "materials": [{
            "doubleSided": true,
            "name": "Default",
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        }],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    })
}
