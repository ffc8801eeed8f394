//! Fabrics: membrane and bending against formulas written down anew, closed forms, and themselves on both backends and solvers.

use crate::common::{build, build_as, cross, dot, farthest, gpu, positions, run, scale, sub, surface};
use taffeta::scene::{
    Body, ConstraintForm, FabricDamping, Icosphere, Material, Mesh, Method, RestCurvature, Scene, Select,
    Zone,
};
use taffeta::{Options, Precision, Simulation};

type V = [f64; 3];

fn unit(a: V) -> V {
    scale(a, 1.0 / dot(a, a).sqrt())
}

/// An orthotropic fabric that is not damped.
fn material() -> Material {
    Material {
        density: Some(0.3),
        stretch: Some([60.0, 90.0].into()),
        shear: Some(20.0),
        poisson: Some(0.2),
        bending: Some([2e-3, 3e-3].into()),
        bending_poisson: Some(0.25),
        twist: Some(1.1e-3),
        damping: Some(FabricDamping { stretch: 0.0, bending: 0.0 }),
        ..Material::default()
    }
}

/// The energy of a flat grid in the xz-plane whose warp runs along x, from its places at rest and now [J].
fn energy(rest: &[V], x: &[V], triangles: &[[u32; 3]]) -> f64 {
    let (s, t) = (60.0, 90.0);
    let d = 1.0 - 0.04 * t / s;
    let tensor = [s / d, 0.2 * t / d, t / d, 20.0];
    let mean = (2e-3_f64 * 3e-3).sqrt();
    let mut all = 0.0;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|node| node as usize);
        // The rest shape's gradient, by inverting the matrix of its edges in x and z.
        let (u, v) = (sub(rest[b], rest[a]), sub(rest[c], rest[a]));
        let det = u[0] * v[2] - v[0] * u[2];
        let column = |p: f64, q: f64| {
            let (e, f) = (sub(x[b], x[a]), sub(x[c], x[a]));
            [0, 1, 2].map(|i| p * e[i] + q * f[i])
        };
        let (warp, weft) = (column(v[2] / det, -u[2] / det), column(-v[0] / det, u[0] / det));
        let (e1, e2, shear) = (0.5 * (dot(warp, warp) - 1.0), 0.5 * (dot(weft, weft) - 1.0), dot(warp, weft));
        let area = det.abs() / 2.0;
        let [c11, c12, c22, g] = tensor;
        all += 0.5 * area * (c11 * e1 * e1 + c22 * e2 * e2 + 2.0 * c12 * e1 * e2 + g * shear * shear);
        // The shape operator, from the angles between normals.
        let mut parts = Vec::new();
        for [from, to, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
            let other = triangles.iter().find_map(|one| {
                let one = one.map(|node| node as usize);
                let has = |node| one.contains(&node);
                (has(from) && has(to) && !has(apex))
                    .then(|| one.into_iter().find(|&n| n != from && n != to))?
            });
            let along = sub(rest[to], rest[from]);
            let length = dot(along, along).sqrt();
            let n = [along[2] / length, -along[0] / length];
            let angle = other.map(|other| {
                let edge = sub(x[to], x[from]);
                let left = unit(cross(edge, sub(x[apex], x[from])));
                let right = unit(cross(sub(x[other], x[from]), edge));
                dot(cross(left, right), unit(edge)).atan2(dot(left, right))
            });
            parts.push((angle, [n[0] * n[0], n[1] * n[1], n[0] * n[1]].map(|p| p * length / (2.0 * area))));
        }
        let density = |s: [f64; 3]| {
            2e-3 * s[0] * s[0]
                + 3e-3 * s[1] * s[1]
                + 2.0 * 0.25 * mean * s[0] * s[1]
                + 4.0 * 1.1e-3 * s[2] * s[2]
        };
        all += 0.5 * area * least(&parts, density);
    }
    all
}

/// The least of a quadratic form over the folds that are missing at borders.
fn least(parts: &[(Option<f64>, [f64; 3])], form: impl Fn([f64; 3]) -> f64) -> f64 {
    let missing: Vec<usize> = (0..3).filter(|&e| parts[e].0.is_none()).collect();
    let value = |free: &[f64]| {
        let mut s = [0.0; 3];
        for (e, (angle, part)) in parts.iter().enumerate() {
            let angle = angle.unwrap_or_else(|| free[missing.iter().position(|&m| m == e).unwrap()]);
            (0..3).for_each(|i| s[i] += angle * part[i]);
        }
        form(s)
    };
    // Newton's method by differences: the form is quadratic, so that steps of 1 are exact.
    let zero = value(&vec![0.0; missing.len()]);
    let at = |set: &[(usize, f64)]| {
        let mut free = vec![0.0; missing.len()];
        set.iter().for_each(|&(i, by)| free[i] += by);
        value(&free)
    };
    let slope = |i: usize| (at(&[(i, 1.0)]) - at(&[(i, -1.0)])) / 2.0;
    let second = |i: usize, j: usize| at(&[(i, 1.0), (j, 1.0)]) - at(&[(i, 1.0)]) - at(&[(j, 1.0)]) + zero;
    match missing.len() {
        0 => zero,
        1 => zero - slope(0) * slope(0) / (2.0 * second(0, 0)),
        _ => {
            let (a, b, d) = (second(0, 0), second(0, 1), second(1, 1));
            let (p, q) = (slope(0), slope(1));
            zero - 0.5 * (d * p * p - 2.0 * b * p * q + a * q * q) / (a * d - b * b)
        }
    }
}

