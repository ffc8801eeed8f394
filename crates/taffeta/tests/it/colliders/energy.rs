//! Cloth that lies on triangles gains nothing.

use super::depth::data;
use super::reference::Faces;
use crate::common::{build_as, run};
use taffeta::Precision;
use taffeta::scene::{
    Body, Collider, ConstraintForm, Cube, Ice, Mass, Mesh, Method, Place, Scene, Solver, Torus,
};

fn cloth(height: f64) -> Body {
    Body::cloth("cloth", Mesh::grid(13, 13, [1.2, 1.2]))
        .at([0.02, height, 0.03])
        .with_mass(Mass::Node(0.01))
        .structural(80.0, 0.1)
        .shear(60.0, 0.1)
        .bend(5.0, 0.02)
}

fn solvers() -> [(f64, Solver); 3] {
    let ice = |form| Solver { method: Method::Ice, ice: Ice { form, ..Ice::default() }, ..Solver::default() };
    [
        (0.001, Solver::default()),
        (0.005, ice(ConstraintForm::Compliant)),
        (0.005, ice(ConstraintForm::Primal)),
    ]
}

fn grounds() -> [(&'static str, f64, Collider); 3] {
    let cube = Collider::mesh(Mesh::Cube(Cube { size: 0.7, divisions: 3 }));
    let torus = Collider::mesh(Mesh::Torus(Torus { major: 0.4, minor: 0.15, rings: 24, segments: 12 }));
    let sheet = Faces::of(&Mesh::grid(8, 8, [2.0, 2.0]));
    [
        ("cube", 0.37, cube),
        ("torus", 0.17, torus),
        ("sheet", 0.011, Collider::mesh(data(sheet.nodes, sheet.triangles))),
    ]
}

#[test]
fn cloth_at_rest_on_triangles_gains_no_energy_in_five_seconds() {
    for (name, height, ground) in grounds() {
        for (h, solver) in solvers() {
            let ground = ground.clone().placed(Place::default()).offset(0.01).friction(0.4);
            let mut scene = Scene::new(name).time(0.02, h).body(cloth(height)).collider(ground);
            scene.solver = solver.clone();
            let mut simulation = build_as(&scene, Precision::F64, 1);
            run(&mut simulation, 100);
            let start = simulation.report().energy();
            let (mut least, mut gain, mut kinetic) = (start, 0.0_f64, 0.0_f64);
            for _ in 0..250 {
                run(&mut simulation, 1);
                let energy = simulation.report().energy();
                (least, gain) = (least.min(energy), gain.max(energy - least));
                kinetic = kinetic.max(simulation.report().kinetic);
            }
            println!(
                "{name} {:?} {:?}: gains {gain:e} J, kinetic {kinetic:e} J, {start} J",
                solver.method, solver.ice.form
            );
            // Of 1 to 4 J; what is solved for is solved to 1e-3.
            let most = if solver.method == Method::Springs { 1e-9 } else { 2e-5 };
            assert!(gain < most, "{name}, {:?}: {gain:e} J", solver.method);
        }
    }
}
