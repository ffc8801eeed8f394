//! Surfaces that start through each other come apart, and then stay so.

use crate::common::{V, build_as, positions, run, turned, warnings};
use std::f64::consts::TAU;
use taffeta::scene::{
    Body, Collider, ConstraintForm, ContactForm, Cuboid, Cylinder, Icosphere, Mass, Material, Mesh, Method,
    Place, Scene, Select, SelfCollision,
};
use taffeta::topology::{Surface, shapes};
use taffeta::{Precision, Simulation};

const THICK: f64 = 0.004;

fn touching(body: Body) -> Body {
    let touch = SelfCollision {
        form: ContactForm::Triangles,
        thickness: THICK,
        friction: 0.2,
        ..SelfCollision::default()
    };
    Body { self_collision: Some(touch), ..body }
}

/// A sheet of so many nodes along each side, every 2 cm.
fn sheet(name: &str, nodes: u32, place: Place) -> Body {
    let size = f64::from(nodes - 1) * 0.02;
    let body = Body::cloth(name, Mesh::grid(nodes, nodes, [size; 2])).with_mass(Mass::Node(1e-4));
    let body = touching(body.structural(25.0, 0.003).shear(12.0, 0.003).bend(1.0, 1e-3));
    Body { place, ..body }
}

fn at(place: V) -> Place {
    turned([0.0, 1.0, 0.0], 0.0, place)
}

/// Bodies without weight, unless they have some.
fn scene(bodies: Vec<Body>) -> Scene {
    let mut scene = Scene::new("tangled").time(1.0 / 60.0, 5e-4);
    scene.world.gravity = [0.0; 3];
    scene.world.drag = 5e-4;
    scene.bodies = bodies;
    scene
}

/// As fabric, with so many implicit steps a frame.
fn implicit(mut scene: Scene, steps: u32) -> Scene {
    for body in &mut scene.bodies {
        *body = Body { place: body.place.clone(), ..touching(Body::cloth(&body.name, body.mesh.clone())) };
        body.material = Some(Material::preset("cotton"));
    }
    scene = scene.method(Method::Ice).time(1.0 / 60.0, 1.0 / (60.0 * f64::from(steps)));
    scene.solver.ice.form = ConstraintForm::Primal;
    scene
}

fn build(scene: &Scene) -> Simulation {
    build_as(scene, Precision::F32, 2)
}

/// Runs until nothing intersects, and the rest of so many frames. The report counts what the oracle counts.
fn comes_free(scene: &Scene, within: u32, what: &str) -> Simulation {
    let mut simulation = build(scene);
    assert!(simulation.intersections().pairs > 10, "{what} starts tangled");
    let mut free = None;
    for frame in 1..=within + 20 {
        run(&mut simulation, 1);
        let (found, report) = (simulation.intersections().pairs, simulation.report());
        match free {
            None => assert_eq!(report.intersections, Some(found), "{what}, frame {frame}"),
            Some(_) => assert_eq!((report.intersections, found), (None, 0), "{what}, frame {frame}"),
        }
        free = free.or((found == 0).then_some(frame));
    }
    assert!(free.is_some_and(|frame| frame <= within), "{what} is free in frame {free:?}");
    simulation
}

/// Two sheets that cross each other in the middle, at so many degrees.
fn crossed(degrees: f64) -> [Body; 2] {
    let other = turned([1.0, 0.0, 0.0], degrees, [0.0, 0.012, 0.003]);
    [sheet("one", 16, at([0.0; 3])), sheet("other", 16, other)]
}

#[test]
fn sheets_that_cross_each_other_come_apart() {
    comes_free(&scene(crossed(20.0).into()), 40, "springs");
    comes_free(&implicit(scene(crossed(20.0).into()), 4), 60, "fabric");
}

#[test]
fn a_tip_comes_back_and_sheets_that_are_stuck_into_each_other_part() {
    let tip = turned([1.0, 0.0, 1.0], 80.0, [0.0, 0.06, 0.0]);
    let through_the_middle = || vec![sheet("one", 18, at([0.0; 3])), sheet("tip", 10, tip.clone())];
    comes_free(&scene(through_the_middle()), 30, "a tip");
    comes_free(&implicit(scene(through_the_middle()), 1), 60, "a tip of fabric");
    // Two cards: the line ends at a border of each.
    let card = turned([1.0, 0.0, 0.0], 60.0, [0.16, 0.01, 0.003]);
    comes_free(&scene(vec![sheet("one", 16, at([0.0; 3])), sheet("card", 16, card)]), 60, "cards");
}

