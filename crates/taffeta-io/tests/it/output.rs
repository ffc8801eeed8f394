//! Outputs, byte by byte or read back.

use std::fs;
use taffeta::Precision;
use taffeta::diagnostics::{FrameReport, PinReaction, SolverReport};
use taffeta::topology::{Polygons, Surface, Uvs};
use taffeta_io::output::{Begin, FrameSink, FrameTable, Npy, Pc2, Positions, Usd, write_obj, write_ply};
use taffeta_io::{MeshOptions, load_mesh};

const FRAMES: [[[f32; 3]; 3]; 2] = [
    [[0.5, 1.0, -2.0], [3.0, 4.0, 5.0], [6.0, 7.0, 8.25]],
    [[9.0, 0.1, 1e-9], [2.0, 3.0, 4.0], [5.0, 6.0, 7.0]],
];

fn write_all(mut sink: Box<dyn FrameSink>) -> Vec<u8> {
    for (frame, positions) in FRAMES.iter().enumerate() {
        sink.frame(frame as f64 / 60.0, &Positions::F32(positions)).unwrap();
    }
    fs::read(&sink.finish().unwrap()[0]).unwrap()
}

fn bytes_of(numbers: impl IntoIterator<Item = f32>) -> Vec<u8> {
    numbers.into_iter().flat_map(f32::to_le_bytes).collect()
}

#[test]
fn npy_holds_the_true_count_and_the_bits() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("positions.npy");
    let bytes = write_all(Box::new(Npy::open(&path, 3, Precision::F32, Begin::New).unwrap()));
    assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
    let header = std::str::from_utf8(&bytes[10..128]).unwrap();
    assert!(
        header.starts_with("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 3), }  "),
        "{header}"
    );
    assert!(header.ends_with(" \n"));
    assert_eq!(bytes[128..], bytes_of(FRAMES.into_iter().flatten().flatten()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a part is left");
}

#[test]
fn npy_in_64_bits_and_what_does_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.npy");
    let mut sink = Box::new(Npy::open(&path, 1, Precision::F64, Begin::New).unwrap());
    sink.frame(0.0, &Positions::F64(&[[0.1, 0.2, 0.3]])).unwrap();
    sink.frame(0.0, &Positions::F32(&[[0.5; 3]])).unwrap();
    let error = sink.frame(0.0, &Positions::F64(&[[0.0; 3]; 2])).unwrap_err().to_string();
    assert!(error.contains("p.npy: 2 vertices instead of 1"), "{error}");
    assert!(!path.exists(), "a file under way has its final name");
    let bytes = fs::read(&sink.finish().unwrap()[0]).unwrap();
    assert_eq!(bytes[128..], [0.1_f64, 0.2, 0.3, 0.5, 0.5, 0.5].map(f64::to_le_bytes).concat());
    let nowhere = Npy::open(&folder.path().join("none/p.npy"), 1, Precision::F32, Begin::New)
        .err()
        .unwrap()
        .to_string();
    assert!(nowhere.contains("none/p.npy.part"), "{nowhere}");
}

#[test]
fn pc2_holds_one_body() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = write_all(Box::new(Pc2::open(&folder.path().join("b.pc2"), 1..3, Begin::New).unwrap()));
    let mut expected = b"POINTCACHE2\0".to_vec();
    expected.extend([1_i32, 2].map(i32::to_le_bytes).concat());
    expected.extend([0_f32, 1.0].map(f32::to_le_bytes).concat());
    expected.extend(2_i32.to_le_bytes());
    expected.extend(bytes_of(FRAMES.iter().flat_map(|frame| frame[1..].iter().flatten().copied())));
    assert_eq!(bytes, expected);
    let mut beyond = Pc2::open(&folder.path().join("c.pc2"), 2..4, Begin::New).unwrap();
    assert!(beyond.frame(0.0, &Positions::F32(&FRAMES[0])).is_err());
}

fn triangle() -> Surface {
    let mut polygons = Polygons::default();
    polygons.push(&[0, 1, 2]);
    Surface {
        vertices: FRAMES[0].map(|p| p.map(f64::from)).to_vec(),
        polygons,
        uvs: Some(Uvs { coords: vec![[0.0, 0.25], [1.0, 0.5]], corners: vec![1, 0, 1] }),
        ..Surface::default()
    }
}

#[test]
fn usd_has_a_prim_for_each_body() {
    let folder = tempfile::tempdir().unwrap();
    let chain = Surface { vertices: vec![[0.0; 3]; 2], links: vec![[0, 1]], ..Surface::default() };
    let bodies = [("my flag".to_owned(), triangle()), ("my-flag".to_owned(), chain)];
    let mut usd = Box::new(Usd::open(&folder.path().join("scene.usda"), 0.04, &bodies, Begin::New).unwrap());
    for frame in FRAMES {
        let all: Vec<[f32; 3]> = frame.into_iter().chain([[0.0; 3], [1.0, -1.0, 0.0]]).collect();
        usd.frame(0.0, &Positions::F32(&all)).unwrap();
    }
    assert!(usd.frame(0.0, &Positions::F32(&FRAMES[0])).is_err());
    let text = fs::read_to_string(&usd.finish().unwrap()[0]).unwrap();
    for expected in [
        "#usda 1.0\n",
        "endTimeCode = 1 ",
        "timeCodesPerSecond = 25\n",
        "def Mesh \"my_flag\"",
        "def BasisCurves \"my_flag_2\"",
        "int[] faceVertexCounts = [3]",
        "int[] faceVertexIndices = [0, 1, 2]",
        "int[] primvars:st:indices = [1, 0, 1]",
        "0: [(0.5, 1, -2), (3, 4, 5), (6, 7, 8.25)],",
        "1: [(2, 0.1, 0.000000001), (9, 6, 7)],",
        "int[] curveVertexCounts = [2]",
        "1: [(0, 0, 0), (1, -1, 0)],",
    ] {
        assert!(text.contains(expected), "{expected} is not in:\n{text}");
    }
    assert_eq!(text.matches('{').count(), text.matches('}').count());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a part is left");
}