#[test]
fn a_fabric_moves_as_by_formulas_written_down_anew() {
    let h = 1e-3;
    let body = Body::cloth("sheet", Mesh::grid(4, 5, [0.4, 0.3])).with_material(material());
    let scene = Scene::new("").time(h, h).body(body);
    let mut simulation = build(&scene);
    let (rest, triangles) = (positions(&simulation), surface(&simulation, 0).triangles);
    let mut mass = vec![0.0; rest.len()];
    for triangle in &triangles {
        triangle.iter().for_each(|&node| mass[node as usize] += 0.3 * (0.1 * 0.1 / 2.0) / 3.0);
    }
    simulation.disturb(0.004, 7);
    let mut x = positions(&simulation);
    let mut v = vec![[0.0; 3]; x.len()];
    for frame in 0..25 {
        let mut forces = vec![[0.0; 3]; x.len()];
        for node in 0..x.len() {
            for axis in 0..3 {
                let here = x[node][axis];
                let mut at = |by: f64| {
                    x[node][axis] = here + by;
                    energy(&rest, &x, &triangles)
                };
                forces[node][axis] = -(at(1e-6) - at(-1e-6)) / 2e-6;
                x[node][axis] = here;
            }
        }
        for node in 0..x.len() {
            for axis in 0..3 {
                let gravity = if axis == 1 { -9.81 } else { 0.0 };
                v[node][axis] += h * (forces[node][axis] / mass[node] + gravity);
                x[node][axis] += h * v[node][axis];
            }
        }
        run(&mut simulation, 1);
        let apart = farthest(&positions(&simulation), &x);
        assert!(apart < 1e-8, "frame {frame}: {apart:e} m apart");
    }
    let report = simulation.report();
    let both = report.energy_of("membranes") + report.energy_of("bends");
    let wanted = energy(&rest, &x, &triangles);
    assert!((both - wanted).abs() < 1e-6 * wanted, "{both} J, not {wanted} J");
}

/// A sheet of cotton that swings by its first row.
fn hung(h: f64) -> Scene {
    let mut body = Body::cloth("sheet", Mesh::grid(13, 15, [0.3, 0.4])).with_material(material());
    body.place.rotation = Some(taffeta::scene::Rotation { axis: [1.0, 0.0, 0.0], degrees: 30.0 });
    Scene::new("").time(0.02, h).body(body.pin(Select::rows(0, 0)))
}

fn implicit(mut scene: Scene) -> Scene {
    scene.solver.method = Method::Ice;
    scene.solver.ice.form = ConstraintForm::Primal;
    scene.solver.ice.tolerance = 1e-8;
    scene.solver.ice.max_iterations = 1000;
    scene.solver.ice.newton_steps = 3;
    scene
}

#[test]
fn explicit_and_implicit_steps_meet_at_first_order() {
    let end = |scene: &Scene| {
        let mut simulation = build_as(scene, Precision::F64, 2);
        run(&mut simulation, 10);
        positions(&simulation)
    };
    let exact = end(&hung(1e-5));
    let apart = [4e-3, 2e-3, 1e-3].map(|h| farthest(&end(&implicit(hung(h))), &exact));
    assert!(apart[0] < 0.02 && apart[1] < 0.62 * apart[0] && apart[2] < 0.62 * apart[1], "{apart:?}");
}

/// All that a fabric may have: zones, a limit, a pleat, and springs beside it.
fn everything() -> Scene {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 3 });
    let round = Material { rest_curvature: RestCurvature::Mesh, ..Material::preset("denim") };
    let band = Zone { select: Select::rows(0, 2), rest_scale: Some(0.9.into()), ..Zone::default() };
    let mut banded = Material { strain_limit: Some(0.05), ..material() };
    banded.zones.insert("band".into(), band);
    let sheet = Body::cloth("sheet", Mesh::grid(19, 21, [0.3, 0.4])).with_material(banded);
    let springs = Body::cloth("springs", Mesh::grid(9, 9, [0.2, 0.2]))
        .with_mass(taffeta::scene::Mass::Area(0.2))
        .structural(100.0, 0.01)
        .at([1.0, 0.0, 0.0]);
    Scene::new("")
        .time(2e-3, 5e-5)
        .body(sheet.pin(Select::rows(0, 0)))
        .body(Body::cloth("ball", ball).with_material(round).at([0.0, -0.5, 0.0]).pin(Select::nodes([0])))
        .body(springs)
}

fn on_gpu(scene: &Scene) -> Simulation {
    let options = Options { gpu: Some(gpu().into()), ..Options::default() };
    Simulation::new(scene, &options).unwrap_or_else(|error| panic!("{error}"))
}

fn after(mut simulation: Simulation, frames: u32) -> Simulation {
    simulation.disturb(2e-3, 3);
    run(&mut simulation, frames);
    simulation
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for scene in [everything(), implicit(everything())] {
        let hash = |threads| after(build_as(&scene, Precision::F32, threads), 3).state_hash();
        assert_eq!(hash(1), hash(3));
    }
}

/// Within roundings: of compressed triangles a compiler takes some sums in another order.
#[test]
fn the_gpu_moves_as_the_cpu_does() {
    for (scene, allowed) in [(everything(), 1e-6), (implicit(everything()), 1e-5)] {
        let (cpu, gpu) = (after(build_as(&scene, Precision::F32, 2), 3), after(on_gpu(&scene), 3));
        let apart = farthest(&positions(&cpu), &positions(&gpu));
        assert!(apart < allowed, "{apart:e} m apart");
        for kind in ["membranes", "bends"] {
            let [a, b] = [&cpu, &gpu].map(|simulation| simulation.report().energy_of(kind));
            assert!(a > 0.0 && (a - b).abs() < 1e-3 * a, "{kind}: {a} J, {b} J");
        }
    }
}
