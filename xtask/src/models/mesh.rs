//! Just enough of mesh formats to turn the fetched models into PLY.

use std::fmt::Write;

/// Vertices and faces.
#[derive(Default)]
pub struct Mesh {
    pub vertices: Vec<[f64; 3]>,
    pub faces: Vec<Vec<usize>>,
}

impl Mesh {
    /// As ASCII PLY.
    pub fn to_ply(&self, comment: &str) -> String {
        let mut text = format!(
            "ply\nformat ascii 1.0\ncomment {comment}\nelement vertex {}\nproperty double x\nproperty double y\n\
             property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.vertices.len(),
            self.faces.len()
        );
        for [x, y, z] in &self.vertices {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{x} {y} {z}");
        }
        for face in &self.faces {
            let corners: Vec<String> = face.iter().map(usize::to_string).collect();
            let _ = writeln!(text, "{} {}", face.len(), corners.join(" "));
        }
        text
    }

    /// The mesh, if it has faces and they name only vertices it has.
    fn checked(self) -> Result<Self, String> {
        let inside = |face: &Vec<usize>| {
            (3..256).contains(&face.len()) && face.iter().all(|&corner| corner < self.vertices.len())
        };
        if self.faces.is_empty() || !self.faces.iter().all(inside) {
            return Err("the mesh has no faces, or faces with vertices it lacks".into());
        }
        Ok(self)
    }
}

/// Reads the vertices and faces of an OBJ.
pub fn from_obj(text: &str) -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => mesh.vertices.push(point(&numbers(words)?)?),
            Some("f") => mesh.faces.push(words.map(obj_corner).collect::<Result<_, _>>()?),
            _ => {}
        }
    }
    mesh.checked()
}

/// Reads the faces of a group of an OBJ, `g NAME`, and the vertices that they have, in their order, times `scale`.
pub fn from_obj_group(text: &str, group: &str, scale: f64) -> Result<Mesh, String> {
    let mut of_group = String::new();
    let mut inside = false;
    for line in text.lines() {
        match line.split_once(' ') {
            Some(("g", name)) => inside = name.trim() == group,
            Some(("f", _)) if !inside => continue,
            _ => {}
        }
        of_group.push_str(line);
        of_group.push('\n');
    }
    let all = from_obj(&of_group)?;
    let mut used = vec![false; all.vertices.len()];
    all.faces.iter().flatten().for_each(|&corner| used[corner] = true);
    let mut mesh = Mesh::default();
    let mut place = vec![0; used.len()];
    for (index, vertex) in all.vertices.iter().enumerate().filter(|(index, _)| used[*index]) {
        place[index] = mesh.vertices.len();
        mesh.vertices.push(vertex.map(|x| x * scale));
    }
    mesh.faces = all.faces.iter().map(|face| face.iter().map(|&corner| place[corner]).collect()).collect();
    Ok(mesh)
}

fn obj_corner(word: &str) -> Result<usize, String> {
    let index = word.split('/').next().and_then(|index| index.parse::<usize>().ok());
    index.and_then(|index| index.checked_sub(1)).ok_or_else(|| format!("not a face corner: {word}"))
}

/// Reads an OFF.
pub fn from_off(text: &str) -> Result<Mesh, String> {
    let body = text.strip_prefix("OFF").ok_or("not an OFF file")?;
    let lines = body.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let mut lines = lines.filter(|line| !line.is_empty());
    let mut row = || numbers(lines.next().unwrap_or_default().split_whitespace());
    let [vertices, faces, ..] = row()?[..] else { return Err("the OFF file has no counts".into()) };
    let mut mesh = Mesh::default();
    for _ in 0..vertices as usize {
        mesh.vertices.push(point(&row()?)?);
    }
    for _ in 0..faces as usize {
        let row = row()?;
        let corners = row.get(1..).unwrap_or_default();
        let count = row.first().map_or(0, |&count| count as usize).min(corners.len());
        mesh.faces.push(corners[..count].iter().map(|&corner| corner as usize).collect());
    }
    mesh.checked()
}

/// Reads a JavaScript module with `positions=[[x,y,z],…]` and `cells=[[i,j,k],…]`.
pub fn from_js(text: &str) -> Result<Mesh, String> {
    let rows = |name: &str| -> Result<Vec<Vec<f64>>, String> {
        let start = text.find(&format!("{name}=[[")).ok_or_else(|| format!("no `{name}`"))?;
        let body = &text[start + name.len() + 3..];
        let body = &body[..body.find("]]").ok_or_else(|| format!("`{name}` has no end"))?];
        body.split("],[").map(|row| numbers(row.split(','))).collect()
    };
    let vertices = rows("positions")?.iter().map(|row| point(row)).collect::<Result<_, _>>()?;
    let corners = |row: Vec<f64>| row.into_iter().map(|corner| corner as usize).collect();
    Mesh { vertices, faces: rows("cells")?.into_iter().map(corners).collect() }.checked()
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec<f64>, String> {
    words.map(|word| word.trim().parse().map_err(|_| format!("not a number: {word}"))).collect()
}

fn point(row: &[f64]) -> Result<[f64; 3], String> {
    row.get(..3).and_then(|xyz| xyz.try_into().ok()).ok_or_else(|| "a vertex has no place".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_triangle_reads_alike_from_three_formats() {
        let js = "exports.positions=[[0,0,0],[1,0,0],[0,1.5,0]]\nexports.cells=[[0,1,2]]";
        let obj = "# a\nv 0 0 0\nv 1 0 0\nv 0 1.5 0\nf 1/1 2//2 3\n";
        let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1.5 0\n3 0 1 2\n";
        let ply = from_js(js).unwrap().to_ply("a");
        assert!(ply.ends_with("end_header\n0 0 0\n1 0 0\n0 1.5 0\n3 0 1 2\n"));
        assert_eq!(from_obj(obj).unwrap().to_ply("a"), ply);
        assert_eq!(from_off(off).unwrap().to_ply("a"), ply);
    }

    #[test]
    fn a_group_has_its_own_vertices_alone() {
        let obj = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1.5 0\ng other\nf 1 2 3\ng skirt\nf 2 3 4\n";
        let skirt = from_obj_group(obj, "skirt", 2.0).unwrap();
        assert_eq!(skirt.vertices, [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
        assert_eq!(skirt.faces, [[0, 1, 2]]);
        assert!(from_obj_group(obj, "tights", 1.0).is_err());
    }

    #[test]
    fn a_face_with_a_vertex_that_is_not_there_is_refused() {
        assert!(from_obj("v 0 0 0\nf 1 2 3\n").is_err());
        assert!(from_obj("v 0 0\n").is_err());
        assert!(from_off("OFF\n1 1 0\n").is_err());
        assert!(from_js("positions=[[0,0]]").is_err());
    }
}