#[test]
fn poses_read_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let places = [[0.1, 0.0, 0.0], [1.0, 0.0, 1.0 / 3.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut polygons = Polygons::default();
    polygons.push(&[0, 1, 2, 3]);
    let seamless = Some(Uvs { coords: vec![[0.0, 0.5], [1.0, 0.5]], corners: vec![0, 1, 1, 0] });
    let surface = Surface { vertices: places.to_vec(), polygons, uvs: seamless, ..Surface::default() };
    let normals = [[0.0, 0.0, 1.0]; 4];
    let write = [write_ply, write_obj];
    for (name, write) in ["a.ply", "a.obj"].into_iter().zip(write) {
        let path = write(&folder.path().join(name), &surface, &Positions::F64(&places), &normals).unwrap();
        let back = load_mesh(&path, &MeshOptions::default()).unwrap();
        assert_eq!((&back.vertices[..], &back.polygons), (&places[..], &surface.polygons));
        let uvs = back.uvs.unwrap();
        let of_corners: Vec<[f32; 2]> = uvs.corners.iter().map(|&i| uvs.coords[i as usize]).collect();
        assert_eq!(of_corners, [[0.0, 0.5], [1.0, 0.5], [1.0, 0.5], [0.0, 0.5]]);
        assert!(write(&path, &surface, &Positions::F64(&places[1..]), &[]).is_err());
    }
}

#[test]
fn a_seam_is_kept_at_the_corners_of_a_ply() {
    let folder = tempfile::tempdir().unwrap();
    let mut surface = triangle();
    surface.polygons.push(&[0, 1, 2]);
    surface.uvs = Some(Uvs { coords: vec![[0.0, 0.25], [1.0, 0.5]], corners: vec![0, 0, 0, 1, 1, 1] });
    let path = write_ply(&folder.path().join("s.ply"), &surface, &Positions::F32(&FRAMES[0]), &[]).unwrap();
    let bytes = fs::read(&path).unwrap();
    let tail: Vec<u8> = [3_u32, 0, 1, 2, 6].map(u32::to_le_bytes).concat();
    let tail = [tail, bytes_of([1.0, 0.5, 1.0, 0.5, 1.0, 0.5])].concat();
    assert!(bytes.ends_with(&tail));
    assert_eq!(load_mesh(&path, &MeshOptions::default()).unwrap().polygons, surface.polygons);
}

#[test]
fn the_table_has_a_row_a_frame_at_any_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.csv");
    let bodies = [("cloth".to_owned(), false, 2), ("a,b".to_owned(), true, 0)];
    let mut table = FrameTable::open(&path, &bodies, Begin::New).unwrap();
    let report = FrameReport {
        frame: 1,
        time: 0.5,
        kinetic: 1.0,
        gravitational: 2.0,
        springs: 0.25,
        momentum: [0.0, -1.0, 0.0],
        angular_momentum: [2.0, 0.0, -0.5],
        max_stretch: 1.1,
        contacts: 7,
        pairs: 3,
        nearest_pair: Some(0.75),
        pair_searches: 2,
        solver: SolverReport { iterations: 12, residual: 0.0625, active_fraction: 0.5, capped: 1 },
        volumes: vec![None, Some(4.5)],
        broken: 5,
        substeps: 34,
        asleep: 2,
        reactions: vec![
            PinReaction { body: 0, pin: 0, force: Some([0.5, 9.0, 0.0]) },
            PinReaction { body: 0, pin: 1, force: None },
        ],
        ..FrameReport::default()
    };
    table.row(&report, Some(6), 1.5).unwrap();
    let expected = "frame,time,kinetic,gravitational,springs,hinges,membranes,bends,energy,px,py,pz,lx,ly,lz,max_stretch,warp_min,\
                    warp_max,weft_min,weft_max,shear,contacts,pairs,nearest_pair,pair_searches,intersections,iterations,residual,active_fraction,broken,substeps,asleep,\"volume_a,b\",\
                    reaction_cloth_0_x,reaction_cloth_0_y,reaction_cloth_0_z,reaction_cloth_1_x,reaction_cloth_1_y,\
                    reaction_cloth_1_z,ms\n\
                    1,0.5,1,2,0.25,0,0,0,3.25,0,-1,0,2,0,-0.5,1.1,,,,,,7,3,0.75,2,6,12,0.0625,0.5,5,34,2,4.5,0.5,9,0,,,,1.5\n";
    assert_eq!(fs::read_to_string(folder.path().join("frames.csv.part")).unwrap(), expected);
    assert_eq!(fs::read_to_string(table.finish().unwrap()).unwrap(), expected);
}
