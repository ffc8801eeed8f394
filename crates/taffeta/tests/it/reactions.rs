//! The forces with which pins hold bodies: against their weight, their motion, their change of momentum, and a fabric's tensor.

use crate::common::{
    V, add, build, build_as, gpu, near, norm, positions, run, scale, sub, turned, weightless,
};
use taffeta::scene::{
    Body, ConstraintForm, Cube, Keyframe, Mass, Material, Mesh, Method, Scene, Select, VolumeForm,
};
use taffeta::{Options, Precision, Simulation};

const G: f64 = 9.81;

fn on_gpu(scene: &Scene) -> Simulation {
    let options = Options { gpu: Some(gpu().into()), ..Options::default() };
    Simulation::new(scene, &options).unwrap()
}

/// On the CPU in 64 bits and in 32, and on the GPU, with how exactly that counts. Solvers stop where 32 bits end.
fn everywhere(scene: &Scene) -> [(Simulation, f64); 3] {
    let mut short = scene.clone();
    (short.solver.ice.tolerance, short.solver.ice.max_iterations) = (1e-4, 100);
    [(build(scene), 1e-8), (build_as(&short, Precision::F32, 2), 2e-4), (on_gpu(&short), 2e-4)]
}

/// The reaction of a pin of the first body [N].
fn reaction(simulation: &Simulation, pin: usize) -> V {
    simulation.report().reaction(0, pin).expect("after a frame")
}

/// The sum of those of all pins of the scene [N].
fn all(simulation: &Simulation) -> V {
    let known = simulation.report().reactions.iter().filter_map(|one| one.force);
    known.fold([0.0; 3], add)
}

/// A sheet of 0.05 kg that hangs from both ends of its first row.
fn hung(fabric: bool) -> Body {
    let sheet = Body::cloth("sheet", Mesh::grid(6, 7, [0.5, 0.5]));
    let sheet = if fabric {
        let material =
            Material { stretch: Some(20.0.into()), shear: Some(8.0), ..Material::preset("cotton") };
        Body { material: Some(Material { density: Some(0.2), ..material }), ..sheet }
    } else {
        sheet.with_mass(Mass::Area(0.2)).structural(20.0, 0.01).shear(10.0, 0.01)
    };
    let sheet = sheet.pin(Select::nodes([0])).pin(Select::nodes([6]));
    Body { place: turned([1.0, 0.0, 0.0], 90.0, [0.3, 1.0, 0.2]), ..sheet }
}

/// The ways to solve for springs, or for none, with a step that suits them [s].
fn ways(scene: impl Fn(f64) -> Scene) -> Vec<(&'static str, Scene)> {
    let implicit = |form, h| {
        let mut scene = scene(h).method(Method::Ice);
        scene.solver.ice.form = form;
        (scene.solver.ice.tolerance, scene.solver.ice.max_iterations) = (1e-9, 2000);
        scene
    };
    vec![
        ("explicit", scene(5e-4)),
        ("primal", implicit(ConstraintForm::Primal, 0.02)),
        ("ice", implicit(ConstraintForm::Compliant, 0.02)),
        ("acad", scene(5e-4).method(Method::Acad)),
    ]
}

#[test]
fn two_corners_share_the_weight_of_a_sheet_that_hangs_still() {
    for fabric in [false, true] {
        let scene = |h| {
            let mut scene = Scene::new("").time(0.1, h).body(hung(fabric));
            scene.world.drag = 0.01;
            scene
        };
        for (name, scene) in ways(scene) {
            // ACAD pulls springs that are too long back in jolts; a fabric has no springs to constrain.
            if name == "acad" || fabric && name == "ice" {
                continue;
            }
            let mut simulation = build(&scene);
            assert_eq!(simulation.report().reaction(0, 0), None, "{name}: at the start");
            run(&mut simulation, 60);
            let [left, right] = [0, 1].map(|pin| reaction(&simulation, pin));
            near(name, left[1] + right[1], 0.05 * G, 2e-4);
            // Triangles lean to one side, and so does a sheet of them.
            near(name, left[1], 0.05 * G / 2.0, if fabric { 5e-3 } else { 2e-4 });
            // They pull outwards alike.
            assert!(left[0] < -0.01, "{name}: {left:?}");
            near(name, left[0] + right[0], 0.0, 2e-4);
            let pin = simulation.pin(simulation.body("sheet").unwrap(), 1).unwrap();
            assert_eq!(simulation.reaction(pin).unwrap().unwrap().to_array(), right);
            let by_vertex = simulation.vertex_reactions(pin).unwrap();
            assert_eq!(by_vertex, [(6, right.into())]);
        }
    }
}

