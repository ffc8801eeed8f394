//! Films and pictures by `taffeta-view`, without a window: held to physics, and to pictures that were looked at.
//!
//! `TAFFETA_NEW_PICTURES=1 cargo test --release -p bevy_taffeta --test it record` makes those again.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A picture: its width, height and rows of red, green and blue.
#[derive(PartialEq)]
struct Picture {
    size: [usize; 2],
    rgb: Vec<u8>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
        let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut rgb).expect("a whole PNG");
        Self { size: [info.width as usize, info.height as usize], rgb }
    }

    /// Mean column and row of what is red.
    fn middle_of_red(&self) -> [f64; 2] {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (index, pixel) in self.rgb.chunks_exact(3).enumerate() {
            if pixel[0] > pixel[2].saturating_add(40) {
                sum[0] += (index % self.size[0]) as f64 + 0.5;
                sum[1] += (index / self.size[0]) as f64 + 0.5;
                count += 1.0;
            }
        }
        assert!(count > 20.0, "{count} red pixels");
        sum.map(|x| x / count)
    }

    /// Mean difference of shades, and the share of pixels that are another colour.
    fn difference(&self, other: &Self) -> [f64; 2] {
        assert_eq!(self.size, other.size);
        let shades = self.rgb.iter().zip(&other.rgb).map(|(a, b)| f64::from(a.abs_diff(*b)));
        let apart = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 20);
        let other = self.rgb.chunks_exact(3).zip(other.rgb.chunks_exact(3)).filter(apart).count();
        let pixels = (self.size[0] * self.size[1]) as f64;
        [shades.sum::<f64>() / (3.0 * pixels), other as f64 / pixels]
    }
}

/// A folder that is removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("taffeta-view-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left behind in the temporary folder does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn view(scene: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taffeta-view"));
    command.arg(scene).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).with_extension("toml")
}

/// Runs to a good end.
fn well(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", said(&output));
    said(&output)
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).concat()
}

fn frame(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("frame_{number:04}.png"))
}

fn count(folder: &Path) -> usize {
    let count = fs::read_dir(folder).expect("a folder").count();
    assert!((0..count).all(|number| frame(folder, number).is_file()), "numbers from 0 on, and nothing else");
    count
}

#[test]
fn a_film_has_as_many_pictures_as_are_asked_for_and_takes_the_place_of_an_earlier_one() {
    let folder = Folder::new("count");
    let film = folder.path().join("film");
    let record = |frames: &str| {
        let mut command = view(&scene("drape"));
        well(command.args(["--size", "80x60", "--frames", frames, "--backend", "cpu", "--record"]).arg(&film))
    };
    assert!(record("12").contains("12 pictures"));
    assert_eq!(count(&film), 12);
    let [first, last] = [0, 11].map(|number| Picture::read(&frame(&film, number)));
    assert_eq!(first.size, [80, 60]);
    assert!(first.difference(&last)[1] > 0.02, "a cloth that falls is elsewhere");
    record("3");
    assert_eq!(count(&film), 3);
    assert!(first == Picture::read(&frame(&film, 0)), "a film starts with the start");
}

/// A ball that falls freely.
const FALL: &str = r#"
[time]
max_step = 0.001
[[body]]
name = "ball"
node_mass = 0.01
mesh.icosphere = { radius = 0.25, subdivisions = 2 }
[body.springs]
structural = { k = 10.0, d = 0.01 }
"#;

#[test]
fn what_falls_is_seen_where_gravity_takes_it_on_the_cpu_and_on_bevys_device() {
    let folder = Folder::new("falls");
    let file = folder.path().join("fall.toml");
    fs::write(&file, FALL).expect("a file");
    // From 6 m a metre is 1 / (6 tan 0.3) of half the height.
    let (pixels, distance) = (240.0, 6.0);
    let by_metre = 0.5 * pixels / (distance * 0.3_f64.tan());
    let camera = ["--size", "320x240", "--eye", "0,-0.4,6", "--at", "0,-0.4,0"];
    for backend in ["cpu", "gpu"] {
        let film = folder.path().join(backend);
        let mut command = view(&file);
        command.args(camera).args(["--frames", "25", "--backend", backend, "--record"]).arg(&film);
        well(&mut command);
        let start = Picture::read(&frame(&film, 0)).middle_of_red();
        assert!((start[1] - (0.5 * pixels - 0.4 * by_metre)).abs() < 0.7, "{backend}: {start:?}");
        for number in [12, 24] {
            let time = number as f64 / 60.0;
            let now = Picture::read(&frame(&film, number)).middle_of_red();
            let fallen = 0.5 * 9.81 * time * time * by_metre;
            assert!((now[0] - start[0]).abs() < 0.3, "{backend}: {now:?}");
            assert!((now[1] - start[1] - fallen).abs() < 0.7, "{backend}: {now:?}, {fallen} pixels further");
        }
    }
    let one = folder.path().join("one.png");
    let mut command = view(&file);
    well(command.args(camera).args(["--at-frame", "24", "--backend", "cpu", "--picture"]).arg(&one));
    assert!(Picture::read(&one) == Picture::read(&frame(&folder.path().join("cpu"), 24)));
}

