//! Files that are not what their name says, and words that should not reach a terminal.

use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};

const ALL: [MeshFormat; 5] =
    [MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Stl, MeshFormat::Off, MeshFormat::Gltf];

fn refusal(bytes: &[u8], format: MeshFormat) -> String {
    parse_mesh(bytes, format, &MeshOptions::default()).unwrap_err().to_string()
}

#[test]
fn nothing_at_all_is_refused_alike() {
    assert!(ALL.into_iter().all(|format| refusal(b"", format) == "no triangles: the file is empty"));
}

#[test]
fn archives_pictures_and_wide_text_are_named_under_any_ending() {
    let wide: Vec<u8> = "\u{FEFF}v 0 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (bytes, what) in [
        (&b"\x1F\x8B\x08\0\0\0\0\0"[..], "is compressed with gzip; unpack it first"),
        (b"PK\x03\x04\x14\0", "is a ZIP archive; unpack it first"),
        (b"\x89PNG\r\n\x1A\n\0\0", "is a picture (PNG), not a mesh"),
        (&wide, "is a text in UTF-16; save it as UTF-8"),
    ] {
        assert!(ALL.into_iter().all(|format| refusal(bytes, format) == what), "{what}");
    }
}

#[test]
fn a_mesh_with_the_ending_of_another_format_is_told_its_own() {
    let begins = |ending| format!("begins as a {ending} file does; if it is one, give its name that ending");
    let ply = b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n";
    assert_eq!(refusal(ply, MeshFormat::Obj), begins(".ply"));
    assert_eq!(refusal(ply, MeshFormat::Stl), begins(".ply"));
    assert_eq!(refusal(b"OFF\n3 1 0\n", MeshFormat::Ply), begins(".off"));
    assert_eq!(refusal(b"solid x\nendsolid x\n", MeshFormat::Obj), begins(".stl"));
    assert_eq!(refusal(b"glTF\x02\0\0\0", MeshFormat::Obj), begins(".glb"));
    assert_eq!(refusal(b"solid x\nendsolid x\n", MeshFormat::Stl), "no triangles: the mesh has no faces");
}

#[test]
fn a_binary_stl_may_begin_with_anything() {
    let mut bytes = b"\x1F\x8B".to_vec();
    bytes.resize(80, 0);
    bytes.extend(1_u32.to_le_bytes());
    let triangle = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32];
    bytes.extend(triangle.iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend([0, 0]);
    let surface = parse_mesh(&bytes, MeshFormat::Stl, &MeshOptions::default()).unwrap();
    assert_eq!(surface.triangles.len(), 1);
}

#[test]
fn control_characters_of_a_file_do_not_reach_the_terminal() {
    let files: [(&[u8], MeshFormat); 4] = [
        (b"v \x1B[31m 0 0\n", MeshFormat::Obj),
        (b"OFF\n\x1B[31m 4 4\n", MeshFormat::Off),
        (b"ply\nformat ascii 1.0\nelement \x1B[31m 5\nproperty int a\nend_header\n", MeshFormat::Ply),
        (br#"{"asset": {"version": "2.0"}, "extensionsRequired": ["\u001b[31m"]}"#, MeshFormat::Gltf),
    ];
    for (bytes, format) in files {
        let error = refusal(bytes, format);
        assert!(error.contains(r"\u001b[31m") && !error.contains('\x1B'), "{error:?}");
    }
}
