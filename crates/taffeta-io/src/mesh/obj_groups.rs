//! The `o` and `g` names of an OBJ file, as sets of vertices.

use std::collections::HashMap;
use std::ops::Range;
use taffeta::topology::Polygons;

/// Most names that a face can be in by one `g`. Each costs memory for every face; files have a handful.
const MOST_NAMES: usize = 32;

/// Which faces belong to which `o` and `g` names.
#[derive(Default)]
pub(super) struct Groups {
    groups: Vec<Group>,
    by_name: HashMap<String, usize>,
    object: Option<usize>,
    current: Vec<usize>,
}

#[derive(Default)]
struct Group {
    name: String,
    /// Faces of the group.
    faces: Vec<Range<usize>>,
    /// From which face on the name holds, and how often it was given: as object and as group.
    since: usize,
    holds: usize,
}

impl Groups {
    /// From face `face` on, the groups are `names`.
    pub fn set_groups<'a>(
        &mut self,
        names: impl Iterator<Item = &'a [u8]>,
        face: usize,
    ) -> Result<(), String> {
        let mut new: Vec<usize> = names
            .take(MOST_NAMES + 1)
            .map(|name| self.index(String::from_utf8_lossy(name).into_owned()))
            .collect();
        if new.len() > MOST_NAMES {
            return Err(format!("more than {MOST_NAMES} group names for one face"));
        }
        new.sort_unstable();
        new.dedup();
        new.iter().for_each(|&group| self.groups[group].open(face));
        std::mem::replace(&mut self.current, new).iter().for_each(|&group| self.groups[group].close(face));
        Ok(())
    }

    /// From face `face` on, the object is `name`.
    pub fn set_object(&mut self, name: String, face: usize) {
        let new = (!name.is_empty()).then(|| self.index(name));
        new.into_iter().for_each(|group| self.groups[group].open(face));
        std::mem::replace(&mut self.object, new).into_iter().for_each(|group| self.groups[group].close(face));
    }

    fn index(&mut self, name: String) -> usize {
        *self.by_name.entry(name).or_insert_with_key(|name| {
            self.groups.push(Group { name: name.clone(), ..Group::default() });
            self.groups.len() - 1
        })
    }

    /// The vertices of each name's faces, in order, each once.
    pub fn vertices(mut self, polygons: &Polygons, count: usize) -> Vec<(String, Vec<u32>)> {
        let end = polygons.len();
        let open: Vec<usize> = self.current.drain(..).chain(self.object).collect();
        open.iter().for_each(|&group| self.groups[group].close(end));
        let mut seen_by = vec![0_usize; count];
        let mut of_group = |(index, group): (usize, Group)| {
            let mut vertices = Vec::new();
            for span in group.faces {
                let corners = polygons.offsets[span.start] as usize..polygons.offsets[span.end] as usize;
                for &vertex in &polygons.corners[corners] {
                    if seen_by[vertex as usize] != index + 1 {
                        seen_by[vertex as usize] = index + 1;
                        vertices.push(vertex);
                    }
                }
            }
            vertices.sort_unstable();
            (group.name, vertices)
        };
        self.groups.into_iter().enumerate().map(&mut of_group).collect()
    }
}

impl Group {
    fn open(&mut self, face: usize) {
        if self.holds == 0 {
            self.since = face;
        }
        self.holds += 1;
    }

    fn close(&mut self, face: usize) {
        self.holds -= 1;
        if self.holds == 0 && self.since < face {
            self.faces.push(self.since..face);
        }
    }
}