#[test]
fn reactions_and_weight_are_the_change_of_momentum_with_every_solver_on_every_device() {
    let scene = |fabric, soft: bool| {
        move |h| {
            let mut body = hung(fabric);
            if soft {
                let cube = Body::soft("cube", Mesh::Cube(Cube { size: 0.4, divisions: 3 }));
                let cube = cube.with_mass(Mass::Whole(0.5)).structural(60.0, 0.05);
                body = cube
                    .keep_volume(VolumeForm::Corrected)
                    .pin(Select::nodes([0, 1]))
                    .pin(Select::nodes([9]));
            }
            let body = body.moving([0.3, -0.5, 0.8]).spinning([0.0, 2.0, 1.0]);
            // One step a frame: what is told is of the only one.
            Scene::new("").time(h, h).body(body)
        }
    };
    for (fabric, soft) in [(false, false), (true, false), (false, true)] {
        for (name, scene) in ways(scene(fabric, soft)) {
            if fabric && name == "ice" {
                continue;
            }
            let h = scene.time.dt;
            for (mut simulation, exact) in everywhere(&scene) {
                let weight = [0.0, -G * simulation.bodies()[0].mass, 0.0];
                for frame in 0..4 {
                    let before = simulation.report().momentum;
                    run(&mut simulation, 1);
                    let change = scale(sub(simulation.report().momentum, before), 1.0 / h);
                    let off = norm(sub(change, add(all(&simulation), weight)));
                    // Momentum in 32 bits has some last digits, and a step divides them.
                    let allowed = exact * (1.0 + norm(change)) + exact * 2e-3 / h;
                    let device = simulation.device();
                    assert!(off < allowed, "{name} {fabric} {soft} {device}: {off:e} N at {frame}");
                }
            }
        }
    }
}

#[test]
fn several_sub_steps_at_once_keep_the_forces_of_the_last() {
    let body = hung(false).moving([0.3, -0.5, 0.8]);
    let scene = Scene::new("").time(0.02, 1e-3).body(body);
    let (mut a, mut b) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for _ in 0..3 {
        run(&mut a, 1);
        run(&mut b, 1);
        assert_eq!(a.state_hash(), b.state_hash());
        assert_eq!(a.report().reactions, b.report().reactions);
    }
}

#[test]
fn a_pin_that_falls_freely_reads_nothing_and_one_that_is_pushed_reads_mass_times_acceleration() {
    let h = 0.01;
    // What symplectic Euler falls: −½ g t (t + h).
    let key = |n: u8, a: f64| {
        let t = f64::from(n) * h;
        Keyframe::translate(t, [0.5 * a * t * (t + h), -0.5 * G * t * (t + h), 0.0])
    };
    for (push, held) in [(0.0, Select::rows(0, 0)), (3.0, Select::rows(0, 9))] {
        let keys = (1..40).map(|n| key(n, push)).collect();
        let sheet = Body::cloth("sheet", Mesh::grid(10, 5, [0.4, 0.8])).with_mass(Mass::Whole(2.0));
        let scene = Scene::new("").time(2.0 * h, h).body(sheet.structural(50.0, 0.1).pin_moving(held, keys));
        for (mut simulation, exact) in everywhere(&scene) {
            for _ in 0..8 {
                run(&mut simulation, 1);
                let force = reaction(&simulation, 0);
                near("across", force[0], 2.0 * push, 1e2 * exact);
                near("up", force[1], 0.0, 1e2 * exact);
            }
        }
    }
}

