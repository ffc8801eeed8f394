//! VTU and GLB, read back by small readers that share nothing with the writers.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use taffeta::Precision;
use taffeta::topology::{Polygons, Surface, Uvs};
use taffeta_io::output::{Begin, FrameSink, GlbBody, Positions, Vtu, write_glb};
use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};

/// A quad, a triangle and a pentagon that share corners, and a chain of three.
fn bodies() -> Vec<(String, Surface)> {
    let mut polygons = Polygons::default();
    polygons.push(&[0, 1, 2, 3]);
    polygons.push(&[1, 4, 2]);
    polygons.push(&[0, 3, 5, 6, 7]);
    let sheet = Surface { vertices: vec![[0.0; 3]; 8], polygons, ..Surface::default() };
    let chain = Surface { vertices: vec![[0.0; 3]; 3], links: vec![[0, 1], [1, 2]], ..Surface::default() };
    vec![("a/b".to_owned(), sheet), ("a_b".to_owned(), chain)]
}

/// Positions of all vertices in a frame, all different.
fn frame(number: u32) -> Vec<[f32; 3]> {
    (0..11_u32).map(|vertex| [vertex as f32, number as f32 + 0.1, -1.5]).collect()
}

fn write(sink: &mut Vtu, frames: std::ops::Range<u32>) {
    for number in frames {
        sink.frame(f64::from(number) * 0.04, &Positions::F32(&frame(number))).unwrap();
    }
}

/// All files below a folder, by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            all.insert(path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&path).unwrap());
        }
    }
    all
}

fn number(text: &str, key: &str) -> usize {
    let text = text.split_once(&format!("{key}=\"")).unwrap_or_else(|| panic!("{key} in {text}")).1;
    text.split_once('"').unwrap().0.parse().unwrap()
}

/// The bytes of the array called `name`.
fn array<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
    let start = file.windows(5).position(|bytes| bytes == b"raw\">").unwrap();
    let data = start + file[start..].iter().position(|byte| *byte == b'_').unwrap() + 1;
    let xml = std::str::from_utf8(&file[..start]).unwrap();
    let line = xml.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
    let (length, bytes) = file[data + number(line, "offset")..].split_first_chunk().unwrap();
    &bytes[..u64::from_le_bytes(*length) as usize]
}

fn u32s(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|number| u32::from_le_bytes(*number)).collect()
}

fn f32s(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks().0.iter().map(|number| f32::from_le_bytes(*number)).collect()
}

#[test]
fn vtu_has_a_file_for_each_body_and_frame_and_the_pvd_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.pvd");
    let mut sink = Box::new(Vtu::open(&path, &bodies(), Precision::F32, Begin::New).unwrap());
    write(&mut sink, 0..2);
    assert!(sink.frame(0.0, &Positions::F32(&frame(0)[1..])).is_err());
    assert!(sink.frame(0.0, &Positions::F64(&[[0.0; 3]; 10])).is_err());
    sink.rewind(2, &sink.mark()).unwrap();
    assert_eq!(sink.finish().unwrap(), std::slice::from_ref(&path));
    let all = files(folder.path());
    let names: Vec<&str> = all.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        ["a_b_000000.vtu", "a_b_000001.vtu", "a_b_2_000000.vtu", "a_b_2_000001.vtu", "scene.pvd"]
    );
    let pvd = std::str::from_utf8(&all["scene.pvd"]).unwrap();
    let listed: Vec<&str> = pvd.lines().filter(|line| line.contains("<DataSet ")).collect();
    assert_eq!(listed.len(), 4);
    assert_eq!(
        listed[3],
        "<DataSet timestep=\"0.04\" part=\"1\" name=\"a_b_2\" file=\"vtu/a_b_2_000001.vtu\"/>"
    );
    assert!(pvd.ends_with("</Collection>\n</VTKFile>\n"), "{pvd}");
}

