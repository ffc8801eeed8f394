//! Every kernel of the GPU's backend against its twin on the CPU.

mod faults;
mod roundings;

use crate::common::gpu;
use std::path::Path;
use taffeta::parity::{entry_points, rows};

/// Runs the row of that name.
fn check(name: &str) {
    let row = rows().into_iter().find(|row| row.name == name).unwrap_or_else(|| panic!("no row `{name}`"));
    let gpu = gpu();
    let outcome = row.run(&gpu).unwrap_or_else(|why| panic!("{name}: {why}"));
    let allowed = row.tolerance.on(&gpu);
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
    integrate_all contact_all contact_all_meshes pins_all loads_all grid_springs_all mesh_springs_all
    grid_particles grid_particles_given grid_particles_later
    mesh_particles mesh_particles_given mesh_particles_later
    grid_patches mesh_patches vertex_normals draw_vertices
    volume_forces volume_forces_given volume_gradients volume_particles measure_kept_volumes restore_volumes
    restore_volumes_meshes
    mark_active list_active free_velocities set_up_rows predict_contacts predict_mesh_contacts start_rows
    count_systems solve_nodes solve_rows record_statistics apply_constraint_forces
    free_nodes predict_contacts_implicit predict_mesh_contacts_implicit step_on set_up_nodes coarsen_springs coarsen_edges coarsen_nodes
    start_nodes step_nodes left_of_nodes restrict_level left_of_level cycle_tail follow_level smooth_level smooth_nodes
    apply_nodes count_descents spring_impulses push_nodes note_descents
    set_up_couplings coarsen_couplings bound_couplings scale_inverses
    solve_joints solve_joint_groups apply_attachments
    clear_cells fill_cells find_self_contacts resolve_self_contacts contact_after_self_collision measure_self_contacts
    bend_hinges measure_hinges hinge_directions aero_forces scale_loads
    measure_nodes measure_grid_springs measure_mesh_springs measure_volumes
    angle_of spring_factor fold_of external depth_and_normal entry_of respond leave_both multiplier solve_symmetric exchange
    euler corner_force gust_velocity
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

/// The names that follow `@compute` in the WGSL under a folder, but for the formulas that only rows run.
fn compute_functions(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for path in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() && !path.ends_with("parity") {
            found.extend(compute_functions(&path));
        } else if path.extension().is_some_and(|extension| extension == "wgsl") {
            let text = std::fs::read_to_string(&path).expect("a text");
            let after = text.split("@compute").skip(1).filter_map(|rest| rest.split("fn ").nth(1));
            found.extend(after.filter_map(|rest| rest.split('(').next()).map(str::to_owned));
        }
    }
    found
}

#[test]
fn every_kernel_in_the_folders_is_among_the_entry_points() {
    let known = entry_points().expect("sources that naga reads");
    let written = compute_functions(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert_eq!(written.len(), known.len());
    for name in written {
        assert!(known.contains(&name), "no source of a kernel has `{name}`");
    }
}
