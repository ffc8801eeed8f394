//! Triangles to samples.

/// Calls `paint` with the index of each sample in the triangle, and the weights of the three corners there.
pub fn fill(size: [usize; 2], corners: [[f64; 2]; 3], mut paint: impl FnMut(usize, [f64; 3])) {
    let area = twice_area(corners[0], corners[1], corners[2]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let range = |axis: usize| {
        let all = corners.map(|corner| corner[axis]);
        let low = all.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
        let high = all.into_iter().fold(f64::NEG_INFINITY, f64::max).min(size[axis] as f64);
        low.floor() as usize..high.ceil().max(0.0) as usize
    };
    for y in range(1) {
        for x in range(0) {
            let at = [x as f64 + 0.5, y as f64 + 0.5];
            let first = twice_area(at, corners[1], corners[2]) / area;
            let second = twice_area(corners[0], at, corners[2]) / area;
            let weights = [first, second, 1.0 - first - second];
            if weights.iter().all(|&weight| weight >= 0.0) {
                paint(y * size[0] + x, weights);
            }
        }
    }
}

/// Twice the area of a triangle, with its sign.
pub fn twice_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_halves_of_a_square_cover_each_sample() {
        let mut hits = [0; 16];
        for half in [[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]], [[0.0, 0.0], [4.0, 4.0], [0.0, 4.0]]] {
            fill([4, 4], half, |index, weights| {
                hits[index] += 1;
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            });
        }
        assert!(hits.iter().all(|&count| count >= 1));
    }
}
