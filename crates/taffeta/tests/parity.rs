//! Every kernel of the GPU's backend against its twin on the CPU.

use std::cell::RefCell;
use std::path::Path;
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
    integrate_all contact_all contact_all_meshes pins_all loads_all grid_springs_all mesh_springs_all
    grid_particles grid_particles_given mesh_particles mesh_particles_given
    grid_patches mesh_patches vertex_normals
    volume_forces volume_forces_given volume_gradients volume_particles measure_kept_volumes restore_volumes
    restore_volumes_meshes
    mark_active list_active free_velocities set_up_rows meet_surfaces meet_meshes start_rows
    count_solves solve_nodes solve_rows note_solves pull_nodes
    free_nodes meet_nodes meet_meshes_by_nodes step_on set_up_nodes coarsen_springs coarsen_edges coarsen_nodes
    start_nodes step_nodes left_of_nodes restrict_level left_of_level cycle_tail follow_level smooth_level smooth_nodes
    apply_nodes count_descents spring_impulses push_nodes note_descents
    count_joints pull_joints attach_nodes
    clear_cells fill_cells find_pairs part_pairs contact_parted measure_pairs
    bend_hinges blow_on_panels scale_loads
    measure_nodes measure_grid_springs measure_mesh_springs measure_hinges measure_volumes
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

