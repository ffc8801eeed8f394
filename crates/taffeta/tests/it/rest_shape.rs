//! Bodies that start in another shape than the one in which they are at rest.

use crate::common::{
    V, add, build, near, norm, positions, run, scale, scene_error, sub, warnings, weightless,
};
use std::sync::Arc;
use taffeta::scene::{Body, Cube, Internal, Mass, Mesh, Place, Scene, SceneError};
use taffeta::topology::{Edges, Surface, shapes};
use taffeta::{Options, Simulation};

const ROWS: u32 = 5;
const COLS: u32 = 6;

/// A sheet of 0.5 m × 0.4 m that starts as `shape` makes of it and has the flat sheet as its pattern.
fn sheet(shape: impl Fn(V) -> V) -> Surface {
    let flat = shapes::grid_surface(ROWS, COLS, [0.5, 0.4]);
    let rest = flat.triangles.iter().map(|t| t.map(|node| flat.nodes[node as usize])).collect();
    let nodes: Vec<V> = flat.nodes.iter().copied().map(shape).collect();
    Surface { vertices: nodes.clone(), nodes, rest: Some(rest), ..flat }
}

fn body(surface: Surface) -> Body {
    Body::cloth("sheet", Mesh::Surface(Arc::new(surface))).with_mass(Mass::Whole(0.2))
}

fn at_rest(body: Body) -> Simulation {
    build(&weightless("rest", 0.01, 5e-4).body(body))
}

fn refused(body: Body) -> SceneError {
    let scene = weightless("rest", 0.01, 1e-3).body(body);
    scene_error(Simulation::new(&scene, &Options::default()))
}

