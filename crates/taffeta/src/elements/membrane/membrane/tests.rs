use super::*;
use crate::real::cross;
use crate::topology::random::SplitMix64;

/// A triangle of 0.3 by 0.2 m whose warp runs along x, with these C₁₁, C₁₂, C₂₂, G [N/m].
fn numbers([c11, c12, c22, g]: [f64; 4], damping: f64, limit: f64) -> [f64; 10] {
    let area = 0.03;
    let of_area = |c: f64| c * area;
    [1.0 / 0.3, 0.0, 0.0, 5.0, of_area(c11), of_area(c12), of_area(c22), of_area(g), damping, limit]
}

const REST: [[f64; 3]; 3] = [[0.0; 3], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0]];
const TENSOR: [f64; 4] = [490.0, 40.0, 210.0, 35.0];

fn random(random: &mut SplitMix64, size: f64) -> [[f64; 3]; 3] {
    std::array::from_fn(|_| std::array::from_fn(|_| size * (2.0 * random.unit() - 1.0)))
}

/// States from hardly strained to squashed, and beyond a limit.
fn states() -> Vec<[[f64; 3]; 3]> {
    let mut chance = SplitMix64::new(11);
    let mut all = Vec::new();
    for size in [1e-3, 0.03, 0.1, 0.4] {
        for _ in 0..20 {
            let by = random(&mut chance, size);
            all.push([0, 1, 2].map(|node| add(REST[node], by[node])));
        }
    }
    all
}

#[test]
fn a_stretch_along_the_warp_gives_the_force_of_the_closed_form() {
    // Force per width S ½ (s² − 1) s, on an edge of 0.2 m; half of it on each of its corners.
    for s in [0.9, 0.97, 1.02, 1.1, 1.3] {
        let x = REST.map(|[x, y, z]| [s * x, y, z]);
        let force = Membrane::forces(x, [[0.0; 3]; 3], numbers([490.0, 0.0, 210.0, 35.0], 0.0, NO_LIMIT));
        let wanted = -490.0 * 0.5 * (s * s - 1.0) * s * 0.2 / 2.0;
        assert!((force[1][0] - wanted).abs() < 1e-12, "{s}: {} N, not {wanted} N", force[1][0]);
    }
}

#[test]
fn forces_are_minus_the_energys_derivative_and_keep_momentum() {
    for limit in [NO_LIMIT, 0.05] {
        let numbers = numbers(TENSOR, 0.0, limit);
        for x in states() {
            let force = Membrane::forces(x, [[0.0; 3]; 3], numbers);
            let (mut net, mut moment) = ([0.0; 3], [0.0; 3]);
            for node in 0..3 {
                net = add(net, force[node]);
                moment = add(moment, cross(x[node], force[node]));
                for axis in 0..3 {
                    let at = |by: f64| {
                        let mut x = x;
                        x[node][axis] += by;
                        Membrane::energy(x, numbers)
                    };
                    let numeric = -(at(1e-6) - at(-1e-6)) / 2e-6;
                    let size = 1.0 + force[node][axis].abs();
                    assert!((numeric - force[node][axis]).abs() < 1e-5 * size, "{x:?}: {numeric}, {force:?}");
                }
            }
            assert!(net.iter().chain(&moment).all(|part| part.abs() < 1e-9));
        }
    }
}

#[test]
fn a_turned_triangle_feels_the_same() {
    let numbers = numbers(TENSOR, 0.0, NO_LIMIT);
    for x in states() {
        let turned = x.map(|[x, y, z]| [0.6 * x - 0.8 * z, y, 0.8 * x + 0.6 * z]);
        let (here, there) = (Membrane::energy(x, numbers), Membrane::energy(turned, numbers));
        assert!((here - there).abs() <= 1e-12 * here);
    }
}

#[test]
fn the_energy_of_a_compression_is_convex_down_to_a_hundredth() {
    let numbers = numbers([490.0, 0.0, 210.0, 35.0], 0.0, NO_LIMIT);
    let energy = |s: f64| Membrane::energy(REST.map(|[x, y, z]| [s * x, y, z]), numbers);
    let mut s = 0.011;
    while s < 1.2 {
        let second = energy(s + 1e-4) - 2.0 * energy(s) + energy(s - 1e-4);
        assert!(second > 0.0, "at a stretch of {s}");
        s += 0.01;
    }
    assert!(energy(0.5) > energy(0.7) && energy(0.7) > energy(0.9));
}

#[test]
fn damping_takes_power_in_every_state() {
    let (still, damped) = (numbers(TENSOR, 0.0, NO_LIMIT), numbers(TENSOR, 0.01, NO_LIMIT));
    let mut chance = SplitMix64::new(5);
    for x in states() {
        let v = random(&mut chance, 3.0);
        let (elastic, all) = (Membrane::forces(x, v, still), Membrane::forces(x, v, damped));
        let power: f64 = (0..3).map(|node| dot(sub(all[node], elastic[node]), v[node])).sum();
        assert!(power < 0.0, "{power} W");
    }
}

/// Where nothing pushes, modes are the whole Hessian.
#[test]
fn under_tension_modes_are_the_derivative_of_the_forces() {
    for limit in [NO_LIMIT, 0.05] {
        let numbers = numbers(TENSOR, 0.0, limit);
        let mut chance = SplitMix64::new(3);
        for _ in 0..10 {
            let by = random(&mut chance, 0.01);
            let x = [0, 1, 2].map(|node| add(scale(REST[node], 1.15), by[node]));
            let u = random(&mut chance, 1.0);
            let moved = |by: f64| {
                let x = [0, 1, 2].map(|node| add(x[node], scale(u[node], by)));
                Membrane::forces(x, [[0.0; 3]; 3], numbers)
            };
            let (ahead, behind) = (moved(1e-7), moved(-1e-7));
            let mut product = [[0.0; 3]; 3];
            for mode in Membrane::modes(x, numbers) {
                let along: f64 = (0..3).map(|node| dot(mode.directions[node], u[node])).sum();
                product =
                    [0, 1, 2].map(|node| add(product[node], scale(mode.directions[node], mode.k * along)));
            }
            for (weights, k) in Membrane::tensions(x, numbers) {
                let along = (0..3).fold([0.0; 3], |sum, node| add(sum, scale(u[node], k * weights[node])));
                product = [0, 1, 2].map(|node| add(product[node], scale(along, weights[node])));
            }
            for node in 0..3 {
                for axis in 0..3 {
                    let numeric = -(ahead[node][axis] - behind[node][axis]) / 2e-7;
                    let apart = (numeric - product[node][axis]).abs();
                    assert!(apart < 1e-4 * (1.0 + numeric.abs()), "{numeric} {}", product[node][axis]);
                }
            }
        }
    }
}

#[test]
fn a_triangle_without_area_gives_no_nan() {
    for x in [[[0.1; 3]; 3], [[0.0; 3], [0.3, 0.0, 0.0], [0.6, 0.0, 0.0]]] {
        let force = Membrane::forces(x, REST, numbers(TENSOR, 0.01, NO_LIMIT));
        assert!(force.iter().flatten().all(|part| part.is_finite()));
        for mode in Membrane::modes(x, numbers(TENSOR, 0.01, NO_LIMIT)) {
            assert!(mode.directions.iter().flatten().all(|part| part.is_finite()) && mode.k >= 0.0);
        }
    }
}
