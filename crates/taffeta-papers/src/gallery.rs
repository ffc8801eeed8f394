//! `taffeta-papers gallery`: the pictures at the top of the README, made by `taffeta-view`.

use crate::{draw, root};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use taffeta_io::program::{self, Failure};

/// A picture of some moments, two in a row; three are in one.
struct Picture {
    name: &'static str,
    shots: &'static [Shot],
    /// Width and height of each shot [pixel].
    size: [usize; 2],
    /// Where the camera is, and what it looks at, as `taffeta-view` takes them.
    eye: &'static str,
    at: &'static str,
}

/// A moment of a scene.
struct Shot {
    scene: &'static str,
    set: Option<&'static str>,
    frame: u32,
}

impl Shot {
    const fn of(scene: &'static str, frame: u32) -> Self {
        Self { scene, set: None, frame }
    }

    const fn with(self, set: &'static str) -> Self {
        Self { set: Some(set), ..self }
    }
}

/// Sizes of a picture, of one of two, of one of three, and of one of four.
const WHOLE: [usize; 2] = [480, 320];
const HALF: [usize; 2] = [240, 320];
const THIRD: [usize; 2] = [320, 240];
const QUARTER: [usize; 2] = [240, 160];

const PICTURES: [Picture; 6] = [
    Picture {
        name: "flag",
        shots: &[
            Shot::of("flag", 230).with("body.flag.material.preset=silk"),
            Shot::of("flag", 230).with("body.flag.material.preset=cotton"),
            Shot::of("flag", 230).with("body.flag.material.preset=denim"),
        ],
        size: THIRD,
        eye: "1.3,1.5,1.9",
        at: "0,1.4,0",
    },
    Picture {
        name: "drape",
        shots: &[Shot::of("drape", 240)],
        size: WHOLE,
        eye: "0.8,1.05,1.8",
        at: "0,0.2,0",
    },
    Picture {
        name: "skirt",
        shots: &[Shot::of("skirt", 240), Shot::of("skirt", 400)],
        size: HALF,
        eye: "1,0.6,3",
        at: "0,0,0",
    },
    Picture {
        name: "press",
        shots: &[
            Shot::of("press_bunny", 80),
            Shot::of("press_bunny", 300).with("body.bunny.volume.form=none"),
            Shot::of("press_bunny", 300).with("body.bunny.volume.form=paper-shader"),
            Shot::of("press_bunny", 300),
        ],
        size: QUARTER,
        eye: "1.2,1.2,4.7",
        at: "-0.05,0.9,0",
    },
    Picture {
        name: "twist",
        shots: &[Shot::of("twist_pins", 0), Shot::of("twist_pins", 60)],
        size: HALF,
        eye: "3.2,2.6,7",
        at: "0,0,0",
    },
    Picture {
        name: "acad",
        shots: &[Shot::of("s1_fig11", 150), Shot::of("s1_fig13", 150)],
        size: HALF,
        eye: "1.9,1.7,4",
        at: "0,0,0",
    },
];

/// Pictures are rendered so many times as wide and high, and brought down.
const FINE: usize = 2;

/// Which pictures, and by which program.
#[derive(clap::Args)]
pub struct Args {
    /// Names of pictures [default: all]
    names: Vec<String>,
    /// The program `taffeta-view` [default: the one in the folder `bevy` beside this program's]
    #[arg(long, value_name = "PATH")]
    view: Option<PathBuf>,
}

/// Makes the named pictures; without names, all.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(name) = args.names.iter().find(|name| !PICTURES.iter().any(|picture| picture.name == **name))
    {
        let known = PICTURES.map(|picture| picture.name).join(", ");
        return Err(Failure::Input(format!("there is no picture {name}; there are {known}")));
    }
    let view = args.view.clone().map_or_else(view, Ok)?;
    if !view.is_file() {
        return Err(Failure::Input(format!(
            "there is no `taffeta-view` at {}: `cargo build --profile quick -p bevy_taffeta --bin taffeta-view` builds it; \
             --view PATH says where another one is",
            view.display()
        )));
    }
    let wanted =
        |picture: &&Picture| args.names.is_empty() || args.names.iter().any(|name| name == picture.name);
    for picture in PICTURES.iter().filter(wanted) {
        let made = picture.make(&view);
        program::say(&made.map_err(|error| Failure::Work(format!("{}: {error}", picture.name)))?)?;
    }
    Ok(())
}

