//! Strain along warp and weft, and shear, are those of the triangles.

use crate::common::{build, gpu, near, weightless};
use std::sync::Arc;
use taffeta::scene::{Body, Mass, Material, Mesh, Scene};
use taffeta::topology::shapes;
use taffeta::{Options, Simulation, StepError};

/// A sheet that is longer by 4 % along the warp, shorter by 2 % along the weft, and sheared by 0.1 rad, beside one at rest.
fn pulled() -> Scene {
    let mut surface = shapes::surface(&Mesh::sheet([0.4, 0.3], 0.01)).unwrap();
    let places = surface.triangles.iter().map(|triangle| triangle.map(|node| surface.nodes[node as usize]));
    surface.rest = Some(places.collect());
    let (sin, cos) = 0.1_f64.sin_cos();
    for place in surface.nodes.iter_mut().chain(&mut surface.vertices) {
        let [x, _, z] = *place;
        *place = [1.04 * x + 0.98 * sin * z, 0.0, 0.98 * cos * z];
    }
    let body = |name: &str, mesh| Body::cloth(name, mesh).with_material(Material::preset("cotton"));
    weightless("pulled", 1e-4, 1e-5)
        .body(body("sheet", Mesh::Surface(Arc::new(surface))))
        .body(body("grid", Mesh::grid(9, 11, [0.5, 0.4])).at([2.0, 0.0, 0.0]))
}

#[test]
fn a_sheet_pulled_by_a_known_stretch_reads_it() {
    let report = build(&pulled()).report().clone();
    let strain = report.strain.unwrap();
    let found = [strain.warp, strain.weft, [strain.shear, report.max_stretch]];
    for (found, wanted) in found.iter().flatten().zip([0.0, 0.04, -0.02, 0.0, 0.1, 1.04]) {
        near("strain", *found, wanted, 1e-12);
    }
    // Springs have none, and nothing else changes for them.
    let springs = Body::cloth("springs", Mesh::grid(3, 3, [0.2, 0.2])).with_mass(Mass::Area(0.2));
    let report = build(&weightless("", 0.01, 1e-3).body(springs.structural(50.0, 0.0))).report().clone();
    assert_eq!((report.strain, report.max_stretch), (None, 1.0));
}

#[test]
fn any_number_of_threads_and_a_gpu_read_the_same_strain() {
    let of = |options: Options| {
        let mut simulation = Simulation::new(&pulled(), &options).unwrap_or_else(|error| panic!("{error}"));
        let start = simulation.report().strain.unwrap();
        [start, simulation.advance(20).unwrap().strain.unwrap()]
    };
    let threads = |threads| of(Options { threads: Some(threads), ..Options::default() });
    let one = threads(1);
    assert_eq!(one, threads(3));
    let device = of(Options { gpu: Some(gpu().into()), ..Options::default() });
    assert_eq!(one[0], device[0]);
    let numbers =
        |all: &[taffeta::diagnostics::FabricStrain; 2]| [all[1].warp, all[1].weft, [all[1].shear; 2]];
    for (a, b) in numbers(&one).iter().flatten().zip(numbers(&device).iter().flatten()) {
        near("strain", *a, *b, 1e-4);
    }
}

#[test]
fn a_fabric_that_bursts_is_stopped() {
    let body = Body::cloth("sheet", Mesh::sheet([0.4, 0.3], 0.02)).with_material(Material::preset("cotton"));
    let limit = build(&weightless("", 1.0, 1.0).body(body.clone())).largest_stable_step();
    let mut simulation = build(&weightless("", 2.0 * limit, 2.0 * limit).body(body));
    simulation.disturb(1e-4, 5);
    let error = (0..1000).find_map(|_| simulation.step().err()).expect("the step is too long");
    let StepError::Diverged(error) = error else { panic!("{error}") };
    assert!(error.to_string().contains("the fabric is"), "{error}");
}
