//! A state by chance, in which no number is zero or one, and some nodes stand on, below and above what kernels branch
//! on; with it the CPU's backend and the arrays that kernels are bound to.

use crate::assembly::Assembly;
use crate::backend::{Backend, FrameInput};
use crate::contact::collider_mesh::gpu::{ColliderMeshes, Words};
use crate::contact::collider_mesh::parity_scene;
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::contact::colliders::gpu::LISTS_DIFFER;
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::colliders::shape::ShapeNow;
use crate::contact::nodes::gpu::HAS_LAYERS;
use crate::contact::nodes::pair;
use crate::contact::triangles::gpu_tables::CornersMoved;
use crate::cpu::CpuBackend;
use crate::cpu::between::Between;
use crate::cpu::team::Team;
use crate::elements::gpu::KindTables;
use crate::elements::hinge;
use crate::elements::load::cpu::Loads;
use crate::features;
use crate::features::Tables;
use crate::gpu::bodies::Bodies;
use crate::gpu::layout::Air;
use crate::gpu::layout::{Four, GROUP, NONE, Solving, Substep};
use crate::motion::gpu_layout::{MOVED_BY_USER, Motion, Pin};
use crate::parity::scene::{CEILING, CENTER, FLOOR, ON_THE_AXIS, middle, scene, wide_sheet};
use crate::plan;
use crate::plan::refinement::InVain;
use crate::real::add;
use crate::scene::{Layers, Scene, Solver};
use crate::step::Op;
use crate::topology::random::SplitMix64;
use crate::volume::gpu_layout::VOLUME_PARTS;
use std::collections::BTreeMap;
use std::ops::Range;
use taffeta_gpu::bytemuck::{Pod, cast_slice};

/// The sub-step that rows run: not the first, so that each finds its own records.
pub const SUBSTEP: usize = 2;

/// Makes a state where springs are constraints, from a seed.
pub type Maker = fn(u64, Solver, bool) -> Result<Fixture, String>;

/// Colliders that are meshes, as kernels and as the CPU see them.
type Meshes = ((ColliderMeshes, Vec<Words>), Vec<MeshSurface<f32>>);

fn meshes_of(assembly: &Assembly) -> Meshes {
    let meshes = assembly.colliders().iter().filter_map(|collider| collider.mesh());
    (ColliderMeshes::new(assembly), meshes.map(|mesh| mesh.surface()).collect())
}

/// Position [m] and inverse mass [1/kg], velocity [m/s] and mass [kg], of all places.
#[derive(Clone, Default)]
pub struct State {
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
}

/// All that a row's twins start from.
pub struct Fixture {
    pub cpu: CpuBackend<f32>,
    pub tables: Tables,
    pub substeps: Vec<plan::Substep<f32>>,
    pub input: FrameInput,
    /// The state before the sub-step, and one after it for the stages that work in place.
    pub old: State,
    pub new: State,
    /// Forces so far [N].
    pub force: Vec<[f32; 3]>,
    /// Whether a place has a node.
    pub is_node: Vec<bool>,
    /// Colliders that are meshes.
    meshes: (ColliderMeshes, Vec<Words>),
    pub surfaces: Vec<MeshSurface<f32>>,
    pins: Vec<Pin>,
}

/// Numbers of a bound array as words.
pub type Arrays = BTreeMap<&'static str, Vec<u32>>;

/// Words of any records.
pub fn words<T: Pod>(records: &[T]) -> Vec<u32> {
    cast_slice(records).to_vec()
}

/// Numbers in (-1, 1), none of them small.
pub struct Chance(SplitMix64);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    pub fn number(&mut self) -> f32 {
        let size = 0.01 + 0.98 * self.0.unit();
        (if self.0.below(2) == 0 { size } else { -size }) as f32
    }

    pub fn three(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| size * self.number())
    }
}

impl Fixture {
    /// The same for the same seed. On hardware, where sums may be fused, nothing stands exactly on a threshold.
    pub fn new(seed: u64, drag: f64, exact: bool) -> Result<Self, String> {
        Self::of(&scene(drag, !exact), seed, exact)
    }

    /// The same where some bodies do not meet some colliders.
    pub fn with_layers(seed: u64, exact: bool) -> Result<Self, String> {
        let mut scene = scene(0.0087, !exact);
        for (number, collider) in (0..).zip(&mut scene.colliders) {
            collider.layers = Layers::new([number % 3], 0..32);
        }
        for (number, body) in (0..).zip(&mut scene.bodies).skip(1) {
            body.layers =
                Layers::new([number % 5], [number % 3, number % 2].into_iter().take(number as usize % 3));
        }
        Self::of(&scene, seed, exact)
    }