#[test]
fn vtu_holds_the_file_s_own_faces_and_the_bits_of_the_positions() {
    let folder = tempfile::tempdir().unwrap();
    let mut sink =
        Vtu::open(&folder.path().join("scene.pvd"), &bodies(), Precision::F32, Begin::New).unwrap();
    write(&mut sink, 0..2);
    let all = files(folder.path());
    let sheet = &all["a_b_000001.vtu"];
    let text = String::from_utf8_lossy(sheet);
    assert_eq!((number(&text, "NumberOfPoints"), number(&text, "NumberOfCells")), (8, 3));
    assert!(text.contains("Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">0.04</DataArray>"));
    assert_eq!(f32s(array(sheet, "Points")), frame(1)[..8].as_flattened());
    assert_eq!(u32s(array(sheet, "connectivity")), [0, 1, 2, 3, 1, 4, 2, 0, 3, 5, 6, 7]);
    assert_eq!(u32s(array(sheet, "offsets")), [4, 7, 12]);
    assert_eq!(array(sheet, "types"), [9, 5, 7]);
    let chain = &all["a_b_2_000001.vtu"];
    assert_eq!(f32s(array(chain, "Points")), frame(1)[8..].as_flattened());
    assert_eq!(u32s(array(chain, "connectivity")), [0, 1, 1, 2]);
    assert_eq!(u32s(array(chain, "offsets")), [2, 4]);
    assert_eq!(array(chain, "types"), [3, 3]);
    assert!(sheet.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
}

#[test]
fn vtu_has_doubles_and_a_texture_without_seams() {
    let folder = tempfile::tempdir().unwrap();
    let mut bodies = bodies();
    bodies.truncate(1);
    let corners = bodies[0].1.polygons.corners.clone();
    let coords: Vec<[f32; 2]> = (0..8_u8).map(|vertex| [f32::from(vertex), 0.5]).collect();
    bodies[0].1.uvs = Some(Uvs { coords, corners });
    let places: Vec<[f64; 3]> = (0..8).map(|vertex| [f64::from(vertex) / 3.0, 0.1, 0.2]).collect();
    let path = folder.path().join("scene.pvd");
    let mut seamless = Vtu::open(&path, &bodies, Precision::F64, Begin::New).unwrap();
    seamless.frame(0.0, &Positions::F64(&places)).unwrap();
    drop(seamless);
    let file = &files(folder.path())["a_b_000000.vtu"];
    let bits = places.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    assert_eq!(array(file, "Points"), bits.collect::<Vec<u8>>());
    let uvs: Vec<f32> = (0..8_u8).flat_map(|vertex| [f32::from(vertex), 0.5]).collect();
    assert_eq!(f32s(array(file, "TCoords")), uvs);
    assert_eq!(array(file, "types"), [9, 5, 7], "arrays after the texture's are shifted");

    bodies[0].1.uvs.as_mut().unwrap().corners[4] = 0;
    let mut seam = Vtu::open(&path, &bodies, Precision::F64, Begin::New).unwrap();
    seam.frame(0.0, &Positions::F64(&places)).unwrap();
    drop(seam);
    let file = &files(folder.path())["a_b_000000.vtu"];
    assert!(!String::from_utf8_lossy(file).contains("TCoords"), "one vertex has two texture coordinates");
}

#[test]
fn vtu_goes_on_from_any_frame_to_the_same_bytes() {
    let whole = tempfile::tempdir().unwrap();
    let mut sink =
        Box::new(Vtu::open(&whole.path().join("s.pvd"), &bodies(), Precision::F32, Begin::New).unwrap());
    write(&mut sink, 0..5);
    sink.finish().unwrap();

    for finished in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.pvd");
        let mut first = Box::new(Vtu::open(&path, &bodies(), Precision::F32, Begin::New).unwrap());
        write(&mut first, 0..2);
        first.sync().unwrap();
        let mark = first.mark();
        write(&mut first, 2..4);
        if finished {
            first.finish().unwrap();
        } else {
            drop(first);
            // What a kill in the middle of a frame leaves.
            fs::write(folder.path().join("vtu/a_b_000004.vtu.part"), "half").unwrap();
        }
        let mut again = Box::new(Vtu::open(&path, &bodies(), Precision::F32, Begin::Again).unwrap());
        again.rewind(2, &mark).unwrap();
        let left = files(&folder.path().join("vtu"));
        assert!(left.keys().eq(["a_b_000000.vtu", "a_b_000001.vtu", "a_b_2_000000.vtu", "a_b_2_000001.vtu"]));
        write(&mut again, 2..5);
        again.finish().unwrap();
        assert!(files(folder.path()) == files(whole.path()), "finished before: {finished}");
    }
}

#[test]
fn vtu_does_not_go_on_where_earlier_frames_are_gone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.pvd");
    let mut sink = Vtu::open(&path, &bodies(), Precision::F32, Begin::New).unwrap();
    write(&mut sink, 0..3);
    fs::remove_file(folder.path().join("vtu/a_b_000001.vtu")).unwrap();
    let error = sink.rewind(2, &sink.mark()).unwrap_err().to_string();
    assert!(error.contains("holds 3 files of frames before 2 and 4 are needed"), "{error}");
    assert!(folder.path().join("vtu/a_b_000002.vtu").exists(), "a refusal removes nothing");
}

#[test]
fn a_new_run_removes_the_files_of_an_earlier_one_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.pvd");
    let mut long = Box::new(Vtu::open(&path, &bodies(), Precision::F32, Begin::New).unwrap());
    write(&mut long, 0..3);
    long.finish().unwrap();
    let others = ["a_b_1.vtu", "a_b_000001.txt", "c_000001.vtu", "a_b_+00001.vtu"];
    for other in others {
        fs::write(folder.path().join("vtu").join(other), "mine").unwrap();
    }
    let mut short = Box::new(Vtu::open(&path, &bodies(), Precision::F32, Begin::New).unwrap());
    let refused = Vtu::open(&path, &bodies(), Precision::F32, Begin::New).err().unwrap().to_string();
    assert!(refused.contains("another run is writing here"), "{refused}");
    assert!(folder.path().join("vtu/a_b_000002.vtu").exists(), "gone before the first frame");
    write(&mut short, 0..1);
    short.finish().unwrap();
    let mut left: Vec<String> = files(&folder.path().join("vtu")).into_keys().collect();
    left.retain(|name| !others.contains(&name.as_str()));
    assert_eq!(left, ["a_b_000000.vtu", "a_b_2_000000.vtu"]);
    Vtu::remove(&path).unwrap();
    let left: Vec<String> = files(folder.path()).into_keys().collect();
    assert_eq!(left, ["a_b_+00001.vtu", "a_b_000001.txt", "a_b_1.vtu", "c_000001.vtu"]);
}

