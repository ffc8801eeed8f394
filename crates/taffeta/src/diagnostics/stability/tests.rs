//! The largest step of random systems against all of their eigenvalues.

use super::*;
use crate::scene::{Body, Icosphere, Mass, Mesh, Scene, Select};
use crate::topology::random::SplitMix64;

/// Springs and elements between random nodes, stiff and damped over several orders of magnitude, some held.
fn system(seed: u64) -> System {
    let mut random = SplitMix64::new(seed);
    let nodes = 8 + random.below(12);
    let mut number = |low: f64, high: f64| low * (high / low).powf(random.unit());
    let direction = |number: &mut dyn FnMut(f64, f64) -> f64| [(); 3].map(|()| number(0.1, 10.0).ln());
    let root_inverse_mass = (0..nodes).map(|_| number(0.5, 5.0)).collect::<Vec<_>>();
    let springs = (0..3 * nodes).map(|i| {
        let along = direction(&mut number);
        let pair = [i % nodes, (i + 1 + i / nodes) % nodes].map(|node| node as u32);
        let d = number(1e-3, 10.0);
        Axis {
            kind: SpringKind::Structural,
            nodes: pair,
            along: scale(along, 1.0 / norm(along)),
            k: number(1.0, 1e3),
            d,
        }
    });
    let springs: Vec<Axis> = springs.collect();
    let count = seed as usize % 9;
    let elements = Modes {
        kind: "hinges",
        width: 4,
        nodes: (0..4 * count).map(|i| ((7 * i) % nodes) as u32).collect(),
        directions: (0..4 * count).map(|_| direction(&mut number)).collect(),
        stiffness: (0..count).map(|_| [number(0.1, 1e3), number(1e-3, 100.0), number(1.0, 2.0)]).collect(),
    };
    let mut system = System {
        springs,
        elements: (count > 0).then_some(elements).into_iter().collect(),
        root_inverse_mass,
        drag: if seed.is_multiple_of(3) { number(1e-3, 1.0) } else { 0.0 },
        ..System::default()
    };
    (0..seed as usize % 3).for_each(|node| system.root_inverse_mass[node] = 0.0);
    system
}

/// Cholesky's factors of 4 − h²K − 2hD exist: the step is stable.
fn is_stable(system: &System, pull: Pull, h: f64) -> bool {
    let nodes = system.root_inverse_mass.len();
    let column = |at: usize| {
        let unit = (0..nodes).map(|node| [0, 1, 2].map(|axis| if 3 * node + axis == at { 1.0 } else { 0.0 }));
        let resisted = system.multiplied(unit, pull);
        resisted
            .iter()
            .flat_map(|x| [0, 1, 2].map(|i| -h * h * x[3 + i] - 2.0 * h * x[6 + i]))
            .collect::<Vec<_>>()
    };
    let mut m: Vec<Vec<f64>> = (0..3 * nodes).map(column).collect();
    for i in 0..m.len() {
        m[i][i] += ROOM;
        for j in 0..i {
            let by = m[i][j] / m[j][j];
            let (above, below) = m.split_at_mut(i);
            below[0].iter_mut().zip(&above[j]).for_each(|(x, y)| *x -= by * y);
        }
        if !m[i][i].is_finite() || m[i][i] <= 0.0 {
            return false;
        }
    }
    true
}

#[test]
fn the_largest_step_of_random_systems_is_stable_and_one_a_hundredth_longer_is_not() {
    for seed in 0..300 {
        let system = system(seed);
        for pull in [Pull::Along, Pull::AnyWay] {
            let ([h, _], _) = system.largest_step(pull);
            assert!(is_stable(&system, pull, h), "{seed}: {h} s is too long");
            assert!(!is_stable(&system, pull, 1.01 * h), "{seed}: {h} s is shorter than it might be");
        }
    }
}

#[test]
fn the_sure_step_of_random_systems_is_stable() {
    for seed in 0..300 {
        let system = system(seed);
        let [sure, _] = system.sure_steps();
        assert!(is_stable(&system, Pull::AnyWay, sure), "{seed}: {sure} s is too long");
    }
}

fn of_body(body: Body) -> System {
    System::new(&Assembly::new(&Scene::new("").body(body)).unwrap(), 0, Explicit::Springs)
}

#[test]
fn the_sure_step_of_cloths_and_balls_is_stable_and_an_eighth_shorter_at_most() {
    let grid = |d| {
        let body = Body::cloth("grid", Mesh::grid(7, 6, [0.5, 0.6])).with_mass(Mass::Node(0.01));
        body.structural(100.0, d).shear(70.0, d).bend(30.0, 0.0)
    };
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 1 });
    let ball = Body::cloth("ball", ball).with_mass(Mass::Whole(1.0)).structural(200.0, 0.05).bend(50.0, 0.02);
    let plain =
        Body { springs: crate::scene::Springs { shear: None, bend: None, ..grid(0.1).springs }, ..grid(0.1) };
    for body in [
        grid(0.0),
        grid(0.5),
        grid(0.01).pin(Select::rows(0, 0)),
        plain,
        ball.clone(),
        ball.pin(Select::nodes([3, 4])),
    ] {
        let name = body.name.clone();
        let system = of_body(body);
        let ([sure, _], ([h, _], _)) = (system.sure_steps(), system.largest_step(Pull::AnyWay));
        assert!(is_stable(&system, Pull::AnyWay, sure) && sure > 0.87 * h, "{name}: {sure} s of {h} s");
    }
}

#[test]
fn springs_that_are_constraints_lend_nothing_to_the_sure_step_of_elements() {
    let grid = Body::cloth("grid", Mesh::grid(7, 6, [0.5, 0.6])).with_mass(Mass::Node(0.01));
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 1 });
    for body in [grid.shear(1e4, 10.0), Body::cloth("ball", ball).with_mass(Mass::Whole(1.0))] {
        let body = body.structural(1e4, 10.0).hinge(0.1, 1e-3);
        let assembly = Assembly::new(&Scene::new("").body(body)).unwrap();
        let system = System::new(&assembly, 0, Explicit::Elements);
        let ([sure, _], ([h, _], _)) = (system.sure_steps(), system.largest_step(Pull::AnyWay));
        assert!(is_stable(&system, Pull::AnyWay, sure) && sure > 0.3 * h, "{sure} s of {h} s");
    }
}

#[test]
fn grids_that_differ_in_their_directions_are_not_alike() {
    let grid = |size| {
        let body = Body::cloth("grid", Mesh::grid(7, 6, size)).with_mass(Mass::Node(0.01));
        body.structural(100.0, 0.0).shear(70.0, 0.0)
    };
    let first = of_body(grid([0.5, 0.6]));
    assert!(first.is_like(&of_body(grid([0.5, 0.6]).at([3.3, 0.7, 0.1]))));
    assert!(!first.is_like(&of_body(grid([0.5, 2.4]))));
}