    /// The same where springs are constraints.
    pub fn with_constraints(seed: u64, solver: Solver, exact: bool) -> Result<Self, String> {
        Self::of(&Scene { solver, ..scene(0.0087, !exact) }, seed, exact)
    }

    /// The same where springs are solved for by nodes; with a sheet beside the others that has a large coarser level.
    pub fn with_levels(seed: u64, solver: Solver, exact: bool) -> Result<Self, String> {
        let explicit = |assembly: &mut Assembly| {
            assembly.elements_mut().iter_mut().for_each(|list| list.implicit = false);
        };
        Self::edited(&Self::levels(solver, exact), explicit, seed, exact)
    }

    /// The same where hinges are solved for as well.
    pub fn with_couplings(seed: u64, solver: Solver, exact: bool) -> Result<Self, String> {
        Self::of(&Self::levels(solver, exact), seed, exact)
    }

    fn levels(solver: Solver, exact: bool) -> Scene {
        let mut scene = Scene { solver, ..scene(0.0087, !exact) };
        scene.bodies.push(wide_sheet());
        scene
    }

    /// With meshes among the colliders.
    pub fn with_meshes(seed: u64, exact: bool) -> Result<Self, String> {
        let mut scene = among_meshes(scene(0.0087, !exact));
        scene.colliders.push(parity_scene::plates());
        let mut fixture = Self::of(&scene, seed, exact)?;
        if exact {
            let from = fixture.cpu.assembly().bodies[1].first;
            let from = parity_scene::put_awkward(&mut fixture.old.position, &mut fixture.new.position, from);
            parity_scene::put_at_plates(&mut fixture.old.position, &mut fixture.new.position, from);
            fixture.put_old();
        }
        Ok(fixture)
    }

    /// The same where springs are constraints. On hardware there are no meshes: what is near one is held by other roundings
    /// otherwise.
    pub fn with_meshes_and_constraints(seed: u64, solver: Solver, exact: bool) -> Result<Self, String> {
        let scene = Scene { solver, ..scene(0.0087, !exact) };
        Self::of(&if exact { among_meshes(scene) } else { scene }, seed, exact)
    }

    /// One mesh alone, near whose surface no way begins or ends: there the direction away from it is what rounding leaves.
    pub fn with_mesh_apart(number: usize) -> Result<Self, String> {
        let mut fixture = Self::of(&among_meshes(scene(0.0087, true)), 40 + number as u64, false)?;
        for substep in &mut fixture.substeps {
            let meshes =
                (0..).zip(substep.colliders()).filter(|(_, collider)| collider.shape.mesh().is_some());
            let index = meshes.map(|(index, _)| index).nth(number);
            substep.edit_colliders(|all| *all = index.into_iter().map(|index| all[index]).collect());
        }
        fixture.leave_surfaces();
        fixture.put_old();
        Ok(fixture)
    }

    /// The same of any scene.
    pub fn of(scene: &Scene, seed: u64, exact: bool) -> Result<Self, String> {
        Self::edited(scene, |_| {}, seed, exact)
    }

    /// The same of a scene that is changed once it is built.
    fn edited(scene: &Scene, edit: impl Fn(&mut Assembly), seed: u64, exact: bool) -> Result<Self, String> {
        let mut chance = Chance::new(seed);
        let mut assembly = Assembly::new(scene).map_err(|error| error.to_string())?;
        edit(&mut assembly);
        for list in assembly.elements_mut().iter_mut().filter(|list| list.kind.name == hinge::NAME) {
            for rest_angle in list.all.numbers.iter_mut().step_by(list.kind.numbers()) {
                // Folds then differ from those at rest by more than half a turn here and there, either way.
                *rest_angle = 3.1 * f64::from(chance.number());
            }
        }
        let states = |chance: &mut Chance, tables: &Tables, cpu: &CpuBackend<f32>| {
            let mut old = old_state(chance, tables, cpu, exact);
            let (new, awkward) = new_state(chance, tables, cpu, exact);
            for place in awkward {
                // They come from near by: on a longer way they would meet something else.
                let [x, y, z, _] = new.position[place];
                let start = add([x, y + 0.25, z], chance.three(0.05));
                old.position[place][..3].copy_from_slice(&start);
            }
            [old, new]
        };
        Self::drawn(assembly, &mut chance, states, input)
    }