/// Lengths of all edges of a surface with its nodes at `places` [m].
fn edge_lengths(surface: &Surface, places: &[V]) -> Vec<f64> {
    let edges = Edges::new(places.len(), &surface.triangles, &[]);
    edges.pairs.iter().map(|[a, b]| norm(sub(places[*b as usize], places[*a as usize]))).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn a_sheet_that_starts_stretched_folded_or_crumpled_returns_to_its_pattern() {
    let fold = |[x, y, z]: V| if x > 0.06 { [0.12 - x, y + 0.3 * (x - 0.06), z] } else { [x, y, z] };
    let crumple = |[x, y, z]: V| {
        let wave = |s: f64| 0.04 * (37.0 * x + s).sin() * (29.0 * z - s).cos();
        [0.8 * x + wave(0.3), y + wave(1.1), 0.7 * z + wave(2.0)]
    };
    let stretch = |[x, y, z]: V| [1.4 * x, y, 0.6 * z + 0.2 * x];
    for (name, shape) in
        [("folded", &fold as &dyn Fn(V) -> V), ("crumpled", &crumple), ("stretched", &stretch)]
    {
        let surface = sheet(shape);
        let pattern = shapes::grid_surface(ROWS, COLS, [0.5, 0.4]);
        let expected = edge_lengths(&pattern, &pattern.nodes);
        let start = largest_difference(&edge_lengths(&surface, &surface.nodes), &expected);
        assert!(start > 0.02 || name == "folded", "{name} starts {start} m away");
        let mut scene = weightless("rest", 0.02, 5e-4);
        scene.world.drag = 0.02;
        let body = body(surface.clone()).structural(100.0, 0.1).bend(5.0, 0.1).hinge(1e-3, 1e-5);
        let mut simulation = build(&scene.body(body));
        run(&mut simulation, 600);
        let end = largest_difference(&edge_lengths(&surface, &positions(&simulation)), &expected);
        assert!(end < 1e-4, "{name}: an edge ends {end} m from its length");
        near(
            "energy at the end",
            simulation.report().springs + simulation.report().energy_of("hinges"),
            0.0,
            1e-6,
        );
    }
}

#[test]
fn energy_at_the_start_is_half_k_times_the_stretch_squared() {
    // Stretched by a half along x: edges along x by a half, diagonals as Pythagoras says.
    let (dx, dz, k) = (0.1_f64, 0.1_f64, 70.0);
    let [r, c] = [ROWS, COLS].map(f64::from);
    let diagonal = ((1.5 * dx).powi(2) + dz * dz).sqrt() - (dx * dx + dz * dz).sqrt();
    let of_user = 0.5 * k * (r * (c - 1.0) * (0.5 * dx).powi(2) + (r - 1.0) * (c - 1.0) * diagonal.powi(2));
    let simulation = at_rest(body(sheet(|[x, y, z]| [1.5 * x, y, z])).structural(k, 0.1));
    near("energy", simulation.report().springs, of_user, 1e-12);
    // A right fold along a column: a quarter turn at each of its edges.
    let folded = |[x, y, z]: V| if x > -0.05 { [-0.05, y + x + 0.05, z] } else { [x, y, z] };
    let hinged = at_rest(body(sheet(folded)).hinge(0.3, 0.0));
    let of_user = (r - 1.0) * 0.5 * 0.3 * std::f64::consts::FRAC_PI_2.powi(2);
    near("energy of hinges", hinged.report().energy_of("hinges"), of_user, 1e-12);
    assert_eq!(
        at_rest(body(sheet(|p| p)).structural(k, 0.0).hinge(1.0, 0.0)).report().energy_of("hinges"),
        0.0
    );
}

#[test]
fn masses_follow_the_pattern_and_not_the_start() {
    let grown = |mass| body(sheet(|p| scale(p, 3.0))).with_mass(mass).structural(1.0, 0.0);
    near("mass", at_rest(grown(Mass::Area(2.0))).bodies()[0].mass, 2.0 * 0.5 * 0.4, 1e-15);
    near("whole mass", at_rest(grown(Mass::Whole(7.0))).bodies()[0].mass, 7.0, 1e-14);
}

#[test]
fn scale_and_fit_act_on_the_pattern_by_the_same_factor() {
    // The start is 1 m along x; `fit` asks for 3 m and so does a scale of 3. The pattern is 0.5 m × 0.4 m.
    let fit = Place { fit: Some(3.0), ..Place::default() };
    let three = Place { scale: Some(3.0), ..Place::default() };
    for place in [fit, three] {
        let mut body = body(sheet(|p| scale(p, 2.0))).with_mass(Mass::Area(1.0)).structural(10.0, 0.0);
        body.place = place;
        let simulation = at_rest(body);
        near("mass", simulation.bodies()[0].mass, 9.0 * 0.2, 1e-13);
        near("stretch", simulation.report().max_stretch, 2.0, 1e-13);
    }
}

/// A tube about the x axis of two panels, each one square long and two wide: nodes 0, 1 on one seam, 4, 5 on the
/// other. The pattern has the panels side by side, 0.2 m wide on each side of the fold, 0.5 m long.
fn tube() -> Surface {
    let nodes = [[0.0, 0.1, 0.0], [0.0, 0.0, 0.1], [0.0, -0.1, 0.0], [0.0, 0.0, -0.1]];
    let nodes: Vec<V> = nodes.into_iter().flat_map(|p| [p, add(p, [0.3, 0.0, 0.0])]).collect();
    let mut surface = Surface { vertices: nodes.clone(), nodes, ..Surface::default() };
    let mut rest = Vec::new();
    for strip in 0..4_u32 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| (2 * strip + i) % 8);
        // The second panel lies 1 m away.
        let from = 0.2 * f64::from(strip) + if strip < 2 { 0.0 } else { 1.0 };
        let place = |x: f64, z: f64| [x, 0.0, from + z];
        surface.triangles.extend([[a, b, c], [d, c, b]]);
        rest.push([place(0.0, 0.0), place(0.5, 0.0), place(0.0, 0.2)]);
        rest.push([place(0.5, 0.2), place(0.0, 0.2), place(0.5, 0.0)]);
    }
    surface.rest = Some(rest);
    surface
}

