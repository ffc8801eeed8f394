//! What cannot be attached is refused with words.

use super::{bob, panel};
use crate::common::{scene_error, warnings};
use taffeta::scene::{Closing, Pin, Scene, Seam, SeamSide, Select};
use taffeta::{Options, Simulation};

/// A scene with a seam is refused, at `path`, with these words.
#[track_caller]
fn refused(seam: Seam, path: &str, words: &str) {
    let scene = Scene::new("").body(panel("a", 5, [0.0; 3])).body(panel("b", 4, [1.0, 0.0, 0.0])).seam(seam);
    let error = scene_error(Simulation::new(&scene, &Options::default()));
    assert_eq!(error.path, path, "{error}");
    assert!(error.message.contains(words), "{error}");
}

fn good() -> Seam {
    Seam::pairs("a", "b", [[4, 0]])
}

#[test]
fn seams_join_bodies_that_exist_by_nodes_that_exist() {
    refused(Seam::pairs("a", "c", [[0, 0]]), "seam[0].to.body", "there is no body `c`; `a`, `b` would do");
    refused(
        Seam::pairs("a", "b", [[0, 16]]),
        "seam[0].pairs[0][1]",
        "is 16, and body `b` has vertices 0 to 15",
    );
    refused(Seam::pairs("a", "a", [[3, 7], [2, 2]]), "seam[0]", "sews vertex 2 of body `a` to itself");
    refused(Seam::pairs("a", "b", []), "seam[0].pairs", "is empty");
    let twice = "sews vertex 3 of body `a` to vertex 1 of body `b` twice; once would do";
    refused(Seam::pairs("a", "b", [[3, 1], [4, 0], [3, 1]]), "seam[0]", twice);
    let reversed = "sews vertex 7 of body `a` to vertex 3 of body `a` twice";
    refused(Seam::pairs("a", "a", [[3, 7], [7, 3]]), "seam[0]", reversed);
    let side = |name: &str, select| SeamSide::new(name, select);
    let unequal = Seam::new(side("a", Select::cols(0, 0)), side("b", Select::cols(0, 0)));
    refused(unequal, "seam[0].to.select", "selects 4 nodes, and from.select 5; as many on both sides");
    let beyond = Seam::new(side("a", Select::cols(5, 5)), side("b", Select::cols(0, 0)));
    refused(beyond, "seam[0].from.select.cols", "");
}

#[test]
fn a_pair_belongs_to_one_seam_and_pairs_that_are_held_are_told() {
    let scene = |pairs: [[u32; 2]; 2]| {
        let held = |name, z| panel(name, 5, [0.0, 0.0, z]).pin(Select::nodes([0, 1]));
        let [first, second] = pairs.map(|pair| Seam::pairs("a", "b", [[4, 4], pair]));
        let second = Seam { pairs: Some(vec![pairs[1]]), ..second };
        Scene::new("").body(held("a", 0.0)).body(held("b", 0.1)).seam(first).seam(second)
    };
    let built = |pairs| Simulation::new(&scene(pairs), &Options::default());
    let error = scene_error(built([[3, 3], [4, 4]]));
    assert_eq!(error.path, "seam[1]");
    assert!(error.message.contains("to vertex 4 of body `b` as seam[0] does"), "{error}");
    let simulation = built([[0, 1], [0, 3]]).expect("it is built");
    assert_eq!(simulation.seam_pair_counts(), [1, 1]);
    let told = warnings(&simulation).join("\n");
    assert!(
        told.contains("seam[0]: pins hold both nodes of 1 of its 2 pairs") && !told.contains("seam[1]"),
        "{told}"
    );
}

#[test]
fn pairs_are_given_in_one_way() {
    refused(Seam { reach: Some(0.1), ..good() }, "seam[0]", "has pairs and reach");
    refused(Seam { pairs: None, ..good() }, "seam[0].from", "has no select; two selections, pairs or reach");
    let from = SeamSide::new("a", Select::cols(0, 0));
    refused(Seam { from, ..good() }, "seam[0].from.select", "says which nodes, as pairs do");
    let reach = |reach| Seam { pairs: None, reach: Some(reach), ..good() };
    refused(reach(0.01), "seam[0].reach", "is 0.01 m, and no node of `a` is so near to one of `b`");
    refused(reach(-1.0), "seam[0].reach", "is -1 m, more than 0");
}

#[test]
fn numbers_of_seams_are_those_of_things() {
    refused(Seam { length: -0.1, ..good() }, "seam[0].length", "is -0.1 m, 0 or more");
    refused(Seam { k: Some(0.0), ..good() }, "seam[0].k", "is 0 N/m, more than 0");
    refused(Seam { break_force: Some(-3.0), ..good() }, "seam[0].break_force", "is -3 N, more than 0");
    refused(
        Seam { close: Closing { start: 1.0, end: 1.0 }, ..good() },
        "seam[0].close.end",
        "later than that",
    );
    refused(
        Seam { close: Closing { start: 0.0, end: 1e-9 }, ..good() },
        "seam[0].close.end",
        "is 1e-9 s after the start, less than a sub-step of",
    );
    let late = Seam { close: Closing { start: 0.7, ..Closing::default() }, ..good() };
    refused(
        late,
        "seam[0].close.start",
        "is 0.7 s, and the seam is closed at 0.5 s where close.end does not",
    );
    refused(Seam { close: Closing { start: -1.0, end: 1.0 }, ..good() }, "seam[0].close.start", "is -1 s");
}

#[test]
fn tethers_need_nodes_that_are_held_for_good() {
    let refused = |body, path: &str, words: &str| {
        let error = scene_error(Simulation::new(&Scene::new("").body(body), &Options::default()));
        assert_eq!(error.path, path, "{error}");
        assert!(error.message.contains(words), "{error}");
    };
    refused(
        panel("a", 5, [0.0; 3]).tether(0.0),
        "body[0].tethers",
        "has no pins; a pin that does not break would do",
    );
    let breaking = panel("a", 5, [0.0; 3]).pin_breaking(Select::nodes([0]), 1.0);
    refused(breaking.tether(0.0), "body[0].tethers", "has only pins that break");
    refused(bob("a", [0.0; 3], 1.0).tether(-0.5), "body[0].tethers.slack", "is -0.5, 0 or more");
    let mut free = bob("a", [0.0; 3], 1.0);
    free.pins.push(Pin { select: Select::nodes([0]), break_force: Some(0.0), ..Pin::default() });
    refused(free, "body[0].pin[1].break_force", "is 0 N, more than 0");
}