/// The two halves of a GLB file, their frame checked.
fn glb(bytes: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let text = word(12);
    assert_eq!((&bytes[16..20], text % 4), (&b"JSON"[..], 0));
    let binary = 20 + text;
    assert_eq!((word(binary), &bytes[binary + 4..binary + 8]), (bytes.len() - binary - 8, &b"BIN\0"[..]));
    let json: Value = serde_json::from_slice(&bytes[20..binary]).unwrap();
    assert_eq!(json["buffers"][0]["byteLength"], word(binary));
    (json, &bytes[binary + 8..])
}

/// The bytes of an accessor, of which `width` numbers make an element.
fn accessor<'a>(json: &Value, binary: &'a [u8], index: &Value, width: usize) -> &'a [u8] {
    let accessor = &json["accessors"][index.as_u64().unwrap() as usize];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let (start, length) = (number(&view["byteOffset"]), number(&view["byteLength"]));
    assert_eq!((start % 4, length), (0, 4 * width * number(&accessor["count"])));
    &binary[start..start + length]
}

/// Writes one body and reads it back: JSON, first primitive's indices, and the attributes by name.
fn round_trip(body: GlbBody) -> (Value, Vec<u32>, BTreeMap<String, Vec<f32>>) {
    let folder = tempfile::tempdir().unwrap();
    let path = write_glb(&folder.path().join("s.glb"), &[body]).unwrap();
    let bytes = fs::read(path).unwrap();
    let (json, binary) = glb(&bytes);
    let primitive = &json["meshes"][0]["primitives"][0];
    let width = |name: &str| match name {
        "TEXCOORD_0" => 2,
        "_VERTEX" => 1,
        _ => 3,
    };
    let attributes = primitive["attributes"].as_object().unwrap();
    let attributes = attributes
        .iter()
        .map(|(name, index)| (name.clone(), f32s(accessor(&json, binary, index, width(name)))))
        .collect();
    let indices = u32s(accessor(&json, binary, &primitive["indices"], 1));
    (json.clone(), indices, attributes)
}

