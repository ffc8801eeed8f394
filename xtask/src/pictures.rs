//! `cargo xtask pictures`: runs scenes and draws one moment of each into docs/pictures/.

pub mod camera;
pub mod light;
mod palette;
mod raster;
pub mod render;
pub mod shapes;
mod shot;
pub mod vector;

use crate::root;
use camera::Camera;
use light::Light;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Which frame of a scene shows best what it is about.
#[derive(Clone, Copy)]
enum Moment {
    End,
    Middle,
    /// The frame in which a body reaches lowest.
    Deepest,
}

/// A scene's picture: its moment, and the camera's heading and elevation [°].
struct Picture {
    scene: &'static str,
    moment: Moment,
    view: [f64; 2],
}

/// The pictures that are drawn when none is named.
const PICTURES: [Picture; 8] = [
    Picture { scene: "drape", moment: Moment::End, view: [25.0, 24.0] },
    Picture { scene: "flag", moment: Moment::Middle, view: [12.0, 8.0] },
    Picture { scene: "trampoline", moment: Moment::Deepest, view: [30.0, 28.0] },
    Picture { scene: "bunny", moment: Moment::End, view: [15.0, 15.0] },
    Picture { scene: "press_bunny", moment: Moment::End, view: [15.0, 6.0] },
    Picture { scene: "poke", moment: Moment::Middle, view: [25.0, 30.0] },
    Picture { scene: "curtain", moment: Moment::Middle, view: [15.0, 8.0] },
    Picture { scene: "hanging", moment: Moment::End, view: [25.0, 10.0] },
];
/// For all other scenes.
const USUAL: (Moment, [f64; 2]) = (Moment::End, [20.0, 18.0]);

/// Draws the named scenes; without names, those that are about something to see.
pub fn run(names: &[&str]) -> ExitCode {
    let all = PICTURES.map(|picture| picture.scene);
    let names = if names.is_empty() { &all } else { names };
    for name in names {
        if let Err(message) = draw(name) {
            eprintln!("xtask: picture {name}: {message}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn draw(name: &str) -> Result<(), String> {
    let clock = Instant::now();
    let chosen = PICTURES.iter().find(|picture| picture.scene == name);
    let (moment, [heading, elevation]) = chosen.map_or(USUAL, |picture| (picture.moment, picture.view));
    let scene = root().join("scenes").join(name).with_extension("toml");
    if !scene.is_file() {
        return Err(format!("there is no scenes/{name}.toml"));
    }
    let shot = shot::take(&scene, moment)?;
    let camera = Camera::around(&shot.subject, heading, elevation, render::SAMPLES);
    let light = Light::on(&shot.faces, heading);
    let bytes = render::render(&shot.faces, &camera, &light, render::SIZE);
    let folder = root().join("docs/pictures");
    let file = folder.join(name).with_extension("png");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let size = write(&file, &bytes, render::SIZE).map_err(|error| format!("{}: {error}", file.display()))?;
    let seconds = clock.elapsed().as_secs_f64();
    println!("docs/pictures/{name}.png: frame {}, {} KB, {seconds:.1} s", shot.frame, size / 1000);
    shot.notes.iter().for_each(|note| println!("    {note}"));
    Ok(())
}

/// Writes the picture as small as it gets; returns its size in bytes.
pub fn write(file: &Path, bytes: &[u8], size: [usize; 2]) -> Result<u64, png::EncodingError> {
    let [width, height] = size.map(|pixels| pixels as u32);
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(file)?), width, height);
    let indexed = palette::reduce(bytes);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(indexed.palette);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    // Neighbouring numbers in a palette mean nothing, so that differences between them gain nothing.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&indexed.pixels)?;
    writer.finish()?;
    Ok(std::fs::metadata(file)?.len())
}
