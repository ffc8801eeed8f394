//! Elements other than springs that are solved for: hinges.

use super::{accurate, newton, with};
use crate::common::compare::{compare_for, reference, scene};
use crate::common::lists::{edges, lumped};
use crate::common::{build, build_as, positions, run, surface, turned};
use taffeta::Precision;
use taffeta::scene::{Body, Ice, Icosphere, Mass, Mesh, Scene, Select};

/// A square metre of 0.2 kg in n × n nodes that hangs by a row, whatever n is the same cloth.
fn sheet(n: u32, k: f64, hinge: f64) -> Body {
    let body = Body::cloth("sheet", Mesh::grid(n, n, [1.0, 1.0])).with_mass(Mass::Whole(0.2));
    let mut body = body.structural(k, 0.0).shear(k, 0.0).hinge(hinge, 0.0).pin(Select::rows(0, 0));
    body.place = turned([1.0, 0.0, 0.0], 60.0, [0.0; 3]);
    body
}

fn ball(subdivisions: u32) -> Body {
    Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions }))
}

/// Iterations of a frame of 1/60 s at most, from nothing.
fn iterations(body: Body) -> u32 {
    let ice = Ice { tolerance: 1e-6, max_iterations: 1000, warm_start: false, ..newton(1) };
    let h = 1.0 / 60.0;
    let mut simulation = build_as(&with(Scene::new("").time(h, h).body(body), ice), Precision::F64, 2);
    simulation.disturb(1e-4, 3);
    let frame = |_| {
        run(&mut simulation, 1);
        simulation.report().solver.iterations
    };
    (0..3).map(frame).max().unwrap_or(0)
}

#[test]
fn sixteen_times_as_many_nodes_of_a_sheet_with_hinges_take_hardly_more_iterations() {
    for (k, hinge) in [(1e3, 1e-3), (1e5, 0.1)] {
        let found = [20, 80].map(|n| iterations(sheet(n, k, hinge)));
        assert!(found[0] > 5 && 3 * found[1] <= 5 * found[0] && found[1] < 35, "{k} {hinge}: {found:?}");
    }
}

#[test]
fn sixteen_times_as_many_nodes_of_a_ball_with_hinges_take_hardly_more_iterations() {
    let body = |subdivisions| ball(subdivisions).with_mass(Mass::Whole(1.0)).structural(1e5, 0.1);
    let found = [3, 5].map(|n| iterations(body(n).hinge(1e-3, 0.0).pin(Select::nodes([0]))));
    assert!(found[0] > 5 && 3 * found[1] <= 5 * found[0] && found[1] < 90, "{found:?}");
}

/// The system is made of hinges alone, and beside springs that are as stiff as wire; folds start at random.
#[test]
fn balls_with_hinges_move_as_their_systems_do() {
    for (k, newton_steps) in [(0.0, 1), (0.0, 3), (5e3, 1)] {
        let mut body = ball(1).with_mass(Mass::Area(0.3)).hinge(0.05, 1e-4).pin(Select::nodes([0, 3]));
        if k > 0.0 {
            body = body.structural(k, 0.2);
        }
        let scene = with(scene(body), accurate(newton_steps));
        let simulation = build(&scene);
        let triangles = surface(&simulation, 0).triangles;
        let mass = lumped(&positions(&simulation), &triangles, 0.3);
        let mut reference = reference(&scene, &simulation, mass);
        reference.hinge(&triangles, [0.05, 1e-4]);
        if k > 0.0 {
            reference.join(edges(&triangles), [k, 0.2]);
        }
        reference.held.extend([0, 3]);
        compare_for(simulation, reference, 0.01, 10);
    }
}

/// Hinges that an explicit step would have to be 1/40 as long for.
#[test]
fn stiff_hinges_set_no_step_and_energy_falls() {
    let body = sheet(24, 1e3, 1.0);
    let h = 1.0 / 60.0;
    let mut scene = with(Scene::new("").time(h, h).body(body), newton(2));
    scene.world.gravity = [0.0; 3];
    let mut simulation = build_as(&scene, Precision::F64, 2);
    assert!(simulation.largest_stable_step_folded().is_infinite());
    simulation.disturb(5e-3, 7);
    let mut before = f64::INFINITY;
    for frame in 0..120 {
        run(&mut simulation, 1);
        let all = simulation.report().energy();
        assert!(all <= before * (1.0 + 1e-9), "frame {frame}: {before} J, then {all} J");
        before = all;
    }
}
