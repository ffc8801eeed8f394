//! Numbers that stand on both sides.

use crate::attachments::attach::ROUNDS as TETHER_ROUNDS;
use crate::attachments::gpu::FIELDS;
use crate::attachments::joints::ROUNDS as GROUP_ROUNDS;
use crate::contact::collider_mesh::{surface as mesh, tree, triangle};
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::colliders::gpu_layout::MESH;
use crate::contact::colliders::met::Differ;
use crate::contact::colliders::moving::{ColliderNow, ContactSurface};
use crate::contact::colliders::predicted_contact::{LEFT_TO_CONTACT, STICKS, TOUCHES};
use crate::contact::colliders::response::NARROW;
use crate::contact::colliders::rigid::Rigid;
use crate::contact::colliders::run::{GROOVES, ROUNDING_ULPS, ROUNDS};
use crate::contact::colliders::shape::{
    BoxNow, CapsuleNow, CylinderNow, ENTRIES, PlaneNow, ShapeNow, SphereNow,
};
use crate::contact::nodes::gpu_layout::FARTHEST;
use crate::contact::nodes::pair::FIRM;
use crate::contact::triangles::carry::Phase;
use crate::contact::triangles::gpu_layout::{LOOSE_REACH, WORDS};
use crate::contact::triangles::surfaces::NEIGHBOURS;
use crate::contact::triangles::{carry, cones, filter, impulse, slide, solved};
use crate::diagnostics::gpu::NODE_SUMS;
use crate::elements::aero::gust::{FARTHEST_CELL, MIDDLE, STRIDES, VALUES};
use crate::elements::hinge::hinge::STIFFEST;
use crate::elements::load::gpu_layout::{FORCE, IS_LOAD, TORQUE};
use crate::elements::membrane::membrane::{FLAT as FLAT_STRETCH, LEAST_SQUARED, LEAST_STRETCH, LIMITED};
use crate::elements::spring::gpu_layout::{IS_RING, NOT_A_MESH, TILE};
use crate::gpu::layout::{GROUP, NONE};
use crate::gpu::layout_tests::{read, sources};
use crate::motion::gpu_layout::MOVED_BY_USER;
use crate::motion::pins::WAY_ULPS;
use crate::real::Real;
use crate::scene::ConstraintForm;
use crate::solvers::explicit::gpu_layout::{OWN, PATCH_NODE_BYTES};
use crate::solvers::implicit::gpu_layout::{IS_LEFT, MOST_OPEN_AT, VECTORS, Vector, When};
use crate::solvers::implicit::implicit::{LEFT, MOST_STEPS, SHARE_OF_OUTER};
use crate::step::{FILTERS, IMPULSES};
use crate::topology::LANES;
use crate::volume::gpu_layout::{RESTORED, VOLUME_PARTS, WEIGHTED};
use crate::volume::volume::{FEW, FLAT, Form};
use std::collections::BTreeMap;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use taffeta_gpu::wgpu::naga::{Expression, Literal, Module};

/// Constants that the Rust side has within a function, or not at all.
const ALONE: &[&str] = &[
    "FRONT",
    "OPEN_AT",
    "PLACE",
    "LEAF_LANES",
    "TAN_EIGHTH",
    "FLOOR",
    "DAMPING",
    "ROW",
    "SLOT",
    "SPRING",
    "SWEEPS",
    "JOINT_RESIDUAL",
    "JOINT_DIRECTION",
    "JOINT_AR",
    "JOINT_AP",
    "JOINT_LINE",
    "ZERO",
    "APART",
    "IGNORED",
    "BELOW",
    "ABOVE",
    "SEEK_NEAREST",
    "SEEK_SUM",
    "SEEK_FACING",
];

/// The numbers of a source's constants.
fn constants(module: &Module) -> BTreeMap<String, f64> {
    let number = |init| match module.global_expressions[init] {
        Expression::Literal(Literal::F32(number)) => f64::from(number),
        Expression::Literal(Literal::U32(number)) => f64::from(number),
        Expression::Literal(Literal::I32(number)) => f64::from(number),
        ref other => panic!("a constant that is no number: {other:?}"),
    };
    let all = module.constants.iter();
    all.filter_map(|(_, one)| Some((one.name.clone()?, number(one.init)))).collect()
}

