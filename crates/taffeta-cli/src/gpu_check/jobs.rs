//! What is measured: scenes and choices of kernels, the most telling first.

use crate::bench::{kernels, scenes};
use taffeta::GpuKernels;
use taffeta::scene::{Body, Collider, Icosphere, Mass, Mesh, Scene, Torus};

/// How far nodes start from their places [m].
pub const DISTURBANCE: f64 = 1e-3;
/// Of each node [kg].
const NODE_MASS: f64 = 1e-3;
/// Of each spring [N/m] and [kg/s].
const SPRING: (f64, f64) = (60.0, 0.01);
/// The grid of Va, Choi and Hong 2021: rows and columns.
pub const LARGEST_OF_2021: [u32; 2] = [1368, 5717];
/// Subdivisions of an icosphere of 162 nodes.
const BALL: u32 = 2;

/// One measurement.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    pub part: &'static str,
    pub kernels: GpuKernels,
    /// A grid's rows and columns, a torus's rings and segments, or a number of balls and the nodes of each.
    pub n: [u32; 2],
}

/// All measurements; where time is short, small ones.
pub fn all(small: bool) -> Vec<Job> {
    let (sides, compared): (&[u32], &[u32]) = if small {
        (&[32, 64, 128], &[32, 64])
    } else {
        (&[32, 64, 128, 160, 256, 512, 1024, 2048, 4096], &[32, 160, 512, 2048])
    };
    let best = |part, n| Job { part, kernels: GpuKernels::Best, n };
    let mut jobs = Vec::new();
    if !small {
        jobs.push(best("grid", LARGEST_OF_2021));
    }
    jobs.extend(sides.iter().map(|&side| best("grid", [side, side])));
    for &side in compared {
        jobs.extend(kernels::ALL.map(|kernels| Job { part: "kernels", kernels, n: [side, side] }));
    }
    // Three edges a node: a million springs, or twenty thousand.
    jobs.push(best("mesh", if small { [120, 56] } else { [1000, 334] }));
    let balls = [if small { 8 } else { 64 }, 162];
    jobs.extend([GpuKernels::Best, GpuKernels::Plain].map(|kernels| Job {
        part: "bodies",
        kernels,
        n: balls,
    }));
    jobs
}

impl Job {
    /// The job for people.
    pub fn name(&self) -> String {
        let [a, b] = self.n;
        format!("{} {a}×{b}, {}", self.part, kernels::name(self.kernels))
    }

    /// What is run.
    pub fn scene(&self) -> Scene {
        match self.part {
            "mesh" => torus(self.n),
            "bodies" => balls(self.n[0]),
            _ => sheet(self.n),
        }
    }
}

/// The sheet of `taffeta bench grid`, without gravity: one of tens of metres would fall out of its shape, and the arithmetic
/// is the same.
pub fn sheet([rows, cols]: [u32; 2]) -> Scene {
    let mut scene = scenes::grid(rows, cols).scene;
    scene.world.gravity = [0.0; 3];
    scene
}

fn torus([rings, segments]: [u32; 2]) -> Scene {
    let mesh = Mesh::Torus(Torus { major: 1.0, minor: 0.4, rings, segments });
    let (k, d) = SPRING;
    let mut scene = Scene::new("torus").time(scenes::FRAME.0, scenes::FRAME.1);
    scene.world.gravity = [0.0; 3];
    scene.body(Body::cloth("torus", mesh).with_mass(Mass::Node(NODE_MASS)).structural(k, d))
}

/// Balls in a row that fall onto a floor.
fn balls(count: u32) -> Scene {
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let mut scene = Scene::new("balls").collider(floor).time(scenes::FRAME.0, scenes::FRAME.1);
    for index in 0..count {
        let mesh = Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: BALL });
        let ball = Body::cloth(format!("ball {index}"), mesh).with_mass(Mass::Node(NODE_MASS));
        let ball = ball.structural(SPRING.0, SPRING.1).bend(SPRING.0, SPRING.1);
        scene = scene.body(ball.at([0.3 * f64::from(index), 0.15, 0.0]));
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_measurement_is_made_twice_and_the_largest_grid_comes_first() {
        for small in [false, true] {
            let mut names: Vec<String> = all(small).iter().map(Job::name).collect();
            assert_eq!(names[0] == "grid 1368×5717, best", !small);
            let count = names.len();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), count);
        }
    }
}
