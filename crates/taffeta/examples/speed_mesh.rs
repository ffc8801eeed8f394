use taffeta::scene::*;
use taffeta::*;
fn main() {
    let threads: usize = std::env::args().nth(1).map_or(2, |s| s.parse().unwrap());
    let mut scene = Scene::new("bench").time(1.0 / 30.0, 1e-3).body(
        Body::soft("t", Mesh::Torus(Torus { major: 1.0, minor: 0.4, rings: 820, segments: 410 }))
            .with_mass(Mass::Node(0.01))
            .structural(100.0, 0.05),
    );
    scene.world.gravity = [0.0; 3];
    let mut sim = Simulation::new(&scene, &Options { threads: Some(threads), ..Default::default() }).unwrap();
    println!(
        "{} largest {:.3e} mem {} {:?}",
        sim.device(),
        sim.largest_stable_step(),
        sim.memory(),
        sim.bodies()[0].springs
    );
    sim.disturb(1e-4, 1);
    let frames = 12;
    sim.step().unwrap();
    let mut times = Vec::new();
    for _ in 0..frames {
        let t = std::time::Instant::now();
        sim.step().unwrap();
        times.push(t.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let median = times[times.len() / 2];
    let n = sim.bodies()[0].springs[0].1;
    println!(
        "{:.3} ms/frame (min {:.3}), {:.1} M springs/s, hash {:016x}",
        median * 1e3,
        times[0] * 1e3,
        n as f64 * 34.0 / median / 1e6,
        sim.state_hash()
    );
}
