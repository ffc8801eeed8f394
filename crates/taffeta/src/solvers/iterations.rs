//! Upper bounds of the iterations of conjugate gradients. A sub-step records no more iterations than that.
//!
//! Source: Saad, "Iterative Methods for Sparse Linear Systems", 2003, theorem 6.29. With the condition number κ of the
//! scaled system, the residual after n steps is at most 2 √κ ((√κ − 1)/(√κ + 1))ⁿ ≤ 2 √κ exp(−2 n/√κ) of that at the start.
//! The least eigenvalue is not below the least scaled compliance, and the largest, after Gershgorin, not above the largest
//! sum of a row's magnitudes.

use crate::assembly::Assembly;
use crate::real::dot;
use crate::scene::Method;
use crate::solvers::dual::distance::Softness;
use std::ops::Range;

/// Margin for rounding, and for a warm start that is worse than none.
const ROOM: (f64, f64) = (1.5, 10.0);

/// Iterations for some bodies, `max_iterations` at most.
pub fn iterations(assembly: &Assembly, bodies: Range<usize>) -> u32 {
    let ice = &assembly.solver.ice;
    let needed = |body: usize| {
        let root = condition(assembly, body).sqrt();
        ROOM.0 * 0.5 * root * (2.0 * root / ice.tolerance).ln() + ROOM.1
    };
    let most = bodies.map(needed).fold(0.0, f64::max);
    // A number too large for 32 bits becomes the largest.
    (most.ceil() as u32).min(ice.max_iterations)
}

/// Iterations for some bodies with implicit springs and elements, `max_iterations` at most. The V-cycle counts as the Jacobi
/// iteration that it contains, with the system scaled by its diagonal blocks. The largest eigenvalue is not above 2,
/// as no element's energy is more than twice that of its nodes alone. The least one is not below the least fraction
/// of a mass in its block.
pub fn descents(assembly: &Assembly, bodies: Range<usize>) -> u32 {
    let (ice, all, h) = (&assembly.solver.ice, assembly.constraints(), assembly.time.substep(0).1);
    let mut most = 0.0_f64;
    for body in bodies {
        let nodes = &assembly.bodies[body];
        let mut stiff = vec![0.0; nodes.nodes];
        for row in all.bodies[body].clone() {
            let [k, damping] = all.materials[all.material[row] as usize];
            all.ends[row].iter().for_each(|&end| stiff[end as usize - nodes.first] += h * (h * k + damping));
        }
        let of_elements = assembly.elements().iter().filter(|list| list.implicit);
        for (list, visit) in of_elements.filter_map(|list| Some((list, list.kind.modes?))) {
            for (ends, numbers) in list.of(list.bodies[body].clone()) {
                let at = |&end: &u32| end as usize - nodes.first;
                let x: Vec<[f64; 3]> = ends.iter().map(|end| nodes.start[at(end)]).collect();
                visit(&x, numbers, &mut |directions, [k, damping, stiffest]| {
                    // As much as all of the element's nodes together, where a spring has two.
                    let most = 0.5 * ends.len() as f64 * stiffest * h * (h * k + damping);
                    for (end, &direction) in ends.iter().zip(directions) {
                        stiff[at(end)] += most * dot(direction, direction);
                    }
                });
            }
        }
        let share = |node: usize| if nodes.free[node] { stiff[node] / nodes.mass[node] } else { 0.0 };
        let root = (2.0 * (1.0 + (0..nodes.nodes).map(share).fold(0.0, f64::max))).sqrt();
        most = most.max(ROOM.0 * 0.5 * root * (2.0 * root / ice.tolerance).ln() + ROOM.1);
    }
    // A number too large for 32 bits becomes the largest.
    (most.ceil() as u32).min(ice.max_iterations)
}