#[test]
fn layers_that_poke_through_each_other_in_many_places_find_their_order() {
    // The upper one has waves that reach below the lower one.
    let mut waves = shapes::surface(&Mesh::grid(30, 30, [0.58, 0.58])).expect("a grid");
    for x in &mut waves.nodes {
        x[1] = 0.003 + 0.006 * (TAU * x[0] / 0.16).sin() * (TAU * x[2] / 0.16).sin();
    }
    let upper = Body::cloth("upper", Mesh::Surface(std::sync::Arc::new(waves))).with_mass(Mass::Node(1e-4));
    let upper = touching(upper.structural(25.0, 0.003).bend(1.0, 1e-3));
    let simulation =
        comes_free(&scene(vec![sheet("lower", 28, at([0.007, 0.0, 0.005])), upper]), 30, "waves");
    let x = positions(&simulation);
    let mean = |some: &[V]| some.iter().map(|x| x[1]).sum::<f64>() / some.len() as f64;
    let (lower, upper) = (mean(&x[..784]), mean(&x[784..]));
    assert!(upper - lower > 0.9 * THICK, "the order of most is that of all: {lower} {upper}");
}

/// A ribbon of 1.2 m by 0.3 m whose middle half is bent by so many degrees, flat at rest; each metre along it is so far aside.
fn ribbon(degrees: f64, aside: f64) -> Body {
    let flat = shapes::grid_surface(61, 17, [0.3, 1.2]);
    let rest = flat.triangles.iter().map(|t| t.map(|node| flat.nodes[node as usize])).collect();
    let places = flat.nodes.iter().map(|x| {
        let (along, steps) = (x[2], 600);
        let turn = degrees.to_radians();
        let ds = along / f64::from(steps);
        let bent = (0..steps).fold([0.0; 2], |[p, q], step| {
            let s = (f64::from(step) + 0.5) * ds;
            let angle = turn * (s / 0.6).clamp(-0.5, 0.5);
            [p + angle.cos() * ds, q + angle.sin() * ds]
        });
        [bent[0], bent[1], x[0] + aside * along]
    });
    let nodes: Vec<V> = places.collect();
    let surface = Surface { vertices: nodes.clone(), nodes, rest: Some(rest), ..flat };
    let body = Body::cloth("ribbon", Mesh::Surface(std::sync::Arc::new(surface))).with_mass(Mass::Whole(0.1));
    touching(body.structural(60.0, 0.01).bend(2.0, 0.002))
}

#[test]
fn ribbons_that_cross_themselves_come_free() {
    comes_free(&scene(vec![ribbon(300.0, 0.0)]), 45, "a loop");
    // More than a turn, wound into itself: a little is left at last that has no clear sides. About two of five come free in time;
    // none did while sides were all that counted.
    let coils = [365.0, 385.0, 405.0, 425.0].map(|degrees| [(degrees, 0.045), (degrees, 0.1)]).concat();
    let free = coils.iter().filter(|&&(degrees, aside)| {
        let mut simulation = build(&scene(vec![ribbon(degrees, aside)]));
        (0..80).any(|_| {
            run(&mut simulation, 1);
            simulation.intersections().pairs == 0
        })
    });
    let count = free.count();
    assert!(count >= 2, "{count} of {} coils come free", coils.len());
}

#[test]
fn what_is_pinned_stays_on_its_side() {
    // The larger part of the upright sheet is above the level one. Pinned below, it goes through; else the part below does.
    let ends_above = |is_pinned: bool| {
        let mut upright = sheet("upright", 10, turned([1.0, 0.0, 0.0], 90.0, [0.001, 0.03, 0.002]));
        let ends = [0, 9].map(|row| positions(&build(&scene(vec![upright.clone()])))[10 * row][1]);
        assert!(ends[0].min(ends[1]) < -0.05 && ends[0].max(ends[1]) > 0.1, "{ends:?}");
        let [low, high] = if ends[0] < ends[1] { [0, 9] } else { [9, 0] };
        if is_pinned {
            upright = upright.pin(Select::rows(low as u32, low as u32));
        }
        let simulation =
            comes_free(&scene(vec![sheet("level", 16, at([0.0; 3])), upright]), 60, "upright and level");
        let x = positions(&simulation);
        // A free level sheet hangs over what has gone through it like a tent.
        let highest = |some: &[V]| some.iter().map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max);
        highest(&x[256 + 10 * high..][..10]) > highest(&x[..256])
    };
    assert!(ends_above(false));
    assert!(!ends_above(true));
}

