//! glTF: scene graphs, ways to write the same numbers, where buffers may lie, and what is refused.

use base64::Engine;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;
use taffeta_io::{MeshFormat, MeshOptions, load_mesh, parse_mesh};

const U8: u32 = 5121;
const U16: u32 = 5123;
const F32: u32 = 5126;

/// A glTF in the making; everything is in its first buffer.
#[derive(Clone)]
struct Gltf {
    json: Value,
    data: Vec<u8>,
}

impl Gltf {
    /// A document with one mesh of one primitive, `attributes` and `indices`, at one node.
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "bufferViews": [], "accessors": [],
            "meshes": [{"primitives": [{"attributes": {}}]}],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        });
        Self { json, data: Vec::new() }
    }

    /// A right-angled triangle with legs of 1 m in the xy plane; it looks to +z.
    fn triangle() -> Self {
        let mut gltf = Self::new();
        gltf.attribute("POSITION", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        gltf
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let (start, view) =
            (self.data.len(), json!({"buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len()}));
        assert!(start.is_multiple_of(4));
        self.data.extend(bytes);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        push(&mut self.json["bufferViews"], view)
    }

    fn accessor(&mut self, bytes: &[u8], kind: &str, component: u32, count: usize) -> usize {
        let view = self.view(bytes);
        push(
            &mut self.json["accessors"],
            json!({"bufferView": view, "type": kind, "componentType": component, "count": count}),
        )
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    fn attribute(&mut self, name: &str, kind: &str, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let size = if kind == "SCALAR" { 1 } else { usize::from(kind.as_bytes()[3] - b'0') };
        let accessor = self.accessor(&bytes, kind, F32, numbers.len() / size);
        self.primitive()["attributes"][name] = accessor.into();
        accessor
    }

    fn indices(&mut self, component: u32, indices: &[u32]) -> usize {
        let size = [1, 1, 2, 2, 4, 4][component as usize - 5120];
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()[..size].to_vec()).collect();
        let accessor = self.accessor(&bytes, "SCALAR", component, indices.len());
        self.primitive()["indices"] = accessor.into();
        accessor
    }

    /// As JSON with its data in a URI.
    fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.data);
        let buffer = json!({"byteLength": self.data.len(), "uri": format!("data:application/octet-stream;base64,{data}")});
        json["buffers"] = json!([buffer]);
        json.to_string().into_bytes()
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.data.len()}]);
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
        let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &self.data)].concat();
        [&b"glTF"[..], &2_u32.to_le_bytes(), &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
    }

    /// Reads it both ways, which must agree.
    fn read(&self) -> Result<Surface, String> {
        let parse = |bytes: &[u8]| {
            parse_mesh(bytes, MeshFormat::Gltf, &MeshOptions::default()).map_err(|error| error.to_string())
        };
        let (text, glb) = (parse(&self.text()), parse(&self.glb()));
        assert_eq!(
            text.as_ref().map(|s| (&s.vertices, &s.polygons)),
            glb.as_ref().map(|s| (&s.vertices, &s.polygons))
        );
        text
    }

    fn refused(&self) -> String {
        self.read().unwrap_err()
    }
}

fn push(list: &mut Value, item: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(item);
    list.len() - 1
}

fn group<'a>(surface: &'a Surface, name: &str) -> &'a [u32] {
    &surface.groups.iter().find(|(found, _)| found == name).unwrap_or_else(|| panic!("no group {name}")).1
}

#[test]
fn indices_of_every_size_strips_fans_and_no_indices_give_the_same_square() {
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    for (component, mode, indices, expected) in [
        (U8, 4, vec![0, 1, 2, 0, 2, 3], [[0, 1, 2], [0, 2, 3]]),
        (U16, 4, vec![0, 1, 2, 0, 2, 3], [[0, 1, 2], [0, 2, 3]]),
        (5125, 4, vec![0, 1, 2, 0, 2, 3], [[0, 1, 2], [0, 2, 3]]),
        (U8, 5, vec![0, 1, 3, 2], [[0, 1, 3], [1, 2, 3]]),
        (U8, 6, vec![0, 1, 2, 3], [[1, 2, 0], [2, 3, 0]]),
    ] {
        let mut gltf = Gltf::new();
        gltf.attribute("POSITION", "VEC3", &square);
        gltf.indices(component, &indices);
        gltf.primitive()["mode"] = mode.into();
        let surface = gltf.read().unwrap();
        assert_eq!(surface.polygons.corners, expected.concat(), "mode {mode}, component {component}");
        assert_eq!(surface.repairs, Vec::<String>::new());
    }
    let mut gltf = Gltf::new();
    let fan = [&square[..], &square[..6]].concat();
    gltf.attribute("POSITION", "VEC3", &fan);
    gltf.primitive()["mode"] = 6.into();
    assert_eq!(gltf.read().unwrap().polygons.corners, [1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0]);
}

