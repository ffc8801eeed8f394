//! Scenes and meshes in, results out.

mod calls;
mod checkpoint;
mod files;
mod garments;
mod given;
mod long;
mod mesh;
mod mesh_formats;
mod mesh_gltf;
mod output;
mod output_vtu_glb;
mod polygons;
mod poses;
mod random_scenes;
mod scene;
