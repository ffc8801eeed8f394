//! The formats of results, and the writer of each.

use super::plan::Plan;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;
use taffeta::{BodyInfo, Simulation};
use taffeta_io::output::{
    FrameSink, GlbBody, Npy, Pc2, Positions, Usd, Vtu, check_file, file_stems, write_glb, write_obj,
    write_ply,
};

/// A format of results. A checkpoint keeps its place in this list: new ones come last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
pub enum Format {
    /// All frames as a NumPy array: positions.npy
    Npy,
    /// All frames as a point cache for Blender, Maya, 3ds Max: BODY.pc2
    Pc2,
    /// All frames as USD: scene.usda
    Usda,
    /// The last frame: BODY.ply
    Ply,
    /// The last frame: BODY.obj
    Obj,
    /// All frames for ParaView: scene.pvd and the folder vtu
    Vtu,
    /// The last frame of all bodies: scene.glb
    #[value(alias = "gltf")]
    Glb,
}

/// What poses of the last frame can have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Poses {
    /// Positions and normals: the simulation is at that frame.
    Full,
    /// Positions alone: it has gone beyond.
    Bare,
    /// Nothing: the last frame was not kept.
    None,
}

/// Writes the last frame in those of `formats` that hold one; returns the files.
pub fn write_poses(
    dir: &Path,
    formats: &[Format],
    simulation: &Simulation,
    positions: &Positions,
    poses: Poses,
) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    if formats.iter().all(|format| format.is_cache()) {
        return Ok(files);
    }
    let poses = poses_of(simulation, positions, poses);
    for (stem, pose) in stems(simulation).iter().zip(&poses) {
        let path = dir.join(stem);
        for format in formats {
            files.extend(format.pose(&path, &pose.surface, &pose.positions, &pose.normals)?);
        }
    }
    if formats.contains(&Format::Glb) {
        let bodies: Vec<_> = poses.iter().map(Pose::glb).collect();
        files.push(write_glb(&dir.join("scene.glb"), &bodies)?);
    }
    Ok(files)
}

/// The last frame of one body.
struct Pose<'a> {
    name: &'a str,
    surface: Surface,
    positions: Positions<'a>,
    normals: Vec<[f32; 3]>,
}

impl Pose<'_> {
    fn glb(&self) -> GlbBody<'_> {
        let Self { name, surface, positions, normals } = self;
        GlbBody { name, surface, positions: *positions, normals }
    }
}

fn poses_of<'a>(simulation: &'a Simulation, positions: &Positions<'a>, poses: Poses) -> Vec<Pose<'a>> {
    let mut first = 0;
    let mut pose = |body: &'a BodyInfo| {
        let range = first..first + body.vertices;
        first = range.end;
        Some(Pose {
            name: &body.name,
            surface: surface_of(simulation, body),
            positions: positions.slice(range)?,
            normals: if poses == Poses::Full {
                simulation.normals(body.handle).expect("a body of this simulation")
            } else {
                Vec::new()
            },
        })
    };
    simulation.bodies().iter().filter_map(&mut pose).collect()
}

impl Format {
    /// As the user calls it.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether it holds all frames.
    pub fn is_cache(self) -> bool {
        match self {
            Self::Npy | Self::Pc2 | Self::Usda | Self::Vtu => true,
            Self::Ply | Self::Obj | Self::Glb => false,
        }
    }

    /// Names of its files for bodies called `stems`.
    pub fn files(self, stems: &[String]) -> Vec<String> {
        let each = |ending: &str| stems.iter().map(|stem| format!("{stem}{ending}")).collect();
        match self {
            Self::Npy => vec!["positions.npy".to_owned()],
            Self::Pc2 => each(".pc2"),
            Self::Usda => vec!["scene.usda".to_owned()],
            Self::Ply => each(".ply"),
            Self::Obj => each(".obj"),
            Self::Vtu => vec!["scene.pvd".to_owned()],
            Self::Glb => vec!["scene.glb".to_owned()],
        }
    }

    /// Whether it holds faces or normals, which take memory while it is written.
    pub fn has_faces(self) -> bool {
        !matches!(self, Self::Npy | Self::Pc2)
    }

