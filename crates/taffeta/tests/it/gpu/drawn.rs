//! Vertices that go from the state to a renderer's buffer on the device.

use super::flag;
use crate::common::{V, gpu, normals, positions, run};
use taffeta::scene::{Body, Icosphere, Mass, Mesh, Scene};
use taffeta::taffeta_gpu::wgpu::{BufferDescriptor, BufferUsages};
use taffeta::taffeta_gpu::{Buffer, Gpu};
use taffeta::{Options, Simulation, VertexTarget, View};

/// Words from a vertex to the next, and the first vertex.
const STRIDE: usize = 8;
const FIRST: usize = 77;
const HALF: View = View {
    alpha: 0.5,
    places: [[0.0, 1.0, 0.0, 3.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    normals: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
};

fn renderer(gpu: &Gpu, vertices: usize) -> (Buffer<f32>, VertexTarget) {
    let buffer: Buffer<f32> = gpu.buffer("renderer", FIRST + STRIDE * vertices).unwrap();
    let target = VertexTarget {
        buffer: buffer.raw().clone(),
        first: 4 * FIRST as u64,
        stride: 4 * STRIDE as u64,
        normal: 12,
    };
    (buffer, target)
}

fn near(what: &str, found: &[f32], wanted: V, tolerance: f64) {
    let apart = (0..3).map(|i| (f64::from(found[i]) - wanted[i]).abs()).fold(0.0, f64::max);
    assert!(apart < tolerance, "{what}: {found:?}, not {wanted:?}");
}

#[test]
fn the_device_draws_half_way_between_two_frames_in_the_renderers_coordinates() {
    let gpu = gpu();
    let ball = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 2 }))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02);
    let options = Options { gpu: Some(gpu.clone().into()), ..Options::default() };
    let mut simulation = Simulation::new(&flag().body(ball), &options).unwrap();
    let nodes: Vec<u32> = (0..162).rev().chain([u32::MAX]).collect();
    assert!(simulation.make_drawn(simulation.bodies()[1].handle, &nodes).unwrap());
    let (buffer, target) = renderer(&gpu, nodes.len());
    for _ in 0..3 {
        run(&mut simulation, 1);
        let before = positions(&simulation)[600..].to_vec();
        run(&mut simulation, 1);
        let after = positions(&simulation)[600..].to_vec();
        simulation.draw(simulation.bodies()[1].handle, &target, &HALF).unwrap();
        let drawn = buffer.read(&gpu).unwrap();
        for (vertex, &node) in nodes.iter().enumerate().take(162) {
            let [a, b] = [before[node as usize], after[node as usize]];
            let [x, y, z]: V = std::array::from_fn(|i| (a[i] + b[i]) / 2.0);
            let words = &drawn[FIRST + STRIDE * vertex..][..STRIDE];
            near("place", words, [y + 3.0, -x, z], 1e-6);
            assert_eq!(words[6..], [0.0; 2], "what is no place and no normal stays");
        }
        assert_eq!(drawn[FIRST + STRIDE * 162..], [0.0; STRIDE], "a vertex without a node stays");
    }
}

#[test]
fn drawn_normals_are_those_of_the_shape_that_is_drawn() {
    let gpu = gpu();
    let options = Options { gpu: Some(gpu.clone().into()), ..Options::default() };
    let mut simulation = Simulation::new(&flag(), &options).unwrap();
    let nodes: Vec<u32> = (0..600).collect();
    assert!(simulation.make_drawn(simulation.bodies()[0].handle, &nodes).unwrap());
    let (buffer, target) = renderer(&gpu, 600);
    run(&mut simulation, 20);
    simulation.draw(simulation.bodies()[0].handle, &target, &View { alpha: 1.0, ..HALF }).unwrap();
    let (drawn, wanted) = (buffer.read(&gpu).unwrap(), normals(&simulation, 0));
    for (node, normal) in wanted.into_iter().enumerate() {
        let [x, y, z] = normal.map(f64::from);
        near("normal", &drawn[FIRST + STRIDE * node + 3..], [y, -x, z], 1e-5);
    }
}

#[test]
fn what_is_not_finite_is_not_drawn() {
    let gpu = gpu();
    let sheet =
        Body::cloth("sheet", Mesh::grid(5, 5, [1.0, 1.0])).with_mass(Mass::Node(0.01)).structural(1e5, 0.0);
    let scene = Scene::new("bursts").body(sheet).time(0.1, 0.1);
    let options = Options { gpu: Some(gpu.clone().into()), ..Options::default() };
    let mut simulation = Simulation::new(&scene, &options).unwrap();
    simulation.disturb(0.01, 1);
    simulation.make_drawn(simulation.bodies()[0].handle, &(0..25).collect::<Vec<_>>()).unwrap();
    let (buffer, target) = renderer(&gpu, 25);
    simulation.submit(60).unwrap();
    simulation.draw(simulation.bodies()[0].handle, &target, &View { alpha: 1.0, ..HALF }).unwrap();
    assert!(buffer.read(&gpu).unwrap().iter().all(|number| number.is_finite()));
    assert!(simulation.poll().unwrap_err().to_string().contains("finite"));
}

#[test]
fn a_buffer_that_vertices_do_not_fit_is_refused_by_its_numbers() {
    let gpu = gpu();
    let options = Options { gpu: Some(gpu.clone().into()), ..Options::default() };
    let mut simulation = Simulation::new(&flag(), &options).unwrap();
    simulation.make_drawn(simulation.bodies()[0].handle, &[0, 1]).unwrap();
    let (_, target) = renderer(&gpu, 2);
    let body = simulation.bodies()[0].handle;
    let mut refused = |target: VertexTarget, why: &str| {
        let error = simulation.draw(body, &target, &HALF).unwrap_err().to_string();
        assert!(error.starts_with("body `flag` cannot be drawn there: ") && error.contains(why), "{error}");
    };
    let bytes = target.buffer.size();
    refused(VertexTarget { stride: bytes, ..target.clone() }, "2 vertices end at byte");
    refused(VertexTarget { first: bytes, ..target.clone() }, "2 vertices end at byte");
    refused(VertexTarget { stride: u64::MAX - 3, ..target.clone() }, "2 vertices end at byte");
    refused(VertexTarget { normal: 14, ..target.clone() }, "multiples of 4");
    refused(VertexTarget { normal: 8, ..target.clone() }, "12 to stride - 12");
    refused(VertexTarget { normal: target.stride, ..target.clone() }, "12 to stride - 12");
    let descriptor = BufferDescriptor {
        label: None,
        size: bytes,
        usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    };
    refused(VertexTarget { buffer: gpu.device().create_buffer(&descriptor), ..target.clone() }, "STORAGE");
    simulation.draw(body, &target, &HALF).unwrap();
}