/// A bound of the condition number of a body's system; infinite if there is no compliance.
fn condition(assembly: &Assembly, body: usize) -> f64 {
    let (all, nodes) = (assembly.constraints(), &assembly.bodies[body]);
    let (rows, soft) = (all.bodies[body].clone(), softness(assembly));
    let inverse_mass = |end: usize| if nodes.free[end] { 1.0 / nodes.mass[end] } else { 0.0 };
    let ends = |row: usize| all.ends[row].map(|end| end as usize - nodes.first);
    let weight = |row: usize| ends(row).map(inverse_mass).iter().sum::<f64>();
    let compliance = |row: usize| {
        let Softness { compliance, epsilon, .. } = soft[all.material[row] as usize];
        compliance + epsilon * weight(row)
    };
    let scale = |row: usize| (weight(row) + compliance(row)).sqrt().recip();
    let free = || rows.clone().filter(|&row| weight(row) > 0.0);
    let mut at_node = vec![0.0; nodes.nodes];
    free().for_each(|row| ends(row).into_iter().for_each(|end| at_node[end] += scale(row)));
    let (mut least, mut most) = (1.0_f64, 1.0_f64);
    for row in free() {
        let own = scale(row) * scale(row) * compliance(row);
        let sum: f64 = ends(row).into_iter().map(|end| inverse_mass(end) * at_node[end]).sum();
        (least, most) = (least.min(own), most.max(own + scale(row) * sum));
    }
    most / least
}

/// The softness of each material in the longest sub-step.
fn softness(assembly: &Assembly) -> Vec<Softness<f64>> {
    let (ice, acad, h) = (&assembly.solver.ice, &assembly.solver.acad, assembly.time.substep(0).1);
    let of = |&[k, d]: &[f64; 2]| match assembly.solver.method {
        Method::Acad => Softness::stiff(acad.epsilon, acad.form, h),
        _ => Softness::spring(k, d, ice.epsilon, ice.form, h),
    };
    assembly.constraints().materials.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, ConstraintForm, Mass, Mesh, Scene, Select};

    fn assembly(k: f64, form: ConstraintForm) -> Assembly {
        let pair = Body::cloth("pair", Mesh::chain(2, 2.0)).with_mass(Mass::Node(0.5)).structural(k, 0.0);
        let mut scene =
            Scene::new("pair").method(Method::Ice).body(pair.pin(Select::nodes([0]))).time(0.1, 0.1);
        scene.solver.ice.form = form;
        Assembly::new(&scene).unwrap()
    }

    #[test]
    fn the_bound_of_two_springs_in_a_row_is_that_by_hand() {
        // Nodes held, free, free; w = 2, D = 1/(k h²) = 2. Scales 1/√(2 + 2), 1/√(4 + 2); shared node: 2.
        let found = condition(&assembly(50.0, ConstraintForm::Compliant), 0);
        let (first, second) = (0.5, 1.0 / 6.0_f64.sqrt());
        let rows = [
            0.5 + first * 2.0 * (first + second),
            1.0 / 3.0 + second * (2.0 * (first + second) + 2.0 * second),
        ];
        assert!((found - rows[0].max(rows[1]) * 3.0).abs() < 1e-12, "{found}");
    }

    #[test]
    fn springs_by_nodes_need_as_many_iterations_as_their_stiffest_node_says() {
        // h² k = 0.5, and the middle node of 0.5 kg has two: κ ≤ 2 (1 + 2).
        let of = |k| descents(&assembly(k, ConstraintForm::Primal), 0..1);
        let root = 6.0_f64.sqrt();
        assert_eq!(of(50.0), (1.5 * 0.5 * root * (2.0 * root / 1e-3).ln() + 10.0).ceil() as u32);
        assert_eq!(of(1e9), 200);
    }

    #[test]
    fn what_gives_way_needs_few_iterations_and_what_does_not_as_many_as_there_may_be() {
        let of = |k, form| iterations(&assembly(k, form), 0..1);
        let soft = of(50.0, ConstraintForm::Compliant);
        assert!((11..40).contains(&soft), "{soft}");
        assert!(of(5000.0, ConstraintForm::Compliant) > soft);
        assert_eq!(of(1e9, ConstraintForm::Compliant), 200);
        assert_eq!(of(50.0, ConstraintForm::Printed), 200);
    }
}
