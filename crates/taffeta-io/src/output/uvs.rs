//! Texture coordinates for formats that give each vertex at most one.

use std::collections::HashMap;
use taffeta::topology::{Surface, Uvs};

/// Vertices with one texture coordinate each: first the file's own, then copies of those at which corners disagree.
pub(super) struct Split {
    /// The file's vertex of each entry; the first are 0, 1, 2, …
    pub source: Vec<u32>,
    /// Texture coordinate of each entry; 0 where no face uses the vertex.
    pub coords: Vec<[f32; 2]>,
    /// The entry of each corner of the faces.
    pub corners: Vec<u32>,
}

impl Split {
    /// Splits the vertices of `surface` where its texture has a seam.
    pub fn of(surface: &Surface, uvs: &Uvs) -> Self {
        let count = surface.vertices.len();
        let mut seen = vec![false; count];
        let mut copies = HashMap::new();
        let mut split =
            Self { source: (0..count as u32).collect(), coords: vec![[0.0; 2]; count], corners: Vec::new() };
        for (&vertex, &uv) in surface.polygons.corners.iter().zip(&uvs.corners) {
            let (own, uv) = (vertex as usize, uvs.coords[uv as usize]);
            if !seen[own] {
                (seen[own], split.coords[own]) = (true, uv);
            }
            let entry = if split.coords[own] == uv {
                vertex
            } else {
                *copies.entry((vertex, uv.map(f32::to_bits))).or_insert_with(|| {
                    split.source.push(vertex);
                    split.coords.push(uv);
                    split.coords.len() as u32 - 1
                })
            };
            split.corners.push(entry);
        }
        split
    }
}

/// One texture coordinate a vertex, if all of its corners agree.
pub(super) fn uvs_of_vertices(surface: &Surface, uvs: &Uvs) -> Option<Vec<[f32; 2]>> {
    let split = Split::of(surface, uvs);
    (split.coords.len() == surface.vertices.len()).then_some(split.coords)
}
