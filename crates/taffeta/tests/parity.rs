//! Every kernel of the GPU's backend against its twin on the CPU.

use std::sync::LazyLock;
use taffeta::parity::{entry_points, rows};
use taffeta::taffeta_gpu::{Choice, Gpu};

static GPU: LazyLock<Gpu> =
    LazyLock::new(|| Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}")));

/// Runs the row of that name.
fn check(name: &str) {
    let row = rows().into_iter().find(|row| row.name == name).unwrap_or_else(|| panic!("no row `{name}`"));
    let outcome = row.run(&GPU).unwrap_or_else(|why| panic!("{name}: {why}"));
    let allowed = row.tolerance.on(&GPU);
    println!(
        "{name}: {} ulps of {allowed} in {} numbers, {:?}",
        outcome.ulps, outcome.compared, outcome.place
    );
    assert!(outcome.compared > 0, "{name} compares nothing");
    if let Some(place) = outcome.place.filter(|_| outcome.ulps > allowed) {
        let why = row.tolerance.why;
        panic!("{name}: {} units in the last place, {allowed} allowed ({why}): {place}", outcome.ulps);
    }
}

macro_rules! named_rows {
    ($($name:ident)*) => {
        $(#[test] fn $name() { check(stringify!($name)); })*
        const NAMES: &[&str] = &[$(stringify!($name)),*];
    };
}

named_rows! {
    integrate_all contact_all pins_all loads_all grid_springs_all mesh_springs_all
    grid_particles grid_particles_given mesh_particles mesh_particles_given
    bend_hinges scale_loads
    measure_nodes measure_grid_springs measure_mesh_springs measure_hinges measure_volumes
    angle_of spring_factor fold_of external depth_and_normal respond leave_both euler
}

#[test]
fn every_row_is_tested_by_its_name() {
    let names: Vec<&str> = rows().iter().map(|row| row.name).collect();
    assert_eq!(names, NAMES);
}

#[test]
fn every_entry_point_has_a_row() {
    let rows = rows();
    for entry in entry_points().expect("sources that naga reads") {
        assert!(rows.iter().any(|row| row.entry == entry), "kernel `{entry}` has no row");
    }
}