/// The kind of a collider's record.
fn kind(shape: ShapeNow<f32>) -> f64 {
    let zero = [0.0; 3];
    let surface = ContactSurface {
        friction: 0.0,
        restitution: 0.0,
        spin: [zero; 3],
        drift: zero,
        carry: Rigid::rest(),
    };
    f64::from(Collider::from(&ColliderNow { shape, surface }).kind)
}

fn twins() -> BTreeMap<&'static str, f64> {
    shared().into_iter().chain(of_solvers()).chain(of_surfaces()).collect()
}

/// Of contact of surfaces.
fn of_surfaces() -> BTreeMap<&'static str, f64> {
    let words = WORDS.iter().map(|&(name, number)| (name, number as f64));
    let lengths = [
        ("SHARE", filter::SHARE),
        ("PART_STEPS", slide::PART_STEPS),
        ("STEP_BITS", f64::from(slide::STEP_BITS)),
        ("AXIS_BITS", f64::from(slide::AXIS_BITS)),
        ("HALF_AXIS", slide::HALF_AXIS),
        ("TILT", slide::TILT),
        ("SLIDES", slide::SLIDES as f64),
        ("AS_ONE", filter::AS_ONE),
        ("ROOM_BEFORE", filter::ROOM_BEFORE),
        ("PUSHES", carry::PUSHES as f64),
        ("FIRST_PUSHES", carry::FIRST_PUSHES as f64),
        ("PHASE_PUSH", f64::from(Phase::Push as u32)),
        ("PHASE_RESTART", f64::from(Phase::Restart as u32)),
        ("PHASE_SQUEEZE", f64::from(Phase::Squeeze as u32)),
        ("PHASE_STOP", f64::from(Phase::Stop as u32)),
        ("PHASE_OVER", f64::from(Phase::Over as u32)),
        ("FIRST_STOP", carry::FIRST_STOP as f64),
        ("SQUEEZED_PART", filter::SQUEEZED_PART),
        ("SQUEEZED_FLOOR", filter::SQUEEZED_FLOOR),
        ("SQUEEZED_AHEAD", filter::SQUEEZED_AHEAD),
        ("PUSH_REACH", f64::from(carry::reach_of_pushes(1.0) as f32)),
        ("MOST_OF_GAP", filter::SHARE * (1.0 - filter::LEAST)),
        ("LEAST_SHARE", filter::LEAST),
        ("MOST_SHARE", 1.0 - filter::LEAST),
        ("PLANE_LEFT", filter::LEFT),
        ("SLENDER", filter::SLENDER),
        ("DIGITS", filter::DIGITS),
        ("THIN", filter::THIN),
        ("CONTACT_FIRM", impulse::FIRM),
        ("SLOP", impulse::SLOP),
        ("RELEASE", impulse::RELEASE),
        ("KEEPS", impulse::KEEPS),
        ("LEVER", impulse::LEVER),
        ("NEARBY", solved::NEAR),
        ("STIFFNESS", solved::STIFFNESS),
        ("NEW", solved::NEW),
        ("STIFF", solved::STIFF),
        ("MOST_SINKING", impulse::SINKS),
        ("NEIGHBOURS", NEIGHBOURS),
        ("LOOSE_REACH", LOOSE_REACH),
        ("JAMS", f64::from(filter::JAMS)),
        ("IMPULSES", IMPULSES as f64),
        ("MOST_FILTER_ROUNDS", FILTERS as f64),
        ("WIDER", cones::WIDER),
        ("WIDER_KEPT", cones::WIDER_KEPT),
        ("ROUNDED", cones::ROUNDED),
    ];
    words.chain(lengths.map(|(name, number)| (name, f64::from(number as f32)))).collect()
}