/// A strip of two quads: vertices 0 to 2 at y = 0, 3 to 5 at y = 1.
fn strip(uvs: &str, faces: &str) -> Surface {
    let text = format!("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n{uvs}{faces}");
    parse_mesh(text.as_bytes(), MeshFormat::Obj, &MeshOptions::default()).unwrap()
}

fn places(surface: &Surface) -> Vec<[f32; 3]> {
    surface.vertices.iter().map(|place| place.map(|x| x as f32)).collect()
}

#[test]
fn glb_has_a_named_mesh_with_the_extent_of_its_positions() {
    let surface = strip("", "f 1 2 5 4\nf 2 3 6 5\n");
    let places: Vec<[f32; 3]> = places(&surface).iter().map(|[x, y, _]| [x + 0.1, *y, -0.3]).collect();
    let normals = [[0.0, 0.0, 1.0], [0.0; 3], [f32::NAN; 3], [0.6, 0.0, 0.8], [1.0, 0.0, 0.0], [0.5; 3]];
    let body =
        GlbBody { name: "a \"b\"", surface: &surface, positions: Positions::F32(&places), normals: &normals };
    let (json, indices, attributes) = round_trip(body);
    assert_eq!((&json["nodes"][0]["name"], &json["nodes"][0]["mesh"]), (&"a \"b\"".into(), &0.into()));
    assert_eq!((&json["scenes"][0]["name"], &json["asset"]["version"]), (&"Scene".into(), &"2.0".into()));
    assert_eq!(json["materials"][0]["doubleSided"], true);
    assert_eq!(attributes["POSITION"], places.as_flattened());
    let corner = &json["accessors"][0];
    let of = |key: &str| -> Vec<f64> {
        corner[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    assert_eq!(of("min"), [0.1_f32, 0.0, -0.3].map(f64::from));
    assert_eq!(of("max"), [2.1_f32, 1.0, -0.3].map(f64::from));
    let up = [0.0, 1.0, 0.0];
    let expected = [normals[0], up, up, normals[3], normals[4], up];
    assert_eq!(attributes["NORMAL"], expected.as_flattened(), "only unit vectors are normals");
    assert_eq!(indices.len(), 4 * 3);
    assert!(!attributes.contains_key("_VERTEX"));
}

#[test]
fn glb_copies_vertices_at_a_seam_after_all_others() {
    // Vertex 4 has two places in the texture. Vertex 1 has one by two indices, which is no seam.
    let uvs = "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.5 0\nvt 1 0\nvt 1 1\nvt 0.75 1\n";
    let surface = strip(uvs, "f 1/1 2/2 5/3 4/4\nf 2/5 3/6 6/7 5/8\n");
    let places = places(&surface);
    let body = GlbBody { name: "s", surface: &surface, positions: Positions::F32(&places), normals: &[] };
    let (_, indices, attributes) = round_trip(body);
    assert_eq!(attributes["_VERTEX"], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 4.0]);
    let copied = [&places[..], &[places[4]]].concat();
    assert_eq!(attributes["POSITION"], copied.as_flattened());
    let v_down = [[0.0, 1.0], [0.5, 1.0], [1.0, 1.0], [0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.75, 0.0]];
    assert_eq!(attributes["TEXCOORD_0"], v_down.as_flattened());
    let (left, right) = indices.split_at(6);
    assert!(left.iter().all(|index| [0, 1, 3, 4].contains(index)), "{left:?}");
    assert!(right.iter().all(|index| [1, 2, 5, 6].contains(index)), "{right:?}");
}

#[test]
fn glb_cuts_faces_as_the_simulation_does_and_turns_them_alike() {
    // A U, and a square below it that looks the other way in the file.
    let text = "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 3 -1 0\nv 0 -1 0\n\
                f 1 2 3 4 5 6 7 8\nf 1 2 9 10\n";
    let surface = parse_mesh(text.as_bytes(), MeshFormat::Obj, &MeshOptions::default()).unwrap();
    let places = places(&surface);
    let body = GlbBody { name: "u", surface: &surface, positions: Positions::F32(&places), normals: &[] };
    let (_, indices, _) = round_trip(body);
    let turned = |[a, b, c]: [u32; 3]| match a.min(b).min(c) {
        first if first == a => [a, b, c],
        first if first == b => [b, c, a],
        _ => [c, a, b],
    };
    let mut written: Vec<_> = indices.as_chunks().0.iter().copied().map(turned).collect();
    let mut simulated: Vec<_> = surface.triangles.iter().copied().map(turned).collect();
    written.sort_unstable();
    simulated.sort_unstable();
    assert_eq!(written, simulated);
    assert_eq!(written.len(), 6 + 2);
}

#[test]
fn glb_has_faces_that_are_not_simulated_and_welded_vertices() {
    // Two triangles with their own corners at the same places, one of them twice, and a face without area.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 2 2\nv 2 2 2\n\
                f 1 2 3\nf 4 5 6\nf 4 5 6\nf 7 8 1\n";
    let surface = parse_mesh(text.as_bytes(), MeshFormat::Obj, &MeshOptions::default()).unwrap();
    assert_eq!((surface.triangles.len(), surface.nodes.len()), (2, 4));
    let places = places(&surface);
    let body = GlbBody { name: "w", surface: &surface, positions: Positions::F32(&places), normals: &[] };
    let (_, indices, attributes) = round_trip(body);
    assert_eq!(indices, [0, 1, 2, 3, 4, 5, 3, 4, 5]);
    assert_eq!(attributes["POSITION"].len(), 3 * 8);
}

#[test]
fn glb_has_chains_as_lines_and_a_lone_node_as_a_point() {
    let folder = tempfile::tempdir().unwrap();
    let (_, chain) = bodies().remove(1);
    let lone = Surface { vertices: vec![[0.0; 3]], ..Surface::default() };
    let body = |name, surface, positions| GlbBody { name, surface, positions, normals: &[] };
    let three = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0 / 3.0, 0.0, 0.0]];
    let all =
        [body("chain", &chain, Positions::F64(&three)), body("lone", &lone, Positions::F32(&[[7.0; 3]]))];
    let bytes = fs::read(write_glb(&folder.path().join("s.glb"), &all).unwrap()).unwrap();
    let (json, binary) = glb(&bytes);
    let [line, point] = [0, 1].map(|mesh| &json["meshes"][mesh]["primitives"][0]);
    assert_eq!((&line["mode"], &point["mode"]), (&1.into(), &0.into()));
    assert_eq!(u32s(accessor(&json, binary, &line["indices"], 1)), [0, 1, 1, 2]);
    let places = f32s(accessor(&json, binary, &line["attributes"]["POSITION"], 3));
    assert_eq!(places, three.as_flattened().iter().map(|x| *x as f32).collect::<Vec<_>>());
    assert_eq!(f32s(accessor(&json, binary, &point["attributes"]["POSITION"], 3)), [7.0; 3]);
    assert!(point["indices"].is_null());
    assert_eq!(json["scenes"][0]["nodes"], serde_json::json!([0, 1]));
}

#[test]
fn glb_refuses_what_json_cannot_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.glb");
    let surface = strip("", "f 1 2 5 4\nf 2 3 6 5\n");
    let mut bad = places(&surface);
    bad[4][1] = f32::NAN;
    let refusal = |positions, normals| {
        let body = GlbBody { name: "flag", surface: &surface, positions, normals };
        write_glb(&path, &[body]).unwrap_err().to_string()
    };
    let error = refusal(Positions::F32(&bad), &[]);
    assert!(error.contains("s.glb: flag: vertex 4 is at [1.0, NaN, 0.0]"), "{error}");
    let error = refusal(Positions::F64(&[[1e300, 0.0, 0.0]; 6]), &[]);
    assert!(error.contains("vertex 0 is at [inf, 0.0, 0.0]"), "{error}");
    let error = refusal(Positions::F32(&bad[1..]), &[]);
    assert!(error.contains("5 positions and 0 normals for 6 vertices"), "{error}");
    let error = refusal(Positions::F32(&bad), &[[0.0, 1.0, 0.0]]);
    assert!(error.contains("6 positions and 1 normals"), "{error}");
    assert!(write_glb(&path, &[]).unwrap_err().to_string().contains("no bodies"));
    assert!(!path.exists());
}