/// A sheet across a collider.
fn across(collider: Collider) -> Scene {
    let mut scene = scene(vec![sheet("sheet", 24, at([0.0, 0.03, 0.0]))]).collider(collider);
    scene.world.gravity = [0.0, -9.81, 0.0];
    scene
}

fn half_box() -> Collider {
    let cuboid = Cuboid { center: [0.0; 3], half: [0.12, 0.1, 0.12] };
    let place = turned([1.0, 0.3, 0.2], 20.0, [0.0; 3]);
    Collider { cuboid: Some(cuboid), place, friction: 0.3, ..Collider::default() }
}

#[test]
fn a_sheet_that_starts_across_a_collider_leaves_it_on_one_side() {
    for (what, collider) in [("ball", Collider::sphere([0.0; 3], 0.12)), ("box", half_box())] {
        let mut simulation = build(&across(collider));
        run(&mut simulation, 30);
        let stretch = simulation.report().max_stretch;
        assert_eq!(simulation.intersections().pairs, 0, "{what}");
        // Each node by its shortest way is torn over the sides of the box: 3.2 times as long.
        assert!(stretch < 1.3, "{what} stretches it {stretch}");
        let lowest = positions(&simulation)[24 * 11..24 * 13].iter().map(|x| x[1]).fold(0.0, f64::max);
        assert!(lowest > 0.1, "{what}: its middle is on top, at {lowest}");
    }
}

#[test]
fn tight_tubes_over_a_ball_and_each_other_are_led_out_by_the_solver() {
    let tube = |name: &str, radius: f64, segments: u32, place| {
        let tube = Cylinder { radius, height: 0.2, segments, rings: 8, capped: false };
        Body { place, ..Body::cloth(name, Mesh::Cylinder(tube)) }
    };
    // Nodes took the side of the nearest line for theirs once: then two in three of such tubes never came free.
    for shift in [0.0, 7e-5] {
        let shirt = tube("shirt", 0.1, 24, at([0.0, 0.02, 0.0]));
        let jacket = tube("jacket", 0.103, 20, turned([1.0, 0.0, 0.3], 4.0, [0.003 + shift, 0.03, 0.002]));
        let ball = Mesh::Icosphere(Icosphere { radius: 0.102, subdivisions: 3 });
        let torso = Collider { mesh: Some(ball), offset: 0.004, ..Collider::default() };
        let scene = implicit(scene(vec![shirt, jacket]).collider(torso), 4);
        let simulation = comes_free(&scene, 10, "tubes");
        // With impulses after the solver alone they take 40 frames.
        assert!(simulation.report().max_stretch < 1.15, "{}", simulation.report().max_stretch);
    }
}

#[test]
fn a_run_that_is_restored_while_surfaces_come_apart_goes_on_alike() {
    for scene in [scene(crossed(20.0).into()), across(half_box())] {
        let mut whole = build_as(&scene, Precision::F32, 1);
        run(&mut whole, 3);
        let snapshot = whole.snapshot();
        assert!(snapshot.is_tangled);
        run(&mut whole, 40);
        assert!(!whole.snapshot().is_tangled);
        for threads in [1, 2, 3] {
            let mut again = build_as(&scene, Precision::F32, threads);
            again.restore(&snapshot).unwrap();
            run(&mut again, 40);
            assert_eq!(again.state_hash(), whole.state_hash(), "{threads} threads");
        }
    }
}

#[test]
fn surfaces_that_start_through_each_other_are_warned_of() {
    let simulation = build(&scene(crossed(70.0).into()));
    let pairs = simulation.intersections().pairs;
    let all = warnings(&simulation);
    let wanted = format!("surfaces start through each other: {pairs} pairs");
    assert!(pairs > 0 && all.iter().any(|warning| warning.contains(&wanted)), "{all:?}");
    assert_eq!(simulation.report().intersections, Some(pairs));
    let apart = build(&scene(vec![sheet("one", 6, at([0.0; 3])), sheet("other", 6, at([0.0, 0.02, 0.0]))]));
    assert!(warnings(&apart).iter().all(|warning| !warning.contains("through each other")));
    assert_eq!(apart.report().intersections, None);
    let words = warnings(&build(&across(half_box()))).join("\n");
    assert!(words.contains("inside collider") && words.contains("led out"), "{words}");
}
