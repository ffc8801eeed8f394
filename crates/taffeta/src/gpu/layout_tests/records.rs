//! Records, field by field.

use crate::attachments::gpu_layout::Joint;
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::nodes::gpu_layout::{ContactMaterial, Surface};
use crate::contact::triangles::gpu_layout::{SolvedContact, SurfaceContact};
use crate::elements::KINDS;
use crate::elements::element::Kind;
use crate::elements::load::gpu_layout::Load;
use crate::elements::spring::gpu_layout::{Along, Entry, Grid, ResidentMesh, Run, Tile};
use crate::gpu::drawn::Drawing;
use crate::gpu::layout::{Air, Gusts};
use crate::gpu::layout::{Solving, Substep};
use crate::gpu::layout_tests::{read, sources, words};
use crate::motion::gpu_layout::{Motion, Pin};
use crate::solvers::dual::gpu_layout::{
    CgState, Constraint, ConstraintGroup, ContactRecord, NodeGroup, Row, Solve, SolveStatistics,
};
use crate::solvers::explicit::gpu_layout::{Part, Patch};
use crate::solvers::implicit::gpu_layout::{
    CoarseEdge, Diagonal, LevelGroup, NodeSolve, Parents, PcgState, SlotSpring, Symmetric, Weight,
    WeightedIndex,
};
use crate::volume::gpu_layout::Chunk;
use crate::volume::gpu_layout::VolumeGroup;
use taffeta_gpu::wgpu::naga::{AddressSpace, Handle, Module, Type, TypeInner};

/// A record: its name, its size, and name, offset and type of its fields.
#[derive(Debug)]
struct Record {
    name: String,
    size: usize,
    fields: Vec<(String, usize, String)>,
}

/// A type's name in WGSL.
trait Named {
    fn name() -> String;
}

macro_rules! named {
    ($($rust:ty: $wgsl:literal),* $(,)?) => {
        $(impl Named for $rust { fn name() -> String { $wgsl.to_owned() } })*
    };
}

named! {
    f32: "f32", u32: "u32", i32: "i32", [f32; 3]: "vec3<f32>", [f32; 4]: "vec4<f32>", [u32; 4]: "vec4<u32>", [u32; 3]: "vec3<u32>",
    [u32; 2]: "vec2<u32>", [f32; 2]: "vec2<f32>", Air: "Air", Gusts: "Gusts", Symmetric: "Symmetric", PcgState: "PcgState",
    [Along; 6]: "array<Along, 6>", Part: "Part",
    ContactMaterial: "ContactMaterial", Solving: "Solving", CgState: "CgState",
}

fn name_of<R, T: Named>(_: fn(&R) -> &T) -> String {
    T::name()
}

/// A record of layout.rs with all its fields; what follows the semicolon fills it up, and WGSL does not know it.
macro_rules! record {
    ($record:ident { $($field:ident),* $(; $($padding:ident),+)? }) => {{
        // Does not compile where a field is not listed.
        let _ = |$record { $($field: _,)* $($($padding: _),+)? }: $record| ();
        let field = |name: &str, offset: usize, ty: String| (name.to_owned(), offset, ty);
        Record {
            name: stringify!($record).to_owned(),
            size: size_of::<$record>(),
            fields: vec![$(field(
                stringify!($field),
                std::mem::offset_of!($record, $field),
                name_of(|record: &$record| &record.$field),
            )),*],
        }
    }};
}

/// The record of a kind of elements: nodes, then numbers.
fn record_of(kind: &Kind) -> Record {
    let (name, numbers) = kind.record;
    let corners = ("corners".to_owned(), 0, format!("array<u32, {}>", kind.nodes));
    let number = |(i, number): (usize, &&str)| ((*number).to_owned(), 4 * (kind.nodes + i), "f32".to_owned());
    Record {
        name: name.to_owned(),
        size: 4 * (kind.nodes + numbers.len()),
        fields: std::iter::once(corners).chain(numbers.iter().enumerate().map(number)).collect(),
    }
}

