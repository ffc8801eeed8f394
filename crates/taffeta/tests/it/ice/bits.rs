//! The same bits however a scene runs, and what is remembered from one frame to the next.

use super::{stiffen, with_acad, with_ice};
use crate::common::alike::{self, PLAIN, SHAKEN};
use crate::common::levels;
use taffeta::scene::{Acad, Collider, ConstraintForm, Ice, Method, Scene};

/// They land, and hang.
fn bodies() -> Scene {
    let mut scene = Scene::new("bits").time(0.01, 0.005).collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    scene.bodies = alike::moving().to_vec();
    scene.bodies.iter_mut().for_each(|body| stiffen(body, 3.0));
    scene
}

/// Loose and few iterations, so that what they start from shows.
fn scenes() -> [Scene; 3] {
    let rough = Ice { tolerance: 1e-3, max_iterations: 5, ..Ice::default() };
    let mut ice = bodies();
    ice.bodies.iter_mut().for_each(|body| stiffen(body, 100.0));
    let acad = Acad { threshold: 0.01, release: 0.005, target: 0.002, ..Acad::default() };
    let printed = Acad { form: ConstraintForm::Printed, ..acad.clone() };
    [
        with_ice(ice, rough.clone()),
        with_acad(bodies(), acad, rough.clone()),
        with_acad(bodies(), printed, Ice { max_iterations: 3, warm_start: false, ..rough }),
    ]
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    SHAKEN.with_any_threads(&scenes(), |report| {
        let solver = &report.solver;
        solver.iterations > 2 && solver.active_fraction > 0.05 && report.contacts > 0
    });
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    SHAKEN.print_hashes(&scenes());
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("ice::bits::prints_hashes", 6);
}

#[test]
fn each_body_moves_as_if_it_were_alone_and_in_any_order() {
    PLAIN.alone_and_in_any_order(&scenes());
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    SHAKEN.restored(&scenes());
}

#[test]
fn pulls_and_constraints_are_remembered_and_nothing_else() {
    let both = alike::needs_no_more_than_the_state;
    let [ice, acad, _] = scenes();
    let cold = |mut scene: Scene| {
        scene.solver.ice.warm_start = false;
        scene
    };
    // With what releases at the threshold, springs are what their lengths say.
    let at_once = |mut scene: Scene| {
        scene.solver.acad.release = scene.solver.acad.threshold;
        scene
    };
    assert!(!both(&ice), "pulls of ICE");
    assert!(!both(&cold(ice.clone())), "pulls of ICE, by which surfaces go");
    let free = Scene { colliders: Vec::new(), ..ice };
    assert!(both(&cold(free)), "ICE without them");
    assert!(!both(&at_once(acad.clone())), "pulls of ACAD");
    assert!(!both(&cold(acad.clone())), "constraints of ACAD");
    assert!(both(&cold(at_once(acad.clone()))), "ACAD without both");
    let mut springs = acad;
    springs.solver.method = Method::Springs;
    assert!(both(&springs), "springs");
}