    /// About how many bytes it takes for `frames` frames, the start included.
    pub fn bytes(self, simulation: &Simulation, frames: u64) -> u64 {
        let sum =
            |count: &dyn Fn(&BodyInfo) -> usize| simulation.bodies().iter().map(count).sum::<usize>() as u64;
        let (vertices, triangles) = (sum(&|body| body.vertices), sum(&|body| body.triangles));
        let exact = 3 * simulation.precision().bytes() as u64;
        let per_frame = match self {
            Self::Npy => exact * vertices,
            Self::Pc2 => 12 * vertices,
            // Three numbers of some ten digits.
            Self::Usda => 40 * vertices,
            // Each frame has its faces: indices, an offset and a kind.
            Self::Vtu => exact * vertices + 17 * triangles,
            Self::Ply | Self::Obj | Self::Glb => return 60 * vertices + 20 * triangles,
        };
        per_frame.saturating_mul(frames)
    }

    /// Whether all is there that an earlier run left in `dir`; `lengths` has the marks of its caches.
    pub fn check<'a>(
        self,
        dir: &Path,
        stems: &[String],
        frames: u64,
        lengths: &mut impl Iterator<Item = &'a Vec<u64>>,
    ) -> io::Result<()> {
        let paths: Vec<PathBuf> = self.files(stems).iter().map(|name| dir.join(name)).collect();
        for (path, mark) in paths.iter().zip(lengths) {
            match self {
                Self::Usda => Usd::check(path, mark)?,
                Self::Vtu => Vtu::check(path, stems, frames, mark)?,
                _ => mark.iter().try_for_each(|&length| check_file(path, length))?,
            }
        }
        Ok(())
    }

    /// The files that take all frames.
    pub fn caches(
        self,
        plan: &Plan,
        simulation: &Simulation,
        dt: f64,
    ) -> io::Result<Vec<Box<dyn FrameSink>>> {
        let (dir, begin, bodies) = (&plan.dir, plan.begin(), simulation.bodies());
        Ok(match self {
            Self::Npy => {
                let vertices = bodies.iter().map(|body| body.vertices).sum();
                let path = dir.join("positions.npy");
                vec![Box::new(Npy::open(&path, vertices, plan.cache_precision, begin)?)]
            }
            Self::Pc2 => {
                let mut caches: Vec<Box<dyn FrameSink>> = Vec::new();
                let mut first = 0;
                for (stem, body) in stems(simulation).iter().zip(bodies) {
                    let range = first..first + body.vertices;
                    first = range.end;
                    caches.push(Box::new(Pc2::open(&dir.join(format!("{stem}.pc2")), range, begin)?));
                }
                caches
            }
            Self::Usda => {
                vec![Box::new(Usd::open(&dir.join("scene.usda"), dt, &surfaces(simulation), begin)?)]
            }
            Self::Vtu => {
                let path = dir.join("scene.pvd");
                vec![Box::new(Vtu::open(&path, &surfaces(simulation), plan.cache_precision, begin)?)]
            }
            Self::Ply | Self::Obj | Self::Glb => Vec::new(),
        })
    }

    /// The file with the last frame of one body; `path` has no ending.
    fn pose(
        self,
        path: &Path,
        surface: &Surface,
        positions: &Positions,
        normals: &[[f32; 3]],
    ) -> io::Result<Option<PathBuf>> {
        let with = |ending: &str| {
            let mut name = path.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        match self {
            Self::Ply => write_ply(&with(".ply"), surface, positions, normals).map(Some),
            Self::Obj => write_obj(&with(".obj"), surface, positions, normals).map(Some),
            Self::Npy | Self::Pc2 | Self::Usda | Self::Vtu | Self::Glb => Ok(None),
        }
    }
}

fn surface_of(simulation: &Simulation, body: &BodyInfo) -> Surface {
    simulation.surface(body.handle).expect("a body of this simulation")
}

fn surfaces(simulation: &Simulation) -> Vec<(String, Surface)> {
    simulation.bodies().iter().map(|body| (body.name.clone(), surface_of(simulation, body))).collect()
}

/// What the files of each body are called, without their ending.
pub fn stems(simulation: &Simulation) -> Vec<String> {
    let names: Vec<String> = simulation.bodies().iter().map(|body| body.name.clone()).collect();
    file_stems(&names)
}