    /// An assembly in states, and with what the user does, that are drawn.
    pub fn drawn(
        assembly: Assembly,
        chance: &mut Chance,
        states: impl FnOnce(&mut Chance, &Tables, &CpuBackend<f32>) -> [State; 2],
        input: impl FnOnce(&mut Chance) -> FrameInput,
    ) -> Result<Self, String> {
        let tables = Tables::new(&Bodies::new(&assembly, 0..assembly.bodies.len()))?;
        let (meshes, surfaces) = meshes_of(&assembly);
        let mut is_node = vec![false; assembly.places];
        for body in &assembly.bodies {
            is_node[body.solver_range()].fill(true);
        }
        let substeps = plan::frame(&assembly, 0.0, (1, InVain::NEVER), features::parameters);
        let cpu = features::on_cpu::<f32>(assembly, Team::new(1)).map_err(|refusal| refusal.message)?;
        let [old, new] = states(chance, &tables, &cpu);
        let force = tables.position.iter().map(|_| chance.three(0.4)).collect();
        let input = input(chance);
        let pins = pins(&tables, &input);
        let mut fixture =
            Self { cpu, tables, substeps, input, old, new, force, is_node, meshes, surfaces, pins };
        fixture.put_old();
        Ok(fixture)
    }

    /// Hands the state before the sub-step to the CPU.
    pub fn put_old(&mut self) {
        for (place, (x, v)) in self.old.position.iter().zip(&self.old.velocity).enumerate() {
            let three = |[x, y, z, _]: Four| [x, y, z].map(f64::from);
            self.cpu.set(place, three(*x), three(*v));
        }
    }

    /// Takes nodes away that come from near the surface of a mesh, or get there.
    fn leave_surfaces(&mut self) {
        for collider in self.substeps[SUBSTEP].colliders() {
            let ShapeNow::Mesh(now) = &collider.shape else { continue };
            let surface = &self.surfaces[now.index as usize];
            let is_near = |x: [f32; 3]| {
                let place = now.local(x);
                let found = parity_scene::nearest_of(surface, now, place);
                found.is_some_and(|found| found.at.squared < NEAR * NEAR)
            };
            for (old, new) in self.old.position.iter_mut().zip(&mut self.new.position) {
                let [start, end] = [[old[0], old[1], old[2]], [new[0], new[1], new[2]]];
                if is_near(collider.surface.carry.apply(start)) || is_near(end) {
                    old[0] += 20.0;
                    new[0] += 20.0;
                }
            }
        }
    }

    /// The sub-step that rows run.
    pub fn substep(&self) -> &plan::Substep<f32> {
        &self.substeps[SUBSTEP]
    }

    /// Runs `stages` on the CPU after the elements, from the forces and the state after that stand here.
    pub fn on_cpu(&mut self, operations: &[Op]) -> (Between<f32>, State) {
        for (place, (x, v)) in self.new.position.iter().zip(&self.new.velocity).enumerate() {
            self.cpu.set_after(place, [x[0], x[1], x[2], v[0], v[1], v[2]]);
        }
        let mut between = Between { force: self.force.clone(), ..Between::default() };
        self.cpu.run_separately(&self.substeps[SUBSTEP], &self.input, &mut between, |op| {
            operations.contains(&op)
        });
        let mut after = self.new.clone();
        for place in (0..self.is_node.len()).filter(|&place| self.is_node[place]) {
            let [x, y, z, u, v, w] = self.cpu.after(place);
            let mass = self.old.velocity[place][3].abs();
            let mass = if between.last_collider[place] > 0 { -mass } else { mass };
            after.position[place] = [x, y, z, self.old.position[place][3]];
            after.velocity[place] = [u, v, w, mass];
        }
        (between, after)
    }

    /// Factors of torques [N/m] that the CPU has found.
    pub fn torques(&mut self) -> Vec<f32> {
        self.cpu.feature::<Loads<f32>>().map_or(Vec::new(), |loads| loads.torques().to_vec())
    }