#[test]
fn a_tube_of_two_panels_has_the_lengths_of_its_pattern_also_over_the_seams() {
    let surface = tube();
    let edges = Edges::new(8, &surface.triangles, &[]);
    // Along the tube 0.5 m, around it 0.2 m, diagonals by Pythagoras.
    let expected = |[a, b]: [u32; 2]| match (a % 2 == b % 2, b - a) {
        (true, _) => 0.2,
        (false, 1) if a % 2 == 0 => 0.5,
        _ => 0.5_f64.hypot(0.2),
    };
    let start = edge_lengths(&surface, &surface.nodes);
    let k = 3.0;
    let of_user: f64 =
        edges.pairs.iter().zip(&start).map(|(p, l)| 0.5 * k * (l - expected(*p)).powi(2)).sum();
    let simulation = at_rest(body(surface.clone()).structural(k, 0.0));
    near("energy of edges", simulation.report().springs, of_user, 1e-14);
    // Over each edge along the tube, seams too: 0.2 m of cloth on both sides, corners 0.5 m apart along it. Over each
    // diagonal: the rectangle's other diagonal.
    let length = |[a, b]: [u32; 2]| norm(sub(surface.nodes[b as usize], surface.nodes[a as usize]));
    let pairs = edges.bend_pairs(&surface.triangles, &[]);
    assert_eq!(pairs.len(), 8);
    let over = |pair: [u32; 2]| {
        let apart = (pair[0] / 2).abs_diff(pair[1] / 2).min(4 - (pair[0] / 2).abs_diff(pair[1] / 2));
        if apart == 2 { 0.5_f64.hypot(0.4) } else { 0.5_f64.hypot(0.2) }
    };
    let of_user: f64 = pairs.iter().map(|p| 0.5 * k * (length(*p) - over(*p)).powi(2)).sum();
    let simulation = at_rest(body(surface.clone()).bend(k, 0.0));
    near("energy of bends", simulation.report().springs, of_user, 1e-14);
    // Flat at rest: each of the four edges along the tube is folded by a quarter turn, the diagonals are flat.
    let simulation = at_rest(body(surface).hinge(0.6, 0.0));
    near(
        "energy of hinges",
        simulation.report().energy_of("hinges"),
        4.0 * 0.3 * std::f64::consts::FRAC_PI_2.powi(2),
        1e-12,
    );
}

fn cube(rest: impl Fn(V) -> V) -> Body {
    let cube = shapes::surface(&Mesh::Cube(Cube { size: 1.0, divisions: 2 })).unwrap();
    let rest = cube.triangles.iter().map(|t| t.map(|node| rest(cube.nodes[node as usize]))).collect();
    let surface = Surface { rest: Some(rest), ..cube };
    Body::soft("cube", Mesh::Surface(Arc::new(surface))).with_mass(Mass::Volume(10.0)).structural(10.0, 0.0)
}

