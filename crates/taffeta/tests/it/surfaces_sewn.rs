//! Contact between triangles of what is sewn together.

use crate::common::{build, build_as, turned};
use crate::surfaces::{fabric, implicit, run_free, sheet};
use taffeta::Precision;
use taffeta::scene::{Body, Material, Scene, Seam, SeamSide, Select};

#[test]
fn what_is_sewn_together_does_not_pass_through_itself() {
    // Three panels along one seam, like an armpit: neither is sewn to both others.
    let row = |name: &str, row| SeamSide::new(name, Select::rows(row, row));
    let hanging = |name: &str, tilt: f64, [y, z]: [f64; 2]| Body {
        place: turned([1.0, 0.0, 0.0], tilt, [0.1, 0.4 + y, 0.3 + z]),
        ..fabric(name, [7, 7], [0.0; 3])
    };
    // Rounding puts nodes of a seam at places that are not quite the same.
    let mut scene = implicit(Scene::new("armpit"), 1.0 / 120.0);
    scene = scene.body(hanging("upper", 90.0, [0.064, 0.0]).pin(Select::rows(0, 0)));
    scene = scene
        .body(hanging("lower", 80.0, [-0.063, 0.014]).with_material(Material::preset("linen")))
        .body(hanging("aside", 110.0, [-0.06, -0.024]));
    scene = scene.seam(Seam::new(row("upper", 6), row("lower", 0)));
    scene = scene.seam(Seam::new(row("lower", 0), row("aside", 0)));
    let mut simulation = build_as(&scene, Precision::F32, 2);
    let touched = (0..40).map(|_| {
        run_free(&mut simulation, 1, "an armpit");
        simulation.report().pairs
    });
    assert!(touched.sum::<u64>() > 0);
}

#[test]
fn a_seam_hides_no_intersection_beside_it() {
    let count = |seam: Option<Seam>| {
        let mut through = sheet("through", [7, 7], [0.0; 3], 0.3);
        through.place = turned([1.0, 0.0, 0.1], 80.0, [0.003, 0.0, 0.001]);
        let scene = Scene::new("crossed").time(1.0 / 60.0, 5e-4).body(sheet("flat", [7, 7], [0.0; 3], 0.3));
        let scene = scene.body(through);
        build(&seam.into_iter().fold(scene, Scene::seam)).intersections().pairs
    };
    let all = count(None);
    assert!(all > 10, "{all}");
    // Corners that are far from each other, and nodes next to each other on the line along which the sheets cross.
    assert_eq!(count(Some(Seam::pairs("flat", "through", [[0, 48]]))), all);
    let beside = count(Some(Seam::pairs("flat", "through", [[24, 24]])));
    assert!(beside < all && beside > all / 2, "{beside} of {all}");
    let soft = Seam { k: Some(10.0), ..Seam::pairs("flat", "through", [[24, 24]]) };
    assert_eq!(count(Some(soft)), all);
}