    /// Forces of all elements [N] that the CPU has found, as they lie on the device.
    pub fn element_forces(&mut self) -> Vec<Four> {
        let mut all = vec![[0.0; 4]; self.tables.elements.forces()];
        for KindTables { set, .. } in self.tables.elements.kinds.iter().filter(|one| !one.set.is_solved_for())
        {
            all[set.forces()].copy_from_slice(&set.found_on_cpu(&mut self.cpu));
        }
        all
    }

    /// Workgroups for one invocation a place.
    pub fn place_groups(&self) -> usize {
        self.tables.len().div_ceil(GROUP)
    }

    /// Forces as kernels keep them; the fourth number is none.
    pub fn force_fours(&self) -> Vec<Four> {
        self.force.iter().map(|&[x, y, z]| [x, y, z, f32::NAN]).collect()
    }

    /// Every array by the name that it has in the sources. What kernels write is NaN.
    pub fn arrays(&self) -> Arrays {
        let (tables, places) = (&self.tables, self.is_node.len());
        let poison = |words: usize| vec![f32::NAN.to_bits(); words];
        let corners: Vec<Four> = self.corners().into_iter().flat_map(|moved| moved.corners).collect();
        let input_forces: Vec<Four> = self.input.forces.iter().map(four_of_input).collect();
        let of_elements = self.tables.elements.kinds.iter().map(|one| (one.set.kind.name, one.words.clone()));
        let mut arrays = Arrays::from([
            ("grids", words(&tables.springs.grids)),
            ("tiles", words(&tables.springs.tiles)),
            ("runs", words(&tables.springs.runs)),
            ("entries", words(&tables.springs.entries)),
            ("load_nodes", words(&tables.loads.nodes)),
            ("node_starts", words(&tables.loads.by_node.offsets)),
            ("node_elements", words(&tables.loads.by_node.items)),
            ("chunks", words(&tables.volumes.chunks)),
            ("corners", words(&tables.volumes.corners)),
            ("colliders", words(&self.colliders())),
            // An array cannot be empty.
            ("mesh_data", if self.meshes.1.is_empty() { vec![0; 4] } else { words(&self.meshes.1) }),
            ("surface_corners", words(&corners)),
            ("motions", words(&self.motions())),
            ("scales", words(&self.scales())),
            ("goals", words(&self.goals())),
            ("volume_groups", words(&tables.volumes.groups)),
            ("pins", words(&self.pins)),
            ("input_forces", words(&input_forces)),
            ("old_position", words(&self.old.position)),
            ("old_velocity", words(&self.old.velocity)),
            ("new_position", poison(4 * places)),
            ("new_velocity", poison(4 * places)),
            ("loads", words(&tables.loads.loads)),
            ("load", words(&self.force_fours())),
            ("force", poison(4 * places)),
            ("element_forces", poison(4 * tables.elements.forces())),
            ("volume_sums", poison(4 * VOLUME_PARTS * tables.volumes.groups.len())),
        ]);
        arrays.extend(of_elements);
        arrays
    }

