//! Which entries of J M⁻¹ Jᵀ are not zero: those of springs that share a node.

use taffeta::topology::Csr;

/// The springs that share a node with spring `i`, ascending, itself among them. `by_node` has ends of `pairs`.
fn row(i: usize, pairs: &[[u32; 2]], by_node: &Csr) -> Vec<u32> {
    let at = |node: &u32| by_node.row(*node as usize).iter().map(|end| end / 2);
    let mut row: Vec<u32> = pairs[i].iter().flat_map(at).collect();
    row.sort_unstable();
    row.dedup();
    row
}

/// How many entries there are at most.
pub fn entries(pairs: &[[u32; 2]], by_node: &Csr) -> usize {
    (0..pairs.len()).map(|i| row(i, pairs, by_node).len()).sum()
}

/// Columns of each row, ascending.
pub fn csr(pairs: &[[u32; 2]], by_node: &Csr) -> Csr {
    let mut pattern = Csr { offsets: vec![0], items: Vec::new() };
    for i in 0..pairs.len() {
        pattern.items.extend(row(i, pairs, by_node));
        pattern.offsets.push(pattern.items.len() as u32);
    }
    pattern
}

/// ELLPACK: the first columns of all rows, which are the diagonal, then the second ones; rows are as long as the longest
/// and end with their own number.
pub fn ell(pairs: &[[u32; 2]], by_node: &Csr) -> Vec<u32> {
    let (rows, m) = (csr(pairs, by_node), pairs.len());
    let width = (0..m).map(|i| rows.row(i).len()).max().unwrap_or(0);
    let mut columns: Vec<u32> = (0..width).flat_map(|_| 0..m as u32).collect();
    for i in 0..m {
        let others = rows.row(i).iter().filter(|&&j| j as usize != i);
        others.zip(1..).for_each(|(&j, k)| columns[k * m + i] = j);
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three springs in a row and one apart.
    const PAIRS: [[u32; 2]; 4] = [[0, 1], [2, 1], [2, 3], [4, 5]];

    #[test]
    fn rows_name_the_springs_that_share_a_node() {
        let by_node = Csr::corners(6, &PAIRS);
        let rows = csr(&PAIRS, &by_node);
        assert_eq!(rows.offsets, [0, 2, 5, 7, 8]);
        assert_eq!(rows.items, [0, 1, 0, 1, 2, 1, 2, 3]);
        assert_eq!(entries(&PAIRS, &by_node), 8);
        assert_eq!(ell(&PAIRS, &by_node), [0, 1, 2, 3, 1, 0, 1, 3, 0, 2, 2, 3]);
    }

    #[test]
    fn springs_that_share_both_nodes_are_in_each_other_s_rows_once() {
        let pairs = [[0, 1], [1, 0]];
        assert_eq!(csr(&pairs, &Csr::corners(2, &pairs)).items, [0, 1, 0, 1]);
    }
}