/// The names that follow `@compute` in the WGSL under a folder, but for the formulas that only rows run, and the
/// papers' kernels, which have tests of their own.
fn compute_functions(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for path in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() && !path.ends_with("parity") && !path.ends_with("paper") {
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

/// Faults in the sources: the row that must find each, what is written, and what is put in its place.
const FAULTS: &[(&str, &str, &str)] = &[
    ("grid_springs_all", "return own + ending;", "return own - ending;"),
    ("grid_springs_all", "col < this_grid.cols", "col <= this_grid.cols"),
    ("grid_particles", "v, 5u, 1, -1)", "v, 5u, 1, 1)"),
    ("grid_particles_given", "return load[node].xyz;", "return load[node].yxz;"),
    ("mesh_springs_all", "kind < KINDS", "kind + 1u < KINDS"),
    ("mesh_particles", "i < run.count", "i + 1u < run.count"),
    ("mesh_particles_given", "(runs[node / LANES * KINDS].count & IS_RING) == 0u", "true"),
    ("contact_all", "if touch.depth > 0.0 {", "if touch.depth > 0.001 {"),
    ("contact_all", "if touch.depth > 0.0 {", "if touch.depth >= 0.0 {"),
    ("contact_all", "!(node.position.w > 0.0)", "false"),
    ("contact_all", "i + 1u != node.last && ", ""),
    ("contact_all", "round < ROUNDS", "round < 2u"),
    ("contact_all", "-node.velocity.w, after.last > 0u", "-node.velocity.w, after.last > 1u"),
    (
        "respond",
        "touch.normal, collider.friction * impulse);",
        "touch.normal, 1.00001 * collider.friction * impulse);",
    ),
    ("respond", "closing > 0.0)", "true)"),
    ("depth_and_normal", "let far = squared > TINY", "let far = distance > TINY"),
    ("depth_and_normal", "beyond.x >= beyond.y && beyond.x", "beyond.x > beyond.y && beyond.x"),
    (
        "depth_and_normal",
        "let inside = deepest <= 0.0;\n    let way",
        "let inside = deepest < 0.0;\n    let way",
    ),
    (
        "depth_and_normal",
        "select(vec3f(1.0), vec3f(-1.0), x < vec3f(0.0))",
        "select(vec3f(1.0), vec3f(-1.0), x <= vec3f(0.0))",
    ),
    ("depth_and_normal", "select(1.0, some, some < 1.0)", "some"),
    ("depth_and_normal", "select(0.0, share, share > 0.0)", "share"),
    ("depth_and_normal", "axis.y * axis.y > 0.5", "axis.y * axis.y > 0.9"),
    ("depth_and_normal", "let by_end = end >= side;", "let by_end = end > side;"),
    ("depth_and_normal", "select(outside.y, 1.0 - flat, inside)", "outside.y"),
    ("entry_of", "if next > 1.0 {", "if next > 0.5 {"),
    ("entry_of", "const ENTRIES: u32 = 12u;", "const ENTRIES: u32 = 2u;"),
    ("entry_of", "if !(approach > 0.0) {", "if false {"),
    ("entry_of", "return least + collider.size;", "return least;"),
    ("entry_of", "select(collider.w, shorter, shorter < collider.w), collider.kind == BOX", "shorter, true"),
    ("contact_all", "dot3(way, way) > far * far", "false"),
    ("contact_all", "dot3(way, way) > far * far", "dot3(way, way) > 1.01 * far * far"),
    ("contact_all", "carried(collider, origin.x), origin.is_carried", "origin.x, true"),
    ("contact_all_meshes", "select(1.0, -1.0, mesh.is_solid && within)", "1.0"),
    ("contact_all_meshes", "hit.inward && leaves", "leaves"),
    (
        "contact_all_meshes",
        "at_end.depth <= 0.0 || dot3(at_end.normal, end - start) > 0.0",
        "at_end.depth <= 0.0",
    ),
    ("contact_all_meshes", "at_end.depth <= 0.0 || dot3(at_end", "dot3(at_end"),
    ("contact_all_meshes", "const GROOVES: u32 = 4u;", "const GROOVES: u32 = 1u;"),
    ("contact_all_meshes", "corners_in(at) == corners_in(own)", "triangle == found.triangle"),
    ("contact_all_meshes", "min(best.squared, most) * LOOSE + mesh.grain", "0.5 * min(best.squared, most)"),
    ("contact_all_meshes", "+ turned(collider, found.velocity)", ""),
    (
        "contact_all_meshes",
        "corners_of(mesh, triangle, collider.u)",
        "corners_of(mesh, triangle, collider.v)",
    ),
    ("contact_all_meshes", "if triangle >= mesh.count {", "if triangle + 1u >= mesh.count {"),
    ("contact_all_meshes", "found.share < first.share ||", "found.share > first.share ||"),
    ("contact_all_meshes", "min(start, end) - reach, max(start, end) + reach", "end - reach, end + reach"),
    (
        "contact_all_meshes",
        "if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {",
        "if vc <= 0.0 && d1 >= 0.0 && d3 < -0.1 {",
    ),
    ("contact_all_meshes", "let side = select(-unit, unit, inward);", "let side = unit;"),
    (
        "contact_all_meshes",
        "let squared = dot3(apart, apart);\n    if squared",
        "let squared = dot3(apart, apart) * 1.00001;\n    if squared",
    ),
    ("contact_all_meshes", "within = select(most * most, FAR, mesh.is_solid)", "within = most * most"),
    ("contact_parted", "|| contacts_of(node) == 0u", ""),
    ("contact_parted", "select(after.velocity.w, -abs(v.w), v.w < 0.0)", "after.velocity.w"),
    ("meet_meshes", "if held.inside > found.inside {", "if held.inside > 0.0 {"),
    ("meet_meshes", "touch.depth - node.h * dot3", "touch.depth + node.h * dot3"),
    ("meet_meshes", "|| !(x.w > 0.0)", ""),
    ("meet_meshes", "|| substeps[0].solving.is_adaptive != 0u", ""),
    ("meet_meshes", "* gather_pulls(node) * -h", "* gather_pulls(node) * h"),
    ("meet_meshes_by_nodes", "h, vector_of(PULLED, node))", "h, vec3f(0.0))"),
    ("meet_meshes_by_nodes", "if x.w > 0.0 {", "{"),
    ("meet_surfaces", "if before.inside > 0.0 {", "if false {"),
    ("meet_surfaces", "if before.inside > 0.0 {", "if true {"),
    ("leave_both", "room <= NARROW", "room <= 1.1 * NARROW"),
    ("leave_both", "first.depth * cosine >= second.depth", "first.depth * cosine > second.depth"),
    ("angle_of", "angle > PI", "angle >= PI"),
    ("angle_of", "let is_up = up > across;", "let is_up = up >= across;"),
    ("spring_factor", "length_squared < TINY);", "length_squared < 2.0 * TINY);"),
    ("fold_of", "along_d - 1.0", "along_d + 1.0"),
    ("external", "let some = sum > TINY;", "let some = sum > 0.0;"),
    ("euler", "inverse_mass > 0.0", "inverse_mass > 0.35"),
    ("integrate_all", "inverse_mass > 0.0", "inverse_mass >= 0.0"),
    (
        "grid_patches",
        "part.first_row + 2, 0, part.first_row == 0",
        "part.first_row + 2, 2, part.first_row == 0",
    ),
    ("mesh_patches", "node.position.w > 0.0", "true"),
    ("vertex_normals", "p.zxy * q.yzx", "p.zxy * q.zxy"),
    ("integrate_all", "abs(v.w)", "v.w"),
    ("pins_all", "index >= substeps[0].pins", "index + 1u >= substeps[0].pins"),
    ("pins_all", "abs(new_velocity[pin.node].w)", "new_velocity[pin.node].w"),
    ("loads_all", "&& bitcast<u32>(hand_forces[i].w) == node; i++", "&& i < 1u; i++"),
    ("blow_on_panels", "index >= arrayLength(&panels)", "index + 1u >= arrayLength(&panels)"),
    ("blow_on_panels", "substeps[0].air.first_force + index", "index"),
    ("blow_on_panels", "cross3(b - a, c - a), flow", "cross3(b - a, c - b) * 1.0000002, flow"),
    ("blow_on_panels", "velocity_of(panel.c)) * THIRD", "velocity_of(panel.b)) * THIRD"),
    ("blow_on_panels", "air.velocity + gust_velocity(air.gusts, x)", "air.velocity"),
    ("corner_force", "area > TINY && speed > TINY;", "area > TINY;"),
    ("corner_force", "area > TINY && speed > TINY;", "speed > TINY;"),
    ("corner_force", "area > TINY && speed > TINY;", "area > TINY && speed > 2.0 * TINY;"),
    ("corner_force", "air.drag * abs(through)", "air.drag * through"),
    ("corner_force", "air.lift * through", "air.lift * abs(through)"),
    ("corner_force", "(turn - sine)", "turn"),
    ("corner_force", "* lift * cosine_squared", "* lift"),
    ("corner_force", "select(0.0, rest, rest > 0.0)", "rest"),
    ("corner_force", "d * d + exposure * lift * turn", "d + exposure * lift * turn"),
    ("gust_velocity", "if start > p {", "if start >= p {"),
    ("gust_velocity", "if start > p {", "if false {"),
    ("gust_velocity", "select(FARTHEST_CELL, number, number < FARTHEST_CELL)", "number"),
    ("gust_velocity", "select(-FARTHEST_CELL, low, low > -FARTHEST_CELL)", "low"),
    ("gust_velocity", "(bits >> 12u) % VALUES", "bits >> 12u"),
    ("gust_velocity", "(bits >> 2u) % VALUES", "bits % VALUES"),
    ("gust_velocity", "a ^ (a >> 15u)", "a ^ (a >> 16u)"),
    ("gust_velocity", "k * STRIDE_Z", "k * STRIDE_Y"),
    ("gust_velocity", "select(c.x, c.y, k == 1u)", "c.y"),
    ("gust_velocity", "sum * (1.0 / sqrt(squares))", "sum"),
    ("loads_all", "of_elements += element_forces", "of_elements = element_forces"),
    (
        "volume_forces",
        "select(0.0, factor, entry.rest_length > 0.0)",
        "select(0.0, factor, entry.rest_length != 0.0)",
    ),
    ("volume_forces", "let is_there = rest_length != 0.0;", "let is_there = rest_length > 0.0;"),
    ("volume_forces", "let is_there = rest_length != 0.0;", "let is_there = true;"),
    ("volume_forces", "with_triangle(way, way.first, count > 0u) / 6.0", "way.sum / 6.0"),
    ("volume_forces", "add_kinds(before + sum, 1u,", "add_kinds(before + sum, 2u,"),
    ("volume_forces", "group.first_group && lane == 0u", "0u && lane == 0u"),
    (
        "volume_forces",
        "if lane < half {\n            volume_lanes",
        "if lane + 1u < half {\n            volume_lanes",
    ),
    ("volume_forces", "vec4f(terms.moment, terms.mass)", "vec4f(terms.moment, 0.0)"),
    ("volume_forces", "node.weight * plain.z", "plain.z"),
    ("volume_forces_given", "lane, force[place].xyz)", "lane, vec3f(0.0))"),
    ("volume_forces_given", "vec4f(pulled.gradient, weight)", "vec4f(pulled.gradient, 1.0)"),
    ("volume_forces_given", "if lane < group.count {", "{"),
    (
        "volume_gradients",
        "new_velocity_of(v.xyz, pulled.force, x.w",
        "new_velocity_of(v.xyz, pulled.force, abs(v.w)",
    ),
    ("volume_gradients", "x.xyz - position_of(group.origin)", "x.xyz - position_of(group.first)"),
    ("measure_kept_volumes", "select(1.0, 0.0, node.inverse_mass > 0.0)", "0.0"),
    ("volume_particles", "if group.groups == 1u {", "if true {"),
    ("multiplier", "<= PROJECTED * goal", "< PROJECTED * goal"),
    ("multiplier", "let some = response > TINY;", "let some = response >= TINY;"),
    ("solve_symmetric", "const FLAT: f32 = 1e-7;", "const FLAT: f32 = 1.02e-7;"),
    ("solve_symmetric", "if trace <= 0.0 {", "if trace < 0.0 {"),
    ("solve_symmetric", "vec3f(c.z, f, g)", "vec3f(c.z, g, f)"),
    ("volume_particles", "|| sums.held > 0.0", ""),
    ("volume_gradients", "vec4f(terms.diagonal, terms.held)", "vec4f(terms.diagonal, 0.0)"),
    ("volume_gradients", "return VolumeNode(vec3f(0.0), 1.0,", "return VolumeNode(vec3f(0.0), 0.0,"),
    ("restore_volumes", "|| sums.held > 0.0", "|| true"),
    ("volume_particles", "case PAPER_SHADER: {", "case 4u: {"),
    ("volume_particles", "off / (3.0 * h * h)", "off / (h * h)"),
    ("volume_particles", "return -goal;", "return goal;"),
    ("volume_particles", "return -gradient.xyz;", "return -gradient.xyz * gradient.w * 1.00001;"),
    (
        "volume_particles",
        "way_of(group, found.push, lane, x.xyz, abs(v.w))",
        "way_of(group, found.push, lane, x.xyz, v.w)",
    ),
    ("volume_particles", "+ group.first_group].xyz;", "+ group.first_group + 1u].xyz;"),
    ("volume_particles", "vec4f(velocity, abs(v.w))", "vec4f(velocity, v.w)"),
    (
        "measure_kept_volumes",
        "let inverse_mass = select(x.w, 0.0, signed_mass < 0.0);",
        "let inverse_mass = x.w;",
    ),
    ("measure_kept_volumes", "if !is_flagged(group, RESTORED) {", "if false {"),
    ("measure_kept_volumes", "gradient, abs(signed_mass), all", "gradient, signed_mass, all"),
    ("measure_kept_volumes", "gradient * (x.w * weight)", "gradient * (inverse_mass * weight)"),
    ("restore_volumes", "const FEW: f32 = 0.0625;", "const FEW: f32 = 2.0;"),
    ("restore_volumes", "const PROJECTED: f32 = 1e-6;", "const PROJECTED: f32 = 1.3e-6;"),
    ("restore_volumes", "const PROJECTED: f32 = 1e-6;", "const PROJECTED: f32 = 0.7e-6;"),
    ("restore_volumes", "abs(sums.x / 3.0 - goal)", "(sums.x / 3.0 - goal)"),
    ("restore_volumes", "select(x.w, 0.0, v.w < 0.0) * lambda", "x.w * lambda"),
    ("restore_volumes", "select(after.velocity.w, -abs(v.w), v.w < 0.0)", "after.velocity.w"),
    ("restore_volumes", "let some = response > TINY;", "let some = response >= 0.0;"),
    ("mark_active", "squared > substeps[0].solving.activation", "squared >= substeps[0].solving.activation"),
    ("mark_active", "squared > substeps[0].solving.release", "squared >= substeps[0].solving.release"),
    ("mark_active", "link.is_active != 0u && squared", "squared"),
    ("mark_active", "(a.w > 0.0 || b.w > 0.0) &&", ""),
    (
        "mark_active",
        "if lane < group.count {\n        own = select",
        "if lane < 255u {\n        own = select",
    ),
    ("list_active", "i < index; i += 256u", "i < index; i += 255u"),
    ("list_active", "i < index; i += 256u", "i <= index; i += 256u"),
    ("list_active", "before + up_to - 1u", "before + up_to"),
    ("list_active", "reach < 256u; reach *= 2u", "reach < 128u; reach *= 2u"),
    ("list_active", "index + 1u == group.first_group + group.groups", "index == group.first_group"),
    ("list_active", "link_groups[group.first_group].first + before", "before"),
    ("free_velocities", "if link.is_active != 0u {", "if true {"),
    ("free_velocities", "select(link.a, link.b, link.a == node)", "link.b"),
    (
        "free_velocities",
        "substeps[0].solving.is_adaptive != 0u {\n                let other",
        "false {\n                let other",
    ),
    ("free_velocities", "at < range.y && incident[at] != NONE", "incident[at] != NONE"),
    ("free_velocities", "abs(v.w));\n    met", "v.w);\n    met"),
    ("set_up_rows", "if softness.form == PRINTED_CONSTRAINT {", "if false {"),
    ("set_up_rows", "select(0.0, scale, inverse_mass > 0.0)", "scale"),
    ("set_up_rows", "softness.compliance + softness.epsilon", "softness.compliance - softness.epsilon"),
    (
        "set_up_rows",
        "length_squared < TINY);\n    let length",
        "length_squared < 2.0 * TINY);\n    let length",
    ),
    ("set_up_rows", "substeps[0].solving.aim * link.rest_length", "link.rest_length"),
    ("start_rows", "substeps[0].solving.is_warm == 0u", "false"),
    ("set_up_rows", "pull / select(1.0, row.scale, row.scale > 0.0)", "pull"),
    ("set_up_rows", "if links[number].is_active != 0u {", "{"),
    ("set_up_rows", "solves[group.solve].next = start;", ""),
    ("set_up_rows", "abs(x.x) + abs(x.y) + abs(x.z)", "x.x + abs(x.y) + abs(x.z)"),
    (
        "count_solves",
        "solves[i].active_links > 0u && solves[i].kept.is_done == 0u",
        "solves[i].kept.is_done == 0u && i > 9u",
    ),
    ("count_solves", "lane == 1u);\n        let across", "lane == 0u);\n        let across"),
    ("count_solves", "select(0u, min(groups, COUNTED_ROW), all > 0u)", "min(groups, COUNTED_ROW)"),
    ("solve_nodes", "if kept.passes == 1u {", "if kept.passes <= 2u {"),
    ("solve_nodes", "if kept.passes < 2u {", "if kept.passes < 1u {"),
    (
        "solve_nodes",
        "max(substeps[0].solving.tolerance_squared * sums.x, sums.y)",
        "substeps[0].solving.tolerance_squared * sums.x",
    ),
    ("solve_nodes", "sums.x > next.limit", "sums.x >= next.limit"),
    ("solve_nodes", "kept.passes - 2u < substeps", "kept.passes - 1u < substeps"),
    ("solve_nodes", "let first = before.gamma == 0.0;", "let first = false;"),
    ("solve_nodes", "curvature > 0.0 && alpha <= LARGEST", "true"),
    ("solve_nodes", "next.alpha * (row.w + next.beta * row.s)", "next.alpha * row.w"),
    ("solve_nodes", "select(-1.0, 1.0, entry % 2u == 1u)", "1.0"),
    ("solve_nodes", "i * 256u < active_count; i += 256u", "i * 256u <= active_count; i += 256u"),
    ("solve_nodes", "if met[node].is_pulled == 0u {", "if false {"),
    ("solve_nodes", "old_position[node].w * sum", "sum"),
    ("solve_nodes", "(v - press.normal * dot3(v, press.normal)) * press.yields", "v * press.yields"),
    (
        "solve_nodes",
        "(v - press.normal * dot3(v, press.normal)) * press.yields",
        "(v - press.normal * dot3(v, press.normal))",
    ),
    ("solve_rows", "row.r + step.beta * row.p", "row.r + row.p"),
    (
        "solve_rows",
        "response[link.b].xyz - response[link.a].xyz",
        "response[link.a].xyz - response[link.b].xyz",
    ),
    ("solve_rows", "next.passes + 1u;", "next.passes;"),
    ("solve_rows", "if in_body < active_count {", "{"),
    ("solve_rows", "active_links[link_groups[group.first_group].first + in_body]", "(group.first + lane)"),
    ("solve_rows", "row_scales[number].y * row.r", "row_scales[number].x * row.r"),
    ("solve_nodes", "let helps = sums.z > 0.0 && sums.w > 0.0;", "let helps = true;"),
    ("solve_nodes", "select(left, first, kept.passes == 1u)", "left"),
    ("solve_rows", "row.r = row.p - step.alpha * row.w;", "row.r = row.p - row.w;"),
    ("solve_rows", "row.x *= step.alpha;", ""),
    ("solve_rows", "row.x * row.p, row.x * row.w)", "row.x * row.p, row.r * row.p)"),
    ("solve_rows", "row.s * row.s", "row.s"),
    ("note_solves", "done.gamma > done.limit", "done.gamma >= done.limit"),
    ("note_solves", "max(done.right, done.limit / substeps[0].solving.tolerance_squared)", "done.right"),
    ("note_solves", "+= min(count.z, 1u)", "+= count.z"),
    ("note_solves", "max(taken[0].residual, most.y)", "most.y"),
    ("pull_nodes", "borne(node, -gather_pulls(node))", "borne(node, gather_pulls(node))"),
    ("pull_nodes", "row.direction * row.x", "row.direction * row.r"),
    ("pull_nodes", "select(landing, inward, inward < landing)", "landing"),
    ("pull_nodes", "select(pulled, least, pulled < least)", "pulled"),
    ("pull_nodes", "select(some, landing, some > landing)", "some"),
    ("pull_nodes", "select(0.0, kept - pulled, kept > pulled)", "0.0"),
    ("pull_nodes", "moved - surface_velocity(collider, place)", "moved"),
    ("pull_nodes", "if press.yields == 0.0 {", "if false {"),
    ("pull_nodes", "substeps[0].first_collider + met[node].surface", "met[node].surface"),
    ("pull_nodes", "if !is_pressed(press) {", "if true {"),
    ("meet_surfaces", "held.inside > deepest || is_first", "held.inside > 0.0"),
    ("meet_surfaces", "node.place + v * node.h).depth", "node.place).depth"),
    ("meet_surfaces", "touch.depth / h;", "touch.depth;"),
    ("meet_surfaces", "-touch.depth <= reach", "true"),
    ("meet_surfaces", "select(node.fall, way + node.fall, way > 0.0)", "node.fall"),
    ("meet_surfaces", "* gather_pulls(node) * -h", "* gather_pulls(node) * h"),
    ("meet_surfaces", "slip <= collider.friction * impulse", "false"),
    ("meet_surfaces", "onto + along", "onto"),
    ("meet_surfaces", "if x.w > 0.0 {\n            let fall", "{\n            let fall"),
    ("meet_surfaces", "substeps[0].colliders > 0u && substeps[0].solving.is_adaptive == 0u", "true"),
    ("meet_surfaces", "press.velocity * (1.0 / h)", "press.velocity"),
    ("start_rows", "if link.is_active != 0u {\n        let rate", "{\n        let rate"),
    (
        "start_rows",
        "response[link.b].xyz - response[link.a].xyz;\n        rows",
        "response[link.b].xyz;\n        rows",
    ),
    (
        "free_nodes",
        "lane >= level_groups[index].count {\n        return;\n    }\n    let node = level_groups[index].first + lane;\n    let v",
        "lane > level_groups[index].count {\n        return;\n    }\n    let node = level_groups[index].first + lane;\n    let v",
    ),
    ("free_nodes", "vec4f(free, abs(v.w))", "vec4f(free, v.w)"),
    (
        "meet_nodes",
        "return Met(vec3f(0.0), 0.0, vec3f(0.0), 0u, 1u, 0.0);",
        "return Met(vec3f(0.0), 1.0, vec3f(0.0), 0u, 1u, 0.0);",
    ),
    ("meet_nodes", "free, h, pulls)", "free, h, vec3f(0.0))"),
    ("meet_nodes", "substeps[0].solving.is_warm != 0u", "true"),
    ("meet_nodes", "yielded(press, pulled - total)", "(pulled - total)"),
    ("meet_nodes", "yielded(press, v.xyz) + press.velocity - free, x.w > 0.0)", "v.xyz - free, x.w > 0.0)"),
    ("meet_nodes", "press.velocity - free, x.w > 0.0)", "press.velocity - free, true)"),
    ("meet_nodes", "abs(v.w) * dot3(off, off)", "v.w * dot3(off, off)"),
    ("meet_nodes", "let off = select(vec3f(0.0), v.xyz - free, x.w > 0.0);", "let off = total;"),
    ("meet_nodes", "NodeSolve(0u, none, none)", "NodeSolve(1u, none, none)"),
    (
        "step_on",
        "vector_of(TOTAL, node) + vector_of(CHANGE, node);\n    put",
        "vector_of(CHANGE, node);\n    put",
    ),
    ("step_on", "before.before + before.next.iterations", "before.next.iterations"),
    ("step_on", "Descent(0u, 0u, 0u, before.next.whole", "Descent(0u, 0u, 0u, before.kept.whole"),
    ("step_on", "let velocity = free + total;", "let velocity = free - total;"),
    ("set_up_nodes", "select(taut, k, taut > k)", "taut"),
    ("set_up_nodes", "let taut = abs(pull) * inverse;", "let taut = pull * inverse;"),
    ("set_up_nodes", "let left = h * (k * h + e) - across;", "let left = h * (k * h - e) - across;"),
    ("set_up_nodes", "sum.diagonal + q * q + across", "sum.diagonal + q * q"),
    ("set_up_nodes", "link.pull + spring.damping", "link.pull - spring.damping"),
    (
        "set_up_nodes",
        "if press.yields == 0.0 {\n        return Diagonal",
        "if false {\n        return Diagonal",
    ),
    ("set_up_nodes", "sum_of(own, held_block(all, press.normal))", "own"),
    ("set_up_nodes", "given.impulse - mass * vector_of(TOTAL, node)", "given.impulse"),
    ("set_up_nodes", "+ FLOOR * EPSILON * trace", ""),
    ("set_up_nodes", "(dot3(n, w) + tau) * 0.5", "dot3(n, w) * 0.5"),
    ("set_up_nodes", "all.mixed - by * normal.mixed", "all.mixed"),
    (
        "set_up_nodes",
        "at < range.y; at += LANES) {\n        let spring",
        "at + LANES < range.y; at += LANES) {\n        let spring",
    ),
    (
        "coarsen_springs",
        "i < edge.first + edge.count; i++) {\n        let link",
        "i + 1u < edge.first + edge.count; i++) {\n        let link",
    ),
    ("coarsen_springs", "coarse_blocks[edge.slots.y] = sum;", ""),
    (
        "coarsen_edges",
        "scaled(coarse_blocks[edge_shares[i].at], edge_shares[i].weight)",
        "coarse_blocks[edge_shares[i].at]",
    ),
    ("coarsen_edges", "coarse_blocks[edge.slots.x] = sum;", ""),
    (
        "coarsen_nodes",
        "diagonals[children[i].at].own, children[i].weight",
        "diagonals[children[i].at].inverse, children[i].weight",
    ),
    (
        "coarsen_nodes",
        "let first = slots[0];\n    for (var at = range.x; at < range.y; at += LANES) {\n        // Those",
        "let first = slots[1];\n    for (var at = range.x; at < range.y; at += LANES) {\n        // Those",
    ),
    (
        "start_nodes",
        "node_solves[group.solve].kept.passes = 1u;",
        "node_solves[group.solve].kept.passes = 2u;",
    ),
    ("start_nodes", "let left = yielded(press, vector_of(LEFT, node));", "let left = vector_of(LEFT, node);"),
    ("start_nodes", "vectors[vector_at(TOTAL, node)].w, 0.0)", "0.0, 0.0)"),
    ("step_nodes", "i < group.groups; i += 256u", "i + 1u < group.groups; i += 256u"),
    ("step_nodes", "let helps = sums.x > 0.0 && sums.y > 0.0;", "let helps = true;"),
    ("step_nodes", "select(sums.z, kept.whole, kept.whole > 0.0)", "sums.z"),
    ("step_nodes", "before == 0u && kept.iterations == 0u", "kept.iterations == 0u"),
    ("step_nodes", "max(sums.x, kept.whole)", "sums.x"),
    ("step_nodes", "if !step.is_there {", "if false {"),
    ("step_nodes", "done.error <= substeps[0]", "done.error < substeps[0]"),
    ("step_nodes", "|| next.iterations == substeps[0].solving.most_iterations", ""),
    (
        "step_nodes",
        "let is_stuck = next.is_done != 0u && next.iterations == kept.iterations;",
        "let is_stuck = next.is_done != 0u;",
    ),
    ("step_nodes", "change + step.alpha * vector_of(CYCLED, node)", "step.alpha * vector_of(CYCLED, node)"),
    ("step_nodes", "product + step.beta * vector_of(WAY_PRODUCT, node)", "product"),
    (
        "step_nodes",
        "times(diagonals[node].inverse, DAMPING * left)",
        "times(diagonals[node].own, DAMPING * left)",
    ),
    ("left_of_nodes", "yielded(press_at(node), left));", "left);"),
    ("left_of_nodes", "var sum = mass * own;", "var sum = vec3f(0.0);"),
    ("left_of_nodes", "sum + q * dot3(q, u) + across * u", "sum + q * dot3(q, u)"),
    (
        "restrict_level",
        "let last = children[node + 1u].at;\n    var sum",
        "let last = children[node + 1u].at - 1u;\n    var sum",
    ),
    ("restrict_level", "children[i].weight * vector_of(CYCLED", "vector_of(CYCLED"),
    ("left_of_level", "var sum = times(diagonals[node].own, own);", "var sum = vec3f(0.0);"),
    ("left_of_level", "m.mixed.y * v.x + m.mixed.z * v.y", "m.mixed.z * v.x + m.mixed.y * v.y"),
    ("cycle_tail", "if index != group.first_group ||", "if index == group.first_group ||"),
    ("cycle_tail", "if is_there && level + 1u < group.groups {", "if is_there && level > 0u {"),
    ("cycle_tail", "sweep + 1u < SWEEPS", "true"),
    (
        "cycle_tail",
        "for (var level = 1u; level < group.groups; level++) {",
        "for (var level = 2u; level < group.groups; level++) {",
    ),
    ("follow_level", "way = yielded(press_at(node), way);", ""),
    (
        "follow_level",
        "above.weights.w * vector_of(CYCLED, above.nodes.w)",
        "above.weights.w * vector_of(CYCLED, above.nodes.z)",
    ),
    ("smooth_level", "vector_of(before, node) + jacobi_step", "jacobi_step"),
    ("smooth_nodes", "vector_of(CYCLE, node) + jacobi_step(node, left)", "jacobi_step(node, left)"),
    (
        "apply_nodes",
        "next.passes + 1u;\n    }\n    if next.is_done != 0u {\n        return;\n    }\n    var terms = vec4f(0.0);\n    if lane < group.count {\n        terms = applied",
        "next.passes;\n    }\n    if next.is_done != 0u {\n        return;\n    }\n    var terms = vec4f(0.0);\n    if lane < group.count {\n        terms = applied",
    ),
    ("apply_nodes", "if lane < group.count {\n        terms = applied", "{\n        terms = applied"),
    (
        "apply_nodes",
        "let product = yielded(press_at(node), springs_times(mass_of(node), CYCLED, node));",
        "let product = springs_times(mass_of(node), CYCLED, node);",
    ),
    ("count_descents", "node_solves[i].kept.is_done == 0u", "node_solves[i].kept.is_done != 0u"),
    (
        "count_descents",
        "select(0u, min(groups, COUNTED_ROW), all > 0u);\n        level_counts",
        "min(groups, COUNTED_ROW);\n        level_counts",
    ),
    ("spring_impulses", "springs_times(0.0, CHANGE, node)", "springs_times(1.0, CHANGE, node)"),
    ("push_nodes", "if !(inverse_mass > 0.0) {", "if false {"),
    (
        "push_nodes",
        "vector_of(TOTAL, node) + vector_of(CHANGE, node);\n    if !is_pressed",
        "vector_of(CHANGE, node);\n    if !is_pressed",
    ),
    ("push_nodes", "return found + press.normal * dot3(springs - found, press.normal);", "return springs;"),
    ("push_nodes", "after_pulls(press, free, pulled, collider, old_position[node].xyz) - free", "pulled"),
    ("push_nodes", "mass_of(node) / substeps[0].h", "substeps[0].h"),
    ("note_descents", "select(1u, 0u, is_solved(done))", "0u"),
    ("note_descents", "node_solves[i].before + done.iterations", "done.iterations"),
    ("note_descents", "select(0.0, share, done.whole > 0.0)", "done.error"),
    ("clear_cells", "pair_work[bucket] = NONE;", "pair_work[bucket] = 0u;"),
    ("clear_cells", "return length - 3u", "return length - 2u"),
    ("fill_cells", "number == NONE || are_odd(x) {", "number == NONE {"),
    ("fill_cells", "place - surfaces[number].first >= surfaces[number].count", "false"),
    ("fill_cells", "vec3f(-FARTHEST), vec3f(FARTHEST)", "vec3f(-1e6), vec3f(1e6)"),
    ("fill_cells", "let next = atomicExchange(&linked[bucket], node);", "let next = NONE;"),
    ("count_joints", "var at = list + 1u; at < end; at++", "var at = list + 2u; at < end; at++"),
    ("count_joints", "1u - joint_broken[attached[at] / 2u]", "1u"),
    ("pull_joints", "let by = -size / distance;", "let by = size / distance;"),
    ("pull_joints", "if distance > 0.0 && give > 0.0 {", "if give > 0.0 {"),
    ("pull_joints", "if distance > 0.0 && give > 0.0 {", "if distance > 0.0 {"),
    ("pull_joints", "/ (give + softness)", "/ give"),
    ("pull_joints", "(distance - goal)", "distance"),
    ("pull_joints", "start * (1.0 - share) + end * share", "end"),
    ("pull_joints", "inverse_mass.y * f32(joints.y)", "inverse_mass.y"),
    ("pull_joints", "joints_left[select(joint.b, joint.a, joint.b == NONE)]", "1u"),
    ("pull_joints", "joint_broken[row] != 0u || pull", "pull"),
    ("pull_joints", "> joint.break_force", "< joint.break_force"),
    ("pull_joints", "goals[substeps[0].first_goal + joint.closing]", "goals[joint.closing]"),
    ("pull_joints", "motions[substeps[0].first_motion + joint.track]", "motions[joint.track]"),
    ("pull_joints", "if joint.track == NONE {", "if true {"),
    ("pull_joints", "select(vec4f(pull.shift, 1.0), vec4f(0.0), breaks)", "vec4f(pull.shift, 1.0)"),
    ("attach_nodes", "select(1.0, -1.0, attached[at] % 2u == 1u)", "1.0"),
    ("attach_nodes", "one.w != 0.0", "true"),
    ("attach_nodes", "sum * (x.w / substeps[0].h)", "sum * x.w"),
    ("attach_nodes", "if squared > reach * reach {", "if false {"),
    ("attach_nodes", "select(0.0, speed, speed > 0.0)", "speed"),
    ("attach_nodes", "dot3(v - along, outward)", "dot3(v, outward)"),
    ("attach_nodes", "const TETHER_ROUNDS: u32 = 8u;", "const TETHER_ROUNDS: u32 = 2u;"),
    ("attach_nodes", "moved = moved || now.moved;", "moved = now.moved;"),
    ("attach_nodes", "Origin(x.xyz, false), 0u)", "Origin(x.xyz, false), 1u)"),
    ("attach_nodes", "all(now.x == x.xyz) && all(now.v == v.xyz)", "false"),
    ("find_pairs", "dot3(d, d) < reach * reach", "dot3(d, d) <= reach * reach"),
    ("find_pairs", "bucket < 27u", "bucket < 24u"),
    ("find_pairs", "bucket % 3u", "bucket % 2u"),
    ("find_pairs", "other != node && ", ""),
    ("find_pairs", "surface_number(other) != number || ", ""),
    ("find_pairs", "apart[lists + at] == b;", "false;"),
    ("find_pairs", "i32(surface.wide);", "i32(surface.wide) + 1;"),
    ("find_pairs", "step - 1u] < b {", "step - 1u] <= b {"),
    ("find_pairs", "select(some.d.w + 1u, NONE, some.d.w == NONE)", "NONE"),
    (
        "find_pairs",
        "if any(all.a == n) || any(all.b == n) || any(all.c == n) || any(all.d == n) {",
        "if false {",
    ),
    ("find_pairs", "vec4u(all.b.w, all.c.xyz)", "vec4u(0u, all.c.xyz)"),
    ("find_pairs", "share < nearest)", "share > nearest)"),
    ("find_pairs", "NONE, number == NONE || are_odd(x)", "NONE, are_odd(x)"),
    ("part_pairs", "select(-1.0, 1.0, node == a)", "1.0"),
    ("part_pairs", "vec2u(contacts_of(a), contacts_of(b))", "vec2u(contacts_of(a), contacts_of(a))"),
    (
        "part_pairs",
        "vec2f(old_position[a].w, old_position[b].w)",
        "vec2f(old_position[a].w, old_position[a].w)",
    ),
    ("part_pairs", "substeps[0].most_apart", "1.0"),
    ("part_pairs", "let a = min(node, other);", "let a = node;"),
    ("part_pairs", "if contacts_of(node) == 0u {", "if false {"),
    ("part_pairs", "touch(moved, Origin(x.xyz, false), 0u)", "moved"),
    ("part_pairs", "select(after.velocity.w, -abs(v.w), v.w < 0.0)", "after.velocity.w"),
    ("exchange", "let is_apart = distance > 0.0;", "let is_apart = distance >= 0.0;"),
    ("exchange", "select(limit, way, way < limit)", "way"),
    ("exchange", "select(missing, come, come < missing)", "come"),
    ("exchange", "select(release, bounce, bounce > release)", "bounce"),
    ("exchange", "const FIRM: f32 = 0.2;", "const FIRM: f32 = 0.20001;"),
    ("exchange", "let release = soft * (", "let release = ("),
    ("exchange", "let push = soft * fresh +", "let push = fresh +"),
    ("exchange", "select(0.0, after - speed, after > speed)", "after - speed"),
    ("exchange", "select(0.0, -speed, speed < 0.0)", "-speed"),
    ("exchange", "let lost = select(1.0,", "let lost = select(0.9999,"),
    ("exchange", "select(0.0, left, left > 0.0)", "left"),
    ("exchange", "mobility > 0.0), mobility > 0.0)", "true), true)"),
    ("exchange", "select(b.restitution, a.restitution, a.restitution > b.restitution)", "a.restitution"),
    ("measure_pairs", "min(pair_lanes[lane].y, other.y)", "other.y"),
    (
        "measure_pairs",
        "node += counts.x * 256u) {\n        found",
        "node += counts.x * 257u) {\n        found",
    ),
    ("scale_loads", "i += 256u", "i += 257u"),
    ("scale_loads", "scales[substeps[0].first_scale + index]", "scales[index]"),
    ("bend_hinges", "const STIFFEST: f32 = 16.0;", "const STIFFEST: f32 = 17.0;"),
    ("bend_hinges", "if angle < -PI {", "if angle < -3.2 {"),
    ("measure_nodes", "for (var half = 128u;", "for (var half = 64u;"),
    ("measure_nodes", "signed_mass < 0.0)", "signed_mass <= 0.0)"),
    ("measure_nodes", "== 0x7f800000u;", "== 0x7f000000u;"),
    ("measure_grid_springs", "index += counts.x) {", "index += counts.x + 1u) {"),
    ("measure_grid_springs", "if along.there != 0u && inside(", "if inside("),
    ("measure_mesh_springs", "0.5 * spring_energy(", "spring_energy("),
    ("measure_hinges", "0.5 * k * turn * turn", "k * turn * turn"),
    ("measure_volumes", "position_of(corners[at + 2u]) - origin", "position_of(corners[at + 2u])"),
];

#[test]
fn faults_in_the_sources_are_found() {
    let rows = rows();
    let mut missed = Vec::new();
    for (name, written, fault) in FAULTS {
        let row = rows.iter().find(|row| row.name == *name).expect("a row");
        let edit = |source: String| {
            assert!(source.contains(written), "`{written}` is not in the sources of {name}");
            source.replace(written, fault)
        };
        let outcome = row
            .run_edited(&GPU, GPU.info().is_software(), &edit)
            .unwrap_or_else(|why| panic!("{name}, `{fault}`: {why}"));
        let allowed = row.tolerance.on(&GPU);
        if outcome.ulps <= allowed {
            missed.push(format!("{name} does not find `{fault}`: {} of {allowed}", outcome.ulps));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// What other devices may round otherwise: here by a unit in the last place, where they fuse or take a short way.
const ROUNDINGS: &[(&str, &str)] = &[
    ("return a.x * b.x + a.y * b.y + a.z * b.z;", "return 1.0000001 * (a.x * b.x + a.y * b.y + a.z * b.z);"),
    (
        "return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);",
        "return 0.9999999 * (a.yzx * b.zxy) - 1.0000001 * (a.zxy * b.yzx);",
    ),
    ("return sqrt(dot3(a, a));", "return 1.0000001 * sqrt(dot3(a, a));"),
    ("let length = sqrt(squared);", "let length = 0.9999999 * sqrt(squared);"),
    ("let inverse = sqrt(inverse_squared);", "let inverse = 1.0000001 * sqrt(inverse_squared);"),
    (
        "let size = select(1.0, sqrt(area) * sqrt(speed), is_blown_on);",
        "let size = select(1.0, 1.0000001 * sqrt(area) * sqrt(speed), is_blown_on);",
    ),
    ("return sum * (1.0 / sqrt(squares));", "return sum * (1.0000001 / sqrt(squares));"),
    ("let inverse = 1.0 / squared;", "let inverse = 0.9999999 / squared;"),
    ("return x + h * new_velocity;", "return x + 1.0000001 * h * new_velocity;"),
    ("let t = num / select", "let t = 1.0000001 * num / select"),
];

#[test]
fn what_hardware_may_round_otherwise_is_allowed_there() {
    let seen = RefCell::new(Vec::new());
    let edit = |mut source: String| {
        for (written, rounded) in
            ROUNDINGS.iter().filter(|(written, _)| source.contains(written)).collect::<Vec<_>>()
        {
            seen.borrow_mut().push(*written);
            source = source.replace(written, rounded);
        }
        source
    };
    for row in rows() {
        let outcome = row.run_edited(&GPU, false, &edit).unwrap_or_else(|why| panic!("{}: {why}", row.name));
        let allowed = row.tolerance.hardware;
        println!("{}: {} ulps of {allowed}", row.name, outcome.ulps);
        assert!(outcome.ulps <= allowed, "{}: {} ulps, {allowed} allowed", row.name, outcome.ulps);
    }
    for (written, _) in ROUNDINGS {
        assert!(seen.borrow().contains(written), "`{written}` is not in the sources");
    }
}