#[test]
fn a_soft_body_has_the_volume_and_struts_of_its_shape_at_rest() {
    let internal = |count| Some(Internal { count, k: 5.0, ..Internal::default() });
    let mut double = cube(|p| scale(p, 2.0));
    double.springs.internal = internal(20);
    double = double.hinge(1.0, 0.0);
    let simulation = at_rest(double);
    let info = &simulation.bodies()[0];
    near("volume", info.rest_volume.unwrap(), 8.0, 1e-14);
    near("hinges at the same angles in both", simulation.report().energy_of("hinges"), 0.0, 1e-20);
    near("mass", info.mass, 80.0, 1e-12);
    // Every spring, struts among them, starts at half its length.
    near("stretch", simulation.report().max_stretch, 1.0, 0.5);
    let struts = info.springs.iter().find(|(kind, _)| *kind == "internal").unwrap().1;
    assert_eq!(struts, 20);
    let edges_alone = at_rest(cube(|p| scale(p, 2.0))).report().springs;
    let in_struts = simulation.report().springs - edges_alone;
    // Struts through a cube of 2 m have lengths from 1 m (across an edge) to 2√3 m; half of it is missing.
    assert!(in_struts > 20.0 * 2.5 * 0.25 && in_struts < 20.0 * 2.5 * 3.0, "{in_struts} J");

    let mut seams = cube(|p| p);
    let Mesh::Surface(surface) = &mut seams.mesh else { panic!("a surface was made") };
    Arc::get_mut(surface).unwrap().rest.as_mut().unwrap()[3].iter_mut().for_each(|p| p[0] += 5.0);
    near("volume of the start", at_rest(seams.clone()).bodies()[0].rest_volume.unwrap(), 1.0, 1e-14);
    seams.springs.internal = internal(5);
    let error = refused(seams);
    assert_eq!(error.path, "body[0].springs.internal");
    assert!(error.message.contains("has seams"), "{error}");
}

#[test]
fn a_mirrored_shape_at_rest_is_refused() {
    let error = refused(cube(|[x, y, z]| [-x, y, z]));
    assert_eq!(error.path, "body[0].rest_shape");
    assert!(error.message.contains("mirror image"), "{error}");
}

#[test]
fn springs_far_from_their_rest_length_are_told_with_their_number() {
    let warnings = |factor| {
        let body = body(sheet(|p| scale(p, factor))).structural(1.0, 0.0);
        let scene: Scene = weightless("far", 1e-3, 1e-3).body(body);
        warnings(&build(&scene)).join(" ")
    };
    assert_eq!(warnings(1.9), "");
    let edges = ROWS * (COLS - 1) + COLS * (ROWS - 1) + (ROWS - 1) * (COLS - 1);
    let long = warnings(1000.0);
    let starts = format!("body `sheet`: {edges} springs start (100.0 % of {edges}) at more than twice");
    assert!(long.contains(&starts) && long.contains("one at 1000.000 times"), "{long}");
    assert!(warnings(0.001).contains("less than half the rest length, one at 0.001 times"));
}

/// Along the corners' ways a hinge is k Σ|∇θ|², and a gradient is one over a height: at half the size it is four times
/// as stiff, and half the step is stable.
#[test]
fn the_largest_step_of_all_shapes_counts_with_hinges_as_stiff_as_at_rest() {
    let hinged = |size: f64| body(sheet(|p| scale(p, size))).with_mass(Mass::Node(0.1)).hinge(0.2, 0.0);
    let [same, doubled] = [1.0, 2.0].map(|size| at_rest(hinged(size)));
    let folded = doubled.largest_stable_step_folded() / same.largest_stable_step_folded();
    near("folded, as one to the other", folded, 1.0, 1e-3);
    let start = doubled.largest_stable_step() / same.largest_stable_step();
    near("as it starts, as one to the other", start, 2.0, 1e-3);
}

#[test]
fn a_spring_that_starts_without_length_counts_for_the_step() {
    // Opposite corners of two triangles that start folded onto each other.
    let flat: [V; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 1.0], [0.5, 0.0, -1.0]];
    let nodes = vec![flat[0], flat[1], flat[2], flat[2]];
    let triangles = vec![[0, 2, 1], [0, 1, 3]];
    let rest = Some(triangles.iter().map(|t: &[u32; 3]| t.map(|node| flat[node as usize])).collect());
    let surface = Surface { vertices: nodes.clone(), nodes, triangles, rest, ..Surface::default() };
    let simulation = at_rest(body(surface).with_mass(Mass::Node(0.1)).bend(50.0, 0.0));
    // Two masses and a spring: ω² = 2k/m, and h = 2/ω.
    near("step", simulation.largest_stable_step(), 2.0 / (2.0 * 50.0 / 0.1_f64).sqrt(), 6e-3);
}