/// The built `taffeta-view`, where cargo puts it.
fn view() -> Result<PathBuf, Failure> {
    let own = std::env::current_exe().map_err(|error| Failure::Work(format!("this program: {error}")))?;
    let name = format!("bevy/taffeta-view{}", std::env::consts::EXE_SUFFIX);
    Ok(own.parent().and_then(Path::parent).unwrap_or(Path::new("..")).join(name))
}

impl Picture {
    /// Makes it; returns what was made.
    fn make(&self, view: &Path) -> Result<String, String> {
        let panels = self.shots.iter().map(|shot| self.shoot(shot, view)).collect::<Result<Vec<_>, _>>()?;
        let [width, height] = self.size;
        let across = if panels.len() == 3 { 3 } else { panels.len().min(2) };
        let rows: Vec<Vec<u8>> = panels.chunks(across).map(|row| draw::beside(row, self.size)).collect();
        let file = root().join("docs/pictures/gallery").join(self.name).with_extension("png");
        let folder = file.parent().map_or(Ok(()), std::fs::create_dir_all);
        folder.map_err(|error| format!("{}: {error}", file.display()))?;
        let bytes = draw::png(&rows.concat(), [width * across, height * rows.len()])
            .map_err(|error| format!("{}: {error}", file.display()))?;
        std::fs::write(&file, &bytes).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(format!("docs/pictures/gallery/{}.png: {} KB", self.name, bytes.len() / 1000))
    }

    /// A moment as rows of red, green and blue.
    fn shoot(&self, shot: &Shot, view: &Path) -> Result<Vec<u8>, String> {
        let file = std::env::temp_dir().join(format!("taffeta-gallery-{}.png", std::process::id()));
        let output =
            self.command(shot, &file, view).output().map_err(|error| format!("taffeta-view: {error}"))?;
        let said = String::from_utf8_lossy(&output.stdout);
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).trim().to_owned());
        }
        if let Some(note) = said.lines().find(|line| line.contains("stand-in")) {
            return Err(format!("{note}; `cargo xtask models` fetches it"));
        }
        let picture = read(&file);
        // What is left behind in the temporary folder does no harm.
        let _ = std::fs::remove_file(&file);
        picture.map(|fine| brought_down(&fine, self.size))
    }

    fn command(&self, shot: &Shot, file: &Path, view: &Path) -> Command {
        let mut command = Command::new(view);
        command.arg(root().join("scenes").join(shot.scene).with_extension("toml")).arg("--picture").arg(file);
        command.args(["--at-frame", &shot.frame.to_string(), "--backend", "cpu"]);
        let [width, height] = self.size.map(|side| FINE * side);
        command.args(["--size", &format!("{width}x{height}"), "--eye", self.eye, "--at", self.at]);
        command.args(shot.set.iter().flat_map(|set| ["--set", set])).stdin(Stdio::null());
        command
    }
}

/// The bytes of a PNG file of red, green and blue.
fn read(file: &Path) -> Result<Vec<u8>, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let opened = File::open(file).map_err(|error| wrong(&error))?;
    let mut reader = png::Decoder::new(BufReader::new(opened)).read_info().map_err(|error| wrong(&error))?;
    let size = reader.output_buffer_size().ok_or_else(|| wrong(&"is too large"))?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|error| wrong(&error))?;
    Ok(bytes)
}

/// A picture by the means of squares of its pixels.
fn brought_down(fine: &[u8], [width, height]: [usize; 2]) -> Vec<u8> {
    let mut small = Vec::with_capacity(3 * width * height);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        for channel in 0..3 {
            let of = |dy: usize, dx: usize| {
                usize::from(fine[3 * (FINE * width * (FINE * y + dy) + FINE * x + dx) + channel])
            };
            let sum: usize =
                (0..FINE).flat_map(|dy| (0..FINE).map(move |dx| (dy, dx))).map(|(dy, dx)| of(dy, dx)).sum();
            small.push(((sum + FINE * FINE / 2) / (FINE * FINE)) as u8);
        }
    }
    small
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_brought_down_by_squares() {
        // Two squares of four pixels beside each other: 0, 1, 2, 3 by rows of each, and 100 more.
        let rows = [[0_u8, 1, 100, 101], [2, 3, 102, 103]];
        let fine: Vec<u8> = rows.iter().flatten().flat_map(|value| [*value, 10, 20]).collect();
        assert_eq!(brought_down(&fine, [2, 1]), [2, 10, 20, 102, 10, 20]);
    }

    #[test]
    fn every_scene_of_the_gallery_is_there() {
        for shot in PICTURES.iter().flat_map(|picture| picture.shots) {
            assert!(
                root().join("scenes").join(shot.scene).with_extension("toml").is_file(),
                "{}",
                shot.scene
            );
        }
    }
}
