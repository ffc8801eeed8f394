//! A cloth over a ball, its held corner lifted and another pulled at: the README's tour.

use taffeta::glam::Vec3;
use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};
use taffeta::{Options, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A 32 × 32 cloth of 2 m × 2 m above a ball, held at one corner.
    let cloth = Body::cloth("cloth", Mesh::grid(32, 32, [2.0, 2.0]))
        .with_mass(Mass::Area(0.2))
        .at([0.0, 0.6, 0.0])
        .structural(200.0, 0.1)
        .shear(200.0, 0.1)
        .bend(20.0, 0.01)
        .pin(Select::nodes([0]));
    let scene = Scene::new("my first cloth")
        .time(1.0 / 60.0, 5e-4)
        .body(cloth)
        .collider(Collider::sphere([0.0, 0.0, 0.0], 0.5).friction(0.3));

    let mut simulation = Simulation::new(&scene, &Options::default())?;
    let cloth = simulation.body("cloth")?;
    let mut positions: Vec<Vec3> = Vec::new();
    for frame in 0..60 {
        // Lift the held corner, and pull at another for the first half second.
        simulation.pin_vertex(cloth, 0, [-1.0, 0.6 + 0.01 * f64::from(frame), -1.0])?;
        if frame < 30 {
            simulation.apply_force(cloth, 31, [0.0, 0.5, 0.0])?;
        }
        let report = simulation.step()?;
        println!("{:.3} s: {:.4} J, stretch {:.3}", report.time, report.energy(), report.max_stretch);
        simulation.positions_f32(&mut positions); // metres, in the mesh's own vertex order
    }
    Ok(())
}
