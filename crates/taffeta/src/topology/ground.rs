//! A height field as a closed block.

use crate::scene::Heightfield;
use crate::topology::Surface;

/// Most heights: as many as nodes of one mesh.
const MOST: usize = 1 << 26;

/// The surface of a block whose top is a height field. The error says what is wrong with it.
///
/// ```
/// use taffeta::scene::Heightfield;
/// use taffeta::topology::{ground, measure};
///
/// let level = Heightfield { size: [2.0, 3.0], heights: vec![vec![0.1; 3]; 2], depth: 0.5 };
/// let block = ground(&level)?;
/// assert!((measure::volume(&block.nodes, &block.triangles) - 2.0 * 3.0 * 0.5).abs() < 1e-12);
/// let error = ground(&Heightfield { heights: vec![vec![0.1; 3]], ..level }).unwrap_err();
/// assert_eq!(error, "heights are 1 × 3; two rows and columns at least would do");
/// # Ok::<(), String>(())
/// ```
pub fn ground(field: &Heightfield) -> Result<Surface, String> {
    let (rows, cols) = (field.heights.len(), field.heights.first().map_or(0, Vec::len));
    if rows < 2 || cols < 2 {
        return Err(format!("heights are {rows} × {cols}; two rows and columns at least would do"));
    }
    if rows.saturating_mul(cols) > MOST {
        return Err(format!("heights are {rows} × {cols}, more than {MOST}"));
    }
    for (row, heights) in field.heights.iter().enumerate() {
        if heights.len() != cols {
            return Err(format!(
                "row {row} has {} heights, the first one {cols}; as many would do",
                heights.len()
            ));
        }
        if let Some(col) = heights.iter().position(|height| !height.is_finite()) {
            return Err(format!("row {row}, column {col} is {}; finite numbers would do", heights[col]));
        }
    }
    let lowest = field.heights.iter().flatten().copied().fold(f64::INFINITY, f64::min) - field.depth;
    let at = |index: usize, count: usize, size: f64| (index as f64 / (count - 1) as f64 - 0.5) * size;
    let place =
        |row: usize, col: usize, y: f64| [at(col, cols, field.size[0]), y, at(row, rows, field.size[1])];
    let mut nodes: Vec<[f64; 3]> =
        (0..rows * cols).map(|i| place(i / cols, i % cols, field.heights[i / cols][i % cols])).collect();
    let mut triangles = Vec::new();
    let node = |row: usize, col: usize| (row * cols + col) as u32;
    for row in 0..rows - 1 {
        for col in 0..cols - 1 {
            let [a, b] = [node(row, col), node(row, col + 1)];
            let [c, d] = [node(row + 1, col), node(row + 1, col + 1)];
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    // Walls down from the border, which goes around counter-clockwise seen from above, and a fan below.
    let border: Vec<u32> = (0..rows)
        .map(|row| node(row, 0))
        .chain((1..cols).map(|col| node(rows - 1, col)))
        .chain((0..rows - 1).rev().map(|row| node(row, cols - 1)))
        .chain((1..cols - 1).rev().map(|col| node(0, col)))
        .collect();
    let first = nodes.len() as u32;
    for &top in &border {
        let [x, _, z] = nodes[top as usize];
        nodes.push([x, lowest, z]);
    }
    let middle = nodes.len() as u32;
    nodes.push([0.0, lowest, 0.0]);
    for (i, &top) in border.iter().enumerate() {
        let j = (i + 1) % border.len();
        let (next, below, after) = (border[j], first + i as u32, first + j as u32);
        triangles.extend([[top, below, next], [next, below, after], [middle, after, below]]);
    }
    Ok(Surface::of_triangles(nodes, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{Edges, measure};

    #[test]
    fn a_height_field_is_a_closed_block_of_its_volume() {
        let heights = vec![vec![0.0, 1.0, 0.0], vec![1.0, 2.0, 1.0]];
        let field = Heightfield { size: [2.0, 3.0], heights, depth: 0.5 };
        let block = ground(&field).unwrap();
        assert!(Edges::new(block.nodes.len(), &block.triangles, &[]).is_closed());
        // By triangles: (0 1 1), (1 1 2), (1 2 0), (0 2 1) of 1.5 m² each, and the foot of 0.5 m below 6 m².
        let top = 1.5 * (2.0 + 4.0 + 3.0 + 3.0) / 3.0;
        assert!((measure::volume(&block.nodes, &block.triangles) - top - 3.0).abs() < 1e-12);
        assert_eq!(block.nodes[4], [0.0, 2.0, 1.5]);
    }
}
