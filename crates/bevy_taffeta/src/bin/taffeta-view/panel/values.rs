//! All values of a scene that can be changed while it runs, by the names that scene files have.

use super::fields::{Field, Value, choice, fields, optional, row};
use bevy_egui::egui::{RichText, Ui};
use bevy_taffeta::SoftMaterial;
use bevy_taffeta::taffeta::scene::{
    Acad, Air, Collider, ConstraintForm, Fabric, Gust, Hinge, Ice, Internal, Mass, Material, Method, PRESETS,
    SelfCollision, Solver, Spring, Tethers, Time, Volume, VolumeForm, VolumeWeights, World, Xpbd,
};

use Value::{Even, Flag, Log, Seed, Three, Whole};

const TIME: [Field<Time>; 2] = [
    Field::new("dt", "s", Log(1e-4, 0.1, |time| &mut time.dt)),
    Field::new("frames", "", Whole(10_000, |time| &mut time.frames)),
];
const MAX_STEP: [Field<f64>; 1] = [Field::new("max_step", "s", Log(1e-6, 0.1, |step| step))];

const WORLD: [Field<World>; 3] = [
    Field::new("gravity", "m/s²", Three(0.05, |world| &mut world.gravity)),
    Field::new("wind_force", "N", Three(0.001, |world| &mut world.wind_force)),
    Field::new("drag", "kg/s", Log(1e-6, 1.0, |world| &mut world.drag)),
];
const AIR: [Field<Air>; 4] = [
    Field::new("velocity", "m/s", Three(0.05, |air| &mut air.velocity)),
    Field::new("density", "kg/m³", Even(0.0, 5.0, |air| &mut air.density)),
    Field::new("drag", "", Even(0.0, 5.0, |air| &mut air.drag)),
    Field::new("lift", "", Even(0.0, 5.0, |air| &mut air.lift)),
];
const GUST: [Field<Gust>; 4] = [
    Field::new("speed", "m/s", Even(0.0, 20.0, |gust| &mut gust.speed)),
    Field::new("length", "m", Log(1e-2, 100.0, |gust| &mut gust.length)),
    Field::new("period", "s", Log(1e-2, 100.0, |gust| &mut gust.period)),
    Field::new("seed", "", Seed(|gust| &mut gust.seed)),
];

const ICE: [Field<Ice>; 5] = [
    Field::new("tolerance", "", Log(1e-8, 0.5, |ice| &mut ice.tolerance)),
    Field::new("max_iterations", "", Whole(10_000, |ice| &mut ice.max_iterations)),
    Field::new("epsilon", "", Log(1e-6, 10.0, |ice| &mut ice.epsilon)),
    Field::new("warm_start", "", Flag(|ice| &mut ice.warm_start)),
    Field::new("newton_steps", "", Whole(20, |ice| &mut ice.newton_steps)),
];
const ACAD: [Field<Acad>; 4] = [
    Field::new("threshold", "", Log(1e-4, 2.0, |acad| &mut acad.threshold)),
    Field::new("release", "", Log(1e-4, 2.0, |acad| &mut acad.release)),
    Field::new("target", "", Log(1e-4, 2.0, |acad| &mut acad.target)),
    Field::new("epsilon", "", Log(1e-4, 10.0, |acad| &mut acad.epsilon)),
];
const XPBD: [Field<Xpbd>; 2] = [
    Field::new("sweeps", "", Whole(100, |xpbd| &mut xpbd.sweeps)),
    Field::new("stretch_limit", "", Even(0.0, 1.0, |xpbd| &mut xpbd.stretch_limit)),
];

