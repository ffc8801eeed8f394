//! The scene graph: which meshes stand where.

use super::document::{Document, Node};

/// An affine map: three rows of a matrix, the last column is the translation [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform([[f64; 4]; 3]);

/// A mesh in its place.
pub(super) struct Placement {
    /// The node that has the mesh; `None` in a document without scenes.
    pub node: Option<usize>,
    pub mesh: usize,
    pub transform: Transform,
}

impl Transform {
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    fn of(node: &Node) -> Result<Self, String> {
        if let Some(m) = node.matrix {
            return Ok(Self(std::array::from_fn(|row| std::array::from_fn(|column| m[4 * column + row]))));
        }
        let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let square = x * x + y * y + z * z + w * w;
        if !(square > 0.0 && square.is_finite()) {
            return Err(format!("its rotation [{x}, {y}, {z}, {w}] is not a unit quaternion"));
        }
        // Twice the products of a quaternion that need not be of length 1: files round it.
        let two = 2.0 / square;
        let rotation = [
            [1.0 - two * (y * y + z * z), two * (x * y - z * w), two * (x * z + y * w)],
            [two * (x * y + z * w), 1.0 - two * (x * x + z * z), two * (y * z - x * w)],
            [two * (x * z - y * w), two * (y * z + x * w), 1.0 - two * (x * x + y * y)],
        ];
        let (scale, move_by) = (node.scale.unwrap_or([1.0; 3]), node.translation.unwrap_or([0.0; 3]));
        Ok(Self(std::array::from_fn(|row| {
            let [a, b, c] = rotation[row];
            [a * scale[0], b * scale[1], c * scale[2], move_by[row]]
        })))
    }

    /// First `inner`, then this.
    fn after(&self, inner: &Self) -> Self {
        let column = |c: usize| [0, 1, 2].map(|row| inner.0[row][c]);
        let [x, y, z] = [0, 1, 2].map(|c| self.turn(column(c)));
        let origin = self.apply(column(3));
        Self(std::array::from_fn(|row| [x[row], y[row], z[row], origin[row]]))
    }

    /// Where a point goes.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(point);
        [0, 1, 2].map(|row| turned[row] + self.0[row][3])
    }

    fn turn(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        self.0.map(|[a, b, c, _]| a * x + b * y + c * z)
    }

    /// Whether it turns right hands into left ones, so that faces must be wound the other way round.
    pub fn mirrors(&self) -> bool {
        let [[a, b, c, _], [d, e, f, _], [g, h, i, _]] = self.0;
        a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0.0
    }
}

/// The meshes of the default scene, or the first, parents before children; of a document without scenes each mesh once.
pub(super) fn placements(document: &Document) -> Result<Vec<Placement>, String> {
    let index = match (document.scene, document.scenes.is_empty()) {
        (None, true) => return Ok((0..document.meshes.len()).map(alone).collect()),
        (index, _) => index.unwrap_or(0),
    };
    let scene = document.scenes.get(index);
    let scene = scene.ok_or_else(|| format!("scene {index}; there are {}", document.scenes.len()))?;
    let mut placed = Vec::new();
    let mut seen = vec![false; document.nodes.len()];
    // The last one comes next.
    let mut open: Vec<(usize, Transform)> = vec![];
    open.extend(scene.nodes.iter().rev().map(|&node| (node, Transform::IDENTITY)));
    while let Some((index, outer)) = open.pop() {
        let Some(node) = document.nodes.get(index) else {
            return Err(format!("node {index}; there are {}", document.nodes.len()));
        };
        let label = || label("node", index, node.name.as_deref());
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("{} is reached twice; nodes must form trees, without cycles", label()));
        }
        let own = Transform::of(node).map_err(|what| format!("{}: {what}", label()))?;
        let transform = outer.after(&own);
        placed.extend(node.mesh.map(|mesh| Placement { node: Some(index), mesh, transform }));
        open.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    Ok(placed)
}

fn alone(mesh: usize) -> Placement {
    Placement { node: None, mesh, transform: Transform::IDENTITY }
}

/// ``node 3 `arm` ``, for errors.
pub(super) fn label(what: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{what} {index} `{name}`"),
        None => format!("{what} {index}"),
    }
}

#[cfg(test)]
mod tests {
    use super::Transform;

    #[test]
    fn transforms_compose_outer_after_inner() {
        // A quarter turn about z, then 1 m along x, of a stretched and mirrored inside.
        let half = 0.5_f64.sqrt();
        let node = |text: &str| Transform::of(&serde_json::from_str(text).unwrap()).unwrap();
        let outer = node(&format!(
            r#"{{"rotation": [0, 0, {}, {}], "translation": [1, 0, 0]}}"#,
            3.0 * half,
            3.0 * half
        ));
        let inner = node(r#"{"matrix": [-2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]}"#);
        let place = outer.after(&inner).apply([1.0, 2.0, 3.0]);
        // (1, 2, 3) → (3, 2, 3) → (−2, 3, 3) → (−1, 3, 3)
        assert!([-1.0, 3.0, 3.0].iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-15), "{place:?}");
        assert!(outer.after(&inner).mirrors() && !outer.mirrors());
        assert_eq!(inner, node(r#"{"scale": [-2, 1, 1], "translation": [5, 0, 0]}"#));
    }
}
