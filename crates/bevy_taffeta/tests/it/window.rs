//! The program in a real window, on a display that nobody sees.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// A display.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Starts a server that says which display it has.
    fn start() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1400x900x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| panic!("Xvfb: {error}; `apt-get install xvfb` would do"));
        let mut number = String::new();
        let out = server.stdout.take().expect("its output is taken once");
        BufReader::new(out).read_line(&mut number).expect("Xvfb says its display");
        Self { server, name: format!(":{}", number.trim()) }
    }

    fn view(&self, arguments: &[&str]) -> Output {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        Command::new(env!("CARGO_BIN_EXE_taffeta-view"))
            .args(arguments)
            .current_dir(scenes)
            .env("DISPLAY", &self.name)
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .expect("the program starts")
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Width, height and RGB of a picture.
fn picture(path: &Path) -> (u32, u32, Vec<[u8; 3]>) {
    let file = BufReader::new(std::fs::File::open(path).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width, info.height, bytes.as_chunks().0.to_vec())
}

#[test]
fn a_window_opens_on_a_scene_shows_panels_and_bodies_and_closes() {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window.png");
    let display = Display::start();
    // A window runs its scene by the clock: a scene that is slower than that would be computed more than drawn.
    let arguments = ["flag.toml", "--size", "1000x640", "--exit-after", "12", "--window-picture"];
    let output = display.view(&[&arguments[..], &[&path.display().to_string()]].concat());
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{words}");
    let (width, height, pixels) = picture(&path);
    assert_eq!((width, height), (1000, 640));
    // Panels are pale at the right and below, the cloth is red at the left.
    let at = |x: u32, y: u32| pixels[(y * width + x) as usize];
    let pale = |[r, g, b]: [u8; 3]| r > 200 && g > 200 && b > 200;
    let right = (60..height).filter(|&y| pale(at(width - 12, y))).count();
    assert!(right > 400, "{right} pale pixels of a panel");
    let red = pixels.iter().filter(|[r, g, b]| *r > 90 && r / 2 > *g && r / 2 > *b).count();
    assert!(red > 3000, "{red} red pixels of cloth");
}

#[test]
fn where_there_is_no_display_that_is_said() {
    let output = Command::new(env!("CARGO_BIN_EXE_taffeta-view"))
        .args([concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/drape.toml"), "--exit-after", "2"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the program starts");
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words}");
    assert!(words.contains("no window can be opened") && words.contains("--picture"), "{words}");
    assert!(!words.contains("panicked"), "{words}");
}