const SPRING: [Field<Spring>; 2] = [
    Field::new("k", "N/m", Log(1e-2, 1e6, |spring| &mut spring.k)),
    Field::new("d", "kg/s", Log(1e-5, 100.0, |spring| &mut spring.d)),
];
const INTERNAL: [Field<Internal>; 2] = [
    Field::new("k", "N/m", Log(1e-2, 1e6, |internal| &mut internal.k)),
    Field::new("d", "kg/s", Log(1e-5, 100.0, |internal| &mut internal.d)),
];
/// Of struts that are chosen at random.
const CHOSEN: [Field<Internal>; 2] = [
    Field::new("count", "", Whole(100_000, |internal| &mut internal.count)),
    Field::new("seed", "", Seed(|internal| &mut internal.seed)),
];
const HINGE: [Field<Hinge>; 2] = [
    Field::new("k", "N·m/rad", Log(1e-8, 10.0, |hinge| &mut hinge.k)),
    Field::new("d", "N·m·s/rad", Log(1e-10, 0.1, |hinge| &mut hinge.d)),
];
const FABRIC: [Field<Fabric>; 10] = [
    Field::new("stretch, warp", "N/m", Log(1.0, 1e5, |fabric| &mut fabric.stretch.warp)),
    Field::new("stretch, weft", "N/m", Log(1.0, 1e5, |fabric| &mut fabric.stretch.weft)),
    Field::new("shear", "N/m", Log(0.1, 1e4, |fabric| &mut fabric.shear)),
    Field::new("poisson", "", Even(-0.9, 0.9, |fabric| &mut fabric.poisson)),
    Field::new("bending, warp", "N·m", Log(1e-8, 1.0, |fabric| &mut fabric.bending.warp)),
    Field::new("bending, weft", "N·m", Log(1e-8, 1.0, |fabric| &mut fabric.bending.weft)),
    Field::new("bending_poisson", "", Even(-0.9, 0.9, |fabric| &mut fabric.bending_poisson)),
    Field::new("thickness", "m", Log(1e-5, 0.1, |fabric| &mut fabric.thickness)),
    Field::new("damping, stretch", "s", Log(1e-6, 1.0, |fabric| &mut fabric.damping.stretch)),
    Field::new("damping, bending", "s", Log(1e-6, 1.0, |fabric| &mut fabric.damping.bending)),
];
const TOUCH: [Field<SelfCollision>; 3] = [
    Field::new("thickness", "m", Log(1e-4, 1.0, |touch| &mut touch.thickness)),
    Field::new("friction", "", Even(0.0, 2.0, |touch| &mut touch.friction)),
    Field::new("restitution", "", Even(0.0, 1.0, |touch| &mut touch.restitution)),
];
const TETHERS: [Field<Tethers>; 1] = [Field::new("slack", "", Log(1e-3, 2.0, |tethers| &mut tethers.slack))];
const WEIGHTS: [Field<VolumeWeights>; 2] = [
    Field::new("center", "m", Three(0.01, |weights| &mut weights.center)),
    Field::new("radius", "m", Log(1e-3, 100.0, |weights| &mut weights.radius)),
];
const TARGET: [Field<f64>; 1] = [Field::new("target", "× rest", Even(0.1, 5.0, |target| target))];
const PRESSURE: [Field<f64>; 1] = [Field::new("pressure", "Pa", Even(-1000.0, 1000.0, |pressure| pressure))];

const COLLIDER: [Field<Collider>; 3] = [
    Field::new("friction", "", Even(0.0, 2.0, |collider| &mut collider.friction)),
    Field::new("restitution", "", Even(0.0, 1.0, |collider| &mut collider.restitution)),
    Field::new("offset", "m", Log(1e-4, 1.0, |collider| &mut collider.offset)),
];

const METHODS: [(Method, &str); 4] =
    [(Method::Springs, "springs"), (Method::Ice, "ice"), (Method::Acad, "acad"), (Method::Xpbd, "xpbd")];
const ORDERS: [(u32, &str); 2] = [(1, "first"), (2, "second")];
const FORMS: [(ConstraintForm, &str); 2] =
    [(ConstraintForm::Compliant, "compliant"), (ConstraintForm::Primal, "primal")];

/// `[time]`
pub fn time(ui: &mut Ui, time: &mut Time) -> bool {
    let changed = fields(ui, &TIME, time)
        | optional(ui, "max_step", &mut time.max_step, time.dt, |ui, step| fields(ui, &MAX_STEP, step));
    row(ui, "sub-steps", |ui| ui.weak(format!("{} a frame", time.substeps())));
    changed
}

/// `[world]`
pub fn world(ui: &mut Ui, world: &mut World) -> bool {
    fields(ui, &WORLD, world)
        | optional(ui, "air", &mut world.air, Air::default(), |ui, air| {
            fields(ui, &AIR, air)
                | optional(ui, "gust", &mut air.gust, Gust::default(), |ui, gust| fields(ui, &GUST, gust))
        })
}

/// `[solver]`
pub fn solver(ui: &mut Ui, solver: &mut Solver) -> bool {
    let mut changed = choice(ui, "method", &METHODS, &mut solver.method);
    match solver.method {
        Method::Ice => {
            changed |= choice(ui, "form", &FORMS, &mut solver.ice.form);
            changed |= fields(ui, &ICE, &mut solver.ice);
            changed |= choice(ui, "order", &ORDERS, &mut solver.ice.order);
        }
        Method::Acad => {
            // What iterates is that of "ice".
            changed |= fields(ui, &ACAD, &mut solver.acad);
            ui.weak("of [solver.ice]:");
            changed |= fields(ui, &ICE[..2], &mut solver.ice) | fields(ui, &ICE[3..4], &mut solver.ice);
        }
        Method::Xpbd => changed |= fields(ui, &XPBD, &mut solver.xpbd),
        _ => {}
    }
    changed
}

