//! The triangles of least area between the nodes of a ring in space (Barequet and Sharir, Filling Gaps in the Boundary of
//! a Polyhedron, 1995).

use super::clean::is_flat;

/// Largest ring; the work grows with the third power.
const LARGEST: usize = 256;

/// Triangles of `ring`, wound as it is, none of them flat, with no edges across it but `allowed` ones. `None`: there are
/// no such triangles, or the ring is too long.
pub(super) fn least_area(
    ring: &[u32],
    nodes: &[[f64; 3]],
    allowed: impl Fn(u32, u32) -> bool,
) -> Option<Vec<[u32; 3]>> {
    let count = ring.len();
    if !(3..=LARGEST).contains(&count) {
        return None;
    }
    let place = |i: usize| nodes[ring[i] as usize];
    // Least area between corners i and j, and the corner between them that gives it.
    let mut least = vec![(f64::INFINITY, 0); count * count];
    (1..count).for_each(|j| least[(j - 1) * count + j].0 = 0.0);
    for span in 2..count {
        for i in 0..count - span {
            let j = i + span;
            if span < count - 1 && !allowed(ring[i], ring[j]) {
                continue;
            }
            let mut best = (f64::INFINITY, 0);
            for k in i + 1..j {
                let sides = least[i * count + k].0 + least[k * count + j].0;
                if sides < best.0 && !is_flat([place(i), place(k), place(j)]) {
                    let sum = sides + area(place(i), place(k), place(j));
                    best = if sum < best.0 { (sum, k) } else { best };
                }
            }
            least[i * count + j] = best;
        }
    }
    least[count - 1].0.is_finite().then(|| gather(ring, &least))
}

fn gather(ring: &[u32], least: &[(f64, usize)]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(ring.len() - 2);
    let mut open = vec![(0, ring.len() - 1)];
    while let Some((i, j)) = open.pop() {
        if j > i + 1 {
            let k = least[i * ring.len() + j].1;
            triangles.push([ring[i], ring[k], ring[j]]);
            open.extend([(i, k), (k, j)]);
        }
    }
    triangles
}

fn area(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    0.5 * cross.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::{area, least_area};

    #[test]
    fn a_bent_hexagon_gets_its_least_area_and_keeps_off_forbidden_edges() {
        // Two corners lifted, so that the flat middle joins the other four.
        let nodes = [
            [0.0, 0.0, 0.0],
            [1.0, -1.0, 3.0],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [1.0, 2.0, 3.0],
            [0.0, 1.0, 0.0],
        ];
        let ring = [0, 1, 2, 3, 4, 5];
        let sum = |triangles: &[[u32; 3]]| -> f64 {
            triangles.iter().map(|t| t.map(|n| nodes[n as usize])).map(|[a, b, c]| area(a, b, c)).sum()
        };
        let free = least_area(&ring, &nodes, |_, _| true).unwrap();
        assert_eq!(free.len(), 4);
        assert!((sum(&free) - (2.0 + 2.0 * 10_f64.sqrt())).abs() < 1e-12, "{}", sum(&free));
        let has = |triangles: &[[u32; 3]], a: u32, b: u32| {
            triangles.iter().any(|t| t.contains(&a) && t.contains(&b))
        };
        assert!(has(&free, 0, 2) && has(&free, 3, 5));
        let kept_off = least_area(&ring, &nodes, |a, b| [a, b] != [0, 2]).unwrap();
        assert!(!has(&kept_off, 0, 2) && sum(&kept_off) > sum(&free));
        assert_eq!(least_area(&ring, &nodes, |_, _| false), None);
        assert_eq!(least_area(&[0, 2, 0], &nodes, |_, _| true), None);
    }
}
