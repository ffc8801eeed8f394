//! Scenes and meshes in, results out.
//!
//! [`load_scene`] reads a TOML scene with its meshes, [`load_mesh`] an OBJ, PLY, STL, OFF or glTF file. [`output`] holds
//! the streaming writers. Everything here answers bad input with an error that names the place.

pub mod checkpoint;
pub mod mesh;
pub mod output;
pub mod scene;

pub use checkpoint::Checkpoint;
pub use mesh::{MeshError, MeshFormat, MeshOptions, load_mesh, parse_mesh, surface_from};
pub use scene::{LoadError, Loaded, Place, SceneSource, load_scene, parse_scene, read_pairs};