    /// Constants that kernels are made with.
    pub fn overrides(&self) -> [(&'static str, f64); 3] {
        let has_layers = u32::from(self.tables.self_collision.has_layers);
        let differ = self.cpu.assembly().lists_differ() as u32;
        [
            ("KINDS", self.tables.springs.kinds as f64),
            (LISTS_DIFFER, differ.into()),
            (HAS_LAYERS, has_layers.into()),
        ]
    }

    /// Records of colliders in each sub-step, and how many ranges of places have a list.
    fn all_met(&self) -> Vec<(Vec<Collider>, u32)> {
        let places = 0..self.tables.len();
        let met = |substep: &plan::Substep<f32>| self.meshes.0.records(substep.met_colliders(), &places);
        self.substeps.iter().map(met).collect()
    }

    fn colliders(&self) -> Vec<Collider> {
        self.all_met().into_iter().flat_map(|(all, _)| all).collect()
    }

    /// Where corners of colliders go in each sub-step.
    fn corners(&self) -> Vec<CornersMoved> {
        self.substeps.iter().map(|substep| self.tables.surfaces.corners_moved(substep)).collect()
    }

    fn motions(&self) -> Vec<Motion> {
        let of =
            |substep: &plan::Substep<f32>| substep.motions().iter().map(Motion::from).collect::<Vec<_>>();
        self.substeps.iter().flat_map(of).collect()
    }

    fn goals(&self) -> Vec<f32> {
        let both = |substep: &plan::Substep<f32>| [substep.goals(), substep.closing()].concat();
        self.substeps.iter().flat_map(both).collect()
    }

    fn scales(&self) -> Vec<f32> {
        self.substeps.iter().flat_map(|substep| substep.scales().to_vec()).collect()
    }

    /// The records of all sub-steps, each with its own place in the arrays.
    pub fn records(&self) -> Vec<Substep> {
        let world = &self.cpu.assembly().world;
        let sum = |count: &dyn Fn(&plan::Substep<f32>) -> usize, index: usize| -> u32 {
            self.substeps[..index].iter().map(count).sum::<usize>() as u32
        };
        let (corners, met) = (self.corners(), self.all_met());
        let record = |(index, substep): (usize, &plan::Substep<f32>)| Substep {
            gravity: world.gravity.map(|c| c as f32),
            h: substep.h,
            wind: world.wind_force.map(|c| c as f32),
            drag: world.drag as f32,
            first_collider: met[..index].iter().map(|(all, _)| all.len() as u32).sum(),
            colliders: substep.colliders().len() as u32,
            first_motion: sum(&|s| s.motions().len(), index),
            first_scale: sum(&|s| s.scales().len(), index),
            frame_fraction: substep.frame_fraction.0,
            frame_rate: substep.frame_fraction.1,
            input_forces: self.input.forces.len() as u32,
            pins: self.pins.len() as u32,
            solving: Solving::of(&self.cpu.assembly().solver).stepping(substep.h, substep.scheme()),
            left: (self.substeps.len() - index) as u32,
            first_goal: sum(&|s| s.goals().len() + s.closing().len(), index),
            max_separation: pair::max_separation(f64::from(substep.h)) as f32,
            own: 0,
            air: Air::of(substep.air()),
            first_corner: corners[..index].iter().map(|moved| moved.corners.len() as u32).sum(),
            corner_parts: corners[index].parts,
            longest_push: corners[index].longest_push,
            led_out: NONE,
            collider_ranges: met[index].1,
            longest_step: substep.longest,
            pins_may_lag: substep.pins_may_lag.into(),
            padding: 0,
        };
        self.substeps.iter().enumerate().map(record).collect()
    }
}

/// Distance from a surface within which other roundings turn the normal by too much [m].
const NEAR: f32 = 0.05;

fn among_meshes(mut scene: Scene) -> Scene {
    let slips =
        [("ball", 0, 0.91), ("ball", 1, 0.11), ("sheet", 2, 0.0), ("blob", 1, 0.17), ("cape", 3, 0.81)];
    let solids = scene.colliders.len();
    for (body, mesh, value) in slips {
        scene = scene.friction_between(body, format!("collider{}", solids + mesh), value);
    }
    scene.colliders.extend(parity_scene::colliders());
    scene
}

fn four_of_input(&(node, force): &(u32, [f64; 3])) -> Four {
    let [x, y, z] = force.map(|c| c as f32);
    [x, y, z, f32::from_bits(node)]
}

/// Near the start, with springs stretched by little and by much, and triangles folded over.
fn old_state(chance: &mut Chance, tables: &Tables, cpu: &CpuBackend<f32>, exact: bool) -> State {
    let mut state = State::default();
    for (place, (&[x, y, z, inverse_mass], &[.., mass])) in
        tables.position.iter().zip(&tables.velocity).enumerate()
    {
        let noise = chance.three([0.003, 0.03, 0.2][place % 3]);
        state.position.push([x + noise[0], y + noise[1], z + noise[2], inverse_mass]);
        let [u, v, w] = chance.three(2.7);
        // A node that has touched before.
        let mass = if place % 5 == 0 { -mass } else { mass };
        state.velocity.push([u, v, w, mass]);
    }
    let first = |body: usize| cpu.assembly().bodies[body].first;
    let mut put = |place: usize, x: [f32; 3]| state.position[place][..3].copy_from_slice(&x);
    let (node, axis) = ON_THE_AXIS;
    put(first(4) + node, axis);
    if exact {
        let short = |length: f32| [0.3 * length, -0.7 * length, 0.4 * length];
        // Springs of no length, of one whose square is no number, of about that which is divided by, and above.
        for (i, length) in [1e-30, 1e-20, 1.1e-15, 1.3e-15, 1e-13, 1e-9].into_iter().enumerate() {
            put(first(0) + 80 + 3 * i, short(length));
            put(first(0) + 81 + 3 * i, [0.0; 3]);
            put(first(6) + 4 + 3 * i, short(length));
            put(first(6) + 5 + 3 * i, [0.0; 3]);
        }
    }
    squash(&mut state, tables, exact);
    state
}

/// Some hinges with a sliver, a triangle without area, an edge without length.
fn squash(state: &mut State, tables: &Tables, exact: bool) {
    let at = |state: &State, node: u32| -> [f32; 3] {
        let [x, y, z, _] = state.position[node as usize];
        [x, y, z]
    };
    let shares: [[f32; 3]; 5] =
        [[0.49, 0.48, 0.03], [0.3, 0.69, 0.01], [0.499, 0.5, 0.001], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let used = if exact { &shares[..] } else { &shares[..2] };
    let hinges = tables.elements.of(hinge::NAME).into_iter().flat_map(KindTables::elements);
    for (share, (corners, _)) in used.iter().cycle().zip(hinges.step_by(97)) {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        let [p, q, r] = [a, b, c].map(|node| at(state, node));
        let mixed: [f32; 3] = std::array::from_fn(|i| share[0] * p[i] + share[1] * q[i] + share[2] * r[i]);
        state.position[c as usize][..3].copy_from_slice(&mixed);
    }
}

/// Around the colliders, and here and there on them.
fn new_state(
    chance: &mut Chance,
    tables: &Tables,
    cpu: &CpuBackend<f32>,
    exact: bool,
) -> (State, Range<usize>) {
    let mut state = State::default();
    for (place, (&[.., inverse_mass], &[.., mass])) in
        tables.position.iter().zip(&tables.velocity).enumerate()
    {
        // Many are where two balls overlap.
        let x = if place % 3 == 0 { add(middle(!exact), chance.three(0.25)) } else { chance.three(0.9) };
        let ([x, y, z], [u, v, w]) = (x, chance.three(3.1));
        state.position.push([x, y, z, inverse_mass]);
        state.velocity.push([u, v, w, mass]);
    }
    let mut place = cpu.assembly().bodies[3].first;
    let mut put = |x: [f32; 3], v: [f32; 3]| {
        state.position[place][..3].copy_from_slice(&x);
        state.velocity[place][..3].copy_from_slice(&v);
        place += 1;
    };
    put(CENTER, [0.3, -0.2, 0.7]);
    put([5.0, CEILING + 0.25, 7.0], [0.3, 0.2, 0.7]);
    // Far from all but the floor and the wall that faces it: on it, a hair above and below; slipping as fast as
    // friction can stop, a hair faster and slower; leaving, and neither coming nor leaving.
    let heights = [FLOOR, FLOOR.next_up(), FLOOR.next_down(), FLOOR - 0.0625, FLOOR + 0.0625];
    // Impulse (1 + 1/4) · 2 = 5/2, of which friction can take half.
    let slips = [1.25_f32, 1.25_f32.next_up(), 1.25_f32.next_down(), 3.0, 0.5];
    let (heights, slips) = if exact { (&heights[..], &slips[..]) } else { (&heights[3..], &slips[3..]) };
    for &height in heights {
        put([5.0, height, 7.0], [0.4, -0.9, 0.2]);
    }
    for speed in [-2.0, 0.0, 0.5] {
        for &slip in slips {
            put([5.0, FLOOR - 0.03125, 7.0], [slip, speed, 0.0]);
        }
    }
    let first = cpu.assembly().bodies[3].first;
    let awkward = first..place;
    (state, awkward)
}

/// Nodes moved and pushed by the program; some are pushed twice.
fn input(chance: &mut Chance) -> FrameInput {
    let mut three = |size: f32| chance.three(size).map(f64::from);
    FrameInput {
        moves: [5_u32, 6, 36].map(|node| (node, three(0.6), three(0.8))).to_vec(),
        forces: [0_u32, 1, 7, 7, 500, 701, 1000, 1001, 1001, 1400].map(|node| (node, three(0.03))).to_vec(),
    }
}

/// The scene's moving pins, then those that the program moves.
fn pins(tables: &Tables, input: &FrameInput) -> Vec<Pin> {
    let moved = |&(node, from, to): &(u32, [f64; 3], [f64; 3])| Pin {
        start: from.map(|c| c as f32),
        node,
        goal: to.map(|c| c as f32),
        track: MOVED_BY_USER,
    };
    tables.pins.iter().copied().chain(input.moves.iter().map(moved)).collect()
}