fn records() -> Vec<Record> {
    let of_elements = KINDS.iter().map(|kind| record_of(kind));
    let others = vec![
        record!(Substep {
            gravity, h, wind, drag, first_collider, colliders, first_motion, first_scale, frame_fraction, frame_rate,
            input_forces, pins, solving, left, first_goal, max_separation, own, air, first_corner,
            corner_parts, longest_push, led_out, collider_ranges, longest_step, pins_may_lag;
            padding
        }),
        record!(Solving {
            activation,
            release,
            aim,
            epsilon,
            form,
            tolerance_squared,
            most_iterations,
            is_adaptive,
            is_warm,
            inner,
            mass,
            outer,
            place_of_velocity,
            place_of_rate,
            velocity_of_rate,
            rate_of_change,
            rate_kept,
            whole,
            is_second,
            is_automatic
        }),
        record!(Air { velocity, density, exposure, drag, lift, gusts; gap }),
        record!(Gusts { offset, cells_a_metre, keys, weights }),
        record!(Motion { x, y, z, rate_x, rate_y, rate_z }),
        record!(Pin { start, node, goal, track }),
        record!(Along { k, damping, rest_length, there }),
        record!(Grid { first, rows, cols, along }),
        record!(Tile { grid, row, col }),
        record!(Part { first_row, first_col, end_row, end_col }),
        record!(Patch { grid, all, inner }),
        record!(ResidentMesh { first, count }),
        record!(Drawing {
            place_x,
            place_y,
            place_z,
            normal_x,
            normal_y,
            normal_z,
            alpha,
            first,
            stride,
            normal
        }),
        record!(Run { start, count, k, damping }),
        record!(Entry { neighbour, rest_length }),
        record!(Load { vector, kind, about, torque, first, count, factor; padding }),
        record!(VolumeGroup { first, count, gradients, origin, first_group, groups, goal, form, flags }),
        record!(Chunk { origin, first, count }),
        record!(Joint { point, track, a, b, start, end, compliance, break_force, closing, grouped }),
    ];
    of_elements.chain(others).chain(records_of_contact()).chain(records_of_solvers()).collect()
}

fn records_of_contact() -> Vec<Record> {
    vec![
        record!(Collider {
            place,
            size,
            spin_x,
            friction,
            spin_y,
            restitution,
            spin_z,
            kind,
            drift,
            mesh,
            axis_u,
            u,
            axis_v,
            v,
            axis_w,
            w,
            carry_x,
            carry_y,
            carry_z
        }),
        record!(ContactMaterial { thickness, friction, restitution }),
        record!(SurfaceContact {
            nodes,
            weights,
            normal,
            gap,
            impulse,
            mobility,
            force,
            thickness,
            order,
            friction,
            solved,
            push,
            leads,
            grip; padding
        }),
        record!(SolvedContact {
            nodes,
            weights,
            normal,
            gap,
            first,
            lead,
            impulse,
            along,
            applied,
            across,
            friction,
            stiffness,
            system,
            is_held
        }),
        record!(Surface {
            first,
            count,
            cols,
            high,
            wide,
            exclusions,
            material,
            cells_a_metre,
            memberships,
            met_layers
        }),
    ]
}

fn records_of_solvers() -> Vec<Record> {
    vec![
        record!(Constraint { a, b, k, damping, rest_length, is_active }),
        record!(ConstraintGroup { first, count, solve, first_group, groups }),
        record!(NodeGroup { first, count, solve, first_group, is_first }),
        record!(Row { direction, r, w, s, p, x }),
        record!(ContactRecord { normal, slides, velocity, collider, is_constrained, inside, surface_speed; padding }),
        record!(CgState { passes, is_done, limit, right, gamma, alpha, beta }),
        record!(Solve { constraints, active_constraints, kept, next }),
        record!(SolveStatistics { iterations, capped, active_fraction, residual }),
        record!(LevelGroup { first, count, solve, first_group, groups }),
        record!(SlotSpring { k, damping, rest_length }),
        record!(Parents { nodes, weights }),
        record!(CoarseEdge { slots, first, count }),
        record!(WeightedIndex { at, weight }),
        record!(Symmetric { diagonal, mixed; gap, padding }),
        record!(Diagonal { own, inverse }),
        record!(PcgState { passes, is_done, iterations, whole, error, alpha, beta }),
        record!(Weight { x, y, z; gap, padding, end }),
        record!(NodeSolve { steps, before, is_met, first, motion, kept, next }),
    ]
}

