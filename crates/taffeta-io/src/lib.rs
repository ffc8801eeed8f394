//! Scenes and meshes in, results out.
//!
//! [`load_scene`] reads a TOML scene with its meshes, [`load_mesh`] an OBJ, PLY, STL, OFF or glTF file. [`output`] holds
//! the streaming writers. Everything here answers bad input with an error that names the place.
//!
//! A mesh from a file becomes a body so:
//!
//! ```no_run
//! use std::{path::Path, sync::Arc};
//! use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
//! use taffeta::{Options, Simulation};
//! use taffeta_io::{MeshOptions, load_mesh};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let surface = load_mesh(Path::new("shirt.ply"), &MeshOptions::default())?;
//! let mut shirt = Body::cloth("shirt", Mesh::Surface(Arc::new(surface)))
//!     .with_mass(Mass::Area(0.2))
//!     .structural(10.0, 0.002)
//!     .pin(Select { group: Some("shoulders".to_owned()), ..Select::default() });
//! shirt.place.scale = Some(0.01); // a file in centimetres
//! let scene = Scene::new("shirt").time(1.0 / 60.0, 4e-4).body(shirt);
//! let mut simulation = Simulation::new(&scene, &Options::default())?;
//! simulation.step()?;
//! # Ok(())
//! # }
//! ```

pub mod checkpoint;
pub mod files;
pub mod mesh;
pub mod output;
pub mod program;
pub mod scene;

pub use checkpoint::Checkpoint;
pub use files::Given;
pub use mesh::{MeshError, MeshFormat, MeshOptions, load_mesh, parse_mesh, surface_from};
pub use scene::{
    LoadError, Loaded, Place, SceneSource, load_files, load_given, load_scene, parse_scene, read_pairs,
    read_poses, read_scene,
};
