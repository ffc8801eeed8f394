//! `taffeta-papers pictures`: runs scenes and draws one moment of each into docs/pictures/.

mod shot;

use crate::draw::camera::Camera;
use crate::draw::light::Light;
use crate::draw::{beside, png, render};
use crate::root;
use std::path::PathBuf;
use std::time::Instant;
use taffeta_io::program::{self, Failure};

/// Which frame of a scene shows best what it is about.
#[derive(Clone, Copy)]
enum Moment {
    End,
    Middle,
    /// The frame in which a body reaches lowest.
    Deepest,
}

/// A scene's picture: its moment, and the camera's heading and elevation [°]; narrow panels, if it is seen from several sides.
struct Picture {
    scene: &'static str,
    moment: Moment,
    view: [f64; 2],
    sides: usize,
}

impl Picture {
    const fn of(scene: &'static str, moment: Moment, view: [f64; 2]) -> Self {
        Self { scene, moment, view, sides: 1 }
    }
}

/// The pictures that are drawn when none is named.
const PICTURES: [Picture; 10] = [
    Picture::of("drape", Moment::End, [25.0, 24.0]),
    Picture::of("flag", Moment::Middle, [12.0, 8.0]),
    Picture::of("trampoline", Moment::Deepest, [30.0, 28.0]),
    Picture::of("bunny", Moment::End, [15.0, 15.0]),
    Picture::of("press_bunny", Moment::End, [15.0, 6.0]),
    Picture::of("poke", Moment::Middle, [25.0, 30.0]),
    Picture::of("curtain", Moment::Middle, [15.0, 8.0]),
    Picture::of("hanging", Moment::End, [25.0, 10.0]),
    Picture { scene: "skirt", moment: Moment::End, view: [20.0, 6.0], sides: 4 },
    Picture { scene: "tights", moment: Moment::End, view: [20.0, 6.0], sides: 4 },
];
/// For all other scenes.
const USUAL: Picture = Picture::of("", Moment::End, [20.0, 18.0]);
/// Size of a panel of a picture from several sides.
const PANEL: [usize; 2] = [320, 640];

/// Draws the named scenes; without names, those that are about something to see.
pub fn run(names: &[String]) -> Result<(), Failure> {
    let all = PICTURES.map(|picture| picture.scene.to_owned());
    let names = if names.is_empty() { &all } else { names };
    if let Some(name) = names.iter().find(|name| !file(name).is_file()) {
        return Err(Failure::Input(format!("there is no scenes/{name}.toml")));
    }
    for name in names {
        let drawn = draw(name).map_err(|error| Failure::Work(format!("picture {name}: {error}")))?;
        program::say(&drawn)?;
    }
    Ok(())
}

fn file(scene: &str) -> PathBuf {
    root().join("scenes").join(scene).with_extension("toml")
}

/// Draws one; returns what was drawn.
fn draw(name: &str) -> Result<String, String> {
    let clock = Instant::now();
    let chosen = PICTURES.iter().find(|picture| picture.scene == name);
    let Picture { moment, view: [heading, elevation], sides, .. } = *chosen.unwrap_or(&USUAL);
    let shot = shot::take(&file(name), moment)?;
    let size = if sides > 1 { PANEL } else { render::SIZE };
    let panel = |side: usize| {
        let heading = heading + 360.0 * side as f64 / sides as f64;
        let camera =
            Camera::around(&shot.subject, heading, elevation, size.map(|pixels| pixels * render::FINE));
        render::render(&shot.faces, &camera, &Light::on(&shot.faces, heading), size)
    };
    let panels: Vec<Vec<u8>> = (0..sides).map(panel).collect();
    let (bytes, whole) = (beside(&panels, size), [size[0] * sides, size[1]]);
    let folder = root().join("docs/pictures");
    let file = folder.join(name).with_extension("png");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let bytes = png(&bytes, whole).map_err(|error| format!("{}: {error}", file.display()))?;
    std::fs::write(&file, &bytes).map_err(|error| format!("{}: {error}", file.display()))?;
    let seconds = clock.elapsed().as_secs_f64();
    let notes: String = shot.notes.iter().map(|note| format!("\n    {note}")).collect();
    Ok(format!(
        "docs/pictures/{name}.png: frame {}, {} KB, {seconds:.1} s{notes}",
        shot.frame,
        bytes.len() / 1000
    ))
}
