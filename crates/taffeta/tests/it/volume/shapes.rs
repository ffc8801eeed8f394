//! Surfaces that are odd, and what is said where they will not do.

use super::drive::{check_gradients, gradients};
use super::{ball, enclosed, surface};
use crate::common::{V, run};
use taffeta::scene::{Body, Icosphere, Mass, Mesh, Scene, Volume, VolumeForm, VolumeWeights};
use taffeta::topology::shapes;
use taffeta::{Options, Simulation};

/// Nodes and triangles of a ball.
fn round(radius: f64, subdivisions: u32) -> (Vec<V>, Vec<[u32; 3]>) {
    let ball = shapes::surface(&Mesh::Icosphere(Icosphere { radius, subdivisions })).unwrap();
    (ball.nodes, ball.triangles)
}

fn refused(body: Body) -> String {
    match Simulation::new(&Scene::new("odd").body(body), &Options::default()) {
        Ok(_) => panic!("it is taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn two_tetrahedra_that_share_a_corner_have_the_gradient_of_both() {
    let x = vec![
        [0.0; 3],
        [1.0, 0.1, 0.0],
        [0.0, 1.2, 0.0],
        [0.2, 0.0, 0.9],
        [-1.0, 0.0, 0.1],
        [0.0, -0.8, 0.0],
        [0.0, 0.1, -1.1],
    ];
    let solid = |[a, b, c, d]: [u32; 4]| [[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
    // The other is the mirror image of a corner: its nodes in an order that makes it right.
    let triangles = [solid([0, 1, 2, 3]), solid([0, 5, 4, 6])].concat();
    let volume = enclosed(&x, &triangles);
    let (gradient, x, triangles) = gradients(surface(x, triangles), [0.0; 3]);
    assert!(volume > 0.3);
    check_gradients(&gradient, &x, &triangles);
}

#[test]
fn two_sheets_that_meet_at_several_nodes_have_the_gradient_of_both() {
    // Two balls of eight faces joined at one node each at the end of a row.
    let octahedron = |at: f64| -> [V; 6] {
        [
            [at + 1.0, 0.0, 0.0],
            [at - 1.0, 0.0, 0.0],
            [at, 1.0, 0.0],
            [at, -1.0, 0.0],
            [at, 0.0, 1.0],
            [at, 0.0, -1.0],
        ]
    };
    let faces: [[u32; 3]; 8] =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let (mut nodes, mut triangles) = (octahedron(0.0).to_vec(), faces.to_vec());
    for row in 1..3 {
        // Node 1 of each stands where node 0 of the one before is.
        let first = nodes.len() as u32;
        let joint =
            nodes.iter().position(|x| x[0] == 2.0 * f64::from(row) - 1.0 && x[1] == 0.0).unwrap() as u32;
        let own = octahedron(2.0 * f64::from(row));
        nodes.extend([own[0], own[2], own[3], own[4], own[5]]);
        let place = [first, joint, first + 1, first + 2, first + 3, first + 4];
        triangles.extend(faces.map(|face| face.map(|n| place[n as usize])));
    }
    let (gradient, x, triangles) = gradients(surface(nodes, triangles), [0.0; 3]);
    check_gradients(&gradient, &x, &triangles);
}

#[test]
fn a_cavity_counts_as_empty() {
    let (mut nodes, mut triangles) = round(1.0, 2);
    let (inner, faces) = round(0.5, 1);
    let first = nodes.len() as u32;
    nodes.extend(inner);
    triangles.extend(faces.iter().map(|&[a, b, c]| [a + first, c + first, b + first]));
    let (gradient, x, triangles) = gradients(surface(nodes, triangles), [0.0; 3]);
    check_gradients(&gradient, &x, &triangles);
    // Under pressure the wall between gets thicker both ways: the cavity's nodes go in.
    let inward = x.iter().zip(&gradient).skip(first as usize).all(|(x, g)| super::dot(*x, *g) < 0.0);
    assert!(inward);
}

#[test]
fn a_surface_that_is_inside_out_is_refused_with_what_would_do() {
    let (nodes, triangles) = round(0.5, 2);
    let reversed = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    for form in [VolumeForm::Corrected, VolumeForm::Printed] {
        let body = Body { mesh: surface(nodes.clone(), Vec::clone(&reversed)), ..ball(2, form) };
        let error = refused(body);
        assert!(error.contains("inside out"), "{error}");
    }
}

/// Two sheets a little apart, closed at their borders.
fn pillow(thickness: f64) -> Mesh {
    let n = 5_u32;
    let place = |i: u32, j: u32, y: f64| [f64::from(i) * 0.25, y, f64::from(j) * 0.25];
    let border = |i: u32, j: u32| i == 0 || j == 0 || i == n - 1 || j == n - 1;
    let mut nodes: Vec<V> = (0..n * n).map(|k| place(k / n, k % n, 0.0)).collect();
    let mut above: Vec<u32> = (0..n * n).collect();
    for k in (0..n * n).filter(|k| !border(k / n, k % n)) {
        above[k as usize] = nodes.len() as u32;
        nodes.push(place(k / n, k % n, thickness));
    }
    let mut triangles = Vec::new();
    for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
        let [a, b, c, d] = [i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j];
        // At a corner both sheets would have the same triangle, but where the diagonal runs into it.
        let halves = if (i == 0) == (j == 0) && (i == 0 || i == n - 2 || j == n - 2) {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        };
        for [p, q, r] in halves {
            triangles.push([p, r, q]);
            triangles.push([p, q, r].map(|k| above[k as usize]));
        }
    }
    surface(nodes, triangles)
}

#[test]
fn a_pillow_that_is_next_to_flat_is_refused_where_it_should_keep_a_volume_and_blown_up_by_a_pressure() {
    let body = |thickness, volume| Body {
        mesh: pillow(thickness),
        volume: Some(volume),
        ..ball(1, VolumeForm::None)
    };
    let thick =
        Simulation::new(&Scene::new("thick").body(body(0.05, Volume::default())), &Options::default());
    assert!(thick.is_ok(), "{}", thick.err().map_or(String::new(), |e| e.to_string()));
    let error = refused(body(1e-7, Volume::default()));
    assert!(
        error.starts_with("body[0].volume") && error.contains("a thicker mesh or volume.pressure would do"),
        "{error}"
    );
    let pressed = Volume { pressure: Some(5.0), ..Volume::default() };
    let mut simulation = Simulation::new(
        &Scene::new("blown").time(0.01, 0.0005).body(body(1e-7, pressed)),
        &Options::default(),
    )
    .unwrap();
    let start = simulation.report().volumes[0].unwrap();
    run(&mut simulation, 20);
    assert!(simulation.report().volumes[0].unwrap() > 1e3 * start);
}

#[test]
fn weights_that_reach_no_node_name_the_nearest() {
    let mut body = ball(1, VolumeForm::Corrected).at([0.0, 2.0, 0.0]);
    let weights = VolumeWeights { center: [0.0, 2.0, 0.0], radius: 0.1 };
    body.volume = Some(Volume { weights: Some(weights), ..Volume::default() });
    let error = refused(body.clone());
    for words in
        ["body[0].volume.weights", "no node is within 0.1 m", "the nearest, vertex ", "a larger radius"]
    {
        assert!(error.contains(words), "{error}");
    }
    body.volume.as_mut().unwrap().weights.as_mut().unwrap().radius = 0.0;
    assert!(refused(body).contains("volume.weights.radius"));
}

#[test]
fn what_makes_no_sense_is_refused_where_it_is() {
    let with = |volume: Volume| refused(Body { volume: Some(volume), ..ball(1, VolumeForm::None) });
    let both = with(Volume { target: Some(1.0), pressure: Some(1.0), ..Volume::default() });
    assert!(both.contains("body[0].volume") && both.contains("a target and a pressure"), "{both}");
    for target in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = with(Volume { target: Some(target), ..Volume::default() });
        assert!(error.contains("body[0].volume.target"), "{error}");
    }
    let form = with(Volume { form: VolumeForm::Projected, pressure: Some(1.0), ..Volume::default() });
    assert!(form.contains("body[0].volume.form"), "{form}");
    let cloth = Body::cloth("c", Mesh::grid(3, 3, [1.0; 2])).with_mass(Mass::Node(1.0));
    let cloth = refused(cloth.keep_volume(VolumeForm::Corrected));
    assert!(cloth.contains("is for soft bodies"), "{cloth}");
}
