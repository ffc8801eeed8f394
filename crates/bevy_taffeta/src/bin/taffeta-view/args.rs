//! What is asked for on the command line.

use bevy::math::Vec3;
use bevy_taffeta::DeviceChoice;
use clap::{Parser, ValueEnum};
use std::path::PathBuf;

/// Show a scene in a window, or make a film of it without one
#[derive(Parser)]
#[command(name = "taffeta-view", version, max_term_width = 110)]
pub struct Args {
    /// The scene, a TOML file
    pub scene: PathBuf,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub backend: Backend,
    /// Worker threads of the CPU [default: as many as help]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Change a value of the scene: body.flag.springs.structural.k=500; may be given several times
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub sets: Vec<String>,
    /// Make a film without a window: FILE.mp4, by ffmpeg, or a folder of PNG files
    #[arg(long, value_name = "PATH")]
    pub record: Option<PathBuf>,
    /// Number of pictures of the film, the first of the start [default: the scene's frames]
    #[arg(long, value_name = "N", requires = "record", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Pictures a second of the film, each a frame later than the one before [default: the scene's frames a second]
    #[arg(long, value_name = "N", requires = "record", value_parser = rate)]
    pub fps: Option<f64>,
    /// Make one picture without a window: FILE.png
    #[arg(long, value_name = "FILE", conflicts_with = "record")]
    pub picture: Option<PathBuf>,
    /// Which frame it is of; 0 is the start [default: the scene's last]
    #[arg(long, value_name = "N", requires = "picture")]
    pub at_frame: Option<u32>,
    /// Close the window after so many updates, counted from the first that shows everything
    #[arg(long, value_name = "N", conflicts_with_all = ["record", "picture"], value_parser = clap::value_parser!(u32).range(1..))]
    pub exit_after: Option<u32>,
    /// Save then what the window shows, panels and all: FILE.png
    #[arg(long, value_name = "FILE", requires = "exit_after")]
    pub window_picture: Option<PathBuf>,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// Where the camera is [m] [default: where it sees the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub eye: Option<Vec3>,
    /// What the camera looks at [m] [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub at: Option<Vec3>,
}

impl Args {
    /// Whether no window opens.
    pub fn is_windowless(&self) -> bool {
        self.record.is_some() || self.picture.is_some()
    }
}

/// Where to compute.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// The GPU that draws, if it is hardware and the scene fits it, else the CPU
    Auto,
    /// CPU threads
    Cpu,
    /// The GPU that draws, in software too; TAFFETA_ADAPTER chooses among several
    Gpu,
}

impl Backend {
    /// As the plugin calls it.
    pub fn device(self) -> DeviceChoice {
        match self {
            Self::Auto => DeviceChoice::Auto,
            Self::Cpu => DeviceChoice::Cpu,
            Self::Gpu => DeviceChoice::Gpu,
        }
    }
}

/// Least and most pixels along a side: what encoders and GPUs take.
const SIDES: std::ops::RangeInclusive<u32> = 16..=8192;

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').map(|(w, h)| [w, h].map(|side| side.trim().parse::<u32>().ok()));
    match sides {
        Some([Some(width), Some(height)]) if SIDES.contains(&width) && SIDES.contains(&height) => {
            Ok([width, height])
        }
        _ => {
            Err(format!("two numbers from {} to {}, such as 1280x720, would do", SIDES.start(), SIDES.end()))
        }
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok().filter(|rate| (0.1..=1000.0).contains(rate));
    rate.ok_or_else(|| "a number from 0.1 to 1000 would do".into())
}

fn point(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].into_iter().all(f32::is_finite) => Ok(Vec3::new(x, y, z)),
        _ => Err("three numbers with commas between, such as 0,1.5,4, would do".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_points_are_read_or_refused_with_what_would_do() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(point("0, -1.5,4"), Ok(Vec3::new(0.0, -1.5, 4.0)));
        for wrong in ["640", "640x", "x480", "0x480", "640x480x2", "99999x480"] {
            assert!(size(wrong).unwrap_err().contains("1280x720"), "{wrong}");
        }
        for wrong in ["1,2", "1,2,3,4", "a,b,c", "1,2,nan"] {
            assert!(point(wrong).unwrap_err().contains("three numbers"), "{wrong}");
        }
    }
}
