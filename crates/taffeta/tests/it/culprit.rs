//! The largest stable step says what sets it, and lowering that alone makes a step stable.

use crate::common::{build, warnings, weightless};
use std::sync::Arc;
use taffeta::diagnostics::culprit::Source;
use taffeta::scene::{Body, FabricDamping, Mass, Material, Mesh, Scene, Select, Spring, WarpWeft, Zone};
use taffeta::springs::SpringKind;
use taffeta::topology::shapes::grid_surface;

/// A number of a scene that may be too large.
struct Planted {
    source: Source,
    is_damping: bool,
    /// Of those that the scene has without it.
    times: f64,
    change: fn(&mut Scene, f64),
}

fn springs() -> Scene {
    let body = Body::cloth("sheet", Mesh::grid(12, 15, [1.4, 1.1])).with_mass(Mass::Node(0.01));
    let body = body.structural(20.0, 0.003).shear(20.0, 0.003).bend(20.0, 0.003).hinge(0.02, 2e-6);
    weightless("springs", 0.1, 0.1).body(body)
}

fn fabric() -> Scene {
    let material = Material {
        density: Some(0.2),
        stretch: Some(100.0.into()),
        shear: Some(40.0),
        bending: Some(1e-4.into()),
        damping: Some(FabricDamping { stretch: 1e-7, bending: 1e-7 }),
        ..Material::default()
    };
    let body = Body::cloth("sheet", Mesh::sheet([0.5, 0.4], 0.04)).with_material(material);
    weightless("fabric", 0.1, 0.1).body(body)
}

fn scaled(spring: &mut Option<Spring>, [k, d]: [f64; 2]) {
    let spring = spring.as_mut().unwrap();
    (spring.k, spring.d) = (k * spring.k, d * spring.d);
}

fn material(scene: &mut Scene) -> &mut Material {
    scene.bodies[0].material.as_mut().unwrap()
}

fn times(numbers: &mut Option<WarpWeft>, by: f64) {
    let both = numbers.unwrap();
    *numbers = Some(WarpWeft { warp: by * both.warp, weft: by * both.weft });
}

/// All that may be too large in a scene of springs, and in one of fabric.
fn all() -> Vec<(Scene, Planted)> {
    let planted = |source, is_damping, times, change: fn(&mut Scene, f64)| Planted {
        source,
        is_damping,
        times,
        change,
    };
    use Source::{Drag, Elements, Springs};
    use SpringKind::{Bend, Shear, Structural};
    let in_springs = [
        planted(Springs(Structural), false, 3e3, |s, by| {
            scaled(&mut s.bodies[0].springs.structural, [by, 1.0]);
        }),
        planted(Springs(Structural), true, 1e4, |s, by| {
            scaled(&mut s.bodies[0].springs.structural, [1.0, by]);
        }),
        planted(Springs(Shear), false, 3e3, |s, by| scaled(&mut s.bodies[0].springs.shear, [by, 1.0])),
        planted(Springs(Bend), true, 1e4, |s, by| scaled(&mut s.bodies[0].springs.bend, [1.0, by])),
        planted(Elements("hinges"), false, 3e4, |s, by| {
            s.bodies[0].springs.hinge.as_mut().unwrap().k *= by;
        }),
        planted(Elements("hinges"), true, 1e5, |s, by| s.bodies[0].springs.hinge.as_mut().unwrap().d *= by),
        planted(Drag, true, 1.0, |s, by| s.world.drag = 100.0 * by),
    ];
    let in_fabric = [
        planted(Elements("membranes"), false, 1e3, |s, by| {
            times(&mut material(s).stretch, by);
            material(s).shear = Some(40.0 * by);
        }),
        planted(Elements("membranes"), true, 1e6, |s, by| {
            material(s).damping.as_mut().unwrap().stretch *= by;
        }),
        planted(Elements("bends"), false, 1e4, |s, by| times(&mut material(s).bending, by)),
        planted(Elements("bends"), true, 1e8, |s, by| material(s).damping.as_mut().unwrap().bending *= by),
    ];
    let with = |scene: fn() -> Scene| move |one| (scene(), one);
    in_springs.into_iter().map(with(springs)).chain(in_fabric.into_iter().map(with(fabric))).collect()
}

