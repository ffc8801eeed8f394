//! Scenes and meshes in, results out.