/// Of the implicit solvers.
fn of_solvers() -> BTreeMap<&'static str, f64> {
    BTreeMap::from([
        ("COMPLIANT", f64::from(ConstraintForm::Compliant as u32)),
        ("PRINTED_CONSTRAINT", f64::from(ConstraintForm::Printed as u32)),
        ("MOST_STEPS", f64::from(MOST_STEPS)),
        ("LEFT", f64::from(LEFT as f32)),
        ("SHARE_OF_OUTER", f64::from(SHARE_OF_OUTER as f32)),
        ("ITERATED", f64::from(When::Iterated as u32)),
        ("BEGUN", f64::from(When::Begun as u32)),
        ("VECTORS", VECTORS as f64),
        ("MOST_OPEN_AT", MOST_OPEN_AT as f64),
        ("IS_LEFT", IS_LEFT as f64),
        ("RESIDUAL", f64::from(Vector::Residual as u32)),
        ("CYCLE", f64::from(Vector::Cycle as u32)),
        ("START", f64::from(Vector::Start as u32)),
        ("FREE", f64::from(Vector::Free as u32)),
        ("RATE", f64::from(Vector::Rate as u32)),
        ("GIVEN", f64::from(Vector::Given as u32)),
        ("TAKEN", f64::from(Vector::Taken as u32)),
        ("CYCLED", f64::from(Vector::Cycled as u32)),
        ("CHANGE", f64::from(Vector::Change as u32)),
        ("DIRECTION", f64::from(Vector::Direction as u32)),
        ("DIRECTION_PRODUCT", f64::from(Vector::DirectionProduct as u32)),
        ("PRODUCT", f64::from(Vector::Product as u32)),
        ("IMPULSE", f64::from(Vector::Impulse as u32)),
        ("TOTAL", f64::from(Vector::Total as u32)),
        ("SPRING_CHANGE", f64::from(Vector::SpringChange as u32)),
    ])
}