#[test]
fn what_is_too_large_is_named_and_lowering_it_alone_makes_the_step_stable() {
    for (scene, planted) in all() {
        let words = format!("{:?} {}", planted.source, planted.is_damping);
        let without = build(&scene).largest_stable_step_folded();
        let mut scene = scene;
        (planted.change)(&mut scene, planted.times);
        let with = build(&scene).largest_stable_step_folded();
        assert!(with < 0.3 * without, "{words}: {with} s with it, {without} s without");
        // Longer than all of it allows, but not than the rest does.
        let step = (with * without).sqrt();
        scene = scene.time(10.0 * step, step);
        let simulation = build(&scene);
        let culprit = simulation.largest_step_culprit().unwrap().clone();
        assert_eq!((culprit.part.source, culprit.part.is_damping), (planted.source, planted.is_damping));
        assert!(culprit.share > 0.5, "{words}: {}", culprit.share);
        // At first, what is planted is little beside the rest.
        let (alone, rest) = (culprit.alone.unwrap(), culprit.without.unwrap());
        assert!(alone > 0.99 * with && alone < 1.3 * with, "{words}: alone {alone} s, all {with} s");
        assert!(rest > 0.9 * without, "{words}: {rest} s, {without} s at first");
        let said = warnings(&simulation).join("\n");
        assert!(said.contains(&format!("{culprit} allows")), "{said}");
        let advised = said.contains("or lower the ") || said.contains("or multiply the ");
        assert!(advised && !said.contains("the mass by"), "{said}");
        // The advice is taken, and does. It is no more than needed by far.
        let factor = culprit.factor.unwrap();
        (planted.change)(&mut scene, factor);
        // A stiff zone of a test may be stiffer than fabrics.
        let still = warnings(&build(&scene)).into_iter().filter(|said| said.contains("stable step"));
        assert_eq!(still.collect::<Vec<_>>(), [""; 0], "{words}");
        let longest = build(&scene).largest_stable_step_folded();
        assert!(longest < 1.6 * step, "{words}: {longest} s, {step} s was wanted");
    }
}

#[test]
fn where_two_are_too_large_all_must_be_lowered() {
    let mut scene = springs();
    scene.bodies[0] = scene.bodies[0].clone().structural(6000.0, 0.0).hinge(0.02, 0.2);
    let simulation = build(&scene);
    let culprit = simulation.largest_step_culprit().unwrap();
    assert_eq!((culprit.part.source, culprit.part.is_damping), (Source::Elements("hinges"), true));
    assert!(culprit.factor.is_none() && culprit.without.is_some_and(|step| step < 0.1));
    let said = warnings(&simulation).join("\n");
    // Of a cloth a million times softer nothing is said: another form would do.
    assert!(
        said.contains("primal form") && !said.contains("lower the") && !said.contains("multiply"),
        "{said}"
    );
}

#[test]
fn a_step_that_is_short_needs_no_culprit_but_has_one() {
    let scene = springs().time(1e-4, 1e-4);
    let culprit = build(&scene).largest_step_culprit().unwrap().clone();
    assert_eq!((culprit.alone, culprit.without, culprit.factor), (None, None, None));
    let loose = Body::cloth("loose", Mesh::grid(3, 3, [1.0, 1.0])).with_mass(Mass::Node(0.1));
    assert_eq!(build(&weightless("", 1.0, 1.0).body(loose)).largest_step_culprit(), None);
}

/// A grid of fabric with a zone, and the same as a mesh.
fn zoned(zone: Option<[[u32; 2]; 2]>) -> [Scene; 2] {
    let (rows, cols, size) = (60, 62, [0.61, 0.59]);
    let scene = |mesh: Mesh, select: Option<Select>| {
        let mut material = Material::preset("cotton");
        if let Some(select) = select {
            material
                .zones
                .insert("stiff".into(), Zone { select, stretch: Some(9e3.into()), ..Zone::default() });
        }
        weightless("zone", 1e-3, 1e-3).body(Body::cloth("sheet", mesh).with_material(material))
    };
    let on_grid = zone.map(|[rows, cols]| Select { cols: Some(cols), ..Select::rows(rows[0], rows[1]) });
    let nodes = zone.map(|[from, to]| {
        let row = |row: u32| (to[0]..=to[1]).map(move |col| row * cols + col);
        Select::nodes((from[0]..=from[1]).flat_map(row).collect::<Vec<_>>())
    });
    let mesh = Mesh::Surface(Arc::new(grid_surface(rows, cols, size)));
    [scene(Mesh::grid(rows, cols, size), on_grid), scene(mesh, nodes)]
}

#[test]
fn a_stiff_zone_in_the_middle_of_a_large_grid_sets_the_step() {
    let step = |scene: &Scene| build(scene).largest_stable_step();
    let plain = step(&zoned(None)[0]);
    let [grid, mesh] = zoned(Some([[27, 33], [28, 34]]));
    let (on_grid, on_mesh) = (step(&grid), step(&mesh));
    assert!(on_grid < 0.5 * plain, "{on_grid} s, {plain} s without the zone");
    assert!((on_grid / on_mesh - 1.0).abs() < 0.01, "{on_grid} s on a grid, {on_mesh} s on a mesh");
    let vertex = build(&grid).largest_step_culprit().unwrap().vertex;
    assert!((26..=34).contains(&(vertex / 62)) && (27..=35).contains(&(vertex % 62)), "vertex {vertex}");
}
