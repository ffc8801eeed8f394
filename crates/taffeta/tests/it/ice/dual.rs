//! The system by constraints and the one by nodes are the same step of backward Euler.

use super::{accurate, any, noise, set, state, stiffen, with_ice};
use crate::common::compare::{cloth, join_grid, reference};
use crate::common::constraints::Row;
use crate::common::reference::{Reference, Rigid};
use crate::common::{V, add, build, dot, norm, positions, run, scale, sub, weightless};
use taffeta::Simulation;
use taffeta::scene::{Keyframe, Scene, Select};

const H: f64 = 0.01;

/// A small sheet with one node held and one that is carried, stretched at random and in motion.
fn sheet(stiffer: f64) -> (Simulation, Reference) {
    let path =
        Rigid { until: 1.0, shift: [0.1, 0.5, -0.3], axis: [0.0, 1.0, 0.0], radians: 0.0, pivot: [0.0; 3] };
    let carried = vec![Keyframe::translate(path.until, path.shift)];
    let mut body = cloth(4, 5, [0.4, 0.3]).pin(Select::nodes([7])).pin_moving(Select::nodes([0]), carried);
    stiffen(&mut body, stiffer);
    let scene: Scene = with_ice(weightless("dual", H, H).body(body), accurate());
    let mut simulation = build(&scene);
    let mut reference = reference(&scene, &simulation, vec![0.05; 20]);
    join_grid(&mut reference, 4, 5);
    reference.springs.iter_mut().for_each(|spring| spring.2 *= stiffer);
    reference.held.extend([0, 7]);
    reference.pins.push((0, reference.x[0], path));
    let (mut x, mut v, mut random) = (positions(&simulation), vec![[0.0; 3]; 20], noise(5));
    for n in (0..20).filter(|n| ![0, 7].contains(n)) {
        x[n] = add(x[n], scale(any(&mut random), 0.03));
        v[n] = any(&mut random);
    }
    set(&mut simulation, &x, &v);
    (reference.x, reference.v) = (x, v);
    (simulation, reference)
}

/// Velocities [m/s] by nodes: (M + h Jᵀ (h K + D) J) v = M v* − h Jᵀ K C.
fn primal(reference: &Reference) -> Vec<V> {
    let free = reference.free_velocities(&reference.forces(), H);
    let (n, rows) = (3 * free.len(), reference.rows(H));
    let mut matrix = vec![vec![0.0; n + 1]; n];
    for node in 0..free.len() {
        for axis in 0..3 {
            matrix[3 * node + axis][3 * node + axis] = reference.mass[node];
            matrix[3 * node + axis][n] = reference.mass[node] * free[node][axis];
        }
    }
    for Row { ends: [a, b], slope, compliance, wanted, .. } in rows {
        // A row says λ = (k C + (h k + d) J v) of itself: 1/compliance is h (h k + d), wanted/compliance is k C.
        let (resists, pull) = (1.0 / compliance, wanted / compliance);
        for (i, (end, sign)) in
            [a, a, a, b, b, b].into_iter().zip([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]).enumerate()
        {
            let row = &mut matrix[3 * end + i % 3];
            let push = sign * slope[i % 3];
            row[n] -= H * push * pull;
            for axis in 0..3 {
                row[3 * a + axis] -= push * slope[axis] * resists;
                row[3 * b + axis] += push * slope[axis] * resists;
            }
        }
    }
    for &node in &reference.held {
        for axis in 0..3 {
            let row = &mut matrix[3 * node + axis];
            row.fill(0.0);
            (row[3 * node + axis], row[n]) = (1.0, free[node][axis]);
        }
    }
    let x = eliminate(matrix);
    x.as_chunks().0.to_vec()
}

/// Gauss, the largest pivot of each column; the right side is the last column.
fn eliminate(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let n = matrix.len();
    for column in 0..n {
        let largest =
            (column..n).max_by(|&i, &j| matrix[i][column].abs().total_cmp(&matrix[j][column].abs()));
        matrix.swap(column, largest.expect("rows are left"));
        let pivot = matrix[column].clone();
        for row in &mut matrix[column + 1..] {
            let share = row[column] / pivot[column];
            (column..=n).for_each(|i| row[i] -= share * pivot[i]);
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|i| matrix[row][i] * x[i]).sum();
        x[row] = (matrix[row][n] - known) / matrix[row][row];
    }
    x
}

/// Largest difference of velocities by the largest change that constraints make.
fn off(got: &[V], expected: &[V], free: &[V]) -> f64 {
    let change = expected.iter().zip(free).map(|(&v, &w)| norm(sub(v, w))).fold(0.0, f64::max);
    assert!(change > 1e-3, "constraints do something");
    got.iter().zip(expected).map(|(&v, &w)| norm(sub(v, w))).fold(0.0, f64::max) / change
}

#[test]
fn by_constraints_and_by_nodes_velocities_are_the_same() {
    for stiffer in [1.0, 30.0, 1e4] {
        let (_, mut reference) = sheet(stiffer);
        let (free, expected) = (reference.free_velocities(&reference.forces(), H), primal(&reference));
        reference.step(H);
        let off = off(&reference.v, &expected, &free);
        assert!(off < 1e-9, "{stiffer}: {off:e}");
    }
}

#[test]
fn a_step_of_the_engine_is_that_of_the_system_by_nodes() {
    for stiffer in [1.0, 30.0, 1e4] {
        let (mut simulation, reference) = sheet(stiffer);
        let (free, expected) = (reference.free_velocities(&reference.forces(), H), primal(&reference));
        run(&mut simulation, 1);
        let off = off(&state(&simulation).1, &expected, &free);
        assert!(off < 1e-9, "{stiffer}: {off:e}");
    }
}

#[test]
fn the_step_meets_the_equation_of_each_spring() {
    // λ = k (l − L + h J v') + d J v' of each spring, checked by the forces that it adds up to at each node.
    let (mut simulation, reference) = sheet(30.0);
    run(&mut simulation, 1);
    let v = state(&simulation).1;
    let free = reference.free_velocities(&reference.forces(), H);
    let mut pulls = vec![[0.0; 3]; v.len()];
    for spring in &reference.springs {
        let (a, b) = (spring.0, spring.1);
        let apart = sub(reference.x[b], reference.x[a]);
        let n = scale(apart, 1.0 / norm(apart));
        let rate = dot(n, sub(v[b], v[a]));
        let pull = spring.2 * (norm(apart) - spring.4 + H * rate) + spring.3 * rate;
        (pulls[a], pulls[b]) = (add(pulls[a], scale(n, pull)), sub(pulls[b], scale(n, pull)));
    }
    for n in (0..v.len()).filter(|n| !reference.held.contains(n)) {
        let force = scale(sub(v[n], free[n]), reference.mass[n] / H);
        assert!(norm(sub(force, pulls[n])) < 1e-9 * norm(force), "node {n}: {force:?} N, {:?} N", pulls[n]);
    }
}
