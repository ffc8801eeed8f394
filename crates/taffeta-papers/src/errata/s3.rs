//! Errata of S3 but for its volume: time, sums, sizes.

use super::Erratum;
use super::finding::{Finding, NONE, found};
use super::vector::ball;
use crate::papers::paper::Paper;
use taffeta::topology::Edges;

pub fn errata() -> Vec<Erratum> {
    vec![EULER, ALGORITHM_3, FRAMES, SIZES, SPEED_UP]
}

const EULER: Erratum = Erratum {
    id: "s3-euler",
    paper: Paper::S3,
    place: "section III and eqs. 2 and 3; S1, section 4.3",
    printed: "\"explicit Euler is used as a time integration method\", with `x_i(t + Δt) = x_i(t) + Δt \
              v_i(t + Δt)`",
    corrected: "the equations are right; their name is semi-implicit, or symplectic, Euler",
    why: "Explicit Euler moves by the *old* velocity, and every undamped spring then gains energy at every \
          step, however short. Eq. 3 takes the new one, and the energy stays about what it was. Who \
          programs the name and not the equation gets another method.",
    setting: "A spring of 100 N/m with 1 kg, stretched by 0.1 m, 1,000 steps of 10 ms; energy at the end \
              over that at the start. Printed: the method of the name; corrected: eqs. 2 and 3.",
    model: "[integration](models/integration.md#source)",
    experiment: || {
        let energy = |new_velocity: bool| {
            let [mut x, mut v, h] = [0.1, 0.0, 0.01];
            for _ in 0..1000 {
                let old = v;
                v -= h * 100.0 * x;
                x += h * if new_velocity { v } else { old };
            }
            (50.0 * x * x + 0.5 * v * v) / 0.5
        };
        vec![found("energy over that at the start", energy(false), energy(true), NONE)]
    },
};

const ALGORITHM_3: Erratum = Erratum {
    id: "s3-algorithm3",
    paper: Paper::S3,
    place: "algorithm 3, lines 6 and 7; algorithm 4, line 9",
    printed: "`Force buffer[i1] = InterlockAdd(force)`, `Volume buffer[0] = InterlockAdd(volume)`",
    corrected: "add to the place and assign nothing; set it back to zero in each step",
    why: "An atomic sum hands out the value from before it. Assigned to the place that it was added to, \
          that takes the sum back. The text explains what is meant, a loop of compare and exchange. Where \
          sums start from zero again neither says.",
    setting: "Three springs pull at a node with 1, 2 and 3 N, one thread after the other; then again in the \
              next step.",
    model: "[GPU baselines](models/gpu-baselines.md#what-the-papers-print-and-what-we-changed)",
    experiment: || {
        let added = |steps: u32, assigns: bool, clears: bool| {
            let mut place = 0.0;
            for _ in 0..steps {
                place = if clears { 0.0 } else { place };
                for force in [1.0, 2.0, 3.0] {
                    let before = place;
                    place = if assigns { before } else { before + force };
                }
            }
            place
        };
        vec![
            found("force, taken by the letter [N]", added(1, true, false), added(1, false, true), 6.0),
            found(
                "force in the second step, without a zero [N]",
                added(2, false, false),
                added(2, false, true),
                6.0,
            ),
        ]
    },
};

const FRAMES: Erratum = Erratum {
    id: "s3-frames",
    paper: Paper::S3,
    place: "section V-B",
    printed: "\"we run all simulations with a fixed time step size of 0.0001\"; averages \"for 400 frames\"",
    corrected: "say how many steps a frame has, and what the nodes weigh",
    why: "With a step a frame 400 frames are 0.04 s, in which nothing falls as far as in the paper's \
          figures; with frames of 1/60 s each has 167 steps. Frame rates and losses of the two differ \
          widely, and cannot be compared with others as long as this is open.",
    setting: "400 frames of free fall. Printed: a step a frame; corrected: 1/60 s a frame, as one would show \
              it.",
    model: "[frames and sub-steps](models/integration.md#frames-and-sub-steps)",
    experiment: || {
        let h: f64 = 1e-4;
        let [once, shown] = [400.0 * h, 400.0 / 60.0];
        let fall = |t: f64| 0.5 * 9.81 * t * (t + h);
        vec![
            found("time of 400 frames [s]", once, shown, NONE),
            found("way of a free fall in it [m]", fall(once), fall(shown), NONE),
            found("steps in a frame", 1.0, (1.0 / 60.0 / h).ceil(), NONE),
        ]
    },
};

