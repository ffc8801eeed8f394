//! A thickness in millimetres that was meant in metres is refused at once, whatever is within it.

use taffeta::scene::{Body, Collider, ContactForm, Icosphere, Mass, Mesh, Scene, SelfCollision};
use taffeta::{BuildError, Options, Simulation};

fn sheet(name: &str, n: u32, size: f64, thickness: f64, form: ContactForm) -> Body {
    let body = Body::cloth(name, Mesh::grid(n, n, [size, size])).with_mass(Mass::Area(0.2));
    let contact = SelfCollision { thickness, form, ..SelfCollision::default() };
    Body { self_collision: Some(contact), ..body.structural(10.0, 0.01) }
}

fn error(scene: &Scene) -> String {
    match Simulation::new(scene, &Options::default()) {
        Err(BuildError::Scene(error)) => format!("{}: {}", error.path, error.message),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it runs"),
    }
}

#[test]
fn a_thickness_that_has_another_body_within_it_is_refused_with_both_names() {
    for form in [ContactForm::Nodes, ContactForm::Triangles] {
        // Neither is too thick for itself.
        let coarse = sheet("coarse", 3, 30.0, 10.0, form);
        let fine = sheet("fine", 300, 1.0, 0.001, form).at([0.0, 0.5, 0.0]);
        for (bodies, number) in [([coarse.clone(), fine.clone()], 0), ([fine, coarse], 1)] {
            let said = error(&bodies.into_iter().fold(Scene::new("typed in mm"), Scene::body));
            assert!(said.starts_with(&format!("body[{number}].self_collision.thickness: is 10 m")), "{said}");
            let parts = ["body `fine` has 90000 nodes", "(mm are divided by 1000)"];
            assert!(parts.iter().all(|words| said.contains(words)), "{said}");
        }
    }
}

#[test]
fn many_bodies_within_each_others_thickness_are_refused() {
    for form in [ContactForm::Nodes, ContactForm::Triangles] {
        let scene = (0..800).fold(Scene::new("typed in mm"), |scene, number| {
            scene.body(sheet(&format!("leaf{number}"), 7, 0.3, 0.3, form).at([
                0.0,
                1e-3 * f64::from(number),
                0.0,
            ]))
        });
        assert!(
            error(&scene).contains("too many pairs of triangles or nodes within that distance at the start")
        );
    }
}

#[test]
fn an_offset_that_has_a_whole_sheet_within_it_is_refused() {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 6 });
    let ball = Collider { offset: 5.0, ..Collider::mesh(ball) };
    let cloth = sheet("cloth", 20, 6.0, 0.01, ContactForm::Triangles);
    let said = error(&Scene::new("typed in mm").body(cloth.at([0.0, 0.7, 0.0])).collider(ball));
    assert!(said.starts_with("collider[0].offset: is 5 m"), "{said}");
    assert!(said.contains("body `cloth` has 400 nodes"), "{said}");
}