#[test]
fn quantised_interleaved_and_sparse_positions_are_read() {
    // (component, bytes of one, whether normalised, what 1 m is in the file)
    let kinds: [(u32, usize, bool, i32); 6] = [
        (5120, 1, true, 127),
        (5121, 1, true, 255),
        (5122, 2, true, 32767),
        (5123, 2, true, 65535),
        (5120, 1, false, 1),
        (5123, 2, false, 1),
    ];
    let expected = Gltf::triangle().read().unwrap().vertices;
    for (component, size, normalised, one) in kinds {
        let mut gltf = Gltf::new();
        let stride = (3 * size).next_multiple_of(4);
        let mut bytes = vec![0_u8; 2];
        for place in &expected {
            let mut element: Vec<u8> =
                place.iter().flat_map(|&x| (x as i32 * one).to_le_bytes()[..size].to_vec()).collect();
            element.resize(stride, 99);
            bytes.extend(element);
        }
        // The last element needs no padding.
        bytes.truncate(2 + 2 * stride + 3 * size);
        let accessor = gltf.accessor(&bytes, "VEC3", component, 3);
        gltf.json["accessors"][accessor]["byteOffset"] = 2.into();
        gltf.json["accessors"][accessor]["normalized"] = normalised.into();
        gltf.json["bufferViews"][0]["byteStride"] = stride.into();
        gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization", "KHR_materials_unlit"]);
        gltf.primitive()["attributes"]["POSITION"] = accessor.into();
        assert_eq!(gltf.read().unwrap().vertices, expected, "{component}, normalised: {normalised}");
    }
    let mut gltf = Gltf::triangle();
    let indices = gltf.view(&[0, 2]);
    let values: Vec<u8> = [0.0_f32, 0.0, 5.0, 0.0, 2.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let values = gltf.view(&values);
    gltf.json["accessors"][0]["sparse"] = json!({"count": 2,
        "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
    assert_eq!(gltf.read().unwrap().vertices, [[0.0, 0.0, 5.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    let mut beyond = gltf.clone();
    beyond.json["accessors"][0]["sparse"]["count"] = 4.into();
    assert!(beyond.refused().contains("accessor 0: 4 sparse elements of 3"), "{}", beyond.refused());
    let mut beyond = gltf.clone();
    beyond.data[37] = 3;
    assert!(
        beyond.refused().contains("accessor 0: sparse index 3; there are 3 elements"),
        "{}",
        beyond.refused()
    );
    gltf.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(gltf.read().unwrap().vertices, [[0.0, 0.0, 5.0], [0.0; 3], [0.0, 2.0, 0.0]]);
    gltf.json["accessors"][0]["count"] = 4_000_000_000_u64.into();
    assert!(gltf.refused().contains("accessor 0: 4000000000 elements"), "{}", gltf.refused());
}

#[test]
fn nodes_place_copies_and_a_mirror_keeps_faces_outward() {
    let mut gltf = Gltf::triangle();
    gltf.json["meshes"][0]["name"] = "leg".into();
    gltf.json["scene"] = 1.into();
    gltf.json["scenes"] = json!([{"nodes": [4]}, {"name": "empty parent first", "nodes": [0]}]);
    let half = 0.5_f64.sqrt();
    gltf.json["nodes"] = json!([
        {"translation": [10, 0, 0], "children": [1, 2, 3]},
        {"mesh": 0, "name": "left"},
        // A quarter turn about x: y becomes z.
        {"mesh": 0, "name": "right", "rotation": [half, 0, 0, half], "scale": [2, 3, 4], "translation": [0, 0, 1]},
        {"mesh": 0, "name": "mirrored", "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -2, 0, 0, 1]},
        {"mesh": 9},
    ]);
    let surface = gltf.read().unwrap();
    let expected = [
        [10.0, 0.0, 0.0],
        [11.0, 0.0, 0.0],
        [10.0, 1.0, 0.0],
        [10.0, 0.0, 1.0],
        [12.0, 0.0, 1.0],
        [10.0, 0.0, 4.0],
        [8.0, 0.0, 0.0],
        [7.0, 0.0, 0.0],
        [8.0, 1.0, 0.0],
    ];
    for (found, expected) in surface.vertices.iter().zip(expected) {
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-14), "{found:?}, not {expected:?}");
    }
    // The mirrored one still looks to +z.
    assert_eq!(surface.polygons.corners, [0, 1, 2, 3, 4, 5, 6, 8, 7]);
    assert_eq!(group(&surface, "right"), [3, 4, 5]);
    assert_eq!(group(&surface, "leg"), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    gltf.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(gltf.refused(), "mesh 9; there are 1");
    gltf.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(gltf.read().unwrap().vertices, Gltf::triangle().read().unwrap().vertices);
}

#[test]
fn graphs_that_are_not_trees_are_refused() {
    let mut gltf = Gltf::triangle();
    for (nodes, roots, expected) in [
        (json!([{"children": [1]}, {"name": "b", "children": [0]}]), json!([0]), "node 0 is reached twice"),
        (
            json!([{"children": [0]}]),
            json!([0]),
            "node 0 is reached twice; nodes must form trees, without cycles",
        ),
        (
            json!([{"children": [1, 2]}, {"children": [2]}, {"name": "c"}]),
            json!([0]),
            "node 2 `c` is reached twice",
        ),
        (json!([{"mesh": 0}]), json!([0, 0]), "node 0 is reached twice"),
        (json!([{"children": [4294967296_u64]}]), json!([0]), "node 4294967296; there are 1"),
        (json!([{"name": "r", "rotation": [0, 0, 0, 0]}]), json!([0]), "node 0 `r`: its rotation"),
    ] {
        gltf.json["nodes"] = nodes;
        gltf.json["scenes"] = json!([{"nodes": roots}]);
        assert!(gltf.refused().starts_with(expected), "{}", gltf.refused());
    }
    // A chain so deep that a recursive walk would end the program.
    let deep = |i: usize| if i < 200_000 { json!({"children": [i + 1]}) } else { json!({"mesh": 0}) };
    gltf.json["nodes"] = (0..=200_000).map(deep).collect();
    gltf.json["scenes"] = json!([{"nodes": [0]}]);
    assert_eq!(gltf.read().unwrap().vertices.len(), 3);
}

#[test]
fn texture_coordinates_are_turned_over_and_shared() {
    let mut gltf = Gltf::triangle();
    gltf.attribute("TEXCOORD_0", "VEC2", &[0.0, 0.0, 0.25, 1.0, 0.5, 0.75]);
    let other = gltf.primitive().clone();
    let mut without = other.clone();
    without["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    without["targets"] = json!([{"POSITION": 0}]);
    let lines = json!({"mode": 1, "attributes": {"POSITION": 0}});
    gltf.json["meshes"][0]["primitives"] = json!([other, other, without, lines]);
    gltf.json["nodes"][0]["skin"] = 0.into();
    let surface = gltf.read().unwrap();
    let uvs = surface.uvs.unwrap();
    assert_eq!(uvs.coords, [[0.0, 1.0], [0.25, 0.0], [0.5, 0.25], [0.0, 0.0]]);
    assert_eq!(uvs.corners, [0, 1, 2, 0, 1, 2, 3, 3, 3]);
    assert_eq!(surface.vertices.len(), 3);
    assert_eq!(
        surface.repairs[..4],
        [
            "passed over 1 primitive of points or lines",
            "1 skin ignored: the mesh is in its bind pose",
            "morph targets of 1 mesh ignored: the base shape is read",
            "3 face corners without a texture coordinate got (0, 0)",
        ]
    );
    let mut gltf = Gltf::triangle();
    let bytes: Vec<u8> = [0_u16, 65535, 0, 0, 0, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let accessor = gltf.accessor(&bytes, "VEC2", U16, 3);
    gltf.json["accessors"][accessor]["normalized"] = true.into();
    gltf.primitive()["attributes"]["TEXCOORD_0"] = accessor.into();
    assert_eq!(gltf.read().unwrap().uvs.unwrap().coords, [[0.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
    gltf.json["accessors"][accessor]["count"] = 2.into();
    assert_eq!(gltf.refused(), "mesh 0, primitive 0: TEXCOORD_0: 2 for 3 vertices");
}

#[test]
fn names_and_attributes_become_groups() {
    let mut gltf = Gltf::triangle();
    gltf.attribute("_PIN", "SCALAR", &[1.0, 0.5, 0.6]);
    gltf.attribute("_WIND", "VEC3", &[0.0; 9]);
    gltf.json["meshes"][0]["name"] = "shirt".into();
    gltf.json["nodes"][0]["name"] = "shirt".into();
    let groups = gltf.read().unwrap().groups;
    assert_eq!(groups, [("_PIN".to_owned(), vec![0, 2]), ("shirt".to_owned(), vec![0, 1, 2])]);
}

#[test]
fn what_lies_outside_of_its_buffer_is_refused_at_each_step() {
    type Damage = fn(&mut Gltf);
    let cases: [(Damage, &str); 18] = [
        (
            |g| g.primitive()["attributes"]["POSITION"] = 7.into(),
            "mesh 0, primitive 0: POSITION: accessor 7; there are 1",
        ),
        (|g| g.primitive()["attributes"] = json!({}), "mesh 0, primitive 0: it has no POSITION"),
        (|g| g.primitive()["mode"] = 7.into(), "mode 7 is not a kind of primitives"),
        (|g| g.primitive()["indices"] = 0.into(), "indices: accessor 0: its type is VEC3; it must be SCALAR"),
        (|g| g.json["accessors"][0]["bufferView"] = 1.into(), "accessor 0: bufferView 1; there are 1"),
        (
            |g| g.json["accessors"][0]["count"] = 4.into(),
            "accessor 0: 4 elements need 48 bytes of bufferView 0, which has 36",
        ),
        (|g| g.json["accessors"][0]["count"] = u64::MAX.into(), "18446744073709551615 elements"),
        (|g| g.json["accessors"][0]["byteOffset"] = 1.into(), "3 elements need 37 bytes"),
        (
            |g| g.json["accessors"][0]["byteOffset"] = u64::MAX.into(),
            "3 elements need 18446744073709551651 bytes",
        ),
        (|g| g.json["accessors"][0]["type"] = "VEC4".into(), "its type is VEC4; it must be VEC3"),
        (|g| g.json["accessors"][0]["componentType"] = 5130.into(), "componentType 5130"),
        (
            |g| g.json["bufferViews"][0]["byteLength"] = 37.into(),
            "bufferView 0 has 37 bytes from byte 0 on, but buffer 0 has only 36",
        ),
        (
            |g| g.json["bufferViews"][0]["byteOffset"] = u64::MAX.into(),
            "bufferView 0 has 36 bytes from byte 18446744073709551615",
        ),
        (|g| g.json["bufferViews"][0]["buffer"] = 1.into(), "bufferView 0 is in buffer 1; there are 1"),
        (|g| g.json["bufferViews"][0]["byteStride"] = 8.into(), "a byteStride of 8, but an element 12 bytes"),
        (|g| g.json["scene"] = 1.into(), "scene 1; there are 1"),
        (
            |g| {
                g.json["accessors"][0]["normalized"] = true.into();
                g.data[..4].copy_from_slice(&f32::NEG_INFINITY.to_le_bytes());
            },
            "POSITION: vertex 0 has the coordinate -inf",
        ),
        (
            |g| g.data[12..16].copy_from_slice(&f32::NAN.to_le_bytes()),
            "POSITION: vertex 1 has the coordinate NaN",
        ),
    ];
    for (damage, expected) in cases {
        let mut gltf = Gltf::triangle();
        damage(&mut gltf);
        let error = gltf.refused();
        assert!(error.contains(expected), "{error}, not {expected}");
    }
    for (component, indices, expected) in [
        (U8, [0, 1, 3], "indices: accessor 1: index 2 is vertex 3; valid: 0 to 2"),
        (U16, [0, 65535, 1], "index 1 is vertex 65535 (restarts are not part of glTF); valid: 0 to 2"),
    ] {
        let mut gltf = Gltf::triangle();
        gltf.indices(component, &indices);
        assert!(gltf.refused().contains(expected), "{}", gltf.refused());
    }
    let mut gltf = Gltf::triangle();
    gltf.attribute("_PIN", "SCALAR", &[0.0, 1.0, 2.0]);
    gltf.primitive()["indices"] = 1.into();
    assert!(gltf.refused().contains("accessor 1: indices must be unsigned integers"), "{}", gltf.refused());
    let mut gltf = Gltf::new();
    gltf.attribute("POSITION", "VEC3", &[0.5; 3 * 300]);
    gltf.indices(U8, &[0, 1, 255]);
    assert!(gltf.refused().contains("index 2 is vertex 255 (restarts"), "{}", gltf.refused());
    gltf.indices(U16, &[0, 1, 255, 256]);
    assert_eq!(gltf.refused(), "mesh 0, primitive 0: 4 corners do not make triangles");
}

#[test]
fn a_small_file_cannot_ask_for_much() {
    let mut gltf = Gltf::new();
    gltf.attribute("POSITION", "VEC3", &[0.5; 3 * 20_000]);
    gltf.json["nodes"] = (0..2_000).map(|_| json!({"mesh": 0})).collect();
    gltf.json["scenes"] = json!([{"nodes": (0..2_000).collect::<Vec<_>>()}]);
    gltf.json["meshes"][0]["primitives"][0]["mode"] = 5.into();
    assert!(gltf.refused().contains("repeats its data too often for its size"), "{}", gltf.refused());
    let mut gltf = Gltf::triangle();
    let primitive = gltf.primitive().clone();
    gltf.json["accessors"][0]["count"] = 0.into();
    gltf.json["meshes"][0]["primitives"] = vec![primitive; 20_000].into();
    gltf.json["nodes"] = (0..20_000).map(|_| json!({"mesh": 0})).collect();
    gltf.json["scenes"] = json!([{"nodes": (0..20_000).collect::<Vec<_>>()}]);
    assert!(gltf.refused().contains("repeats its data too often for its size"), "{}", gltf.refused());
    let mut gltf = Gltf::triangle();
    gltf.json["extras"] = serde_json::from_str(&("[".repeat(100) + &"]".repeat(100))).unwrap();
    assert!(gltf.read().is_ok());
    let deep = "[".repeat(1_000_000);
    let error =
        parse_mesh(deep.as_bytes(), MeshFormat::Gltf, &MeshOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with("cannot be read as glTF 2.0"), "{error}");
}

#[test]
fn required_extensions_that_change_the_shape_are_refused_by_name() {
    let mut gltf = Gltf::triangle();
    for (name, expected) in [
        (
            "KHR_draco_mesh_compression",
            "the required extension KHR_draco_mesh_compression; export without compression",
        ),
        ("EXT_meshopt_compression", "EXT_meshopt_compression; export without compression"),
        ("EXT_mesh_gpu_instancing", "EXT_mesh_gpu_instancing; export without instancing"),
        ("ACME_bend", "the required extension ACME_bend; export without it"),
    ] {
        gltf.json["extensionsRequired"] = json!(["KHR_texture_transform", name]);
        assert!(gltf.refused().starts_with("not yet supported: ") && gltf.refused().ends_with(expected));
    }
    gltf.json["extensionsRequired"] = json!(["KHR_texture_basisu", "KHR_lights_punctual"]);
    gltf.json["textures"] = json!([{}]);
    assert!(gltf.read().is_ok());
    gltf.json["asset"]["version"] = "1.0".into();
    assert_eq!(gltf.refused(), "not supported: glTF 1.0; convert to glTF 2.0");
}

/// A folder with a triangle's data at several places, and the answer to a glTF in `scene/` that names `uri`.
fn ask(uri: &str, byte_length: usize, within: &[&str]) -> Result<Surface, String> {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let gltf = Gltf::triangle();
    for sub in ["scene/parts", "shared", "secret"] {
        fs::create_dir_all(at(sub)).unwrap();
        fs::write(at(sub).join("a b.bin"), [&gltf.data[..], b"more"].concat()).unwrap();
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(at("secret/a b.bin"), at("scene/link.bin")).unwrap();
    let mut json = gltf.json;
    let uri = uri.replace("FOLDER", &folder.path().display().to_string());
    json["buffers"] = json!([{"byteLength": byte_length, "uri": uri}]);
    fs::write(at("scene/mesh.gltf"), json.to_string()).unwrap();
    let within: Vec<PathBuf> = within.iter().map(|name| at(name)).collect();
    let options = MeshOptions { within: &within, ..MeshOptions::default() };
    load_mesh(&at("scene/mesh.gltf"), &options).map_err(|error| error.to_string())
}

#[test]
fn buffers_lie_in_the_folder_of_the_file_or_where_the_caller_says() {
    let good: [(&str, &[&str]); 5] = [
        ("parts/a%20b.bin", &[]),
        ("./parts/../parts/a b.bin", &[]),
        ("../shared/a%20b.bin", &["shared"]),
        ("%2E%2E/shared/a%20b.bin", &["none", "shared"]),
        ("link.bin", &["secret"]),
    ];
    for (uri, within) in good {
        let surface = ask(uri, 36, within).expect(uri);
        assert_eq!(surface.vertices, Gltf::triangle().read().unwrap().vertices);
    }
    let outside = [
        "../secret/a%20b.bin",
        "%2e%2e/secret/a%20b.bin",
        "../../../../../../../../etc/passwd",
        "FOLDER/secret/a b.bin",
        "/etc/passwd",
        "file:///etc/passwd",
        "http://example.org/a.bin",
        "C:/a.bin",
        "..\\secret\\a.bin",
        #[cfg(unix)]
        "link.bin",
    ];
    for uri in outside {
        let error = ask(uri, 36, &["shared"]).expect_err(uri);
        assert!(error.contains("mesh.gltf: buffer 0: `"), "{error}");
        assert!(error.ends_with("is outside the scene's folder; put the file beside the glTF"), "{error}");
    }
}

#[test]
fn files_that_are_missing_or_short_are_named() {
    let of = |uri: &str, length: usize| ask(uri, length, &[]).unwrap_err();
    assert!(of("none.bin", 36).contains("buffer 0: `none.bin` cannot be read: "));
    assert!(of("parts", 0).contains("buffer 0: `parts` cannot be read: is not a regular file"));
    assert!(of("parts/a%20b.bin", 41).contains("`parts/a%20b.bin` has 40 bytes, but byteLength says 41"));
    assert!(
        of("parts/a%20b.bin", usize::MAX).contains("has 40 bytes, but byteLength says 18446744073709551615")
    );
    assert!(of("%ff", 36).contains("`%ff` has a % that is not followed by UTF-8"));
    assert!(of("a%00b", 36).contains("cannot be read"));
    assert!(of("data:;base64,AAAA", 4).contains("byteLength says 4 bytes, but there are 3"));
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"] = json!([{"byteLength": 36, "uri": "a.bin"}]);
    let alone = parse_mesh(gltf.json.to_string().as_bytes(), MeshFormat::Gltf, &MeshOptions::default());
    assert!(alone.unwrap_err().to_string().contains("buffer 0: `a.bin` is a file of its own"));
    gltf.json["buffers"] = json!([{"byteLength": 36}]);
    let none = parse_mesh(gltf.json.to_string().as_bytes(), MeshFormat::Gltf, &MeshOptions::default());
    assert!(none.unwrap_err().to_string().contains("buffer 0: it has no uri"));
}

#[test]
fn damaged_documents_get_an_answer() {
    let mut gltf = Gltf::triangle();
    gltf.attribute("TEXCOORD_0", "VEC2", &[0.0; 6]);
    gltf.attribute("_PIN", "SCALAR", &[1.0; 3]);
    gltf.indices(U8, &[0, 1, 2]);
    gltf.json["nodes"][0]["scale"] = json!([1, -1, 1]);
    for whole in [gltf.text(), gltf.glb()] {
        for end in 0..whole.len() {
            let answer = parse_mesh(&whole[..end], MeshFormat::Gltf, &MeshOptions::default());
            assert!(answer.is_err(), "{end} bytes were accepted");
        }
        let mut bytes = whole.clone();
        for at in 0..whole.len() {
            for flip in [1, 2, 4, 8, 16, 32, 64, 128, 255] {
                bytes[at] ^= flip;
                let _ = parse_mesh(&bytes, MeshFormat::Gltf, &MeshOptions::default());
                bytes[at] = whole[at];
            }
        }
    }
    assert!(
        load_mesh(Path::new("none.glb"), &MeshOptions::default())
            .unwrap_err()
            .to_string()
            .contains("cannot be read")
    );
}