const SIZES: Erratum = Erratum {
    id: "s3-sizes",
    paper: Paper::S3,
    place: "section V-B",
    printed: "\"the mesh with a maximum resolution of 31K nodes and about 20K triangles\"",
    corrected: "a closed surface has about twice as many triangles as nodes: N nodes have 2N − 4 without holes \
             through the body",
    why: "Each triangle has three corners, and at each node at least three triangles meet, so there are at \
          least as many triangles as nodes on any closed surface. Perhaps nodes inside, of the tetrahedra \
          of TetGen, are counted, or the two numbers belong to two meshes.",
    setting: "Euler's formula for 31,000 nodes, and taffeta's ball of 20,480 triangles. Exact: edges \
              counted, nodes − edges + triangles = 2.",
    model: "[meshes](meshes.md)",
    experiment: sizes,
};

fn sizes() -> Vec<Finding> {
    let ball = ball(1.0, 5);
    let edges = Edges::new(ball.nodes.len(), &ball.triangles, &[]).pairs.len();
    let [nodes, triangles] = [ball.nodes.len(), ball.triangles.len()].map(|n| n as f64);
    vec![
        found("triangles of 31,000 nodes", 20_000.0, 2.0 * 31_000.0 - 4.0, NONE),
        found("triangles of 31,000 nodes, at least", 20_000.0, 31_000.0, NONE),
        found("nodes of about 20,000 triangles", 31_000.0, nodes, 2.0 + edges as f64 - triangles),
    ]
}

const SPEED_UP: Erratum = Erratum {
    id: "s3-speed-up",
    paper: Paper::S3,
    place: "section VI, against the abstract and section V-B",
    printed: "\"the average speedup of factor 2.53\"; \"an average of 95.35 for the conventional MSM\"",
    corrected: "2.54, as in the other two places; 95.35 %",
    why: "One of the two is rounded otherwise. Of the five models behind the mean the text prints both \
          rates for two only, so it cannot be computed again.",
    setting: "What the text prints: frames a second of the armadillo (54.5 and 28.19) and the dragon (39.39 \
              and 9.42), GPU over CPU.",
    model: "speeds of its own, in [results](results/README.md)",
    experiment: || {
        vec![
            found("mean speed-up with the volume constraint", 2.53, 2.54, NONE),
            found("of these, the armadillo", NONE, 54.5 / 28.19, NONE),
            found("of these, the dragon", NONE, 39.39 / 9.42, NONE),
        ]
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_method_of_the_name_gains_energy_and_that_of_the_equations_does_not() {
        let energy = (EULER.experiment)()[0].clone();
        // Each step multiplies the energy by 1 + h² k/m.
        assert!((energy.printed.unwrap() / 1.01f64.powi(1000) - 1.0).abs() < 1e-9);
        assert!((0.9..1.1).contains(&energy.corrected.unwrap()), "{energy:?}");
    }

    #[test]
    fn an_assigned_sum_is_lost_and_one_without_zero_is_kept() {
        let [letter, again] = (ALGORITHM_3.experiment)().try_into().unwrap();
        assert_eq!([letter.printed, letter.corrected, again.printed], [Some(0.0), Some(6.0), Some(12.0)]);
    }

    #[test]
    fn a_step_a_frame_falls_some_millimetres() {
        let [_, fall, steps] = (FRAMES.experiment)().try_into().unwrap();
        assert!((fall.printed.unwrap() - 0.007_867_62).abs() < 1e-9);
        assert_eq!(steps.corrected, Some(167.0));
    }

    #[test]
    fn a_ball_has_twice_as_many_triangles_as_nodes_less_four() {
        let nodes = sizes()[2].clone();
        assert_eq!([nodes.corrected, nodes.exact], [Some(10_242.0); 2]);
    }
}