/// Ends at the door, before anything is simulated, and says why.
fn refused(command: &mut Command, words: &[&str]) {
    let output = command.output().expect("it starts");
    let said = said(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(words.iter().all(|word| said.contains(word)), "{said}, not {words:?}");
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn what_cannot_be_is_named_at_the_door() {
    let folder = Folder::new("door");
    let (broken, film) = (folder.path().join("broken.toml"), folder.path().join("film"));
    fs::write(&broken, FALL.replace("node_mass = 0.01", "node_mass = -1.0")).expect("a file");
    refused(view(&broken).arg("--record").arg(&film), &["broken.toml:6", "node_mass", "-1"]);
    refused(view(&folder.path().join("none.toml")).arg("--record").arg(&film), &["none.toml"]);
    assert!(!film.exists());
    refused(view(&scene("drape")).arg("--record").arg(broken.join("film")), &["broken.toml", "written"]);
    let nowhere = folder.path().join("nowhere/film.mp4");
    refused(view(&scene("drape")).arg("--record").arg(&nowhere), &["nowhere", "written"]);
    refused(view(&scene("drape")).args(["--record", "film.avi"]), &["film.avi", ".mp4"]);
    refused(view(&scene("drape")).args(["--picture", "picture.gif"]), &["picture.gif", ".png"]);
    refused(view(&scene("drape")).args(["--record", "film", "--size", "0x9"]), &["1280x720"]);
}

#[test]
fn a_film_that_diverges_says_so_and_keeps_what_was_good() {
    let folder = Folder::new("diverges");
    let (file, film) = (folder.path().join("tin.toml"), folder.path().join("film"));
    let stiff = FALL.replace("k = 10.0", "k = 3000.0").replace("0.001", "0.01");
    let floor = "[[collider]]\nplane = { point = [0.0, -0.4, 0.0] }\n";
    fs::write(&file, stiff + floor).expect("a file");
    let mut command = view(&file);
    let output =
        command.args(["--size", "80x60", "--frames", "90", "--backend", "cpu", "--record"]).arg(&film);
    let output = output.output().expect("it starts");
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("body `ball`") && said.contains("max_step"), "{said}");
    let kept = count(&film);
    // Frame n went wrong: 0 to n − 1 are there.
    assert!(kept > 1 && said.contains(&format!("error: frame {kept}: ")), "{kept}: {said}");
    assert!(said.contains(&format!("{kept} pictures")), "{said}");
    Picture::read(&frame(&film, kept - 1));
}

#[test]
fn without_ffmpeg_a_film_is_a_folder_and_what_to_install_is_said() {
    let folder = Folder::new("without");
    let film = folder.path().join("film.mp4");
    let mut command = view(&scene("drape"));
    command.args(["--size", "80x60", "--frames", "2", "--record"]).arg(&film).env("PATH", folder.path());
    let said = well(&mut command);
    assert!(said.contains("install ffmpeg"), "{said}");
    assert_eq!(count(&film.with_extension("")), 2);
    assert!(!film.exists());
}

#[test]
fn with_ffmpeg_a_film_is_whole_and_starts_at_once() {
    if Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).status().is_err() {
        println!("skipped: there is no ffmpeg");
        return;
    }
    let folder = Folder::new("with");
    let film = folder.path().join("film.mp4");
    let mut command = view(&scene("drape"));
    // H.264 in this form needs even sides.
    well(command.args(["--size", "81x61", "--frames", "3", "--record"]).arg(&film));
    let bytes = fs::read(&film).expect("a film");
    let place = |word: &[u8]| bytes.windows(word.len()).position(|window| window == word);
    assert_eq!(place(b"ftyp"), Some(4));
    assert!(place(b"avc1").is_some() && place(b"moov") < place(b"mdat"));
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing else is left");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_film_after_a_whole_picture() {
    let folder = Folder::new("ctrl-c");
    let film = folder.path().join("film");
    let mut child = view(&scene("drape"))
        .args(["--size", "80x60", "--backend", "cpu", "--record"])
        .arg(&film)
        .spawn()
        .expect("it starts");
    while !frame(&film, 1).exists() && child.try_wait().expect("a child").is_none() {
        std::thread::yield_now();
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    let kept = count(&film);
    assert!((2..240).contains(&kept), "{kept}");
    (0..kept).for_each(|number| assert_eq!(Picture::read(&frame(&film, number)).size, [80, 60]));
}

/// Largest mean difference of shades, and share of pixels of another colour: drivers round in their own ways at edges.
const ALIKE: [f64; 2] = [1.0, 0.01];

fn alike([shades, other]: [f64; 2]) -> bool {
    shades < ALIKE[0] && other < ALIKE[1]
}

#[test]
fn pictures_of_scenes_are_those_that_were_looked_at() {
    let folder = Folder::new("pictures");
    let shoot = |name: &str, words: &[&str]| {
        let file = folder.path().join("picture.png");
        let mut command = view(&scene(name));
        command.args(["--size", "160x120", "--backend", "cpu"]).args(words).arg("--picture").arg(&file);
        well(&mut command);
        file
    };
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures");
    let near = ["--eye", "0.8,1.05,1.8", "--at", "0,0.2,0"];
    let mut apart = Vec::new();
    for (name, at, camera) in [("drape", "60", &near[..]), ("flag", "60", &[]), ("twist_pins", "30", &[])] {
        let now = shoot(name, &[&["--at-frame", at], camera].concat());
        let kept = kept.join(name).with_extension("png");
        if std::env::var_os("TAFFETA_NEW_PICTURES").is_some() {
            fs::copy(&now, &kept).expect("a place for it");
        }
        let difference = Picture::read(&kept).difference(&Picture::read(&now));
        apart.extend((!alike(difference)).then_some((name, difference)));
    }
    assert!(apart.is_empty(), "mean difference of shades, share of other pixels: {apart:?}");
    // A cloth that is a twentieth of a second behind is seen.
    let behind = Picture::read(&shoot("twist_pins", &["--at-frame", "27"]));
    let difference = Picture::read(&kept.join("twist_pins.png")).difference(&behind);
    assert!(!alike(difference), "{difference:?}");
}