/// The structs within a type.
fn structs_in(module: &Module, ty: Handle<Type>, found: &mut Vec<Handle<Type>>) {
    match &module.types[ty].inner {
        TypeInner::Array { base, .. } => structs_in(module, *base, found),
        TypeInner::Struct { members, .. } => {
            found.push(ty);
            members.iter().for_each(|member| structs_in(module, member.ty, found));
        }
        _ => {}
    }
}

/// The structs of which buffers are made.
fn bound_structs(module: &Module) -> Vec<Record> {
    let mut found = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        if matches!(variable.space, AddressSpace::Uniform | AddressSpace::Storage { .. }) {
            structs_in(module, variable.ty, &mut found);
        }
    }
    found.sort();
    found.dedup();
    let record = |ty: &Handle<Type>| {
        let ty = &module.types[*ty];
        let TypeInner::Struct { members, span } = &ty.inner else { unreachable!("only structs were taken") };
        let field = |member: &taffeta_gpu::wgpu::naga::StructMember| {
            (member.name.clone().unwrap_or_default(), member.offset as usize, words(module, member.ty))
        };
        Record {
            name: ty.name.clone().unwrap_or_default(),
            size: *span as usize,
            fields: members.iter().map(field).collect(),
        }
    };
    found.iter().map(record).collect()
}

/// What differs between the structs of a source and the records.
fn differences(source: &str) -> Vec<String> {
    let (records, mut wrong) = (records(), Vec::new());
    for one in bound_structs(&read(source)) {
        match records.iter().find(|record| record.name == one.name) {
            None => wrong.push(format!("`{}` of the WGSL has no record in layout.rs", one.name)),
            Some(record) if (record.size, &record.fields) != (one.size, &one.fields) => {
                wrong.push(format!("layout.rs has {record:?}, the WGSL {one:?}"));
            }
            Some(_) => {}
        }
    }
    wrong
}

#[test]
fn structs_in_buffers_are_the_records_of_the_rust_side() {
    for source in sources() {
        assert!(differences(&source).is_empty(), "{}", differences(&source).join("\n"));
    }
}

#[test]
fn every_record_is_a_struct_in_a_buffer() {
    let used: Vec<String> =
        sources().iter().flat_map(|source| bound_structs(&read(source))).map(|record| record.name).collect();
    for record in records() {
        assert!(used.contains(&record.name), "no kernel uses `{}` of layout.rs", record.name);
    }
}

#[test]
fn a_field_that_is_moved_renamed_left_out_or_of_another_type_is_found() {
    let changes = [
        ("    start: u32,\n    count: u32,", "    count: u32,\n    start: u32,"),
        ("    neighbour: u32,", "    neighbor: u32,"),
        ("    rest_steepness: f32,\n", ""),
        ("    row: i32,\n    col: i32,\n}\n\n@group(1)", "    row: u32,\n    col: i32,\n}\n\n@group(1)"),
        ("    collider_ranges: u32,\n", ""),
        ("    exposure: f32,\n    /// Coefficients.\n    drag: f32,", "    drag: f32,\n    exposure: f32,"),
        (
            "    material: ContactMaterial,\n    cells_a_metre: f32,",
            "    cells_a_metre: f32,\n    material: ContactMaterial,",
        ),
        ("along: array<Along, 6>", "along: array<Along, 7>"),
    ];
    // Only the types are read: functions that use a field may not be valid then.
    let sources: Vec<String> = sources().iter().map(|source| declarations(source)).collect();
    for (written, fault) in changes {
        let source = sources.iter().find(|source| source.contains(written));
        let source = source.unwrap_or_else(|| panic!("`{written}` is not in the sources"));
        let faulty = source.replacen(written, fault, 1);
        assert!(differences(source).is_empty());
        assert!(!differences(&faulty).is_empty(), "`{fault}` in place of `{written}` is not found");
    }
}

/// A source without its functions.
fn declarations(source: &str) -> String {
    let mut kept = String::new();
    let mut in_function = false;
    for line in source.lines() {
        in_function |= line.starts_with("fn ") || line.starts_with("@compute");
        if !in_function {
            kept.push_str(line);
            kept.push('\n');
        }
        in_function &= line != "}";
    }
    kept
}