/// Of the rest.
fn shared() -> BTreeMap<&'static str, f64> {
    let zero = [0.0; 3];
    BTreeMap::from([
        ("TINY", f64::from(<f32 as Real>::TINY)),
        ("FAR", f64::from(<f32 as Real>::FAR)),
        ("PI", f64::from(PI)),
        ("HALF_PI", f64::from(FRAC_PI_2)),
        ("QUARTER_PI", f64::from(FRAC_PI_4)),
        ("ROUNDS", ROUNDS as f64),
        ("STIFFEST", STIFFEST),
        ("LEAST_STRETCH", f64::from(LEAST_STRETCH as f32)),
        ("LEAST_SQUARED", f64::from(LEAST_SQUARED as f32)),
        ("LINE_OFFSET", f64::from((LEAST_SQUARED + FLAT_STRETCH + FLAT_STRETCH) as f32)),
        ("FLAT_STRETCH", f64::from(FLAT_STRETCH as f32)),
        ("LIMITED", LIMITED),
        ("STRIDE_X", f64::from(STRIDES[0])),
        ("STRIDE_Y", f64::from(STRIDES[1])),
        ("STRIDE_Z", f64::from(STRIDES[2])),
        ("VALUES", f64::from(VALUES)),
        ("MIDDLE", MIDDLE),
        ("FARTHEST_CELL", FARTHEST_CELL),
        ("THIRD", f64::from((1.0 / 3.0) as f32)),
        ("NARROW", f64::from(NARROW as f32)),
        ("NUMBERS", NODE_SUMS as f64),
        ("IS_LOAD", f64::from(IS_LOAD)),
        ("MOVED_BY_USER", f64::from(MOVED_BY_USER)),
        ("NOT_A_MESH", f64::from(NOT_A_MESH)),
        ("IS_RING", f64::from(IS_RING)),
        ("WEIGHTED", f64::from(WEIGHTED)),
        ("RESTORED", f64::from(RESTORED)),
        ("VOLUME_PARTS", VOLUME_PARTS as f64),
        ("KEPT", f64::from(Form::Kept as u32)),
        ("PAPER_SHADER", f64::from(Form::PaperShader as u32)),
        ("PRINTED", f64::from(Form::Printed as u32)),
        ("PRESSURE", f64::from(Form::Pressure as u32)),
        ("FLAT", f64::from(FLAT as f32)),
        ("FIRM", f64::from(FIRM as f32)),
        ("FEW", f64::from(FEW as f32)),
        ("PROJECTED", f64::from(<f32 as Real>::PROJECTED)),
        ("LANES", LANES as f64),
        ("GROUPS_IN_ROW", f64::from(taffeta_gpu::GROUPS_IN_ROW)),
        ("EPSILON", f64::from(<f32 as Real>::EPSILON)),
        ("WAY_ULPS", WAY_ULPS),
        ("LARGEST", f64::from(f32::MAX)),
        ("NONE", f64::from(NONE)),
        ("UNLIMITED", f64::from(slide::UNLIMITED)),
        ("GROUP_ROUNDS", GROUP_ROUNDS as f64),
        ("JOINT_FIELDS", FIELDS as f64),
        ("TETHER_ROUNDS", TETHER_ROUNDS as f64),
        ("FARTHEST", f64::from(FARTHEST)),
        ("OWN", OWN as f64),
        ("NUMBERS_A_NODE", f64::from(PATCH_NODE_BYTES / 4)),
        ("TILE_COLS", TILE[1] as f64),
        ("FORCE", f64::from(FORCE)),
        ("TORQUE", f64::from(TORQUE)),
        ("SPHERE", kind(ShapeNow::Sphere(SphereNow { center: zero, radius: 0.0 }))),
        ("PLANE", kind(ShapeNow::Plane(PlaneNow { normal: zero, level: 0.0 }))),
        ("BOX", kind(ShapeNow::Box(BoxNow { center: zero, axes: [zero; 3], half: zero, offset: 0.0 }))),
        ("CAPSULE", kind(ShapeNow::Capsule(CapsuleNow { a: zero, along: zero, inverse: 0.0, radius: 0.0 }))),
        (
            "CYLINDER",
            kind(ShapeNow::Cylinder(CylinderNow {
                center: zero,
                axis: zero,
                half: 0.0,
                radius: 0.0,
                offset: 0.0,
            })),
        ),
        ("MESH", f64::from(MESH)),
        ("ENTRIES", ENTRIES as f64),
        ("NO_TRIANGLE", f64::from(NONE)),
        ("PASSED", f64::from(triangle::SLACK as f32)),
        ("GRAZING", mesh::GRAZING),
        ("LOOSE", f64::from((1.0 + tree::SLACK) as f32)),
        ("GROOVES", GROOVES as f64),
        ("TOUCHES", f64::from(TOUCHES as f32)),
        ("DIFFER_BY_FRICTION", f64::from(Differ::ByFriction as u32)),
        ("DIFFER_BY_COLLIDERS", f64::from(Differ::ByColliders as u32)),
        ("STICKS", f64::from(STICKS as f32)),
        ("LEFT_TO_CONTACT", f64::from(LEFT_TO_CONTACT as f32)),
        ("ROUNDING_ULPS", f64::from(ROUNDING_ULPS as f32)),
    ])
}

#[test]
fn constants_are_the_same_on_both_sides() {
    let twins = twins();
    let mut seen = Vec::new();
    for source in sources() {
        for (name, number) in constants(&read(&source)) {
            match twins.get(name.as_str()) {
                Some(&twin) => assert_eq!(number, twin, "`{name}`"),
                None => {
                    assert!(ALONE.contains(&name.as_str()), "`{name}` has no twin here, nor is it in ALONE")
                }
            }
            seen.push(name);
        }
    }
    for name in twins.keys().chain(ALONE) {
        assert!(seen.iter().any(|one| one == name), "`{name}` is not in the WGSL");
    }
}

#[test]
fn a_tile_is_a_workgroup() {
    assert_eq!(TILE[0] * TILE[1], GROUP);
    assert_eq!(GROUP % LANES, 0);
}
