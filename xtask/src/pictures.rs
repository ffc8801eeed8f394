//! `cargo xtask pictures`: runs scenes and draws one moment of each into docs/pictures/.

pub mod camera;
pub mod light;
mod palette;
mod raster;
pub mod render;
pub mod shapes;
mod shot;
mod solid;
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
    let Picture { moment, view: [heading, elevation], sides, .. } = *chosen.unwrap_or(&USUAL);
    let scene = root().join("scenes").join(name).with_extension("toml");
    if !scene.is_file() {
        return Err(format!("there is no scenes/{name}.toml"));
    }
    let shot = shot::take(&scene, moment)?;
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
    let size = write(&file, &bytes, whole).map_err(|error| format!("{}: {error}", file.display()))?;
    let seconds = clock.elapsed().as_secs_f64();
    println!("docs/pictures/{name}.png: frame {}, {} KB, {seconds:.1} s", shot.frame, size / 1000);
    shot.notes.iter().for_each(|note| println!("    {note}"));
    Ok(())
}

/// Pictures of one size side by side; bytes of red, green and blue by rows.
pub fn beside(panels: &[Vec<u8>], [width, height]: [usize; 2]) -> Vec<u8> {
    let row = |y: usize| panels.iter().flat_map(move |panel| &panel[3 * width * y..3 * width * (y + 1)]);
    (0..height).flat_map(row).copied().collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_beside_each_other_row_by_row() {
        let panel = |first: u8| (first..first + 12).collect::<Vec<u8>>();
        let both = beside(&[panel(0), panel(100)], [2, 2]);
        assert_eq!(both[..12], [0, 1, 2, 3, 4, 5, 100, 101, 102, 103, 104, 105]);
        assert_eq!(both[12..15], [6, 7, 8]);
    }
}
