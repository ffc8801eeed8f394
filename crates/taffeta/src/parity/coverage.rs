//! That the states of the rows have nodes and elements on both sides of what kernels branch on, and on it.

use crate::backend::Backend;
use crate::contact::colliders::response::leave_both;
use crate::elements::hinge::{self, hinge as formula};
use crate::gpu::layout::GROUP;
use crate::parity::fixture::{Fixture, SUBSTEP};
use crate::parity::scene::FLOOR;
use crate::real::{dot, norm, scale, sub};
use crate::scene::{ConstraintForm, Method, Solver};
use crate::step::Op;
use std::collections::BTreeMap;

/// How often each thing is there.
#[derive(Default)]
pub struct Count(BTreeMap<&'static str, usize>);

impl Count {
    pub fn note(&mut self, what: &'static str, is: bool) {
        *self.0.entry(what).or_default() += usize::from(is);
    }

    pub fn check(&self) {
        let missing: Vec<_> = self.0.iter().filter(|(_, count)| **count == 0).collect();
        assert!(missing.is_empty(), "nowhere in the states: {missing:?}");
    }
}

fn fixtures() -> [Fixture; 2] {
    [(1, 0.0087), (2, 0.0)].map(|(seed, drag)| Fixture::new(seed, drag, true).expect("a fixture"))
}

#[test]
fn nodes_are_inside_outside_and_on_colliders() {
    let mut count = Count::default();
    for fixture in fixtures() {
        for (x, v) in fixture.new.position.iter().zip(&fixture.new.velocity) {
            let (place, velocity) = ([x[0], x[1], x[2]], [v[0], v[1], v[2]]);
            count.note("a held node inside", x[3] == 0.0 && x[1] < FLOOR);
            count.note("on the floor", x[3] > 0.0 && x[1] == FLOOR);
            count.note("a hair above the floor", x[3] > 0.0 && x[1] == FLOOR.next_up());
            count.note("a hair below the floor", x[3] > 0.0 && x[1] == FLOOR.next_down());
            let mut inside = 0;
            for collider in fixture.substep().colliders() {
                let (depth, normal) = collider.depth_and_normal(place).unwrap();
                if depth <= 0.0 || x[3] == 0.0 {
                    continue;
                }
                inside += 1;
                let contact = collider.surface.contact_at(place, (depth, normal));
                let relative = sub(velocity, contact.surface_velocity);
                let approach = -dot(relative, normal);
                let slip = norm(sub(relative, scale(normal, -approach)));
                let most = contact.friction * (1.0 + contact.restitution) * approach;
                count.note("leaving", approach < 0.0);
                count.note("neither leaving nor coming", approach == 0.0);
                count.note("sticking", approach > 0.0 && slip < most);
                count.note("slipping", approach > 0.0 && slip > most);
                count.note("slipping as fast as friction can stop", approach > 0.0 && slip == most);
            }
            count.note("in no collider", inside == 0);
            count.note("in one", inside == 1);
            count.note("in two", inside == 2);
            count.note("in three", inside == 3);
        }
    }
    count.check();
}

/// Nodes that need more than one round to leave a wedge are those that are still in it after one.
#[test]
fn nodes_are_in_wedges_of_all_sorts() {
    let mut count = Count::default();
    for mut fixture in fixtures() {
        let (between, after) = fixture.on_cpu(&[Op::Contact]);
        let colliders = fixture.substeps[SUBSTEP].colliders().to_vec();
        let last_collider =
            between.last_collider.iter().zip(&fixture.new.position).filter(|(last, _)| **last > 0);
        for (_, x) in last_collider {
            let mut penetration: Vec<_> = colliders
                .iter()
                .filter_map(|collider| collider.depth_and_normal([x[0], x[1], x[2]]))
                .collect();
            penetration.sort_by(|a, b| b.0.total_cmp(&a.0));
            let [first, second] = [penetration[0], penetration[1]];
            let (cosine, way) = (dot(first.1, second.1), leave_both(first, second));
            count.note("one is enough", first.0 * cosine >= second.0);
            count.note("both are left", way != scale(first.1, first.0));
            count.note("both press", second.0 > 0.0);
        }
        let still = |x: &[f32; 4]| {
            colliders.iter().filter(|c| c.depth_and_normal([x[0], x[1], x[2]]).unwrap().0 > 1e-6).count()
        };
        count.note("all are out", after.position.iter().any(|x| still(x) == 0));
        let last = between.last_collider.iter().max().copied().unwrap_or(0);
        count.note("the last collider is touched", last as usize == colliders.len());
    }
    count.check();
}

#[test]
fn hinges_are_flat_steep_folded_over_and_without_area() {
    let mut count = Count::default();
    for fixture in fixtures() {
        let hinges = fixture.tables.elements.of(hinge::NAME).expect("all have some");
        for (corners, numbers) in hinges.elements() {
            let corners: [u32; 4] = corners.try_into().expect("four corners");
            let [rest_angle, rest_steepness] = [numbers[0], numbers[1]].map(f32::from_bits);
            let corner = |node: u32| -> [f32; 3] {
                let [x, y, z, _] = fixture.old.position[node as usize];
                [x, y, z]
            };
            let (theta, gradient) = formula::angle_and_gradient(corners.map(corner));
            let steep = formula::steepness(&gradient);
            let most = formula::STIFFEST as f32 * rest_steepness;
            count.note("without area", steep == 0.0);
            count.note("steep", steep > most);
            count.note("not steep", steep > 0.0 && steep < most);
            count.note("folded over", theta - rest_angle > std::f32::consts::PI);
            count.note("folded over the other way", theta - rest_angle < -std::f32::consts::PI);
        }
    }
    count.check();
}

#[test]
fn springs_and_rows_are_of_all_lengths() {
    let mut count = Count::default();
    for fixture in fixtures() {
        let tables = &fixture.tables;
        let at = |place: usize| -> [f32; 3] {
            let [x, y, z, _] = fixture.old.position[place];
            [x, y, z]
        };
        for place in 1..tables.len() {
            let d = sub(at(place), at(place - 1));
            count.note("a spring of no length", dot(d, d) == 0.0);
            count.note("below what is divided by", dot(d, d) > 0.0 && dot(d, d) < 1e-30);
            count.note("just above", dot(d, d) > 1e-30 && dot(d, d) < 1e-29);
            let row = tables.loads.by_node.row(place);
            count.note("a node without loads or hinges", row.is_empty() && fixture.is_node[place]);
            count.note("a node with several", row.len() > 7);
            count.note("a place without a node", !fixture.is_node[place]);
            count.note("held", fixture.old.position[place][3] == 0.0 && fixture.is_node[place]);
        }
        for run in &tables.springs.runs {
            count.note("a slice without springs of a kind", run.count == 0);
            count.note("a slice with springs", run.count > 0 && run.count < 100);
        }
        count.note("several workgroups", fixture.place_groups() > 2);
        count.note("three kinds", tables.springs.kinds == 3);
        count.note("a grid of several tiles", tables.springs.tiles.iter().any(|t| t.row > 0 && t.col > 0));
        count.note("one row", tables.springs.grids.iter().any(|grid| grid.rows == 1));
        count.note("one column", tables.springs.grids.iter().any(|grid| grid.cols == 1));
        count.note("two columns", tables.springs.grids.iter().any(|grid| grid.cols == 2));
        count.note("a load on many", tables.loads.loads.iter().any(|load| load.count as usize > GROUP));
        let pushed = fixture.input.forces.windows(2);
        count.note("pushed twice", pushed.into_iter().any(|two| two[0].0 == two[1].0));
        count.note("no drag", fixture.cpu.assembly().world.drag == 0.0);
    }
    count.check();
}

#[test]
fn on_hardware_nothing_stands_on_a_threshold() {
    let fixture = Fixture::new(1, 0.0087, false).expect("a fixture");
    let near = |x: &&[f32; 4]| (x[1] - FLOOR).abs() < 1e-6;
    assert_eq!(fixture.new.position.iter().filter(near).count(), 0);
    let inside = |x: &&[f32; 4]| x[1] < FLOOR;
    assert!(fixture.new.position.iter().filter(inside).count() > 100);
}

#[test]
fn levels_are_of_all_sorts() {
    let mut count = Count::default();
    let mut solver = Solver { method: Method::Ice, ..Solver::default() };
    solver.ice.form = ConstraintForm::Primal;
    let fixture = Fixture::with_levels(3, solver, true).expect("a fixture");
    let multigrid = &fixture.tables.multigrid;
    for group in &multigrid.groups[0] {
        let tail = multigrid.tail.iter().find(|one| one.solve == group.solve);
        count.note("several groups", group.groups > 1);
        count.note("a tail of several levels", tail.is_some_and(|tail| tail.groups > 2));
        count.note("a tail of one level", tail.is_some_and(|tail| tail.groups == 1));
    }
    count.note("several groups of a coarser level", multigrid.wide[0].iter().any(|group| group.groups > 1));
    count.note("a third level", multigrid.edges.get(1).is_some_and(|edges| edges.len() > GROUP));
    for parents in &multigrid.parents {
        let all = parents.weights.iter().filter(|weight| **weight > 0.0).count();
        for (number, what) in ["none", "one", "two", "three", "four"].into_iter().enumerate() {
            count.note(what, all == number);
        }
    }
    count.note("a slot without a spring", multigrid.slot_springs.iter().any(|spring| spring.k == 0.0));
    count.note("an edge of many", multigrid.edges.iter().flatten().any(|edge| edge.count > 4));
    count.check();
}
