use taffeta::scene::*;
use taffeta::*;
fn main() {
    let n: u32 = std::env::args().nth(1).map_or(160, |s| s.parse().unwrap());
    let m: u32 = std::env::args().nth(2).map_or(n, |s| s.parse().unwrap());
    let threads: usize = std::env::args().nth(3).map_or(2, |s| s.parse().unwrap());
    let mut scene = Scene::new("bench").time(1.0 / 30.0, 1e-3).body(
        Body::cloth("sheet", Mesh::grid(n, m, [0.01 * m as f64, 0.01 * n as f64]))
            .with_mass(Mass::Node(0.01))
            .structural(100.0, 0.05)
            .shear(100.0, 0.05)
            .bend(100.0, 0.05)
            .pin(Select::nodes([0, m - 1])),
    );
    scene.world.gravity = [0.0; 3];
    let mut sim = Simulation::new(&scene, &Options { threads: Some(threads), ..Default::default() }).unwrap();
    println!("{} largest {:.3e} mem {}", sim.device(), sim.largest_stable_step(), sim.memory());
    sim.disturb(1e-3, 1);
    let frames = (60_000_000 / (n as usize * m as usize)).clamp(2, 200);
    sim.step().unwrap();
    let mut times = Vec::new();
    for _ in 0..frames {
        let t = std::time::Instant::now();
        sim.step().unwrap();
        times.push(t.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let median = times[times.len() / 2];
    println!(
        "{n}x{m}: {:.3} ms/frame (min {:.3}), {:.1} M particle-substeps/s, hash {:016x} {:?}",
        median * 1e3,
        times[0] * 1e3,
        (n * m) as f64 * 34.0 / median / 1e6,
        sim.state_hash(),
        sim.report()
    );
}