/// What a body is made of.
pub fn material(ui: &mut Ui, material: &mut SoftMaterial) -> bool {
    let mut changed = mass(ui, &mut material.mass);
    let springs = &mut material.springs;
    let soft = Spring { k: 10.0, d: 0.0 };
    let kinds =
        [("structural", &mut springs.structural), ("shear", &mut springs.shear), ("bend", &mut springs.bend)];
    for (key, spring) in kinds {
        changed |= optional(ui, key, spring, soft, |ui, spring| fields(ui, &SPRING, spring));
    }
    changed |= optional(ui, "internal", &mut springs.internal, Internal::default(), |ui, internal| {
        let given = internal.file.is_some() || internal.pairs.is_some();
        fields(ui, &INTERNAL, internal) | (!given && fields(ui, &CHOSEN, internal))
    });
    changed |= optional(ui, "hinge", &mut springs.hinge, Hinge { k: 1e-5, d: 0.0 }, |ui, hinge| {
        fields(ui, &HINGE, hinge)
    });
    let density =
        |fabric: &Option<Material>| fabric.as_ref().map(|fabric| Mass::Area(fabric.fabric().density));
    let before = density(&material.fabric);
    changed |= optional(ui, "material", &mut material.fabric, Material::default(), fabric);
    if let Some(now) = density(&material.fabric)
        && before == Some(material.mass)
    {
        material.mass = now;
    }
    changed |= optional(ui, "volume", &mut material.volume, Volume::default(), volume);
    let touch = &mut material.self_collision;
    changed |= optional(ui, "self_collision", touch, SelfCollision::default(), |ui, touch| {
        fields(ui, &TOUCH, touch)
    });
    changed
        | optional(ui, "tethers", &mut material.tethers, Tethers::default(), |ui, tethers| {
            fields(ui, &TETHERS, tethers)
        })
}

/// The one way in which the mass is given.
fn mass(ui: &mut Ui, mass: &mut Mass) -> bool {
    let (key, unit, value) = match mass {
        Mass::Node(value) => ("node_mass", "kg", value),
        Mass::Whole(value) => ("mass", "kg", value),
        Mass::Area(value) => ("area_density", "kg/m²", value),
        Mass::Volume(value) => ("density", "kg/m³", value),
    };
    fields(ui, &[Field::new(key, unit, Log(1e-5, 1e4, |mass: &mut f64| mass))], value)
}

/// `[body.material]`
fn fabric(ui: &mut Ui, material: &mut Material) -> bool {
    let presets: Vec<(usize, &str)> = PRESETS.iter().map(|preset| preset.name).enumerate().collect();
    let before = material.fabric();
    let named = PRESETS.iter().position(|preset| Some(preset.name) == material.preset.as_deref());
    let mut chosen = named.unwrap_or(usize::MAX);
    if choice(ui, "preset", &presets, &mut chosen) {
        material.preset = Some(PRESETS[chosen].name.into());
        return true;
    }
    let mut now = before;
    let changed = fields(ui, &FABRIC, &mut now);
    keep(&mut material.stretch, before.stretch, now.stretch);
    keep(&mut material.shear, before.shear, now.shear);
    keep(&mut material.poisson, before.poisson, now.poisson);
    keep(&mut material.bending, before.bending, now.bending);
    keep(&mut material.bending_poisson, before.bending_poisson, now.bending_poisson);
    keep(&mut material.thickness, before.thickness, now.thickness);
    keep(&mut material.damping, before.damping, now.damping);
    if !material.zones.is_empty() {
        let words = format!("{} from the file", material.zones.len());
        row(ui, "zones", |ui| ui.weak(words));
    }
    changed
}

/// Takes over a value that was changed; others stay those of the preset.
fn keep<T: PartialEq>(own: &mut Option<T>, before: T, now: T) {
    if now != before {
        *own = Some(now);
    }
}

/// `[body.volume]`
fn volume(ui: &mut Ui, volume: &mut Volume) -> bool {
    use VolumeForm::{Corrected, None, Projected};
    let forms = [Corrected, Projected, None].map(|form| (form, form.name()));
    let mut changed = choice(ui, "form", &forms, &mut volume.form);
    if !volume.motion.is_empty() {
        let words = format!("{} keyframes from the file", volume.motion.len());
        row(ui, "motion", |ui| ui.weak(words));
    }
    if volume.pressure.is_none() && !volume.is_pressure() {
        changed |= optional(ui, "target", &mut volume.target, 1.0, |ui, target| fields(ui, &TARGET, target));
    }
    if volume.target.is_none() {
        changed |= optional(ui, "pressure", &mut volume.pressure, 0.0, |ui, pressure| {
            fields(ui, &PRESSURE, pressure)
        });
    }
    if let Some(weights) = &mut volume.weights {
        ui.label(RichText::new("weights").strong());
        changed |= fields(ui, &WEIGHTS, weights);
    }
    changed
}

/// How a collider feels.
pub fn collider(ui: &mut Ui, collider: &mut Collider) -> bool {
    fields(ui, &COLLIDER, collider)
}
