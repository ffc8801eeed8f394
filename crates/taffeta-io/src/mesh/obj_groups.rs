//! The `o` and `g` names of an OBJ file, as sets of vertices.

use std::collections::HashMap;
use taffeta::topology::Polygons;

/// Which faces belong to which `o` and `g` names.
#[derive(Default)]
pub(super) struct Groups {
    names: Vec<String>,
    by_name: HashMap<String, usize>,
    object: Option<usize>,
    current: Vec<usize>,
    /// From which face on which names hold.
    runs: Vec<(usize, Vec<usize>)>,
}

impl Groups {
    /// From face `face` on, the groups are `names`.
    pub fn set_groups<'a>(&mut self, names: impl Iterator<Item = &'a [u8]>, face: usize) {
        self.current = names.map(|name| self.index(String::from_utf8_lossy(name).into_owned())).collect();
        self.start_run(face);
    }

    /// From face `face` on, the object is `name`.
    pub fn set_object(&mut self, name: String, face: usize) {
        self.object = (!name.is_empty()).then(|| self.index(name));
        self.start_run(face);
    }

    fn index(&mut self, name: String) -> usize {
        *self.by_name.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            self.names.len() - 1
        })
    }

    fn start_run(&mut self, face: usize) {
        let mut active = self.current.clone();
        active.extend(self.object);
        active.sort_unstable();
        active.dedup();
        if self.runs.last().is_some_and(|(start, _)| *start == face) {
            self.runs.pop();
        }
        self.runs.push((face, active));
    }

    /// The vertices of each name's faces, in order, each once.
    pub fn vertices(self, polygons: &Polygons, count: usize) -> Vec<(String, Vec<u32>)> {
        let mut spans = vec![Vec::new(); self.names.len()];
        for (i, (start, active)) in self.runs.iter().enumerate() {
            let end = self.runs.get(i + 1).map_or(polygons.len(), |(next, _)| *next);
            active.iter().for_each(|&group| spans[group].push(*start..end));
        }
        let mut seen_by = vec![0_usize; count];
        let mut of_group = |group: usize| {
            let mut vertices = Vec::new();
            for span in spans[group].iter().filter(|span| !span.is_empty()) {
                let corners = polygons.offsets[span.start] as usize..polygons.offsets[span.end] as usize;
                for &vertex in &polygons.corners[corners] {
                    if seen_by[vertex as usize] != group + 1 {
                        seen_by[vertex as usize] = group + 1;
                        vertices.push(vertex);
                    }
                }
            }
            vertices.sort_unstable();
            vertices
        };
        self.names.into_iter().enumerate().map(|(group, name)| (name, of_group(group))).collect()
    }
}
