//! Colours: pairs of one colour share no node.

/// For each pair the first colour that none of those before it has at either of its nodes (greedy colouring, in order).
pub fn colours(nodes: usize, pairs: &[[u32; 2]]) -> Vec<usize> {
    let mut taken: Vec<Vec<u64>> = vec![vec![0]; nodes];
    let mut all = Vec::with_capacity(pairs.len());
    for &[a, b] in pairs {
        let words = taken[a as usize].len().max(taken[b as usize].len());
        let word = |node: u32, at: usize| taken[node as usize].get(at).copied().unwrap_or(0);
        let free = (0..words).find_map(|at| {
            let free = !(word(a, at) | word(b, at));
            (free != 0).then(|| 64 * at + free.trailing_zeros() as usize)
        });
        let colour = free.unwrap_or(64 * words);
        for node in [a, b] {
            let own = &mut taken[node as usize];
            own.resize(own.len().max(colour / 64 + 1), 0);
            own[colour / 64] |= 1 << (colour % 64);
        }
        all.push(colour);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_pairs_of_a_colour_share_a_node() {
        // A star of 200 and a ring through its points.
        let star = (1..=200).map(|point| [0, point]);
        let ring = (1..=200).map(|point| [point, point % 200 + 1]);
        let pairs: Vec<[u32; 2]> = star.chain(ring).collect();
        let all = colours(201, &pairs);
        let mut seen = std::collections::BTreeSet::new();
        for (pair, &colour) in pairs.iter().zip(&all) {
            assert!(pair.iter().all(|&node| seen.insert((colour, node))), "{pair:?} of {colour}");
        }
        assert_eq!(all.iter().max(), Some(&199));
    }
}
