//! Small systems of equations, in full.

/// A matrix by rows.
pub type Matrix = Vec<Vec<f64>>;

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

pub fn times(matrix: &Matrix, vector: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| dot(row, vector)).collect()
}

/// |b − A x| by |b|.
pub fn residual(matrix: &Matrix, x: &[f64], b: &[f64]) -> f64 {
    let left: Vec<f64> = times(matrix, x).iter().zip(b).map(|(ax, b)| b - ax).collect();
    norm(&left) / norm(b)
}

/// Conjugate gradients as S1 has them (eqs. 12–17), so many iterations from 0; `quotient` divides.
pub fn conjugate_gradients(
    matrix: &Matrix,
    b: &[f64],
    iterations: usize,
    quotient: fn(f64, f64) -> f64,
) -> Vec<f64> {
    let mut x = vec![0.0; b.len()];
    let [mut r, mut p] = [b.to_vec(), b.to_vec()];
    for _ in 0..iterations {
        let ap = times(matrix, &p);
        let before = dot(&r, &r);
        let alpha = quotient(before, dot(&p, &ap));
        for i in 0..b.len() {
            x[i] += alpha * p[i];
            r[i] -= alpha * ap[i];
        }
        let beta = quotient(dot(&r, &r), before);
        for i in 0..b.len() {
            p[i] = r[i] + beta * p[i];
        }
    }
    x
}

/// As printed.
pub fn divided(a: f64, b: f64) -> f64 {
    a / b
}

/// Nothing where there is nothing left to divide by.
pub fn guarded(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

/// An orthonormal basis of what columns span: as many vectors as the rank (Gram and Schmidt, twice for the digits).
pub fn basis(columns: impl IntoIterator<Item = Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let size = norm(&column);
        let left = without(without(column, &basis), &basis);
        let rest = norm(&left);
        if rest > 1e-8 * size {
            basis.push(left.iter().map(|x| x / rest).collect());
        }
    }
    basis
}

/// What of a vector is not in the span of an orthonormal basis.
pub fn without(mut vector: Vec<f64>, basis: &[Vec<f64>]) -> Vec<f64> {
    for one in basis {
        let share = dot(one, &vector);
        vector.iter_mut().zip(one).for_each(|(v, o)| *v -= share * o);
    }
    vector
}

/// Solves a system with a diagonal and equal neighbours above and below it (Thomas).
pub fn tridiagonal(diagonal: &[f64], beside: &[f64], right: &[f64]) -> Vec<f64> {
    let n = diagonal.len();
    let [mut d, mut b] = [diagonal.to_vec(), right.to_vec()];
    for i in 1..n {
        let factor = beside[i - 1] / d[i - 1];
        d[i] -= factor * beside[i - 1];
        b[i] -= factor * b[i - 1];
    }
    for i in (0..n).rev() {
        let next = if i + 1 < n { beside[i] * b[i + 1] } else { 0.0 };
        b[i] = (b[i] - next) / d[i];
    }
    b
}
