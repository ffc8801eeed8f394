//! Cloth is pulled through a ring.

use super::reference::Form;
use crate::common::{build_as, positions, run};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Keyframe, Mass, Mesh, Scene, Select, Torus};

#[test]
fn cloth_pulled_through_a_ring_comes_out_whole() {
    let ring = Torus { major: 0.21, minor: 0.1, rings: 24, segments: 12 };
    let ring = Collider::mesh(Mesh::Torus(ring)).offset(0.01).friction(0.1);
    let form = Form::of(&ring);
    let pins =
        [7, 8, 9].into_iter().flat_map(|row| [7, 8, 9].map(|col| row * 17 + col)).collect::<Vec<u32>>();
    let up = vec![Keyframe::translate(2.0, [0.0, 1.6, 0.0])];
    let cloth = Body::cloth("cloth", Mesh::grid(17, 17, [0.8, 0.8]))
        .at([0.0, -0.2, 0.0])
        .with_mass(Mass::Node(0.004))
        .structural(800.0, 0.3)
        .shear(400.0, 0.15)
        .bend(2.0, 0.01)
        .pin_moving(Select::nodes(pins), up);
    let scene = Scene::new("ring").time(0.02, 5e-4).body(cloth).collider(ring);
    for (precision, slack) in [(Precision::F64, 1e-12), (Precision::F32, 1e-6)] {
        let mut simulation = build_as(&scene, precision, 1);
        let (mut contacts, mut stretch) = (0, 0.0_f64);
        for frame in 0..105 {
            run(&mut simulation, 1);
            for x in positions(&simulation) {
                let off = form.distance(x) - 0.01;
                assert!(off >= -slack, "{precision}, frame {frame}: {x:?} is {:e} m inside", -off);
            }
            contacts = contacts.max(simulation.report().contacts);
            stretch = stretch.max(simulation.report().max_stretch);
        }
        let lowest = positions(&simulation).iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        println!("{precision}: lowest {lowest}, stretch {stretch}, {contacts} contacts");
        assert!(lowest > 0.11, "{precision}: a node is left at {lowest} m");
        assert!(stretch < 1.5 && contacts > 20, "{precision}: stretched to {stretch}, {contacts} contacts");
    }
}