#[test]
fn a_strip_that_is_pulled_along_its_warp_pulls_back_by_its_tensor() {
    // Force by width: S ½ (s² − 1) s.
    let (stiffness, width) = (490.0, 0.2);
    let material =
        Material { stretch: Some(stiffness.into()), poisson: Some(0.0), ..Material::preset("cotton") };
    let matrix = |s: f64| [[s, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for s in [1.02, 1.1] {
        let strip = Body::cloth("strip", Mesh::grid(5, 9, [0.4, width])).with_material(material.clone());
        // One motion for both ends: about the middle.
        let pulled = |strip: Body, col| {
            strip.pin_moving(Select::cols(col, col), vec![Keyframe::deform(0.0, matrix(s), [0.0; 3])])
        };
        let strip = pulled(pulled(strip, 0), 8);
        let mut scene = weightless("", 0.02, 0.02).body(strip).method(Method::Ice);
        scene.solver.ice.form = ConstraintForm::Primal;
        (scene.solver.ice.tolerance, scene.solver.ice.max_iterations) = (1e-6, 1000);
        scene.world.drag = 1e-3;
        for (mut simulation, exact) in everywhere(&scene) {
            let start = positions(&simulation);
            near("an end", start[0][0], -0.2 * s, 1e-6);
            run(&mut simulation, 40);
            let wanted = stiffness * 0.5 * (s * s - 1.0) * s * width;
            let [left, right] = [0, 1].map(|pin| reaction(&simulation, pin));
            near("left", left[0], -wanted, 1e-3 * wanted);
            near("right", right[0], wanted, 1e-3 * wanted);
            near("across", right[2], 0.0, 1e-3 * wanted);
            near("both", left[0] + right[0], 0.0, 1e4 * exact);
            // A corner has half of what others at its end have.
            let pin = simulation.pin(simulation.body("strip").unwrap(), 1).unwrap();
            let by_vertex = simulation.vertex_reactions(pin).unwrap();
            let vertices: Vec<usize> = by_vertex.iter().map(|one| one.0).collect();
            assert_eq!(vertices, [8, 17, 26, 35, 44]);
            for (vertex, force) in by_vertex {
                let share = if matches!(vertex, 8 | 44) { 8.0 } else { 4.0 };
                near("a vertex", force.x, wanted / share, 1e-3 * wanted);
            }
        }
    }
}

#[test]
fn pins_that_deform_have_the_velocity_of_their_places() {
    let deform = [[1.3, 0.2, 0.0], [0.0, 0.9, -0.1], [0.3, 0.0, 1.1]];
    let pivot = [0.1, -0.2, 0.3];
    let sheet = Body::cloth("sheet", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Node(0.1));
    let sheet = sheet.pin_moving(Select::rows(0, 3), vec![Keyframe::deform(0.5, deform, pivot)]);
    for (mut simulation, exact) in everywhere(&weightless("", 0.05, 0.01).body(sheet)) {
        let start = positions(&simulation);
        for frame in 1..=12 {
            run(&mut simulation, 1);
            let share = f64::min(1.0, 0.1 * f64::from(frame));
            let mut velocities: Vec<[f32; 3]> = Vec::new();
            simulation.velocities_f32(&mut velocities);
            for ((x0, x), v) in start.iter().zip(positions(&simulation)).zip(velocities) {
                let arm = sub(*x0, pivot);
                let stretched: V = std::array::from_fn(|i| (0..3).map(|j| deform[i][j] * arm[j]).sum());
                let way = sub(stretched, arm);
                let place = add(*x0, scale(way, share));
                assert!(norm(sub(x, place)) < 1e-2 * exact, "{x:?} {place:?}");
                let speed = if frame <= 10 { scale(way, 2.0) } else { [0.0; 3] };
                let off = norm(sub(v.map(f64::from), speed));
                assert!(off < exact.max(1e-6), "{v:?} {speed:?}");
            }
        }
    }
}

#[test]
fn pins_that_break_tell_nothing_and_others_have_what_they_hold() {
    let chain = Body::cloth("chain", Mesh::chain(4, 1.0)).with_mass(Mass::Node(0.1)).structural(200.0, 1.0);
    let chain = chain.pin(Select::nodes([0])).pin_breaking(Select::nodes([4]), 1e3).pin(Select::nodes([0]));
    let mut simulation = build(&weightless("", 0.1, 1e-3).body(chain));
    run(&mut simulation, 1);
    let known: Vec<_> = simulation.report().reactions.iter().map(|one| (one.pin, one.force)).collect();
    assert_eq!(known, [(0, Some([0.0; 3])), (1, None), (2, known[2].1)]);
    assert!(norm(known[2].1.unwrap()) < 1e-9);
}
