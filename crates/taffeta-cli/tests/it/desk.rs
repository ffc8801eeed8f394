//! What the tests of the program share: a folder, a scene in it, and the program.

use assert_cmd::Command;
use std::path::PathBuf;
use tempfile::TempDir;

/// A folder of its own with `scene.toml` in it.
pub struct Desk {
    dir: TempDir,
}

/// A small sheet held at two corners.
pub const SHEET: &str = r#"
title = "Small sheet"
[time]
dt = 0.01
max_step = 0.002
frames = 4
[[body]]
name = "sheet"
node_mass = 0.01
mesh.grid = { rows = 5, cols = 7, size = [0.6, 0.4] }
[body.springs]
structural = { k = 100.0, d = 0.05 }
shear = { k = 50.0, d = 0.05 }
[[body.pin]]
select = { nodes = [0, 6] }
"#;

/// A soft ball that falls onto the floor.
pub const BALL: &str = r#"
title = "Ball"
[time]
max_step = 0.001
frames = 12
[[body]]
name = "ball"
kind = "soft"
mass = 1.0
mesh.icosphere = { radius = 0.2, subdivisions = 2 }
place.position = [0.0, 0.25, 0.0]
springs.structural = { k = 200.0, d = 0.1 }
[[collider]]
plane = {}
"#;

impl Desk {
    /// A folder with `scene` in it.
    pub fn with(scene: &str) -> Self {
        let desk = Self { dir: TempDir::new().expect("a temporary folder") };
        std::fs::write(desk.path("scene.toml"), scene).expect("the scene is written");
        desk
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// The program, in the folder.
    pub fn taffeta(&self, words: &[&str]) -> Command {
        let mut command = assert_cmd::cargo::cargo_bin_cmd!("taffeta");
        command.current_dir(self.dir.path()).args(words);
        command
    }

    /// Names of the files in a folder, sorted.
    pub fn files(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).expect("the folder is there");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// A JSON file in the folder.
    pub fn json(&self, name: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(self.path(name)).expect("the file is there");
        serde_json::from_str(&text).expect("it is JSON")
    }

    /// Header of a npy file, as text, and the number of bytes after it.
    pub fn npy(&self, name: &str) -> (String, usize) {
        let bytes = std::fs::read(self.path(name)).expect("the file is there");
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = String::from_utf8_lossy(&bytes[10..10 + length]).into_owned();
        (header, bytes.len() - 10 - length)
    }
}

/// Standard output, standard error and the exit code.
pub fn ending(mut command: Command) -> (String, String, Option<i32>) {
    let output = command.output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr), output.status.code())
}
